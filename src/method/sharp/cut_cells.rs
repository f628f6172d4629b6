//! The cells of a body as it cuts the grid: those whose velocity it sets, and those beside the
//! faces that it covers.
//!
//! ```text
//!      .   .   .   .      o   ghost cells: inside, in gaps that the grid does not resolve, and
//!   ---o---o---o---o---       within 0.2 h outside a flat surface of a fixed body
//!      o   o  +|   .      +   between two faces that are about as near: the profiles of both
//!   .   .  . --+   .
//! ```

use super::cut_body::{CutBody, GhostCell, OwnCell, OwnCells};
use super::gap::{Surroundings, UNRESOLVED, smooth_step};
use super::normal::{Foot, Normal};
use super::seen::{Before, Feet, Known, Reach, SeenCell, Sight};
use super::shared_cell::SharedCell;
use super::stencil::{Image, Reading, Stencil};
use crate::geometry::{Block, Overlap, images};
use crate::grid::Grid;
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

impl<const D: usize> CutBody<D> {
    /// Finds its own cells and its ghost cells within `bounds` about its centre (m), of which those
    /// in gaps narrower than `tight` (m) lie outside. A body that stays where it is sees each cell
    /// once, as far as it ever may.
    pub(super) fn find_cells(
        &mut self,
        around: &Surroundings<D>,
        k: usize,
        before: &Before,
        bounds: &Vector3<f64>,
        tight: f64,
    ) {
        let reach = self.reach(around, k, before, tight);
        let mut kept = self.kept.take();
        let mut feet = std::mem::take(&mut self.ghosts.feet);
        if let Some(kept) = kept.as_mut().filter(|_| around.round.is_none()) {
            if !kept.sees {
                let reach = self.reach(around, k, before, UNRESOLVED * around.profiles.h);
                self.see_cells(around, k, before, bounds, &reach, |_, mut seen| {
                    seen.find_feet(around, k, &reach, &mut kept.feet, &mut feet.near);
                    kept.cells.push(seen);
                });
                kept.sees = true;
            }
            for seen in &kept.cells {
                let owned = around.ownership(&seen.arm, seen.sight.s);
                self.add_cell(around, &reach, seen, owned, &kept.feet);
            }
        } else {
            let Feet { near, of_cell } = &mut feet;
            self.see_cells(around, k, before, bounds, &reach, |body, mut seen| {
                let owned = around.ownership(&seen.arm, seen.sight.s);
                of_cell.clear();
                if owned > 0.0 {
                    seen.find_feet(around, k, &reach, of_cell, near);
                }
                body.add_cell(around, &reach, &seen, owned, of_cell);
            });
        }
        self.kept = kept;
        self.ghosts.feet = feet;
    }

    /// Calls with the cells that concern it, of those within `bounds` about its centre (m) and the
    /// reach beyond.
    fn see_cells(
        &mut self,
        around: &Surroundings<D>,
        k: usize,
        before: &Before,
        bounds: &Vector3<f64>,
        reach: &Reach,
        mut found: impl FnMut(&mut CutBody<D>, SeenCell),
    ) {
        let grid = around.grid;
        let body = &around.bodies[k];
        let mut touched_cells = 0;
        let extent = bounds.add_scalar(before.way.norm().max(reach.tight));
        let extent = extent.add_scalar(reach.beside);
        for centre in images(grid, body.shape(), &body.centre) {
            let image = self.stencils.image(grid, centre);
            let mut known = Known::default();
            for at in Block::owned(grid, &centre, &extent) {
                let arm = Vector3::from_fn(|a, _| {
                    if a < D { (at[a] as f64 + 0.5) * grid.h[a] - centre[a] } else { 0.0 }
                });
                let Some(cell) = grid.owned_index(at) else { continue };
                // Cells that it touches come in the same order, image by image; the next one may be
                // the first that another image touches.
                let own = |solid: &Overlap| {
                    solid.cell == cell && (solid.arm - arm).amax() < around.profiles.h
                };
                let touched = self.solid.get(touched_cells).filter(|solid| own(solid));
                let touched = touched.map(|solid| solid.arm);
                touched_cells += usize::from(touched.is_some());
                let sight = reach.sight(around, before, &arm, touched.is_some(), &mut known);
                if let Some(sight) = sight {
                    let cell = cell as u32;
                    found(self, SeenCell { image, arm, touched, sight, cell, feet: [0; 2] });
                }
            }
        }
        debug_assert_eq!(touched_cells, self.solid.len());
    }

