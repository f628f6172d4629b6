//! Writes bodies as ParaView opens them ([`mics_run::bodies`]): first a point at each centre, then
//! the surfaces of those that are not round; with tractions those of all, and pressure and shear on
//! them. (Pieces of their own for these are misread by VTK,
//! which leaves their points' numbers as they are.)

use super::surface::{Load, Points};
use crate::Result;
use crate::method::Traction;
use crate::particles::Body;
use mics_run::file::replace;
use nalgebra::Vector3;
use std::collections::HashMap;
use std::fmt::Write as _;
use std::path::Path;

/// Triangles along the length of a curved surface.
const ALONG: f64 = 32.0;

/// A body as it is written.
pub struct Shown<'a> {
    /// Its number.
    pub id: usize,
    /// The body itself.
    pub body: &'a Body,
    /// The force of the fluid on it (N).
    pub force: Vector3<f64>,
    /// The tractions on its surface; none where they are not asked for.
    pub tractions: &'a [Traction],
}

/// Writes bodies at a time (s).
///
/// # Errors
/// When the file cannot be written.
pub fn write<'a>(path: &Path, time: f64, bodies: impl Iterator<Item = Shown<'a>>) -> Result<()> {
    let mut text = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" \
        byte_order=\"LittleEndian\">\n<PolyData>\n<FieldData>\n\
         <DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" \
             format=\"ascii\">{time:?}</DataArray>\n</FieldData>\n"
    );
    let mut piece = Piece::default();
    let bodies: Vec<_> = bodies.collect();
    for (k, one) in bodies.iter().enumerate() {
        let body = one.body;
        piece.put(one, body.centre, body.velocity, body.shape().is_round());
        piece.loads.push(Load::mean(one.tractions));
        piece.vertices.push(vec![k]);
    }
    bodies.iter().for_each(|one| piece.put_surface(one));
    piece.write(&mut text);
    text += "</PolyData>\n</VTKFile>\n";
    replace(path, text.as_bytes())
}

/// Points with the data of each, and the cells that they form.
#[derive(Default)]
struct Piece<'a> {
    /// The body that a point is of.
    bodies: Vec<&'a Shown<'a>>,
    /// Positions of the points (m).
    places: Vec<Vector3<f64>>,
    /// Velocities of the points (m/s).
    velocities: Vec<Vector3<f64>>,
    /// Radii of the spheres to be drawn at the points (m); 0 where there is none.
    radii: Vec<f64>,
    /// Pressure and shear at the points, at a centre their means; zero where there are none.
    loads: Vec<Load>,
    /// The cells: points, segments and triangles.
    vertices: Vec<Vec<usize>>,
    lines: Vec<Vec<usize>>,
    triangles: Vec<Vec<usize>>,
}

impl<'a> Piece<'a> {
    /// Adds a point of a body; a sphere of its radius is to be drawn there if `round`.
    fn put(
        &mut self,
        one: &'a Shown<'a>,
        place: Vector3<f64>,
        velocity: Vector3<f64>,
        round: bool,
    ) {
        self.bodies.push(one);
        self.places.push(place);
        self.velocities.push(velocity);
        self.radii.push(if round { one.body.radius() } else { 0.0 });
    }

    /// The surface of a body that is not round, or has tractions.
    fn put_surface(&mut self, one: &'a Shown<'a>) {
        let body = one.body;
        let shape = body.shape();
        let turn = body.orientation();
        let points = Points::new(one.tractions, shape.dimension());
        let triangles = match &points {
            Some(points) => points.triangles(shape),
            None if shape.is_round() => Vec::new(),
            None => shape.triangles(2.0 * shape.radius() / ALONG),
        };
        let mut known: HashMap<[u64; 3], usize> = HashMap::new();
        for corners in triangles {
            let corner = |corner: Vector3<f64>| {
                *known.entry(<[f64; 3]>::from(corner).map(f64::to_bits)).or_insert_with(|| {
                    let arm = turn * corner;
                    let velocity = body.velocity + body.spin.cross(&arm);
                    self.put(one, body.centre + arm, velocity, false);
                    let load = points.as_ref().map(|points| points.load(&arm));
                    self.loads.push(load.unwrap_or_default());
                    self.places.len() - 1
                })
            };
            let [a, b, c] = corners.map(corner);
            if b == c {
                self.lines.push(vec![a, b]);
            } else {
                self.triangles.push(vec![a, b, c]);
            }
        }
    }

    fn write(&self, text: &mut String) {
        let count = |cells: &[Vec<usize>]| cells.len();
        let _ = write!(
            text,
            "<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"{}\" NumberOfLines=\"{}\" \
             NumberOfStrips=\"0\" NumberOfPolys=\"{}\">\n\
             <PointData Scalars=\"radius\" Vectors=\"velocity\">\n",
            self.places.len(),
            count(&self.vertices),
            count(&self.lines),
            count(&self.triangles)
        );
        let all = || self.bodies.iter();
        let vectors = |of: &[Vector3<f64>]| -> Vec<f64> {
            of.iter().flat_map(|v| <[f64; 3]>::from(*v)).collect()
        };
        array(text, "id", 1, all().map(|one| one.id as f64));
        array(text, "radius", 1, self.radii.iter().copied());
        array(text, "diameter", 1, all().map(|one| one.body.shape().diameter()));
        array(text, "velocity", 3, vectors(&self.velocities));
        array(text, "spin", 3, all().flat_map(|one| <[f64; 3]>::from(one.body.spin)));
        array(text, "force", 3, all().flat_map(|one| <[f64; 3]>::from(one.force)));
        let turned = |body: &Body| {
            [body.orientation.w, body.orientation.i, body.orientation.j, body.orientation.k]
        };
        array(text, "orientation", 4, all().flat_map(|one| turned(one.body)));
        if all().any(|one| !one.tractions.is_empty()) {
            array(text, "pressure", 1, self.loads.iter().map(|load| load.pressure));
            let shear = self.loads.iter().flat_map(|load| <[f64; 3]>::from(load.shear));
            array(text, "shear", 3, shear);
        }
        *text += "</PointData>\n<Points>\n";
        array(text, "Points", 3, vectors(&self.places));
        *text += "</Points>\n";
        cells(text, "Verts", &self.vertices);
        cells(text, "Lines", &self.lines);
        cells(text, "Polys", &self.triangles);
        *text += "</Piece>\n";
    }
}

