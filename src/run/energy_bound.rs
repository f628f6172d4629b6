//! Energy from nothing: a flow whose budget shows that the method has made as much as it ever had says nothing, and ends.
//!
//! ```text
//!   made  =  -min(method, 0) - min(contacts, 0) - min(friction, 0)
//!         >  start + |gravity| + |drive| + |borders| + |prescribed|                 of the budget ([`EnergyBudget`])
//! ```
//! and by more than a thousandth of what free bodies give in a fall of a spacing: no body is set down just where it comes to rest.
//! What these take is dissipation and grows; what they make, in an unstable step, is soon orders of magnitude beyond this. The
//! budget holds with moving walls, inflows and prescribed bodies as well.

use crate::domain::Domain;
use crate::particles::Body;
use crate::state::{EnergyBudget, State};
use crate::{Error, Result};

/// What rounding makes of a scene at rest (J, of all that its bodies could have at 1 m/s).
const ROUNDING: f64 = 1e-12;

/// The part of a fall by a spacing that a body's place cannot be known to.
const SETTLING: f64 = 1e-3;

/// What free bodies could give in such a fall (J).
pub(super) fn settling<const D: usize>(domain: &Domain<D>, bodies: &[Body]) -> f64 {
    let (fluid, h) = (&domain.fluid, domain.grid.h.iter().copied().fold(f64::INFINITY, f64::min));
    let free = bodies.iter().filter(|body| body.freedom().is_some());
    let submerged = free.map(|body| (body.mass() - fluid.density * body.volume()).abs()).sum::<f64>();
    SETTLING * h * submerged * fluid.gravity.norm()
}

/// Refuses a state whose energy the method has made, beyond `allowed` (J).
///
/// # Errors
/// With the budget, what gained most, and what to do.
pub(super) fn refuse_made<const D: usize>(s: &State<D>, allowed: f64) -> Result<()> {
    let e = &s.energy;
    let rounding = ROUNDING * s.bodies.iter().map(|body| body.mass()).sum::<f64>();
    let sources = [("the step of the flow", e.method), ("contacts", e.contacts), ("friction", e.friction)];
    let made = sources.iter().map(|(_, lost)| -lost.min(0.0)).sum::<f64>();
    if made <= e.scale() + rounding + allowed {
        return Ok(());
    }
    let source = sources.iter().min_by(|a, b| a.1.total_cmp(&b.1)).map_or("", |source| source.0);
    Err(Error::Run(format!(
        "{made:.3e} J have come from nothing, made by {source}: {} {:.3e} J in all, where the start, gravity, the drive, borders and \
         prescribed bodies have given {:.3e} J; take shorter steps, stiffer contacts or other cells",
        richest(e, s),
        e.total(),
        e.start + e.gravity + e.drive + e.borders + e.prescribed,
    )))
}

/// What has most of the energy, in words.
fn richest<const D: usize>(e: &EnergyBudget, s: &State<D>) -> String {
    let speed = |k: &usize| s.bodies[*k].velocity.norm();
    let fastest = (0..s.bodies.len()).max_by(|a, b| speed(a).total_cmp(&speed(b)));
    match fastest.filter(|_| e.fluid < e.bodies.max(e.springs)) {
        Some(k) => format!("mostly bodies have it, particle {k} the fastest at {:.3e} m/s;", speed(&k)),
        None => "mostly the fluid has it;".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;
    use crate::petsc::{Layout, Session};

    #[test]
    fn what_is_made_is_refused_once_it_is_as_much_as_there_ever_was() {
        let session = Session::start(&[]).unwrap();
        let layout = Layout::new(&session, &[8, 8], &[true, true], 3).unwrap();
        let grid = Grid::<2>::new([8, 8], [1.0, 1.0], [true, true], &layout);
        let mut s = State::new(&grid, Vec::new(), false);
        let judge = |s: &State<2>| refuse_made(s, 0.0).err().map(|e| e.to_string());
        s.energy = EnergyBudget { start: 1.0, borders: -2.0, method: -2.9, fluid: 2.0, ..EnergyBudget::default() };
        assert_eq!(judge(&s), None);
        s.energy.contacts = 5.0;
        assert_eq!(judge(&s), None, "what contacts take makes up for nothing, and is nothing made");
        s.energy.method = -3.1;
        let said = judge(&s).unwrap();
        assert!(
            said.contains("3.100e0 J") && said.contains("the step of the flow") && said.contains("fluid"),
            "{said}"
        );
        (s.energy.method, s.energy.friction) = (2.0, -4.0);
        assert!(judge(&s).unwrap().contains("friction"));
    }
}
