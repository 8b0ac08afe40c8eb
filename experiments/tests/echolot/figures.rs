//! Figures are drawn from data files alone.

use std::path::Path;

use experiments::data::atomic;
use experiments::data::table::Table;
use experiments::figures::{Drawn, draw_all, draw_bench, draw_bound};

fn table(path: &Path, text: &str) {
    atomic::write(path, text.as_bytes()).unwrap();
    Table::read(path).unwrap();
}

/// Writes the least data that every figure needs.
fn write_data(data: &Path) {
    let layout = r#"{"name": "room", "size_m": [2.0, 2.0], "layer_m": 0.1,
        "walls": [{"points_m": [[0.5, 0.5], [1.5, 0.5], [1.5, 1.5]], "thickness_m": 0.02}]}"#;
    atomic::write(&data.join("layout.json"), layout.as_bytes()).unwrap();
    table(
        &data.join("drive.csv"),
        "path,t_s,x_m,y_m,heading_rad,v_mps,omega_radps,v_odometry_mps,omega_odometry_radps\n\
         mapping,0,1,1,0,0.3,0,0.3,0.01\nmapping,1,1.2,1,0,0.3,0,0.3,0.01\n\
         localization,0,1,1,0,0.3,0,0.3,0.01\nlocalization,1,1,1.2,0,0.3,0.1,0.3,0.11\n",
    );
    let image = ndarray::Array2::from_shape_fn((12, 10), |(row, column)| (row * column) as f32);
    ndarray_npy::write_npy(data.join("map.npy"), &image).unwrap();
    atomic::write(
        &data.join("map.json"),
        br#"{"origin_m": [0.0, 0.0], "cell_m": 0.2}"#,
    )
    .unwrap();
    ndarray_npy::write_npy(data.join("reflections.npy"), &image).unwrap();
    atomic::write(
        &data.join("reflections.json"),
        br#"{"t_s": [0.2, 1.2], "range_m": [0.0, 10.0]}"#,
    )
    .unwrap();
    table(
        &data.join("rays.csv"),
        "t_s,round_trip_m,kind\n0.5,2.0,single\n0.5,3.0,corner\n0.5,4.0,double\n",
    );
    table(
        &data.join("drift_paths.csv"),
        "method,trial,t_s,x_m,y_m,heading_rad,error_m\ndoppler,0,0.3,1,1,0,0.01\ndoppler,0,0.4,1,1.1,0,0.02\n\
         toa-only,0,0.3,1,1,0,0.02\ntoa-only,0,0.4,1,1.1,0,0.03\nodometry,0,0.3,1,1,0,0.2\n\
         odometry,0,0.4,1,1.2,0,0.3\n",
    );
    table(
        &data.join("window_size.csv"),
        "half_width_m,trial,mae_m\n1,0,0.2\n1,1,0.1\n4,0,0.04\n4,1,0.05\n",
    );
    table(
        &data.join("snr.csv"),
        "snr_db,trial,mae_m\n-15,0,0.2\n5,0,0.04\n",
    );
    table(
        &data.join("periods.csv"),
        "m,trial,mae_m\n1,0,0.3\n6,0,0.04\n",
    );
    table(
        &data.join("periods_paths.csv"),
        "m,t_s,x_m,y_m\n1,0.1,1,1\n1,0.2,1,1.1\n6,0.1,1,1\n6,0.2,1.1,1\n",
    );
    table(
        &data.join("step_time.csv"),
        "stage,half_width_m,time_ms\ndoppler_bank,,7.5\ndoppler_bank,,8\nfilter,1,0.5\nfilter,4,2.5\n",
    );
    table(
        &data.join("multipath_room.csv"),
        "x_m,y_m,ceiling_m\n0,0,2.5\n4,0,2.5\n4,3,2.5\n0,3,2.5\n",
    );
    table(
        &data.join("multipath_drive.csv"),
        "t_s,x_m,y_m\n0,1,1\n1,2,1\n",
    );
    table(
        &data.join("multipath_gates.csv"),
        "method,gate_m,trial,mae_m\nspatial,0.2,0,0.02\nspatial,0.3,0,0.03\n",
    );
    for name in ["multipath.csv", "multipath_scene.csv"] {
        table(
            &data.join(name),
            "method,trial,t_s,x_m,y_m,error_m\nspatial,0,0.1,1,1,0.01\nspatial,0,0.2,1,1.1,0.02\n\
             planar,0,0.1,1,1,0.01\ndoppler,0,0.1,1,1,0.01\n",
        );
    }
    table(
        &data.join("angular_resolution.csv"),
        "m,cos_theta,level\n1,-1,0.2\n1,0.5,1\n1,1,0.7\n6,-1,0.1\n6,0.5,1\n6,1,0.1\n",
    );
    table(
        &data.join("angular_resolution_widths.csv"),
        "m,half_power_width,theory\n1,0.5,0.49\n6,0.08,0.082\n",
    );
    for name in ["dual_circle.csv", "dual_circle_published.csv"] {
        table(
            &data.join(name),
            "method,trial,point,x_true_m,y_true_m,x_m,y_m\ndual-circle,0,1,1,1,1.02,0.99\n",
        );
    }
}

