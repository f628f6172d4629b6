//! Closed surfaces of triangles from STL files, binary or text.

use super::Fault;
use nalgebra::Vector3;
use std::collections::HashMap;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// A closed surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Its triangles, corners counterclockwise seen from outside (m).
    pub triangles: Vec<[Vector3<f64>; 3]>,
    /// What was corrected on the way, in words for the user.
    pub notes: Vec<String>,
}

/// The triangles of a file, whose lengths are `scale` metres, counterclockwise seen from outside.
///
/// # Errors
///
/// Those of [`load`].
pub fn read(path: &Path, scale: f64) -> Result<Vec<[Vector3<f64>; 3]>, Fault> {
    Ok(load(path, scale)?.triangles)
}

/// That surface, with what was corrected.
///
/// # Errors
///
/// The file cannot be read or has no triangles, a corner is no place, the surface is open,
/// triangles disagree about which side is outside, or it holds no volume.
pub fn load(path: &Path, scale: f64) -> Result<Surface, Fault> {
    let file = File::open(path).map_err(|e| Fault(format!("cannot be read: {e}")))?;
    let mut reader = BufReader::new(file);
    let mesh = stl_io::create_stl_reader(&mut reader)
        .and_then(|triangles| triangles.collect::<Result<Vec<_>, _>>())
        .map_err(|e| Fault(format!("is no STL file: {e}")))?;
    let corner = |v: &stl_io::Vertex| scale * Vector3::from(v.0.map(f64::from));
    closed(mesh.iter().map(|triangle| triangle.vertices.each_ref().map(corner)).collect())
}

/// Checks a surface of triangles (m).
///
/// # Errors
///
/// Those of [`load`].
pub fn closed(mesh: Vec<[Vector3<f64>; 3]>) -> Result<Surface, Fault> {
    if mesh.is_empty() {
        return Err(Fault("has no triangles".to_owned()));
    }
    let mut notes = Vec::new();
    let mut numbers: HashMap<[u64; 3], u32> = HashMap::new();
    let mut edges: HashMap<[u32; 2], usize> = HashMap::new();
    let mut triangles = Vec::new();
    let mut flat = 0;
    for (k, corners) in mesh.iter().enumerate() {
        if corners.iter().flat_map(|x| x.iter()).any(|x| !x.is_finite()) {
            return Err(Fault(format!("triangle {} has a corner that is no place", k + 1)));
        }
        // Minus zero is zero.
        let own = corners.map(|corner| {
            let next = numbers.len() as u32;
            *numbers.entry(<[f64; 3]>::from(corner).map(|x| (x + 0.0).to_bits())).or_insert(next)
        });
        if own[0] == own[1] || own[1] == own[2] || own[2] == own[0] {
            // Two corners in one: it fills no gap.
            flat += 1;
            continue;
        }
        for i in 0..3 {
            if let Some(other) = edges.insert([own[i], own[(i + 1) % 3]], k) {
                let why = format!(
                    "triangles {} and {} share an edge and disagree about which side is outside, \
                     or lie on each other",
                    other + 1,
                    k + 1
                );
                return Err(Fault(why));
            }
        }
        triangles.push(*corners);
    }
    if let Some((_, k)) = open_edges(&edges).min_by_key(|(_, k)| **k) {
        let count = open_edges(&edges).count();
        let why = format!(
            "the surface is open: {count} edges have one triangle only, as one of triangle {}; \
             close it in the program that wrote it",
            k + 1
        );
        return Err(Fault(why));
    }
    if flat > 0 {
        notes.push(format!("{flat} triangles with two corners in one place were left out"));
    }
    orient(triangles, notes)
}

/// The edges that no second triangle has.
fn open_edges(edges: &HashMap<[u32; 2], usize>) -> impl Iterator<Item = (&[u32; 2], &usize)> {
    edges.iter().filter(|([from, to], _)| !edges.contains_key(&[*to, *from]))
}

