//! `mics validate`: the shipped cases beside their references, value for value. It is the study
//! `cases/validate.study.toml`, of which each measure that has a reference in its case is a row.

mod page;

use crate::cases;
use crate::study::{self, COPY, Plan, Runner, may_start};
use mics_run::config::{Text, suggest};
use mics_run::file::replace;
use mics_run::summary::Summary;
use mics_run::{Error, Result, print};
use page::Page;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use toml::Value;

/// The study that it runs.
const STUDY: &str = include_str!("../../../../cases/validate.study.toml");

/// Command line of `mics validate`.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct Request {
    /// Only the cases whose names begin so.
    pub names: Vec<String>,
    /// The short cases only, under five minutes; the default.
    #[arg(long, conflicts_with = "full")]
    pub quick: bool,
    /// All cases with a reference.
    #[arg(long, conflicts_with = "names")]
    pub full: bool,
    /// The folder of its runs.
    #[arg(long, value_name = "DIR", default_value = "runs/validate")]
    pub out: PathBuf,
    /// Repeat the runs that are finished.
    #[arg(long)]
    pub force: bool,
    /// Print a page of Markdown, as docs/accuracy.md is one.
    #[arg(long)]
    pub markdown: bool,
    /// Compare with such a page, and name the values that have moved since by more than a tenth
    /// of their tolerance; the status is then 1 where there are any, and 0 where values fall
    /// short as the page has them.
    #[arg(long, value_name = "PAGE")]
    pub compare: Option<PathBuf>,
    /// PETSc options, after --.
    #[arg(last = true, value_name = "PETSC OPTIONS", allow_hyphen_values = true)]
    pub petsc: Vec<String>,
}

/// Results of all cases.
#[derive(Default)]
struct Found {
    /// The rows of the table.
    rows: Vec<Vec<String>>,
    pass: usize,
    short: usize,
    /// Cases whose runs failed.
    failed: Vec<String>,
    /// Messages about values that have moved from the page.
    moved: Vec<String>,
    /// Case, measure and where its reference is from.
    sources: Vec<(String, String, String)>,
}

/// Runs the shipped cases that have references, and prints their measures beside the references:
/// the short ones, all, or those whose names begin so.
///
/// # Errors
/// When a name is unknown, a run fails, or measures fall short of their references or have moved
/// from the page they are compared with: [`Error::Short`], after all have been run.
pub fn validate(request: &Request) -> Result<()> {
    let Request { out, force, markdown, compare, .. } = request;
    let page = compare.as_deref().map(Page::read).transpose()?;
    let text = Text::new(&out.join("cases/validate.study.toml"), STUDY);
    let study = chosen(request, &text)?;
    may_start("mics validate", out)?;
    write(out, &study)?;
    let plan = Plan::new(&study, &text)?;
    let say = if *markdown { complain } else { print };
    let runner =
        Runner { plan: &plan, folder: out, repeats: 1, limit_seconds: None, force: *force, say };
    let outcomes = runner.go(&|_| Ok(()))?;
    let mut found = Found::default();
    for (run, ends) in plan.runs.iter().zip(&outcomes) {
        let case = &run.labels[0];
        let done = ends.iter().find(|outcome| outcome.status == "done");
        match done.and_then(|outcome| serde_json::from_value(outcome.summary.clone()).ok()) {
            Some(summary) => found.take(case, &summary, page.as_ref()),
            None => found.failed.push(case.clone()),
        }
    }
    let table = study::markdown(&page::COLUMNS, found.rows.clone());
    if *markdown {
        print(&page::page(request, &table, &found))?;
    } else {
        print(&format!("\n{table}"))?;
    }
    let end = conclude(&found, page.as_ref())?;
    if *markdown { Ok(()) } else { print(&end) }
}

/// Says a line beside a page on standard output.
fn complain(line: &str) -> Result<()> {
    let _ = writeln!(std::io::stderr(), "{line}");
    Ok(())
}

