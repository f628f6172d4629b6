//! Least-squares fits over time: Morison's formula to the force on a particle that swings, and a
//! quadratic to any signal.
//!
//! ```text
//!   sum_k dt_k (F_k - sum_i c_i g_i(t_k))^2 -> least:   A c = b,   A_ij = sum_k dt_k g_i g_j,
//!              b_i = sum_k dt_k F_k g_i
//!   what the fit leaves:   sum_k dt_k F_k^2 - b . c
//! ```

use crate::Result;
use crate::archive::{Archive, Checkpointed};
use crate::particles::Oscillation;
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
use std::collections::VecDeque;

/// The quarter of a body's way over which its speed changes least.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steadiest {
    /// Mean speed over it (m/s).
    pub speed: f64,
    /// Largest less least speed there, as a part of that.
    pub variation: f64,
}

/// Finds that quarter among samples of time (s) and speed (m/s): by the way and not by the time, so
/// that a body at rest has none. Where a speed approaches its end exponentially and changes by 1 %
/// over the last quarter of the way, its mean there is within 1 % of the end.
pub fn steadiest_quarter(samples: &[(f64, f64)]) -> Option<Steadiest> {
    let steps =
        samples.windows(2).map(|pair| 0.5 * (pair[0].1 + pair[1].1) * (pair[1].0 - pair[0].0));
    let mut way = vec![0.0];
    way.extend(steps.scan(0.0, |sum, step| {
        *sum += step;
        Some(*sum)
    }));
    let quarter = 0.25 * way.last()?;
    let mut best: Option<Steadiest> = None;
    let mut end: usize = 0;
    // Indices of samples of the window that may become its largest and its least, in order.
    let mut high = VecDeque::new();
    let mut low = VecDeque::new();
    for start in 0..samples.len() {
        while end < samples.len() && (end == start || way[end - 1] - way[start] < quarter) {
            while high.back().is_some_and(|k: &usize| samples[*k].1 <= samples[end].1) {
                high.pop_back();
            }
            while low.back().is_some_and(|k: &usize| samples[*k].1 >= samples[end].1) {
                low.pop_back();
            }
            high.push_back(end);
            low.push_back(end);
            end += 1;
        }
        let first = samples[start];
        let last = samples[end - 1];
        let gone = way[end - 1] - way[start];
        if gone < quarter || gone <= 0.0 {
            break;
        }
        let speed = gone / (last.0 - first.0);
        let variation = (samples[*high.front()?].1 - samples[*low.front()?].1) / speed;
        if best.is_none_or(|best| variation < best.variation) {
            best = Some(Steadiest { speed, variation });
        }
        for ends in [&mut high, &mut low] {
            if ends.front() == Some(&start) {
                ends.pop_front();
            }
        }
    }
    best
}

/// Sums of a least-squares fit of `F = -C_D 0.5 rho S |U| U - C_M rho V dU/dt`.
#[derive(Default)]
pub struct Morison {
    /// `0.5 rho S` (kg/m) and `rho V` (kg).
    scales: [f64; 2],
    products: Matrix2<f64>,
    forces: Vector2<f64>,
    /// The force's square over time (N2 s).
    square: f64,
}

impl Morison {
    /// A fit without samples, of a particle with this frontal area S (m2) and volume V (m3) in a
    /// fluid of this density (kg/m3).
    pub fn new(density: f64, area: f64, volume: f64) -> Morison {
        Morison { scales: [0.5 * density * area, density * volume], ..Morison::default() }
    }

    /// Takes the mean force (N) over a step `dt` (s) that ends on `path` now.
    pub fn add(&mut self, path: &Oscillation, force: &Vector3<f64>, dt: f64) {
        let middle = Oscillation { time: path.time - 0.5 * dt, ..*path };
        let Some(along) = path.amplitude.try_normalize(0.0) else { return };
        let speed = middle.velocity().dot(&along);
        let rate = middle.acceleration().dot(&along);
        let force = force.dot(&along);
        let terms = Vector2::new(-self.scales[0] * speed.abs() * speed, -self.scales[1] * rate);
        self.products += dt * terms * terms.transpose();
        self.forces += dt * force * terms;
        self.square += dt * force * force;
    }

    /// `C_D` and `C_M`; `None` where the samples do not tell them apart.
    pub fn coefficients(&self) -> Option<Vector2<f64>> {
        Some(self.products.cholesky()?.solve(&self.forces))
    }

    /// Root mean square of what the fit leaves of the force, over that of the force; `None` without
    /// a fit or a force.
    pub fn residual(&self) -> Option<f64> {
        let left = self.square - self.forces.dot(&self.coefficients()?);
        // Rounding may leave slightly less than 0 of a force that the formula gives in full.
        Some((left.max(0.0) / self.square).sqrt()).filter(|part| part.is_finite())
    }
}

impl Checkpointed for Morison {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        let Morison { products, forces, square, scales: _ } = self;
        archive.serialize([forces, square])?;
        products.iter_mut().try_for_each(|x| x.serialize(archive))
    }
}

