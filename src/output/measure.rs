//! Measures: numbers that a run reports, each from a series of samples in time.

use super::compare::Comparison;
use super::midline;
use super::snapshot::Snapshot;
use crate::Result;
use crate::case::{Case, ForceRule, Measure, MeasureKind};
use crate::coupling::Exchange;
use crate::solids::{Body, Motion, Oscillation};
use crate::tape::{Lasting, Tape};
use nalgebra::{Matrix2, Vector2, Vector3};
use std::f64::consts::PI;

/// A measure and its samples so far.
pub struct Series {
    measure: Measure,
    rule: ForceRule,
    /// Force (N) of a coefficient of 1.
    force_scale: f64,
    /// Reference speed over diameter (1/s).
    rate: f64,
    samples: Vec<(f64, f64)>,
    morison: Morison,
    /// What the newest snapshot gave.
    midline: Option<f64>,
    /// Time of the step before (s).
    before: f64,
}

/// Sums of a least-squares fit of `F = -C_D 0.5 rho S |U| U - C_M rho V dU/dt`.
#[derive(Default)]
struct Morison {
    /// `0.5 rho S` (kg/m) and `rho V` (kg).
    scales: [f64; 2],
    products: Matrix2<f64>,
    forces: Vector2<f64>,
}

impl Morison {
    /// Takes the mean force (N) over a step `dt` (s) that ends on `path` now.
    fn add(&mut self, path: &Oscillation, force: &Vector3<f64>, dt: f64) {
        let middle = Oscillation { time: path.time - 0.5 * dt, ..*path };
        let Some(along) = path.amplitude.try_normalize(0.0) else { return };
        let (speed, rate) = (middle.velocity().dot(&along), middle.acceleration().dot(&along));
        let terms = Vector2::new(-self.scales[0] * speed.abs() * speed, -self.scales[1] * rate);
        self.products += dt * terms * terms.transpose();
        self.forces += dt * force.dot(&along) * terms;
    }

    /// `C_D` and `C_M`; `None` where the samples do not tell them apart.
    fn coefficients(&self) -> Option<Vector2<f64>> {
        Some(self.products.cholesky()?.solve(&self.forces))
    }
}

/// One series for each measure of the case.
pub fn series(case: &Case) -> Vec<Series> {
    let of = |m: &Measure| {
        let speed = m.speed.or(case.reference_speed()).unwrap_or(1.0);
        let diameter = case.particle.get(m.particle).map_or(1.0, |p| p.shape.diameter());
        let circle = 0.25 * PI * diameter * diameter;
        let (area, volume) =
            if case.dimension() == 2 { (diameter, circle) } else { (circle, 2.0 / 3.0 * diameter * circle) };
        let density = case.fluid.density;
        Series {
            morison: Morison { scales: [0.5 * density * area, density * volume], ..Morison::default() },
            before: 0.0,
            midline: None,
            rule: m.force.unwrap_or(case.coupling.force),
            force_scale: 0.5 * density * speed * speed * area,
            rate: speed / diameter,
            samples: Vec::new(),
            measure: m.clone(),
        }
    };
    case.measure.iter().map(of).collect()
}

impl Series {
    /// The measure's name.
    pub fn name(&self) -> &str {
        &self.measure.name
    }

    /// The value so far beside the measure's reference; `None` where the measure has none.
    pub fn comparison(&self) -> Option<Comparison> {
        Comparison::of(&self.measure, self.value())
    }

    /// Takes what the fields of the whole grid give.
    pub fn take_fields(&mut self, snapshot: &Snapshot) {
        self.midline = midline::extremum(self.measure.kind, snapshot);
    }

