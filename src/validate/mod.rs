//! `mics validate`: the shipped cases beside their references, value for value.

mod page;

use crate::petsc::Session;
use crate::run;
use crate::{Error, Result};
use mics_run::compare::{Comparison, measured, percent};
use mics_run::print;
use mics_run::published::cylinder_reference;
use mics_run::summary::Summary;
use page::Page;
use std::fs;
use std::path::{Path, PathBuf};

/// A shipped case, as it is compiled into the program, and how it is run.
struct Row {
    name: String,
    text: &'static str,
    set: Vec<String>,
    quick: bool,
}

/// What stands in a folder that may be written over, and its text.
const MARK: &str = "validate.txt";
const MARKED: &str = "The runs in this folder are those of `mics validate`, which replaces them.\n";

macro_rules! shipped {
    ($path:literal) => {
        include_str!(concat!("../../cases/", $path))
    };
}

/// What `mics validate` is asked for.
#[derive(Clone, Debug)]
pub struct Request {
    /// How the names of the cases begin; none: the short ones, or all.
    pub names: Vec<String>,
    /// All cases.
    pub full: bool,
    /// Overrides of every case, `KEY=VALUE`.
    pub set: Vec<String>,
    /// Where the runs go.
    pub out: PathBuf,
    /// Whether it prints a page of Markdown.
    pub markdown: bool,
    /// The page that it compares its values with.
    pub compare: Option<PathBuf>,
    /// PETSc's options.
    pub petsc: Vec<String>,
    /// Draws the figures of a run.
    pub draw: run::Draw,
    /// The git commit that the program was built from.
    pub commit: &'static str,
}

/// What has been found so far.
#[derive(Default)]
struct Found {
    pass: usize,
    short: usize,
    /// Cases whose runs failed.
    failed: Vec<String>,
    /// What has moved from the page, in words.
    moved: Vec<String>,
    /// Case, measure and where its reference is from.
    sources: Vec<(String, String, String)>,
}

/// Runs the shipped cases that have references, each into a folder of the request's, and prints
/// their measures beside the references: the short ones, all, or those whose names begin so.
/// Collective; rank 0 prints.
///
/// # Errors
/// When a name is unknown, a run fails, or measures fall short of their references or have moved
/// from the page they are compared with: [`Error::Short`], after all have been run.
pub fn validate(request: &Request) -> Result<()> {
    let Request { names, full, set, out, markdown, compare, petsc, draw, commit } = request;
    let mut rows = chosen(names, *full)?;
    rows.iter_mut().for_each(|row| row.set.extend_from_slice(set));
    let page = compare.as_deref().map(Page::read).transpose()?;
    let session = Session::start(petsc)?;
    let lead = session.rank() == 0;
    let say = |line: &str| if lead { print(line) } else { Ok(()) };
    let cure = |e| {
        Error::Usage(format!(
            "{}: cannot be made ({e}); give another folder with --out",
            out.display()
        ))
    };
    session.agree(if lead {
        may_use(out).and_then(|()| fs::create_dir_all(out).map_err(cure))
    } else {
        Ok(())
    })?;
    let mark = out.join(MARK);
    session.agree(if lead {
        fs::write(&mark, MARKED).map_err(Error::io(&mark))
    } else {
        Ok(())
    })?;
    if *markdown {
        say(&page::head(*full, names, commit))?;
    } else {
        say(&columns(["case", "measure", "value", "reference", "error", "tolerance", "", "s"]))?;
        say(&columns(
            WIDTHS.map(|width| "-".repeat(width.unsigned_abs())).each_ref().map(String::as_str),
        ))?;
    }
    let mut found = Found::default();
    for row in rows {
        match measure(&session, &row, out, petsc, *draw, commit) {
            Ok(summary) => {
                for (name, c) in summary.comparisons() {
                    let written = if *markdown { page::row } else { line };
                    say(&written(&row.name, &name, &c, &summary))?;
                    *(if c.pass { &mut found.pass } else { &mut found.short }) += 1;
                    found
                        .moved
                        .extend(page.as_ref().and_then(|page| page.moved(&row.name, &name, &c)));
                    found.sources.extend(c.source.map(|source| (row.name.clone(), name, source)));
                }
            }
            Err(Error::Interrupted(_)) => {
                let again = format!(
                    "interrupted; `mics validate {:?}` and what comes after it remain",
                    row.name
                );
                return Err(Error::Interrupted(again));
            }
            Err(e) => {
                say(&format!("| {:<28} | the run failed: {e} |", row.name))?;
                found.failed.push(row.name);
            }
        }
    }
    if *markdown {
        say(&page::tail(found.pass, found.short, &found.sources))?;
    }
    let end = conclude(&found, page.as_ref())?;
    if *markdown { Ok(()) } else { say(&format!("\n{end}")) }
}

