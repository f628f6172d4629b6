//! Number of ranks that a run is to have, where nobody speaks of MPI.
//!
//! ```text
//!   work = cells + 30 (cells that the surfaces of bodies cut),     ranks = work/100,000
//! ```
//! A cell at a surface costs as much as thirty of fluid ([`surface_work`]).

use crate::config::{Case, Solver};
use crate::scene::{read_case, surface_work};
use crate::{Error, Result};
use std::path::Path;
use std::str::FromStr;
use std::{env, thread};

/// Work of a rank, in cells of fluid, below which it communicates more than it computes.
const WORK_A_RANK: usize = 100_000;

/// Cells below which a rank's box is little but ghosts.
const CELLS_A_RANK: usize = 8_000;

/// The work of a step and the cells that it is divided by.
#[derive(Clone, Copy, Debug)]
pub struct RunSize {
    cells: usize,
    /// In cells of fluid.
    work: usize,
}

impl RunSize {
    /// The work of a case, with its bodies as they are told.
    pub fn of(case: &Case) -> RunSize {
        let cells: usize = case.domain.cells.iter().product();
        let surfaces: f64 = case.particle.iter().map(|p| surface_work(case, p)).sum();
        RunSize { cells, work: cells + surfaces as usize }
    }

    /// Number of ranks that it is enough for, at least 1.
    pub fn ranks(self) -> usize {
        (self.work / WORK_A_RANK).min(self.cells / CELLS_A_RANK).max(1)
    }

    /// Advice on a number of ranks, where the work is enough for more of them; `None` where that is
    /// right.
    pub fn advice(self, ranks: usize) -> Option<String> {
        let enough = self.ranks();
        let cores = cores();
        let with = if cores > ranks {
            format!("--ranks {} uses the cores that are idle", enough.min(cores))
        } else {
            "more cores would help".to_owned()
        };
        (enough > ranks).then(|| {
            format!(
                "{ranks} rank{} on {cores} core{}: cells and bodies are work for {enough}; {with}",
                if ranks == 1 { "" } else { "s" },
                if cores == 1 { "" } else { "s" },
            )
        })
    }
}

/// Number of ranks that a run is to have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ranks {
    /// As many as there are cores, and fewer where each would have too little work.
    Auto,
    /// A given number.
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
    /// Number of ranks for some work on a machine with so many cores.
    fn count(self, work: RunSize, cores: usize) -> usize {
        match self {
            Ranks::Auto => cores.min(work.ranks()),
            Ranks::Count(count) => count,
        }
    }
}

/// The cores that this process may use.
pub fn cores() -> usize {
    thread::available_parallelism().map_or(1, usize::from)
}

/// The variable that tells ranks that whoever started them shows how far they are.
pub const WATCHED: &str = "MICS_RANKS_WATCHED";

/// Variables that the first rank of several gets from its starter: mpirun, and servers of srun.
const OF_A_RANK: [&str; 3] = ["OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK"];

/// Whether this process is a rank that mpirun or srun has started.
pub fn is_rank() -> bool {
    OF_A_RANK.iter().any(|name| env::var_os(name).is_some())
}

/// Plan for the start of a run.
pub struct Launch {
    /// The ranks that are to be started; 1 where this process is to run the case.
    pub ranks: usize,
    /// The case's name.
    pub name: String,
    /// Whether its fields are large: their memory is worth to be in huge pages.
    pub large: bool,
}

/// Plans the start of a case. This process runs it where one rank is enough, or where nobody has
/// said how many and this is a rank already or a solver has been chosen, which behaves on several
/// ranks in its own way.
///
/// # Errors
/// When the case is wrong, or this is a rank already and more are asked for.
pub fn plan(ranks: Option<Ranks>, case: &Path, set: &[String], options: bool) -> Result<Launch> {
    let is_rank = is_rank();
    if is_rank && ranks.is_some() {
        return Err(Error::Usage(
            "--ranks starts mpirun by itself: leave one of the two away".into(),
        ));
    }
    let case = read_case(case, set)?.case;
    let work = RunSize::of(&case);
    let ranks = match ranks {
        _ if is_rank => 1,
        Some(ranks) => ranks.count(work, cores()),
        None => usual(&case, options),
    };
    Ok(Launch { ranks, name: case.name, large: work.work >= WORK_A_RANK })
}

/// Number of ranks of a case where nobody has given one, with or without PETSc's options on the
/// command line.
pub fn usual(case: &Case, options: bool) -> usize {
    let chosen = options || chooses_solver(case);
    if chosen { 1 } else { Ranks::Auto.count(RunSize::of(case), cores()) }
}

/// Whether a case has a solver of its own choice.
fn chooses_solver(case: &Case) -> bool {
    !case.petsc.options.is_empty() || case.pressure.solver != Solver::Auto
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn ranks_option_is_number_or_auto() {
        assert_eq!(("auto".parse(), "3".parse()), (Ok(Ranks::Auto), Ok(Ranks::Count(3))));
        assert!(["0", "-1", "two", ""].iter().all(|text| text.parse::<Ranks>().is_err()));
        let work = |cells, work| RunSize { cells, work };
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
        let RunSize { cells, work } = RunSize::of(&case);
        let domain = &case.domain;
        let across = case.particle[0].shape.diameter() * domain.cells[0] as f64 / domain.size[0];
        assert_eq!((case.particle.len(), cells), (1, domain.cells.iter().product::<usize>()));
        let of_surface = (work - cells) as f64 / (PI * across * across);
        assert!((of_surface - 30.0).abs() < 0.01, "{of_surface}");
    }
}
