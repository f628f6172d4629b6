//! A convex polyhedron: the hull of a closed surface, of which the edges may be rounded.
//!
//! ```text
//!      .---------.        the core is the hull with its faces moved in by the rounding r, and the
//!     ( +-------+ )       body all that is within r of it: what a ball of the radius r sweeps that
//!     | |  core | |       moves within the hull. The faces stay where they are. A face that such a
//!     ( +-------+ )       ball does not reach is rounded off.
//!      '---------'
//! ```
//! Distances are exact. Boxes see a rounded one as a polyhedron with flat facets along its edges
//! and corners, 22 degrees apart, whose volume is exact: Steiner's
//! `V + A r + sum of l phi r^2/2 + 4/3 pi r^3`, with l the length of an edge of the core and phi
//! the angle between its faces' normals.

use super::polygon::SKIN;
use crate::boxes::convex::{self, Convex};
use crate::surface::facets::{Facet, Facets};
use crate::surface::stl;
use crate::{Core, Face, Fault, Lattice, Nearest, Part, Polytope, Shape, SurfacePoint, Tile};
use nalgebra::{Matrix3, Vector3};
use parry3d_f64::math::Vector as Place;
use parry3d_f64::transformation::try_convex_hull;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Angle between the facets of a rounded edge (rad).
const STEP: f64 = PI / 8.0;

/// A plane: its normal and offset (m).
type Plane = (Vector3<f64>, f64);

/// A convex polyhedron (3D).
#[derive(Clone, Debug)]
pub struct Polyhedron {
    /// The solid that boxes see, and the core of a rounded one, which distances are from.
    solid: Facets,
    core: Option<Facets>,
    rounding: f64,
    volume: f64,
    inertia: Matrix3<f64>,
    hull_excess: f64,
    parts: [Part; 1],
}

impl Polyhedron {
    /// The convex hull of a closed surface (m), with edges rounded to this radius (m); it is moved
    /// so that its centre of volume is the origin.
    ///
    /// # Errors
    ///
    /// A corner is no place, the hull is flat or has more than 60,000 faces, or the rounding leaves
    /// nothing.
    pub fn new(triangles: &[[Vector3<f64>; 3]], rounding: f64) -> Result<Polyhedron, Fault> {
        if !(rounding.is_finite() && rounding >= 0.0) {
            return Err(Fault(format!("the rounding {rounding} m is no length")));
        }
        let planes = hull(triangles)?;
        let Some(mut whole) = between(&planes, 0.0) else {
            return Err(Fault("the hull of the surface holds no volume".to_owned()));
        };
        let (volume, first) = whole.moments();
        let mesh = stl::volume(triangles).abs();
        let hull_excess = if mesh > 0.0 { volume / mesh - 1.0 } else { f64::INFINITY };
        let shift = -first / volume;
        whole.shift(&shift);
        let planes = moved(&planes, &shift);
        if rounding == 0.0 {
            return Ok(Polyhedron::sharp(&whole, &planes, hull_excess));
        }
        let nothing = || {
            let why = format!("the rounding {rounding} m is as large as the hull's inner radius");
            Fault(why)
        };
        let core = between(&planes, rounding).ok_or_else(nothing)?;
        Ok(Polyhedron::rounded(&core, rounding, hull_excess))
    }

    fn sharp(whole: &Convex, planes: &[Plane], hull_excess: f64) -> Polyhedron {
        let solid = Facets::new(whole);
        let skin = SKIN * solid.depth();
        let core = between(planes, skin).map_or_else(|| solid.clone(), |core| Facets::new(&core));
        Polyhedron {
            rounding: 0.0,
            volume: whole.moments().0,
            inertia: convex::inertia(&whole.second_moments()),
            hull_excess,
            parts: [part(&core, skin)],
            core: None,
            solid,
        }
    }

    fn rounded(core: &Convex, rounding: f64, hull_excess: f64) -> Polyhedron {
        let facets = Facets::new(core);
        let volume = steiner(core, &facets, rounding);
        let mut whole = bevelled(&facets, rounding, volume);
        // The core goes along as the rounded body is moved to its own centre.
        let shift = -whole.moments().1 / whole.moments().0;
        whole.shift(&shift);
        let mut core = core.clone();
        core.shift(&shift);
        let core = Facets::new(&core);
        Polyhedron {
            solid: Facets::new(&whole),
            rounding,
            volume,
            inertia: convex::inertia(&whole.second_moments()),
            hull_excess,
            parts: [part(&core, rounding)],
            core: Some(core),
        }
    }

    /// The part by which the hull is larger than the surface that it is the hull of.
    pub fn hull_excess(&self) -> f64 {
        self.hull_excess
    }

    /// Number of its faces, the coplanar ones as one and without those of rounded edges.
    pub fn face_count(&self) -> usize {
        self.core.as_ref().unwrap_or(&self.solid).faces().len()
    }
}

/// The part that contacts see, about this core.
fn part(core: &Facets, rounding: f64) -> Part {
    let face = |face: &Facet| Face { normal: face.normal, corners: core.round(face).collect() };
    let polytope = Polytope::new(core.corners().to_vec(), core.faces().iter().map(face).collect());
    Part {
        place: Vector3::zeros(),
        core: Core::Polytope(polytope),
        rounding,
        radius: core.radius() + rounding,
    }
}

