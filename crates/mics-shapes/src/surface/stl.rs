//! Closed surfaces of triangles from STL files, binary or text.
//!
//! ```text
//!   text     solid [name]                              any number of solids, in any case;
//!              facet normal nx ny nz                   together they are one surface
//!                outer loop
//!                  vertex x y z                        three of them, 64-bit numbers
//!                endloop
//!              endfacet
//!            endsolid [name]
//!   binary   80 bytes, u32 count, count times (normal, three vertices: 12 f32; 2 bytes)
//! ```

use crate::Fault;
use nalgebra::Vector3;
use std::collections::HashMap;
use std::path::Path;

/// Bytes ahead of the triangles of a binary file, the last four their count.
const HEAD: usize = 84;
/// Bytes of a triangle of a binary file.
const RECORD: usize = 50;

/// Distance (of the surface's length) within which corners are one: what single precision tells
/// apart.
const ONE_CORNER: f64 = 1e-7;

/// The corners of a triangle (m).
pub type Triangle = [Vector3<f64>; 3];

/// A closed surface.
#[derive(Clone, Debug, PartialEq)]
pub struct ClosedSurface {
    /// Its triangles, corners counterclockwise seen from outside (m).
    pub triangles: Vec<Triangle>,
    /// Corrections made on the way, in words for the user.
    pub notes: Vec<String>,
}

/// The triangles in a file, whose lengths are `scale` metres.
///
/// # Errors
///
/// The file cannot be read or is no STL file, in words, with the line of a text.
pub fn read(path: &Path, scale: f64) -> Result<Vec<Triangle>, Fault> {
    let bytes = std::fs::read(path).map_err(|e| Fault(format!("cannot be read: {e}")))?;
    // The count of a binary file has a byte that is zero, and text has none.
    let mesh = match bytes.get(..HEAD).filter(|head| head.contains(&0)) {
        Some(head) => binary(head, &bytes[HEAD..])?,
        None => text(&String::from_utf8_lossy(&bytes))?,
    };
    Ok(mesh.into_iter().map(|corners| corners.map(|corner| scale * corner)).collect())
}

/// The triangles of a binary file.
fn binary(head: &[u8], records: &[u8]) -> Result<Vec<Triangle>, Fault> {
    let word = |bytes: &[u8]| std::array::from_fn(|k| bytes[k]);
    let count = u32::from_le_bytes(word(&head[HEAD - 4..])) as usize;
    let found = records.len() / RECORD;
    if found < count {
        let why = format!(
            "ends after {found} triangles, and its head counts {count}: a binary STL file that is \
             cut off, or no STL file; write it again"
        );
        return Err(Fault(why));
    }
    let number = |bytes: &[u8]| f64::from(f32::from_le_bytes(word(bytes)));
    let corner = |bytes: &[u8]| Vector3::from_fn(|a, _| number(&bytes[4 * a..]));
    let triangle = |record: &[u8]| [12, 24, 36].map(|at| corner(&record[at..]));
    Ok(records.chunks_exact(RECORD).take(count).map(triangle).collect())
}

/// The triangles of all solids of a file of text.
fn text(text: &str) -> Result<Vec<Triangle>, Fault> {
    let mut triangles = Vec::new();
    let mut corners = Vec::new();
    let mut expected: &[&str] = &["solid"];
    for (number, line) in (1..).zip(text.trim_start_matches('\u{feff}').lines()) {
        let mut words = line.split_whitespace();
        let Some(first) = words.next().map(str::to_ascii_lowercase) else { continue };
        let refuse = |wanted: &str| {
            let found: String = line.trim().chars().take(40).collect();
            Fault(format!("line {number}: {wanted} is expected in an STL file, not \"{found}\""))
        };
        if !expected.contains(&first.as_str()) {
            return Err(refuse(&format!("`{}`", expected.join("` or `"))));
        }
        expected = match first.as_str() {
            "facet" => &["outer"],
            "outer" => &["vertex"],
            "vertex" => {
                let place: Option<Vec<f64>> = words.map(|word| word.parse().ok()).collect();
                let place = place.filter(|place| place.len() == 3);
                let wanted = "`vertex` with three numbers";
                corners.push(Vector3::from_vec(place.ok_or_else(|| refuse(wanted))?));
                if corners.len() < 3 { &["vertex"] } else { &["endloop"] }
            }
            "endloop" => &["endfacet"],
            "endsolid" => &["solid"],
            _ => &["facet", "endsolid"],
        };
        if let [a, b, c] = corners[..] {
            triangles.push([a, b, c]);
            corners.clear();
        }
    }
    if expected != ["solid"] {
        let wanted = expected.join("` or `");
        return Err(Fault(format!("ends where `{wanted}` is expected: it is cut off")));
    }
    Ok(triangles)
}

