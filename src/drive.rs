//! The drive, which moves the fluid besides its boundaries: a force `G` per volume (N/m3), uniform,
//! that acts as the mean gradient of the pressure.
//!
//! ```text
//!   total pressure  p - G.x          a = (-grad p + G)/rho on faces,
//!              a body feels G V besides the gradient of p
//! ```
//! Pressure and drive are found together where the mean velocity `mean(U)` over the box, fluid and
//! bodies alike, is held: a change `d` of `G` along the axis `e` changes the velocities through
//! faces by `dt d (H/rho + sum_k m_k V_k/M_k) e` (V_k, M_k: a free body's volume and mass, m_k the
//! part of a face that it covers), so that, with `C` the mean of the bracket,
//!
//! ```text
//!   d = ( U_held - mean(U) )/(dt C)                   after every solve, and before the first
//!   -div( H grad phi )/rho + ... - j (j.phi)/(N C) = -D/dt,
//!              j = div( sum_k (1/rho - V_k/M_k) m_k e )
//! ```
//! The solve contains the drive's response to the pressure (N: all cells), and the mean is held to
//! rounding in every step.

use crate::Result;
use crate::grid::{Grid, VectorField, simd, total};
use crate::kernels::faces::FaceCoefficient;
use crate::petsc::Session;
use nalgebra::Vector3;

/// Drive of the fluid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drive {
    /// A force per volume on the fluid alone (N/m3).
    Fluid(Vector3<f64>),
    /// A mean gradient of the pressure, or gravity along a slope, which bodies feel as well (N/m3).
    Gradient(Vector3<f64>),
    /// The gradient that holds the mean velocity (m/s) along an axis.
    Held {
        /// The axis.
        axis: usize,
        /// The mean velocity of everything in the box (m/s).
        velocity: f64,
    },
}

impl Drive {
    /// The drive times a factor.
    pub fn times(&self, factor: f64) -> Drive {
        match *self {
            Drive::Fluid(force) => Drive::Fluid(factor * force),
            Drive::Gradient(force) => Drive::Gradient(factor * force),
            Drive::Held { axis, velocity } => Drive::Held { axis, velocity: factor * velocity },
        }
    }

    /// The force at the start, before the pressure is known (N/m3).
    pub fn at_start(&self) -> Vector3<f64> {
        match self {
            Drive::Fluid(force) | Drive::Gradient(force) => *force,
            Drive::Held { .. } => Vector3::zeros(),
        }
    }

    /// Force (N) that a body of a volume (m3) feels of the force on the fluid (N/m3).
    pub fn on_body(&self, force: &Vector3<f64>, volume: f64) -> Vector3<f64> {
        if let Drive::Fluid(_) = self { Vector3::zeros() } else { volume * force }
    }

    /// The axis whose mean velocity is held.
    pub fn held(&self) -> Option<usize> {
        if let Drive::Held { axis, .. } = self { Some(*axis) } else { None }
    }
}

/// The drive while the pressure is found.
pub struct Driving<'a, const D: usize> {
    /// The drive itself.
    pub drive: &'a Drive,
    /// Its force on the fluid so far (N/m3).
    pub force: &'a mut Vector3<f64>,
    /// `1/rho` on faces, as far as they are open (m3/kg).
    pub beta: &'a FaceCoefficient<D>,
    /// C above, where the mean is held (m3/kg).
    pub inverse_density: f64,
    /// The ranks.
    pub session: &'a Session,
}

impl<const D: usize> Driving<'_, D> {
    /// Changes the drive over the step `dt` (s) so that the velocities through faces (m/s) have the
    /// mean that is held, and changes them accordingly on open faces. Returns the change (N/m3),
    /// which bodies have yet to follow. Collective.
    pub fn follow(
        &mut self,
        grid: &Grid<D>,
        dt: f64,
        faces: &mut VectorField<D>,
    ) -> Result<Vector3<f64>> {
        let mut change = Vector3::zeros();
        let Drive::Held { axis, velocity } = *self.drive else { return Ok(change) };
        let mean = mean(self.session, grid, axis, faces)?;
        change[axis] = (velocity - mean) / (dt * self.inverse_density);
        *self.force += change;
        let face = &mut faces[axis];
        let acceleration = dt * change[axis];
        for row in grid.face_rows(axis) {
            match self.beta {
                FaceCoefficient::Uniform(beta) => {
                    face[row].iter_mut().for_each(|f| *f += acceleration * beta)
                }
                FaceCoefficient::Field(beta) => face[row.clone()]
                    .iter_mut()
                    .zip(&beta[axis][row])
                    .for_each(|(f, beta)| *f += acceleration * beta),
            }
        }
        Ok(change)
    }
}

/// Volume of the box (m3; m2 in 2D).
pub fn box_volume<const D: usize>(grid: &Grid<D>) -> f64 {
    grid.size.iter().product()
}

/// The mean over all faces along `axis` of velocities through them. Collective.
pub fn mean<const D: usize>(
    session: &Session,
    grid: &Grid<D>,
    axis: usize,
    faces: &VectorField<D>,
) -> Result<f64> {
    let face = &faces[axis];
    let row_sum = |row: std::ops::Range<usize>| total(row.len(), |i| face[row.start + i]);
    let mut sum = [simd(|| grid.rows().map(row_sum).sum::<f64>())];
    session.sum(&mut sum)?;
    Ok(sum[0] / grid.cells.iter().product::<usize>() as f64)
}

/// The mean of `1/rho` over all faces along `axis`. Collective.
pub fn mean_coefficient<const D: usize>(
    session: &Session,
    grid: &Grid<D>,
    axis: usize,
    beta: &FaceCoefficient<D>,
) -> Result<f64> {
    match beta {
        FaceCoefficient::Uniform(beta) => Ok(*beta),
        FaceCoefficient::Field(beta) => mean(session, grid, axis, beta),
    }
}
