//! The house: which crate knows which, and that modules use each other in one direction.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// The repository.
fn top() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The names of a manifest's dependencies, those of tests and builds included.
fn dependencies(manifest: &toml::Table) -> BTreeSet<String> {
    let tables = ["dependencies", "dev-dependencies", "build-dependencies"];
    let tables = tables.iter().filter_map(|name| manifest.get(*name)?.as_table());
    tables.flat_map(|table| table.keys().cloned()).collect()
}

/// The crates of the workspace and which of them each depends on.
fn crates() -> BTreeMap<String, BTreeSet<String>> {
    let mut folders = vec![top().to_owned(), top().join("src"), top().join("sys")];
    folders.extend(fs::read_dir(top().join("crates")).unwrap().map(|entry| entry.unwrap().path()));
    let read = |folder: &PathBuf| {
        let manifest: toml::Table =
            fs::read_to_string(folder.join("Cargo.toml")).unwrap().parse().unwrap();
        (manifest["package"]["name"].as_str().unwrap().to_owned(), dependencies(&manifest))
    };
    let all: BTreeMap<_, _> = folders.iter().map(read).collect();
    let known: BTreeSet<String> = all.keys().cloned().collect();
    all.into_iter().map(|(name, all)| (name, all.intersection(&known).cloned().collect())).collect()
}

#[test]
fn figure_and_solver_crates_do_not_depend_on_each_other() {
    let expected = [
        ("mics", &["mics-plot", "mics-run", "mics-solver"][..]),
        ("mics-plot", &["mics-run", "mics-shapes"]),
        ("mics-run", &["mics-shapes"]),
        ("mics-shapes", &[]),
        ("mics-solver", &["mics-run", "mics-shapes", "petsc-sys"]),
        ("petsc-sys", &[]),
    ];
    let expected = expected
        .map(|(name, all)| (name.to_owned(), all.iter().map(|name| (*name).to_owned()).collect()));
    assert_eq!(crates(), BTreeMap::from(expected));
}

/// The source of a file without comments, and without the tests at its end.
fn code(file: &Path) -> String {
    let text = fs::read_to_string(file).unwrap();
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    let lines = text.lines().filter(|line| !line.trim_start().starts_with("//"));
    lines.map(|line| format!("{line}\n")).collect()
}

/// The names that follow a path, as `crate::`, in a source.
fn used(code: &str, path: &str) -> BTreeSet<String> {
    let name = |text: &str| -> String {
        text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
    };
    let mut found = BTreeSet::new();
    for (at, word) in code.match_indices(path) {
        // `super::super::` is no `super::`.
        if code[..at].ends_with("::") {
            continue;
        }
        let rest = &code[at + word.len()..];
        match rest.strip_prefix('{') {
            None => _ = found.insert(name(rest)),
            Some(list) => {
                let mut depth = 0;
                for part in list.split_inclusive([',', '{', '}']) {
                    if depth == 0 {
                        found.insert(name(part.trim()));
                    }
                    match part.chars().last() {
                        Some('{') => depth += 1,
                        Some('}') if depth == 0 => break,
                        Some('}') => depth -= 1,
                        _ => {}
                    }
                }
            }
        }
    }
    found.remove("");
    found.remove("super");
    found
}

/// All files of Rust in a folder, tests aside.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let of = |path: PathBuf| match path.file_stem().unwrap().to_str().unwrap() {
        "tests" => Vec::new(),
        _ if path.is_dir() => files(&path),
        _ => vec![path],
    };
    entries.flat_map(of).filter(|path| path.extension().is_some_and(|e| e == "rs")).collect()
}

/// The modules in a folder of the crate in `root` and which others of the folder each uses.
fn modules(root: &Path, folder: &Path) -> BTreeMap<String, BTreeSet<String>> {
    let mut arrows: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    let names = |path: &Path| -> Vec<String> {
        path.iter().map(|name| name.to_str().unwrap().to_owned()).collect()
    };
    let place = names(folder.strip_prefix(root).unwrap());
    let from_crate =
        format!("crate::{}", place.iter().map(|n| format!("{n}::")).collect::<String>());
    for file in files(folder) {
        let inside = names(&file.strip_prefix(folder).unwrap().with_extension(""));
        // The command line is a crate of its own.
        if ["lib", "mod", "main", "bin", "build"].contains(&inside[0].as_str()) {
            continue;
        }
        let depth = inside.len() - usize::from(inside.last().is_some_and(|name| name == "mod"));
        let (code, from_file) = (code(&file), "super::".repeat(depth));
        let all = arrows.entry(inside[0].clone()).or_default();
        all.extend(used(&code, &from_crate).into_iter().chain(used(&code, &from_file)));
    }
    let known: BTreeSet<String> = arrows.keys().cloned().collect();
    for (module, used) in &mut arrows {
        used.retain(|name| known.contains(name) && name != module);
    }
    arrows
}

/// Modules that use each other in a circle: what is left where all that use nothing else are taken
/// away, again and again.
fn circles(mut arrows: BTreeMap<String, BTreeSet<String>>) -> BTreeMap<String, BTreeSet<String>> {
    loop {
        let before = arrows.len();
        let left: BTreeSet<String> = arrows.keys().cloned().collect();
        arrows.retain(|_, used| !used.is_disjoint(&left));
        if arrows.len() == before {
            return arrows;
        }
    }
}

/// A folder and all in it.
fn folders(folder: PathBuf) -> Vec<PathBuf> {
    let entries = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path());
    let inner: Vec<_> = entries.filter(|path| path.is_dir()).flat_map(folders).collect();
    std::iter::once(folder).chain(inner).collect()
}