/// Root mean square of a signal about its quadratic in time, over the size of its mean. Samples are
/// (time (s), value), each the mean over the step before it, and weigh as much as that step is
/// long; the first one only says where the second one's step begins. `None` of four samples or
/// fewer, which a quadratic meets, and of a signal whose mean is 0.
pub fn noise(samples: &[(f64, f64)]) -> Option<f64> {
    let [(start, _), _, _, _, .., (end, _)] = *samples else { return None };
    // From -1 to 1, where the powers of time are well apart.
    let powers = |time: f64| {
        let s = (2.0 * time - start - end) / (end - start);
        Vector3::new(1.0, s, s * s)
    };
    let weighted = || samples.windows(2).map(|w| (w[1].0 - w[0].0, powers(w[1].0), w[1].1));
    let mut products = Matrix3::zeros();
    let mut values = Vector3::zeros();
    for (dt, powers, value) in weighted() {
        products += dt * powers * powers.transpose();
        values += dt * value * powers;
    }
    let quadratic = products.cholesky()?.solve(&values);
    let left: f64 =
        weighted().map(|(dt, powers, value)| dt * (value - quadratic.dot(&powers)).powi(2)).sum();
    // The sum of the values is their product with the power 0.
    let mean = values.x / (end - start);
    Some((left / (end - start)).sqrt() / mean.abs()).filter(|part| part.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// A fall from rest with v = 1 - exp(-t), a rest on the floor after it, and a fall that is too
    /// short.
    #[test]
    fn terminal_speed_from_steadiest_quarter() {
        let fall = |until: f64| {
            (0..=1000).map(move |k| until * f64::from(k) / 1000.0).map(|t| (t, 1.0 - (-t).exp()))
        };
        let lands = fall(12.0).chain((1..500).map(|k| (12.0 + 0.1 * f64::from(k), 0.0)));
        let long = steadiest_quarter(&lands.collect::<Vec<_>>()).unwrap();
        assert!((long.speed - 1.0).abs() < 1e-3 && long.variation < 1e-3, "{long:?}");
        let short = steadiest_quarter(&fall(1.0).collect::<Vec<_>>()).unwrap();
        assert!(short.variation > 0.05 && short.speed < 0.64, "{short:?}");
        assert_eq!(steadiest_quarter(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)]), None);
        assert_eq!(steadiest_quarter(&[]), None);
    }

    #[test]
    fn morison_residual_of_unmodelled_force() {
        let fit = |extra: f64| {
            let mut morison = Morison::new(2.0, 0.2, 0.03);
            let dt = 0.01;
            let mut square = 0.0;
            for k in 1..=400 {
                let time = dt * f64::from(k);
                let origin = Vector3::zeros();
                let drift = Vector3::zeros();
                let amplitude = Vector3::new(-0.3, 0.4, 0.0);
                let path = |time| Oscillation { origin, drift, amplitude, frequency: 0.5, time };
                let middle = path(time - 0.5 * dt);
                let (u, a) = [middle.velocity(), middle.acceleration()]
                    .map(|v| v.dot(&amplitude) / 0.5)
                    .into();
                // The formula has odd harmonics only, so that it takes nothing of the second one.
                let force = -2.1 * 0.2 * u.abs() * u - 1.4 * 0.06 * a
                    + extra * (2.0 * TAU * 0.5 * middle.time).sin();
                square += dt * force * force;
                morison.add(&path(time), &(force / 0.5 * amplitude), dt);
            }
            let c = morison.coefficients().unwrap();
            let left = morison.residual().unwrap();
            assert!((c.x - 2.1).abs() < 1e-9 && (c.y - 1.4).abs() < 1e-9, "{c}");
            (left, (0.5 * extra * extra * 4.0 / square).sqrt())
        };
        let (left, expected) = fit(0.07);
        assert!(expected > 0.05 && (left / expected - 1.0).abs() < 1e-9, "{left} of {expected}");
        assert!(fit(0.0).0 < 1e-7);
        assert_eq!(Morison::new(2.0, 0.2, 0.03).residual(), None);
    }

    /// `2 + 0.3 t - 0.05 t^2` from `start` on, with deviations of 3 `size` over short steps and of
    /// -`size` over steps three times as long.
    fn signal(start: f64, size: f64) -> Vec<(f64, f64)> {
        let mut time = 0.0;
        let mut sample = |k: usize| {
            let short = k.is_multiple_of(2);
            time += if short { 0.001 } else { 0.003 };
            let deviation = if short { 3.0 * size } else { -size };
            (start + time, 2.0 + 0.3 * time - 0.05 * time * time + deviation)
        };
        (0..2000).map(&mut sample).collect()
    }

    #[test]
    fn force_noise_about_weighted_quadratic_fit() {
        // Over four seconds the quadratic's mean is 2 + 0.6 - 0.05 16/3; the deviations' is 0, and
        // of their square 3.
        let expected = 3.0f64.sqrt() * 0.1 / (2.6 - 0.8 / 3.0);
        for start in [0.0, 1000.0] {
            let found = noise(&signal(start, 0.1)).unwrap();
            assert!((found / expected - 1.0).abs() < 1e-3, "{found} of {expected}");
            assert!(noise(&signal(start, 0.0)).unwrap() < 1e-12, "a quadratic has none");
        }
        let negative: Vec<_> = signal(0.0, 0.1).into_iter().map(|(t, v)| (t, -v)).collect();
        assert!((noise(&negative).unwrap() / expected - 1.0).abs() < 1e-3);
        assert_eq!(noise(&signal(0.0, 0.1)[..4]), None, "a quadratic goes through three values");
        assert_eq!(noise(&[(1.0, 2.0); 9]), None, "no time passes");
    }
}