/// Whether a folder is there for `mics validate`: new, empty or its own.
fn may_use(out: &Path) -> Result<()> {
    let empty = fs::read_dir(out).map_or(true, |mut entries| entries.next().is_none());
    if empty || out.join(MARK).exists() {
        return Ok(());
    }
    let why = "holds something that `mics validate` did not write; give another folder with --out";
    Err(Error::Usage(format!("{}: {why}", out.display())))
}

/// The last line, or the failure that it is.
fn conclude(found: &Found, page: Option<&Page>) -> Result<String> {
    let Found { pass, short, failed, moved, .. } = found;
    let counts = format!("{pass} of {} values pass", pass + short);
    match (page, short) {
        _ if !failed.is_empty() => {
            Err(Error::Run(format!("{counts}; runs that failed: {}", failed.join(", "))))
        }
        (Some(page), _) if moved.is_empty() => {
            Ok(format!("{counts}; all are as {} has them", page.file.display()))
        }
        (Some(page), _) => {
            let (count, list) = (moved.len(), moved.join("\n  "));
            Err(Error::Short(format!(
                "{counts}; {count} are not as {} has them:\n  {list}",
                page.file.display()
            )))
        }
        (None, 0) => Ok(counts),
        (None, short) => {
            Err(Error::Short(format!("{counts}, {short} fall short of their references")))
        }
    }
}

/// The rows of some names, or of all cases, or the short ones.
fn chosen(names: &[String], full: bool) -> Result<Vec<Row>> {
    let mut rows = shipped();
    if let Some(unknown) =
        names.iter().find(|name| !rows.iter().any(|row| row.name.starts_with(*name)))
    {
        let known =
            rows.iter().map(|row| format!("\"{}\"", row.name)).collect::<Vec<_>>().join(", ");
        return Err(Error::Usage(format!(
            "no case begins with \"{unknown}\"; known here: {known}"
        )));
    }
    rows.retain(|row| match names {
        [] => full || row.quick,
        names => names.iter().any(|name| row.name.starts_with(name)),
    });
    Ok(rows)
}

/// Runs one case and returns its summary (an empty one on other ranks than the first).
fn measure(
    session: &Session,
    row: &Row,
    out: &Path,
    petsc: &[String],
    draw: run::Draw,
    commit: &'static str,
) -> Result<Summary> {
    let stem: String =
        row.name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
    let (case, folder) = (out.join(format!("{stem}.toml")), out.join(&stem));
    let lead = session.rank() == 0;
    session.agree(if lead {
        fs::write(&case, row.text).map_err(Error::io(&case))
    } else {
        Ok(())
    })?;
    let request = run::Request {
        case,
        out: Some(folder.clone()),
        set: row.set.clone(),
        force: true,
        resume: false,
        quiet: true,
        petsc: petsc.to_vec(),
        draw,
        commit,
    };
    run::run(&request)?;
    session.agree(if lead { Summary::read(&folder) } else { Ok(Summary::default()) })
}

/// Widths of the table's columns, negative where text stands on the left.
const WIDTHS: [isize; 8] = [-28, -16, 9, 16, 19, 9, -11, 5];