/// Cells by the numbers of their points.
fn cells(text: &mut String, kind: &str, cells: &[Vec<usize>]) {
    let mut end = 0;
    let ends = cells.iter().map(|cell| {
        end += cell.len();
        end
    });
    let arrays = [
        ("connectivity", cells.iter().flatten().copied().collect::<Vec<_>>()),
        ("offsets", ends.collect()),
    ];
    let _ = writeln!(text, "<{kind}>");
    for (name, numbers) in arrays {
        let _ = write!(text, "<DataArray type=\"Int64\" Name=\"{name}\" format=\"ascii\">");
        numbers.iter().for_each(|number| {
            let _ = write!(text, "{number} ");
        });
        *text += "</DataArray>\n";
    }
    let _ = writeln!(text, "</{kind}>");
}

fn array(text: &mut String, name: &str, components: usize, values: impl IntoIterator<Item = f64>) {
    let kind = if name == "id" { "Int64" } else { "Float64" };
    let _ = write!(
        text,
        "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" \
        format=\"ascii\">"
    );
    values.into_iter().for_each(|value| {
        let _ = write!(text, "{value} ");
    });
    text.push_str("</DataArray>\n");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Disc;
    use mics_run::bodies::read;
    use nalgebra::UnitQuaternion;
    use std::f64::consts::FRAC_PI_4;
    use std::sync::Arc;

    fn shown(id: usize, body: &Body) -> Shown<'_> {
        Shown { id, body, force: Vector3::zeros(), tractions: &[] }
    }

    #[test]
    fn bodies_csv_round_trip_and_truncated_file() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("bodies.vtp");
        assert!(read(&path).unwrap().is_empty());
        let at =
            |x: f64| Body::new(Arc::new(Disc { radius: 0.1 }), 1.0, 0.0, Vector3::new(x, 0.5, 0.0));
        let turned = UnitQuaternion::from_scaled_axis(Vector3::z() * 0.7);
        let mut moved = at(0.25);
        moved.id = 7;
        moved.velocity = Vector3::new(3.0, -4.0, 0.0);
        moved.orientation = turned;
        let bodies = [at(0.4), moved];
        write(&path, 0.1, bodies.iter().map(|body| shown(body.id, body))).unwrap();
        let poses = read(&path).unwrap();
        assert_eq!((poses.len(), poses[&0].centre, poses[&0].speed), (2, [0.4, 0.5, 0.0], 0.0));
        assert_eq!((poses[&7].centre, poses[&7].speed), ([0.25, 0.5, 0.0], 5.0));
        assert!(poses[&7].orientation.unwrap().angle_to(&turned) < 1e-12);
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, &text[..text.len() / 2]).unwrap();
        assert!(read(&path).unwrap_err().to_string().contains("not bodies that mics wrote"));
    }

    #[test]
    fn surface_of_turned_body_lies_around_its_centre_and_moves_with_it() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("bodies.vtp");
        let square =
            mics_shapes::Polygon::new(&[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]], 0.0);
        let shape = Arc::new(square.unwrap());
        let mut body = Body::new(shape, 1.0, 0.0, Vector3::new(5.0, 5.0, 0.0));
        body.orientation = UnitQuaternion::from_scaled_axis(Vector3::z() * FRAC_PI_4);
        body.velocity = Vector3::new(1.0, 0.0, 0.0);
        body.spin = Vector3::z();
        write(&path, 0.0, std::iter::once(shown(0, &body))).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.contains("NumberOfPoints=\"5\" NumberOfVerts=\"1\" NumberOfLines=\"4\""));
        let numbers = |name: &str, width: usize| -> Vec<f64> {
            let from = text.find(&format!("Name=\"{name}\"")).unwrap();
            let values = text[from..].split(['>', '<']).nth(1).unwrap();
            let all = values.split_ascii_whitespace().map(|number| number.parse().unwrap());
            all.skip(width).collect()
        };
        for (at, v) in numbers("Points", 3).chunks(3).zip(numbers("velocity", 3).chunks(3)) {
            let arm = [at[0] - 5.0, at[1] - 5.0];
            // The corners of the diamond.
            assert!((arm[0].abs() + arm[1].abs() - 2.0_f64.sqrt()).abs() < 1e-9, "{arm:?}");
            assert!((v[0] - 1.0 + arm[1]).abs() < 1e-12 && (v[1] - arm[0]).abs() < 1e-12);
        }
        assert!(numbers("radius", 0).iter().all(|r| *r == 0.0));
        assert_eq!(read(&path).unwrap()[&0].centre, [5.0, 5.0, 0.0]);
    }
}
