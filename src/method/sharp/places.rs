//! Where the bodies are cut: as long as one stays near to where it was cut last, it stays cut as it
//! was, and so does what it covers, sets and reads there.
//!
//! ```text
//!   cut anew:  |x - x_cut| + |R - R_cut| r > 1e-3 h    x: centre, R: orientation, r: radius
//!              or the last cut was 2e-3 h and more from the one before: of cells that the body
//!              then left it sets the velocity for one step alone
//! ```

use super::seen::Moved;
use crate::numerics::CUT_ANEW;
use crate::particles::Body;
use crate::state::{BodyHistory, CutAt};
use std::collections::HashMap;

/// The bodies as they are cut.
pub struct CutPlaces {
    /// The bodies as they lay when they were cut last.
    pub bodies: Vec<Body>,
    /// How each had moved then since it was cut before.
    pub moved: Vec<Moved>,
    /// Which of them have to be cut anew.
    pub stirred: Vec<bool>,
    /// The distance within which none has (m).
    least: f64,
}

impl CutPlaces {
    /// The bodies where they lie, to be cut, on a grid of this spacing (m).
    pub fn new(bodies: &[Body], h: f64) -> CutPlaces {
        CutPlaces {
            bodies: bodies.to_vec(),
            moved: bodies.iter().map(Moved::not).collect(),
            stirred: vec![true; bodies.len()],
            least: CUT_ANEW * h,
        }
    }

    /// Takes the bodies, all to be cut, where they were cut by these histories, and where they lie
    /// if they have none.
    pub fn settle(&mut self, bodies: &[Body], histories: &[BodyHistory]) {
        self.bodies.clone_from_slice(bodies);
        for (body, history) in self.bodies.iter_mut().zip(histories) {
            if let Some(CutAt { centre, orientation }) = history.cut_at {
                body.centre = centre;
                body.orientation = orientation;
            }
        }
        self.moved.iter_mut().zip(&self.bodies).for_each(|(moved, body)| *moved = Moved::not(body));
        self.stirred.fill(true);
    }

    /// Per body of other ones, its number among these, if it is cut in the same place here.
    pub fn find(&self, others: &CutPlaces) -> Vec<Option<usize>> {
        let numbers: HashMap<usize, usize> =
            self.bodies.iter().enumerate().map(|(k, body)| (body.id, k)).collect();
        let here = |other: &Body| {
            let k = *numbers.get(&other.id)?;
            (self.bodies[k].pose() == other.pose()).then_some(k)
        };
        others.bodies.iter().map(here).collect()
    }

    /// Takes the bodies that have moved too far since they were cut last. Returns whether there are
    /// any.
    pub fn follow(&mut self, bodies: &[Body], periods: &[Option<f64>; 3]) -> bool {
        for (k, body) in bodies.iter().enumerate() {
            let moved = Moved::since(&self.bodies[k].pose(), body, periods);
            self.stirred[k] = moved.farthest > self.least || self.has_left_cells(k);
            if self.stirred[k] {
                self.bodies[k].clone_from(body);
                self.moved[k] = moved;
            }
        }
        self.stirred.contains(&true)
    }

    /// Takes these bodies as cut anew where they were cut before, unless they have moved.
    pub fn stay(&mut self, again: &[bool]) {
        for (k, body) in self.bodies.iter().enumerate() {
            if again[k] && !self.stirred[k] {
                self.moved[k] = Moved::not(body);
            }
        }
    }

    /// Keeps in the histories where bodies are cut; of none that may have left cells as it was cut,
    /// which are the fluid's after a step.
    pub fn keep(&self, histories: &mut [BodyHistory]) {
        for (k, history) in histories.iter_mut().enumerate() {
            let Body { centre, orientation, .. } = self.bodies[k];
            history.cut_at = (!self.has_left_cells(k)).then_some(CutAt { centre, orientation });
        }
    }

    /// Has the bodies cut anew in the next step whose histories do not know where they are cut.
    pub fn recall(&mut self, histories: &[BodyHistory]) {
        let all = self.moved.iter_mut().zip(histories);
        let anew = all.filter(|(_, history)| history.cut_at.is_none());
        anew.for_each(|(moved, _)| moved.farthest = f64::INFINITY);
    }

    fn has_left_cells(&self, k: usize) -> bool {
        self.moved[k].farthest > 2.0 * self.least
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Disc;
    use nalgebra::vector;
    use std::sync::Arc;

    #[test]
    fn bodies_are_cut_anew_where_they_moved_and_once_more_where_they_left_cells() {
        let mut body = Body::new(Arc::new(Disc { radius: 0.4 }), 1.0, 0.0, vector![1.0, 1.0, 0.0]);
        let mut places = CutPlaces::new(std::slice::from_ref(&body), 0.1);
        let mut cut_after = |spacings: f64| {
            body.centre.x += 0.1 * spacings;
            let cut = places.follow(std::slice::from_ref(&body), &[None; 3]);
            let mut histories = [BodyHistory::default()];
            places.keep(&mut histories);
            (cut, histories[0].cut_at.is_some())
        };
        // By little, by as much in all as counts, by far, and not any more.
        let ways = [4e-4, 4e-4, 4e-4, 0.3, 0.0, 0.0];
        let found = ways.map(&mut cut_after);
        let cut = [false, false, true, true, true, false];
        let known = [true, true, true, false, true, true];
        assert_eq!(found, std::array::from_fn(|n| (cut[n], known[n])));
    }
}
