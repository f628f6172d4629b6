//! `mics validate`: the shipped cases beside their references, value for value.

use crate::output::compare::{Comparison, percent, signed_percent};
use crate::output::plot::cylinder_reference;
use crate::output::print;
use crate::output::summary::Summary;
use crate::petsc::Session;
use crate::run::{self, Request};
use crate::{Error, Result};
use std::fs;
use std::path::Path;

/// A shipped case, as it is compiled into the program, and how it is run.
struct Row {
    name: String,
    text: &'static str,
    set: Vec<String>,
    quick: bool,
}

macro_rules! shipped {
    ($path:literal) => {
        include_str!(concat!("../cases/", $path))
    };
}

/// Runs the shipped cases that have references, the short ones or all, each into a folder in `out`, and prints their
/// measures beside the references. Collective; rank 0 prints.
///
/// # Errors
/// When a run fails, or its measures fall short of a reference: [`Error::Short`], after all have been run.
pub fn validate(full: bool, out: &Path, petsc: &[String]) -> Result<()> {
    let session = Session::start(petsc)?;
    let lead = session.rank() == 0;
    let say = |line: &str| if lead { print(line) } else { Ok(()) };
    session.agree(if lead { fs::create_dir_all(out).map_err(Error::io(out)) } else { Ok(()) })?;
    say(&format!(
        "| {:<28} | {:<16} | {:>9} | {:>16} | {:>9} | {:>9} | {:<11} | {:>5} |",
        "case", "measure", "value", "reference", "error", "tolerance", "", "s"
    ))?;
    say(&format!("|{}|", [30, 18, 11, 18, 11, 11, 13, 7].map(|n| "-".repeat(n)).join("|")))?;
    let (mut rows, mut short, mut failed) = (0, 0, Vec::new());
    for row in shipped().into_iter().filter(|row| full || row.quick) {
        match measure(&session, &row, out, petsc) {
            Ok(summary) => {
                for (name, c) in summary.comparisons() {
                    say(&line(&row.name, &name, &c, summary.wall_seconds))?;
                    rows += 1;
                    short += usize::from(!c.pass);
                }
            }
            Err(e) => {
                say(&format!("| {:<28} | the run failed: {e} |", row.name))?;
                failed.push(row.name);
            }
        }
    }
    say("")?;
    let pass = format!("{} of {rows} values pass", rows - short);
    if !failed.is_empty() {
        return Err(Error::Run(format!("{pass}; runs that failed: {}", failed.join(", "))));
    }
    if short > 0 {
        return Err(Error::Short(format!("{pass}, {short} fall short; the runs are in {}", out.display())));
    }
    say(&format!("{pass}; the runs are in {}", out.display()))
}

/// Runs one case and returns its summary (an empty one on other ranks than the first).
fn measure(session: &Session, row: &Row, out: &Path, petsc: &[String]) -> Result<Summary> {
    let stem: String = row.name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
    let (case, folder) = (out.join(format!("{stem}.toml")), out.join(&stem));
    let lead = session.rank() == 0;
    session.agree(if lead { fs::write(&case, row.text).map_err(Error::io(&case)) } else { Ok(()) })?;
    let request = Request {
        case,
        out: Some(folder.clone()),
        set: row.set.clone(),
        force: true,
        quiet: true,
        petsc: petsc.to_vec(),
        ..Request::default()
    };
    run::run(&request)?;
    session.agree(if lead { Summary::read(&folder) } else { Ok(Summary::default()) })
}

fn line(case: &str, name: &str, c: &Comparison, seconds: f64) -> String {
    let value = c.value.map_or("none".into(), |v| format!("{v:.5}"));
    let error = c.error.map_or(String::new(), signed_percent);
    format!(
        "| {case:<28} | {name:<16} | {value:>9} | {:>16} | {error:>9} | {:>9} | {:<11} | {seconds:>5.0} |",
        c.reference.to_string(),
        percent(c.tolerance),
        c.verdict()
    )
}

/// The cases with references, in the order in which they are run: the short ones of `--quick` first.
fn shipped() -> Vec<Row> {
    let row = |name: &str, text: &'static str, set: &[&str], quick: bool| Row {
        name: name.into(),
        text,
        set: set.iter().map(|given| given.to_string()).collect(),
        quick,
    };
    let wake = shipped!("cylinder-wake/case.toml");
    let settling = shipped!("settling-disc/case.toml");
    let mut rows = vec![
        row("lid-driven-cavity", shipped!("lid-driven-cavity/case.toml"), &[], true),
        row("cylinder-wake Re 100", wake, &[], true),
        row("settling-disc N 8", settling, &[], true),
        row("neutral-disc-in-couette slow", shipped!("neutral-disc-in-couette/slow.toml"), &[], true),
        row("drafting-kissing-tumbling", shipped!("drafting-kissing-tumbling/case.toml"), &[], true),
        row("neutral-disc-in-couette", shipped!("neutral-disc-in-couette/case.toml"), &[], false),
        row("channel-cylinder 2D-1", shipped!("channel-cylinder/steady.toml"), &[], false),
        row("channel-cylinder 2D-2", shipped!("channel-cylinder/case.toml"), &[], false),
        row("oscillating-cylinder", shipped!("oscillating-cylinder/case.toml"), &[], false),
        row("settling-disc N 16", settling, &["domain.cells=[128,384]", "measure.0.tolerance=0.01"], false),
        row("settling-disc heavier", shipped!("settling-disc/heavier.toml"), &[], false),
    ];
    let others = cylinder_reference("cd").into_iter().filter(|(re, _)| *re != 100.0);
    rows.extend(others.map(|(re, cd)| {
        let column = |name: &str| cylinder_reference(name).into_iter().find(|r| r.0 == re).map(|r| r.1);
        let (end, from) = if re < 50.0 { (25.0, 24.0) } else { (40.0, 20.0) };
        let mut set = vec![format!("fluid.viscosity={:?}", 200.0 / re), format!("time.end={end:?}")];
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
    use crate::case::load;

    #[test]
    fn every_row_is_a_good_case_with_a_reference_and_its_source() {
        let folder = tempfile::tempdir().unwrap();
        let (case, rows) = (folder.path().join("case.toml"), shipped());
        assert!(rows.iter().any(|row| row.quick) && rows.iter().any(|row| !row.quick));
        for row in rows {
            fs::write(&case, row.text).unwrap();
            let case = load(&case, &row.set).unwrap_or_else(|e| panic!("{}: {e}", row.name)).case;
            let with = case.measure.iter().filter(|m| m.reference.is_some());
            assert!(with.clone().count() > 0 && with.clone().all(|m| m.source.is_some()), "{}", row.name);
        }
    }
}
