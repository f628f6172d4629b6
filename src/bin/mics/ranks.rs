//! A run on several ranks without a word of MPI, or on one with its memory in huge pages: this very
//! command once more. Of several ranks that is under mpirun, and this process stays beside it,
//! which draws the bar and hands on what asks the run to end.

use mics::launch::{self, Launch, Ranks};
use mics::output::progress::Glance;
use mics::{Error, Result};
use rustix::process::{
    Pid, Signal, getpid, kill_process, set_parent_process_death_signal, test_kill_process,
};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGUSR1};
use signal_hook::iterator::Signals;
use std::os::unix::process::{CommandExt as _, ExitStatusExt as _};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::time::Duration;
use std::{env, fs, io, thread};

/// Time between two looks at the ranks.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// Time between two looks of a rank at the process that has started it.
const WATCH_EVERY: Duration = Duration::from_secs(1);

/// The variable that tells ranks which process has started their mpirun.
const STARTER: &str = "MICS_STARTER";

/// mpirun on so many ranks, on fewer cores if need be, with a session folder of its own, which goes
/// with it: the usual one is shared by all of a user's programs, and the first to end takes it away
/// from those that begin.
struct Mpirun {
    /// The command `mpirun`, to which the program that the ranks run is to be added.
    command: Command,
    session: PathBuf,
}

impl Mpirun {
    /// One that is to be started.
    ///
    /// # Errors
    /// When its folder cannot be made.
    fn new(ranks: usize) -> Result<Mpirun> {
        let session = env::temp_dir().join(format!("mics-ranks-{}", std::process::id()));
        fs::create_dir_all(&session).map_err(Error::io(&session))?;
        let mut command = Command::new("mpirun");
        // Whoever may run this program may run it on ranks.
        for name in ["OMPI_ALLOW_RUN_AS_ROOT", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM"] {
            command.env(name, "1");
        }
        command.args(["-q", "--mca", "orte_tmpdir_base"]).arg(&session);
        // Ranks that are bound to cores would all be bound to the first ones, whoever's they are.
        command.args(["--bind-to", "none"]);
        // Ranks wait by asking again and again: beside other programs they are to let these go on.
        command.args(["--mca", "mpi_yield_when_idle", "1"]);
        command.args((ranks > launch::cores()).then_some("--oversubscribe"));
        command.args(["-n", &ranks.to_string()]);
        Ok(Mpirun { command, session })
    }
}

impl Drop for Mpirun {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.session);
    }
}

/// The command line of a run, as far as its ranks need it.
pub struct Choice<'a> {
    /// `--ranks`; without it as many as are good for it.
    pub ranks: Option<Ranks>,
    /// The case and its overrides.
    pub case: &'a Path,
    /// `key.path=value`.
    pub set: &'a [String],
    /// Whether PETSc has options of the command line's.
    pub options: bool,
    /// The run's folder, if it is not the usual one.
    pub out: Option<&'a Path>,
    /// Whether its progress is shown.
    pub shown: bool,
}

/// Runs this very command on the ranks of its case, and returns their exit status; `None` where
/// this process is to run it, and has its fields in huge pages if they are large.
///
/// # Errors
/// When the case is wrong, this is a rank already, mpirun cannot be started, or a rank is killed.
pub fn run(choice: &Choice) -> Result<Option<u8>> {
    let launch = launch::plan(choice.ranks, choice.case, choice.set, choice.options)?;
    if launch.ranks == 1 {
        begin_again(&launch)?;
        if launch::is_rank() {
            end_with_starters();
        }
        return Ok(None);
    }
    let tunables = huge_pages(env::var("GLIBC_TUNABLES").ok()).filter(|_| launch.large);
    let program = env::current_exe().map_err(Error::io("this program"))?;
    let words = env::args_os().skip(1);
    let mut mpirun = Mpirun::new(launch.ranks)?;
    let folder = choice.out.map_or_else(|| Path::new("runs").join(&launch.name), Path::to_owned);
    let glance = if choice.shown { Glance::at(&folder) } else { None };
    if glance.is_some() {
        mpirun.command.env(launch::WATCHED, "1");
    }
    mpirun.command.env(STARTER, std::process::id().to_string());
    mpirun.command.envs(tunables.map(|tunables| ("GLIBC_TUNABLES", tunables)));
    let words = without_ranks(words.map(|word| word.to_string_lossy().into_owned()));
    mpirun.command.arg(program).args(words);
    match wait(&mut mpirun.command, glance) {
        // Nobody has asked for ranks: one does without.
        Err(e) if e.kind() == io::ErrorKind::NotFound && choice.ranks.is_none() => Ok(None),
        Err(e) => Err(Error::io("mpirun, of Debian's openmpi-bin")(e)),
        Ok((status, asked)) => status_of(status, asked).map(Some),
    }
}

/// Ends this rank with what has started it, which would run on, and hold the folder, where that is
/// killed: at once with mpirun, and as by Ctrl-C with the process that has started mpirun.
fn end_with_starters() {
    let _ = set_parent_process_death_signal(Some(Signal::KILL));
    let starter = env::var(STARTER).ok().and_then(|id| id.parse().ok()).and_then(Pid::from_raw);
    let Some(starter) = starter else { return };
    thread::spawn(move || {
        while test_kill_process(starter).is_ok() {
            thread::sleep(WATCH_EVERY);
        }
        let _ = kill_process(getpid(), Signal::USR1);
    });
}

/// Lets this process check a case as a run of it has its memory: in huge pages if its fields are
/// large.
///
/// # Errors
/// When the case is wrong.
pub fn check(case: &Path, set: &[String]) -> Result<()> {
    begin_again(&launch::plan(None, case, set, true)?)
}