#[test]
fn modules_have_no_dependency_cycle() {
    let mut arrows_seen = 0;
    for root in [
        "src",
        "src/bin/mics",
        "crates/mics-run/src",
        "crates/mics-plot/src",
        "crates/mics-shapes/src",
    ] {
        let root = top().join(root);
        for folder in folders(root.clone()) {
            let arrows = modules(&root, &folder);
            arrows_seen += arrows.values().map(BTreeSet::len).sum::<usize>();
            let circles = circles(arrows);
            assert!(circles.is_empty(), "{folder:?}: each uses another of these: {circles:#?}");
        }
    }
    assert!(arrows_seen > 300, "{arrows_seen}");
}

#[test]
fn dependency_cycle_is_found_in_use_lists_and_paths() {
    let code = "use crate::a::{b, c};\nuse crate::{Error, d::{e, f}, g};\nlet x = crate::h::i();";
    let names = ["Error", "a", "d", "g", "h"].map(str::to_owned);
    assert_eq!(used(code, "crate::"), BTreeSet::from(names));
    let inner = "use super::a::b;\nuse super::super::c::d;\nuse super::{e, f::g};";
    assert_eq!(used(inner, "super::"), BTreeSet::from(["a", "e", "f"].map(str::to_owned)));
    assert_eq!(used(inner, "super::super::"), BTreeSet::from(["c".to_owned()]));
    let of = |all: &[(&str, &str)]| {
        let arrow = |(from, to): &(&str, &str)| ((*from).into(), BTreeSet::from([(*to).into()]));
        circles(all.iter().map(arrow).collect())
    };
    assert_eq!(of(&[("a", "b"), ("b", "c"), ("c", "d")]).len(), 0);
    assert_eq!(of(&[("a", "b"), ("b", "c"), ("c", "b")]).len(), 3);
}

/// Most lines of a file, and of a function.
const FILE_LINES: usize = 450;
const FUNCTION_LINES: usize = 60;

/// The name of the function that a line begins, if it begins one.
fn function(line: &str) -> Option<&str> {
    let (before, after) = line.split_once("fn ")?;
    let qualified = before.split_whitespace().all(|word| {
        ["const", "unsafe", "extern", "\"C\"", "async"].contains(&word) || word.starts_with("pub")
    });
    let name = after.split(|c: char| !c.is_alphanumeric() && c != '_').next()?;
    (qualified && !name.is_empty()).then_some(name)
}

/// The functions of a source, which is formatted, with their lines: from the one with its name to
/// the brace in the same column.
fn functions(text: &str) -> Vec<(&str, usize)> {
    let lines: Vec<&str> = text.lines().collect();
    let length = |first: usize| {
        let indent = lines[first].len() - lines[first].trim_start().len();
        let ends = |line: &&str| line.len() - line.trim_start().len() == indent;
        let closes = |line: &str| line.trim_start().starts_with('}') || line.ends_with(';');
        match lines[first].ends_with(['}', ';']) {
            true => 1,
            false => {
                let rest = lines[first + 1..].iter();
                2 + rest.take_while(|line| !(ends(line) && closes(line))).count()
            }
        }
    };
    let found = lines.iter().enumerate().filter_map(|(k, line)| Some((function(line)?, length(k))));
    found.collect()
}

/// All files of Rust in a folder.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let of = |path: PathBuf| if path.is_dir() { sources(&path) } else { vec![path] };
    entries.flat_map(of).filter(|path| path.extension().is_some_and(|e| e == "rs")).collect()
}

#[test]
fn files_and_functions_within_length_limits() {
    let (mut files, mut long) = (BTreeSet::new(), BTreeSet::new());
    for folder in ["src", "crates", "sys", "tests", "benches", "examples"] {
        for path in sources(&top().join(folder)) {
            let text = fs::read_to_string(&path).unwrap();
            let name = path.strip_prefix(top()).unwrap().to_str().unwrap().to_owned();
            if text.lines().count() > FILE_LINES {
                files.insert(name.clone());
            }
            if ["src", "crates", "sys"].contains(&folder) {
                let over = functions(&text).into_iter().filter(|(_, n)| *n > FUNCTION_LINES);
                long.extend(over.map(|(function, _)| format!("{name}: {function}")));
            }
        }
    }
    assert!(files.is_empty(), "over {FILE_LINES} lines: {files:?}");
    assert!(long.is_empty(), "over {FUNCTION_LINES} lines: {long:?}");
}

/// Seconds are the machine's and its other users': tests wait for what happens, for five minutes at
/// most, and judge none.
#[test]
fn no_test_of_the_suite_judges_seconds() {
    let clocks = ["Instant::now", "SystemTime::now"];
    let mut timed = sources(&top().join("tests"));
    timed.retain(|path| {
        clocks.iter().any(|clock| fs::read_to_string(path).unwrap().contains(clock))
    });
    let here = ["live.rs", "house.rs"];
    timed.retain(|path| here.iter().all(|name| !path.ends_with(name)));
    assert!(timed.is_empty(), "{timed:?}: use live::wait_for");
}

/// A run of a test or of PETSc that writes where it stands leaves something there.
#[test]
fn no_file_at_the_top_is_empty() {
    let entries = fs::read_dir(top()).unwrap().map(|entry| entry.unwrap().path());
    let left: Vec<_> =
        entries.filter(|p| p.is_file() && p.metadata().unwrap().len() == 0).collect();
    assert!(left.is_empty(), "{left:?}");
}

#[test]
fn function_length_from_name_to_closing_brace() {
    let text = "impl A {\n    pub(crate) const fn short() {}\n    fn long(\n        a: u8,\n\
        \x20   ) {\n\n        a;\n    }\n}\n/// fn of words\nunsafe extern \"C\" fn one(\n);\n";
    assert_eq!(functions(text), [("short", 1), ("long", 6), ("one", 2)]);
}
