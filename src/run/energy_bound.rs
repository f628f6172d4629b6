//! Energy from nothing: a flow whose budget shows that the method has made as much as it ever had says nothing, and ends.
//!
//! ```text
//!   -method  >  start + |gravity| + |borders| + |prescribed|       of the budget ([`EnergyBudget`])
//! ```
//! What the method takes is dissipation and grows; what it makes, in an unstable step, is soon orders of magnitude beyond this. The
//! budget holds with moving walls, inflows and prescribed bodies as well.

use crate::state::{EnergyBudget, State};
use crate::{Error, Result};

/// What rounding makes of a scene at rest (J, of all that its bodies could have at 1 m/s).
const ROUNDING: f64 = 1e-12;

/// Refuses a state whose energy the method has made.
///
/// # Errors
/// With the budget, what gained most, and what to do.
pub(super) fn refuse_made<const D: usize>(s: &State<D>) -> Result<()> {
    let e = &s.energy;
    let rounding = ROUNDING * s.bodies.iter().map(|body| body.mass()).sum::<f64>();
    if -e.method <= e.scale() + rounding {
        return Ok(());
    }
    Err(Error::Run(format!(
        "{:.3e} J have come from nothing: {} has {:.3e} J; the start, gravity, the borders and prescribed bodies have given \
         {:.3e} J; the step is unstable here: take shorter steps, stiffer contacts or other cells",
        -e.method,
        richest(e, s),
        e.total(),
        e.start + e.gravity + e.borders + e.prescribed,
    )))
}

/// What has most of the energy, in words.
fn richest<const D: usize>(e: &EnergyBudget, s: &State<D>) -> String {
    if e.fluid >= e.bodies.max(e.springs) {
        return "the flow, fluid first,".into();
    }
    let speed = |k: &usize| s.bodies[*k].velocity.norm();
    let fastest = (0..s.bodies.len()).max_by(|a, b| speed(a).total_cmp(&speed(b)));
    let what = if e.bodies >= e.springs { "the bodies" } else { "the springs of contacts" };
    match fastest {
        Some(k) => format!("what moves, {what} first, particle {k} the fastest at {:.3e} m/s,", speed(&k)),
        None => format!("what moves, {what} first,"),
    }
}
