//! The cells of a body as it cuts the grid: those whose velocity it sets, and those beside the
//! faces that it covers.
//!
//! ```text
//!      .   .   .   .      o   ghost cells: inside, in gaps that the grid does not resolve, and
//!   ---o---o---o---o---       within 0.2 h outside a flat surface of a fixed body
//!      o   o  +|   .      +   between two faces that are about as near: the profiles of both
//!   .   .  . --+   .
//! ```

use super::PROFILE_DEPTH;
use super::cut_body::{Before, CutBody, GhostCell, OwnCell};
use super::gap::{Surroundings, smooth_step};
use super::shared_cell::SharedCell;
use super::stencil::{Image, Normal, Reading, Stencil};
use crate::geometry::{Block, Overlap, Planes, Shape, images};
use crate::grid::Grid;
use crate::particles::Body;
use nalgebra::Vector3;

/// Distance (spacings) up to which cells outside a fixed flat surface have the profile in place of
/// a momentum of their own, and up to twice that a part of it: a row of them along it would see no
/// more of themselves in their ghost cells, and turn with the row above, faster than eight Legendre
/// stages bear (1.075 times a step at 0.01, 1.015 at 0.05, 0.95 at 0.1).
const CLOSE: f64 = 0.1;

/// How far a cell's middle is at most from what a face beside it is covered by (m).
fn beside_face<const D: usize>(grid: &Grid<D>) -> f64 {
    let square = |axis: usize| {
        (0..D).map(|a| grid.h[a] * if a == axis { 1.0 } else { 0.5 }).map(|x| x * x).sum::<f64>()
    };
    (0..D).map(square).fold(0.0, f64::max).sqrt()
}

/// How far outside a body cells concern it (m).
struct Reach {
    /// In gaps that the grid does not resolve.
    tight: f64,
    /// As far as a point of the body went.
    way: f64,
    /// Beside the faces that it covers.
    beside: f64,
    /// With a profile as those inside have.
    outside: f64,
}

/// What a body sees of a cell.
struct Seen {
    /// Signed distance from the surface (m), and the normal there of a body that is not round.
    s: f64,
    normal: Option<Vector3<f64>>,
    /// Whether the body has just left it.
    cleared: bool,
}

impl Reach {
    /// What a body of this shape, which lay `before`, sees of the cell at `arm` (m); none where
    /// that is nothing to it.
    fn seen<const D: usize>(
        &self,
        around: &Surroundings<D>,
        shape: &dyn Shape,
        before: &Before,
        arm: &Vector3<f64>,
        touched: bool,
        planes: &mut Planes,
    ) -> Option<Seen> {
        let (orientation, point) = (&around.orientation, Vector3::zeros());
        let far = self.tight.max(self.way).max(self.beside);
        if !touched && around.round.is_none() && planes.clears(shape, orientation, arm, &point, far)
        {
            return None;
        }
        let (s, normal) = around.nearest(shape, orientation, arm);
        let cleared = s > 0.0
            && s <= self.way
            && around.distance(shape, &before.orientation, &(arm + before.way)) <= 0.0;
        let concerns = touched || cleared || s <= self.tight || s < self.beside;
        (concerns && shape.owns(orientation, arm)).then_some(Seen { s, normal, cleared })
    }
}

impl<const D: usize> CutBody<D> {
    /// Finds its own cells and its ghost cells within an extent (m), of which those in gaps
    /// narrower than `tight` (m) lie outside.
    pub(super) fn find_cells(
        &mut self,
        around: &Surroundings<D>,
        k: usize,
        before: &Before,
        extent: &Vector3<f64>,
        tight: f64,
    ) {
        let (grid, body) = (around.grid, &around.bodies[k]);
        let mut touched_cells = 0;
        let reach = self.reach(around, body, before, tight);
        let extent = extent.add_scalar(reach.beside);
        for centre in images(grid, body.shape(), &body.centre) {
            let image = self.stencils.image(grid, centre);
            let mut planes = Planes::default();
            for at in Block::owned(grid, &centre, &extent) {
                let arm = Vector3::from_fn(|a, _| {
                    if a < D { (at[a] as f64 + 0.5) * grid.h[a] - centre[a] } else { 0.0 }
                });
                let Some(cell) = grid.owned_index(at) else { continue };
                // Cells that it touches come in the same order, image by image; the next one may be
                // the first that another image touches.
                let own =
                    |solid: &Overlap| solid.cell == cell && (solid.arm - arm).amax() < around.h;
                let touched = self.solid.get(touched_cells).is_some_and(own);
                touched_cells += usize::from(touched);
                let seen = reach.seen(around, body.shape(), before, &arm, touched, &mut planes);
                let Some(seen) = seen else { continue };
                let s = seen.s;
                let owned = around.ownership(&arm, s);
                // A cell beside a covered face counts from where it does not touch the body yet: as
                // the surface passes a line of the grid, nothing jumps.
                if (touched || s < reach.beside) && owned > 0.0 {
                    let arm = if touched { self.solid[touched_cells - 1].arm } else { arm };
                    self.add_own_cell(arm, owned, cell);
                }
                if (s <= tight.max(reach.outside) || seen.cleared) && owned > 0.0 {
                    self.add_ghost_cell(around, k, &image, &arm, seen, owned, cell);
                }
            }
        }
        debug_assert_eq!(touched_cells, self.solid.len());
        self.targets.clear();
        self.targets.resize(self.ghost_cells.len(), Vector3::zeros());
    }

