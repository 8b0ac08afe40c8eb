//! A study on a cluster: the real daemons on this machine, one node of which dies in the middle.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::json;

use crate::room::expect;
use crate::studies::study_file;

/// The cluster's script.
fn script() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cluster.sh")
}

/// Daemons in a folder; dropping ends them.
struct Cluster {
    folder: PathBuf,
    configuration: String,
}

impl Drop for Cluster {
    fn drop(&mut self) {
        let stop = Command::new("sh")
            .arg(script())
            .arg(&self.folder)
            .arg("stop")
            .status();
        assert!(stop.unwrap().success());
    }
}

/// A cluster, or the reason why there is none here.
fn start(folder: &Path) -> Result<Cluster, String> {
    for program in ["slurmctld", "slurmd", "munged", "sbatch"] {
        let found = std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default())
            .any(|folder| folder.join(program).exists());
        if !found && !Path::new("/usr/sbin").join(program).exists() {
            return Err(format!("{program} is not installed"));
        }
    }
    let output = Command::new("sh")
        .arg(script())
        .arg(folder)
        .output()
        .map_err(|e| e.to_string())?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).trim().to_string());
    }
    Ok(Cluster {
        folder: folder.to_path_buf(),
        configuration: String::from_utf8_lossy(&output.stdout).trim().to_string(),
    })
}

#[test]
fn a_cluster_of_which_a_node_dies_gives_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let cluster = match start(&at.join("cluster")) {
        Ok(cluster) => cluster,
        Err(reason) => {
            eprintln!("skipped: {reason}");
            return;
        }
    };
    study_file(
        at,
        &[
            ("vary", json!([{"localizer.periods": [2, 3, 4, 5, 6, 8]}])),
            ("seeds", json!({"filter": 2})),
            ("methods", json!(["doppler", "landmarks"])),
            ("claims", json!([])),
        ],
    );
    expect(
        at,
        &["run", "mine.json", "--results", "alone", "--no-figures"],
    );
    let mut run = Command::new(env!("CARGO_BIN_EXE_echolot"))
        .current_dir(at)
        .env("SLURM_CONF", &cluster.configuration)
        .args([
            "run",
            "mine.json",
            "--on",
            "slurm",
            "--array-size",
            "2",
            "--sbatch-arg",
            "--comment=test",
        ])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // In the middle: some trials are done, others are not.
    let trials = || std::fs::read_dir(at.join("results/cache/trials")).map_or(0, Iterator::count);
    let started = Instant::now();
    while trials() < 5 && started.elapsed() < Duration::from_secs(120) {
        assert!(
            run.try_wait().unwrap().is_none(),
            "it ended before a node could die"
        );
        std::thread::sleep(Duration::from_millis(20));
    }
    let node = std::fs::read_to_string(cluster.folder.join("slurmd-n1.pid")).unwrap();
    let killed = Command::new("kill")
        .args(["-9", node.trim()])
        .status()
        .unwrap();
    assert!(killed.success());
    let output = run.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    assert!(said.contains("submitted 2 worker(s)"), "{said}");
    let read = |results: &str| {
        std::fs::read_to_string(at.join(results).join("mine/data/trials.csv")).unwrap()
    };
    assert_eq!(read("results"), read("alone"));
}
