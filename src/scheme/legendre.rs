//! Runge-Kutta-Legendre stages (RKL2 of Meyer, Balsara & Aslam, J. Comput. Phys. 257, 2014,
//! 594-626): the limit of explicit diffusion grows with the square of their number.
//!
//! ```text
//!   Y_1 = Y_0 + (w/3) dt F_0,    Y_j = (1 - m - n) Y_0 + m Y_(j-1) + n Y_(j-2) + m w dt F_(j-1) -
//!                                a_(j-1) m w dt F_0
//!   w = 4/(s^2 + s - 2),    b_j = (j^2 + j - 2)/(2 j (j + 1)),  b_0 = b_1 = 1/3,    a_j = 1 - b_j
//!   m = (2j - 1)/j  b_j/b_(j-1),    n = -(j - 1)/j  b_j/b_(j-2)
//! ```
//! for `Y' = F(Y)`, of second order at `Y_s`. On the negative real axis it is stable to `-(s^2 + s
//! - 2)/2`, and no stage overshoots there.

/// A stage: the factors of `Y_j`, and its weights in the end of the step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stage {
    /// Factor of the start of the step.
    pub start: f64,
    /// Factor of the stage before.
    pub last: f64,
    /// Factor of the stage before that one.
    pub before: f64,
    /// Factor of the rate of the stage before, times the step.
    pub rate: f64,
    /// Factor of the rate at the start, times the step.
    pub first: f64,
    /// The time that it stands for, of the step.
    pub time: f64,
    /// Weight of its rate in the end of the step, times the step.
    pub weight: f64,
    /// Share of a term added to it that the end of the step keeps, other than by rates.
    pub remains: f64,
}

impl Stage {
    /// Factor of a steady rate in this stage, times the step.
    pub fn part(&self) -> f64 {
        self.rate + self.first
    }
}

/// All stages of a step.
#[derive(Clone, Debug)]
pub struct Legendre {
    /// Weight of the rate at the start in the end of the step, times the step.
    pub weight: f64,
    /// The stages in order; the last is the end of the step.
    pub stages: Vec<Stage>,
}

/// The limit on the negative real axis with so many stages, over Euler's.
pub fn limit(stages: usize) -> f64 {
    let s = stages as f64;
    0.25 * (s * s + s - 2.0)
}

impl Legendre {
    /// The stages of a step with so many of them, three or more.
    pub fn new(stages: usize) -> Legendre {
        let w = 1.0 / limit(stages);
        let b = |j: usize| if j < 2 { 1.0 / 3.0 } else { limit(j) / (0.5 * (j * (j + 1)) as f64) };
        let mut all = vec![Stage {
            start: 1.0,
            last: 0.0,
            before: 0.0,
            rate: 0.0,
            first: b(1) * w,
            time: b(1) * w,
            weight: 0.0,
            remains: 0.0,
        }];
        for j in 2..=stages {
            let n = j as f64;
            let last = (2.0 * n - 1.0) / n * b(j) / b(j - 1);
            let before = (1.0 - n) / n * b(j) / b(j - 2);
            let rate = last * w;
            let mut stage = Stage {
                start: 1.0 - last - before,
                last,
                before,
                rate,
                first: (b(j - 1) - 1.0) * rate,
                ..all[0]
            };
            let before_last = if j > 2 { all[j - 3].time } else { 0.0 };
            stage.time = last * all[j - 2].time + before * before_last + stage.part();
            all.push(stage);
        }
        // From the end back: what it has of each stage.
        let end = all.len() - 1;
        all[end].remains = 1.0;
        let mut weight = all[end].first;
        for j in (0..end).rev() {
            let after = all.get(j + 2).map_or(0.0, |next| next.before * next.remains);
            all[j].remains = all[j + 1].last * all[j + 1].remains + after;
            all[j].weight = all[j + 1].rate * all[j + 1].remains;
            weight += all[j].first * all[j].remains;
        }
        Legendre { weight, stages: all }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The end of a step of `y' = z y` from 1.
    fn grown(legendre: &Legendre, z: f64) -> f64 {
        let mut last = 1.0;
        let mut before = 1.0;
        for stage in &legendre.stages {
            let next = stage.start
                + stage.last * last
                + stage.before * before
                + z * (stage.rate * last + stage.first);
            before = last;
            last = next;
        }
        last
    }

    #[test]
    fn legendre_step_second_order_with_recurrence_weights() {
        for s in 3..=20 {
            let legendre = Legendre::new(s);
            let error = |z: f64| grown(&legendre, z) - z.exp();
            let order = (error(1e-2) / error(5e-3)).log2();
            assert!((order - 3.0).abs() < 0.02, "{s}: {order}");
            assert!((legendre.stages[s - 1].time - 1.0).abs() < 1e-13);
            // The stages' own values, weighted.
            let mut last = 1.0;
            let mut before = 1.0;
            let z = -0.3;
            let mut sum = 1.0 + z * legendre.weight;
            for stage in &legendre.stages {
                let next = stage.start
                    + stage.last * last
                    + stage.before * before
                    + z * (stage.rate * last + stage.first);
                sum += z * stage.weight * next;
                before = last;
                last = next;
            }
            assert!((sum - last).abs() < 1e-13, "{s}: {sum} {last}");
        }
    }

    #[test]
    fn legendre_stability_limit() {
        for s in 3..=20 {
            let legendre = Legendre::new(s);
            let end = 2.0 * limit(s);
            let worst = (0..=1000)
                .map(|k| grown(&legendre, -end * f64::from(k) / 1000.0).abs())
                .fold(0.0, f64::max);
            assert!(worst <= 1.0 + 1e-12, "{s}: {worst}");
            assert!(grown(&legendre, -1.3 * end).abs() > 1.0, "{s}");
            // The time of a stage grows from each to the next.
            assert!(legendre.stages.windows(2).all(|pair| pair[0].time < pair[1].time), "{s}");
        }
    }

    #[test]
    fn legendre_stage_increment_weights() {
        let legendre = Legendre::new(5);
        for (k, stage) in legendre.stages.iter().enumerate() {
            let mut last = 0.0;
            let mut before = 0.0;
            for (j, one) in legendre.stages.iter().enumerate() {
                let next = one.last * last + one.before * before + f64::from(j == k);
                before = last;
                last = next;
            }
            assert!((last - stage.remains).abs() < 1e-14);
        }
    }
}
