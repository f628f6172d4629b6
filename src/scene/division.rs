//! Work of a case, and how even it is over the ranks at the start.
//!
//! ```text
//!   work = cells + 30 (cells that the surfaces of bodies cut)
//! ```
//! Only the case tells the work, with the bodies where they begin: a restart has the same division.

use super::build::axes;
use crate::config::{Case, Particle};
use crate::grid::Division;
use std::f64::consts::PI;

/// Work of a cell that the surface of a body cuts, in cells of fluid: ghost cells, apertures and
/// forces (crowds, beds and spheres take 20 to 60).
const SURFACE_CELL: f64 = 30.0;

/// Work of the cells that the surface of a body cuts, in cells of fluid.
pub(crate) fn surface_work(case: &Case, particle: &Particle) -> f64 {
    let spacings = case.spacings();
    let h = spacings.iter().fold(f64::INFINITY, |least, h| least.min(*h));
    SURFACE_CELL * PI * (particle.shape.diameter() / h).powi(spacings.len() as i32 - 1)
}

/// Work of the heaviest rank over the mean of all, by the number of ranks along each axis. A cut
/// across gravity counts as more than any other imbalance where free bodies settle or rise: they
/// all end on one side of it.
pub(super) fn imbalance<const D: usize>(case: &Case, ranks: [usize; D]) -> f64 {
    let Case { fluid, particle, .. } = case;
    let division = Division { cells: axes(&case.domain.cells), ranks };
    let spacings = case.spacings();
    let cell = |p: &Particle| -> [usize; D] {
        let along = |a: usize| (p.position[a] / spacings[a]).max(0.0) as usize;
        std::array::from_fn(|a| along(a).min(division.cells[a] - 1))
    };
    let gravity: [f64; D] = axes(&fluid.gravity);
    let uneven = division.imbalance(particle.iter().map(|p| (cell(p), surface_work(case, p))));
    let across = |a: usize| ranks[a] > 1 && gravity[a] != 0.0 && !case.periodic(a);
    let settles = |p: &Particle| p.is_free() && p.density() != fluid.density;
    if (0..D).any(across) && particle.iter().any(settles) {
        // The heaviest rank has the work of all ranks at most.
        return uneven + ranks.iter().product::<usize>() as f64;
    }
    uneven
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::read_case;
    use std::path::Path;

    #[test]
    fn division_of_settling_crowd_has_no_cut_across_gravity() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../cases/crowd/case.toml");
        let mut case = read_case(&path, &[]).unwrap().case;
        let of = |case: &Case| [[4, 1], [2, 2], [1, 4]].map(|ranks| imbalance(case, ranks));
        let [side_by_side, both, stacked] = of(&case);
        assert!(side_by_side < 1.15 && both > 5.0 && stacked > 5.0);
        // Bodies as heavy as the fluid stay where they are.
        let density = case.fluid.density;
        case.fluid.density = case.particle[0].density();
        assert!(of(&case).iter().all(|uneven| (1.0..1.3).contains(uneven)), "{:?}", of(&case));
        case.fluid.density = density;
        case.particle.clear();
        assert_eq!(of(&case), [1.0; 3]);
    }
}
