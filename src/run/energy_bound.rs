//! The energy that a closed scene can have: a flow that has more of it has come from an unstable step, and says nothing.
//!
//! ```text
//!   E  <=  E_0 + sum_k [ max(rho_k - rho, 0) V_k (V^2 + (r omega)^2)/2 + (rho_k + rho) V_k sum_a |g_a| L_a ]
//! ```
//! with the fluid's energy E_0 at the start, free particles' velocity V and spin omega there, volume V_k, and the box's lengths
//! L_a: a particle that falls the whole way. Generous, and what an unstable step gives is orders of magnitude beyond.

use crate::config::{Case, Motion, Particle, Side};
use crate::{Error, Result};
use std::f64::consts::PI;

/// How much more than this is refused.
const MARGIN: f64 = 2.0;

/// What particles and gravity can give to the fluid (J; per metre of depth in 2D). None where borders or prescribed particles
/// do work on it, or gravity can do so for ever.
pub(super) fn of_particles(case: &Case) -> Option<f64> {
    let idle = |(_, side): (&str, &Side)| matches!(side, Side::Wall | Side::Slip | Side::Periodic);
    if !case.sides().all(idle) {
        return None;
    }
    let mut fall = 0.0;
    for (axis, (g, size)) in
        case.fluid.gravity.iter().zip(&case.domain.size).enumerate().filter(|(_, (g, _))| **g != 0.0)
    {
        if case.periodic(axis) {
            return None;
        }
        fall += g.abs() * size;
    }
    case.particle.iter().map(|p| of_particle(p, case.fluid.density, case.dimension(), fall)).sum()
}

/// Of one particle, which gravity can give `fall` (J/kg).
fn of_particle(p: &Particle, fluid: f64, dimension: usize, fall: f64) -> Option<f64> {
    let (velocity, spin) = match &p.motion {
        Motion::Fixed => return Some(0.0),
        Motion::Free { velocity, spin, locked } if locked.is_empty() => (velocity, spin),
        Motion::Free { .. } | Motion::Prescribed { .. } => return None,
    };
    let r = 0.5 * p.shape.diameter();
    let volume = if dimension == 2 { PI * r * r } else { 4.0 / 3.0 * PI * r.powi(3) };
    let square = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>();
    let motion = 0.5 * (square(velocity) + r * r * square(spin));
    Some(volume * ((p.density - fluid).max(0.0) * motion + (p.density + fluid) * fall))
}

/// Refuses an `energy` (J) far beyond what the `start` (J) and particles can have given.
///
/// # Errors
/// With both and what to do.
pub(super) fn refuse_beyond(energy: f64, start: Option<f64>, given: Option<f64>) -> Result<()> {
    let (Some(start), Some(given)) = (start, given) else { return Ok(()) };
    let most = start + given;
    // What is at rest for ever has its rounding.
    if energy <= MARGIN * most || most == 0.0 {
        return Ok(());
    }
    Err(Error::Run(format!(
        "the kinetic energy is {energy:.3e} J, and the start and gravity can have given {most:.3e} J at most: the step is \
         unstable here; take shorter steps, stiffer contacts or other cells"
    )))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::written;

    fn given(more: &str) -> Option<f64> {
        let text = format!(
            "name = \"box\"\ntime.end = 1.0\ndomain = {{ size = [4.0, 2.0], cells = [32, 16] }}\n\
             fluid = {{ density = 1.0, viscosity = 0.1, gravity = [0.0, -5.0] }}\n{more}"
        );
        of_particles(&written(&text).unwrap())
    }

    const SIDES: &str = "[boundary]\neast = \"periodic\"\nwest = \"periodic\"\nsouth = \"wall\"\nnorth = \"slip\"\n";

    #[test]
    fn a_closed_box_has_the_energy_of_its_particles_and_their_fall_and_an_open_one_any() {
        let disc = |more: &str| {
            format!("{SIDES}[[particle]]\nshape = {{ disc = {{ diameter = 2.0 }} }}\nposition = [1.0, 1.0]\n{more}")
        };
        let free = disc("density = 3.0\nvelocity = [3.0, 4.0]\nspin = 2.0");
        assert!((given(&free).unwrap() - PI * (2.0 * 0.5 * (25.0 + 4.0) + 4.0 * 10.0)).abs() < 1e-12);
        assert_eq!(given(SIDES), Some(0.0));
        assert_eq!(given(&disc("motion = \"fixed\"")), Some(0.0));
        assert_eq!(given(&disc("motion = { prescribed = { spin = 1.0 } }")), None);
        assert_eq!(given(&disc("locked = [\"x\"]")), None);
        for (from, to) in [("\"slip\"", "{ moving_wall = [1.0, 0.0] }"), ("\"slip\"", "\"outflow\"")] {
            assert_eq!(given(&free.replace(from, to)), None);
        }
        let all_round = SIDES.replace("\"wall\"", "\"periodic\"").replace("\"slip\"", "\"periodic\"");
        assert_eq!(given(&all_round), None, "it can fall for ever");
    }

    #[test]
    fn an_energy_that_nothing_gave_is_refused_with_its_numbers() {
        assert!(refuse_beyond(5.9, Some(1.0), Some(2.0)).is_ok());
        assert!(refuse_beyond(1e9, Some(1.0), None).is_ok());
        let said = refuse_beyond(6.1, Some(1.0), Some(2.0)).unwrap_err().to_string();
        assert!(said.contains("6.100e0 J") && said.contains("3.000e0 J at most"), "{said}");
    }
}
