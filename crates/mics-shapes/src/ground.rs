//! How a convex part touches a region of the surface of an obstacle ([`crate::region`]).
//!
//! ```text
//!   ball, smooth part   D by Euler's sum, p as the law's potential, which then is the sum of what
//!                       each of several nearest points would have
//!   polytope            p = 8 as of two polytopes: its corners, as balls of its rounding, with the
//!                       faces (each by Euler's sum), sharp corners of the surface with it, and its
//!                       edges with sharp edges
//! ```

use crate::mesh::Mesh;
use crate::part::{Core, Part, Polytope};
use crate::placed::{Placed, Pose};
use crate::region::{Foot, Held, Region, foot, foot_of_ball};
use crate::touch::{PARALLEL, POWER, Patch, SAME, Touch, mean, nearest_of, radius};
use nalgebra::Vector3;

/// Local radii of curvature of a part where the surface lies along `normal`, and of that (m).
fn radii(part: &Part, pose: &Pose, normal: &Vector3<f64>) -> [f64; 2] {
    [radius(part, &Placed::new(part, pose), normal), f64::INFINITY]
}

/// The contact at one point.
fn single(foot: &Foot, part: &Part, pose: &Pose) -> Touch {
    let normal = -foot.up;
    let radii = radii(part, pose, &normal);
    Touch { normal, overlap: -foot.gap, gain: 1.0, place: foot.place, spread: 0.0, radii }
}

/// The contact of a patch, where it touches.
fn whole(patch: &Patch, part: &Part, pose: &Pose) -> Option<Touch> {
    patch.is_touched().then(|| patch.whole(radii(part, pose, &patch.direction())))
}

impl Mesh {
    /// How a part of a body in this pose touches a region, in the axes of the surface: the place is
    /// on the surface. `power` is p for parts that are no polytopes.
    pub fn touch(&self, region: &Region, part: &Part, pose: &Pose, power: f64) -> Touch {
        if let Core::Polytope(polytope) = &part.core {
            return self.touch_polytope(region, part, pose, polytope);
        }
        let (nearest, touching) = self.nearest_face(region, part, pose);
        if touching < 2 {
            return single(&nearest, part, pose);
        }
        let mut patch = Patch::about(part.rounding, nearest.place, power);
        self.add_signed(region, &mut patch, |simplex, normal| foot(part, pose, simplex, normal));
        whole(&patch, part, pose).unwrap_or_else(|| single(&nearest, part, pose))
    }

    /// The same of a polytope.
    fn touch_polytope(
        &self,
        region: &Region,
        part: &Part,
        pose: &Pose,
        polytope: &Polytope,
    ) -> Touch {
        let side = Placed::new(part, pose);
        let mut patch = Patch::about(part.rounding, side.place, f64::from(POWER));
        self.add_polytope(region, (part, pose, polytope), &side, &mut patch);
        if let Some(touch) = whole(&patch, part, pose) {
            return touch;
        }
        let nearest = self.nearest_face(region, part, pose).0;
        let feet = polytope.corners.iter().filter_map(|corner| {
            let ball = Part::ball(Vector3::zeros(), part.rounding);
            let pose = Pose { place: side.at(corner), ..*pose };
            let foot = self.nearest_face(region, &ball, &pose).0;
            (foot.gap <= nearest.gap + SAME * part.radius).then_some(foot.place)
        });
        let place = mean(feet).unwrap_or(nearest.place);
        single(&Foot { place, ..nearest }, part, pose)
    }

    /// The foot of the nearest face of a region, and how many overlap with the part.
    fn nearest_face(&self, region: &Region, part: &Part, pose: &Pose) -> (Foot, usize) {
        let (mut best, mut touching) =
            (Foot { gap: f64::INFINITY, up: Vector3::x(), place: pose.place }, 0);
        let ball = matches!(part.core, Core::Point);
        let middle = pose.place + pose.orientation * part.place;
        for face in &region.faces {
            let corners = &face.corners[..self.dimension()];
            let foot = if ball {
                foot_of_ball(&middle, part.rounding, corners, &face.normal)
            } else {
                foot(part, pose, corners, &face.normal)
            };
            touching += usize::from(foot.gap < 0.0);
            if foot.gap < best.gap {
                best = foot;
            }
        }
        (best, touching)
    }

    /// Adds the depths of faces, edges and corners by the signs of Euler's sum.
    fn add_signed(
        &self,
        region: &Region,
        patch: &mut Patch,
        foot: impl Fn(&[Vector3<f64>], &Vector3<f64>) -> Foot,
    ) {
        let mut add = |simplex: &[Vector3<f64>], normal: &Vector3<f64>, counts: f64| {
            let foot = foot(simplex, normal);
            patch.add(-foot.gap, &-foot.up, &foot.place, counts);
        };
        let none = Vector3::zeros();
        for face in &region.faces {
            add(&face.corners[..self.dimension()], &face.normal, 1.0);
        }
        for (ends, counts) in &region.edges {
            add(&ends.map(|k| self.corner(k)), &none, *counts);
        }
        for (corner, counts) in &region.corners {
            add(&[self.corner(*corner)], &none, *counts);
        }
    }

    /// Adds all pairs of features of a polytope and a region.
    fn add_polytope(
        &self,
        region: &Region,
        (part, pose, polytope): (&Part, &Pose, &Polytope),
        side: &Placed<'_>,
        patch: &mut Patch,
    ) {
        for corner in polytope.corners.iter().map(|corner| side.at(corner)) {
            // Beyond the plane of every face it touches none.
            let near = |face: &Held| (corner - face.corners[0]).dot(&face.normal) < part.rounding;
            if region.faces.iter().any(near) {
                self.add_signed(region, patch, |simplex, normal| {
                    foot_of_ball(&corner, part.rounding, simplex, normal)
                });
            }
        }
        for corner in &region.sharp_corners {
            let foot = foot(part, pose, &[self.corner(*corner)], &Vector3::zeros());
            patch.add(-foot.gap, &-foot.up, &foot.place, 1.0);
        }
        for sharp in &region.sharp_edges {
            let other = sharp.map(|k| self.corner(k));
            self.add_edges(polytope, part.rounding, side, &other, patch);
        }
    }

    /// Adds the nearest points of the edges of a polytope and of a sharp edge.
    fn add_edges(
        &self,
        polytope: &Polytope,
        rounding: f64,
        side: &Placed<'_>,
        other: &[Vector3<f64>; 2],
        patch: &mut Patch,
    ) {
        for face in &polytope.faces {
            let n = face.corners.len();
            for k in 0..n {
                let [from, to] = [face.corners[k], face.corners[(k + 1) % n]];
                // Every edge is one of two faces, once each way.
                if from > to {
                    continue;
                }
                let own = [from, to].map(|k| side.at(&polytope.corners[k as usize]));
                let (e, f) = (own[1] - own[0], other[1] - other[0]);
                let sine = e.cross(&f).norm_squared() / (e.norm_squared() * f.norm_squared());
                let counts = sine / (sine + PARALLEL * PARALLEL);
                if counts > 0.01 {
                    let [x, y] = nearest_of(&own, other);
                    let way = y - x;
                    let distance = way.norm();
                    if distance > 0.0 && distance < rounding {
                        patch.add(rounding - distance, &(way / distance), &y, counts);
                    }
                }
            }
        }
    }
}