/// The study of the cases that are asked for.
fn chosen(request: &Request, text: &Text) -> Result<study::Study> {
    let mut study = study::read(text, true)?;
    let quick = std::mem::take(&mut study.quick);
    let name = |row: &study::Listed| row.labels["case"].0.clone();
    let known: Vec<String> = study.row.iter().map(name).collect();
    let unknown = |name: &&String| !known.iter().any(|known| known.starts_with(*name));
    if let Some(unknown) = request.names.iter().find(unknown) {
        let known: Vec<&str> = known.iter().map(String::as_str).collect();
        let words = format!("no case begins with \"{unknown}\"; {}", suggest(unknown, &known));
        return Err(Error::Usage(words));
    }
    study.row.retain(|row| {
        let own = &row.labels["case"];
        match &request.names[..] {
            [] => request.full || quick.keep["case"].contains(own),
            names => names.iter().any(|name| own.0.starts_with(name)),
        }
    });
    // The case of the study is read even where no row has it.
    study.case = study.row.first().map_or("", case).into();
    if !request.petsc.is_empty() {
        study.set.insert("petsc.options".into(), Value::String(request.petsc.join(" ")));
    }
    Ok(study)
}

/// The case file of a row of the study.
fn case(row: &study::Listed) -> &str {
    row.set.get("case").and_then(Value::as_str).unwrap_or_default()
}

/// Writes the study and its cases into the folder of the runs.
fn write(out: &Path, study: &study::Study) -> Result<()> {
    fs::create_dir_all(out).map_err(Error::io(out))?;
    replace(&out.join(COPY), STUDY.as_bytes())?;
    for file in study.row.iter().map(case) {
        let path = out.join("cases").join(file);
        let folder = path.parent().unwrap_or(out);
        fs::create_dir_all(folder).map_err(Error::io(folder))?;
        replace(&path, cases::text(file).as_bytes())?;
    }
    Ok(())
}

impl Found {
    /// Takes the measures of a case, and compares them with the page.
    fn take(&mut self, case: &str, summary: &Summary, page: Option<&Page>) {
        for (name, c) in summary.comparisons() {
            self.rows.push(page::row(case, &name, &c, summary));
            *(if c.pass { &mut self.pass } else { &mut self.short }) += 1;
            self.moved.extend(page.and_then(|page| page.moved(case, &name, &c)));
            self.sources.extend(c.source.map(|source| (case.to_owned(), name, source)));
        }
    }
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
            let file = page.file.display();
            Err(Error::Short(format!("{counts}; {count} are not as {file} has them:\n  {list}")))
        }
        (None, 0) => Ok(counts),
        (None, short) => {
            Err(Error::Short(format!("{counts}, {short} fall short of their references")))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mics_run::config::Reference;

    const CYLINDER: &str = include_str!("../../../../cases/cylinder-wake/cylinder_s3.csv");

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
    fn validate_runs_valid_cases_whose_references_have_sources() {
        let folder = tempfile::tempdir().unwrap();
        let text = Text::new(&folder.path().join("cases/validate.study.toml"), STUDY);
        let count = |names: &[&str], full| {
            let names = names.iter().map(|name| name.to_string()).collect();
            let request = Request { names, full, ..Request::default() };
            chosen(&request, &text).map(|study| study.row.len())
        };
        let quick = count(&[], false).unwrap();
        let all = count(&[], true).unwrap();
        assert!(0 < quick && quick < all && count(&["settling-disc", "cyl"], false).unwrap() > 3);
        assert_eq!(count(&["settling-disc"], false).unwrap(), 3);
        assert!(matches!(count(&["nonsense"], false), Err(Error::Usage(_))));

        let full = Request { full: true, ..Request::default() };
        let study = chosen(&full, &text).unwrap();
        write(folder.path(), &study).unwrap();
        for run in Plan::new(&study, &text).unwrap().runs {
            let case = run.loaded.unwrap_or_else(|refusal| panic!("{}: {}", run.id, refusal.why));
            if let Some(re) = run.labels[0].strip_prefix("cylinder-wake Re ") {
                let row = CYLINDER.lines().find(|row| row.split(',').next() == Some(re)).unwrap();
                let drag = row.split(',').nth(1).unwrap().parse().unwrap();
                assert_eq!(case.measure[0].reference, Some(Reference::Value(drag)), "{}", run.id);
            }
            let mut with = case.measure.iter().filter(|m| m.reference.is_some()).peekable();
            assert!(with.peek().is_some() && with.all(|m| m.source.is_some()), "{}", run.id);
        }
    }
}
