//! Refusals of a wrong case or command line: exit status 2, one message that says where and what
//! would be right, and nothing written. Each row breaks a good case in one way.

use crate::bad_bodies::BAD_BODIES;
use crate::bad_keys::BAD_KEYS;
use crate::support::mics_command;
use mics::config::load;
use std::fs;
use std::path::Path;
use std::process::Output;

pub const GOOD: &str = r#"name = "small"

[domain]
size = [2.0, 1.0]
cells = [32, 16]

[fluid]
density = 1.0
viscosity = 0.1

[boundary]
west = { inflow = [1.0, 0.0] }
east = "outflow"
south = "periodic"
north = "periodic"

[[particle]]
shape = { disc = { diameter = 0.2 } }
position = [0.5, 0.5]
motion = "fixed"

[[particle]]
shape = { disc = { diameter = 0.3 } }
position = [1.2, 0.5]
motion = "fixed"

[time]
end = 0.1
cfl = 0.4

[pressure]
divergence_limit = 1.0e-6

[[measure]]
name = "drag"
kind = "drag_coefficient"
"#;

/// Overrides of the good case that are refused, and what the message must say.
const BAD_OVERRIDES: &[(&str, &[&str])] = &[
    ("fluid.viscosity", &["key.path=value"]),
    ("fluid.viscosity=", &["no value"]),
    ("=2.0", &["key.path=value"]),
    ("time.end=0,2", &["`0,2` has a comma where a number has a point: --set time.end=0.2"]),
    ("fluid.viscosity=5.0 Pa s", &["words behind the number", "--set fluid.viscosity=5.0"]),
    ("time.scheme=euler", &[r#"--set 'time.scheme="euler"'"#]),
    ("domain.cells=[32", &["not a TOML value"]),
    ("particle.5.density=2.0", &["no entry 5", "has 2"]),
    ("particle.density=2.0", &["`particle.0.density`"]),
    (
        "fluid.viscosity=-2.0",
        &["small.toml", "fluid.viscosity", "zero or positive", "(given by --set)"],
    ),
    ("fluid.viscosty=2.0", &["small.toml", "did you mean `viscosity`?", "(given by --set)"]),
    ("preset=\"mics-2004\"", &["small.toml", "preset", "mics-2003", "(given by --set)"]),
    ("domain.cells=\"many\"", &["small.toml", "domain.cells", "wanted a list", "(given by --set)"]),
];

/// `mics run CASE --out DIR` and these further arguments.
fn mics(case: &Path, out: &Path, arguments: &[&str]) -> Output {
    let mut command = mics_command();
    command.arg("run").arg(case).arg("--out").arg(out).args(arguments);
    command.output().expect("the binary runs")
}

/// Faults of a refusal: its status, its message or what it left in `out`; empty where all is as it
/// should be.
pub fn shortcomings(output: &Output, out: &Path, says: &[&str]) -> Vec<String> {
    let message = String::from_utf8_lossy(&output.stderr);
    let mut wrong = Vec::new();
    if output.status.code() != Some(2) {
        wrong.push(format!("exit status {:?}, expected 2", output.status.code()));
    }
    if message.lines().filter(|line| line.starts_with("error: ")).count() != 1
        || !message.starts_with("error: ")
    {
        wrong.push("expected one message".into());
    }
    wrong.extend(
        says.iter()
            .filter(|part| !message.contains(**part))
            .map(|part| format!("does not say `{part}`")),
    );
    if out.exists() {
        wrong.push("the output folder was made".into());
    }
    if !wrong.is_empty() {
        wrong.push(format!("it printed: {message}"));
    }
    wrong
}

/// Runs `text` as a case file and expects a refusal that says all of `says`.
fn refused(text: &[u8], arguments: &[&str], says: &[&str]) -> Vec<String> {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let (case, out) = (folder.path().join("small.toml"), folder.path().join("out"));
    fs::write(&case, text).expect("the scratch folder takes a file");
    shortcomings(&mics(&case, &out, arguments), &out, says)
}

/// Faults of the refusal of a text as it is read, without a process of its own; a text that reads
/// well is run.
fn refused_as_read(text: &str, says: &[&str]) -> Vec<String> {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let case = folder.path().join("small.toml");
    fs::write(&case, text).expect("the scratch folder takes a file");
    let Err(error) = load(&case, &[]) else { return refused(text.as_bytes(), &[], says) };
    let message = error.to_string();
    let lacks = says.iter().filter(|part| !message.contains(**part));
    let lacks = lacks.map(|part| format!("does not say `{part}`: {message}"));
    let status = (error.exit_code() != 2).then(|| format!("exit status {}", error.exit_code()));
    lacks.chain(status).collect()
}

/// Fails with every shortcoming of every row, so that one run shows all.
pub fn expect_none(shortcomings: impl IntoIterator<Item = (String, Vec<String>)>) {
    let failed = shortcomings.into_iter().filter(|(_, wrong)| !wrong.is_empty());
    let report: Vec<_> =
        failed.map(|(row, wrong)| format!("{row}\n    {}", wrong.join("\n    "))).collect();
    assert!(report.is_empty(), "{} rows fall short:\n{}", report.len(), report.join("\n"));
}

#[test]
fn base_case_of_bad_input_tests_is_valid() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let case = folder.path().join("small.toml");
    fs::write(&case, GOOD).expect("the scratch folder takes a file");
    let output = mics_command().arg("check").arg(case).output().expect("the binary runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn bad_case_message_has_file_line_key_and_cure() {
    expect_none(BAD_KEYS.iter().chain(BAD_BODIES).map(|(from, to, line, key, says)| {
        assert!(GOOD.contains(from), "the good case has no `{from}`");
        let text = GOOD.replacen(from, to, 1);
        // The line that is meant is the last one that begins so up to the end of the replacement,
        // else the first.
        let changed = text[..GOOD.find(from).unwrap_or(0) + to.len()].lines().count();
        let begins_so = |(_, text): &(usize, &str)| !line.is_empty() && text.starts_with(line);
        let up_to_change = text.lines().enumerate().take(changed).filter(begins_so).last();
        let place = match up_to_change.or_else(|| text.lines().enumerate().find(begins_so)) {
            Some((index, _)) => format!("small.toml:{}: ", index + 1),
            None => "small.toml: ".into(),
        };
        let mut all = vec![place.as_str(), key];
        all.extend(*says);
        (format!("`{from}` -> `{to}`"), refused_as_read(&text, &all))
    }));
}

#[test]
fn bad_override_message_has_the_right_form() {
    let row = |(given, says): &(&str, &[&str])| {
        (given.to_string(), refused(GOOD.as_bytes(), &["--set", given], says))
    };
    expect_none(BAD_OVERRIDES.iter().map(row));
}

#[test]
fn contradiction_with_preset_is_refused_at_its_line() {
    let text = GOOD
        .replacen('\n', "\npreset = \"mics-2003\"\n", 1)
        .replace("cfl = 0.4", "scheme = \"rk2\"");
    let says = ["small.toml:2: time.advection", "qsi is a one-step scheme", "(given by preset)"];
    expect_none([("rk2 with the preset".into(), refused(text.as_bytes(), &[], &says))]);
}

#[test]
fn bad_particle_csv_message_has_file_line_and_column() {
    let row = |csv: &str, says: &[&str]| {
        let folder = tempfile::tempdir().expect("a scratch folder");
        let (case, out) = (folder.path().join("small.toml"), folder.path().join("out"));
        let text = GOOD.replace("[time]", "[[swarm]]\nfrom = \"gravel.csv\"\n[time]");
        fs::write(&case, text).expect("the scratch folder takes a file");
        fs::write(folder.path().join("gravel.csv"), csv).expect("the scratch folder takes a file");
        let all = [&["small.toml:28: swarm.0.from: "], says].concat();
        (csv.to_owned(), shortcomings(&mics(&case, &out, &[]), &out, &all))
    };
    expect_none([
        row(
            "x,y,diamter\n1.7,0.2,0.1\n",
            &["gravel.csv:1", "`diamter`", "x, y, diameter, density, vx, vy, spin"],
        ),
        row("x,y\n1.7,0.2\n", &["gravel.csv:1", "`diameter` is missing", "x, y and diameter"]),
        row("x,y,y,diameter\n1.7,0.2,0.2,0.1\n", &["gravel.csv:1", "`y`", "twice"]),
        row(
            "x,y,diameter\n1.7,0.2,0.1\n1.7,high,0.1\n",
            &["gravel.csv:3", "`y`", "finite number", "\"high\""],
        ),
        row("x,y,diameter\n1.7,0.2,-0.1\n", &["gravel.csv:2", "`diameter`", "positive (m)"]),
        row("x,y,diameter\n1.7,0.2\n", &["gravel.csv:2", "has 2 columns, and the header 3"]),
        row("x,y,diameter\n1.99,0.2,0.1\n", &["gravel.csv:2", "along x", "outside the domain"]),
        row(
            "x,y,diameter\n1.8,0.9,0.1\n1.8,0.2,0.1\n1.75,0.2,0.1\n",
            &["gravel.csv:4", "that of line 3"],
        ),
        row("x,y,diameter\n1.2,0.5,0.1\n", &["gravel.csv:2", "overlaps particle 1"]),
        row("x,y,diameter\n", &["gravel.csv", "lists no particles"]),
    ]);
}

#[test]
fn case_file_that_is_not_utf8_is_refused() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let out = folder.path().join("out");
    let absent = folder.path().join("absent.toml");
    let latin1 = GOOD.replace("small", "sm\u{e5}ll").chars().map(|c| c as u8).collect::<Vec<_>>();
    expect_none([
        (
            "absent".into(),
            shortcomings(&mics(&absent, &out, &[]), &out, &["absent.toml", "no such file"]),
        ),
        (
            "a directory".into(),
            shortcomings(
                &mics(folder.path(), &out, &[]),
                &out,
                &["directory", "name the case file"],
            ),
        ),
        ("not UTF-8".into(), refused(&latin1, &[], &["small.toml:1", "UTF-8"])),
    ]);
}

#[test]
fn force_replaces_only_a_run_folder() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let (case, out) = (folder.path().join("small.toml"), folder.path().join("out"));
    fs::write(&case, GOOD).expect("the scratch folder takes a file");
    let short = [
        "--quiet",
        "--set",
        "time.end=0.02",
        "--set",
        "output.figures=false",
        "--set",
        "measure=[]",
    ];
    assert!(mics(&case, &out, &short).status.success());
    let (notes, stale) = (out.join("fields/notes.txt"), out.join("fields/99999999.vti"));
    fs::write(&notes, "mine").expect("the folder takes a file");
    fs::write(&stale, "old").expect("the folder takes a file");
    // Its own case would be deleted under it.
    let inside = mics(&out.join("case.toml"), &out, &["--force"]);
    let message = String::from_utf8_lossy(&inside.stderr);
    assert!(
        inside.status.code() == Some(2) && message.contains("would delete the case file"),
        "{message}"
    );
    assert!(mics(&case, &out, &[&short[..], &["--force"]].concat()).status.success());
    assert_eq!(fs::read_to_string(&notes).expect("it is still there"), "mine");
    assert!(!stale.exists(), "a field of the run before");
    // A folder with a case in it is not a run.
    let own = folder.path().join("own");
    fs::create_dir(&own).expect("the scratch folder takes a folder");
    fs::write(own.join("case.toml"), GOOD).expect("the folder takes a file");
    let refused = mics(&case, &own, &["--force"]);
    let message = String::from_utf8_lossy(&refused.stderr);
    assert!(refused.status.code() == Some(2) && message.contains("holds no run"), "{message}");
    assert_eq!(fs::read_to_string(own.join("case.toml")).expect("it is still there"), GOOD);
}

#[test]
fn impossible_petsc_option_is_refused_by_name() {
    let row = |options: &[&str], says: &[&str]| {
        (options.join(" "), refused(GOOD.as_bytes(), &[&["--"], options].concat(), says))
    };
    expect_none([
        row(&["-ksp_type", "nonsense"], &["nonsense"]),
        row(&["-pc_type", "nonsense"], &["nonsense"]),
        row(&["-pc_type", "lu", "-pc_factor_mat_solver_type", "nonsense"], &["nonsense"]),
        row(&["-options_file", "/nowhere/at/all"], &["/nowhere/at/all"]),
        row(&["-ksp_rtol", "small"], &["-ksp_rtol", "\"small\"", "not a tolerance"]),
        row(&["-ksp_rtol", "1.0"], &["-ksp_rtol", "no reduction", "1e-8"]),
        row(&["ksp_type", "cg"], &["\"ksp_type\"", "begin with a dash"]),
        row(&["-ksp_type", "cg", "pc_type", "gamg"], &["\"pc_type\"", "begin with a dash"]),
    ]);
}
