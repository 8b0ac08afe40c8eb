//! Provenance of results: source revision, toolchain, machine and time.

use std::collections::BTreeMap;
use std::process::Command;

use serde::{Deserialize, Serialize};

/// Name of the stage in which recordings are simulated.
pub const SIMULATIONS: &str = "simulations";

/// Origin of a set of results.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// Git revision of the source tree; `unknown` outside one.
    pub commit: String,
    /// Whether tracked files outside `results` differed from that revision.
    pub dirty: bool,
    /// Version of the program.
    pub version: String,
    /// Compiler.
    pub toolchain: String,
    /// Processor.
    pub cpu: String,
    /// Threads used.
    pub threads: usize,
    /// Wall-clock seconds of each stage; a stage that found its results in the cache is short.
    pub seconds: BTreeMap<String, f64>,
    /// Seconds that the simulation of each recording took when it was simulated.
    #[serde(default)]
    pub simulation_seconds: BTreeMap<String, f64>,
    /// Greatest resident memory of the process, MiB; 0 where the system does not report it.
    #[serde(default)]
    pub peak_memory_mib: f64,
}

impl Provenance {
    /// This program, on this machine, now.
    pub fn here() -> Self {
        Self {
            commit: output("git", &["rev-parse", "--short=12", "HEAD"])
                .unwrap_or_else(|| "unknown".into()),
            dirty: output(
                "git",
                &["status", "--porcelain", "-uno", "--", ".", ":!results"],
            )
            .is_some_and(|text| !text.is_empty()),
            version: env!("CARGO_PKG_VERSION").to_string(),
            toolchain: output("rustc", &["--version"]).unwrap_or_else(|| "unknown".into()),
            cpu: cpu(),
            threads: rayon::current_num_threads(),
            seconds: BTreeMap::new(),
            simulation_seconds: BTreeMap::new(),
            peak_memory_mib: peak_memory_mib(),
        }
    }
}

/// Output of a program, trimmed; `None` when it fails or does not exist.
fn output(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_string())
}

/// Name of the processor.
fn cpu() -> String {
    let named = std::fs::read_to_string("/proc/cpuinfo")
        .ok()
        .and_then(|text| {
            let line = text.lines().find(|line| line.starts_with("model name"))?;
            Some(line.split_once(':')?.1.trim().to_string())
        });
    named
        .or_else(|| output("sysctl", &["-n", "machdep.cpu.brand_string"]))
        .unwrap_or_else(|| std::env::consts::ARCH.to_string())
}

/// Greatest resident memory of this process so far, MiB; 0 where the system does not report it.
pub fn peak_memory_mib() -> f64 {
    std::fs::read_to_string("/proc/self/status")
        .ok()
        .and_then(|text| {
            let line = text
                .lines()
                .find(|line| line.starts_with("VmHWM:"))?
                .to_string();
            line.split_whitespace().nth(1)?.parse::<f64>().ok()
        })
        .map_or(0.0, |kib| (kib / 1024.0).round())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn provenance_names_machine_and_program() {
        let here = Provenance::here();
        assert!(!here.cpu.is_empty() && !here.version.is_empty() && here.threads > 0);
    }
}