    /// Takes the state after a step: the time (s), what each particle exchanged, the particles, the largest speed of the
    /// fluid (m/s).
    pub fn sample(&mut self, time: f64, exchange: &[Exchange], bodies: &[Body], max_speed: f64) {
        let dt = time - std::mem::replace(&mut self.before, time);
        if time < self.measure.from {
            return;
        }
        let particle = self.measure.particle;
        let force = exchange.get(particle).map_or_else(Vector3::zeros, |e| match self.rule {
            ForceRule::Momentum => e.momentum,
            ForceRule::Literal => e.literal(),
        });
        let coefficient = |axis: usize| force[axis] / self.force_scale;
        if let (true, Some(Motion::Prescribed(Some(path)))) =
            (self.measure.kind.fits_morison(), bodies.get(particle).map(|b| b.motion))
        {
            self.morison.add(&path, &force, dt);
        }
        let body = |of: &dyn Fn(&Body) -> f64| bodies.get(particle).map_or(0.0, of);
        let value = match self.measure.kind {
            MeasureKind::MaxSpeed => max_speed,
            MeasureKind::DragCoefficient | MeasureKind::DragCoefficientMax => coefficient(0),
            MeasureKind::LiftCoefficient
            | MeasureKind::LiftCoefficientMax
            | MeasureKind::LiftRms
            | MeasureKind::LiftAmplitude
            | MeasureKind::Strouhal => coefficient(1),
            MeasureKind::TerminalVelocity => body(&|b| b.velocity.norm()),
            MeasureKind::PositionX => body(&|b| b.centre.x),
            MeasureKind::PositionY => body(&|b| b.centre.y),
            MeasureKind::PositionZ => body(&|b| b.centre.z),
            MeasureKind::VelocityX => body(&|b| b.velocity.x),
            MeasureKind::VelocityY => body(&|b| b.velocity.y),
            MeasureKind::VelocityZ => body(&|b| b.velocity.z),
            MeasureKind::Spin => body(&|b| b.spin.z),
            MeasureKind::MorisonDrag | MeasureKind::MorisonInertia => 0.0,
            MeasureKind::MidlineULeast | MeasureKind::MidlineVLeast | MeasureKind::MidlineVLargest => return,
            MeasureKind::ContactStart => exchange.get(particle).map_or(0.0, |e| e.contact.norm()),
        };
        self.keep((time, value));
    }

    /// Keeps a sample: the one that counts where one does, so that a long run takes no more memory than a short one.
    fn keep(&mut self, new: (f64, f64)) {
        let counts = |kept: (f64, f64)| match self.measure.kind {
            MeasureKind::MaxSpeed
            | MeasureKind::TerminalVelocity
            | MeasureKind::DragCoefficientMax
            | MeasureKind::LiftCoefficientMax => Some(new.1 > kept.1),
            MeasureKind::PositionX | MeasureKind::PositionY | MeasureKind::PositionZ => Some(true),
            MeasureKind::ContactStart => Some(kept.1 <= 0.0),
            _ => None,
        };
        match self.samples.last_mut().map(|kept| (counts(*kept), kept)) {
            None | Some((None, _)) => self.samples.push(new),
            Some((Some(better), kept)) if better => *kept = new,
            Some(_) => {}
        }
    }

    /// The measure's value; `None` where the samples do not give one (no steps in its window, no oscillation, no
    /// contact).
    pub fn value(&self) -> Option<f64> {
        if let Some(value) = self.midline {
            return Some(value);
        }
        let values = || self.samples.iter().map(|s| s.1);
        let (low, high) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        let mean = mean(&self.samples)?;
        match self.measure.kind {
            MeasureKind::DragCoefficient
            | MeasureKind::LiftCoefficient
            | MeasureKind::VelocityX
            | MeasureKind::VelocityY
            | MeasureKind::VelocityZ
            | MeasureKind::Spin => Some(mean),
            MeasureKind::MaxSpeed
            | MeasureKind::TerminalVelocity
            | MeasureKind::DragCoefficientMax
            | MeasureKind::LiftCoefficientMax => Some(high),
            MeasureKind::MorisonDrag => self.morison.coefficients().map(|c| c.x),
            MeasureKind::MorisonInertia => self.morison.coefficients().map(|c| c.y),
            MeasureKind::PositionX | MeasureKind::PositionY | MeasureKind::PositionZ => {
                self.samples.last().map(|s| s.1)
            }
            MeasureKind::ContactStart => self.samples.iter().find(|s| s.1 > 0.0).map(|s| s.0),
            MeasureKind::LiftAmplitude => Some(0.5 * (high - low)),
            MeasureKind::LiftRms => {
                let squares: Vec<_> = self.samples.iter().map(|&(t, v)| (t, (v - mean) * (v - mean))).collect();
                self::mean(&squares).map(f64::sqrt)
            }
            // A lift coefficient that moves by less is a steady wake, whatever its last digits do.
            MeasureKind::Strouhal if high - low < 2e-3 => None,
            MeasureKind::Strouhal => frequency(&self.samples, mean).map(|f| f / self.rate),
            MeasureKind::MidlineULeast | MeasureKind::MidlineVLeast | MeasureKind::MidlineVLargest => self.midline,
        }
    }
}

