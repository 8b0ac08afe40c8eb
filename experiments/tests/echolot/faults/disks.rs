//! No room on the disk, or no right to write.

use std::path::PathBuf;
use std::process::Command;

use super::{Case, cases, contents, moments, spread, temporaries};
use crate::room::{expect, note};

/// Writes fail beyond a size of file, as on a full disk: first the probe, then one file after the other.
#[cfg(unix)]
#[test]
fn a_disk_without_room_loses_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for Case {
        name,
        command,
        files,
    } in cases(at)
    {
        expect(at, &command);
        let whole = contents(at, &files);
        let sizes: Vec<u64> = files
            .iter()
            .map(|file| std::fs::metadata(at.join(file)).unwrap().len())
            .collect();
        let largest = sizes.iter().copied().max().unwrap();
        if name == "run" {
            std::fs::remove_dir_all(at.join("cache")).unwrap();
        }
        let (count, mut refused) = (moments(3).min(20), 0);
        for index in 0..count {
            // In blocks of 512 bytes, from nothing to just below the largest file.
            let limit = (spread(index) * largest as f64 / 512.0) as u64;
            let limited = format!(
                "trap '' XFSZ; ulimit -f {limit}; exec {} {}",
                env!("CARGO_BIN_EXE_echolot"),
                command.join(" ")
            );
            let output = Command::new("sh")
                .current_dir(at)
                .args(["-c", &limited])
                .output()
                .unwrap();
            let said = String::from_utf8_lossy(&output.stderr);
            if !output.status.success() {
                refused += 1;
                assert_eq!(output.status.code(), Some(2), "{name}: {said}");
                assert!(said.contains("error: "), "{name}: {said}");
                assert_eq!(
                    contents(at, &files),
                    whole,
                    "{name}, {limit} blocks: {said}"
                );
            }
            assert_eq!(
                temporaries(at),
                Vec::<PathBuf>::new(),
                "{name}, {limit} blocks"
            );
        }
        expect(at, &command);
        assert_eq!(contents(at, &files), whole, "{name}");
        note(
            "no room for a file",
            name,
            refused,
            "a line, exit 2, files whole",
        );
    }
}

/// A command that runs another as a user who may write nothing of root's, or where that is not root's business already
/// nothing.
#[cfg(target_os = "linux")]
fn without_rights() -> Vec<&'static str> {
    let root = Command::new("id").arg("-u").output();
    match root.is_ok_and(|id| id.stdout == b"0\n") {
        true => vec![
            "setpriv",
            "--reuid=65534",
            "--regid=65534",
            "--clear-groups",
        ],
        false => vec!["env"],
    }
}

/// A folder in which nothing may be written, as a user who is not root.
#[cfg(target_os = "linux")]
#[test]
fn a_place_without_the_right_to_write_is_told() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let all = cases(at);
    let allow = |mode| {
        std::fs::set_permissions(at, std::fs::Permissions::from_mode(mode)).unwrap();
    };
    // The program where anybody may run it.
    let program = at.join("program");
    std::fs::copy(env!("CARGO_BIN_EXE_echolot"), &program).unwrap();
    let mut refused = 0;
    for Case {
        name,
        command,
        files,
    } in all
    {
        allow(0o555);
        let user = without_rights();
        let output = Command::new(user[0])
            .args(&user[1..])
            .arg(&program)
            .current_dir(at)
            .args(&command)
            .output()
            .unwrap();
        allow(0o755);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{name}: {said}");
        let last = said.lines().last().unwrap_or_default();
        assert!(
            last.starts_with("error: ") && last.contains("denied"),
            "{name}: {said}"
        );
        assert!(contents(at, &files).iter().all(Option::is_none), "{name}");
        refused += 1;
    }
    note(
        "no right to write",
        "simulate, map, localize, slam, run",
        refused,
        "a line, exit 2",
    );
}

/// A small disk of its own that fills up, or may only be read, where such a one may be mounted.
#[cfg(target_os = "linux")]
#[test]
fn a_small_disk_that_is_full_or_read_only_gets_whole_files_or_none() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let all = cases(at);
    let may = Command::new("unshare")
        .args(["-m", "mount", "-t", "tmpfs", "none", "/mnt"])
        .output()
        .is_ok_and(|output| output.status.success());
    if !may {
        println!("no disk can be mounted here");
        return;
    }
    for Case {
        name,
        command,
        files,
    } in all
    {
        expect(at, &command);
        let whole = contents(at, &files);
        let size: usize = whole.iter().flatten().map(Vec::len).sum();
        let (mut full, mut read_only) = (0, 0);
        for index in 0..moments(3).min(20) {
            let kept = at.join("kept");
            if kept.exists() {
                std::fs::remove_dir_all(&kept).unwrap();
            }
            std::fs::create_dir_all(at.join("disk")).unwrap();
            // In pages, from next to nothing to just below what the command writes.
            let pages = 1 + (spread(index) * size as f64 / 4096.0) as usize;
            let lock = if index == 0 {
                "mount -o remount,ro . &&"
            } else {
                ""
            };
            let script = format!(
                "mount -t tmpfs -o size={}k none disk && cd disk && ln -s ../*.json ../scenes ../mapping ../drive \
                 ../input . && cd ../disk && {lock} {} {}; code=$?; cp -a . ../kept; exit $code",
                4 * pages,
                env!("CARGO_BIN_EXE_echolot"),
                command.join(" ")
            );
            let output = Command::new("unshare")
                .current_dir(at)
                .args(["-m", "sh", "-c", &script])
                .output()
                .unwrap();
            let said = String::from_utf8_lossy(&output.stderr);
            let code = output.status.code();
            // Files of the same content take one page less or more.
            assert!(
                code == Some(2) || (code == Some(0) && index > 0),
                "{name}: {said}"
            );
            for ((file, now), whole) in files.iter().zip(contents(&kept, &files)).zip(&whole) {
                assert!(
                    now.is_none() || now == *whole,
                    "{name}, {pages} pages: {file}"
                );
                assert!(
                    code == Some(2) || now.is_some(),
                    "{name}, {pages} pages: {file}"
                );
            }
            if code == Some(2) {
                assert!(said.contains("error: "), "{name}: {said}");
                assert_eq!(
                    temporaries(&kept),
                    Vec::<PathBuf>::new(),
                    "{name}, {pages} pages"
                );
                *(if index == 0 {
                    &mut read_only
                } else {
                    &mut full
                }) += 1;
            }
        }
        note(
            "full disk (tmpfs)",
            name,
            full,
            "a line, exit 2, files whole or none",
        );
        note("read-only disk", name, read_only, "a line, exit 2, no file");
    }
}
