//! The rigid motion that carries the momentum of a body's cells: `v`, `omega` with
//!
//! ```text
//!   sum_c W_c (v + omega x r_c)       = P
//!              W_c a weight (kg) in each cell, r_c its arm from the body's centre
//!   sum_c W_c r_c x (v + omega x r_c) = L     P, L the momentum and angular momentum to be carried
//! ```
//! a symmetric system of six; directions in which the body is held keep their velocity and drop
//! out.

use crate::particles::Freedom;
use crate::sums::Summed;
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

/// Sums over a body's cells that fix its rigid motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    /// `sum W` (kg).
    pub mass: f64,
    /// `sum W r` (kg m).
    pub first: Vector3<f64>,
    /// `sum W r r^T` (kg m2): xx, yy, zz, xy, yz, zx.
    pub second: [f64; 6],
    /// `sum W u` (kg m/s).
    pub momentum: Vector3<f64>,
    /// `sum W r x u` (kg m2/s).
    pub spin: Vector3<f64>,
}

impl Summed for Moments {
    fn each(&mut self, take: &mut dyn FnMut(&mut [f64])) {
        let Moments { mass, first, second, momentum, spin } = self;
        take(std::slice::from_mut(mass));
        take(second);
        [first, momentum, spin].into_iter().for_each(|v| v.each(take));
    }
}

impl Moments {
    /// Adds a cell of weight `w` (kg) at `arm` (m) with velocity `u` (m/s).
    #[inline]
    pub fn add(&mut self, w: f64, arm: &Vector3<f64>, u: &Vector3<f64>) {
        self.mass += w;
        self.first += w * arm;
        let (x, y, z) = (arm.x, arm.y, arm.z);
        for (slot, product) in
            self.second.iter_mut().zip([x * x, y * y, z * z, x * y, y * z, z * x])
        {
            *slot += w * product;
        }
        self.momentum += w * u;
        self.spin += w * arm.cross(u);
    }

    /// The rigid motion (m/s, rad/s) that carries `momentum` and `spin` along the free directions;
    /// along the others it is `held`'s. Where the cells do not fix the rotation (a body within one
    /// of them), it is held too; without any weight all is.
    pub fn rigid_motion(
        &self,
        freedom: &Freedom,
        held: (Vector3<f64>, Vector3<f64>),
    ) -> (Vector3<f64>, Vector3<f64>) {
        if self.mass <= 0.0 {
            return held;
        }
        let [xx, yy, zz, xy, yz, zx] = self.second;
        // About the centroid of the cells, whose distance from the body's centre fixes no rotation.
        let about_centroid = xx + yy + zz - self.first.norm_squared() / self.mass;
        let turns = about_centroid > 1e-9 * (xx + yy + zz);
        let tensor = Matrix3::new(yy + zz, -xy, -zx, -xy, zz + xx, -yz, -zx, -yz, xx + yy);
        let cross = self.first.cross_matrix();
        let mut a = Matrix6::zeros();
        a.fixed_view_mut::<3, 3>(0, 0).fill_with_identity();
        a.fixed_view_mut::<3, 3>(0, 0).scale_mut(self.mass);
        a.fixed_view_mut::<3, 3>(0, 3).copy_from(&-cross);
        a.fixed_view_mut::<3, 3>(3, 0).copy_from(&cross);
        a.fixed_view_mut::<3, 3>(3, 3).copy_from(&tensor);
        let mut b = Vector6::zeros();
        b.fixed_rows_mut::<3>(0).copy_from(&self.momentum);
        b.fixed_rows_mut::<3>(3).copy_from(&self.spin);
        for k in 0..6 {
            let (free, value) = if k < 3 {
                (freedom.translation[k], held.0[k])
            } else {
                (freedom.rotation[k - 3] && turns, held.1[k - 3])
            };
            let scale = if k < 3 { self.mass } else { xx + yy + zz };
            if free && a[(k, k)] > 1e-9 * scale {
                continue;
            }
            b -= a.column(k) * value;
            a.row_mut(k).fill(0.0);
            a.column_mut(k).fill(0.0);
            a[(k, k)] = 1.0;
            b[k] = value;
        }
        let solved = a.cholesky().map(|factor| factor.solve(&b));
        solved.map_or(held, |x| (x.fixed_rows::<3>(0).into(), x.fixed_rows::<3>(3).into()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: Freedom = Freedom { translation: [true; 3], rotation: [true; 3] };

    fn cells() -> Vec<(f64, Vector3<f64>)> {
        (0..30)
            .map(f64::from)
            .map(|k| {
                (
                    1.0 + (k * 0.7).sin().abs(),
                    Vector3::new((k * 1.3).sin(), (k * 2.1).cos(), (k * 0.4).sin() + 0.2),
                )
            })
            .collect()
    }

    fn of(motion: impl Fn(&Vector3<f64>) -> Vector3<f64>) -> Moments {
        let mut m = Moments::default();
        cells().iter().for_each(|(w, r)| m.add(*w, r, &motion(r)));
        m
    }

    #[test]
    fn rigid_motion_fit_recovers_rigid_motion() {
        let (v, w) = (Vector3::new(1.0, -2.0, 0.5), Vector3::new(0.3, 0.7, -1.1));
        let zero = Vector3::zeros();
        let (found_v, found_w) = of(|r| v + w.cross(r)).rigid_motion(&ALL, (zero, zero));
        assert!((found_v - v).norm() + (found_w - w).norm() < 1e-12);
    }

    #[test]
    fn rigid_motion_fit_conserves_momentum() {
        let motion = |r: &Vector3<f64>| Vector3::new(r.y * r.z, r.x * r.x, (3.0 * r.y).sin());
        let m = of(motion);
        let (v, w) = m.rigid_motion(&ALL, (Vector3::zeros(), Vector3::zeros()));
        let rigid = of(|r| v + w.cross(r));
        assert!((rigid.momentum - m.momentum).norm() < 1e-12 * m.momentum.norm());
        assert!((rigid.spin - m.spin).norm() < 1e-12 * m.spin.norm());
    }

    #[test]
    fn rigid_motion_of_body_within_one_cell() {
        let mut m = Moments::default();
        m.add(3.0, &Vector3::new(0.1, -0.2, 0.0), &Vector3::new(1.0, 2.0, 0.0));
        let (v, w) = m.rigid_motion(&ALL, (Vector3::zeros(), Vector3::zeros()));
        assert!(
            (v - Vector3::new(1.0, 2.0, 0.0)).norm() < 1e-14 && w == Vector3::zeros(),
            "{v} {w}"
        );
    }

    #[test]
    fn rigid_motion_fit_keeps_locked_direction() {
        let held = Freedom { translation: [true, false, true], rotation: [false, false, true] };
        let (v, w) = of(|r| *r).rigid_motion(&held, (Vector3::repeat(7.0), Vector3::repeat(5.0)));
        assert_eq!((v.y, w.x, w.y), (7.0, 5.0, 5.0));
        assert!(v.x.is_finite() && w.z != 5.0);
    }
}