impl Lasting for Series {
    fn pass(&mut self, tape: &mut Tape) -> Result<()> {
        let Series { samples, morison, before, midline, measure: _, rule: _, force_scale: _, rate: _ } = self;
        let Morison { products, forces, scales: _ } = morison;
        tape.pass([samples, before, forces, midline])?;
        products.iter_mut().try_for_each(|x| x.pass(tape))
    }
}

/// Mean over time by trapezia.
fn mean(samples: &[(f64, f64)]) -> Option<f64> {
    let (first, last) = (samples.first()?, samples.last()?);
    if samples.len() == 1 {
        return Some(first.1);
    }
    let area: f64 = samples.windows(2).map(|w| 0.5 * (w[0].1 + w[1].1) * (w[1].0 - w[0].0)).sum();
    Some(area / (last.0 - first.0))
}

/// Oscillations per unit time from the first to the last upward crossing of `level`. A crossing counts after the signal
/// has been below the level by a tenth of its depth, so that noise makes none.
fn frequency(samples: &[(f64, f64)], level: f64) -> Option<f64> {
    let depth = samples.iter().map(|s| level - s.1).fold(0.0, f64::max);
    let (mut armed, mut crossings) = (false, Vec::new());
    for w in samples.windows(2) {
        armed |= level - w[0].1 > 0.1 * depth;
        if armed && w[0].1 < level && w[1].1 >= level {
            crossings.push(w[0].0 + (level - w[0].1) / (w[1].1 - w[0].1) * (w[1].0 - w[0].0));
            armed = false;
        }
    }
    let (first, last) = (crossings.first()?, crossings.last()?);
    (crossings.len() > 1).then(|| (crossings.len() - 1) as f64 / (last - first))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_noisy_sine_has_its_frequency() {
        let signal = |t: f64| 0.3 + (2.0 * PI * 1.7 * t).sin() + 0.03 * (2.0 * PI * 61.0 * t).sin();
        let samples: Vec<_> = (0..5000).map(|k| k as f64 * 2e-3).map(|t| (t, signal(t))).collect();
        assert!((frequency(&samples, 0.3).unwrap() - 1.7).abs() < 0.01);
        assert_eq!(frequency(&samples[..100], 0.3), None);
    }

    fn disc() -> Body {
        let shape = std::sync::Arc::new(crate::geometry::Disc { radius: 0.1 });
        let mut body = Body::new(shape, 2.0, 0.1, Vector3::new(0.5, 8.0, 0.0));
        body.spin.z = 0.5;
        body
    }

    fn pushed(momentum: Vector3<f64>) -> Exchange {
        let mut exchange = Exchange::default();
        exchange.momentum = momentum;
        exchange
    }

    /// The measures of these kinds, from 1 s on, of a disc of 0.2 m in a fluid of 2 kg/m3.
    fn of_kinds(kinds: &[&str]) -> Vec<Series> {
        let measure =
            |kind: &&str| format!("[[measure]]\nname = \"{kind}\"\nkind = \"{kind}\"\nfrom = 1.0\nspeed = 3.0\n");
        let text = format!(
            "name = \"t\"\ntime.end = 9.0\ndomain = {{ size = [1.0, 9.0], cells = [8, 72] }}\n\
             fluid = {{ density = 2.0, viscosity = 0.1 }}\n\
             boundary = {{ west = \"wall\", east = \"wall\", south = \"wall\", north = \"wall\" }}\n\
             particle = [{{ shape = {{ disc = {{ diameter = 0.2 }} }}, position = [0.5, 8.0] }}]\n{}",
            kinds.iter().map(measure).collect::<String>()
        );
        series(&toml::from_str(&text).unwrap())
    }

    #[test]
    fn the_force_on_a_swinging_disc_gives_back_the_coefficients_that_it_was_made_with() {
        let mut series = of_kinds(&["morison_drag", "morison_inertia"]);
        let (origin, drift, amplitude) = (Vector3::zeros(), Vector3::zeros(), Vector3::new(-0.3, 0.4, 0.0));
        let path = |time| Oscillation { origin, drift, amplitude, frequency: 0.5, time };
        let (along, mut time) = (amplitude.normalize(), 0.0);
        for k in 0..400 {
            let dt = 0.01 * (1.0 + 0.3 * f64::from(k).sin());
            time += dt;
            let middle = path(time - 0.5 * dt);
            let (u, a) = (middle.velocity().dot(&along), middle.acceleration().dot(&along));
            // Across the motion, and before the window, anything goes.
            let across = Vector3::new(0.8, 0.6, 0.0) * f64::from(k).cos();
            let force = -2.1 * 0.5 * 2.0 * 0.2 * u.abs() * u - 1.4 * 2.0 * 0.01 * PI * a;
            let momentum = if time < 1.0 { Vector3::repeat(9.0) } else { force * along + across };
            let mut body = disc();
            body.motion = Motion::Prescribed(Some(path(time)));
            let exchange = pushed(momentum);
            series.iter_mut().for_each(|s| s.sample(time, &[exchange], std::slice::from_ref(&body), 0.0));
        }
        let values: Vec<f64> = series.iter().map(|s| s.value().unwrap()).collect();
        assert!((values[0] - 2.1).abs() < 1e-12 && (values[1] - 1.4).abs() < 1e-12, "{values:?}");
    }

    #[test]
    fn the_largest_coefficients_are_those_of_the_window() {
        let mut series = of_kinds(&["drag_coefficient_max", "lift_coefficient_max", "drag_coefficient"]);
        for (time, x, y) in [(0.5, 9.0, 9.0), (1.0, 1.8, -0.9), (2.0, 3.6, 0.18), (3.0, 1.8, -2.0)] {
            let exchange = pushed(Vector3::new(x, y, 0.0));
            series.iter_mut().for_each(|s| s.sample(time, &[exchange], &[disc()], 0.0));
        }
        // In units of 0.5 rho U^2 d = 1.8 N.
        let values: Vec<f64> = series.iter().map(|s| s.value().unwrap()).collect();
        assert!(values.iter().zip([2.0, 0.1, 1.5]).all(|(a, b)| (a - b).abs() < 1e-12), "{values:?}");
        let kept: Vec<usize> = series.iter().map(|s| s.samples.len()).collect();
        assert_eq!(kept, [1, 1, 3], "a mean needs all samples, the largest itself");
    }

    #[test]
    fn a_falling_body_that_lands_gives_its_speed_place_spin_and_landing() {
        let mut series = of_kinds(&["terminal_velocity", "position_y", "velocity_y", "spin", "contact_start"]);
        assert!(series.iter().all(|s| s.value().is_none()));
        let mut body = disc();
        // Before the window, in it, at the bottom, and at rest without a force.
        for (time, speed, force) in
            [(0.5, -9.0, 9.0), (1.0, -2.0, 0.0), (2.0, -3.0, 0.0), (3.0, 0.0, 7.0), (4.0, 0.0, 0.0)]
        {
            body.velocity.y = speed;
            body.centre.y += speed / 10.0;
            let mut exchange = Exchange::default();
            exchange.contact.y = force;
            series.iter_mut().for_each(|s| s.sample(time, &[exchange], std::slice::from_ref(&body), 0.0));
        }
        let values: Vec<f64> = series.iter().map(|s| s.value().unwrap()).collect();
        let expected = [3.0, 8.0 - 1.4, -(2.5 + 1.5) / 3.0, 0.5, 3.0];
        assert!(values.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{values:?}");
    }
}
