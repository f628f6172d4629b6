//! A convex polyhedron: the hull of a closed surface, of which the edges may be rounded.
//!
//! ```text
//!      .---------.        the core is the hull with its faces moved in by the rounding r, and the
//!     ( +-------+ )       body all that is within r of it: what a ball of the radius r sweeps that
//!     | |  core | |       moves within the hull. The faces stay where they are. A face that such a
//!     ( +-------+ )       ball does not reach is rounded off.
//!      '---------'
//! ```
//! Distances are exact. What a rounded one fills of boxes is that of a polyhedron with flat facets
//! along its edges and corners, 22 degrees apart, whose volume is exact: Steiner's
//! `V + A r + sum of l phi r^2/2 + 4/3 pi r^3`, with l the length of an edge of the core and phi
//! the angle between its faces' normals.

use super::convex::{self, Convex};
use super::facets::{Facet, Facets};
use super::polygon::SKIN;
use super::{Core, Face, Fault, Geometry, Nearest, Part, Patch, Polytope, stl};
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
    /// What boxes see, and what distances are from: the same where nothing is rounded.
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

    /// How many faces it has, the coplanar ones as one and without those of rounded edges.
    pub fn face_count(&self) -> usize {
        self.core.as_ref().unwrap_or(&self.solid).faces().len()
    }
}