/// Begins this very command once more with its memory in huge pages, if the fields are large and it
/// has not yet. Returns where that is not needed, or fails: then the pages are small ones.
fn begin_again(launch: &Launch) -> Result<()> {
    let tunables = huge_pages(env::var("GLIBC_TUNABLES").ok()).filter(|_| launch.large);
    if let Some(tunables) = tunables {
        let mut words = env::args_os();
        let name = words.next().unwrap_or_default();
        let mut again = Command::new(env::current_exe().map_err(Error::io("this program"))?);
        let _ = again.arg0(name).args(words).env("GLIBC_TUNABLES", tunables).exec();
    }
    Ok(())
}

/// Value of `GLIBC_TUNABLES` by which the C library asks for huge pages for its memory, beside what
/// it has `already`; `None` where that has it. A row of a 3D field is on a page of 4 kB of its own,
/// and to look up where pages are takes a part of the time: -13 to -15 % of a step of crowd and
/// settling-sphere. Only a program that begins reads it.
fn huge_pages(already: Option<String>) -> Option<String> {
    const HUGE: &str = "glibc.malloc.hugetlb";
    match already {
        Some(already) if already.contains(HUGE) => None,
        Some(already) if !already.is_empty() => Some(format!("{already}:{HUGE}=1")),
        _ => Some(format!("{HUGE}=1")),
    }
}

/// Starts it, waits for it, and says whether a signal has asked it to end. The first of a kind asks
/// the ranks to stop after their step, a second one ends them at once; mpirun hands on SIGUSR1 and
/// lets them live, where it would give them a second only after Ctrl-C.
fn wait(command: &mut Command, mut glance: Option<Glance>) -> io::Result<(ExitStatus, bool)> {
    let mut signals = Signals::new([SIGINT, SIGTERM, SIGUSR1, SIGHUP])?;
    // In a group of its own: what the terminal sends reaches this process alone.
    let mut child = command.process_group(0).stdin(Stdio::null()).spawn()?;
    let mut asked = Vec::new();
    let status = loop {
        if let Some(status) = child.try_wait()? {
            break status;
        }
        for signal in signals.pending() {
            let at_once = signal == SIGHUP || asked.contains(&signal);
            let ending = if at_once { Signal::TERM } else { Signal::USR1 };
            // One that has just ended by itself is no failure to end it.
            let _ = kill_process(Pid::from_child(&child), ending);
            asked.push(signal);
        }
        glance.iter_mut().for_each(Glance::look);
        thread::sleep(LOOK_EVERY);
    };
    glance.iter().for_each(Glance::close);
    Ok((status, !asked.is_empty()))
}

/// The exit status that this process has for that of mpirun.
fn status_of(status: ExitStatus, asked: bool) -> Result<u8> {
    // mpirun says 128 more than the number of the signal that has killed a rank.
    let killed =
        status.signal().or(status.code().filter(|code| *code > 130).map(|code| code - 128));
    match (status.code(), killed) {
        (Some(code @ (0 | 2 | 3 | 130)), _) => Ok(code as u8),
        _ if asked => Ok(130),
        (_, Some(signal)) => Err(Error::Run(format!(
            "a rank was ended by signal {signal}{}; --resume goes on from the newest checkpoint",
            if signal == 9 { ", which the system sends when memory is short" } else { "" }
        ))),
        _ => Err(Error::Run(format!("mpirun could not run the ranks ({status}); try --ranks 1"))),
    }
}

/// The words of a command but `--ranks` and its number; those behind `--` are PETSc's.
fn without_ranks(words: impl Iterator<Item = String>) -> Vec<String> {
    let mut kept = Vec::new();
    let mut number = false;
    let mut ours = true;
    for word in words {
        ours &= word != "--";
        let own = ours && (number || word == "--ranks" || word.starts_with("--ranks="));
        number = ours && word == "--ranks";
        if !own {
            kept.push(word);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn launch_removes_own_option_from_command() {
        let left = |words: &str| without_ranks(words.split(' ').map(String::from)).join(" ");
        assert_eq!(left("run --ranks 2 a.toml --quiet"), "run a.toml --quiet");
        assert_eq!(left("run a.toml --ranks=auto -- -ksp_type cg"), "run a.toml -- -ksp_type cg");
        assert_eq!(left("run a.toml --ranks 2 -- --ranks 3"), "run a.toml -- --ranks 3");
    }

    #[test]
    fn huge_pages_are_asked_for_once_and_beside_other_tunables() {
        let asked = |already: &str| huge_pages(Some(already.into()));
        assert_eq!(huge_pages(None).as_deref(), Some("glibc.malloc.hugetlb=1"));
        assert_eq!(asked("a.b=1").as_deref(), Some("a.b=1:glibc.malloc.hugetlb=1"));
        assert!(
            ["glibc.malloc.hugetlb=0", "a.b=1:glibc.malloc.hugetlb=1"].map(asked) == [None, None]
        );
    }

    #[test]
    fn exit_status_of_ranks_is_that_of_the_run() {
        let status = |code: i32, asked| status_of(ExitStatus::from_raw(code << 8), asked);
        assert!([0, 2, 3, 130].iter().all(|&code| status(code, false).unwrap() == code as u8));
        assert_eq!(status(1, true).unwrap(), 130);
        let said = |code: i32| status(code, false).unwrap_err().to_string();
        assert!(said(137).contains("signal 9, which the system sends when memory is short"));
        assert!(said(1).contains("--ranks 1"));
    }
}
