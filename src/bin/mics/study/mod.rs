//! `mics study`: a case over a table of overrides and PETSc options, one run after another.
//!
//! ```text
//! study file -> Plan: axes multiplied out, every case read and checked
//!            -> repeat 1: run 1, run 2, ...   repeat 2: run 1, run 2, ...
//!              each a process of its own
//!            -> medians over the repeats: study.csv, study.md; figures: value_MEASURE,
//!                 work_precision_MEASURE (and _mean), cost
//! ```
//!
//! Repeats are interleaved, so that a machine that slows down for a while slows all runs alike. The
//! table is written after every run: whenever a study is stopped, it has what was done, and the
//! same command goes on from there.

mod check;
mod child;
mod columns;
mod cross;
mod file;
mod markdown;
mod plan;
mod planned;
mod reference;
mod sheet;
mod table;

use child::Outcome;
use file::{Failures, Study};
use mics_plot::study::Layout;
use mics_run::file::replace;
use mics_run::print;
use mics_run::{Error, Result};
use plan::Plan;
use planned::{Planned, Refusal};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;
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
    /// Run the study as the file's [quick] changes it, into NAME-quick.
    #[arg(long)]
    pub quick: bool,
    /// Repeat the runs that are finished.
    #[arg(long)]
    pub force: bool,
}

/// The copy of the study file that marks a study's folder.
const COPY: &str = "study.toml";

/// Runs a study, or lists its runs.
///
/// # Errors
/// When the study file, a case, or a reference is wrong (nothing is written), when the folder
/// cannot be written, and, after all runs, when some are not done.
pub fn study(request: &Request) -> Result<()> {
    if std::env::var("OMPI_COMM_WORLD_SIZE").is_ok_and(|size| size != "1") {
        let words = "mics study starts its runs by itself: without mpirun, and with ranks = [...] \
            in the study file";
        return Err(Error::Usage(words.into()));
    }
    let (study, text) = check::read(&request.study, request.quick)?;
    let mut plan = Plan::new(&study, &text)?;
    let name = if request.quick { format!("{}-quick", study.name) } else { study.name.clone() };
    let folder = request.out.clone().unwrap_or_else(|| Path::new("runs").join(&name));
    may_use(&folder)?;
    if request.list {
        return list(&study, &plan, &folder);
    }
    fs::create_dir_all(&folder).map_err(Error::io(&folder))?;
    replace(&folder.join(COPY), text.as_str().as_bytes())?;
    check_scenes(&study, &mut plan, &folder, request.force)?;
    let outcomes = run_all(&study, &plan, &folder, request.force)?;
    report(&study, &plan, &outcomes, &name, &folder)?;
    end(&study, &plan, &outcomes)
}

/// Prints the tables, writes them and draws the figures of a study of that name into its folder.
fn report(
    study: &Study,
    plan: &Plan,
    outcomes: &[Vec<Outcome>],
    name: &str,
    folder: &Path,
) -> Result<()> {
    let table = write_table(study, plan, outcomes, folder)?;
    let mut files = vec![folder.join("study.csv"), folder.join("study.md")];
    let mut texts = vec![markdown::markdown(plan, &table, study.columns.as_deref())];
    if let Some(spread) = &study.spread {
        texts.push(markdown::spread(plan, &table, &spread.over));
        files.push(folder.join("spread.md"));
        replace(&files[files.len() - 1], texts[texts.len() - 1].as_bytes())?;
    }
    if !study.cross.is_empty() {
        texts.push(cross::cross(plan, &table.rows, &study.cross));
        files.push(folder.join("cross.md"));
        replace(&files[files.len() - 1], texts[texts.len() - 1].as_bytes())?;
    }
    print("")?;
    for text in &texts {
        print(text.trim_end())?;
        print("")?;
    }
    let over = study.spread.as_ref().map_or(&[][..], |spread| &spread.over);
    let measures = plan.measures();
    let costs: Vec<_> =
        study.plot.costs.iter().map(|name| (name.clone(), columns::axis(name))).collect();
    let shown: Vec<_> = table.rows.iter().map(|row| row.shown(&study.plot.costs)).collect();
    let figures = mics_plot::study::draw(
        name,
        &table.shown(plan, &measures, &costs),
        &shown,
        &Layout { series: study.plot.series.as_deref(), each: &study.plot.each, over },
        folder,
    )?;
    for path in files.iter().chain(&figures) {
        print(&path.display().to_string())?;
    }
    Ok(())
}

/// Names the runs that are done and in doubt, and those that are not done: as the study's error,
/// unless failures are results.
fn end(study: &Study, plan: &Plan, outcomes: &[Vec<Outcome>]) -> Result<()> {
    for (run, outcomes) in plan.runs.iter().zip(outcomes) {
        let remark = outcomes.last().filter(|o| o.status == "done" && !o.message.is_empty());
        remark.map_or(Ok(()), |outcome| print(&format!("{}: {}", run.id, outcome.message)))?;
    }
    let broken = plan.runs.iter().zip(outcomes).filter_map(|(run, outcomes)| {
        let outcome = outcomes.iter().find(|outcome| outcome.status != "done")?;
        Some((format!("{} ({})", run.id, outcome.status), outcome.status))
    });
    let broken: Vec<(String, &str)> = broken.collect();
    if broken.is_empty() {
        return Ok(());
    }
    let names: Vec<&str> = broken.iter().map(|(name, _)| name.as_str()).collect();
    let count = broken.len();
    let total = plan.runs.len();
    let words =
        format!("{count} of {total} runs are not done: {}; study.csv says why", names.join(", "));
    // One that somebody stopped says nothing of its solver.
    let stopped = broken.iter().any(|(_, status)| *status == "interrupted");
    if study.failures == Failures::Rows && !stopped {
        print(&words)
    } else {
        Err(Error::Short(words))
    }
}

