//! A study on a cluster that Slurm manages: an array of workers on one cache, and a job that gathers what they did.
//!
//! Workers are `echolot task` without keys: each does tasks until none is left. Before its time runs out Slurm sends
//! SIGTERM; a simulation then leaves its checkpoint, and the job asks to be queued again.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use anyhow::{Context, Result, bail};
use serde::{Deserialize, Serialize};

use super::{Plan, Study, StudySummary};
use crate::data::{atomic, json};
use crate::run::interrupt;
use crate::session::Workspace;

/// Pause between two looks at the cache and the queue.
const LOOK_AGAIN: Duration = Duration::from_secs(1);

/// What is asked of Slurm.
#[derive(Debug, Clone)]
pub struct Request {
    /// The study file.
    pub study: PathBuf,
    /// Folder of the results.
    pub results: PathBuf,
    /// Folder of the cache, which all nodes see.
    pub cache: PathBuf,
    /// Number of workers.
    pub array_size: usize,
    /// Threads of each.
    pub threads: usize,
    /// Partition, if not the default.
    pub partition: Option<String>,
    /// Limit of time of a worker, as `sbatch --time` takes it.
    pub time: Option<String>,
    /// More arguments of `sbatch`.
    pub sbatch: Vec<String>,
}

/// Numbers of the jobs of a study.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Jobs {
    workers: String,
    gather: String,
}

/// Submits the workers of a study and the job that gathers, unless they are queued already, and shows progress until
/// the results are there. Interrupted, the jobs go on, and the same call takes them up again.
///
/// # Errors
/// When Slurm refuses, a job fails, or the user interrupts.
pub fn run(
    study: &Study,
    plan: &Plan,
    workspace: &Workspace,
    request: &Request,
) -> Result<StudySummary> {
    let folder = request.results.join(&study.file.name);
    let file = folder.join("slurm/jobs.json");
    let known: Option<Jobs> = file.exists().then(|| json::read(&file)).transpose()?;
    let jobs = match known {
        Some(jobs) if is_queued(&jobs.gather)? => {
            workspace.board.say(format!(
                "jobs {} and {} are queued already",
                jobs.workers, jobs.gather
            ));
            jobs
        }
        _ => {
            let jobs = submit(study, request, &folder)?;
            atomic::write(&file, serde_json::to_string(&jobs)?.as_bytes())?;
            workspace.board.say(format!(
                "submitted {} worker(s) as job {} and the gathering as job {}; interrupt at any time, they go on",
                request.array_size, jobs.workers, jobs.gather
            ));
            jobs
        }
    };
    let tasks = plan.tasks(study, workspace).len() as u64;
    let task = workspace
        .board
        .task(format!("tasks of {}", study.file.name), tasks);
    loop {
        interrupt::check()?;
        let queued = is_queued(&jobs.gather)?;
        task.set(plan.done(workspace));
        if !queued {
            break;
        }
        std::thread::sleep(LOOK_AGAIN);
    }
    task.finish();
    let summary = folder.join("summary.json");
    if !summary.exists() || plan.done(workspace) < tasks {
        bail!(
            "job {}: ended without results; {} says why",
            jobs.gather,
            folder.join("slurm").display()
        );
    }
    StudySummary::read(&summary)
}

/// Whether a job is queued or runs.
fn is_queued(job: &str) -> Result<bool> {
    let output = Command::new("squeue")
        .args(["--noheader", "--jobs", job])
        .output()
        .context("squeue: cannot be run; is this a machine of the cluster?")?;
    // Slurm forgets jobs that ended a while ago and calls their numbers invalid.
    Ok(output.status.success() && !output.stdout.trim_ascii().is_empty())
}

/// A word for a shell, whatever is in it.
fn quoted(word: &str) -> String {
    format!("'{}'", word.replace('\'', "'\\''"))
}

/// The absolute path of a file or folder that may not be there yet.
fn absolute(path: &Path) -> Result<String> {
    let path = std::path::absolute(path)?;
    path.to_str()
        .map(str::to_string)
        .with_context(|| format!("{}: is no UTF-8; rename it", path.display()))
}