    /// How far from a body cells concern it, of which those in gaps do up to `tight` (m).
    fn reach(&self, around: &Surroundings<D>, body: &Body, before: &Before, tight: f64) -> Reach {
        // No body has left a cell that is further off than a point of it went.
        let turned = (around.orientation.matrix() - before.orientation.matrix()).norm();
        let turned = if around.round.is_some() { 0.0 } else { turned };
        Reach {
            tight,
            way: before.way.norm() + (turned + 1e-9) * body.radius(),
            beside: if self.flat { beside_face(around.grid) } else { 0.0 },
            outside: if self.flat && around.cubic { 2.0 * CLOSE * around.h } else { 0.0 },
        }
    }

    fn add_own_cell(&mut self, arm: Vector3<f64>, owned: f64, cell: usize) {
        if owned < 1.0 {
            let next = SharedCell::next(&self.own_cells, cell, owned, 1.0, false);
            self.shared_own_cells.push(next);
        }
        let (ownership, cell, cut_change) = (owned, cell as u32, [0.0; D]);
        self.own_cells.push(OwnCell { ownership, cut_change, cell });
        self.own_arms.push(arm);
    }

    /// Adds the ghost cell at `arm` (m), of which the body has `seen` this, and the profile that it
    /// needs.
    #[allow(clippy::too_many_arguments)]
    fn add_ghost_cell(
        &mut self,
        around: &Surroundings<D>,
        k: usize,
        image: &Image,
        arm: &Vector3<f64>,
        Seen { s, normal, cleared }: Seen,
        owned: f64,
        cell: usize,
    ) {
        let (body, shared) = (&around.bodies[k], owned < 1.0);
        let normal =
            || Normal::new(around.round, arm, s, normal.unwrap_or_else(|| arm.normalize()));
        let mut weight = 1.0;
        if s > 0.0 && !cleared {
            let (across, share) = self.stencils.profile_across(around, image, &normal(), s);
            weight = share;
            if weight > 0.0 {
                self.add_profile(around, arm, across, 1.0);
            } else if self.flat && around.cubic && s < 2.0 * CLOSE * around.h {
                weight = 1.0 - smooth_step(s / around.h, CLOSE, 2.0 * CLOSE);
                self.add_profile_at(around, image, arm, s, &normal(), 1.0);
            } else if !shared {
                return;
            }
        } else if s > -body.radius().min(PROFILE_DEPTH * around.h) {
            self.find_feet(around, body.shape(), arm, s);
            if self.feet.len() < 2 {
                self.add_profile_at(around, image, arm, s, &normal(), 1.0);
                self.feet.clear();
            }
            let all: f64 = (0..self.feet.len()).map(|i| around.share_of(s, i, &self.feet)).sum();
            for i in 0..self.feet.len() {
                let foot = self.feet[i];
                let share = around.share_of(s, i, &self.feet) / all;
                let normal = Normal::new(None, arm, foot.distance, foot.normal);
                self.add_profile_at(around, image, arm, foot.distance, &normal, share);
            }
        }
        if shared {
            let next = SharedCell::next(&self.ghost_cells, cell, owned, weight, cleared);
            self.shared_ghost_cells.push(next);
        }
        let (arm, cell, first) = (*arm, cell as u32, true);
        self.ghost_cells.push(GhostCell { arm, weight, cell, cleared, first });
    }

    /// Finds the faces of a body with sharp edges that are about as near to the cell inside at
    /// `arm` (m) as the nearest, at the signed distance `s` (m).
    fn find_feet(
        &mut self,
        around: &Surroundings<D>,
        shape: &dyn Shape,
        arm: &Vector3<f64>,
        s: f64,
    ) {
        self.feet.clear();
        if around.round.is_none() {
            let within = around.beside_nearest(s) - s;
            shape.feet(&around.orientation, arm, within, &mut self.feet);
        }
    }

    /// Adds the profile at the signed distance `s` (m) along a normal to the ghost cell that comes
    /// next.
    fn add_profile_at(
        &mut self,
        around: &Surroundings<D>,
        image: &Image,
        arm: &Vector3<f64>,
        s: f64,
        normal: &Normal,
        share: f64,
    ) {
        let stencil = self.stencils.profile(around, image, normal, s);
        if around.cubic {
            let own = Reading { arm: *arm, stencil, place: self.ghost_cells.len() as u32 };
            let own = (self.profiles.len(), &own);
            self.cubic.extend(self.stencils.cubic(around, image, normal, s, own));
        }
        self.add_profile(around, arm, stencil, share);
    }

    fn add_profile(
        &mut self,
        around: &Surroundings<D>,
        arm: &Vector3<f64>,
        stencil: Stencil,
        share: f64,
    ) {
        if stencil.is_still() {
            return;
        }
        self.profiles.push(Reading { arm: *arm, stencil, place: self.ghost_cells.len() as u32 });
        if around.round.is_none() {
            self.shares.push(share);
        }
    }
}
