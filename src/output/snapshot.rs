//! Fields as ParaView opens them: VTK image data (`.vti`, raw appended arrays) and a time series (`.pvd`).

use crate::particles::Body;
use crate::scene::Scene;
use crate::{Error, Result};
use nalgebra::Vector3;
use std::fmt::Write as _;
use std::io::{self, BufRead as _, BufReader, BufWriter, Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::{fs, str};

/// Bytes of a file that hold its time, and more.
const HEAD: u64 = 4096;

/// One array of a snapshot, a value or three for each cell, x fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    /// Its name in ParaView.
    pub name: String,
    /// 1 for a scalar, 3 for a vector.
    pub components: usize,
    /// `components` numbers a cell.
    pub values: Vec<f64>,
}

/// The whole grid's fields at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    /// Time (s).
    pub time: f64,
    /// Cells along x, y, z (1 along z in 2D).
    pub cells: [usize; 3],
    /// Spacing (m); in 2D that along z is that along x.
    pub h: [f64; 3],
    /// Velocity (m/s), pressure (Pa), vorticity (1/s), in 3D Q (1/s2), whose isosurfaces show vortices, solid fraction, density (kg/m3) where it varies.
    /// Of cells that a body fills by more than half, velocity, vorticity and Q are those of the body's own motion.
    pub arrays: Vec<Array>,
}

impl Snapshot {
    /// Gathers the fields on rank 0 (elsewhere the arrays are empty). Collective.
    pub fn take<const D: usize>(scene: &mut Scene<D>) -> Result<Snapshot> {
        scene.domain.boundaries.fill_velocity(&mut scene.state.u)?;
        let own = |field: &mut [f64], motion: &dyn Fn(&Body, &Vector3<f64>) -> f64| {
            scene.method.with_body_overlaps(|k, overlaps| {
                let inside = overlaps.iter().filter(|o| o.is_inside());
                inside.for_each(|o| field[o.cell] = motion(&scene.state.bodies[k], &o.arm));
            });
        };
        let mut derived = scene.domain.grid.field();
        let mut velocity = Vec::new();
        for (axis, u) in scene.state.u.iter().enumerate() {
            derived.copy_from_slice(u);
            own(&mut derived, &|body, arm| body.velocity_at(arm)[axis]);
            velocity.push(scene.gather(&derived)?);
        }
        let mut arrays =
            vec![Array::vector("velocity", velocity), Array::scalar("pressure", scene.gather(&scene.state.p)?)];

        // (vector part, derivative's axis, of component): omega = d(of)/d(axis) - d(axis)/d(of).
        let planes: &[(usize, usize)] = if D == 2 { &[(0, 1)] } else { &[(1, 2), (2, 0), (0, 1)] };
        let mut vorticity = Vec::new();
        let slope = |scene: &Scene<D>, c: usize, i: usize, axis: usize| {
            let (grid, u) = (&scene.domain.grid, &scene.state.u[i]);
            (u[c + grid.stride[axis]] - u[c - grid.stride[axis]]) / (2.0 * grid.h[axis])
        };
        for &(a, b) in planes {
            for c in scene.domain.grid.rows().flatten() {
                derived[c] = slope(scene, c, b, a) - slope(scene, c, a, b);
            }
            own(&mut derived, &|body, _| 2.0 * body.spin[3 - a - b]);
            vorticity.push(scene.gather(&derived)?);
        }
        arrays.push(match vorticity.pop() {
            Some(only) if vorticity.is_empty() => Array::scalar("vorticity", only),
            last => Array::vector("vorticity", vorticity.into_iter().chain(last).collect()),
        });
        if D == 3 {
            // Q = -(du_i/dx_j du_j/dx_i)/2: positive where the flow turns more than it strains (Hunt, Wray & Moin 1988).
            for c in scene.domain.grid.rows().flatten() {
                let pairs = (0..D).flat_map(|i| (0..D).map(move |j| (i, j)));
                derived[c] = -0.5 * pairs.map(|(i, j)| slope(scene, c, i, j) * slope(scene, c, j, i)).sum::<f64>();
            }
            own(&mut derived, &|body, _| body.spin.norm_squared());
            arrays.push(Array::scalar("q", scene.gather(&derived)?));
        }
        if !scene.state.bodies.is_empty() {
            let mut fraction = scene.domain.grid.field();
            scene.method.with_overlaps(|overlaps| overlaps.for_each(|o| fraction[o.cell] += o.fraction));
            arrays.push(Array::scalar("solid_fraction", scene.gather(&fraction)?));
        }
        if let crate::grid::Coefficient::Field(density) = &scene.method.mixture().density {
            arrays.push(Array::scalar("density", scene.gather(density)?));
        }
        let grid = &scene.domain.grid;
        let pick = |a: usize| if a < D { a } else { 0 };
        Ok(Snapshot {
            time: scene.state.time,
            cells: std::array::from_fn(|a| if a < D { grid.cells[a] } else { 1 }),
            h: std::array::from_fn(|a| grid.h[pick(a)]),
            arrays,
        })
    }