/// The scripts of worker and gathering.
fn scripts(request: &Request) -> Result<[String; 2]> {
    let program = quoted(&absolute(&std::env::current_exe()?)?);
    let study = quoted(&absolute(&request.study)?);
    let places = format!(
        "--results {} --cache {}",
        quoted(&absolute(&request.results)?),
        quoted(&absolute(&request.cache)?)
    );
    let worker = format!(
        "#!/bin/sh\n\
        # A worker: tasks until none is left. Told to stop before the limit of time, it asks to be queued again and\n\
        # goes on from its checkpoint.\n\
        {program} task {study} {places} --threads {} &\n\
        child=$!\n\
        trap 'kill -TERM $child' TERM\n\
        wait $child\n\
        code=$?\n\
        while kill -0 $child 2>/dev/null; do wait $child; code=$?; done\n\
        if [ $code -eq {} ]; then scontrol requeue $SLURM_JOB_ID; fi\n\
        exit $code\n",
        request.threads,
        interrupt::EXIT_CODE,
    );
    let gather = format!("#!/bin/sh\nexec {program} gather {study} {places}\n");
    Ok([worker, gather])
}

/// Submits both jobs.
fn submit(study: &Study, request: &Request, folder: &Path) -> Result<Jobs> {
    let place = folder.join("slurm");
    std::fs::create_dir_all(&place).with_context(|| place.display().to_string())?;
    let output = |name: &str| format!("--output={}", place.join(name).display());
    let [worker, gather] = scripts(request)?;
    atomic::write(&place.join("worker.sh"), worker.as_bytes())?;
    atomic::write(&place.join("gather.sh"), gather.as_bytes())?;
    let name = format!("--job-name={}", study.file.name);
    let mut shared = vec![name];
    shared.extend(
        request
            .partition
            .iter()
            .map(|name| format!("--partition={name}")),
    );
    shared.extend(request.time.iter().map(|time| format!("--time={time}")));
    shared.extend(request.sbatch.iter().cloned());
    let last = request.array_size.max(1) - 1;
    let mut arguments = shared.clone();
    arguments.extend([
        format!("--array=0-{last}"),
        format!("--cpus-per-task={}", request.threads.max(1)),
        "--requeue".to_string(),
        "--signal=B:TERM@120".to_string(),
        output("worker-%A-%a.out"),
    ]);
    let workers = sbatch(&arguments, &place.join("worker.sh"))?;
    let mut arguments = shared;
    arguments.extend([
        format!("--dependency=afterok:{workers}"),
        "--kill-on-invalid-dep=yes".to_string(),
        output("gather-%j.out"),
    ]);
    let gather = sbatch(&arguments, &place.join("gather.sh"))?;
    Ok(Jobs { workers, gather })
}

/// Submits a script; the number of the job.
fn sbatch(arguments: &[String], script: &Path) -> Result<String> {
    let output = Command::new("sbatch")
        .arg("--parsable")
        .args(arguments)
        .arg(script)
        .output()
        .context("sbatch: cannot be run; is this a machine of the cluster?")?;
    let said = String::from_utf8_lossy(&output.stdout);
    if !output.status.success() {
        let complaint = String::from_utf8_lossy(&output.stderr);
        bail!(
            "sbatch: {}; correct the arguments",
            complaint.trim().replace('\n', "; ")
        );
    }
    // Behind a semicolon stands the name of the cluster.
    Ok(said
        .trim()
        .split(';')
        .next()
        .unwrap_or_default()
        .to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_quoted_for_the_shell() {
        for word in ["plain", "two words", "it's", "$HOME;`rm`", ""] {
            let script = format!("printf %s {}", quoted(word));
            let output = Command::new("sh").args(["-c", &script]).output().unwrap();
            assert_eq!(String::from_utf8(output.stdout).unwrap(), word);
        }
    }
}
