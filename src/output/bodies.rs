//! Writes bodies as ParaView opens them ([`mics_run::bodies`]).

use crate::Result;
use crate::particles::Body;
use mics_run::file::replace;
use nalgebra::Vector3;
use std::fmt::Write as _;
use std::path::Path;

/// Writes the bodies with the forces of the fluid on them (N) at a time (s).
///
/// # Errors
/// When the file cannot be written.
pub fn write(path: &Path, time: f64, bodies: &[Body], forces: &[Vector3<f64>]) -> Result<()> {
    let count = bodies.len();
    let mut text = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" \
        byte_order=\"LittleEndian\">\n<PolyData>\n<FieldData>\n\
         <DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" \
             format=\"ascii\">{time:?}</DataArray>\n</FieldData>\n\
         <Piece NumberOfPoints=\"{count}\" NumberOfVerts=\"{count}\" NumberOfLines=\"0\" \
             NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n\
         <PointData Scalars=\"radius\" Vectors=\"velocity\">\n"
    );
    let vectors = |of: fn(&Body) -> Vector3<f64>| {
        bodies.iter().flat_map(|b| <[f64; 3]>::from(of(b))).collect::<Vec<_>>()
    };
    array(&mut text, "id", 1, bodies.iter().map(|b| b.id as f64));
    array(&mut text, "radius", 1, bodies.iter().map(Body::radius));
    array(&mut text, "velocity", 3, vectors(|b| b.velocity));
    array(&mut text, "spin", 3, vectors(|b| b.spin));
    array(&mut text, "force", 3, forces.iter().flat_map(|f| <[f64; 3]>::from(*f)));
    let turned = |b: &Body| [b.orientation.w, b.orientation.i, b.orientation.j, b.orientation.k];
    array(&mut text, "orientation", 4, bodies.iter().flat_map(turned));
    text += "</PointData>\n<Points>\n";
    array(&mut text, "Points", 3, vectors(|b| b.centre));
    text += "</Points>\n<Verts>\n";
    for (name, first) in [("connectivity", 0), ("offsets", 1)] {
        let _ = write!(text, "<DataArray type=\"Int64\" Name=\"{name}\" format=\"ascii\">");
        (first..first + count).for_each(|at| text += &format!("{at} "));
        text += "</DataArray>\n";
    }
    text += "</Verts>\n</Piece>\n</PolyData>\n</VTKFile>\n";
    replace(path, text.as_bytes())
}

fn array(text: &mut String, name: &str, components: usize, values: impl IntoIterator<Item = f64>) {
    let kind = if name == "id" { "Int64" } else { "Float64" };
    let _ = write!(
        text,
        "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" \
        format=\"ascii\">"
    );
    values.into_iter().for_each(|value| text.push_str(&format!("{value} ")));
    text.push_str("</DataArray>\n");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Disc;
    use mics_run::bodies::read;
    use nalgebra::UnitQuaternion;
    use std::sync::Arc;

    #[test]
    fn bodies_csv_round_trip_and_truncated_file() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("bodies.vtp");
        assert!(read(&path).unwrap().is_empty());
        let at =
            |x: f64| Body::new(Arc::new(Disc { radius: 0.1 }), 1.0, 0.0, Vector3::new(x, 0.5, 0.0));
        let turned = UnitQuaternion::from_scaled_axis(Vector3::z() * 0.7);
        let mut moved = at(0.25);
        (moved.id, moved.velocity, moved.orientation) = (7, Vector3::new(3.0, -4.0, 0.0), turned);
        write(&path, 0.1, &[at(0.4), moved], &[Vector3::zeros(); 2]).unwrap();
        let poses = read(&path).unwrap();
        assert_eq!((poses.len(), poses[&0].centre, poses[&0].speed), (2, [0.4, 0.5, 0.0], 0.0));
        assert_eq!((poses[&7].centre, poses[&7].speed), ([0.25, 0.5, 0.0], 5.0));
        assert!(poses[&7].orientation.unwrap().angle_to(&turned) < 1e-12);
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, &text[..text.len() / 2]).unwrap();
        assert!(read(&path).unwrap_err().to_string().contains("not bodies that mics wrote"));
    }
}
