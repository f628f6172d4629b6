//! Moments of inertia, and whatever else takes angular velocity to angular momentum.

use super::Freedom;
use nalgebra::{Matrix3, Vector3};

/// A symmetric map from angular velocity (rad/s) to angular momentum (kg m2/s), in the axes of the
/// box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Inertia {
    /// One moment about all axes (kg m2).
    Same(f64),
    /// A tensor (kg m2).
    Tensor(Matrix3<f64>),
}

impl Inertia {
    /// Angular momentum at a spin (kg m2/s).
    pub fn of(&self, spin: &Vector3<f64>) -> Vector3<f64> {
        match self {
            Inertia::Same(i) => *i * spin,
            Inertia::Tensor(i) => i * spin,
        }
    }

    /// Moment about the axis x, y or z (kg m2).
    pub fn about(&self, axis: usize) -> f64 {
        match self {
            Inertia::Same(i) => *i,
            Inertia::Tensor(i) => i[(axis, axis)],
        }
    }

    /// `factor` times it.
    pub fn times(&self, factor: f64) -> Inertia {
        match self {
            Inertia::Same(i) => Inertia::Same(factor * i),
            Inertia::Tensor(i) => Inertia::Tensor(factor * i),
        }
    }

    /// The sum of it and `times` the other one.
    pub fn plus(&self, times: f64, other: &Inertia) -> Inertia {
        match (self, other) {
            (Inertia::Same(a), Inertia::Same(b)) => Inertia::Same(a + times * b),
            (a, b) => Inertia::Tensor(a.tensor() + times * b.tensor()),
        }
    }

    /// Change of the spin (rad/s) by an angular impulse (N m s): none about held axes, whose
    /// support takes the torque for that.
    pub fn spin_change(&self, impulse: &Vector3<f64>, freedom: &Freedom) -> Vector3<f64> {
        match self {
            Inertia::Same(i) => freedom.about(impulse) / *i,
            Inertia::Tensor(_) => self.inverse(freedom) * impulse,
        }
    }

    /// The map from an angular impulse to that change (1/(kg m2)).
    pub fn inverse(&self, freedom: &Freedom) -> Matrix3<f64> {
        let mut tensor = self.tensor();
        let held = || (0..3).filter(|a| !freedom.rotation[*a]);
        for a in held() {
            tensor.row_mut(a).fill(0.0);
            tensor.column_mut(a).fill(0.0);
            tensor[(a, a)] = 1.0;
        }
        let mut inverse = tensor.try_inverse().unwrap_or_else(Matrix3::zeros);
        held().for_each(|a| inverse[(a, a)] = 0.0);
        inverse
    }

    fn tensor(&self) -> Matrix3<f64> {
        match self {
            Inertia::Same(i) => Matrix3::from_diagonal_element(*i),
            Inertia::Tensor(i) => *i,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angular_impulse_about_free_and_locked_axes() {
        let inertia = Inertia::Tensor(Matrix3::new(3.0, 0.5, -0.2, 0.5, 2.0, 0.3, -0.2, 0.3, 1.0));
        let impulse = Vector3::new(1.0, -2.0, 0.7);
        let all = Freedom { translation: [true; 3], rotation: [true; 3] };
        assert!((inertia.of(&inertia.spin_change(&impulse, &all)) - impulse).norm() < 1e-14);
        let plane = Freedom { rotation: [false, true, true], ..all };
        let change = inertia.spin_change(&impulse, &plane);
        assert!(
            change.x == 0.0 && plane.about(&(inertia.of(&change) - impulse)).norm() < 1e-14,
            "{change}"
        );
    }
}