fn columns(cells: [&str; 8]) -> String {
    let cell = |(text, width): (&str, isize)| match width.unsigned_abs() {
        n if width < 0 => format!(" {text:<n$} |"),
        n => format!(" {text:>n$} |"),
    };
    "|".to_owned() + &cells.into_iter().zip(WIDTHS).map(cell).collect::<String>()
}

fn line(case: &str, name: &str, c: &Comparison, run: &Summary) -> String {
    let value = c.value.map_or("none".into(), measured);
    let error = c.difference().unwrap_or_default();
    let (reference, tolerance) = (c.reference.to_string(), percent(c.tolerance));
    columns([
        case,
        name,
        &value,
        &reference,
        &error,
        &tolerance,
        c.verdict(),
        &format!("{:.0}", run.wall_seconds),
    ])
}

/// The cases with references, in the order in which they are run: the short ones of `--quick`
/// first.
fn shipped() -> Vec<Row> {
    let row = |name: &str, text: &'static str, set: &[&str], quick: bool| Row {
        name: name.into(),
        text,
        set: set.iter().map(|given| given.to_string()).collect(),
        quick,
    };
    let wake = shipped!("cylinder-wake/case.toml");
    let settling = shipped!("settling-disc/case.toml");
    let (sphere, let_go) =
        (shipped!("settling-sphere/case.toml"), shipped!("sphere-let-go/case.toml"));
    let mut rows = vec![
        row("lid-driven-cavity", shipped!("lid-driven-cavity/case.toml"), &[], true),
        row("cylinder-wake Re 100", wake, &[], true),
        row("settling-disc N 8", settling, &[], true),
        row(
            "neutral-disc-in-couette slow",
            shipped!("neutral-disc-in-couette/slow.toml"),
            &[],
            true,
        ),
        row(
            "drafting-kissing-tumbling",
            shipped!("drafting-kissing-tumbling/case.toml"),
            &[],
            true,
        ),
        row("sphere-let-go s 1.5", let_go, &[], true),
        row("poiseuille", shipped!("poiseuille/case.toml"), &[], true),
        row("open-channel", shipped!("open-channel/case.toml"), &[], true),
        row("sphere-array phi 0.125", shipped!("sphere-array/case.toml"), &[], true),
        row("taylor-green", shipped!("taylor-green/case.toml"), &[], false),
        row("sheared-bed A1", shipped!("sheared-bed/case.toml"), &[], false),
        row("random-array phi 0.2", shipped!("random-array/case.toml"), &[], false),
        row("poiseuille-duct", shipped!("poiseuille/duct.toml"), &[], false),
        row("neutral-disc-in-couette", shipped!("neutral-disc-in-couette/case.toml"), &[], false),
        row("channel-cylinder 2D-1", shipped!("channel-cylinder/steady.toml"), &[], false),
        row("channel-cylinder 2D-2", shipped!("channel-cylinder/case.toml"), &[], false),
        row("oscillating-cylinder", shipped!("oscillating-cylinder/case.toml"), &[], false),
        row(
            "settling-disc N 16",
            settling,
            &["domain.cells=[128,384]", "measure.0.tolerance=0.01"],
            false,
        ),
        row("settling-disc heavier", shipped!("settling-disc/heavier.toml"), &[], false),
        row("approach", shipped!("approach/case.toml"), &[], false),
        row("settling-sphere Re 11.6", sphere, &[], false),
        row("sphere-in-couette", shipped!("sphere-in-couette/case.toml"), &[], false),
        row("sphere-stream unbounded", shipped!("sphere-stream/unbounded.toml"), &[], false),
    ];
    // Density (kg/m3) and viscosity (Pa s) of the oils, time to run for (s) and speed measured
    // (m/s): settling_sphere.csv.
    let oils = [
        ("1.5", 970.0, 0.373, 2.0, 0.03599),
        ("4.1", 965.0, 0.212, 1.65, 0.05718),
        ("31.9", 960.0, 0.058, 1.0, 0.12224),
    ];
    rows.extend(oils.map(|(re, density, viscosity, end, speed)| {
        let set = [
            format!("fluid.density={density:?}"),
            format!("fluid.viscosity={viscosity:?}"),
            format!("time.end={end:?}"),
            format!("measure.0.reference={speed:?}"),
        ];
        Row {
            name: format!("settling-sphere Re {re}"),
            text: sphere,
            set: set.into(),
            quick: false,
        }
    }));
    let mut light = vec![
        "particle.0.density=1.0".to_owned(),
        "time.step=0.0007".into(),
        "time.end=0.01414".into(),
    ];
    for (k, (time, speed)) in
        [(0.0007, 0.013644), (0.007, 0.13539), (0.014, 0.26953)].into_iter().enumerate()
    {
        light.push(format!("measure.{k}.when.time={time:?}"));
        light.push(format!("measure.{k}.reference={speed:?}"));
        light.push(format!("measure.{k}.tolerance=0.05"));
    }
    rows.push(Row { name: "sphere-let-go s 0.001".into(), text: let_go, set: light, quick: false });
    let others = cylinder_reference("cd").into_iter().filter(|(re, _)| *re != 100.0);
    rows.extend(others.map(|(re, cd)| {
        let column =
            |name: &str| cylinder_reference(name).into_iter().find(|r| r.0 == re).map(|r| r.1);
        let (end, from) = if re < 50.0 { (25.0, 24.0) } else { (40.0, 20.0) };
        let mut set =
            vec![format!("fluid.viscosity={:?}", 200.0 / re), format!("time.end={end:?}")];
        // A steady wake has no frequency, and a lift of 0 is no reference.
        let references = [Some(cd), column("st"), column("cl_amplitude").filter(|v| *v > 0.0)];
        for (k, reference) in references.into_iter().enumerate() {
            set.push(format!("measure.{k}.from={from:?}"));
            set.extend(reference.map(|v| format!("measure.{k}.reference={v:?}")));
        }
        Row { name: format!("cylinder-wake Re {re}"), text: wake, set, quick: re == 20.0 }
    }));
    rows.sort_by_key(|row| !row.quick);
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::load;

    #[test]
    fn one_value_that_falls_short_makes_the_status_1_and_a_run_that_fails_3() {
        let found = |short, failed: &[&str]| Found {
            pass: 4,
            short,
            failed: failed.iter().map(|name| name.to_string()).collect(),
            ..Found::default()
        };
        assert_eq!(conclude(&found(0, &[]), None).unwrap(), "4 of 4 values pass");
        assert_eq!(conclude(&found(1, &[]), None).unwrap_err().exit_code(), 1);
        assert_eq!(conclude(&found(1, &["crowd"]), None).unwrap_err().exit_code(), 3);
    }

    #[test]
    fn cases_are_chosen_by_how_their_names_begin() {
        let count = |names: &[&str], full| {
            let names: Vec<String> = names.iter().map(|name| name.to_string()).collect();
            chosen(&names, full).map(|rows| rows.len())
        };
        let (quick, all) = (count(&[], false).unwrap(), count(&[], true).unwrap());
        assert!(0 < quick && quick < all && count(&["settling-disc", "cyl"], false).unwrap() > 3);
        assert!(count(&["settling-disc"], true).unwrap() == 3);
        assert!(matches!(
            count(&["nonsense"], false),
            Err(Error::Usage(m)) if m.contains("\"oscillating-cylinder\"")
        ));
    }

    #[test]
    fn every_row_is_a_good_case_with_a_reference_and_its_source() {
        let folder = tempfile::tempdir().unwrap();
        let (case, rows) = (folder.path().join("case.toml"), shipped());
        assert!(rows.iter().any(|row| row.quick) && rows.iter().any(|row| !row.quick));
        for row in rows {
            fs::write(&case, row.text).unwrap();
            let case = load(&case, &row.set).unwrap_or_else(|e| panic!("{}: {e}", row.name)).case;
            let with = case.measure.iter().filter(|m| m.target.is_some());
            assert!(
                with.clone().count() > 0
                    && with.clone().all(|m| m.target.as_ref().is_some_and(|t| t.source.is_some())),
                "{}",
                row.name
            );
        }
    }
}
