//! Fields as ParaView opens them: VTK image data (`.vti`, raw appended arrays) and a time series
//! (`.pvd`).
//!
//! ```text
//!   XML: grid, time, arrays and where each begins     bytes, values of array 0
//!                 bytes, values of array 1
//!              ...
//!              XML
//! ```
//! Values stand in the whole grid's order, x fastest. Every rank writes its own cells where they
//! belong in the one file: no rank holds the whole grid, and a file does not tell how many ranks
//! wrote it. All have to see the same folder.

use crate::file::{part, replace};
use crate::{Error, Result};
use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, Read as _};
use std::ops::Range;
use std::os::unix::fs::FileExt as _;
use std::path::{Path, PathBuf};
use std::str;

/// First bytes of a file, which hold all of its XML before the values.
const HEAD: u64 = 1 << 16;
/// End of that XML.
const MARK: &[u8] = b"encoding=\"raw\">\n_";
/// End of a file, after the values.
const END: &[u8] = b"\n</AppendedData>\n</VTKFile>\n";
/// Bytes that are collected before they are written.
const BUFFER: usize = 1 << 20;

/// Head of a file, ahead of its values.
#[derive(Clone, Debug, PartialEq)]
pub struct Head {
    /// Time (s).
    pub time: f64,
    /// Cells along x, y, z (1 along z in 2D).
    pub cells: [usize; 3],
    /// Spacing (m); in 2D that along z is that along x.
    pub h: [f64; 3],
    /// Name of each array, and its components a cell.
    pub arrays: Vec<(String, usize)>,
}

impl Head {
    /// Bytes of the values of an array of so many components.
    fn size(&self, components: usize) -> u64 {
        8 * components as u64 * self.cells.iter().map(|n| *n as u64).product::<u64>()
    }

    /// Offset after the XML of each array's size, and of the end of the last array (bytes).
    fn offsets(&self) -> Vec<u64> {
        let next = |at: &mut u64, (_, components): &(String, usize)| {
            let here = *at;
            *at += 8 + self.size(*components);
            Some((here, *at))
        };
        let ends: Vec<_> = self.arrays.iter().scan(0, next).collect();
        ends.iter().map(|(here, _)| *here).chain([ends.last().map_or(0, |(_, end)| *end)]).collect()
    }

    fn xml(&self) -> String {
        let [nx, ny, nz] = self.cells;
        let [hx, hy, hz] = self.h;
        let mut text = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" \
            byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<ImageData WholeExtent=\"0 {nx} 0 \
            {ny} 0 {nz}\" Origin=\"0 0 0\" Spacing=\"{hx:?} {hy:?} {hz:?}\">\n<FieldData>\n\
            <DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" \
            format=\"ascii\">{:?}</DataArray>\n</FieldData>\n\
            <Piece Extent=\"0 {nx} 0 {ny} 0 {nz}\">\n\
            <CellData Scalars=\"pressure\" Vectors=\"velocity\">\n",
            self.time
        );
        for ((name, components), offset) in self.arrays.iter().zip(self.offsets()) {
            let _ = writeln!(
                text,
                "<DataArray type=\"Float64\" Name=\"{name}\" NumberOfComponents=\"{components}\" \
                format=\"appended\" offset=\"{offset}\"/>"
            );
        }
        text + "</CellData>\n</Piece>\n</ImageData>\n<AppendedData encoding=\"raw\">\n_"
    }

    /// Reads the XML at the beginning of these bytes; also where the values begin.
    pub(crate) fn parse(bytes: &[u8]) -> Option<(Head, usize)> {
        let data = bytes.windows(MARK.len()).position(|w| w == MARK)? + MARK.len();
        let head = str::from_utf8(&bytes[..data]).ok()?;
        let attribute = |line: &str, name: &str| {
            let from = line.find(&format!(" {name}=\""))? + name.len() + 3;
            Some(line[from..from + line[from..].find('"')?].to_owned())
        };
        let image = head.lines().find(|l| l.starts_with("<ImageData"))?;
        let numbers =
            |text: String| text.split(' ').map(|w| w.parse().ok()).collect::<Option<Vec<f64>>>();
        let extent = numbers(attribute(image, "WholeExtent")?)?;
        let h = numbers(attribute(image, "Spacing")?)?;
        let cells = [1, 3, 5].map(|k| extent.get(k).copied().unwrap_or(0.0) as usize);
        let time = head.lines().find(|line| line.contains("TimeValue"))?;
        let time = time.get(time.find('>')? + 1..time.rfind("</")?)?.parse().ok()?;
        let listed = head.lines().filter(|l| l.contains("format=\"appended\""));
        let listed = listed.map(|line| {
            let components = attribute(line, "NumberOfComponents")?.parse().ok()?;
            Some((
                (attribute(line, "Name")?, components),
                attribute(line, "offset")?.parse::<u64>().ok()?,
            ))
        });
        let (arrays, offsets): (Vec<_>, Vec<_>) =
            listed.collect::<Option<Vec<_>>>()?.into_iter().unzip();
        let found = Head { time, cells, h: h.try_into().ok()?, arrays };
        // Sizes that no file has are refused: their sum may overflow.
        let most = found.arrays.iter().try_fold(0usize, |sum, (_, components)| {
            let size =
                cells.iter().try_fold(components.checked_mul(8)?, |n, c| n.checked_mul(*c))?;
            (*components > 0).then(|| sum.checked_add(size))?
        });
        (most.is_some() && found.offsets()[..offsets.len()] == offsets).then_some((found, data))
    }

    /// Reads the head of a file; also where its values begin (bytes).
    ///
    /// # Errors
    /// When the file is not there or not of that form.
    pub(crate) fn read(path: &Path) -> Result<(Head, u64)> {
        let mut bytes = Vec::new();
        let file = File::open(path).map_err(Error::io(path))?;
        file.take(HEAD).read_to_end(&mut bytes).map_err(Error::io(path))?;
        Head::parse(&bytes).map(|(head, data)| (head, data as u64)).ok_or_else(|| strange(path))
    }
}

