//! Refusals of a wrong command line, a wrong folder, a damaged file or too many ranks: exit status
//! 2, one message that says where and what would be right, and nothing written. (Wrong cases are in
//! `bad_input`.)

use crate::bad_input::{GOOD, expect_none, shortcomings};
use crate::support::{command, mics, mpirun, run, shipped};
use std::fs;
use std::path::Path;

/// A row: the words of the command line (those that begin with @ are files of the scratch folder),
/// what the message says.
type Row = (&'static [&'static str], &'static [&'static str]);

#[rustfmt::skip]
const BAD: &[Row] = &[
    // The command line.
    (&["runn", "@case.toml"], &["'runn'", "'run'"]),
    (&["run"], &["<CASE>"]),
    (&["check"], &["<CASE>"]),
    (&["plot"], &["<RUNS>"]),
    (&["report"], &["<RUN>"]),
    (&["run", "@case.toml", "--outt", "@out"], &["'--outt'", "'--out'"]),
    (&["run", "@case.toml", "--out"], &["--out <DIR>"]),
    (&["run", "@case.toml", "--set"], &["--set <KEY=VALUE>"]),
    (&["run", "@case.toml", "@case.toml"], &["unexpected argument", "case.toml"]),
    (&["run", "@case.toml", "--quiet=maybe"], &["--quiet", "maybe"]),
    (&["validate", "--quick", "--full"], &["'--quick'", "'--full'"]),
    (
        &["validate", "nonsense", "--out", "@out"],
        &["no case begins with \"nonsense\"", "`settling-disc N 8`"],
    ),
    (&["validate", "settling", "--out", "@out", "--compare", "@absent.md"], &["absent.md: cannot \
        be read", "--compare"]),
    (
        &["validate", "settling", "--out", "@out", "--compare", "@case.toml"],
        &["case.toml", "`mics validate --markdown`"],
    ),
    (&["completions", "klingon"], &["'klingon'", "bash"]),
    (&["schema", "more"], &["unexpected argument 'more'"]),
    (&["run", "@case.toml", "--out", "@out", "--", "ksp_type"], &["\"ksp_type\"", "begin with a \
        dash"]),
    // Folders.
    (&["run", "@case.toml", "--out", "@case.toml"], &["case.toml", "cannot be used as a run's \
        folder"]),
    (&["run", "@case.toml", "--out", "@case.toml/out"], &["case.toml/out", "cannot be used as a \
        run's folder"]),
    (
        &["run", "@case.toml", "--out", "/proc/no/such"],
        &["/proc/no/such", "cannot be made", "--out"],
    ),
    (&["run", "@case.toml", "--out", "@notes"], &["notes", "which no run wrote", "--out"]),
    (
        &["run", "@case.toml", "--out", "@notes", "--force"],
        &["notes", "which no run wrote", "--out"],
    ),
    (&["validate", "settling", "--out", "@case.toml"], &["case.toml", "cannot be made", "--out"]),
    (&["check", "@notes"], &["notes", "a directory", "name the case file in it"]),
    (&["check", "@absent.toml"], &["absent.toml", "no such file"]),
    (&["plot", "@absent"], &["absent: not a run's folder", "`mics run`"]),
    (&["plot", "@notes"], &["notes: not a run's folder", "case.toml", "`mics run`"]),
    (&["film"], &["<RUN>"]),
    (&["film", "@absent"], &["absent: not a run's folder", "`mics run`"]),
    (&["film", "@notes"], &["notes: not a run's folder", "case.toml", "`mics run`"]),
    (&["film", "@run", "--out", "@notes"], &["notes: is a folder", "--out film.png"]),
    (&["film", "@run-fields"], &[".vti", "not a snapshot that mics wrote"]),
    (&["film", "@run-no-fields"], &["no snapshot", "a film needs two", "output.fields = \
        { every_time = "]),
    (&["report", "@absent"], &["absent: not a run's folder", "run.json", "`mics run`"]),
    (&["report", "@notes"], &["notes: not a run's folder", "run.json", "`mics run`"]),
    (&["report", "@run", "--out", "@notes"], &["notes: is a folder", "--out report.html"]),
    // Damaged files of a run.
    (&["report", "@run-json"], &["run-json: not a run's folder", "run.json: EOF while parsing"]),
    (&["report", "@run-case"], &["run-case: not a run's folder", "case.toml", "`mics run`"]),
    (&["report", "@run-fields"], &[".vti", "not a snapshot that mics wrote"]),
    (&["plot", "@run-fields"], &[".vti", "not a snapshot that mics wrote"]),
    (&["plot", "@run-no-fields"], &["run-no-fields: not a run's folder", "no snapshot"]),
];

