//! The house: which crate knows which, that modules use each other in one direction, and what types
//! and functions look like.

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

/// All files of Rust in a folder.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let of = |path: PathBuf| if path.is_dir() { sources(&path) } else { vec![path] };
    entries.flat_map(of).filter(|path| path.extension().is_some_and(|e| e == "rs")).collect()
}

/// A source without comments and without what its texts and characters hold.
fn plain(source: &str) -> String {
    let mut plain = String::new();
    let mut rest = source;
    while let Some(c) = rest.chars().next() {
        let in_word = plain.ends_with(|c: char| c.is_alphanumeric() || c == '_');
        let hashes = rest.len() - 1 - rest[c.len_utf8()..].trim_start_matches('#').len();
        let raw = c == 'r' && !in_word && rest[1 + hashes..].starts_with('"');
        let length = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if raw {
            let begin = hashes + 2;
            let end = format!("\"{}", "#".repeat(hashes));
            begin + rest[begin..].find(&end).unwrap() + end.len()
        } else if c == '"' {
            let mut escaped = false;
            let ends = |c: char| {
                let ends = c == '"' && !escaped;
                escaped = c == '\\' && !escaped;
                ends
            };
            2 + rest[1..].find(ends).unwrap()
        } else if rest.starts_with("'\\") {
            4 + rest[3..].find('\'').unwrap()
        } else if c == '\'' && rest.chars().nth(2) == Some('\'') {
            2 + rest.chars().nth(1).map_or(0, char::len_utf8)
        } else {
            plain.push(c);
            c.len_utf8()
        };
        rest = &rest[length..];
    }
    plain
}

/// The source between the bracket that a plain source begins with and the one that closes it, and
/// what follows.
fn within(source: &str) -> Option<(&str, &str)> {
    let mut depth = 0;
    let closes = |c: char| {
        depth += i32::from("([{".contains(c)) - i32::from(")]}".contains(c));
        depth == 0
    };
    let end = source.find(closes)?;
    Some((source.get(1..end)?, &source[end + 1..]))
}

/// The parts of a list of fields, parameters or values between its commas.
fn parts(list: &str) -> Vec<&str> {
    let mut depth = 0;
    let mut before = ' ';
    let between = |c: char| {
        // After a space they compare or shift, and an arrow is no bracket either.
        let none = "<>".contains(c) && " -=".contains(before);
        if !none {
            depth += i32::from("([{<".contains(c)) - i32::from(")]}>".contains(c));
        }
        before = if none { ' ' } else { c };
        c == ',' && depth == 0
    };
    list.split(between).map(str::trim).filter(|part| !part.is_empty()).collect()
}

/// A plain source past the parameters in `<` and `>` that it may begin with.
fn past_generics(source: &str) -> &str {
    let mut depth = 0;
    let mut before = ' ';
    let ends = |c: char| {
        depth += i32::from(c == '<') - i32::from(c == '>' && before != '-');
        before = c;
        depth == 0
    };
    if source.starts_with('<') { &source[source.find(ends).unwrap() + 1..] } else { source }
}

/// The names after a keyword in a plain source, and what follows each.
fn named<'a>(source: &'a str, keyword: &str) -> Vec<(&'a str, &'a str)> {
    let word = |c: char| c.is_alphanumeric() || c == '_';
    let all = source.match_indices(keyword).filter(|(at, _)| !source[..*at].ends_with(word));
    let split = |(at, _): (usize, &str)| {
        let rest = source[at + keyword.len()..].strip_prefix(' ')?;
        let end = rest.find(|c| !word(c)).unwrap_or(rest.len());
        (end > 0).then(|| rest.split_at(end))
    };
    all.filter_map(split).collect()
}

/// The structs of a plain source with how many fields each has.
fn fields(source: &str) -> Vec<(&str, usize)> {
    let count = |(name, rest)| {
        let rest = past_generics(rest);
        let begin = rest.find(['{', '(', ';'])?;
        let (fields, _) = within(&rest[begin..]).filter(|_| rest[begin..].starts_with('{'))?;
        Some((name, parts(fields).len()))
    };
    named(source, "struct").into_iter().filter_map(count).collect()
}

/// The types of other files that a plain source has methods of, those of traits aside.
fn guests(source: &str) -> Vec<&str> {
    let types = ["struct", "enum", "union", "trait"].iter().flat_map(|kind| named(source, kind));
    let own: BTreeSet<&str> = types.map(|(name, _)| name).collect();
    let of = |(at, keyword): (usize, &str)| {
        let head = past_generics(&source[at + keyword.len()..]).split('{').next()?;
        let name = head.trim_start().trim_start_matches("dyn ");
        let name = name.split(|c: char| !c.is_alphanumeric() && c != '_').next()?;
        (!head.contains(" for ") && !own.contains(name)).then_some(name)
    };
    source.match_indices("\nimpl").filter_map(of).collect()
}

/// The lists of names of a plain source that are bound to a list of values at once, as in
/// `(a, b) = (x, y);`, those that are swapped aside.
fn bound_together(source: &str) -> Vec<&str> {
    let together = |(at, _): (usize, &str)| {
        let line = source[at..].trim_start();
        let line = line.strip_prefix("let ").unwrap_or(line);
        let (names, rest) = within(line).filter(|_| line.starts_with('('))?;
        let (types, values) = rest.split_once('=')?;
        let plain = types.trim().is_empty() || types.starts_with(':') && !types.contains(';');
        let values = values.trim_start();
        let (values, end) = within(values).filter(|_| plain && values.starts_with('('))?;
        let [mut old, mut new] = [names, values].map(parts);
        old.sort_unstable();
        new.sort_unstable();
        (end.starts_with(';') && new.len() > 1 && old != new).then_some(names)
    };
    source.match_indices('\n').filter_map(together).collect()
}