#[test]
fn every_figure_is_drawn_and_the_same_each_time() {
    let folder = tempfile::tempdir().unwrap();
    write_data(&folder.path().join("data"));
    write_data(&folder.path().join("site/data"));
    let pictures = |drawn: Vec<Drawn>| -> Vec<Vec<u8>> {
        drawn
            .into_iter()
            .map(|drawn| match drawn {
                Drawn::Picture(path) => std::fs::read(path).unwrap(),
                Drawn::Missing { figure, file } => panic!("{figure}: {}", file.display()),
            })
            .collect()
    };
    let first = pictures(draw_all(folder.path()).unwrap());
    assert_eq!(first.len(), 14 + 7);
    assert_eq!(first, pictures(draw_all(folder.path()).unwrap()));
}

#[test]
fn the_roofline_is_drawn_from_the_rows_of_the_benchmark() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(draw_bench(folder.path()).unwrap(), None);
    let row = |engine: &str, side: usize, threads: usize, speed: f64| {
        serde_json::json!({"engine": engine, "scheme": "slf", "nx": side, "ny": side, "threads": threads,
            "gcells_per_s": speed, "flops_per_cell": 7.0, "bytes_per_cell": 12.0})
    };
    let peak = |threads: usize| {
        serde_json::json!({"threads": threads, "fma_gflops": 100.0 * threads as f64,
            "l1_load_gbps": 200.0 * threads as f64, "memory_gbps": 30.0})
    };
    let data = serde_json::json!({"peaks": [peak(1), peak(2)], "rows": [
        row("reference", 256, 1, 1.0), row("fast", 256, 1, 5.0), row("fast", 1000, 2, 15.0)]});
    std::fs::write(folder.path().join("bench.json"), data.to_string()).unwrap();
    let draw = || std::fs::read(draw_bench(folder.path()).unwrap().unwrap()).unwrap();
    assert_eq!(draw(), draw());
    std::fs::write(folder.path().join("bench.json"), "{\"rows\": []}").unwrap();
    let error = format!("{:#}", draw_bench(folder.path()).unwrap_err());
    assert!(
        error.contains("bench.json") && error.contains("peaks"),
        "{error}"
    );
}

#[test]
fn the_bound_is_drawn_from_the_rows_of_the_example() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(draw_bound(folder.path()).unwrap(), None);
    let rows = "snr_db,periods,found,range_m,range_bound_m,cosine,cosine_bound\n\
        -20,1,0.95,1.3e-3,1.2e-3,4.4e-2,4.8e-2\n0,1,1,1.3e-4,1.2e-4,6e-3,4.8e-3\n-20,6,1,5.9e-4,4.8e-4,1.3e-2,3.3e-3\n";
    table(&folder.path().join("data/landmark_bound.csv"), rows);
    let draw = || std::fs::read(draw_bound(folder.path()).unwrap().unwrap()).unwrap();
    assert_eq!(draw(), draw());
    table(
        &folder.path().join("data/landmark_bound.csv"),
        "snr_db,periods\n-20,1\n",
    );
    let error = format!("{:#}", draw_bound(folder.path()).unwrap_err());
    assert!(error.contains("landmark_bound.csv"), "{error}");
}

#[test]
fn a_figure_without_data_is_left_out_and_damaged_data_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("data");
    write_data(&data);
    std::fs::remove_file(data.join("snr.csv")).unwrap();
    let drawn = draw_all(folder.path()).unwrap();
    let missing = drawn
        .iter()
        .filter(|drawn| matches!(drawn, Drawn::Missing { .. }))
        .count();
    assert_eq!(missing, 1);
    std::fs::write(
        data.join("window_size.csv"),
        "half_width_m,trial,mae_m\n1,0,wide\n",
    )
    .unwrap();
    let error = format!("{:#}", draw_all(folder.path()).unwrap_err());
    assert!(
        error.contains("window_size.csv") && error.contains("wide"),
        "{error}"
    );
}
