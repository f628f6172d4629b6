//! Common parts of the tests: PETSc behind a lock (it is one per process), scenes from text, runs
//! of the program.

use mics::config::{Case, load};
use mics::petsc::Session;
use mics::scene::Scene;
use std::collections::HashMap;
use std::ops::{Deref, DerefMut};
use std::path::Path;
use std::process::{Command, Output};
use std::sync::{Mutex, MutexGuard, Once, PoisonError};
use std::time::Duration;

static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
static STARTED: Once = Once::new();

/// Starts PETSc, for good: the process's other tests need it.
fn start_petsc() {
    STARTED.call_once(|| std::mem::forget(Session::start(&[]).expect("PETSc starts")));
}

/// PETSc for as long as the guard lives.
pub struct Petsc {
    pub session: Session,
    _guard: MutexGuard<'static, ()>,
}

pub fn petsc() -> Petsc {
    let guard = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
    start_petsc();
    let session = Session::start(&[]).expect("PETSc runs");
    Petsc { session, _guard: guard }
}

impl Petsc {
    /// The scene of a case's text.
    pub fn scene<const D: usize>(&self, text: &str) -> Scene<D> {
        Scene::new(&self.session, &case(text)).unwrap_or_else(|e| panic!("{e}"))
    }
}

/// The case that a text describes.
pub fn case(text: &str) -> Case {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("case.toml");
    std::fs::write(&path, text).unwrap();
    load(&path, &[]).unwrap_or_else(|e| panic!("{e}")).case
}

/// A case's text in 2D: periodic, without particles, unless `more` says otherwise (whole tables).
pub fn box_case(
    size: [f64; 2],
    cells: [usize; 2],
    viscosity: f64,
    sides: [&str; 4],
    more: &str,
) -> String {
    let [west, east, south, north] = sides;
    let time = if more.contains("[time]") { "" } else { "[time]\nend = 1.0" };
    format!(
        "name = \"test\"\n[domain]\nsize = {size:?}\ncells = {cells:?}\n[fluid]\ndensity = 1.0\n\
        viscosity = {viscosity:?}\n\
         [boundary]\nwest = {west}\neast = {east}\nsouth = {south}\nnorth = {north}\n{time}\n\
         {more}\n"
    )
}

/// The two couplings, each as a whole table: a scene with particles names the one that it is about.
pub const SHARP: &str = "[coupling]\nwall = \"sharp\"\n";
pub const MIXING: &str = "[coupling]\nwall = \"mixing\"\n";

pub const PERIODIC: [&str; 4] = ["\"periodic\"", "\"periodic\"", "\"periodic\"", "\"periodic\""];

/// A stream along x between sides that slip.
pub const STREAM: [&str; 4] = ["{ inflow = [1.0, 0.0] }", "\"outflow\"", "\"slip\"", "\"slip\""];

/// Observed order between two resolutions a factor `ratio` apart.
pub fn order(coarse: f64, fine: f64, ratio: f64) -> f64 {
    (coarse / fine).ln() / ratio.ln()
}

/// A program to run. MPI changes the environment of this process as it starts: behind Rust's back,
/// so that no program may start at that moment, and with variables that no MPI program started from
/// here may see.
pub fn command(program: &str) -> Command {
    start_petsc();
    let ours = |name: &str| ["OMPI_", "PMIX_", "PRTE_"].iter().any(|p| name.starts_with(p));
    let mut command = Command::new(program);
    command.env_clear().envs(std::env::vars().filter(|(name, _)| !ours(name)));
    command
}

/// Variables that OpenMPI asks of a superuser who starts ranks.
pub const AS_ROOT: [(&str, &str); 2] =
    [("OMPI_ALLOW_RUN_AS_ROOT", "1"), ("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")];

/// A program to run on several ranks, with a session folder of its own: OpenMPI's usual one is
/// shared by all of a user's programs, and the first to end takes it away from those that begin.
pub struct Mpirun {
    command: Command,
    _session: tempfile::TempDir,
}

impl Deref for Mpirun {
    type Target = Command;

    fn deref(&self) -> &Command {
        &self.command
    }
}

impl DerefMut for Mpirun {
    fn deref_mut(&mut self) -> &mut Command {
        &mut self.command
    }
}

pub fn mpirun(ranks: usize, program: &str) -> Mpirun {
    let (mut command, session) = (command("mpirun"), tempfile::tempdir().unwrap());
    command.envs(AS_ROOT).args(["--mca", "orte_tmpdir_base"]).arg(session.path());
    command.args(["--oversubscribe", "-n", &ranks.to_string(), program]);
    Mpirun { command, _session: session }
}

/// Time that this thread has computed so far: what a busy machine does not stretch.
pub fn thread_time() -> Duration {
    let spent = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Duration::new(spent.tv_sec as u64, spent.tv_nsec as u32)
}

/// The program, to run.
pub fn mics_command() -> Command {
    command(env!("CARGO_BIN_EXE_mics"))
}

/// Runs the program.
pub fn mics(arguments: &[&str]) -> Output {
    mics_command().args(arguments).output().expect("the program starts")
}

/// Runs a case into `out` on one rank, which must succeed, and returns its summary.
pub fn run(case: &Path, out: &Path, more: &[&str]) -> serde_json::Value {
    let (case, out_word) = (case.to_str().unwrap(), out.to_str().unwrap());
    let words = ["run", case, "--quiet", "--ranks", "1", "--out", out_word];
    let output = mics(&[&words[..], more].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    summary(out)
}

/// Runs a case into `out` on so many ranks, which must succeed.
pub fn run_on_ranks(ranks: usize, case: &Path, out: &Path) {
    let words = ["run", case.to_str().unwrap(), "--quiet", "--out", out.to_str().unwrap()];
    let output = mpirun(ranks, env!("CARGO_BIN_EXE_mics")).args(words).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

pub fn summary(out: &Path) -> serde_json::Value {
    let text = std::fs::read_to_string(out.join("summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&text).unwrap();
    let [found, limit] =
        ["divergence_max", "divergence_limit"].map(|k| summary[k].as_f64().unwrap());
    assert!(found < limit, "the divergence {found:e} is not below D0 = {limit:e}");
    summary
}

/// The columns of a CSV file, by name.
pub fn columns(path: &Path) -> HashMap<String, Vec<f64>> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(path).unwrap();
    let names: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
    let mut columns: HashMap<String, Vec<f64>> =
        names.iter().map(|n| (n.clone(), Vec::new())).collect();
    for record in reader.records().map(Result::unwrap) {
        for (name, value) in names.iter().zip(record.iter()) {
            columns.get_mut(name).unwrap().push(value.parse().unwrap_or(f64::NAN));
        }
    }
    columns
}

/// A file of the repository.
pub fn shipped(path: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}
