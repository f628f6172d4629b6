//! Contact of a convex part with a region of an obstacle's surface ([`crate::contact::region`]).
//!
//! ```text
//!   ball, smooth part   D by Euler's sum, p as the law's potential, which then is the sum of what
//!                       each of several nearest points would have
//!   polytope            p = 8 as of two polytopes: its corners, as balls of its rounding, with the
//!                       faces (each by Euler's sum), sharp corners of the surface with it, and its
//!                       edges with sharp edges
//! ```

use crate::contact::beside::Beside;
use crate::contact::depths::{POWER, Patch, Touch, mean};
use crate::contact::faces::Mesh;
use crate::contact::flags::Flags;
use crate::contact::foot::foot;
use crate::contact::near::{Crossing, Foot, around, crossing, foot_of_ball};
use crate::contact::part::{Core, Part, Polytope};
use crate::contact::polytope;
use crate::contact::pose::{Placed, Pose};
use crate::contact::region::{Bound, Held, Region};
use crate::contact::touch::{SAME, radius};
use nalgebra::Vector3;

/// A part of a body beside a region that it may touch.
struct Above<'a> {
    mesh: &'a Mesh,
    region: &'a Region,
    part: &'a Part,
    pose: &'a Pose,
    /// Bound of the way by which any gap has narrowed since the faces were found (m).
    way: f64,
}

/// Contact of a part of a body in this pose with a region, in the axes of the surface: the place is
/// on the surface. `power` is p for parts that are no polytopes.
pub fn touch_region(mesh: &Mesh, region: &Region, part: &Part, pose: &Pose, power: f64) -> Touch {
    let above = Above { mesh, region, part, pose, way: region.way(part, pose) };
    match &part.core {
        Core::Polytope(polytope) => above.touch_polytope(polytope),
        _ => above.touch(power),
    }
}