/// Checks a surface of triangles (m).
///
/// # Errors
///
/// There are no triangles, a corner is no place, the surface is open, triangles disagree about
/// which side is outside, or it holds no volume.
pub fn closed(mesh: Vec<Triangle>) -> Result<ClosedSurface, Fault> {
    if mesh.is_empty() {
        return Err(Fault("has no triangles".to_owned()));
    }
    let mut notes = Vec::new();
    let origin = mesh[0][0];
    let size = mesh.iter().flatten().map(|x| (x - origin).norm()).fold(0.0, f64::max);
    // The first of the corners that are one.
    let mut all: Vec<Vector3<f64>> = Vec::new();
    let mut numbers: HashMap<[i64; 3], u32> = HashMap::new();
    let mut edges: HashMap<[u32; 2], usize> = HashMap::new();
    let mut triangles = Vec::new();
    let mut flat = 0;
    for (k, corners) in mesh.iter().enumerate() {
        if corners.iter().flat_map(|x| x.iter()).any(|x| !x.is_finite()) {
            return Err(Fault(format!("triangle {} has a corner that is no place", k + 1)));
        }
        let own = corners.map(|corner| {
            let near = ((corner - origin) / (ONE_CORNER * size)).map(|x| x.round() as i64);
            *numbers.entry(near.into()).or_insert_with(|| {
                all.push(corner);
                all.len() as u32 - 1
            })
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
        triangles.push(own.map(|k| all[k as usize]));
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
    orient(triangles, size, notes)
}

/// The edges that no second triangle has.
fn open_edges(edges: &HashMap<[u32; 2], usize>) -> impl Iterator<Item = (&[u32; 2], &usize)> {
    edges.iter().filter(|([from, to], _)| !edges.contains_key(&[*to, *from]))
}

/// Turns a surface of this length (m) that is inside out.
fn orient(
    mut triangles: Vec<Triangle>,
    size: f64,
    mut notes: Vec<String>,
) -> Result<ClosedSurface, Fault> {
    let volume = volume(&triangles);
    if volume.abs() <= 1e-9 * size.powi(3) {
        return Err(Fault(format!("the surface holds no volume: {volume:e} m3")));
    }
    if volume < 0.0 {
        triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
        notes.push("the surface was inside out, and has been turned".to_owned());
    }
    Ok(ClosedSurface { triangles, notes })
}

/// Volume that a closed surface holds (m3).
pub fn volume(triangles: &[Triangle]) -> f64 {
    let Some([top, ..]) = triangles.first() else { return 0.0 };
    let part = |[a, b, c]: &Triangle| (a - top).dot(&(b - top).cross(&(c - top))) / 6.0;
    triangles.iter().map(part).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron() -> Vec<Triangle> {
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

    /// A solid of these triangles as text.
    fn written(mesh: &[Triangle]) -> String {
        let mut text = "solid stone\n".to_owned();
        for corners in mesh {
            text += "facet normal 0 0 0\nouter loop\n";
            for x in corners {
                text += &format!("vertex {:e} {:e} {:e}\n", x.x, x.y, x.z);
            }
            text += "endloop\nendfacet\n";
        }
        text + "endsolid stone\n"
    }

    /// A binary file of these triangles whose head begins with `name`.
    fn packed(mesh: &[Triangle], name: &[u8]) -> Vec<u8> {
        let mut bytes = name.to_vec();
        bytes.resize(HEAD - 4, b' ');
        bytes.extend((mesh.len() as u32).to_le_bytes());
        for corners in mesh {
            bytes.extend([0; 12]);
            let numbers = corners.iter().flat_map(|x| x.iter());
            bytes.extend(numbers.flat_map(|x| (*x as f32).to_le_bytes()));
            bytes.extend([0; 2]);
        }
        bytes
    }

    fn loaded(bytes: &[u8], scale: f64) -> Result<Vec<Triangle>, Fault> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("stone.stl");
        std::fs::write(&path, bytes).unwrap();
        read(&path, scale).and_then(closed).map(|surface| surface.triangles)
    }

    #[test]
    fn files_of_both_kinds_are_read_and_cut_off_ones_refused() {
        let mesh = tetrahedron();
        let cut = "is cut off";
        for (bytes, why) in [
            (packed(&mesh, b"stone"), "ends after 3 triangles, and its head counts 4"),
            (packed(&mesh, b"solid stone"), cut),
            (written(&mesh).into_bytes(), cut),
        ] {
            let found = loaded(&bytes, 0.1).unwrap();
            assert_eq!(found.len(), 4);
            assert!((volume(&found) - 1e-3 / 6.0).abs() < 1e-15);
            let refused = loaded(&bytes[..bytes.len() - 32], 0.1).unwrap_err().0;
            assert!(refused.contains(why), "{refused}");
        }
    }

    #[test]
    fn all_solids_of_a_text_are_one_surface_however_they_are_written() {
        let mesh = tetrahedron();
        let moved: Vec<Triangle> = mesh.iter().map(|t| t.map(|x| x.add_scalar(3.0))).collect();
        let two = loaded((written(&mesh) + &written(&moved)).as_bytes(), 1.0).unwrap();
        assert!(two.len() == 8 && (volume(&two) - 1.0 / 3.0).abs() < 1e-12);
        // Each face a solid of its own.
        let faces: String = mesh.iter().map(|t| written(&[*t])).collect();
        for text in [
            faces.clone(),
            faces.to_uppercase(),
            faces.replace(" stone", ""),
            format!("\n  \n{faces}"),
            format!("\u{feff}{faces}"),
            faces.replace('\n', "\r\n"),
        ] {
            assert_eq!(loaded(text.as_bytes(), 1.0).unwrap(), mesh, "{text}");
        }
    }

    #[test]
    fn numbers_of_a_text_have_64_bits() {
        // A millimetre at 20 km.
        let far = Vector3::new(2e4, -2e4, 2e4);
        let mesh: Vec<Triangle> = tetrahedron().iter().map(|t| t.map(|x| 1e-3 * x + far)).collect();
        let found = volume(&loaded(written(&mesh).as_bytes(), 1.0).unwrap());
        assert!((found / (1e-9 / 6.0) - 1.0).abs() < 1e-6, "{found}");
        // Corners that differ by rounding are one.
        let mut mesh = tetrahedron();
        mesh[3][0].y = 1e-16;
        assert_eq!(loaded(written(&mesh).as_bytes(), 1.0).unwrap(), tetrahedron());
    }

    #[test]
    fn what_is_no_stl_is_named_by_line_and_what_was_expected() {
        let whole = written(&tetrahedron());
        for (from, to, why) in [
            ("solid stone", "mesh", "line 1: `solid` is expected in an STL file, not \"mesh\""),
            ("outer loop", "outer\nouter", "line 4: `vertex` is expected"),
            ("0e0 0e0\n", "0e0 up\n", "line 4: `vertex` with three numbers is expected"),
            ("0e0 0e0\n", "0e0\n", "not \"vertex 0e0 0e0\""),
            ("endfacet\n", "endfacet\nvertex 1 2 3\n", "line 9: `facet` or `endsolid` is"),
        ] {
            let refused = loaded(whole.replacen(from, to, 1).as_bytes(), 1.0).unwrap_err().0;
            assert!(refused.contains(why), "{refused}");
        }
        assert!(loaded(b"", 1.0).unwrap_err().0.contains("no triangles"));
        let none = read(Path::new("none.stl"), 1.0).unwrap_err().0;
        assert!(none.contains("cannot be read"), "{none}");
    }
}
