//! Rows of `particles.csv` and `obstacles.csv`, which may be far larger than memory, for figures
//! and reports. Obstacles have the numbers after those of the particles.

use super::kinds::{Course, LINES, representatives};
use crate::figure::{Series, SeriesStyle};
use mics_run::Result;
use mics_run::config::{Case, FixedRows, Motion};
use mics_run::folder::{OBSTACLES, old_name};
use mics_run::not_a_run;
use std::collections::HashMap;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Take};
use std::path::{Path, PathBuf};

/// The whole lines of a table of a run, which may still be growing.
pub fn table(path: &Path) -> Option<csv::Reader<Take<File>>> {
    let mut file = File::open(path).ok()?;
    let length = file.metadata().ok()?.len();
    let mut whole = length;
    let mut block = [0u8; 4096];
    // Backwards to the end of the last whole line.
    while whole > 0 {
        let from = whole.saturating_sub(block.len() as u64);
        let part = &mut block[..(whole - from) as usize];
        file.seek(SeekFrom::Start(from)).ok()?;
        file.read_exact(part).ok()?;
        match part.iter().rposition(|byte| *byte == b'\n') {
            Some(at) => {
                whole = from + at as u64 + 1;
                break;
            }
            None => whole = from,
        }
    }
    file.rewind().ok()?;
    Some(csv::Reader::from_reader(file.take(whole)))
}

/// The bodies that figures of motion are of: those that are `asked` for, or else all that move.
pub fn moving(case: &Case, asked: &[usize]) -> Vec<usize> {
    let particles = asked.iter().copied().filter(|id| *id < case.particle.len());
    if asked.is_empty() { movers(case).collect() } else { particles.collect() }
}

/// The bodies that figures of forces are of: those that are `asked` for, or else all that move, all
/// that are held where they have rows, and the obstacles.
pub fn loaded(case: &Case, asked: &[usize]) -> Vec<usize> {
    let held = |id: &usize| {
        case.output.fixed_rows() == FixedRows::Always && case.particle[*id].motion == Motion::Fixed
    };
    let held = (0..case.particle.len()).filter(held);
    let walls = case.particle.len()..case.particle.len() + case.obstacle.len();
    if asked.is_empty() { movers(case).chain(held).chain(walls).collect() } else { asked.to_vec() }
}

/// The free ones among the bodies of [`moving`].
pub fn free(case: &Case, asked: &[usize]) -> Vec<usize> {
    let mut ids = moving(case, asked);
    ids.retain(|id| case.particle[*id].is_free());
    ids
}

/// Rows of `particles.csv` and `obstacles.csv`; none where there is no such file.
#[derive(Default)]
pub struct Rows {
    /// The run's folder, for messages.
    run: PathBuf,
    /// The number of each column by its name.
    columns: HashMap<String, usize>,
    /// All rows of the particles that figures show.
    followed: Vec<Vec<f64>>,
    /// Every particle's largest speed (m/s).
    pub fastest: HashMap<usize, f64>,
    /// Forces of the fluid (N) by kinds of bodies, where there are more bodies than a figure has
    /// lines.
    pub forces: Option<Course>,
    /// Velocities (m/s) by kinds of bodies, where there are so many.
    pub velocities: Option<Course>,
}

impl Rows {
    /// Reads a run's rows. All are kept of the particles that are `asked` for, or else of all, or
    /// of those that stand for them.
    pub fn read(run: &Path, case: &Case, asked: &[usize]) -> Rows {
        let mut rows = Rows { run: run.to_owned(), ..Rows::default() };
        let movers = moving(case, asked);
        let loaded = loaded(case, asked);
        let free = free(case, asked);
        let follows = [&movers, &loaded, &free].map(|ids| representatives(case, ids)).concat();
        let course = |ids: &[usize]| (ids.len() > LINES).then(|| Course::new(case, ids));
        rows.forces = course(&loaded);
        rows.velocities = course(&free);
        rows.take("particles.csv", 0, &follows);
        rows.take(OBSTACLES, case.particle.len(), &follows);
        [&mut rows.forces, &mut rows.velocities].into_iter().flatten().for_each(Course::close);
        rows
    }

