//! The values of stencils ([`super::stencil`]) of a velocity field, many at a time:
//!
//! ```text
//!   the cells and weights of all image points  ->  the velocities there  ->  the sums of each
//! ```
//! No step waits for the one before it at the same point.

use super::image_point::{ImagePoint, Place, Ray};
use super::stencil::{Reading, Stencil, Stencils};
use crate::grid::{Grid, VectorField};
use crate::particles::{RigidVelocity, Velocities};
use nalgebra::Vector3;
use pulp::Simd;

/// Readings at a time, and image points of one at most.
const MANY: usize = 16;
const MOST: usize = 4;

/// Where a body reads.
#[derive(Clone, Copy)]
pub struct Flow<'a, V: Velocities, const D: usize> {
    /// The grid, and the velocity of its cells (m/s), ghosts filled.
    pub grid: &'a Grid<D>,
    pub u: &'a VectorField<D>,
    /// The velocities of all bodies, and which it is.
    pub velocities: V,
    pub k: usize,
}

impl<const D: usize> Stencils<D> {
    /// Hands `take` each of the readings with its value (m/s, or 1/s of a slope). With `limit`, the
    /// speed (m/s) up to which the layer is resolved, and the largest profile there, of the
    /// velocity at the first image point.
    #[inline(always)]
    pub fn values<S: Simd>(
        &self,
        simd: S,
        readings: &[Reading],
        flow: &Flow<impl Velocities, D>,
        limit: Option<(f64, f64)>,
        mut take: impl FnMut(&Reading, Vector3<f64>),
    ) {
        for readings in readings.chunks(MANY) {
            let mut places = [Place::<D>::NONE; MOST * MANY];
            let mut count = 0;
            for Reading { arm, stencil, .. } in readings {
                let ray = self.ray(stencil, arm);
                for image_point in self.image_points_of(stencil) {
                    places[count] = ray.place(image_point.out);
                    count += 1;
                }
            }
            let mut seen = [[0.0; D]; MOST * MANY];
            for (seen, place) in seen.iter_mut().zip(&places[..count]) {
                *seen = place.velocity(simd, flow.grid, flow.u);
            }
            let mut rest = &seen[..count];
            for reading in readings {
                let (own, others) = rest.split_at(reading.stencil.count as usize);
                rest = others;
                take(reading, self.combine(reading, own, flow, limit));
            }
        }
    }

    /// The value of one.
    pub fn value(&self, reading: &Reading, flow: &Flow<impl Velocities, D>) -> Vector3<f64> {
        let one = std::slice::from_ref(reading);
        let mut value = Vector3::zeros();
        self.values(pulp::Scalar::new(), one, flow, None, |_, found| value = found);
        value
    }

    /// That of one for which its image points have `seen` these velocities (m/s).
    #[inline(always)]
    fn combine(
        &self,
        Reading { arm, stencil, .. }: &Reading,
        seen: &[[f64; D]],
        Flow { velocities, k, .. }: &Flow<impl Velocities, D>,
        limit: Option<(f64, f64)>,
    ) -> Vector3<f64> {
        let (rest, turning) = self.rigid(stencil, arm, &velocities(*k));
        let mut sum = Vector3::zeros();
        let mut first = None;
        for (image_point, seen) in self.image_points_of(stencil).iter().zip(seen) {
            let relative = vector(seen) - (rest + image_point.out * turning);
            first.get_or_insert(relative);
            sum += image_point.share * relative;
        }
        if let (Some((limit, largest)), Some(first)) = (limit, first) {
            // first <= limit: the layer is resolved. By squares, as hardly any is limited.
            let first = first.norm_squared();
            let size = sum.norm_squared();
            let factor = if first <= limit * limit { first } else { limit * limit };
            let most = first.max(largest * largest * factor);
            if size > most {
                sum *= (most / size).sqrt();
            }
        }
        let Some(across) = self.across.get(stencil.across as usize) else { return sum };
        let there = across.other.velocity(*velocities);
        there.map_or(sum, |there| sum + across.share * (there - (rest + across.wall * turning)))
    }

    /// The largest speed at the image points of a reading, relative to the body (m/s).
    pub fn fastest(
        &self,
        Reading { arm, stencil, .. }: &Reading,
        flow: &Flow<impl Velocities, D>,
    ) -> f64 {
        let (rest, turning) = self.rigid(stencil, arm, &(flow.velocities)(flow.k));
        let ray = self.ray(stencil, arm);
        let speed = |image_point: &ImagePoint| {
            let place = ray.place(image_point.out);
            let there = vector(&place.velocity(pulp::Scalar::new(), flow.grid, flow.u));
            (there - (rest + image_point.out * turning)).norm()
        };
        self.image_points_of(stencil).iter().map(speed).fold(0.0, f64::max)
    }

    #[inline(always)]
    fn image_points_of(&self, stencil: &Stencil) -> &[ImagePoint] {
        &self.image_points[stencil.first as usize..][..stencil.count as usize]
    }

    /// The line of a stencil through the cells.
    #[inline(always)]
    fn ray(&self, stencil: &Stencil, arm: &Vector3<f64>) -> Ray<'_, D> {
        let mut start = self.centre;
        let mut along = [0.0; D];
        let inverse_h = &self.lattice.inverse_h;
        let line = self.lines.get(stencil.line as usize);
        for a in 0..D {
            along[a] = inverse_h[a] * line.map_or(arm[a], |line| line.along[a]);
            start[a] += line.map_or(0.0, |line| inverse_h[a] * line.from[a]);
        }
        Ray { lattice: &self.lattice, origin: stencil.origin, start, along }
    }

    /// The rigid motion of a body along the line of a stencil, as `rest + out turning` (m/s).
    #[inline(always)]
    fn rigid(
        &self,
        stencil: &Stencil,
        arm: &Vector3<f64>,
        body: &RigidVelocity,
    ) -> (Vector3<f64>, Vector3<f64>) {
        let RigidVelocity { velocity, spin } = body;
        match self.lines.get(stencil.line as usize) {
            None => (*velocity, spin.cross(arm)),
            Some(line) => (velocity + spin.cross(&line.from), spin.cross(&line.along)),
        }
    }
}

#[inline(always)]
fn vector<const D: usize>(numbers: &[f64; D]) -> Vector3<f64> {
    Vector3::from_fn(|a, _| if a < D { numbers[a] } else { 0.0 })
}
