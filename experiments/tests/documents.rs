//! The documents: links resolve, generated parts are current, SUMMARY.md lists every page, lines are short.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use experiments::check::targets::Targets;
use experiments::check::verdicts::judge;
use experiments::check::{readme, report};
use experiments::summary::Summary;

/// Lines of prose and of code have at most this many characters.
const WIDTH: usize = 120;

/// Folders whose Rust files keep to it.
const SOURCES: [&str; 5] = ["fdtd", "oracles", "localizer", "experiments", "fuzz"];

/// The workspace's folder.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("..")
        .canonicalize()
        .unwrap()
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Adds the files with an extension below a folder, without built, cached or hidden folders.
fn collect(folder: &Path, extension: &str, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().to_string();
        if path.is_dir() {
            // Folders of the workspace that no commit holds, or that are other people's.
            if !name.starts_with('.')
                && !["target", "cache", "book", "venv", "shared"].contains(&name.as_str())
            {
                collect(&path, extension, files);
            }
        } else if path.extension().is_some_and(|own| own == extension) {
            files.push(path);
        }
    }
}

/// All Markdown files of the workspace.
fn documents() -> Vec<PathBuf> {
    let mut files = Vec::new();
    collect(&root(), "md", &mut files);
    files.sort();
    files
}

/// The lines of a text outside of fenced blocks, with their numbers from 1.
fn prose(text: &str) -> Vec<(usize, &str)> {
    let mut fenced = false;
    text.lines()
        .enumerate()
        .filter_map(|(index, line)| {
            if line.trim_start().starts_with("```") {
                fenced = !fenced;
                return None;
            }
            (!fenced).then_some((index + 1, line))
        })
        .collect()
}

/// A line without the text between backticks.
fn without_code(line: &str) -> String {
    line.split('`').step_by(2).collect::<Vec<_>>().join("``")
}

/// Targets of the links of a line.
fn links(line: &str) -> Vec<String> {
    let line = without_code(line);
    line.match_indices("](")
        .filter_map(|(at, _)| {
            let rest = &line[at + 2..];
            Some(rest[..rest.find(')')?].to_string())
        })
        .collect()
}

/// The anchors of a text's headings, as GitHub makes them.
fn anchors(text: &str) -> BTreeSet<String> {
    prose(text)
        .into_iter()
        .filter(|(_, line)| line.starts_with('#'))
        .map(|(_, line)| {
            line.trim_start_matches('#')
                .trim()
                .to_lowercase()
                .chars()
                .filter_map(|c| match c {
                    ' ' => Some('-'),
                    c if c.is_alphanumeric() || c == '-' || c == '_' => Some(c),
                    _ => None,
                })
                .collect()
        })
        .collect()
}

#[test]
fn relative_links_resolve() {
    let mut broken = Vec::new();
    for file in documents() {
        let text = read(&file);
        for (number, line) in prose(&text) {
            for link in links(line) {
                if link.contains("://") || link.starts_with("mailto:") {
                    continue;
                }
                let (path, anchor) = link.split_once('#').unwrap_or((&link, ""));
                let target = match path {
                    "" => file.clone(),
                    path => file.parent().unwrap().join(path),
                };
                let found = target.exists()
                    && (anchor.is_empty()
                        || (target.is_file() && anchors(&read(&target)).contains(anchor)));
                if !found {
                    broken.push(format!("{}:{number}: {link}", file.display()));
                }
            }
        }
    }
    assert!(broken.is_empty(), "broken links:\n{}", broken.join("\n"));
}

#[test]
fn summary_lists_every_page() {
    let folder = root().join("docs");
    let summary = read(&folder.join("SUMMARY.md"));
    let listed: BTreeSet<PathBuf> = summary
        .lines()
        .flat_map(links)
        .map(|link| folder.join(link))
        .collect();
    let mut pages = Vec::new();
    collect(&folder, "md", &mut pages);
    for page in pages {
        assert!(
            page.ends_with("SUMMARY.md") || listed.contains(&page),
            "docs/SUMMARY.md does not list {}",
            page.display()
        );
    }
}

#[test]
fn lines_are_short() {
    let mut long = Vec::new();
    for file in documents() {
        let generated = file.starts_with(root().join("results"));
        if generated && !file.ends_with("results/README.md") {
            continue;
        }
        for (number, line) in prose(&read(&file)) {
            let is_table = line.trim_start().starts_with('|');
            let is_picture = line.starts_with("![");
            if line.chars().count() > WIDTH && !is_table && !is_picture {
                long.push(format!("{}:{number}", file.display()));
            }
        }
    }
    let mut sources = Vec::new();
    for folder in SOURCES {
        collect(&root().join(folder), "rs", &mut sources);
    }
    for file in sources {
        for (index, line) in read(&file).lines().enumerate() {
            if line.chars().count() > WIDTH {
                long.push(format!("{}:{}", file.display(), index + 1));
            }
        }
    }
    assert!(
        long.is_empty(),
        "lines of more than {WIDTH} characters:\n{}",
        long.join("\n")
    );
    for name in ["README.md", "ARCHITECTURE.md"] {
        assert!(read(&root().join(name)).lines().count() <= 150, "{name}");
    }
}

#[test]
fn claims_are_current() {
    let results = root().join("results");
    let summary = |name: &str| Summary::read(&results.join(name).join("summary.json")).unwrap();
    let paper = summary("paper");
    let [quick, large] = readme::runs(&results, &paper.provenance).unwrap();
    let layouts = readme::random_layouts(&results).unwrap();
    let targets = Targets::load().unwrap();
    let judged = judge(&targets, &paper).unwrap();
    let file = root().join("README.md");
    let text = read(&file);
    let blocks = [
        readme::claims(&targets, &judged, layouts.as_ref()),
        readme::commands(&quick, &large),
    ];
    assert!(
        readme::fill(&text, &file, &blocks).unwrap() == text,
        "README.md is not what results/paper/summary.json says: make claims"
    );
    assert!(
        read(&results.join("paper/report.md")) == report::markdown(&targets, &judged, &paper),
        "results/paper/report.md is not what results/paper/summary.json says: make claims"
    );
}

#[test]
fn the_command_line_is_current() {
    assert!(
        read(&root().join("docs/reference/command-line.md")) == experiments::cli::reference(),
        "docs/reference/command-line.md is not what the program says: make reference"
    );
}

/// Source files named in backticks with their path from the workspace's folder, except those that a reader writes
/// (`my_...`).
#[test]
fn source_files_that_documents_name_exist() {
    let mut missing = Vec::new();
    for file in documents() {
        for (line, text) in prose(&read(&file)) {
            for name in text.split('`').skip(1).step_by(2) {
                let of_source = ["fdtd/", "oracles/", "localizer/", "experiments/"];
                if of_source.iter().any(|start| name.starts_with(start))
                    && !name.contains(['{', '*', ':', '<'])
                    && !name.contains("my_")
                    && !root().join(name).exists()
                {
                    missing.push(format!("{}:{line}: {name}", file.display()));
                }
            }
        }
    }
    assert!(missing.is_empty(), "{}", missing.join("\n"));
}
