//! Bodies that leave the box: what lasts of them goes, what lasts of the others stays, and the method is made anew for these.

use super::{Scene, build};
use crate::config::Case;
use crate::grid::Border;
use crate::method::energy;
use crate::particles::{Body, Motion};
use crate::{Error, Result};
use nalgebra::Vector3;

impl<const D: usize> Scene<D> {
    /// The place in the list of the first free body whose surface may reach an outflow within a step as long as `dt` (s), and the axis.
    /// No body reaches through one: the part of it outside would be missing in what the fluid does to it.
    pub fn leaving(&self, dt: f64) -> Option<(usize, usize)> {
        let (grid, borders) = (&self.domain.grid, &self.domain.boundaries.borders);
        let open = |axis: usize, side: usize| matches!(borders[axis][side], Some(Border::Outflow));
        let leaves = |body: &Body, axis: usize| {
            let (at, extent) =
                (body.centre[axis] + 1.5 * dt * body.velocity[axis], body.shape().bounds(&body.turn())[axis]);
            // What goes inwards stays, however near it is.
            let (low, high) = (
                at <= extent && body.velocity[axis] < 0.0,
                at >= grid.size[axis] - extent && body.velocity[axis] > 0.0,
            );
            (low && open(axis, 0)) || (high && open(axis, 1))
        };
        let free = self.state.bodies.iter().enumerate().filter(|(_, body)| matches!(body.motion, Motion::Free(_)));
        free.flat_map(|(k, body)| (0..D).map(move |axis| (k, body, axis)))
            .find_map(|(k, body, axis)| leaves(body, axis).then_some((k, axis)))
    }

    /// Takes the body at the place `k` of the list out of the box. What it had of momentum and energy is counted as the border's.
    /// Collective.
    ///
    /// # Errors
    /// When the method cannot be made for the others.
    pub fn remove(&mut self, case: &Case, k: usize) -> Result<Body> {
        if k >= self.state.bodies.len() {
            return Err(Error::Run(format!("there is no body {k} to be removed")));
        }
        let s = &mut self.state;
        let gone = s.bodies.remove(k);
        s.exchange.remove(k);
        if let Some(walls) = &mut s.walls {
            walls.bodies.remove(k);
        }
        s.touching.springs.retain(|(first, second, _)| *first != k && *second != k);
        for (first, second, _) in &mut s.touching.springs {
            // A wall's number follows those of the bodies.
            *first -= usize::from(*first > k);
            *second -= usize::from(*second > k);
        }
        self.remake(case)?;
        Ok(gone)
    }

    /// Brings the body at the place `k` of the list to another place (m), at the velocity that it has. Collective.
    ///
    /// # Errors
    /// As [`Scene::remove`].
    pub fn bring(&mut self, case: &Case, k: usize, centre: Vector3<f64>) -> Result<()> {
        self.state.bodies[k].centre = centre;
        self.state.touching.springs.retain(|(first, second, _)| *first != k && *second != k);
        self.remake(case)
    }

    /// Makes the method anew for the bodies as they are, and balance and budget with it. Collective.
    fn remake(&mut self, case: &Case) -> Result<()> {
        self.method = build::method(&self.domain, case, &self.state.bodies);
        self.resume()?;
        self.method.rebalance(&self.domain, &mut self.state)?;
        energy::reopen(&mut self.domain, &mut self.state, &self.method)
    }

    /// The numbers of the bodies.
    pub fn ids(&self) -> Vec<u64> {
        self.state.bodies.iter().map(|body| body.id as u64).collect()
    }

    /// Keeps the bodies of these numbers only, before their state is read. Collective.
    ///
    /// # Errors
    /// When there is another one among them.
    pub fn keep_only(&mut self, case: &Case, ids: &[u64]) -> Result<()> {
        let s = &mut self.state;
        if s.bodies.len() == ids.len() {
            return Ok(());
        }
        s.bodies.retain(|body| ids.binary_search(&(body.id as u64)).is_ok());
        if s.bodies.len() != ids.len() {
            return Err(Error::Usage("it has particles that the case has not".into()));
        }
        s.exchange.truncate(ids.len());
        if let Some(walls) = &mut s.walls {
            walls.bodies.truncate(ids.len());
        }
        self.method = build::method(&self.domain, case, &self.state.bodies);
        Ok(())
    }
}
