//! The traction of the fluid on the surfaces of bodies, for readers of the results.

use crate::Result;
use crate::petsc::Session;
use nalgebra::Vector3;
use std::cmp::Ordering;

/// The traction of the fluid at a point of a body's surface.
#[derive(Clone, Copy, Debug)]
pub struct Traction {
    /// Place of the body in the state's list.
    pub body: usize,
    /// From the body's centre to the point, along the axes of the box (m).
    pub arm: Vector3<f64>,
    /// The point's part of the surface (m2; m per metre of depth).
    pub area: f64,
    /// Pressure without its hydrostatic part (Pa).
    pub pressure: f64,
    /// Viscous traction on the body (Pa).
    pub shear: Vector3<f64>,
}

impl Traction {
    /// Tractions of all ranks by body, of so many, on rank 0; nothing elsewhere, or where no rank
    /// has any. Collective.
    ///
    /// # Errors
    /// When ranks cannot reach each other.
    pub fn gather(
        session: &Session,
        bodies: usize,
        own: &[Traction],
    ) -> Result<Vec<Vec<Traction>>> {
        let numbers = |t: &Traction| {
            let [x, y, z]: [f64; 3] = t.arm.into();
            let [sx, sy, sz]: [f64; 3] = t.shear.into();
            [t.body as f64, x, y, z, t.area, t.pressure, sx, sy, sz]
        };
        let own: Vec<f64> = own.iter().flat_map(numbers).collect();
        let mut all = Vec::new();
        session.gather(&own, |_, part| {
            for n in part.chunks_exact(9) {
                all.resize(bodies, Vec::new());
                let body = n[0] as usize;
                all[body].push(Traction {
                    body,
                    arm: Vector3::new(n[1], n[2], n[3]),
                    area: n[4],
                    pressure: n[5],
                    shear: Vector3::new(n[6], n[7], n[8]),
                });
            }
        })?;
        // In an order that does not depend on the ranks.
        for own in &mut all {
            own.sort_by(|a: &Traction, b| {
                let pairs = a.arm.iter().zip(&b.arm).map(|(a, b)| a.total_cmp(b));
                pairs.fold(Ordering::Equal, Ordering::then)
            });
        }
        Ok(all)
    }
}