/// The part that contacts see, about this core.
fn part(core: &Facets, rounding: f64) -> Part {
    let face = |face: &Facet| Face { normal: face.normal, corners: core.round(face).collect() };
    let polytope = Polytope {
        corners: core.corners().to_vec(),
        faces: core.faces().iter().map(face).collect(),
    };
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
    if all.len() < 4 || !(size > 0.0) {
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

/// What lies below all of these planes, moved in by a way (m); none where nothing does.
fn between(planes: &[Plane], way: f64) -> Option<Convex> {
    let size = planes.iter().map(|(_, at)| at.abs()).fold(0.0, f64::max);
    let mut body = Convex::with_capacity(2 * planes.len() + 8);
    let far = [0, 1, 2].map(|a| Vector3::ith(a, 64.0 * size));
    body.set_box(&Vector3::zeros(), &far);
    for (n, at) in planes {
        body.cut(n, at - way, 0.0);
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
        let (angle, at) = (angle(a, b), core.corners()[from as usize]);
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
    let (mut low, mut high) = (0.98 * r, r);
    let mut ends = [low, high].map(|out| body(out).moments().0 - volume);
    for _ in 0..8 {
        if ends[1].abs() < 1e-13 * volume || ends[0] == ends[1] {
            break;
        }
        let next = high - ends[1] * (high - low) / (ends[1] - ends[0]);
        (low, high) = (high, next.clamp(0.9 * r, 1.1 * r));
        ends = [ends[1], body(high).moments().0 - volume];
    }
    let mut whole = body(high);
    // Of a nearly smooth body the faces alone are the facets.
    whole.scale((volume / whole.moments().0).cbrt());
    whole
}

impl Geometry for Polyhedron {
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
        let (distance, normal, _) = self.core.as_ref().unwrap_or(&self.solid).nearest(point);
        Nearest { distance: distance - self.rounding, normal }
    }

    fn surface(&self, spacing: f64) -> Vec<Patch> {
        let mut all = self.solid.patches(spacing);
        if self.core.is_some() {
            for patch in &mut all {
                let Nearest { distance, normal } = self.nearest(&patch.place);
                (patch.place, patch.normal) = (patch.place - distance * normal, normal);
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
    fn filled(&self, middle: &Vector3<f64>, half: &[Vector3<f64>; 3]) -> (f64, Vector3<f64>) {
        self.solid.filled(middle, half)
    }

    fn parts(&self) -> &[Part] {
        &self.parts
    }

    fn triangles(&self, _: f64) -> Vec<[Vector3<f64>; 3]> {
        self.solid.triangles()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::patches;
    use crate::scatter::{feet, lattice, scatter};
    use nalgebra::Rotation3;

    /// A box turned by a vector (rad).
    fn cuboid(half: Vector3<f64>, turn: Vector3<f64>) -> Vec<[Vector3<f64>; 3]> {
        let mut body = Convex::default();
        body.set_box(&Vector3::new(3.0, 1.0, -2.0), &[0, 1, 2].map(|a| Vector3::ith(a, half[a])));
        let turn = Rotation3::from_scaled_axis(turn);
        Facets::new(&{
            body.shift(&Vector3::new(-3.0, -1.0, 2.0));
            body
        })
        .triangles()
        .into_iter()
        .map(|corners| corners.map(|x| turn * x + Vector3::new(3.0, 1.0, -2.0)))
        .collect()
    }

    /// A stone: points on an ellipsoid.
    fn stone(points: usize) -> Vec<[Vector3<f64>; 3]> {
        let at = |k: usize| {
            let n = Vector3::from_fn(|a, _| scatter(3 * k + a)).normalize();
            n.component_mul(&Vector3::new(1.0, 0.8, 0.6))
        };
        // The hull is all that counts.
        (0..points / 3).map(|k| [at(3 * k), at(3 * k + 1), at(3 * k + 2)]).collect()
    }

    #[test]
    fn cube_and_its_rounding_have_exact_volumes() {
        for turn in [Vector3::zeros(), Vector3::new(0.3, 1.0, -0.4)] {
            let mesh = cuboid(Vector3::new(0.5, 0.4, 0.3), turn);
            let body = Polyhedron::new(&mesh, 0.0).unwrap();
            assert!((body.volume / 0.48 - 1.0).abs() < 1e-12 && body.hull_excess.abs() < 1e-12);
            assert_eq!((body.face_count(), body.solid.corners().len()), (6, 8));
            let own = Rotation3::from_scaled_axis(turn).inverse();
            let inertia = own * body.inertia * own.transpose();
            let exact = 0.04 * Vector3::new(1.0, 1.36, 1.64);
            assert!((inertia - Matrix3::from_diagonal(&exact)).norm() < 1e-12, "{inertia}");
            assert!((body.thickness() - 0.6).abs() < 1e-12);
            let r = 0.1;
            let round = Polyhedron::new(&mesh, r).unwrap();
            let [a, b, c] = [0.8, 0.6, 0.4];
            let exact = a * b * c
                + 2.0 * (a * b + b * c + c * a) * r
                + PI * r * r * (a + b + c)
                + 4.0 / 3.0 * PI * r.powi(3);
            assert!((round.volume / exact - 1.0).abs() < 1e-12, "{} {exact}", round.volume);
            // About x: core, slabs, quarter rods and eighths of a ball.
            let n = own.inverse() * Vector3::x();
            let (found, exact) = (n.dot(&(round.inertia * n)), rounded_inertia([a, b, c], r));
            println!("inertia of the rounded one: {:.1e} off", found / exact - 1.0);
            assert!((found / exact - 1.0).abs() < 1e-4, "{found} {exact}");
        }
    }

    /// About x of a box of these edges within r.
    fn rounded_inertia([a, b, c]: [f64; 3], r: f64) -> f64 {
        let block = |a: f64, b: f64, c: f64| a * b * c * (b * b + c * c) / 12.0;
        let core = block(a + 2.0 * r, b, c);
        let slab = |b: f64, c: f64| {
            2.0 * (a * b * r * (b * b + r * r) / 12.0 + a * b * r * (0.5 * (c + r)).powi(2))
        };
        let quarter = PI * r * r / 4.0;
        let (centre, own) = (4.0 * r / (3.0 * PI), PI * r.powi(4) / 16.0);
        let square = |b: f64| own + quarter * (b * centre + 0.25 * b * b);
        let rods = 4.0 * a * (square(b) + square(c));
        // Rods along y, and along z.
        let along = |b: f64, c: f64| 4.0 * (b.powi(3) / 12.0 * quarter + b * square(c));
        let eighth = PI * r.powi(3) / 6.0;
        let ball = |b: f64| r.powi(5) * PI / 30.0 + eighth * (b * 0.375 * r + 0.25 * b * b);
        core + slab(b, c)
            + slab(c, b)
            + rods
            + along(b, c)
            + along(c, b)
            + 8.0 * (ball(b) + ball(c))
    }

    #[test]
    fn boxes_of_a_turned_lattice_sum_to_the_polyhedron() {
        let cube = cuboid(Vector3::new(0.5, 0.4, 0.3), Vector3::new(0.3, 1.0, -0.4));
        for (name, mesh) in [("cube", &cube), ("stone", &stone(102))] {
            for rounding in [0.0, 0.05] {
                let body = Polyhedron::new(mesh, rounding).unwrap();
                let (volume, first) = lattice(&body);
                let feet = feet(&body, 1.5);
                let faces = body.face_count();
                println!(
                    "{name} of {faces} faces, rounding {rounding}: {volume:.1e}, {first:.1e}, feet {feet:.1e}"
                );
                assert!(volume < 1e-12 && first < 1e-12 && feet < 1e-12);
                let middle: Vector3<f64> =
                    body.surface(0.05).iter().map(|p| p.area * p.normal).sum();
                assert!(rounding > 0.0 || middle.norm() < 1e-12, "{middle}");
                let [part] = body.parts() else { panic!() };
                for (n, _) in patches::directions(3) {
                    let below = body.extent(&n) - part.core.support(&n).dot(&n) - part.rounding;
                    assert!((-1e-12..0.05).contains(&below), "{below}");
                }
            }
        }
    }

    /// Of a point anywhere the grid finds what a loop over all faces does.
    #[test]
    fn nearest_face_by_the_grid_is_the_nearest_of_all() {
        let body = Polyhedron::new(&stone(102), 0.0).unwrap().solid;
        for k in 0..5000 {
            let point = 1.3 * Vector3::from_fn(|a, _| scatter(3 * k + a));
            let (distance, _, _) = body.nearest(&point);
            let triangles = body.triangles();
            let above = body.faces().iter().map(|face| face.normal.dot(&point) - face.offset);
            let above = above.fold(f64::NEG_INFINITY, f64::max);
            if above <= 0.0 {
                assert!((distance - above).abs() < 1e-14);
                continue;
            }
            // By parry's triangles.
            use parry3d_f64::query::PointQuery;
            let place = |x: &Vector3<f64>| Place::new(x.x, x.y, x.z);
            let own = triangles.iter().map(|[a, b, c]| {
                let triangle = parry3d_f64::shape::Triangle::new(place(a), place(b), place(c));
                triangle.distance_to_local_point(place(&point), true)
            });
            let least = own.fold(f64::INFINITY, f64::min);
            assert!((distance - least).abs() < 1e-12, "{point}: {distance} {least}");
        }
    }

    #[test]
    fn sphere_of_triangles_is_nearly_a_sphere() {
        let mesh: Vec<_> = patches::triangles(10).collect();
        let body = Polyhedron::new(&mesh, 0.0).unwrap();
        let (volume, exact) = (body.volume(), 4.0 / 3.0 * PI);
        println!("{} faces: volume {:.4} of the sphere", body.face_count(), volume / exact);
        let sphere = 0.4 * volume * (volume / exact).powf(2.0 / 3.0);
        assert!((body.inertia() - sphere * Matrix3::identity()).norm() < 1e-3 * sphere);
    }

    #[test]
    fn faults_of_polyhedra_say_what_is_wrong() {
        let fault = |mesh: &[[Vector3<f64>; 3]], r| Polyhedron::new(mesh, r).unwrap_err().0;
        let flat = [[Vector3::x(), Vector3::y(), Vector3::zeros()]];
        assert!(fault(&flat, 0.0).contains("flat"));
        assert!(fault(&[], 0.0).contains("flat"));
        assert!(fault(&[[f64::NAN * Vector3::x(); 3]], 0.0).contains("triangle 1"));
        let cube = cuboid(Vector3::repeat(0.5), Vector3::zeros());
        assert!(fault(&cube, 0.6).contains("rounding"));
        // Of a cube with a dent the hull is the cube.
        let mut dented = cube;
        let corner = dented[0];
        let middle = Vector3::new(3.0, 1.0, -2.0);
        dented[0] = [corner[0], corner[1], middle];
        dented.push([corner[1], corner[2], middle]);
        dented.push([corner[2], corner[0], middle]);
        let body = Polyhedron::new(&dented, 0.0).unwrap();
        assert!((body.hull_excess() - 1.0 / 11.0).abs() < 1e-12, "{}", body.hull_excess());
    }
}