/// The planes of the hull of a surface, coplanar triangles once.
fn hull(triangles: &[[Vector3<f64>; 3]]) -> Result<Vec<Plane>, Fault> {
    for (k, corners) in triangles.iter().enumerate() {
        if !corners.iter().flatten().all(|x| x.is_finite()) {
            return Err(Fault(format!("triangle {} has a corner that is no place", k + 1)));
        }
    }
    let mut all: Vec<[f64; 3]> = triangles.iter().flatten().map(|x| (*x).into()).collect();
    all.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
    all.dedup();
    let middle =
        all.iter().map(|x| Vector3::from(*x)).sum::<Vector3<f64>>() / all.len().max(1) as f64;
    let size = all.iter().map(|x| (Vector3::from(*x) - middle).norm()).fold(0.0, f64::max);
    let scaled: Vec<Place> = all
        .iter()
        .map(|x| (Vector3::from(*x) - middle) / size)
        .map(|x| Place::new(x.x, x.y, x.z))
        .collect();
    let flat = || Fault("the surface is flat: its hull holds no volume".to_owned());
    if all.len() < 4 || size <= 0.0 {
        return Err(flat());
    }
    let (points, faces) = try_convex_hull(&scaled).map_err(|_| flat())?;
    let mut planes: Vec<Plane> = Vec::new();
    for face in faces {
        let [a, b, c] = face.map(|k| {
            let p = points[k as usize];
            Vector3::new(p.x, p.y, p.z)
        });
        let normal = (b - a).cross(&(c - a));
        if normal.norm() < 1e-12 {
            continue;
        }
        let normal = normal.normalize();
        let offset = normal.dot(&a);
        let same =
            |(n, at): &&mut Plane| n.dot(&normal) > 1.0 - 2e-10 && (*at - offset).abs() < 1e-6;
        match planes.iter_mut().find(same) {
            Some((_, at)) => *at = at.max(offset),
            None => planes.push((normal, offset)),
        }
    }
    if planes.len() > 60_000 {
        let why = format!("the hull has {} faces; 60,000 are the most", planes.len());
        return Err(Fault(why));
    }
    let width = |(n, at): &Plane| {
        at - scaled.iter().map(|x| n.x * x.x + n.y * x.y + n.z * x.z).fold(f64::INFINITY, f64::min)
    };
    if planes.len() < 4 || planes.iter().map(width).fold(f64::INFINITY, f64::min) < 1e-6 {
        return Err(flat());
    }
    Ok(planes.iter().map(|(n, at)| (*n, n.dot(&middle) + size * at)).collect())
}

fn moved(planes: &[Plane], shift: &Vector3<f64>) -> Vec<Plane> {
    planes.iter().map(|(n, at)| (*n, at + n.dot(shift))).collect()
}

/// The polyhedron below all of these planes, moved in by a way (m); none where it is empty.
fn between(planes: &[Plane], way: f64) -> Option<Convex> {
    let size = planes.iter().map(|(_, at)| at.abs()).fold(0.0, f64::max);
    let mut body = Convex::with_capacity(2 * planes.len() + 8);
    let far = [0, 1, 2].map(|a| Vector3::ith(a, 64.0 * size));
    body.set_box(&Vector3::zeros(), &far);
    for (n, at) in planes {
        body.cut(n, at - way);
    }
    let (volume, _) = body.moments();
    (volume > 1e-12 * size.powi(3)).then_some(body)
}

/// The edges of a polyhedron: the corners at its ends and the normals of its faces.
fn edges(core: &Facets) -> BTreeMap<(u32, u32), Vec<Vector3<f64>>> {
    let mut edges: BTreeMap<(u32, u32), Vec<Vector3<f64>>> = BTreeMap::new();
    for face in core.faces() {
        let round: Vec<u32> = core.round(face).collect();
        for (k, from) in round.iter().enumerate() {
            let to = round[(k + 1) % round.len()];
            edges.entry((*from.min(&to), *from.max(&to))).or_default().push(face.normal);
        }
    }
    edges
}

fn angle(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    a.cross(b).norm().atan2(a.dot(b))
}

/// Volume of all that is within r (m) of a core (m3).
fn steiner(core: &Convex, facets: &Facets, r: f64) -> f64 {
    let area: f64 = facets.patches(f64::INFINITY).iter().map(|patch| patch.area).sum();
    let bent: f64 = edges(facets)
        .iter()
        .filter_map(|((from, to), normals)| {
            let [from, to] = [from, to].map(|k| facets.corners()[*k as usize]);
            let [a, b] = normals.as_slice() else { return None };
            Some((to - from).norm() * angle(a, b))
        })
        .sum();
    core.moments().0 + area * r + 0.5 * bent * r * r + 4.0 / 3.0 * PI * r.powi(3)
}

