//! The union of closed surfaces, by libraries whose answers are exact: faces that lie on each
//! other, edges that touch and surfaces that cross themselves are no special case for them.

use super::Face;
use crate::Fault;
use i_overlay::core::fill_rule::FillRule;
use i_overlay::float::simplify::SimplifyShape;
use manifold_rust::manifold::Manifold;
use manifold_rust::types::{Error, MeshGL64, WindingRule};
use nalgebra::Vector3;
use std::collections::HashMap;

/// Lattice (of the size of all) on which corners are put: images across a period are the same on
/// both sides but for rounding, and no sliver is left between them.
const LATTICE: f64 = 1.0 / (1u64 << 36) as f64;

/// Distance (of the size of all) within which a corner of the union is one of those given.
const SAME: f64 = 4.0 * LATTICE;

/// The surface of what faces enclose, each with the number of those whose part it is.
///
/// # Errors
/// When the faces do not close.
pub fn union(dimension: usize, faces: &[(Face, u32)]) -> Result<Vec<(Face, u32)>, Fault> {
    let corners = || faces.iter().flat_map(|(face, _)| face);
    let cell = LATTICE * corners().map(|x| x.amax()).fold(0.0, f64::max);
    let on_lattice = |x: Vector3<f64>| x.map(|x| (x / cell).round() * cell);
    // Corners that are left are those given.
    let key = |x: &Vector3<f64>| <[i64; 3]>::from(x.map(|x| (x / cell).round() as i64));
    let given: HashMap<_, _> = corners().map(|x| (key(x), *x)).collect();
    let faces: Vec<_> = faces.iter().map(|(face, k)| (face.map(on_lattice), *k)).collect();
    let mut all = if dimension == 2 { outlines(&faces) } else { solids(&faces)? };
    for corner in all.iter_mut().flat_map(|(face, _)| face) {
        *corner = given.get(&key(corner)).copied().unwrap_or(*corner);
    }
    Ok(all)
}

/// Whether a closed surface of triangles crosses or touches itself.
pub fn crosses_itself(faces: &[Face]) -> bool {
    let all: Vec<_> = faces.iter().map(|face| (*face, 0)).collect();
    soup(&all).0.has_self_intersections()
}

/// The surfaces of faces as the library has them, those of a number one after the other, and the
/// number that it has for number 0.
fn soup(faces: &[(Face, u32)]) -> (Manifold, u32) {
    let mut mesh = MeshGL64 { num_prop: 3, ..MeshGL64::default() };
    let mut known = HashMap::new();
    let most = faces.iter().map(|(_, number)| *number).max().unwrap_or(0);
    let first = Manifold::reserve_ids(most + 1);
    for run in faces.chunk_by(|one, other| one.1 == other.1) {
        mesh.run_index.push(mesh.tri_verts.len() as u64);
        mesh.run_original_id.push(first + run[0].1);
        for corner in run.iter().flat_map(|(face, _)| face) {
            let next = known.len() as u64;
            let key = [corner.x, corner.y, corner.z].map(|x| (x + 0.0).to_bits());
            let number = *known.entry(key).or_insert(next);
            if number == next {
                mesh.vert_properties.extend(corner.iter());
            }
            mesh.tri_verts.push(number);
        }
    }
    mesh.run_index.push(mesh.tri_verts.len() as u64);
    (Manifold::from_mesh_gl64_robust(&mesh), first)
}

fn solids(faces: &[(Face, u32)]) -> Result<Vec<(Face, u32)>, Fault> {
    let (soup, first) = soup(faces);
    let whole = soup.rebuild_solid(WindingRule::Positive);
    if whole.status() != Error::NoError {
        return Err(Fault(format!("its surface cannot be used: {:?}", whole.status())));
    }
    let mesh = whole.get_mesh_gl64(-1);
    let mut all = Vec::with_capacity(mesh.num_tri());
    for (run, number) in mesh.run_index.windows(2).zip(&mesh.run_original_id) {
        for t in run[0] / 3..run[1] / 3 {
            let corners = mesh.get_tri_verts(t as usize);
            let face = corners.map(|k| Vector3::from(mesh.get_vert_pos(k as usize)));
            all.push((face, number - first));
        }
    }
    Ok(all)
}

/// Outlines of what segments in the plane z = 0 enclose, the solid on their left.
fn outlines(faces: &[(Face, u32)]) -> Vec<(Face, u32)> {
    let corners: Vec<Vector3<f64>> = faces.iter().map(|(face, _)| face[0]).collect();
    let size = corners.iter().map(|x| x.amax()).fold(0.0, f64::max);
    let same = |x: &Vector3<f64>, y: &Vector3<f64>| (x - y).amax() <= SAME * size;
    let shapes = contours(faces).simplify_shape_as::<i64>(FillRule::Positive);
    let mut all = Vec::new();
    for contour in shapes.iter().flatten() {
        let given = |[x, y]: &[f64; 2]| {
            let x = Vector3::new(*x, *y, 0.0);
            corners.iter().copied().find(|corner| same(corner, &x)).unwrap_or(x)
        };
        let contour: Vec<Vector3<f64>> = contour.iter().map(given).collect();
        for (k, from) in contour.iter().enumerate() {
            let way = contour[(k + 1) % contour.len()] - from;
            // It may be part of several segments, one after the other.
            let along = |x: &Vector3<f64>| (x - from).dot(&way) / way.norm_squared();
            let on_it = |x: &&Vector3<f64>| {
                let t = along(x);
                0.0 < t && t < 1.0 && same(x, &(from + t * way))
            };
            let mut stops: Vec<Vector3<f64>> = corners.iter().filter(on_it).copied().collect();
            stops.push(from + way);
            stops.sort_unstable_by(|x, y| along(x).total_cmp(&along(y)));
            stops.dedup_by(|x, y| same(x, y));
            let mut from = *from;
            for to in stops.into_iter().filter(|to| !same(to, &contour[k])) {
                all.push(([from, to, to], owner(faces, &from, &to, SAME * size)));
                from = to;
            }
        }
    }
    all
}

/// The number of the first segment that a part of it lies on, in its direction.
fn owner(faces: &[(Face, u32)], from: &Vector3<f64>, to: &Vector3<f64>, near: f64) -> u32 {
    let middle = 0.5 * (from + to);
    let holds = |(face, _): &&(Face, u32)| {
        let way = face[1] - face[0];
        let arm = middle - face[0];
        let t = arm.dot(&way) / way.norm_squared();
        (0.0..=1.0).contains(&t)
            && (arm - t * way).amax() <= 2.0 * near
            && way.dot(&(to - from)) > 0.0
    };
    faces.iter().find(holds).map_or(0, |(_, number)| *number)
}

/// The closed lines that segments make, one after the other as they are given.
fn contours(faces: &[(Face, u32)]) -> Vec<Vec<[f64; 2]>> {
    let mut all: Vec<Vec<[f64; 2]>> = Vec::new();
    let mut open: Option<(Vector3<f64>, Vec<[f64; 2]>)> = None;
    for ([from, to, _], _) in faces {
        let (first, mut line) = open.take().unwrap_or((*from, Vec::new()));
        line.push([from.x, from.y]);
        if *to == first {
            all.push(line);
        } else {
            open = Some((first, line));
        }
    }
    all
}
