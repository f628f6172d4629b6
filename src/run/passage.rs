//! Free bodies that reach an outflow: they leave, come in again at the other end, or end the run,
//! as the case says. And bodies that come in.

use super::Run;
use crate::Result;
use crate::config::Removed;
use crate::particles::{Body, nearest_image};
use nalgebra::Vector3;

impl<const D: usize> Run<'_, D> {
    /// Takes the bodies out that would reach an outflow in the next step, about as long as the last
    /// one, `dt` (s); says whether one has come in again, or nothing where the case wants the run
    /// to end there instead. Collective.
    pub(super) fn pass(&mut self, dt: f64) -> Result<Option<bool>> {
        // Once each: what the fluid takes along may go out at the other side of the box at once.
        let mut returned = Vec::new();
        while let Some((k, axis)) = self.scene.leaving(dt, &returned) {
            let step = self.scene.state.steps;
            let time = self.scene.state.time;
            let body = &self.scene.state.bodies[k];
            let entrance = (self.case.output.removed == Removed::Return)
                .then(|| self.entrance(body, axis))
                .flatten();
            let (what, body) = match (self.case.output.removed, entrance) {
                (Removed::Stop, _) => {
                    self.log.say(&format!(
                        "particle {} has reached an outflow at t = {time:.6} s: the run ends here, \
                        as output.removed = \"stop\" says",
                        body.id
                    ));
                    return Ok(None);
                }
                (_, Some(centre)) => {
                    returned.push(body.id);
                    self.scene.bring(self.case, k, centre)?;
                    ("returned", self.scene.state.bodies[k].clone())
                }
                _ => ("left", self.scene.remove(self.case, k)?),
            };
            let id = body.id;
            self.on_lead(|folder, _, log| {
                log.say(&format!("particle {id} {what} at t = {time:.6} s"));
                folder.write_passage(step, time, what, &body)
            })?;
        }
        Ok(Some(!returned.is_empty()))
    }

    /// Lets bodies in that wait for it, and says whether one came. Collective.
    pub(super) fn admit(&mut self) -> Result<bool> {
        let came = self.scene.admit(self.case)?;
        for body in &came {
            let step = self.scene.state.steps;
            let time = self.scene.state.time;
            self.on_lead(|folder, _, log| {
                log.say(&format!("particle {} came in at t = {time:.6} s", body.id));
                folder.write_passage(step, time, "entered", body)
            })?;
        }
        Ok(!came.is_empty())
    }

    /// Where a body comes in again that goes out along an axis (m); `None` where another one is in
    /// its way.
    fn entrance(&self, body: &Body, axis: usize) -> Option<Vector3<f64>> {
        let domain = &self.scene.domain;
        let s = &self.scene.state;
        let mut centre = body.centre;
        let far = domain.grid.size[axis];
        let extent = body.reach()[axis];
        centre[axis] = if body.centre[axis] > 0.5 * far { extent } else { far - extent };
        let clear = |other: &Body| {
            let apart = nearest_image(&other.centre, &centre, &domain.periods()).norm();
            other.id == body.id || apart >= body.radius() + other.radius()
        };
        s.bodies.iter().all(clear).then_some(centre)
    }
}
