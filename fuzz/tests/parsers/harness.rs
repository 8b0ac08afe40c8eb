//! What every target shares: seeds, the limits of one input, and the list of what was tried.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use bolero::check;
use fuzz::{Plan, mutated};

/// Longest time for one input.
const LONGEST: Duration = Duration::from_secs(1);
/// Memory that one input may take, bytes.
const MOST_BYTES: u64 = 1 << 30;

/// Processor time of this thread: others may keep the machine busy.
#[cfg(unix)]
fn processor_time() -> Duration {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Duration::new(now.tv_sec as u64, now.tv_nsec as u32)
}

#[cfg(not(unix))]
fn processor_time() -> Duration {
    static START: std::sync::LazyLock<std::time::Instant> =
        std::sync::LazyLock::new(std::time::Instant::now);
    START.elapsed()
}

/// The seeds of a target: the files of its folder in `corpus`.
pub(crate) fn corpus(name: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("corpus")
        .join(name);
    let mut files: Vec<PathBuf> = std::fs::read_dir(&folder)
        .unwrap_or_else(|error| panic!("{}: {error}", folder.display()))
        .map(|entry| entry.unwrap().path())
        .collect();
    files.sort();
    assert!(!files.is_empty(), "{name} has no corpus");
    files
        .iter()
        .map(|file| std::fs::read(file).unwrap())
        .collect()
}

/// Limits the address space to what is taken now and the memory of one input. An allocation beyond it ends the test.
#[cfg(target_os = "linux")]
fn limit_memory() {
    use rustix::process::{Resource, Rlimit, setrlimit};
    let pages = std::fs::read_to_string("/proc/self/statm").unwrap();
    let pages: u64 = pages.split(' ').next().unwrap().parse().unwrap();
    // Other targets run beside this one, and their threads have stacks.
    let taken = pages * 4096 + (1 << 29);
    let limit = Some(taken + MOST_BYTES);
    setrlimit(
        Resource::As,
        Rlimit {
            current: limit,
            maximum: limit,
        },
    )
    .ok();
}

#[cfg(not(target_os = "linux"))]
fn limit_memory() {
    let _ = MOST_BYTES;
}

/// Runs a parser on the seeds and on mutations of them.
pub(crate) fn fuzz(
    name: &str,
    seeds: Vec<Vec<u8>>,
    parse: impl Fn(&[u8]) + std::panic::RefUnwindSafe,
) {
    static LIMIT: std::sync::Once = std::sync::Once::new();
    LIMIT.call_once(limit_memory);
    for seed in &seeds {
        parse(seed);
    }
    let (inputs, longest_us) = (AtomicU64::new(0), AtomicU64::new(0));
    let one = |plan: &Plan| {
        let bytes = mutated(&seeds, plan);
        let started = processor_time();
        parse(&bytes);
        let taken = processor_time().saturating_sub(started);
        assert!(
            taken < LONGEST,
            "{name}: {taken:?} for {}",
            String::from_utf8_lossy(&bytes)
        );
        inputs.fetch_add(1, Ordering::Relaxed);
        longest_us.fetch_max(taken.as_micros() as u64, Ordering::Relaxed);
    };
    let target = check!().with_type::<Plan>().with_max_len(512);
    if std::env::var_os("BOLERO_RANDOM_ITERATIONS").is_some() {
        let hours = Duration::from_secs(24 * 3600);
        target.with_test_time(hours).for_each(one);
    } else {
        let target = target.with_iterations(usize::MAX);
        target.with_test_time(Duration::from_secs(2)).for_each(one);
    }
    let (inputs, longest_us) = (inputs.into_inner(), longest_us.into_inner());
    println!(
        "{name}: {inputs} inputs, the longest {:.1} ms",
        longest_us as f64 * 1e-3
    );
    note(name, inputs, longest_us);
}

/// Adds a line to the list of what was tried, where one is kept: see `echolot robustness`.
fn note(name: &str, inputs: u64, longest_us: u64) {
    let Some(list) = std::env::var_os("ECHOLOT_TRIED") else {
        return;
    };
    let line = serde_json::json!({
        "kind": "mutated files",
        "what": name,
        "count": inputs,
        "result": format!("no panic; the longest took {:.1} ms", longest_us as f64 * 1e-3),
    });
    let mut file = std::fs::OpenOptions::new()
        .append(true)
        .create(true)
        .open(list)
        .unwrap();
    std::io::Write::write_all(&mut file, format!("{line}\n").as_bytes()).unwrap();
}

/// Runs a parser of text; what is no text is for the reader of files to refuse.
pub(crate) fn fuzz_text(name: &str, parse: impl Fn(&str) + std::panic::RefUnwindSafe) {
    fuzz(name, corpus(name), |bytes| {
        parse(&String::from_utf8_lossy(bytes))
    });
}

/// An error is one line, and not a page of the file.
pub(crate) fn line<T, E: std::fmt::Display>(result: Result<T, E>) -> Option<T> {
    result
        .map_err(|error| {
            let text = format!("{error:#}");
            assert!(!text.contains('\n') && text.len() < 2000, "{text}");
        })
        .ok()
}