/// The core with facets around it: over its faces at the distance r (m), and over its edges and
/// corners a little further, so that the volume (m3) is the one given.
fn bevelled(core: &Facets, r: f64, volume: f64) -> Convex {
    let flat: Vec<Plane> = core.faces().iter().map(|face| (face.normal, face.offset + r)).collect();
    let mut bent: Vec<Plane> = Vec::new();
    let mut around: BTreeMap<u32, Vec<Vector3<f64>>> = BTreeMap::new();
    for ((from, to), normals) in edges(core) {
        let [a, b] = normals.as_slice() else { continue };
        let angle = angle(a, b);
        let at = core.corners()[from as usize];
        let count = (angle / STEP).ceil() as usize;
        let all = (0..=count).map(|k| {
            let part = angle * k as f64 / count.max(1) as f64;
            (((angle - part).sin() * a + part.sin() * b) / angle.sin()).normalize()
        });
        let all: Vec<Vector3<f64>> = if angle > 1e-6 { all.collect() } else { vec![*a, *b] };
        bent.extend(all[1..all.len() - 1].iter().map(|n| (*n, n.dot(&at))));
        for corner in [from, to] {
            around.entry(corner).or_default().extend(&all);
        }
    }
    for (corner, normals) in around {
        let at = core.corners()[corner as usize];
        let middle = normals.iter().sum::<Vector3<f64>>().normalize();
        let widest = normals.iter().map(|n| angle(n, &middle)).fold(0.0, f64::max);
        let rings = (widest / STEP).ceil() as usize;
        for ring in 1..rings {
            let t = ring as f64 / rings as f64;
            // Further in there are fewer.
            let every = (rings / ring).max(1);
            let inner = normals.iter().step_by(every);
            bent.extend(
                inner.map(|n| (t * n + (1.0 - t) * middle).normalize()).map(|n| (n, n.dot(&at))),
            );
        }
        if rings > 1 {
            bent.push((middle, middle.dot(&at)));
        }
    }
    let body = |out: f64| {
        let bent = bent.iter().map(|(n, at)| (*n, at + out));
        let planes: Vec<Plane> = flat.iter().copied().chain(bent).collect();
        between(&planes, 0.0).unwrap_or_default()
    };
    // The volume grows nearly evenly with the way of the facets.
    let mut low = 0.98 * r;
    let mut high = r;
    let mut ends = [low, high].map(|out| body(out).moments().0 - volume);
    for _ in 0..8 {
        if ends[1].abs() < 1e-13 * volume || ends[0] == ends[1] {
            break;
        }
        let next = high - ends[1] * (high - low) / (ends[1] - ends[0]);
        low = high;
        high = next.clamp(0.9 * r, 1.1 * r);
        ends = [ends[1], body(high).moments().0 - volume];
    }
    let mut whole = body(high);
    // A nearly smooth body has no facets but its faces: they are scaled to its volume.
    whole.scale((volume / whole.moments().0).cbrt());
    whole
}

impl Shape for Polyhedron {
    fn dimension(&self) -> usize {
        3
    }

    fn radius(&self) -> f64 {
        self.core.as_ref().map_or(self.solid.radius(), |core| core.radius() + self.rounding)
    }

    fn volume(&self) -> f64 {
        self.volume
    }

    fn inertia(&self) -> Matrix3<f64> {
        self.inertia
    }

    fn thickness(&self) -> f64 {
        let core = |core: &Facets| core.thickness() + 2.0 * self.rounding;
        self.core.as_ref().map_or_else(|| self.solid.thickness(), core)
    }

    fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        let found = self.core.as_ref().unwrap_or(&self.solid).nearest(point);
        Nearest { distance: found.distance - self.rounding, ..found }
    }

    fn feet(&self, point: &Vector3<f64>, within: f64, feet: &mut Vec<Nearest>) {
        let facets = self.core.as_ref().unwrap_or(&self.solid);
        facets.feet(point, within - self.rounding, feet);
        feet.iter_mut().for_each(|foot| foot.distance -= self.rounding);
    }

    /// None of a rounded one, which boxes see otherwise than distances.
    fn plane(&self, point: &Vector3<f64>) -> Option<Nearest> {
        self.core.is_none().then(|| self.solid.plane(point))
    }

    fn surface(&self, spacing: f64) -> Vec<SurfacePoint> {
        let mut all = self.solid.patches(spacing);
        if self.core.is_some() {
            for patch in &mut all {
                let Nearest { distance, normal } = self.nearest(&patch.place);
                patch.place -= distance * normal;
                patch.normal = normal;
            }
        }
        all
    }

    fn extent(&self, n: &Vector3<f64>) -> f64 {
        self.core
            .as_ref()
            .map_or_else(|| self.solid.extent(n), |core| core.extent(n) + self.rounding)
    }

    /// Exact without rounding; see the top.
    fn tile(&self, lattice: &Lattice, found: &mut dyn FnMut(&Tile)) {
        self.solid.tile(lattice, found);
    }

    fn parts(&self) -> &[Part] {
        &self.parts
    }

    fn triangles(&self, _: f64) -> Vec<[Vector3<f64>; 3]> {
        self.solid.triangles()
    }
}

#[cfg(test)]
mod tests;
