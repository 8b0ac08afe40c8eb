#![allow(missing_docs)]
use fdtd::scheme::Scheme;
use fdtd::validation::tilted_impedance::*;
use fdtd::walls::WallModel;
fn main() {
    let quick = std::env::args().count() > 1;
    for s in Scheme::ALL {
        if s == Scheme::Slf {
            continue;
        }
        for tilt in [0.0, 3.0, 10.0, 20.0, 30.0, 45.0] {
            for tan in [0.0, 1.0] {
                let mut w = [0.0f64; 3];
                for shift in if quick {
                    vec![0.37]
                } else {
                    vec![0.0, 0.37, 0.71]
                } {
                    let e = errors(s, WallModel::CutCells, tilt, tan, shift).unwrap();
                    for i in 0..3 {
                        w[i] = w[i].max(e[i]);
                    }
                }
                println!("{s} {tilt} tan {tan}: {:.4} {:.4} {:.4}", w[0], w[1], w[2]);
            }
        }
    }
}