    /// Adds a cell, so far as it is `owned`, with its feet among those given.
    fn add_cell(
        &mut self,
        around: &Surroundings<D>,
        reach: &Reach,
        seen: &SeenCell,
        owned: f64,
        feet: &[Foot],
    ) {
        if owned <= 0.0 {
            return;
        }
        // A cell beside a covered face counts from where it does not touch the body yet: as the
        // surface passes a line of the grid, nothing jumps.
        if seen.touched.is_some() || seen.sight.s < reach.beside {
            self.add_own_cell(seen.touched.unwrap_or(seen.arm), owned, seen.cell);
        }
        if reach.sets(&seen.sight) {
            self.add_ghost_cell(around, seen, owned, &feet[seen.feet()]);
        }
    }

    /// How far from a body cells concern it, of which those in gaps do up to `tight` (m).
    fn reach(&self, around: &Surroundings<D>, k: usize, before: &Before, tight: f64) -> Reach {
        let body = &around.bodies[k];
        // No body has left a cell that is further off than a point of it went.
        let turned = (around.orientation.matrix() - before.orientation.matrix()).norm();
        let turned = if around.round.is_some() { 0.0 } else { turned };
        Reach {
            tight,
            way: before.way.norm() + (turned + 1e-9) * body.radius(),
            beside: if self.surface.flat { beside_face(around.grid) } else { 0.0 },
            outside: if self.surface.flat && around.profiles.cubic {
                2.0 * CLOSE * around.profiles.h
            } else {
                0.0
            },
        }
    }

    fn add_own_cell(&mut self, arm: Vector3<f64>, owned: f64, cell: u32) {
        let OwnCells { cells, shared } = &mut self.own;
        if owned < 1.0 {
            shared.push(SharedCell::next(cells, cell, owned, 1.0, false));
        }
        cells.push(OwnCell { arm, ownership: owned, cut_change: [0.0; D], cell });
    }

    /// Adds a ghost cell, and the profiles that it needs, from these feet; the deep ones have none.
    fn add_ghost_cell(
        &mut self,
        around: &Surroundings<D>,
        seen: &SeenCell,
        owned: f64,
        feet: &[Foot],
    ) {
        let SeenCell { image, arm, cell, .. } = seen;
        let shared = owned < 1.0;
        let Sight { s, cleared, .. } = seen.sight;
        let mut weight = 1.0;
        if let (true, [foot]) = (s > 0.0 && !cleared, feet) {
            let normal = foot.normal(around.round, arm);
            let (across, share) = self.stencils.profile_across(around, image, &normal, s);
            weight = share;
            if weight > 0.0 {
                self.add_profile(arm, across, 1.0);
            } else if self.surface.flat
                && around.profiles.cubic
                && s < 2.0 * CLOSE * around.profiles.h
            {
                weight = 1.0 - smooth_step(s / around.profiles.h, CLOSE, 2.0 * CLOSE);
                self.add_profile_at(around, image, arm, &normal, foot, 1.0);
            } else if !shared {
                return;
            }
        } else if let [foot] = feet {
            self.add_profile_at(around, image, arm, &foot.normal(around.round, arm), foot, 1.0);
        } else {
            let all: f64 = (0..feet.len()).map(|i| around.share_of(s, i, feet)).sum();
            for (i, foot) in feet.iter().enumerate() {
                let share = around.share_of(s, i, feet) / all;
                self.add_profile_at(
                    around,
                    image,
                    arm,
                    &foot.normal(around.round, arm),
                    foot,
                    share,
                );
            }
        }
        if shared {
            let next = SharedCell::next(&self.ghosts.cells, *cell, owned, weight, cleared);
            self.ghosts.shared.push(next);
        }
        self.ghosts.cells.push(GhostCell {
            arm: *arm,
            weight,
            target: Vector3::zeros(),
            offset: Vector3::zeros(),
            cell: *cell,
            cleared,
            first: true,
        });
    }

    /// Adds the profile from a foot along its normal to the ghost cell that comes next.
    fn add_profile_at(
        &mut self,
        around: &Surroundings<D>,
        image: &Image,
        arm: &Vector3<f64>,
        normal: &Normal,
        foot: &Foot,
        share: f64,
    ) {
        let s = foot.near.distance;
        let stencil = self.stencils.profile(around, image, normal, s);
        if around.profiles.cubic {
            let place = self.ghosts.cells.len() as u32;
            let own = Reading { arm: *arm, stencil, place, share };
            let profile = self.ghosts.profiles.len();
            let cubic = self.stencils.cubic(around, image, normal, s, profile, &own);
            self.ghosts.cubic.extend(cubic);
        }
        self.add_profile(arm, stencil, share);
    }

    fn add_profile(&mut self, arm: &Vector3<f64>, stencil: Stencil, share: f64) {
        if stencil.is_still() {
            return;
        }
        let place = self.ghosts.cells.len() as u32;
        self.ghosts.profiles.push(Reading { arm: *arm, stencil, place, share });
    }
}
