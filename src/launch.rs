//! Ranks without a word of MPI: this program starts itself again, under mpirun.
//!
//! ```text
//!   work = cells + 30 (cells that the surfaces of bodies cut),     ranks = work/100,000
//! ```
//! A cell at a surface costs as much as thirty of fluid: ghost cells, apertures, forces (crowds,
//! beds and spheres take 20 to 60).

use crate::config::{Case, Particle};
use crate::scene::read_case;
use crate::{Error, Result};
use std::f64::consts::PI;
use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::Command;
use std::str::FromStr;
use std::{env, thread};

/// Work, in cells of fluid, below which a rank has more to say than to do.
const WORK_A_RANK: usize = 100_000;

/// Cells below which a rank's box is little but ghosts.
const CELLS_A_RANK: usize = 8_000;

/// What a cell that a body's surface cuts costs, in cells of fluid.
const SURFACE_CELL: f64 = 30.0;

/// The work of a step and the cells that it is divided by.
#[derive(Clone, Copy, Debug)]
pub struct Work {
    cells: usize,
    /// In cells of fluid.
    work: usize,
}

impl Work {
    /// That of a case, with its bodies as they are told.
    pub fn of(case: &Case) -> Work {
        let domain = &case.domain;
        let cells: usize = domain.cells.iter().product();
        let spacing = domain.size.iter().zip(&domain.cells).map(|(size, n)| size / *n as f64);
        let h = spacing.fold(f64::INFINITY, f64::min);
        let surface = |particle: &Particle| {
            let across = particle.shape.diameter() / h;
            PI * if domain.cells.len() == 2 { across } else { across * across }
        };
        let surfaces: f64 = case.particle.iter().map(surface).sum();
        Work { cells, work: cells + (SURFACE_CELL * surfaces) as usize }
    }

    /// How many ranks it is enough for, at least 1.
    pub fn ranks(self) -> usize {
        (self.work / WORK_A_RANK).min(self.cells / CELLS_A_RANK).max(1)
    }

    /// What is to be said of the cores that ranks leave idle; `None` where that is right.
    pub fn advice(self, ranks: usize) -> Option<String> {
        let better = self.ranks().min(cores());
        (better > ranks).then(|| {
            format!(
                "{} of {} cores in use: the cells and bodies are work for {better} \
                (--ranks {better} or auto)",
                ranks,
                cores()
            )
        })
    }
}

/// How many ranks a run is to have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ranks {
    /// As many as there are cores, and fewer where each would have too little work.
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
    /// How many so much work has on a machine with so many cores.
    fn count(self, work: Work, cores: usize) -> usize {
        match self {
            Ranks::Auto => cores.min(work.ranks()),
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
    // Whoever may run this program may run it on ranks.
    for name in ["OMPI_ALLOW_RUN_AS_ROOT", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM"] {
        command.env(name, "1");
    }
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
    let count = ranks.count(Work::of(&read_case(case, set)?.case), cores());
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
        let work = |cells, work| Work { cells, work };
        let auto = |cells, of_bodies| Ranks::Auto.count(work(cells, cells + of_bodies), 8);
        assert_eq!([auto(50_000, 0), auto(250_000, 0), auto(10_000_000, 0)], [1, 2, 8]);
        // Many bodies on a small grid, and on one that cannot be divided further.
        assert_eq!([auto(100_000, 400_000), auto(20_000, 10_000_000)], [5, 2]);
        assert_eq!(Ranks::Count(16).count(work(100, 100), 2), 16);
    }

    #[test]
    fn work_counts_cells_and_cells_at_surfaces_of_bodies() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../cases/settling-sphere/case.toml");
        let case = read_case(&path, &[]).unwrap().case;
        let Work { cells, work } = Work::of(&case);
        let domain = &case.domain;
        let across = case.particle[0].shape.diameter() * domain.cells[0] as f64 / domain.size[0];
        assert_eq!((case.particle.len(), cells), (1, domain.cells.iter().product::<usize>()));
        let of_surface = (work - cells) as f64 / (PI * across * across);
        assert!((of_surface - 30.0).abs() < 0.01, "{of_surface}");
    }

    #[test]
    fn launch_removes_own_option_from_command() {
        let left = |words: &str| without_ranks(words.split(' ').map(String::from)).join(" ");
        assert_eq!(left("run --ranks 2 a.toml --quiet"), "run a.toml --quiet");
        assert_eq!(left("run a.toml --ranks=auto -- -ksp_type cg"), "run a.toml -- -ksp_type cg");
        assert_eq!(left("run a.toml --ranks 2 -- --ranks 3"), "run a.toml -- --ranks 3");
    }
}
