//! `mics validate`: the shipped cases beside their references, value for value.

mod page;
mod shipped;

use crate::petsc::Session;
use crate::run;
use crate::{Error, Result};
use mics_run::compare::{Comparison, measured, percent};
use mics_run::print;
use mics_run::summary::Summary;
use page::Page;
use shipped::{Row, shipped};
use std::fs;
use std::path::{Path, PathBuf};

/// File that marks a folder that may be written over, and its text.
const MARK: &str = "validate.txt";
const MARKED: &str = "The runs in this folder are those of `mics validate`, which replaces them.\n";

/// Request to `mics validate`.
#[derive(Clone, Debug)]
pub struct Request {
    /// Beginnings of the names of the cases; none: the short ones, or all.
    pub names: Vec<String>,
    /// All cases.
    pub full: bool,
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

/// Results so far.
#[derive(Default)]
struct Found {
    pass: usize,
    short: usize,
    /// Cases whose runs failed.
    failed: Vec<String>,
    /// Messages about values that have moved from the page.
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
    let Request { names, full, out, markdown, compare, petsc, draw, commit } = request;
    let rows = chosen(names, *full)?;
    let page = compare.as_deref().map(Page::read).transpose()?;
    let session = Session::start(petsc)?;
    let lead = session.rank() == 0;
    let say = |line: &str| if lead { print(line) } else { Ok(()) };
    session.agree(if lead { prepare(out) } else { Ok(()) })?;
    if *markdown {
        say(&page::head(*full, names, commit))?;
    } else {
        say(&columns(["case", "measure", "value", "reference", "error", "tolerance", "", "s"]))?;
        let rules = WIDTHS.map(|width| "-".repeat(width.unsigned_abs()));
        say(&columns(rules.each_ref().map(String::as_str)))?;
    }
    let mut found = Found::default();
    for row in rows {
        match measure(&session, &row, out, petsc, *draw, commit) {
            Ok(summary) => {
                for (name, c) in summary.comparisons() {
                    let written = if *markdown { page::row } else { line };
                    say(&written(&row.name, &name, &c, &summary))?;
                    found.take(&row.name, name, c, page.as_ref());
                }
            }
            Err(Error::Interrupted(_)) => {
                return Err(Error::Interrupted(format!(
                    "interrupted; `mics validate {:?}` and what comes after it remain",
                    row.name
                )));
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

impl Found {
    /// Counts a measure of a case, and compares it with the page.
    fn take(&mut self, case: &str, name: String, c: Comparison, page: Option<&Page>) {
        *(if c.pass { &mut self.pass } else { &mut self.short }) += 1;
        self.moved.extend(page.and_then(|page| page.moved(case, &name, &c)));
        self.sources.extend(c.source.map(|source| (case.to_owned(), name, source)));
    }
}

/// Makes the folder of the runs, and marks it as one.
fn prepare(out: &Path) -> Result<()> {
    may_use(out)?;
    fs::create_dir_all(out).map_err(|e| {
        let place = out.display();
        Error::Usage(format!("{place}: cannot be made ({e}); give another folder with --out"))
    })?;
    let mark = out.join(MARK);
    fs::write(&mark, MARKED).map_err(Error::io(&mark))
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
            let count = moved.len();
            let list = moved.join("\n  ");
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
    let case = out.join(format!("{stem}.toml"));
    let folder = out.join(&stem);
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
    let reference = c.reference.to_string();
    let tolerance = percent(c.tolerance);
    columns([
        case,
        name,
        &value,
        &reference,
        &error,
        &tolerance,
        c.verdict(),
        &format!("{:.0}", run.cost.wall_seconds),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::load;

    #[test]
    fn validate_exit_status_1_for_value_and_3_for_failed_run() {
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
    fn validate_chooses_cases_by_name_prefix() {
        let count = |names: &[&str], full| {
            let names: Vec<String> = names.iter().map(|name| name.to_string()).collect();
            chosen(&names, full).map(|rows| rows.len())
        };
        let quick = count(&[], false).unwrap();
        let all = count(&[], true).unwrap();
        assert!(0 < quick && quick < all && count(&["settling-disc", "cyl"], false).unwrap() > 3);
        assert!(count(&["settling-disc"], true).unwrap() == 3);
        assert!(matches!(
            count(&["nonsense"], false),
            Err(Error::Usage(m)) if m.contains("\"oscillating-cylinder\"")
        ));
    }

    #[test]
    fn validate_rows_are_valid_cases_with_sources() {
        let folder = tempfile::tempdir().unwrap();
        let case = folder.path().join("case.toml");
        let rows = shipped();
        assert!(rows.iter().any(|row| row.quick) && rows.iter().any(|row| !row.quick));
        for row in rows {
            fs::write(&case, row.text).unwrap();
            let case = load(&case, &row.set).unwrap_or_else(|e| panic!("{}: {e}", row.name)).case;
            let with = case.measure.iter().filter(|m| m.reference.is_some());
            assert!(
                with.clone().count() > 0 && with.clone().all(|m| m.source.is_some()),
                "{}",
                row.name
            );
        }
    }
}