/// The functions of a plain source with a parameter that is taken apart, as in
/// `fn f((a, b): (A, B))`.
fn taking_apart(source: &str) -> Vec<&str> {
    let tuple = |part: &&str| part.trim_start_matches('&').starts_with('(');
    let takes =
        |rest| within(past_generics(rest)).is_some_and(|(all, _)| parts(all).iter().any(tuple));
    named(source, "fn").into_iter().filter(|(_, rest)| takes(rest)).map(|(name, _)| name).collect()
}

/// The sources of the program.
fn program() -> Vec<PathBuf> {
    ["src", "crates"].iter().flat_map(|folder| sources(&top().join(folder))).collect()
}

/// Most fields of a type, and those that have more.
const FIELDS: usize = 12;
const MANY_FIELDS: [(&str, &str); 4] = [
    ("Case", "a key of a case's file each"),
    ("Measure", "a key of a measure's table each"),
    ("State", "all that lasts from step to step, as a checkpoint has it"),
    ("Swarm", "a key of a swarm's table each"),
];

#[test]
fn types_have_twelve_fields_at_most() {
    let mut many = BTreeSet::new();
    for path in program() {
        let source = plain(&fs::read_to_string(&path).unwrap());
        let over = fields(&source).into_iter().filter(|(_, count)| *count > FIELDS);
        many.extend(over.map(|(name, _)| name.to_owned()));
    }
    assert_eq!(many, BTreeSet::from(MANY_FIELDS.map(|(name, _)| name.to_owned())));
}

/// The files that have methods of types of other files.
const WITH_GUESTS: [(&str, &str); 5] = [
    ("crates/mics-run/src/config/describe.rs", "all words of `mics check` on tables, in one style"),
    ("src/method/mixture/force.rs", "an equation of the paper"),
    ("src/method/mixture/impose.rs", "an equation of the paper"),
    ("src/method/mixture/motion.rs", "an equation of the paper"),
    ("src/method/mixture/properties.rs", "an equation of the paper"),
];

#[test]
fn methods_stand_in_the_file_of_their_type() {
    let mut with_guests = BTreeMap::new();
    for path in ["src", "crates"].iter().flat_map(|folder| files(&top().join(folder))) {
        let source = plain(&code(&path));
        let guests: Vec<_> = guests(&source).into_iter().map(str::to_owned).collect();
        if !guests.is_empty() {
            let name = path.strip_prefix(top()).unwrap().to_str().unwrap().to_owned();
            with_guests.insert(name, guests);
        }
    }
    let expected = BTreeSet::from(WITH_GUESTS.map(|(name, _)| name.to_owned()));
    let found: BTreeSet<_> = with_guests.keys().cloned().collect();
    assert_eq!(found, expected, "{with_guests:#?}");
}

#[test]
fn values_are_bound_one_by_one() {
    let mut found = Vec::new();
    for path in program() {
        let source = plain(&fs::read_to_string(&path).unwrap());
        let name = path.strip_prefix(top()).unwrap().display();
        found.extend(bound_together(&source).iter().map(|names| format!("{name}: ({names})")));
        found.extend(taking_apart(&source).iter().map(|function| format!("{name}: {function}")));
    }
    assert!(found.is_empty(), "{found:#?}");
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
fn sources_are_read_past_texts_and_brackets() {
    let source = "a('\\'', b\"(\\\"\", r#\"\"(\"#, 'x', &'a y) // (\n;";
    assert_eq!(plain(source), "a(, b, , , &'a y) \n;");
    assert_eq!(within("(a[0], {b}) = c"), Some(("a[0], {b}", " = c")));
    assert_eq!(parts("a: B<C, D>, f: fn(E, F) -> G, #[h(i, j)] k: L,").len(), 3);
    assert_eq!(parts("a < b, c >> 1, (d, e)"), ["a < b", "c >> 1", "(d, e)"]);
    let types = "\nstruct A<F: Fn(B) -> C> {\n a: F,\n b: D<E, F>,\n}\nstruct G(H);\nstruct I;\n";
    assert_eq!(fields(types), [("A", 2)]);
    let methods = "\nimpl<F: Fn() -> B> A<F> {}\nimpl J {}\nimpl K for J {}\nimpl dyn L + '_ {}\n";
    assert_eq!(guests(&(types.to_owned() + methods)), ["J", "L"]);
    let bound = "\n let (a, b) = (x, y);\n (a, b) = (b, a);\n let (a, mut b): (A, B) =\n \
        (x(1), y);\n let (a, b) = f(x, y);\n (a.0, b) = (x, y);\n (a, b) == (x, y);\n";
    assert_eq!(bound_together(bound), ["a, b", "a, mut b", "a.0, b"]);
    let functions = "fn f<F: Fn(A, B)>((a, b): (A, B)) {}\nfn g(f: impl Fn((A, B)), [a, b]: C) {}";
    assert_eq!(taking_apart(functions), ["f"]);
}
