//! The length of a step: what the case asks for, what stability allows, and no step that stands out
//! at the end.

use crate::Result;
use crate::config::{Case, Loaded, Step};
use crate::numerics::{LIMIT_SHARE, STEP_GROWTH};
use crate::scheme::{Bound, Limits, RK3};
use std::fmt;
/// Steps at the end of a run that keep one length.
const LAST_STEPS: f64 = 50.0;

/// Refuses a step, or a Courant number to choose steps by, that breaks a limit.
pub fn check_step(loaded: &Loaded, limits: &Limits) -> Result<()> {
    let (bound, limit) = limits.tightest();
    let largest = limits.scheme.courant_limit();
    match loaded.case.time.length() {
        Step::Fixed(step) if step > limit => Err(loaded.error_at(
            "time.step",
            format!(
                "{step} s is over the {bound}, {limit:.4e} s; give a smaller step, or time.cfl \
                instead"
            ),
        )),
        Step::Courant(number) if number > largest => {
            let cure =
                if largest < RK3.courant_limit() { " or choose time.scheme = \"rk3\"" } else { "" };
            let message = format!(
                "{number} is over the limit of this scheme, a Courant number of {largest}; \
                    lower it{cure}"
            );
            Err(loaded.error_at("time.cfl", message))
        }
        _ => Ok(()),
    }
}

/// Reason for the length of a time step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Choice {
    /// `time.step`.
    Given,
    /// `time.cfl`.
    CourantNumber,
    /// [`LIMIT_SHARE`] of a stability limit.
    Limit(Bound),
    /// A run has ten steps at least.
    TenthOfRun,
    /// A step grows slowly from the one before.
    Growth,
}

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Choice::Given => write!(f, "given"),
            Choice::CourantNumber => write!(f, "by time.cfl"),
            Choice::Limit(bound) => write!(f, "by {LIMIT_SHARE} of the {bound}"),
            Choice::TenthOfRun => write!(f, "a tenth of the run, since nothing limits it yet"),
            Choice::Growth => write!(f, "by its growth from the step before"),
        }
    }
}

/// The next step (s) and what chose it. Where `time.cfl` chooses, what is left is cut into equal
/// steps, and the last 50 keep one length: the force of the mixing depends on dt, and a last step
/// of its own would show as a spike. A fixed step stays as it is, and the run ends at or after
/// `time.end`. The first step is as short as without further stages for viscosity: what has just
/// been let go is resolved.
pub fn choose_step(case: &Case, limits: &Limits, before: Option<f64>, left: f64) -> (f64, Choice) {
    let courant = match case.time.length() {
        Step::Fixed(step) => return (step, Choice::Given),
        Step::Courant(number) => number,
    };
    let limits = &match before {
        None => Limits { scheme: limits.scheme.explicit(), ..*limits },
        Some(_) => *limits,
    };
    let others = [
        (Choice::TenthOfRun, case.time.end / 10.0),
        (Choice::Growth, before.map_or(f64::INFINITY, |b| STEP_GROWTH * b)),
    ];
    let least = |a: (Choice, f64), b: (Choice, f64)| if b.1 < a.1 { b } else { a };
    let most = |a: (Choice, f64), b: (Choice, f64)| if b.1 > a.1 { b } else { a };
    let ranges =
        limits.ranges().filter_map(|range| shares(&range, courant).into_iter().reduce(least));
    let (choice, wanted) =
        ranges.reduce(most).into_iter().chain(others).reduce(least).unwrap_or(others[0]);
    if let Some(before) = before {
        let count = (left / before).round().max(1.0);
        let kept = left / count;
        if count <= LAST_STEPS && kept <= (1.05 * wanted).min(limits.tightest().1) {
            return (kept, choice);
        }
    }
    (left / (left / wanted * (1.0 - 1e-9)).ceil().max(1.0), choice)
}

/// Longest step (s) by each bound of one kind of stages, where steps go by a Courant number.
fn shares(limits: &Limits, courant: f64) -> [(Choice, f64); 3] {
    limits.bounds().map(|(bound, dt)| match bound {
        Bound::Advection(most) if courant > most => {
            (Choice::Limit(bound), limits.step_for(LIMIT_SHARE * most))
        }
        Bound::Advection(_) => (Choice::CourantNumber, limits.step_for(courant)),
        _ => (Choice::Limit(bound), LIMIT_SHARE * dt),
    })
}
