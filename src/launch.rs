//! Ranks without a word of MPI: this program starts itself again, under mpirun.

use crate::scene::read_case;
use crate::{Error, Result};
use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::Command;
use std::str::FromStr;
use std::{env, thread};

/// Cells below which a rank has more to say than to do.
const CELLS_A_RANK: usize = 100_000;

/// How many ranks a run is to have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ranks {
    /// As many as there are cores, and fewer where each would have less than 100,000 cells.
    Auto,
    /// So many.
    Count(usize),
}

impl FromStr for Ranks {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Ranks, String> {
        match text.parse() {
            _ if text == "auto" => Ok(Ranks::Auto),
            Ok(count) if count > 0 => Ok(Ranks::Count(count)),
            _ => Err("a number of ranks, or auto".into()),
        }
    }
}

impl Ranks {
    /// How many a grid of so many cells has on a machine with so many cores.
    fn count(self, cells: usize, cores: usize) -> usize {
        match self {
            Ranks::Auto => cores.min(cells / CELLS_A_RANK).max(1),
            Ranks::Count(count) => count,
        }
    }
}

fn cores() -> usize {
    thread::available_parallelism().map_or(1, usize::from)
}

/// mpirun with so many ranks, on fewer cores if need be; what they run is to follow.
pub fn mpirun(ranks: usize) -> Command {
    let mut command = Command::new("mpirun");
    command.args((ranks > cores()).then_some("--oversubscribe")).args(["-n", &ranks.to_string()]);
    command
}

/// Becomes an mpirun of this very command on the ranks of a case; returns where one rank is enough,
/// which needs none.
///
/// # Errors
/// When the case is wrong, this is a rank already, or mpirun cannot be started.
pub fn on_ranks(ranks: Ranks, case: &Path, set: &[String]) -> Result<()> {
    if env::var_os("OMPI_COMM_WORLD_SIZE").is_some() {
        return Err(Error::Usage(
            "--ranks starts mpirun by itself: leave one of the two away".into(),
        ));
    }
    let count = ranks.count(read_case(case, set)?.case.domain.cells.iter().product(), cores());
    if count == 1 {
        return Ok(());
    }
    let program = env::current_exe().map_err(Error::io("this program"))?;
    let mut command = mpirun(count);
    command.arg(program).args(without_ranks(
        env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned()),
    ));
    // What comes back is a failure: the program is another one otherwise.
    Err(Error::io("mpirun")(command.exec()))
}

/// The words of a command but `--ranks` and its number; those behind `--` are PETSc's.
fn without_ranks(words: impl Iterator<Item = String>) -> Vec<String> {
    let (mut kept, mut number, mut ours) = (Vec::new(), false, true);
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
    fn ranks_option_is_number_or_auto() {
        assert_eq!(("auto".parse(), "3".parse()), (Ok(Ranks::Auto), Ok(Ranks::Count(3))));
        assert!(["0", "-1", "two", ""].iter().all(|text| text.parse::<Ranks>().is_err()));
        let auto = |cells, cores| Ranks::Auto.count(cells, cores);
        assert_eq!([auto(50_000, 8), auto(250_000, 8), auto(10_000_000, 8)], [1, 2, 8]);
        assert_eq!(Ranks::Count(16).count(100, 2), 16);
    }

    #[test]
    fn launch_removes_own_option_from_command() {
        let left = |words: &str| without_ranks(words.split(' ').map(String::from)).join(" ");
        assert_eq!(left("run --ranks 2 a.toml --quiet"), "run a.toml --quiet");
        assert_eq!(left("run a.toml --ranks=auto -- -ksp_type cg"), "run a.toml -- -ksp_type cg");
        assert_eq!(left("run a.toml --ranks 2 -- --ranks 3"), "run a.toml -- --ranks 3");
    }
}
