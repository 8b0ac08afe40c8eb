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
    // Four walls of the first room are known; what was heard is drawn beside the map.
    assert!(walls(&later) >= 3, "{}", walls(&later));
    assert!(later.contains("Echoes around the robot"));
}

/// Walls among the landmarks that a document shows.
fn walls(document: &str) -> usize {
    let from = document.find("stroke:var(--good)").unwrap();
    let to = document[from..].find("</g>").unwrap();
    document[from..from + to].matches("<line").count()
}

/// A drive of the example by images, among landmarks from an unknown start, and without a map.
#[test]
fn a_localization_is_replayed_with_what_was_heard_and_believed() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let [mapping, drive] =
        ["mapping", "drive"].map(|name| project_file(&format!("examples/site_robot/{name}")));
    expect(at, &["map", &mapping, "-o", "map"]);
    expect(at, &["map", &mapping, "--method", "landmarks", "-o", "map"]);
    let localize = [
        "localize", &drive, "--map", "map", "-o", "est.tum", "--report",
    ];
    let among = ["--method", "landmarks", "--start", "unknown"];
    expect(at, &[&localize[..], &["images.html"]].concat());
    expect(at, &[&localize[..], &["landmarks.html"], &among].concat());
    expect(
        at,
        &["slam", &drive, "-o", "slam.tum", "--report", "slam.html"],
    );
    // A page is replaced by the next one, another file is not.
    expect(at, &[&localize[..], &["images.html"]].concat());
    std::fs::write(at.join("notes.html"), "<p>mine</p>").unwrap();
    assert!(refuse(at, &[&localize[..], &["notes.html"]].concat()).contains("--force"));
    for name in ["images", "landmarks", "slam"] {
        let page = std::fs::read_to_string(at.join(format!("{name}.html"))).unwrap();
        assert!(page.len() < 2 << 20, "{name}: {} bytes", page.len());
        assert!(!page.contains("src=") && page.contains("mean error (MAE)"));
    }
    let see = |name: &str, moment: &str| opened(&at.join(format!("{name}.html")), moment);
    let Some(images) = see("images", "#t=6") else {
        eprintln!("skipped: chromium is not installed");
        return;
    };
    assert!(said(&images).contains("m sure"), "{}", said(&images));
    assert!(images.contains("data:image/png;base64"), "the map is drawn");
    // Particles and hypotheses are dots of that size.
    let dots = |document: &str| document.matches("r=\"0.015\"").count();
    assert!(dots(&images) > 30, "{}", dots(&images));
    let [early, late] = ["#t=0.5", "#t=10"].map(|moment| see("landmarks", moment).unwrap());
    let hypotheses = [dots(&early), dots(&late)];
    assert!(
        hypotheses[0] > 10 && (1..5).contains(&hypotheses[1]),
        "{hypotheses:?}"
    );
    assert!(said(&early).contains("converging"), "{}", said(&early));
    assert!(said(&late).contains("sure"), "{}", said(&late));
    assert_eq!(walls(&early), walls(&late));
    // Without a map nothing is known at the start.
    let [early, late] = ["", "#t=12"].map(|moment| see("slam", moment).unwrap());
    assert_eq!(walls(&early), 0);
    assert!(walls(&late) >= 3, "{}", walls(&late));
}
