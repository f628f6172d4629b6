//! The profile of the flow beside a wall, far from others, as factors of what probes see. In spacings, s the distance from the wall:
//!
//! ```text
//!   w(s) = a s + b (s^2/2 + 1/24)      through both probes: a cell has the mean of what is in it, and that of a parabola is w''/24 beyond
//!                                      its middle, on the wall as well
//!   w(s) = a s + b (s^2/2 + 1/24) + c (s^3/6 + s/24)     through three probes, or two and what lies across a narrow gap: the finer profile
//! ```
//! Without the 1/24 a flow between walls is too easy: the sum over cells of what they have in their middles is more than what flows.

use crate::params;
use nalgebra::{Matrix3, Vector3};

/// Factors of both probes' velocities in the parabola's at the distance `s`.
pub fn parabola(s: f64) -> [f64; 2] {
    let bend = |s: f64| params::cell_mean() + 0.5 * s * s;
    let (first, second) = (params::first_probe(), params::second_probe());
    let determinant = bend(first) * second - bend(second) * first;
    [(bend(s) * second - bend(second) * s) / determinant, (bend(first) * s - bend(s) * first) / determinant]
}

/// What is known of a profile beside a wall, apart from zero on it.
#[derive(Clone, Copy, Debug)]
pub enum Known {
    /// Its mean in a cell at this distance.
    Mean(f64),
    /// Its value on the wall across, at this distance.
    Wall(f64),
}

impl Known {
    /// What a, b, c of the cubic make of it.
    fn of(self) -> Vector3<f64> {
        let (s, mean) = match self {
            Known::Mean(s) => (s, params::cell_mean()),
            Known::Wall(s) => (s, 0.0),
        };
        Vector3::new(s, 0.5 * s * s + mean, s * (s * s / 6.0 + mean))
    }
}

/// Factors of three known values in the cubic's mean at the distance `s`; none where they do not determine it.
pub fn cubic(s: f64, known: [Known; 3]) -> Option<[f64; 3]> {
    let system = Matrix3::from_columns(&known.map(Known::of));
    system.lu().solve(&Known::Mean(s).of()).map(Into::into)
}

/// Factors of the means at one, two and three times [`params::slope_probe`] in the slope on the wall of the cubic through them: where no body moves.
pub fn slope_of_means() -> [f64; 3] {
    let system = Matrix3::from_columns(&[1.0, 2.0, 3.0].map(|n| Known::Mean(n * params::slope_probe()).of()));
    system.lu().solve(&Vector3::x()).map_or_else(slope, Into::into)
}

/// Factors of the velocities at one, two and three times [`params::slope_probe`] in the slope of the cubic through them and zero on the
/// wall. With the parabola's w''/24 there in place of zero pressure and shear make up the force within 0.5 % at Re = 2 in place of 1 %,
/// but the torque on a disc that is spun up, 16 cells a diameter, is 2 to 3 % too much in place of 0.5, and light discs turn for too long.
pub fn slope() -> [f64; 3] {
    [3.0, -1.5, 1.0 / 3.0].map(|factor| factor / params::slope_probe())
}

#[cfg(test)]
mod tests {
    use super::{Known, cubic, parabola};

    #[test]
    fn the_means_of_a_parabola_are_continued_as_such() {
        let mean = |s: f64| s - 0.7 * (s * s + 1.0 / 12.0);
        for s in [-2.5, -1.0, -0.3, 0.0, 0.4, 1.7] {
            let [first, second] = parabola(s);
            assert!((first * mean(1.0) + second * mean(2.0) - mean(s)).abs() < 1e-12, "at {s}");
        }
    }

    #[test]
    fn the_means_of_a_cubic_are_continued_as_such_also_across_a_gap() {
        let value = |s: f64| s - 0.7 * s * s + 0.2 * s * s * s;
        let mean = |s: f64| value(s) - 0.7 / 12.0 + 0.2 * s / 4.0;
        for s in [-1.5, -0.3, 0.0, 0.4] {
            let [one, two, three] = cubic(s, [1.0, 2.0, 3.0].map(Known::Mean)).unwrap();
            assert!((one * mean(1.0) + two * mean(2.0) + three * mean(3.0) - mean(s)).abs() < 1e-12, "at {s}");
            let [one, two, across] = cubic(s, [Known::Mean(0.7), Known::Mean(1.4), Known::Wall(2.1)]).unwrap();
            assert!(
                (one * mean(0.7) + two * mean(1.4) + across * value(2.1) - mean(s)).abs() < 1e-12,
                "across, at {s}"
            );
        }
    }
}