/// Finds the runs that their scenes refuse, by a step over a limit for example, and says before the
/// first one starts which runs are refused. What is done already is not asked again.
fn check_scenes(study: &Study, plan: &mut Plan, folder: &Path, force: bool) -> Result<()> {
    for run in &mut plan.runs {
        let done = !force
            && (0..study.repeats).all(|k| child::kept(run, &place(folder, run, k)).is_some());
        if let (Ok(_), false) = (&run.loaded, done)
            && let Some(why) = child::refusal(run)?
        {
            run.loaded = Err(Refusal::of_scene(why));
        }
        if let Err(refusal) = &run.loaded {
            print(&format!("{} is refused: {}", run.id, refusal.why))?;
        }
    }
    Ok(())
}

/// Refuses a folder that holds something other than a study.
fn may_use(folder: &Path) -> Result<()> {
    let refuse = |why: &str| Err(Error::Usage(format!("{}: {why}", folder.display())));
    let mut entries = match fs::read_dir(folder) {
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(()),
        Err(e) => return refuse(&format!("cannot be used as a study's folder: {e}")),
        Ok(entries) => entries,
    };
    if folder.join(COPY).is_file() || entries.next().is_none() {
        return Ok(());
    }
    refuse("the folder exists and holds no study (no study.toml); give another folder with --out")
}

fn place(folder: &Path, run: &Planned, repeat: usize) -> PathBuf {
    folder.join("runs").join(&run.id).join((repeat + 1).to_string())
}

fn list(study: &Study, plan: &Plan, folder: &Path) -> Result<()> {
    let mut left = 0;
    for run in &plan.runs {
        let done = (0..study.repeats)
            .filter(|k| child::kept(run, &place(folder, run, *k)).is_some())
            .count();
        left += if run.loaded.is_ok() { study.repeats - done } else { 0 };
        let cells = run
            .loaded
            .as_ref()
            .map(|case| case.domain.cells.iter().map(usize::to_string).collect::<Vec<_>>());
        print(&format!(
            "{}: {}, {done} of {} done",
            run.id,
            cells.map_or_else(
                |refusal| format!("refused: {}", refusal.why),
                |cells| format!("{} cells", cells.join(" x "))
            ),
            study.repeats
        ))?;
        print(&format!("    {}", run.set.join("; ")))?;
        if !run.petsc.is_empty() {
            print(&format!("    -- {}", run.petsc.join(" ")))?;
        }
    }
    let runs = plan.runs.len();
    let repeats = study.repeats;
    print(&format!(
        "{runs} runs, {repeats} times each, {left} left to do, into {}",
        folder.display()
    ))
}

/// Runs what is not done yet, repeat by repeat; returns the outcomes of every run. One that is not
/// done is not repeated.
fn run_all(study: &Study, plan: &Plan, folder: &Path, force: bool) -> Result<Vec<Vec<Outcome>>> {
    let mut outcomes: Vec<Vec<Outcome>> = plan.runs.iter().map(|_| Vec::new()).collect();
    let total = plan.runs.len() * study.repeats;
    let limit = study.limit_seconds.map(Duration::from_secs_f64);
    let mut older = 0;
    for repeat in 0..study.repeats {
        for (index, run) in plan.runs.iter().enumerate() {
            if outcomes[index].iter().any(|outcome| outcome.status != "done") {
                continue;
            }
            let at = place(folder, run, repeat);
            let kept = if force { None } else { child::kept(run, &at) };
            let word = if kept.is_some() { "kept" } else { "done" };
            let count = format!("{}/{total} {}", repeat * plan.runs.len() + index + 1, run.id);
            let outcome = kept.map_or_else(|| child::run(run, &at, &count, limit), Ok)?;
            if ["done", "too slow"].contains(&outcome.status) && !study.keep_fields {
                child::drop_fields(&at)?;
            }
            older += usize::from(outcome.commit != crate::COMMIT);
            let end = match (outcome.status, outcome.summary["cpu_seconds"].as_f64()) {
                ("done", Some(cpu)) => {
                    let remark = if outcome.message.is_empty() { "" } else { "; " };
                    format!("{word}, {} CPU s{remark}{}", markdown::short(cpu), outcome.message)
                }
                (status, _) => format!("{status}: {}", outcome.message),
            };
            let again =
                if study.repeats > 1 { format!(", repeat {}", repeat + 1) } else { String::new() };
            print(&format!("{count}{again}: {end}"))?;
            outcomes[index].push(outcome);
            write_table(study, plan, &outcomes, folder)?;
        }
    }
    if older > 0 {
        print(&format!(
            "{older} runs were kept that another build of mics did; --force does them again"
        ))?;
    }
    Ok(outcomes)
}

fn write_table(
    study: &Study,
    plan: &Plan,
    outcomes: &[Vec<Outcome>],
    folder: &Path,
) -> Result<Table> {
    let table = Table::new(plan, outcomes);
    replace(&folder.join("study.csv"), &table::csv(plan, &table.rows))?;
    let text = markdown::markdown(plan, &table, study.columns.as_deref());
    replace(&folder.join("study.md"), text.as_bytes())?;
    Ok(table)
}
