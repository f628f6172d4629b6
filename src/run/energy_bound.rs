//! Spurious energy gain: a flow whose budget shows that the method has made as much as it ever had
//! says nothing, and ends.
//!
//! ```text
//!   made  =  -min(method, 0) - min(contacts, 0) - min(friction, 0)
//!         >  start + |gravity| + |drive| + |boundaries| + |prescribed|
//!              of the budget ([`EnergyBudget`])
//! ```
//! and by more than a thousandth of what free bodies give in a fall of a spacing: no body is set
//! down just where it comes to rest. What these take is dissipation and grows; what they make, in
//! an unstable step, is soon orders of magnitude beyond this. The budget holds with moving walls,
//! inflows and prescribed bodies as well.

use crate::config::Case;
use crate::domain::Domain;
use crate::particles::Body;
use crate::state::{EnergyBudget, State};
use crate::{Error, Result};

/// Energy that rounding gives a scene at rest, over the mass of its bodies (J/kg).
const ROUNDING: f64 = 1e-12;

/// The part of a spacing to which the place of a body at rest is not known.
const SETTLING: f64 = 1e-3;

/// The part of all work from which on a spurious gain is worth a word.
const DOUBTFUL: f64 = 0.25;

/// The part of all work from which on the bound on the work of contacts is worth a word.
const WORTH_SAYING: f64 = 0.01;

/// The part of all work from which on what the method has lost is worth a word.
const MUCH_LOST: f64 = 0.25;

/// Energy that free bodies could give in a fall by `SETTLING` of a spacing (J).
pub(super) fn settling<const D: usize>(domain: &Domain<D>, bodies: &[Body]) -> f64 {
    let fluid = &domain.fluid;
    let h = domain.grid.h.iter().copied().fold(f64::INFINITY, f64::min);
    let free = bodies.iter().filter(|body| body.freedom().is_some());
    let submerged =
        free.map(|body| (body.mass() - fluid.density * body.volume()).abs()).sum::<f64>();
    SETTLING * h * submerged * fluid.gravity.norm()
}

/// Refuses a state whose energy the method has made, beyond `allowed` (J).
///
/// # Errors
/// With the budget, what gained most, and what to do.
pub(super) fn refuse_made<const D: usize>(s: &State<D>, allowed: f64) -> Result<()> {
    let e = &s.energy;
    let rounding = ROUNDING * s.bodies.iter().map(|body| body.mass()).sum::<f64>();
    let Made { energy, source } = Made::of(e);
    if energy <= e.scale() + rounding + allowed {
        return Ok(());
    }
    Err(Error::Run(format!(
        "energy balance violated: {energy:.3e} J gained, mostly by {}: {} {:.3e} J in all, where \
        the start, gravity, the drive, boundaries and prescribed bodies have given {:.3e} J; {}",
        source.0,
        richest(e, s),
        e.total(),
        e.supplied(),
        source.1
    )))
}

/// Warning, at the end of a run, of energy that the method has made beyond `allowed` (J), not
/// enough to refuse it.
pub(super) fn doubt<const D: usize>(s: &State<D>, allowed: f64) -> Option<String> {
    let rounding = ROUNDING * s.bodies.iter().map(|body| body.mass()).sum::<f64>();
    let Made { energy, source: (name, cure) } = Made::of(&s.energy);
    let put_in = s.energy.scale();
    (energy > DOUBTFUL * put_in + rounding + allowed).then(|| {
        let share = 100.0 * energy / put_in;
        format!(
            "warning: energy balance violated: {energy:.3e} J gained, mostly by {name}: {share:.0} \
            % of all that was put in (steps.csv has when); {cure}"
        )
    })
}

/// Note, at the end of a run, on the bound on the work of contacts.
pub(super) fn bounded<const D: usize>(s: &State<D>) -> Option<String> {
    let share = s.energy.bounded / s.energy.scale();
    (share > WORTH_SAYING).then(|| {
        format!(
            "note: the bound on the work of contacts took {:.3e} J from rebounds, {:.1} % of all \
            that was put in (bounded_energy in steps.csv): the fluid's response in them is far \
            from that of lone bodies; more cells or shorter steps resolve it better",
            s.energy.bounded,
            100.0 * share
        )
    })
}

