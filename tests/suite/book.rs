//! The book in docs/ and the other pages: links lead somewhere, every page is in the table of
//! contents, what the program writes is what it writes, and the cases that are printed are cases.

use crate::support::{case, mics, shipped};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// The pages of Markdown that a reader may meet.
fn pages() -> Vec<PathBuf> {
    let in_folder = |folder: &str| {
        let entries = std::fs::read_dir(shipped(folder)).unwrap();
        entries.map(|entry| entry.unwrap().path()).collect::<Vec<_>>()
    };
    let docs =
        in_folder("docs").into_iter().filter(|path| path.extension().is_some_and(|e| e == "md"));
    let cases = in_folder("cases")
        .into_iter()
        .map(|path| path.join("README.md"))
        .filter(|path| path.exists());
    let top = ["README.md", "CONTRIBUTING.md", "CHANGELOG.md"].map(shipped);
    top.into_iter().chain(docs).chain(cases).collect()
}

/// The lines of a page that are no code, with their numbers; what stands between backticks is cut
/// out where `bare`.
fn prose(text: &str, bare: bool) -> Vec<(usize, String)> {
    let mut fenced = false;
    let mut lines = Vec::new();
    for (k, line) in text.lines().enumerate() {
        if line.trim_start().starts_with("```") {
            fenced = !fenced;
        } else if !fenced && bare {
            lines.push((k + 1, line.split('`').step_by(2).collect()));
        } else if !fenced {
            lines.push((k + 1, line.to_owned()));
        }
    }
    lines
}

/// Where a page can be entered: its headings, as forges and mdBook name them.
fn anchors(text: &str) -> Vec<String> {
    let mut seen: HashMap<String, usize> = HashMap::new();
    let headings = prose(text, false).into_iter().filter(|(_, line)| line.starts_with('#'));
    let names = headings.map(|(_, line)| {
        let title = line.trim_start_matches('#').trim().to_lowercase();
        let kept = title.chars().filter(|c| c.is_alphanumeric() || [' ', '-', '_'].contains(c));
        let name: String = kept.map(|c| if c == ' ' { '-' } else { c }).collect();
        let count = seen.entry(name.clone()).or_default();
        *count += 1;
        if *count == 1 { name } else { format!("{name}-{}", *count - 1) }
    });
    names.collect()
}

/// The targets of a line's links and pictures.
fn links(line: &str) -> Vec<&str> {
    line.split("](").skip(1).filter_map(|rest| rest.split(')').next()).collect()
}

/// Fault of a link of a page; `None` where it leads somewhere.
fn broken(page: &Path, text: &str, link: &str) -> Option<String> {
    if ["http://", "https://", "mailto:"].iter().any(|scheme| link.starts_with(scheme)) {
        return None;
    }
    let (path, anchor) =
        link.split_once('#').map_or((link, None), |(path, anchor)| (path, Some(anchor)));
    let target = if path.is_empty() { page.to_owned() } else { page.with_file_name(path) };
    if !target.exists() {
        return Some(format!("{path} is not there"));
    }
    let there = if path.is_empty() {
        text.to_owned()
    } else {
        std::fs::read_to_string(&target).unwrap_or_default()
    };
    let anchor = anchor.filter(|anchor| !anchors(&there).iter().any(|name| name == anchor))?;
    Some(format!("{} has no heading #{anchor}", target.display()))
}