    /// Takes the rows of a file whose bodies have the numbers from `first` on, and keeps all of
    /// those that figures show.
    fn take(&mut self, file: &str, first: usize, shown: &[usize]) {
        let Some(mut reader) = table(&self.run.join(file)) else { return };
        let columns = reader
            .headers()
            .map(|h| h.iter().enumerate().map(|(k, n)| (n.to_owned(), k)).collect());
        self.columns = columns.unwrap_or_default();
        let [Some(t), Some(id), Some(v)] =
            ["time", "id", "vx"].map(|n| self.columns.get(n).copied())
        else {
            return;
        };
        let force = self.columns.get("fluid_fx").copied();
        let mut record = csv::StringRecord::new();
        let width = self.columns.len();
        while let Ok(true) = reader.read_record(&mut record) {
            let number = |k: usize| match record.get(k).and_then(|v| v.parse().ok()) {
                Some(body) if k == id => first as f64 + body,
                value => value.unwrap_or(f64::NAN),
            };
            let particle = number(id) as usize;
            let time = number(t);
            let velocity = [v, v + 1, v + 2].map(number);
            let speed = velocity.iter().map(|v| v * v).sum::<f64>().sqrt();
            if let Some(course) = &mut self.velocities {
                course.take(particle, time, velocity);
            }
            if let (Some(course), Some(f)) = (&mut self.forces, force) {
                course.take(particle, time, [f, f + 1, f + 2].map(number));
            }
            let fastest = self.fastest.entry(particle).or_insert(0.0);
            *fastest = fastest.max(speed);
            if shown.contains(&particle) {
                self.followed.push((0..width).map(number).collect());
            }
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.followed.is_empty()
    }

    /// A column of one particle that is followed.
    ///
    /// # Errors
    /// When there is no such column.
    pub fn column(&self, id: usize, name: &str) -> Result<Vec<f64>> {
        let at = |name: &str| {
            let lacks = || not_a_run(&self.run, &format!("particles.csv lacks {name}"));
            let old = || self.columns.get(&old_name(name)?);
            self.columns.get(name).or_else(old).copied().ok_or_else(lacks)
        };
        let k = at("id")?;
        let column = at(name)?;
        Ok(self.followed.iter().filter(|row| row[k] == id as f64).map(|row| row[column]).collect())
    }

    /// One column over another, of one particle that is followed.
    ///
    /// # Errors
    /// When there is no such column.
    pub fn curve(&self, id: usize, x: &str, y: &str, label: &str) -> Result<Series> {
        let points = self.column(id, x)?.into_iter().zip(self.column(id, y)?).collect();
        Ok(Series { label: label.into(), points, style: SeriesStyle::Line })
    }
}

/// The particles that move.
pub fn movers(case: &Case) -> impl Iterator<Item = usize> {
    case.particle.iter().enumerate().filter(|(_, p)| p.motion != Motion::Fixed).map(|(id, _)| id)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_end_with_the_last_whole_line() {
        let folder = tempfile::tempdir().unwrap();
        let case: Case = mics_run::config::written(
            "name = \"t\"\ntime.end = 9.0\ndomain = { size = [1.0, 2.0], cells = [8, 16] }\n\
            fluid = { density = 2.0, viscosity = 0.1 }\n\
            boundary = { west = \"periodic\", east = \"periodic\", south = \"wall\", north = \
            \"wall\" }\n\
            particle = [{ shape = { disc = { diameter = 0.2 } }, position = [0.5, 1.8] }]\n",
        )
        .unwrap();
        let text = "time,id,x,y,z,vx,vy,vz\n0.0,0,0.5,1.8,0,0,0,0\n1.0,0,0.9,1.6,0,3,4,0\n\
            2.0,0,0.1,1.4,0,0,0,0\n\
            3.0,0,0.2,1.0,0,9,9,9";
        // The last line is not whole yet, and may lack digits.
        std::fs::write(folder.path().join("particles.csv"), text).unwrap();
        let rows = Rows::read(folder.path(), &case, &[]);
        assert_eq!(rows.fastest[&0], 5.0);
        assert_eq!(rows.column(0, "y").unwrap(), [1.8, 1.6, 1.4]);
        let lacks = rows.column(0, "spin").unwrap_err().to_string();
        assert!(lacks.contains("particles.csv lacks spin"), "{lacks}");
    }
}
