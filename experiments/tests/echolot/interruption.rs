//! Interrupted commands: their checkpoints, and resuming by the same command.

use crate::room::{echolot, scene_file};

#[cfg(unix)]
#[test]
fn an_interrupted_simulation_goes_on_to_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    scene_file(at);
    let simulate = |output: &str, more: &[&str]| {
        let fixed = ["simulate", "room.json", "--path", "short", "-o", output];
        echolot(at, &[&fixed[..], more].concat())
    };
    assert!(simulate("whole", &["--threads", "1"]).status.success());
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_echolot"))
        .current_dir(at)
        .args(["simulate", "room.json", "--path", "short", "-o", "parts"])
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    // It prints its plan and starts a moment later. A signal that comes earlier or later makes the test weaker, not
    // wrong.
    let mut stderr = std::io::BufReader::new(child.stderr.take().unwrap());
    std::io::BufRead::read_line(&mut stderr, &mut String::new()).unwrap();
    std::thread::sleep(std::time::Duration::from_millis(150));
    let killed = std::process::Command::new("kill")
        .arg(child.id().to_string())
        .status();
    let code = child.wait().unwrap().code();
    if killed.is_ok_and(|status| status.success()) && code != Some(0) {
        assert_eq!(code, Some(130));
        assert!(at.join("parts.checkpoint").exists() && !at.join("parts").exists());
    }
    assert!(simulate("parts", &["--resume"]).status.success());
    assert!(!at.join("parts.checkpoint").exists());
    for file in ["signal.wav", "odometry.csv", "truth.tum"] {
        let bytes = |run: &str| std::fs::read(at.join(run).join(file)).unwrap();
        assert_eq!(bytes("whole"), bytes("parts"), "{file}");
    }
}

#[cfg(unix)]
#[test]
fn an_interrupted_validation_ends_at_once_and_keeps_the_laws_that_were_measured() {
    let folder = tempfile::tempdir().unwrap();
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_echolot"))
        .current_dir(folder.path())
        .arg("validate")
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let files = |of: &std::path::Path| -> Vec<std::path::PathBuf> {
        let entries = std::fs::read_dir(of).into_iter().flatten();
        entries.map(|entry| entry.unwrap().path()).collect()
    };
    let cache = folder.path().join("results/cache/validation");
    let kept = || -> Vec<std::path::PathBuf> {
        let whole = |file: &std::path::PathBuf| {
            let name = file.file_name().unwrap().to_string_lossy();
            name.ends_with(".json") && !name.starts_with('.')
        };
        files(&cache).into_iter().filter(whole).collect()
    };
    while kept().is_empty() {
        assert!(child.try_wait().unwrap().is_none(), "ended by itself");
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    let pid = child.id().to_string();
    assert!(
        (std::process::Command::new("kill").arg(pid).status())
            .unwrap()
            .success()
    );
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("error: interrupted"), "{said}");
    assert!(!folder.path().join("results/validation").exists());
    for file in kept() {
        let measured: serde_json::Value =
            serde_json::from_slice(&std::fs::read(&file).unwrap()).unwrap();
        assert!(
            !measured["value"]["measurements"]
                .as_array()
                .unwrap()
                .is_empty(),
            "{file:?}"
        );
    }
}