#[test]
fn book_links_resolve() {
    let mut wrong = Vec::new();
    for page in pages() {
        let text = std::fs::read_to_string(&page).unwrap();
        for (line, said) in prose(&text, true) {
            let found = links(&said).into_iter().filter_map(|link| broken(&page, &text, link));
            wrong.extend(found.map(|why| format!("{}:{line}: {why}", page.display())));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn book_names_tests_that_exist() {
    let folders = ["tests", "src", "crates"].map(shipped);
    let sources: String = folders.iter().flat_map(|folder| sources(folder)).collect();
    let mut wrong = Vec::new();
    for page in pages().iter().filter(|page| !page.ends_with("CHANGELOG.md")) {
        let text = std::fs::read_to_string(page).unwrap().replace('\n', " ");
        let named = ["--test suite ", "test `", "tests `"].map(|before| text.split(before).skip(1));
        for rest in named.into_iter().flatten() {
            let name = rest.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap();
            if !name.starts_with(char::is_uppercase) && !sources.contains(name) {
                wrong.push(format!("{}: no test {name}", page.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The texts of all sources in a folder.
fn sources(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let texts = entries.flat_map(|path| match path.extension() {
        _ if path.is_dir() => sources(&path),
        Some(ending) if ending == "rs" => vec![std::fs::read_to_string(&path).unwrap()],
        _ => Vec::new(),
    });
    texts.collect()
}

#[test]
fn link_checker_follows_forge_anchors() {
    let text = "# A `[fluid]` of two\n## Twice\n```\n# no heading, [no](link)\n```\n## Twice\n";
    assert_eq!(anchors(text), ["a-fluid-of-two", "twice", "twice-1"]);
    let page = shipped("docs/output.md");
    for (link, right) in [
        ("running.md", true),
        ("nowhere.md", false),
        ("#twice-1", true),
        ("#thrice", false),
        ("method.md#a-step", true),
        ("method.md#nothing", false),
        ("https://example.org/nothing", true),
    ] {
        assert_eq!(broken(&page, text, link).is_none(), right, "{link}");
    }
}

#[test]
fn book_pages_are_in_summary() {
    let summary = shipped("docs/SUMMARY.md");
    let text = std::fs::read_to_string(&summary).unwrap();
    let listed: Vec<PathBuf> =
        text.lines().flat_map(links).map(|link| summary.with_file_name(link)).collect();
    let listed: Vec<PathBuf> = listed.iter().map(|path| path.canonicalize().unwrap()).collect();
    for page in pages() {
        let here = page.canonicalize().unwrap();
        let apart = page == summary;
        assert!(
            apart || listed.contains(&here),
            "docs/SUMMARY.md does not have {}",
            page.display()
        );
    }
}

#[test]
fn keys_page_equals_schema_markdown() {
    let output = mics(&["schema", "--markdown"]);
    let (written, kept) = (
        String::from_utf8(output.stdout).unwrap(),
        std::fs::read_to_string(shipped("docs/keys.md")),
    );
    assert!(
        written.contains("## `[[particle]]`")
            && written.contains("| `diameter` | number | required |"),
        "{written}"
    );
    assert!(
        kept.unwrap() == written,
        "docs/keys.md is another: mics schema --markdown > docs/keys.md"
    );
}

#[test]
fn cases_printed_in_pages_are_valid() {
    for (page, count) in [("docs/tutorial.md", 2), ("README.md", 1)] {
        let text = std::fs::read_to_string(shipped(page)).unwrap();
        let blocks = text.split("```toml\n").skip(1).filter_map(|rest| rest.split("```").next());
        let whole: Vec<&str> = blocks.filter(|block| block.contains("[domain]")).collect();
        assert_eq!(whole.len(), count, "{page}");
        assert!(whole.iter().all(|block| !case(block).particle.is_empty()), "{page}");
    }
}

/// The first paragraph of the book says that bodies have shapes and that there are obstacles.
#[test]
fn first_page_names_shapes_and_obstacles() {
    let text = std::fs::read_to_string(shipped("README.md")).unwrap();
    let said = text.split("\n\n").nth(1).unwrap();
    for word in ["shapes", "bstacles", "polyhedra"] {
        assert!(said.contains(word), "README.md lacks {word}");
    }
    let glossary = std::fs::read_to_string(shipped("docs/glossary.md")).unwrap();
    assert!(glossary.contains("\n| obstacle |") && !glossary.contains("A disc (2D) or a sphere"));
}