    /// The array of a name.
    pub fn array(&self, name: &str) -> Option<&Array> {
        self.arrays.iter().find(|a| a.name == name)
    }

    /// Writes the snapshot under a temporary name and renames it, so that no reader meets half a file.
    pub fn write(&self, path: &Path) -> Result<()> {
        let [nx, ny, nz] = self.cells;
        let [hx, hy, hz] = self.h;
        let mut head = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" \
             header_type=\"UInt64\">\n<ImageData WholeExtent=\"0 {nx} 0 {ny} 0 {nz}\" Origin=\"0 0 0\" \
             Spacing=\"{hx:?} {hy:?} {hz:?}\">\n<FieldData>\n<DataArray type=\"Float64\" Name=\"TimeValue\" \
             NumberOfTuples=\"1\" format=\"ascii\">{:?}</DataArray>\n</FieldData>\n\
             <Piece Extent=\"0 {nx} 0 {ny} 0 {nz}\">\n<CellData Scalars=\"pressure\" Vectors=\"velocity\">\n",
            self.time
        );
        let mut offset = 0;
        for a in &self.arrays {
            let _ = writeln!(
                head,
                "<DataArray type=\"Float64\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" offset=\"{offset}\"/>",
                a.name, a.components,
            );
            offset += 8 * (1 + a.values.len());
        }
        head += "</CellData>\n</Piece>\n</ImageData>\n<AppendedData encoding=\"raw\">\n_";
        let put = |file: &mut BufWriter<fs::File>| {
            file.write_all(head.as_bytes())?;
            for a in &self.arrays {
                file.write_all(&(8 * a.values.len() as u64).to_le_bytes())?;
                a.values.iter().try_for_each(|v| file.write_all(&v.to_le_bytes()))?;
            }
            file.write_all(b"\n</AppendedData>\n</VTKFile>\n")
        };
        replace_by(path, |file| put(file).map_err(Error::io(part(path))))
    }

    /// Reads a file that [`Snapshot::write`] wrote.
    ///
    /// # Errors
    /// When the file is not there or not of that form.
    pub fn read(path: &Path) -> Result<Snapshot> {
        let bytes = fs::read(path).map_err(Error::io(path))?;
        Self::parse(&bytes).ok_or_else(|| Self::strange(path))
    }

    /// The time (s) of a file that [`Snapshot::write`] wrote, from its first lines.
    ///
    /// # Errors
    /// When the file is not there or not of that form.
    pub fn time_of(path: &Path) -> Result<f64> {
        let file = fs::File::open(path).map_err(Error::io(path))?;
        let mut lines = BufReader::new(file).take(HEAD).lines().map_while(io::Result::ok);
        lines.find_map(|line| time_in(&line)).ok_or_else(|| Self::strange(path))
    }

    fn strange(path: &Path) -> Error {
        Error::Usage(format!("{}: not a snapshot that mics wrote", path.display()))
    }

    fn parse(bytes: &[u8]) -> Option<Snapshot> {
        let mark = b"encoding=\"raw\">\n_";
        let data = bytes.windows(mark.len()).position(|w| w == mark)? + mark.len();
        let head = str::from_utf8(&bytes[..data]).ok()?;
        let attribute = |line: &str, name: &str| {
            let from = line.find(&format!(" {name}=\""))? + name.len() + 3;
            Some(line[from..from + line[from..].find('"')?].to_owned())
        };
        let image = head.lines().find(|l| l.starts_with("<ImageData"))?;
        let numbers = |text: String| text.split(' ').map(|w| w.parse().ok()).collect::<Option<Vec<f64>>>();
        let (extent, h) = (numbers(attribute(image, "WholeExtent")?)?, numbers(attribute(image, "Spacing")?)?);
        let cells = [1, 3, 5].map(|k| extent.get(k).copied().unwrap_or(0.0) as usize);
        let time = head.lines().find_map(time_in)?;
        let mut arrays = Vec::new();
        for line in head.lines().filter(|l| l.contains("format=\"appended\"")) {
            let from = data + attribute(line, "offset")?.parse::<usize>().ok()?;
            let length = u64::from_le_bytes(bytes.get(from..from + 8)?.try_into().ok()?) as usize;
            let raw = bytes.get(from + 8..(from + 8).checked_add(length)?)?;
            let values: Vec<_> =
                raw.chunks_exact(8).filter_map(|b| b.try_into().ok().map(f64::from_le_bytes)).collect();
            let components: usize = attribute(line, "NumberOfComponents")?.parse().ok()?;
            let expected = cells.iter().try_fold(components, |n, c| n.checked_mul(*c))?;
            if components == 0 || expected != values.len() {
                return None;
            }
            arrays.push(Array { name: attribute(line, "Name")?, components, values });
        }
        Some(Snapshot { time, cells, h: h.try_into().ok()?, arrays })
    }
}

