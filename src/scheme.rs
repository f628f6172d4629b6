//! The time schemes and how far they are stable.
//!
//! For a wave of phase angles `theta_a` a stage multiplies by `z = C g(theta) - r sum (1 - cos
//! theta_a)`, with C the Courant number (sum over axes; for QSI their largest), r the step over the
//! limit of Euler's diffusion, g the symbol of the advection; the step multiplies by the scheme's
//! polynomial of z. Upwind differences damp as well, `Re g(pi) = -16/15`, so that advection and
//! diffusion share one stability limit:
//!
//! ```text
//!  C <= C_max    and    r/limit + share C <= 1    and, for Euler with upwind5,    min_a r_a >= C^2
//! ```
//! A test below scans the symbols: within these limits no wave grows by more than 0.1 % a step, and
//! none at all where viscosity damps it a little.

pub mod legendre;

use std::fmt;

/// A Runge-Kutta scheme whose stages are built from the weighted sum of the rates so far.
#[derive(Clone, Copy, Debug)]
pub struct Scheme {
    /// Weight of each stage's rate in the step.
    pub weights: &'static [f64],
    /// For each stage after the first: factors of the weighted sum so far and of the pressure's
    /// acceleration.
    pub stages: &'static [(f64, f64)],
    /// Whether the carrying velocity is taken at the middle of the step.
    pub centred: bool,
    /// Whether the Courant number is the largest over the axes (advection goes axis by axis), not
    /// their sum.
    pub by_axis: bool,
    /// Largest Courant number.
    courant_limit: f64,
    /// Stability limit on the negative real axis, over Euler's.
    diffusion_limit: f64,
    /// Part of that limit that advection takes at a Courant number of 1.
    share: f64,
    /// Whether advection amplifies what viscosity does not damp.
    needs_viscosity: bool,
    /// Most stages of [`legendre::Legendre`] where viscosity asks for more stages than these.
    pub most_stages: Option<usize>,
}

/// Part of the limit of diffusion that upwind advection takes at a Courant number of 1.
const UPWIND_SHARE: f64 = 8.0 / 15.0;

/// One stage with upwind advection.
const ONE_STAGE: Scheme = Scheme {
    weights: &[1.0],
    stages: &[],
    centred: false,
    by_axis: false,
    courant_limit: 0.25,
    diffusion_limit: 1.0,
    share: UPWIND_SHARE,
    needs_viscosity: true,
    most_stages: None,
};

/// Euler (the paper's) with upwind advection.
pub static EULER: Scheme = ONE_STAGE;

/// Euler with QSI, whose foot of a path stays within one cell.
pub static QSI: Scheme =
    Scheme { by_axis: true, courant_limit: 0.9, share: 1.36, needs_viscosity: false, ..ONE_STAGE };

/// Second order, strong-stability preserving.
pub static RK2: Scheme = Scheme {
    weights: &[0.5, 0.5],
    stages: &[(2.0, 1.0)],
    centred: true,
    by_axis: false,
    courant_limit: 0.5,
    diffusion_limit: 1.0,
    share: UPWIND_SHARE,
    needs_viscosity: false,
    most_stages: None,
};

/// Three stages, strong-stability preserving.
pub static RK3: Scheme = Scheme {
    weights: &[1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0],
    stages: &[(6.0, 1.0), (1.5, 0.5)],
    centred: true,
    by_axis: false,
    courant_limit: 1.2,
    diffusion_limit: 1.25,
    share: UPWIND_SHARE,
    needs_viscosity: false,
    most_stages: None,
};

/// That part in Legendre stages: little of the far end of their limit is left to advection.
const LEGENDRE_SHARE: f64 = 0.2;

impl Scheme {
    /// The scheme with up to `most` Legendre stages where viscosity asks for them: more than it has
    /// itself, or it stays as it is.
    pub fn stabilised(self, most: usize) -> Scheme {
        Scheme { most_stages: (most > self.weights.len()).then_some(most), ..self }
    }

    /// The scheme without stages that viscosity asks for.
    pub fn explicit(&self) -> Scheme {
        Scheme { most_stages: None, ..*self }
    }

    /// The scheme with the limits of its longest steps of Legendre stages: where advection binds,
    /// those of [`RK2`].
    fn long(&self) -> Option<Scheme> {
        let diffusion_limit = legendre::limit(self.most_stages?);
        let courant_limit = RK2.courant_limit;
        Some(Scheme {
            courant_limit,
            diffusion_limit,
            share: LEGENDRE_SHARE,
            most_stages: None,
            ..*self
        })
    }