/// Turns an inside out surface.
fn orient(mut triangles: Vec<[Vector3<f64>; 3]>, mut notes: Vec<String>) -> Result<Surface, Fault> {
    let volume = volume(&triangles);
    let size = triangles.iter().flatten().map(|x| (x - triangles[0][0]).norm()).fold(0.0, f64::max);
    if volume.abs() <= 1e-9 * size.powi(3) {
        return Err(Fault(format!("the surface holds no volume: {volume:e} m3")));
    }
    if volume < 0.0 {
        triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
        notes.push("the surface was inside out, and has been turned".to_owned());
    }
    Ok(Surface { triangles, notes })
}

/// Volume that a closed surface holds (m3).
pub fn volume(triangles: &[[Vector3<f64>; 3]]) -> f64 {
    let Some([top, ..]) = triangles.first() else { return 0.0 };
    let part = |[a, b, c]: &[Vector3<f64>; 3]| (a - top).dot(&(b - top).cross(&(c - top))) / 6.0;
    triangles.iter().map(part).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron() -> Vec<[Vector3<f64>; 3]> {
        let [o, x, y, z] = [Vector3::zeros(), Vector3::x(), Vector3::y(), Vector3::z()];
        vec![[o, y, x], [o, x, z], [o, z, y], [x, y, z]]
    }

    #[test]
    fn closed_surface_is_read_and_an_inside_out_one_turned() {
        let found = closed(tetrahedron()).unwrap();
        assert!((volume(&found.triangles) - 1.0 / 6.0).abs() < 1e-15 && found.notes.is_empty());
        let mut turned = tetrahedron();
        turned.iter_mut().for_each(|corners| corners.swap(0, 1));
        let found = closed(turned).unwrap();
        assert!((volume(&found.triangles) - 1.0 / 6.0).abs() < 1e-15);
        assert!(found.notes[0].contains("inside out"));
        let mut doubled = tetrahedron();
        doubled.push([doubled[0][0], doubled[0][0], doubled[0][1]]);
        assert!(closed(doubled).unwrap().notes[0].contains("1 triangles"));
    }

    #[test]
    fn faults_of_surfaces_name_the_triangle() {
        let fault = |mesh| closed(mesh).unwrap_err().0;
        assert!(fault(Vec::new()).contains("no triangles"));
        let mut mesh = tetrahedron();
        mesh.remove(3);
        assert!(fault(mesh).contains("open: 3 edges"));
        let mut mesh = tetrahedron();
        mesh[1][2][0] = f64::NAN;
        assert!(fault(mesh).contains("triangle 2"));
        let mut mesh = tetrahedron();
        mesh[2].swap(0, 1);
        assert!(fault(mesh).contains("disagree"));
        let [a, b, c] = tetrahedron()[0];
        assert!(fault(vec![[a, b, c], [b, a, c]]).contains("no volume"));
    }

    #[test]
    fn files_of_both_kinds_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let mesh = tetrahedron();
        let triangles: Vec<stl_io::Triangle> = mesh
            .iter()
            .map(|corners| stl_io::Triangle {
                normal: stl_io::Normal::new([0.0; 3]),
                vertices: corners.map(|x| stl_io::Vertex::new(x.map(|x| x as f32).into())),
            })
            .collect();
        let mut bytes = Vec::new();
        stl_io::write_stl(&mut bytes, triangles.iter()).unwrap();
        let mut text = "solid stone\n".to_owned();
        for corners in &mesh {
            text += "facet normal 0 0 0\nouter loop\n";
            for x in corners {
                text += &format!("vertex {:e} {:e} {:e}\n", x.x, x.y, x.z);
            }
            text += "endloop\nendfacet\n";
        }
        text += "endsolid stone\n";
        for bytes in [bytes, text.into_bytes()] {
            let path = folder.path().join("stone.stl");
            std::fs::write(&path, &bytes).unwrap();
            let found = read(&path, 0.1).unwrap();
            assert_eq!(found.len(), 4);
            assert!((volume(&found) - 1e-3 / 6.0).abs() < 1e-15);
            std::fs::write(&path, &bytes[..bytes.len() - 30]).unwrap();
            let why = read(&path, 0.1).unwrap_err().0;
            assert!(why.contains("STL") || why.contains("open"), "{why}");
        }
        assert!(
            read(&folder.path().join("none.stl"), 1.0).unwrap_err().0.contains("cannot be read")
        );
    }
}