/// The time in the line of a file that says it.
fn time_in(line: &str) -> Option<f64> {
    let line = Some(line).filter(|line| line.contains("TimeValue"))?;
    line.get(line.find('>')? + 1..line.rfind("</")?)?.parse().ok()
}

impl Array {
    pub(super) fn scalar(name: &str, values: Vec<f64>) -> Array {
        Array { name: name.into(), components: 1, values }
    }

    /// Three components a cell; those that are missing are zero.
    pub(super) fn vector(name: &str, parts: Vec<Vec<f64>>) -> Array {
        let n = parts.first().map_or(0, Vec::len);
        let values = (0..n).flat_map(|c| (0..3).map(move |k| (c, k)));
        let values = values.map(|(c, k)| parts.get(k).map_or(0.0, |p| p[c])).collect();
        Array { name: name.into(), components: 3, values }
    }
}

/// The index of a time series: `(time, file name)`.
pub fn write_series(path: &Path, entries: &[(f64, String)]) -> Result<()> {
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n<Collection>\n",
    );
    for (time, file) in entries {
        let _ = writeln!(text, "<DataSet timestep=\"{time:?}\" file=\"{file}\"/>");
    }
    text += "</Collection>\n</VTKFile>\n";
    replace(path, text.as_bytes())
}

/// The name of a file while it is being written.
pub fn part(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".part");
    path.with_file_name(name)
}

/// Writes a whole file or none.
pub fn replace(path: &Path, bytes: &[u8]) -> Result<()> {
    replace_by(path, |file| file.write_all(bytes).map_err(Error::io(part(path))))
}

/// The same, piece by piece.
///
/// # Errors
/// When the file cannot be written, or `write` says so.
pub fn replace_by(path: &Path, write: impl FnOnce(&mut BufWriter<fs::File>) -> Result<()>) -> Result<()> {
    let part = part(path);
    let written = fs::File::create(&part).map_err(Error::io(&part)).and_then(|file| {
        let mut file = BufWriter::new(file);
        write(&mut file)?;
        file.flush().map_err(Error::io(&part))
    });
    let written = written.and_then(|()| fs::rename(&part, path).map_err(Error::io(path)));
    if written.is_err() {
        // Half a file (a full disk) is of no use, and would keep space that the next one needs.
        let _ = fs::remove_file(&part);
    }
    written
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_snapshot_reads_back_as_it_was_written() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.vti");
        let snapshot = Snapshot {
            time: 0.1 + 0.2,
            cells: [2, 1, 1],
            h: [0.1, 0.3, 0.1],
            arrays: vec![
                Array::vector("velocity", vec![vec![1.0, 2.0], vec![3.0, f64::MIN_POSITIVE]]),
                Array::scalar("pressure", vec![-0.0, 1e300]),
            ],
        };
        snapshot.write(&path).unwrap();
        assert_eq!(Snapshot::read(&path).unwrap(), snapshot);
        assert_eq!(Snapshot::time_of(&path).unwrap(), snapshot.time);
        let text = String::from_utf8_lossy(&fs::read(&path).unwrap()).replace("Components=\"3\"", "Components=\"0\"");
        fs::write(&path, text).unwrap();
        assert!(Snapshot::read(&path).is_err(), "an array of no components");
        fs::write(&path, "<VTKFile").unwrap();
        assert!(Snapshot::read(&path).unwrap_err().to_string().contains("not a snapshot"));
        assert!(Snapshot::time_of(&path).unwrap_err().to_string().contains("not a snapshot"));
    }
}
