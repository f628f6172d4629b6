//! What half and twice each number of the method does ([`Numerics`]): the measures of `mics
//! validate` that change by more than a thousandth, and what scenes in contact give.
//!
//! ```text
//!   cargo bench --bench constants [-- NAME | NAME=VALUE]...
//! ```
//! A row a value, in Markdown; some minutes each. Values out of their range are passed over.

use mics::numerics::Numerics;
use mics_run::summary::Summary;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

/// Scenes beside those of `mics validate`, and what is changed of their cases.
const CASES: [(&str, &[&str]); 2] = [
    (
        "cases/packing/case.toml",
        &[
            "domain.size=[0.05,0.08]",
            "domain.cells=[40,64]",
            "swarm.0.count=12",
            "swarm.0.region={ min = [0.0, 0.0], max = [0.05, 0.08] }",
            "time.end=1.0",
        ],
    ),
    (
        "cases/wet-rebound/case.toml",
        &[
            "domain.cells=[32,56,32]",
            "measure.0.name=\"rebound\"",
            "measure.0.when={ time = 0.028 }",
            "time.end=0.03",
            "output.figures=false",
        ],
    ),
];

/// Measures that differ by less than this of their value are not shown.
const WORTH_SHOWING: f64 = 1e-3;

fn main() {
    let words: Vec<String> =
        std::env::args().skip(1).filter(|word| !word.starts_with('-')).collect();
    let base = measures(None);
    println!("| number | value | CPU | what changes |\n|---|---|---|---|");
    for (name, value) in wanted(&words) {
        let found = measures(Some((name, value)));
        let cpu = found["CPU"] / base["CPU"];
        println!("| `{name}` | {value} | {cpu:.2} | {} |", differences(&base, &found).join(", "));
    }
}

/// The numbers that the words ask for, with their values: half and twice the default of those that
/// are named without one, and of all without words.
fn wanted(words: &[String]) -> Vec<(&'static str, f64)> {
    let given =
        |name: &str| words.iter().find_map(|word| word.strip_prefix(name)?.strip_prefix('='));
    let mut wanted = Vec::new();
    for (name, default) in Numerics::default().named() {
        if let Some(value) = given(name) {
            wanted.push((name, value.parse().expect("a number")));
        } else if words.is_empty() || words.iter().any(|word| word == name) {
            wanted.extend([0.5, 2.0].map(|factor| (name, factor * default)));
        }
    }
    wanted.retain(|(name, value)| Numerics::is_valid(name, *value));
    wanted
}

/// How the measures differ from those of the constants as they are, the largest difference first.
fn differences(base: &BTreeMap<String, f64>, found: &BTreeMap<String, f64>) -> Vec<String> {
    let mut off: Vec<(f64, String)> = Vec::new();
    for (key, own) in base.iter().filter(|(key, _)| *key != "CPU") {
        match found.get(key) {
            None => off.push((f64::INFINITY, format!("{key} fails"))),
            Some(value) => {
                let change = value / own - 1.0;
                off.push((change.abs(), format!("{key} {:+.1} %", 100.0 * change)));
            }
        }
    }
    off.retain(|(size, _)| *size > WORTH_SHOWING);
    off.sort_by(|a, b| b.0.total_cmp(&a.0));
    off.into_iter().take(6).map(|(_, text)| text).collect()
}

/// All measures with another value of a number, and the CPU time (s) that they took.
fn measures(other: Option<(&str, f64)>) -> BTreeMap<String, f64> {
    let set = other.map(|(name, value)| format!("numerics.{name}={value:?}"));
    let set: Vec<&str> = set.iter().flat_map(|set| ["--set", set]).collect();
    let folder = tempfile::tempdir().expect("a folder");
    let mics = |words: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_mics"));
        // What fails is missing in the table.
        command.args(words).args(&set).output().expect("mics starts");
    };
    let path = |name: &str| folder.path().join(name).display().to_string();
    mics(&["validate", "--quick", "--out", &path("validate")]);
    for (case, scene) in CASES {
        let out = path(&folder_of(case));
        let mut words = vec!["run", case, "--out", &out, "--quiet"];
        scene.iter().for_each(|set| words.extend(["--set", set]));
        mics(&words);
    }
    let mut found = BTreeMap::from([("CPU".to_owned(), 0.0)]);
    let runs =
        std::fs::read_dir(path("validate")).into_iter().flatten().flatten().map(|e| e.path());
    for run in runs.chain(CASES.iter().map(|(case, _)| folder.path().join(folder_of(case)))) {
        read(&run, &mut found);
    }
    found
}

/// The name of a case's folder.
fn folder_of(case: &str) -> String {
    let folder = Path::new(case).parent().and_then(Path::file_name).unwrap_or_default();
    folder.to_string_lossy().into_owned()
}

/// The measures of a run that ended well.
fn read(run: &Path, found: &mut BTreeMap<String, f64>) {
    let Ok(summary) = Summary::read(run) else { return };
    let case = run.file_name().unwrap_or_default().display();
    let measures =
        summary.measures.iter().filter_map(|(name, value)| Some((name, value.as_f64()?)));
    found.extend(measures.map(|(name, value)| (format!("{case} {name}"), value)));
    *found.entry("CPU".to_owned()).or_default() += summary.cpu_seconds;
}
