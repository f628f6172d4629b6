//! `mics study`: a case over a table of overrides, one run after another.
//!
//! ```text
//! study file -> Plan: axes multiplied out, every case read and checked
//!            -> Runner: repeat 1: run 1, run 2, ...   repeat 2: run 1, run 2, ...
//!                 each a process of its own
//!            -> Table: medians over the repeats: study.csv, study.md, figures
//! ```
//!
//! Repeats are interleaved, so that a machine that slows down for a while slows all runs alike. The
//! table is written after every run: whenever a study is stopped, it has what was done, and the
//! same command goes on from there.

mod check;
mod child;
mod columns;
mod file;
mod plan;
mod planned;
mod reference;
mod runner;
mod show;
mod table;

pub use check::read;
pub use file::{Listed, Study};
pub use plan::Plan;
pub use runner::{COPY, Runner, may_start};
pub use show::markdown;

use mics_plot::study::{Quantity, draw};
use mics_run::config::Text;
use mics_run::file::replace;
use mics_run::print;
use mics_run::{Error, Result};
use std::fs;
use std::path::{Path, PathBuf};
use table::Table;

/// Command line of `mics study`.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct Request {
    /// The study file (TOML).
    pub study: PathBuf,
    /// The study's folder [default: runs/NAME].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// List the runs without running them.
    #[arg(long)]
    pub list: bool,
    /// Run the study as the file's [quick] changes it, every run once, into NAME-quick.
    #[arg(long)]
    pub quick: bool,
    /// Repeat the runs that are finished.
    #[arg(long)]
    pub force: bool,
}

/// Runs a study, or lists its runs.
///
/// # Errors
/// When the study file, a case, or a reference is wrong (nothing is written), when the folder
/// cannot be written, and, after all runs, when some are not done.
pub fn study(request: &Request) -> Result<()> {
    let text = Text::read(&request.study, "study")?;
    let study = read(&text, request.quick)?;
    let plan = Plan::new(&study, &text)?;
    let name = if request.quick { format!("{}-quick", study.name) } else { study.name.clone() };
    let folder = request.out.clone().unwrap_or_else(|| Path::new("runs").join(&name));
    may_start("mics study", &folder)?;
    let runner = Runner {
        plan: &plan,
        folder: &folder,
        repeats: study.repeats,
        limit_seconds: study.limit_seconds,
        force: request.force,
        say: print,
    };
    if request.list {
        return list(&runner);
    }
    fs::create_dir_all(&folder).map_err(Error::io(&folder))?;
    replace(&folder.join(COPY), text.as_str().as_bytes())?;
    let outcomes = runner.go(&|outcomes| write(&study, &Table::new(&plan, outcomes), &folder))?;
    let table = Table::new(&plan, &outcomes);
    write(&study, &table, &folder)?;
    report(&study, &table, &name, &folder)?;
    end(&plan, &table)
}

/// Writes the tables.
fn write(study: &Study, table: &Table, folder: &Path) -> Result<()> {
    replace(&folder.join("study.csv"), &table.csv())?;
    replace(&folder.join("study.md"), show::tables(study, table).as_bytes())
}

/// Prints the tables, and draws the figures of a study of that name into its folder.
fn report(study: &Study, table: &Table, name: &str, folder: &Path) -> Result<()> {
    print(&format!("\n{}", show::tables(study, table)))?;
    let quantity = |column: &str| Quantity {
        name: column.to_owned(),
        label: show::with_unit(table, column),
        target: table.targets.get(column).cloned(),
    };
    let shown = mics_plot::study::Study {
        title: name.to_owned(),
        names: table.names.clone(),
        quantities: show::shown(study, table, false).into_iter().map(quantity).collect(),
        across: study.across.clone(),
        over: study.over.clone(),
        rows: table.rows.iter().map(|row| row.run.clone()).collect(),
    };
    let files = ["study.csv", "study.md"].map(|file| folder.join(file));
    let figures = draw(&shown, folder)?;
    files.iter().chain(&figures).try_for_each(|path| print(&path.display().to_string()))
}

/// Names the runs that are done and in doubt and, as the study's error, those that are not done.
fn end(plan: &Plan, table: &Table) -> Result<()> {
    let mut broken = Vec::new();
    for (run, row) in plan.runs.iter().zip(&table.rows) {
        match row.status {
            "done" if row.message.is_empty() => {}
            "done" => print(&format!("{}: {}", run.id, row.message))?,
            status => broken.push(format!("{} ({status})", run.id)),
        }
    }
    match broken.len() {
        0 => Ok(()),
        count => Err(Error::Short(format!(
            "{count} of {} runs are not done: {}; study.csv says why",
            plan.runs.len(),
            broken.join(", ")
        ))),
    }
}

/// Lists the runs, and what is done of them.
fn list(runner: &Runner) -> Result<()> {
    let repeats = runner.repeats;
    let mut left = 0;
    for run in &runner.plan.runs {
        let done = (0..repeats).filter(|repeat| runner.kept(run, *repeat).is_some()).count();
        let what = match &run.loaded {
            Ok(case) => {
                left += repeats - done;
                let cells: Vec<String> = case.domain.cells.iter().map(usize::to_string).collect();
                format!("{} cells", cells.join(" x "))
            }
            Err(refusal) => format!("refused: {}", refusal.why),
        };
        let ranks = if run.ranks > 1 { format!(" on {} ranks", run.ranks) } else { String::new() };
        print(&format!("{}: {what}{ranks}, {done} of {repeats} done", run.id))?;
        print(&format!("    {}", run.set.join("; ")))?;
    }
    let runs = runner.plan.runs.len();
    let folder = runner.folder.display();
    print(&format!("{runs} runs, {repeats} times each, {left} left to do, into {folder}"))
}