    /// Number of stages that a step of so many times the limit of Euler's diffusion needs: its own
    /// up to where these would hold at the Courant number of Legendre stages.
    pub fn stages_for(&self, diffusion: f64) -> usize {
        let holds =
            |limit: f64, share: f64| diffusion / limit + share * RK2.courant_limit <= 1.0 + 1e-9;
        let own = self.weights.len();
        match self.most_stages {
            Some(most) if !holds(self.diffusion_limit, self.share) => {
                (own + 1..most).find(|s| holds(legendre::limit(*s), LEGENDRE_SHARE)).unwrap_or(most)
            }
            _ => own,
        }
    }

    /// Largest Courant number.
    pub fn courant_limit(&self) -> f64 {
        self.courant_limit
    }
}

/// Bound of the time step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bound {
    /// This Courant number.
    Advection(f64),
    /// Explicit diffusion, beside the advection.
    Diffusion,
    /// Euler steps amplify upwind advection where viscosity damps too little.
    Undamped,
}

impl fmt::Display for Bound {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Bound::Advection(limit) => write!(f, "advection limit (Courant number {limit})"),
            Bound::Diffusion => {
                write!(f, "diffusion limit (explicit diffusion beside advection on this grid)")
            }
            Bound::Undamped => {
                write!(f, "limit of Euler steps with upwind advection (viscosity must damp them)")
            }
        }
    }
}

/// Rates at which the time step's limits are used up, at the present velocities.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Courant number per second (1/s).
    pub courant_rate: f64,
    /// One over the limit of explicit Euler diffusion (1/s); zero where nothing diffuses.
    pub diffusion_rate: f64,
    /// The fluid's part of it along the axis where it is least (1/s): what damps waves along that
    /// axis.
    pub damping_rate: f64,
    /// Largest growth of the Courant rate (1/s2) by gravity on free particles and by forces.
    pub courant_growth: f64,
    /// The scheme that steps.
    pub scheme: Scheme,
}

impl Limits {
    /// The step (s) at whose end the Courant number is at most `cfl`; infinite where nothing moves.
    pub fn step_for(&self, cfl: f64) -> f64 {
        let rate = self.courant_rate;
        2.0 * cfl / (rate + (rate * rate + 4.0 * cfl * self.courant_growth).sqrt())
    }

    /// These limits for steps of the scheme's own stages, and for those of Legendre stages.
    pub fn ranges(&self) -> impl Iterator<Item = Limits> {
        let with = |scheme| Limits { scheme, ..*self };
        std::iter::once(with(self.scheme.explicit())).chain(self.scheme.long().map(with))
    }

    /// Each bound with its step (s), in the stages that allow the longer one; infinite where
    /// nothing moves or diffuses.
    pub fn bounds(&self) -> [(Bound, f64); 3] {
        let least = |bounds: &[(Bound, f64); 3]| {
            bounds.iter().map(|bound| bound.1).fold(f64::INFINITY, f64::min)
        };
        let ranges = self.ranges().map(|range| range.own_bounds());
        let longest = ranges
            .reduce(|first, second| if least(&second) > least(&first) { second } else { first });
        longest.unwrap_or_else(|| self.own_bounds())
    }

    fn own_bounds(&self) -> [(Bound, f64); 3] {
        let a = self.courant_rate;
        let b = self.diffusion_rate;
        let s = self.scheme;
        let undamped =
            if s.needs_viscosity && a > 0.0 { self.damping_rate / (a * a) } else { f64::INFINITY };
        [
            (Bound::Advection(s.courant_limit), s.courant_limit / a),
            (
                Bound::Diffusion,
                if b > 0.0 { 1.0 / (b / s.diffusion_limit + s.share * a) } else { f64::INFINITY },
            ),
            (Bound::Undamped, undamped),
        ]
    }