pub(crate) fn strange(path: &Path) -> Error {
    Error::Usage(format!("{}: not a snapshot that mics wrote", path.display()))
}

/// Writer of cells to their places in a file, in any order. The first failure is told at the end.
pub struct Cells {
    file: File,
    path: PathBuf,
    /// Where the values of each array begin.
    begins: Vec<u64>,
    /// Bytes that are yet to be written, and where they go.
    waiting: Vec<u8>,
    at: u64,
    failed: Option<io::Error>,
}

impl Cells {
    /// Writer of the cells of a `file` that will be at `path`.
    pub fn of(file: File, path: &Path, head: &Head) -> Cells {
        let data = head.xml().len() as u64;
        let begins = head.offsets().iter().map(|offset| data + offset + 8).collect();
        Cells {
            file,
            path: part(path),
            begins,
            waiting: Vec::with_capacity(BUFFER),
            at: 0,
            failed: None,
        }
    }

    /// Writes all of the file but the values.
    pub fn frame(&mut self, head: &Head) {
        self.write(0, head.xml().as_bytes());
        for (k, (_, components)) in head.arrays.iter().enumerate() {
            self.write(self.begins[k] - 8, &head.size(*components).to_le_bytes());
        }
        let end = self.begins.last().map_or(0, |after| after - 8);
        self.write(end, END);
    }

    /// Writes a row of array `k` from the cell `first` on, in the whole grid's order.
    pub fn put(
        &mut self,
        k: usize,
        components: usize,
        first: usize,
        row: Range<usize>,
        parts: &[&[f64]],
    ) {
        let at = self.begins[k] + 8 * (components * first) as u64;
        let next = self.waiting.len() + 8 * components * row.len();
        if at != self.at + self.waiting.len() as u64 || next > BUFFER {
            self.flush();
            self.at = at;
        }
        for c in row {
            for k in 0..components {
                self.waiting.extend(parts.get(k).map_or(0.0, |part| part[c]).to_le_bytes());
            }
        }
    }

    fn flush(&mut self) {
        let waiting = std::mem::take(&mut self.waiting);
        self.write(self.at, &waiting);
        self.waiting = waiting;
        self.waiting.clear();
    }

    fn write(&mut self, at: u64, bytes: &[u8]) {
        if self.failed.is_none() {
            self.failed = self.file.write_all_at(bytes, at).err();
        }
    }

    /// Writes what is left.
    ///
    /// # Errors
    /// When anything could not be written.
    pub fn finish(mut self) -> Result<()> {
        self.flush();
        self.failed.map_or(Ok(()), |e| Err(Error::io(self.path)(e)))
    }
}

/// Rows along x of one array of a file, read as they are asked for.
pub struct ArrayRows {
    file: File,
    path: PathBuf,
    /// Head of the file.
    pub head: Head,
    begin: u64,
    /// Components of the array.
    pub components: usize,
}

