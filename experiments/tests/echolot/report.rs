//! The page of a study: whole, safe, and its replay moves in a real browser.

use std::path::Path;
use std::process::Command;

use serde_json::json;

use crate::room::{expect, project_file, refuse};
use crate::studies::study_file;

/// The page's document as a browser has it after its script ran; `None` where there is no browser.
fn opened(page: &Path, moment: &str) -> Option<String> {
    let profile = tempfile::tempdir().unwrap();
    let output = Command::new("chromium")
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--dump-dom"])
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .arg(format!("file://{}{moment}", page.display()))
        .output()
        .ok()?;
    Some(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// What the page says of a moment of the drive.
fn said(document: &str) -> String {
    let from = document
        .find("<output>")
        .unwrap_or_else(|| panic!("{document}"));
    let to = document[from..].find("</output>").unwrap();
    document[from + 8..from + to].to_string()
}

/// The page of the committed results of the papers' size.
#[test]
fn the_papers_page_is_whole_and_small() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    expect(
        at,
        &["report", &project_file("results/paper"), "-o", "paper.html"],
    );
    let file = at.join("paper.html");
    let page = std::fs::read_to_string(&file).unwrap();
    assert!(page.len() < 10 << 20, "{} bytes", page.len());
    for word in [
        "not reproduced",
        "data/drift_paths.csv",
        "report.md",
        "fig04_scene_and_map",
    ] {
        assert!(page.contains(word), "{word}");
    }
    assert!(page.matches("<svg").count() > 10);
    assert_eq!(
        page.matches("src=").count(),
        page.matches("src=\"data:image/png;").count()
    );
    let Some(start) = opened(&file, "") else {
        eprintln!("skipped: chromium is not installed");
        return;
    };
    // The first error of the first trial, as the data file has it.
    let paths =
        std::fs::read_to_string(project_file("results/paper/data/drift_paths.csv")).unwrap();
    let first: f64 = paths
        .lines()
        .nth(1)
        .unwrap()
        .rsplit(',')
        .next()
        .unwrap()
        .parse()
        .unwrap();
    let words = said(&start);
    assert!(words.contains(&format!("Doppler {first:.4} m")), "{words}");
    let later = said(&opened(&file, "#t=20").unwrap());
    assert!(
        later.starts_with("20.") || later.starts_with("19.9"),
        "{later}"
    );
    assert_ne!(later, words);
}

#[test]
fn a_report_is_one_page_whose_replay_moves() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let evil = json!("<script>alert(1)</script> & \"more\"");
    study_file(
        at,
        &[
            ("about", evil),
            ("methods", json!(["odometry", "landmarks"])),
            ("claims", json!([])),
        ],
    );
    expect(at, &["run", "mine.json", "--no-figures"]);
    expect(at, &["report", "results/mine", "-o", "pages/mine.html"]);
    let file = at.join("pages/mine.html");
    let page = std::fs::read_to_string(&file).unwrap();
    assert!(!page.contains("alert(1)</script>"), "texts are escaped");
    assert!(page.matches("<svg").count() >= 3 && page.contains("../results/mine/data/trials.csv"));
    // Nothing is loaded from anywhere.
    for word in ["http://", "https://", "src=", "@import", "url("] {
        let found = page.matches(word).count();
        let allowed = page.matches("http://www.w3.org/2000/svg").count();
        assert!(
            found <= if word == "http://" { allowed } else { 0 },
            "{word}"
        );
    }
    expect(at, &["report", "results/mine", "-o", "pages/mine.html"]);
    std::fs::write(at.join("notes.html"), "<p>mine</p>").unwrap();
    assert!(refuse(at, &["report", "results/mine", "-o", "notes.html"]).contains("--force"));
    assert!(refuse(at, &["report", "results", "-o", "a.html"]).contains("summary.json"));

    let Some(start) = opened(&file, "") else {
        eprintln!("skipped: chromium is not installed");
        return;
    };
    assert!(
        said(&start).starts_with("0.0 s \u{b7} odometry"),
        "{}",
        said(&start)
    );
    let later = opened(&file, "#t=6").unwrap();
    assert!(said(&later).starts_with("6.0 s"), "{}", said(&later));
    assert_ne!(said(&later)[5..], said(&start)[5..]);
    assert!(later.contains("rotate("), "robots stand on the map");
}
