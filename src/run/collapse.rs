//! Steps that shrink to nothing: a run whose steps have been shorter than a thousandth of what they
//! were for a hundred steps goes nowhere, and says so.

use crate::particles::{Body, gap, nearest_image};
use crate::{Error, Result};

/// Part of the first or of the usual step, and the steps below it, that end a run.
const LEAST: f64 = 1e-3;
const PATIENCE: u32 = 100;
/// How fast the usual step follows: about the median's place among the last thousand.
const FOLLOW: f64 = 5e-3;

/// The lengths of the steps so far.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Collapse {
    first: f64,
    usual: f64,
    short: u32,
}

impl Collapse {
    /// Takes the step `dt` (s).
    ///
    /// # Errors
    /// When it was one too many that was too short, with the two bodies nearest to each other or to
    /// a wall.
    pub(super) fn take(
        &mut self,
        dt: f64,
        bodies: &[Body],
        size: &[f64],
        periods: &[Option<f64>; 3],
    ) -> Result<()> {
        if self.first == 0.0 {
            (self.first, self.usual) = (dt, dt);
        }
        // A step up or down by a share each time settles where half of them are longer.
        self.usual *= if dt > self.usual { 1.0 + FOLLOW } else { 1.0 - FOLLOW };
        self.short = if dt < LEAST * self.first.max(self.usual) { self.short + 1 } else { 0 };
        if self.short < PATIENCE {
            return Ok(());
        }
        Err(Error::Run(format!(
            "the steps have been {dt:.1e} s and shorter for {PATIENCE} steps, where the first was \
            {:.1e} s: nothing moves on any more; {} let contacts begin more softly \
            (contact.normal_stiffness = \"auto\"), keep what is prescribed from squeezing the \
            rest, or shorten time.cfl",
            self.first,
            nearest(bodies, size, periods)
        )))
    }
}

/// The two nearest, in words.
fn nearest(bodies: &[Body], size: &[f64], periods: &[Option<f64>; 3]) -> String {
    let mut found = (f64::INFINITY, String::new());
    let said = |body: &Body, other: &str, gap: f64| {
        format!("{} and {other} are nearest, with a gap of {gap:.2e} m;", body.called())
    };
    for (i, body) in bodies.iter().enumerate().filter(|(_, body)| !body.is_obstacle()) {
        for other in bodies[i + 1..].iter() {
            let apart = nearest_image(&body.centre, &other.centre, periods);
            let spheres = || apart.norm() - body.radius() - other.radius();
            let gap = if other.is_obstacle() { gap(body, other, &apart).1 } else { spheres() };
            if gap < found.0 {
                found = (gap, said(body, &other.called(), gap));
            }
        }
        for (a, size) in size.iter().enumerate().filter(|(a, _)| periods[*a].is_none()) {
            let gap = body.centre[a].min(size - body.centre[a]) - body.radius();
            if gap < found.0 {
                found = (gap, said(body, "a wall", gap));
            }
        }
    }
    found.1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn collapsed_step_length_ends_run() {
        let mut collapse = Collapse::default();
        let mut take = |dt| collapse.take(dt, &[], &[], &[None; 3]);
        assert!((0..10).all(|_| take(1.0).is_ok()));
        assert!((0..99).all(|_| take(5e-4).is_ok()));
        assert!(take(1.0).is_ok());
        assert!((0..99).all(|_| take(5e-4).is_ok()));
        assert!(take(5e-4).unwrap_err().to_string().contains("shorter for 100 steps"));
    }
}