impl ArrayRows {
    /// Opens the rows of an array; `None` where the file has no array of the name.
    ///
    /// # Errors
    /// When the file is not there or not of that form.
    pub fn open(path: &Path, name: &str) -> Result<Option<ArrayRows>> {
        let (head, data) = Head::read(path)?;
        let Some(k) = head.arrays.iter().position(|array| array.0 == name) else { return Ok(None) };
        let begin = data + head.offsets()[k] + 8;
        let components = head.arrays[k].1;
        let file = File::open(path).map_err(Error::io(path))?;
        Ok(Some(ArrayRows { file, path: path.to_owned(), head, begin, components }))
    }

    /// Reads the row of a number, `j + cells along y * k`, into `values`.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn read(&self, row: usize, values: &mut Vec<f64>) -> Result<()> {
        let length = 8 * self.components * self.head.cells[0];
        let mut bytes = vec![0; length];
        let at = self.begin + (row * length) as u64;
        self.file.read_exact_at(&mut bytes, at).map_err(Error::io(&self.path))?;
        values.clear();
        values.extend(
            bytes.chunks_exact(8).map(|b| b.try_into().map_or(f64::NAN, f64::from_le_bytes)),
        );
        Ok(())
    }
}

/// The index of a time series: `(time, file name)`.
pub fn write_series(path: &Path, entries: &[(f64, String)]) -> Result<()> {
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" \
        byte_order=\"LittleEndian\">\n<Collection>\n",
    );
    for (time, file) in entries {
        let _ = writeln!(text, "<DataSet timestep=\"{time:?}\" file=\"{file}\"/>");
    }
    text += "</Collection>\n</VTKFile>\n";
    replace(path, text.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file::PartFile;
    use crate::snapshot::{Array, Snapshot};
    use std::fs;

    #[test]
    fn vti_rows_in_any_order_round_trip() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.vti");
        let arrays = vec![("velocity".to_owned(), 3), ("pressure".to_owned(), 1)];
        let head = Head { time: 0.1 + 0.2, cells: [2, 2, 1], h: [0.1, 0.3, 0.1], arrays };
        let (whole, file) = PartFile::create(&path).unwrap();
        let mut cells = Cells::of(file, &path, &head);
        let u = [1.0, 2.0, 3.0, 4.0];
        let v = [5.0, f64::MIN_POSITIVE, 7.0, 8.0];
        let p = [-0.0, 1e300, 1.5, 2.5];
        cells.put(1, 1, 2, 2..4, &[&p]);
        cells.put(1, 1, 0, 0..2, &[&p]);
        cells.frame(&head);
        cells.put(0, 3, 0, 0..2, &[&u, &v]);
        cells.put(0, 3, 2, 2..4, &[&u, &v]);
        cells.finish().unwrap();
        assert!(!path.exists());
        whole.commit().unwrap();
        let velocity = (0..4).flat_map(|c| [u[c], v[c], 0.0]).collect();
        let expected = Snapshot {
            time: head.time,
            cells: head.cells,
            h: head.h,
            arrays: vec![
                Array { name: "velocity".into(), components: 3, values: velocity },
                Array { name: "pressure".into(), components: 1, values: p.to_vec() },
            ],
        };
        assert_eq!(Snapshot::read(&path).unwrap(), expected);
        assert_eq!(Snapshot::time_of(&path).unwrap(), head.time);
        let rows = ArrayRows::open(&path, "velocity").unwrap().unwrap();
        let mut row = Vec::new();
        rows.read(1, &mut row).unwrap();
        assert_eq!(row, [3.0, 7.0, 0.0, 4.0, 8.0, 0.0]);
        assert!(ArrayRows::open(&path, "spin").unwrap().is_none());
        let whole = fs::read(&path).unwrap();
        let text = String::from_utf8_lossy(&whole).replace("Components=\"3\"", "Components=\"0\"");
        fs::write(&path, text).unwrap();
        assert!(Snapshot::read(&path).is_err(), "an array of no components");
        fs::write(&path, &whole[..whole.len() - 60]).unwrap();
        assert!(Snapshot::read(&path).is_err(), "cut off");
        fs::write(&path, "<VTKFile").unwrap();
        assert!(Snapshot::read(&path).unwrap_err().to_string().contains("not a snapshot"));
        assert!(Snapshot::time_of(&path).unwrap_err().to_string().contains("not a snapshot"));
    }

    #[test]
    fn unfinished_vti_leaves_no_file() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.vti");
        drop(PartFile::create(&path).unwrap());
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 0);
    }
}