impl Above<'_> {
    /// Local radii of curvature of the part where the surface lies along `normal`, and of that (m).
    fn radii(&self, normal: &Vector3<f64>) -> [f64; 2] {
        [radius(self.part, &Placed::new(self.part, self.pose), normal), f64::INFINITY]
    }

    /// The contact at one point.
    fn single(&self, foot: &Foot) -> Touch {
        let normal = -foot.up;
        Touch::single(normal, -foot.gap, foot.place, self.radii(&normal))
    }

    /// The contact of a patch, where it touches.
    fn whole(&self, patch: &Patch) -> Option<Touch> {
        patch.is_touched().then(|| patch.whole(self.radii(&patch.direction())))
    }

    /// The faces that may overlap, by the gap that they had.
    fn near(&self) -> impl Iterator<Item = (usize, &Held)> {
        let near = self.region.faces.iter().take_while(|face| face.gap <= self.way);
        near.enumerate()
    }

    /// The corners of a face (m).
    fn simplex<'b>(&self, face: &'b Held) -> &'b [Vector3<f64>] {
        &face.corners[..self.mesh.dimension()]
    }

    /// Contact of a ball or a curved part.
    fn touch(&self, power: f64) -> Touch {
        let placed = Placed::new(self.part, self.pose);
        let mut patch = Patch::about(self.part.rounding, placed.place, power);
        let (nearest, overlapping) = match Beside::new(placed) {
            Some(beside) => self.find(|face, best| {
                let foot = beside.nearer(self.simplex(face), &face.normal, best)?;
                add(&mut patch, Some(foot), 1.0);
                Some(foot)
            }),
            None => {
                self.find(|face, _| self.foot_of(self.simplex(face), &face.normal, f64::INFINITY))
            }
        };
        if overlapping.count < 2 {
            return self.single(&nearest);
        }
        if self.part.core == Core::Point {
            patch = Patch::about(self.part.rounding, nearest.place, power);
            for (_, face) in self.near().filter(|(k, _)| overlapping.may(*k as u32)) {
                add(&mut patch, self.foot_of(self.simplex(face), &face.normal, 0.0), 1.0);
            }
        }
        self.add_edges(&overlapping, &mut patch, |simplex| {
            self.foot_of(simplex, &Vector3::zeros(), 0.0)
        });
        self.whole(&patch).unwrap_or_else(|| self.single(&nearest))
    }

    /// The foot on a simplex of a face with this normal, where the gap is less than `most` (m).
    fn foot_of(&self, simplex: &[Vector3<f64>], normal: &Vector3<f64>, most: f64) -> Option<Foot> {
        foot(self.part, self.pose, simplex, normal, most)
    }

    /// The foot of the nearest face, and which overlap. Those that are no nearer since they were
    /// found are passed over, as are others of which `foot` knows that they are no nearer than
    /// `best` (m).
    fn find(&self, mut foot: impl FnMut(&Held, f64) -> Option<Foot>) -> (Foot, Flags) {
        let mut best = Foot { gap: f64::INFINITY, up: Vector3::x(), place: self.pose.place };
        let mut overlapping = Flags::none();
        for (k, face) in self.region.faces.iter().enumerate() {
            let least = best.gap.max(0.0);
            if face.gap - self.way > least {
                break;
            }
            let Some(foot) = foot(face, least) else { continue };
            if foot.gap < 0.0 {
                overlapping.add(k);
            }
            if foot.gap < best.gap {
                best = foot;
            }
        }
        (best, overlapping)
    }

    /// Adds the depths of edges and corners by the signs of Euler's sum.
    fn add_edges(
        &self,
        overlapping: &Flags,
        patch: &mut Patch,
        foot: impl Fn(&[Vector3<f64>]) -> Option<Foot>,
    ) {
        for Bound { corners, counts, faces, .. } in &self.region.edges {
            if *counts != 0.0 && faces.iter().all(|k| overlapping.may(*k)) {
                add(patch, foot(&corners.map(|k| self.mesh.corner(k))), *counts);
            }
        }
        for Bound { corners, counts, faces, .. } in &self.region.corners {
            if *counts != 0.0 && faces.iter().all(|k| overlapping.may(*k)) {
                add(patch, foot(&[self.mesh.corner(*corners)]), *counts);
            }
        }
    }

    fn touch_polytope(&self, polytope: &Polytope) -> Touch {
        let side = Placed::new(self.part, self.pose);
        let mut patch = Patch::about(self.part.rounding, side.place, f64::from(POWER));
        let mut near = Flags::none();
        for (k, face) in self.near() {
            if self.least_height(polytope, &side, self.simplex(face)) < self.part.rounding {
                near.add(k);
            }
        }
        if near.count > 0 {
            for corner in &polytope.corners {
                self.add_corner(&near, &self.region.before(corner), &side.at(corner), &mut patch);
            }
            self.add_sharp(&near, polytope, &side, &mut patch);
        }
        self.whole(&patch).unwrap_or_else(|| self.beside_polytope(polytope, &side))
    }

    /// The least that a corner, an edge or a face of these corners (m) can be above the core (m).
    fn least_height(
        &self,
        polytope: &Polytope,
        side: &Placed<'_>,
        simplex: &[Vector3<f64>],
    ) -> f64 {
        let (middle, reach) = around(simplex);
        let back = side.orientation.inverse_transform_vector(&(middle - side.place));
        polytope.height(&back) - reach
    }

    /// Contact of a polytope with the region, of which nothing overlaps with it.
    fn beside_polytope(&self, polytope: &Polytope, side: &Placed<'_>) -> Touch {
        let rounding = self.part.rounding;
        let (nearest, _) = self.find(|face, most| {
            let simplex = self.simplex(face);
            if self.least_height(polytope, side, simplex) - rounding > most {
                return None;
            }
            polytope::foot(polytope, side, rounding, simplex, &face.normal, most)
        });
        // The mean of all corners that are as near.
        let least = nearest.gap + SAME * self.part.radius;
        let feet = polytope.corners.iter().filter_map(|corner| {
            let corner = side.at(corner);
            let low = (corner - nearest.place).dot(&nearest.up) - rounding <= least;
            let foot = |face: &Held, _| {
                let none = Vector3::zeros();
                Some(foot_of_ball(&corner, rounding, self.simplex(face), &none))
            };
            let foot = low.then(|| self.find(foot).0)?;
            (foot.gap <= least).then_some(foot.place)
        });
        let place = mean(feet).unwrap_or(nearest.place);
        self.single(&Foot { place, ..nearest })
    }

    /// Adds a corner of a polytope as a ball of its rounding, from its place when the faces were
    /// found (m) to that now (m): by its depth below a face that it was in front of, and by its
    /// distance from one behind which it lay already, outside the solid: the far side of a tip.
    fn add_corner(
        &self,
        near: &Flags,
        before: &Vector3<f64>,
        corner: &Vector3<f64>,
        patch: &mut Patch,
    ) {
        let radius = self.part.rounding;
        let above = |face: &Held, at: &Vector3<f64>| (at - face.corners[0]).dot(&face.normal);
        let none = Vector3::zeros();
        let mut overlapping = Flags::none();
        for (k, face) in self.near().filter(|(k, _)| near.may(*k as u32)) {
            // Beyond the plane of a face it touches none of it.
            let height = above(face, corner);
            if height >= radius {
                continue;
            }
            let behind = height < 0.0 && above(face, before) < 0.0;
            let normal = if behind { &none } else { &face.normal };
            let foot = foot_of_ball(corner, radius, self.simplex(face), normal);
            if foot.gap < 0.0 {
                add(patch, Some(foot), 1.0);
                overlapping.add(k);
            }
        }
        if overlapping.count > 0 {
            self.add_edges(&overlapping, patch, |simplex| {
                Some(foot_of_ball(corner, radius, simplex, &none))
            });
        }
    }

    /// Adds sharp corners of the surface with the polytope, and its edges with sharp edges, where
    /// their faces are near.
    fn add_sharp(&self, near: &Flags, polytope: &Polytope, side: &Placed<'_>, patch: &mut Patch) {
        let rounding = self.part.rounding;
        let is_near = |faces: &[u32; 2]| faces.iter().all(|k| near.may(*k));
        for corner in self.region.corners.iter().filter(|c| c.sharp && is_near(&c.faces)) {
            let place = [self.mesh.corner(corner.corners)];
            if self.least_height(polytope, side, &place) < rounding {
                add(patch, self.foot_of(&place, &Vector3::zeros(), 0.0), 1.0);
            }
        }
        for edge in self.region.edges.iter().filter(|e| e.sharp && is_near(&e.faces)) {
            let other = edge.corners.map(|k| self.mesh.corner(k));
            if self.least_height(polytope, side, &other) >= rounding {
                continue;
            }
            for own in &polytope.edges {
                let ends = own.corners.map(|k| side.at(&polytope.corners[k as usize]));
                let Some(Crossing { points: [x, y], counts }) = crossing(&ends, &other, rounding)
                else {
                    continue;
                };
                let way = y - x;
                let distance = way.norm();
                if distance > 0.0 && distance < rounding {
                    patch.add(rounding - distance, &(way / distance), &y, counts);
                }
            }
        }
    }
}

/// Adds the depth of a foot, if there is one, that counts so many times.
fn add(patch: &mut Patch, foot: Option<Foot>, counts: f64) {
    if let Some(foot) = foot {
        patch.add(-foot.gap, &-foot.up, &foot.place, counts);
    }
}