/// A scratch folder with a case, a folder that no run wrote, a run, and runs that are damaged in
/// one way each.
fn scratch() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("case.toml"), GOOD).unwrap();
    fs::create_dir(at("notes")).unwrap();
    fs::write(at("notes/mine.txt"), "mine").unwrap();
    run(&at("case.toml"), &at("run"), &["--set", "time.end=0.02", "--set", "output.figures=false"]);
    let damage = |name: &str, file: &str, how: &dyn Fn(&Path)| {
        copy(&at("run"), &at(name));
        how(&at(name).join(file));
    };
    let delete = |path: &Path| fs::remove_file(path).unwrap();
    damage("run-json", "run.json", &|path| fs::write(path, "{\"version\": ").unwrap());
    damage("run-case", "case.toml", &delete);
    damage("run-fields", "fields", &|path| {
        for file in fs::read_dir(path)
            .unwrap()
            .map(|e| e.unwrap().path())
            .filter(|p| p.extension().unwrap() == "vti")
        {
            let bytes = fs::read(&file).unwrap();
            fs::write(&file, &bytes[..bytes.len() / 2]).unwrap();
        }
    });
    damage("run-no-fields", "fields", &|path| {
        fs::remove_dir_all(path).unwrap();
        fs::create_dir(path).unwrap();
    });
    folder
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir(to).unwrap();
    for entry in fs::read_dir(from).unwrap().map(Result::unwrap) {
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &target);
        } else {
            fs::copy(entry.path(), target).unwrap();
        }
    }
}

/// Every file of a folder with its size.
fn listing(folder: &Path) -> Vec<(std::path::PathBuf, u64)> {
    let mut all = Vec::new();
    for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
        let size = entry.metadata().unwrap().len();
        if entry.path().is_dir() {
            all.extend(listing(&entry.path()))
        } else {
            all.push((entry.path(), size))
        }
    }
    all.sort();
    all
}

#[test]
fn bad_command_line_folder_or_file_is_refused() {
    let folder = scratch();
    let before = listing(folder.path());
    expect_none(BAD.iter().map(|(words, says)| {
        let full: Vec<String> = words
            .iter()
            .map(|word| {
                word.strip_prefix('@')
                    .map_or(word.to_string(), |name| format!("{}/{name}", folder.path().display()))
            })
            .collect();
        let output = mics(&full.iter().map(String::as_str).collect::<Vec<_>>());
        let mut wrong = shortcomings(&output, &folder.path().join("out"), says);
        if listing(folder.path()) != before {
            wrong.push("files were written or changed".into());
        }
        (words.join(" "), wrong)
    }));
}

#[test]
fn too_many_ranks_and_bad_cases_are_refused_with_one_message() {
    let folder = tempfile::tempdir().unwrap();
    let (case, out) = (folder.path().join("small.toml"), folder.path().join("out"));
    fs::write(&case, GOOD).unwrap();
    let row = |ranks: usize, words: &[&str], says: &[&str]| {
        let mut command = mpirun(ranks, env!("CARGO_BIN_EXE_mics"));
        let output =
            command.arg("run").arg(&case).arg("--out").arg(&out).args(words).output().unwrap();
        (format!("{ranks} ranks {words:?}"), shortcomings(&output, &out, says))
    };
    expect_none([
        row(
            2,
            &["--set", "fluid.viscosity=-1"],
            &["small.toml", "fluid.viscosity", "zero or positive"],
        ),
        row(2, &["--outt"], &["'--outt'"]),
        row(2, &["--", "-ksp_type", "nonsense"], &["nonsense"]),
        row(
            9,
            &["--set", "domain.cells=[8,8]", "--set", "particle=[]", "--set", "measure=[]"],
            &["9 ranks are too many", "fewer ranks"],
        ),
        // Three leave some of them with enough cells and some without.
        row(
            3,
            &["--set", "domain.cells=[8,8]", "--set", "particle=[]", "--set", "measure=[]"],
            &["3 ranks are too many", "fewer ranks"],
        ),
    ]);
}

/// Nothing of a scene at rest is solved before the first step.
#[test]
fn bad_petsc_options_are_refused_for_scene_at_rest() {
    let case = shipped("cases/settling-disc/case.toml");
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let row = |ranks: usize, options: &[&str], says: &[&str]| {
        let words =
            ["run".as_ref(), case.as_os_str(), "--out".as_ref(), out.as_os_str(), "--".as_ref()];
        let output = match ranks {
            1 => command(env!("CARGO_BIN_EXE_mics")).args(words).args(options).output(),
            _ => mpirun(ranks, env!("CARGO_BIN_EXE_mics")).args(words).args(options).output(),
        };
        let output = output.unwrap();
        (format!("{ranks} ranks {options:?}"), shortcomings(&output, &out, says))
    };
    expect_none([
        row(1, &["-pc_boxmg_smooth", "0"], &["-pc_boxmg_smooth", "\"0\"", "from 1 to 20"]),
        row(1, &["-pc_boxmg_cycle", "f"], &["-pc_boxmg_cycle", "\"f\"", "neither v nor w"]),
        row(1, &["-ksp_type", "preonly", "-pc_type", "lu"], &["preonly", "use cg, bcgs or gmres"]),
    ]);
}