    /// The bound that binds, and its step (s).
    pub fn tightest(&self) -> (Bound, f64) {
        let [first, rest @ ..] = self.bounds();
        rest.into_iter().fold(first, |least, bound| if bound.1 < least.1 { bound } else { least })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::advection::{qsi_symbol, upwind5_symbol};
    use nalgebra::Complex;
    use std::f64::consts::PI;

    /// Largest amplification of any wave over a step with Courant numbers `c` and diffusion parts
    /// `r` along two axes.
    fn amplification(scheme: &Scheme, qsi: bool, c: [f64; 2], r: [f64; 2]) -> f64 {
        let one = Complex::new(1.0, 0.0);
        let count = scheme.stages_for(r[0] + r[1]);
        let stages = (count > scheme.weights.len()).then(|| legendre::Legendre::new(count).stages);
        let angles = || (0..=64).map(|k| PI * f64::from(k) / 64.0);
        let step = |x: f64, y: f64| {
            let damping = r[0] * (1.0 - x.cos()) + r[1] * (1.0 - y.cos());
            if qsi {
                return qsi_symbol(c[0], x) * qsi_symbol(c[1], y) - damping;
            }
            let z = upwind5_symbol(x) * c[0] + upwind5_symbol(y) * c[1] - damping;
            if let Some(stages) = &stages {
                let mut last = one;
                let mut before = one;
                for stage in stages {
                    let rates = z * (last * stage.rate + stage.first);
                    let next = last * stage.last + before * stage.before + rates + stage.start;
                    before = last;
                    last = next;
                }
                return last;
            }
            match scheme.weights.len() {
                1 => one + z,
                2 => one + z + z * z / 2.0,
                _ => one + z + z * z / 2.0 + z * z * z / 6.0,
            }
        };
        angles()
            .flat_map(|x| angles().map(move |y| (x, y)))
            .map(|(x, y)| step(x, y).norm())
            .fold(0.0, f64::max)
    }

    #[test]
    fn stability_limits_by_von_neumann_analysis() {
        let legendre = [(RK2, 3), (RK2, 4), (RK2, 12), (RK3, 3), (RK3, 4), (RK3, 10)]
            .map(|(own, most)| own.stabilised(most));
        for (name, scheme, qsi) in [
            ("euler", &EULER, false),
            ("rk2", &RK2, false),
            ("rk3", &RK3, false),
            ("qsi", &QSI, true),
        ]
        .into_iter()
        .chain(legendre.iter().map(|scheme| ("legendre", scheme, false)))
        {
            // Advection and diffusion in all proportions, along one axis, both, or one each.
            for ratio in [0.0, 1e-3, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 1e3] {
                if ratio == 0.0 && scheme.needs_viscosity {
                    continue;
                }
                let shares = [(1.0, 1.0), (0.5, 0.5), (1.0, 0.5), (0.7, 0.3), (0.3, 1.0)];
                for (c, r) in shares {
                    let r: [f64; 2] = [r * ratio, (1.0 - r) * ratio];
                    let least = if scheme.needs_viscosity { f64::min(r[0], r[1]) } else { 0.0 };
                    let limits = Limits {
                        courant_rate: 1.0,
                        diffusion_rate: ratio,
                        damping_rate: least,
                        courant_growth: 0.0,
                        scheme: *scheme,
                    };
                    let (bound, dt) = limits.tightest();
                    let c = if qsi { [1.0, (2.0_f64 - 2.0 * c).min(1.0)] } else { [c, 1.0 - c] };
                    let grows =
                        |dt: f64| amplification(scheme, qsi, c.map(|c| c * dt), r.map(|r| r * dt));
                    let here = grows(dt);
                    assert!(
                        here < 1.0012,
                        "{name}, r/C = {ratio}, {c:?} {r:?}: {here} at {bound} {dt}"
                    );
                    // QSI alone has no limit but its stencil's; tiny steps amplify little however
                    // unstable they are; and the worst proportions set the limit for all.
                    let own = scheme.most_stages.is_none() || bound == Bound::Diffusion;
                    if !qsi && own && dt > 0.05 && c[0] == 1.0 && r[0] <= 0.5 * ratio {
                        let beyond = grows(2.5 * dt);
                        assert!(
                            beyond > 1.005,
                            "{name}, r/C = {ratio}: {beyond} far over {bound} {dt}: limit too low"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn first_step_of_body_falling_from_rest() {
        let limits = Limits {
            courant_rate: 0.0,
            diffusion_rate: 0.0,
            damping_rate: 0.0,
            courant_growth: 10.0,
            scheme: RK2,
        };
        let dt = limits.step_for(0.4);
        assert!((10.0 * dt * dt - 0.4).abs() < 1e-12, "{dt}");
        assert_eq!(Limits { courant_rate: 2.0, courant_growth: 0.0, ..limits }.step_for(0.4), 0.2);
    }

    #[test]
    fn step_limit_is_the_smallest_bound() {
        let limits = |a, b, scheme: &Scheme| {
            Limits {
                courant_rate: a,
                diffusion_rate: b,
                damping_rate: 0.5 * b,
                courant_growth: 0.0,
                scheme: *scheme,
            }
            .tightest()
        };
        assert_eq!(limits(1.0, 0.0, &RK2), (Bound::Advection(0.5), 0.5));
        assert_eq!(limits(0.0, 4.0, &RK2), (Bound::Diffusion, 0.25));
        assert_eq!(limits(1.0, 0.1, &EULER), (Bound::Undamped, 0.05));
        assert_eq!(limits(0.0, 0.0, &RK3).1, f64::INFINITY);
    }
}