/// Note, at the end of a run, on energy that the method has lost.
pub(super) fn lost<const D: usize>(case: &Case, s: &State<D>) -> Option<String> {
    let share = s.energy.losses.method / s.energy.scale();
    let cure =
        crate::check::thin_layer(case).unwrap_or_else(|| "more cells resolve it better".into());
    (share > MUCH_LOST).then(|| {
        format!(
            "note: the method lost {:.0} % of all energy that was put in (method_loss in \
            steps.csv), where the grid does not resolve the flow: {cure}; forces and speeds may be \
            off by more than the pages say",
            100.0 * share
        )
    })
}

/// Energy that the method has made.
struct Made {
    /// All of it (J).
    energy: f64,
    /// The largest source of it, and the cure, in words.
    source: (&'static str, &'static str),
}

impl Made {
    fn of(e: &EnergyBudget) -> Made {
        let sources = [
            (
                e.losses.method,
                (
                    "the step of the flow",
                    "take smaller cells, or shorter steps if bodies strike each other or a wall",
                ),
            ),
            (e.losses.contacts, ("contacts", "take shorter steps, or stiffer contacts")),
            (e.losses.friction, ("friction", "take shorter steps, or stiffer contacts")),
        ];
        let energy = sources.iter().map(|(lost, _)| -lost.min(0.0)).sum();
        let source = sources
            .into_iter()
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map_or(("", ""), |(_, source)| source);
        Made { energy, source }
    }
}

/// Words on whether bodies or the fluid have most of the energy.
fn richest<const D: usize>(e: &EnergyBudget, s: &State<D>) -> String {
    let speed = |k: &usize| s.bodies[*k].velocity.norm();
    let fastest = (0..s.bodies.len()).max_by(|a, b| speed(a).total_cmp(&speed(b)));
    match fastest.filter(|_| e.fluid < e.bodies.max(e.springs)) {
        Some(k) => {
            let name = s.bodies[k].called();
            format!("mostly bodies have it, {name} the fastest at {:.3e} m/s;", speed(&k))
        }
        None => "mostly the fluid has it;".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;
    use crate::petsc::{Layout, Session};
    use crate::state::{EnergyLosses, SuppliedWork};

    #[test]
    fn energy_gain_over_all_supplied_energy_is_refused() {
        let session = Session::start(&[]).unwrap();
        let layout = Layout::new(&session, &[8, 8], &[true, true], 3).unwrap();
        let grid = Grid::<2>::new([8, 8], [1.0, 1.0], [true, true], &layout);
        let mut s = State::new(&grid, Vec::new(), false);
        let judge = |s: &State<2>| refuse_made(s, 0.0).err().map(|e| e.to_string());
        s.energy = EnergyBudget {
            start: 1.0,
            work: SuppliedWork { boundaries: -2.0, ..SuppliedWork::default() },
            losses: EnergyLosses { method: -2.9, ..EnergyLosses::default() },
            fluid: 2.0,
            ..EnergyBudget::default()
        };
        assert_eq!(judge(&s), None);
        s.energy.losses.contacts = 5.0;
        assert_eq!(judge(&s), None, "what contacts take makes up for nothing, and is nothing made");
        assert!(
            doubt(&s, 0.0)
                .is_some_and(|said| said.contains("97 %") && said.contains("the step of the flow"))
        );
        s.energy.losses.method = -0.1;
        assert_eq!(doubt(&s, 0.0), None);
        s.energy.losses.method = -3.1;
        let said = judge(&s).unwrap();
        assert!(
            said.contains("3.100e0 J")
                && said.contains("the step of the flow")
                && said.contains("fluid"),
            "{said}"
        );
        s.energy.losses = EnergyLosses { method: 2.0, friction: -4.0, ..s.energy.losses };
        assert!(judge(&s).unwrap().contains("friction"));
    }
}
