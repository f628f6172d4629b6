//! Rows of `particles.csv` and `obstacles.csv`, which may be far larger than memory, for figures
//! and reports. Obstacles have the numbers after those of the particles.

use super::discs::start;
use super::kinds::{Course, LINES, representatives};
use crate::figure::{Series, SeriesStyle};
use mics_run::Result;
use mics_run::bodies::Pose;
use mics_run::config::{Case, FixedRows, Motion};
use mics_run::folder::{OBSTACLES, old_name};
use mics_run::not_a_run;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
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
    if asked.is_empty() { movers(case).collect() } else { asked.to_vec() }
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
    /// Where every particle is at each of the times asked for.
    places: Vec<HashMap<usize, Pose>>,
    /// Every particle's largest speed (m/s).
    pub fastest: HashMap<usize, f64>,
    /// Forces of the fluid (N) by kinds of bodies, where there are more bodies than a figure has
    /// lines.
    pub forces: Option<Course>,
    /// Velocities (m/s) by kinds of bodies, where there are so many.
    pub velocities: Option<Course>,
}

impl Rows {
    /// Reads a run's rows, with the centres at some times (s): between two rows linear, after the
    /// last one as there. All rows are kept of the particles that are `asked` for, or else of all,
    /// or of those that stand for them.
    pub fn read(run: &Path, case: &Case, times: &[f64], asked: &[usize]) -> Rows {
        let mut rows = Rows {
            run: run.to_owned(),
            places: vec![HashMap::new(); times.len()],
            ..Rows::default()
        };
        let movers = moving(case, asked);
        let loaded = loaded(case, asked);
        let free = free(case, asked);
        let follows = [&movers, &loaded, &free].map(|ids| representatives(case, ids)).concat();
        let course = |ids: &[usize]| (ids.len() > LINES).then(|| Course::new(case, ids));
        rows.forces = course(&loaded);
        rows.velocities = course(&free);
        if !rows.take(case, "particles.csv", 0, times, &follows) {
            rows.begin(case);
        }
        rows.take(case, OBSTACLES, case.particle.len(), times, &follows);
        [&mut rows.forces, &mut rows.velocities].into_iter().flatten().for_each(Course::close);
        rows
    }

    /// Takes the rows of a file whose bodies have the numbers from `first` on, and keeps all of
    /// those that figures show; returns whether there are any.
    fn take(
        &mut self,
        case: &Case,
        file: &str,
        first: usize,
        times: &[f64],
        shown: &[usize],
    ) -> bool {
        let Some(mut reader) = table(&self.run.join(file)) else { return false };
        let columns = reader
            .headers()
            .map(|h| h.iter().enumerate().map(|(k, n)| (n.to_owned(), k)).collect());
        self.columns = columns.unwrap_or_default();
        let [Some(t), Some(id), Some(x), Some(v)] =
            ["time", "id", "x", "vx"].map(|n| self.columns.get(n).copied())
        else {
            return false;
        };
        let mut before: HashMap<usize, Placed> = HashMap::new();
        let force = self.columns.get("fluid_fx").copied();
        let turn = Turn::of(case, &self.columns);
        let mut record = csv::StringRecord::new();
        let width = self.columns.len();
        while let Ok(true) = reader.read_record(&mut record) {
            let number = |k: usize| match record.get(k).and_then(|v| v.parse().ok()) {
                Some(body) if k == id => first as f64 + body,
                value => value.unwrap_or(f64::NAN),
            };
            let particle = number(id) as usize;
            let orientation = turn.filter(|_| is_turned(case, particle)).map(|t| t.read(number));
            let pose = Pose { orientation, ..Pose::at([x, x + 1, x + 2].map(number)) };
            let now = Placed { time: number(t), pose };
            let last = before.insert(particle, now).unwrap_or(now);
            for (places, time) in self.places.iter_mut().zip(times) {
                if (last.time..now.time).contains(time) {
                    places.insert(particle, last.towards(&now, *time, case));
                }
            }
            let velocity = [v, v + 1, v + 2].map(number);
            let speed = velocity.iter().map(|v| v * v).sum::<f64>().sqrt();
            if let Some(course) = &mut self.velocities {
                course.take(particle, now.time, velocity);
            }
            if let (Some(course), Some(f)) = (&mut self.forces, force) {
                course.take(particle, now.time, [f, f + 1, f + 2].map(number));
            }
            let fastest = self.fastest.entry(particle).or_insert(0.0);
            *fastest = fastest.max(speed);
            if shown.contains(&particle) {
                self.followed.push((0..width).map(number).collect());
            }
        }
        self.end(times, &before);
        !before.is_empty()
    }

    /// After their last rows particles are where they were in these, at each of
    /// the times asked for.
    fn end(&mut self, times: &[f64], newest: &HashMap<usize, Placed>) {
        let end = newest.values().map(|last| last.time).fold(0.0, f64::max);
        for (places, time) in self.places.iter_mut().zip(times) {
            // A body without a row at the end has left the box.
            let there = |last: f64| last <= *time * (1.0 + 1e-12) && (last == end || *time <= last);
            let ended = newest.iter().filter(|(_, last)| there(last.time));
            places.extend(ended.map(|(particle, last)| (*particle, last.pose)));
        }
    }

    /// Without any row, all that does not come in later is where it starts.
    fn begin(&mut self, case: &Case) {
        let there = || case.particle.iter().enumerate().filter(|(_, p)| p.enter.is_none());
        self.places
            .iter_mut()
            .for_each(|places| places.extend(there().map(|(id, p)| (id, Pose::at(start(p))))));
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.followed.is_empty()
    }

    /// Where particles are at one of the times asked for, by its number among them.
    pub fn poses(&self, time: usize) -> impl Fn(usize) -> Option<Pose> {
        move |particle| self.places.get(time)?.get(&particle).copied()
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

/// The columns that say how a particle is turned: its angle in 2D (rad), a quaternion in 3D.
#[derive(Clone, Copy)]
enum Turn {
    Angle(usize),
    Quaternion([usize; 4]),
}

impl Turn {
    /// The columns of a case, where they are there.
    fn of(case: &Case, columns: &HashMap<String, usize>) -> Option<Turn> {
        if case.dimension() == 2 {
            return columns.get("angle").copied().map(Turn::Angle);
        }
        let [w, x, y, z] = ["qw", "qx", "qy", "qz"].map(|name| columns.get(name).copied());
        Some(Turn::Quaternion([w?, x?, y?, z?]))
    }

    fn read(self, number: impl Fn(usize) -> f64) -> UnitQuaternion<f64> {
        match self {
            Turn::Angle(k) => UnitQuaternion::from_axis_angle(&Vector3::z_axis(), number(k)),
            Turn::Quaternion(columns) => {
                let [w, x, y, z] = columns.map(number);
                UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z))
            }
        }
    }
}

/// Whether a figure shows how a particle is turned by its outline.
fn is_turned(case: &Case, particle: usize) -> bool {
    case.particle.get(particle).is_none_or(|p| !p.shape.is_round())
}

/// Where a particle is at a time of a row.
#[derive(Clone, Copy)]
struct Placed {
    /// The time (s).
    time: f64,
    /// Where it is, and how it is turned.
    pose: Pose,
}

impl Placed {
    /// Where it is at a time before the row `to`; one that crosses a periodic face meanwhile is
    /// where it was.
    fn towards(&self, to: &Placed, time: f64, case: &Case) -> Pose {
        let part = (time - self.time) / (to.time - self.time);
        let from = self.pose;
        let orientation = from.orientation.zip(to.pose.orientation).map(|(a, b)| {
            // The shorter way; far apart they have no way between them that is right.
            let b = if a.coords.dot(&b.coords) < 0.0 { -b.into_inner() } else { b.into_inner() };
            UnitQuaternion::new_normalize(a.into_inner() * (1.0 - part) + b * part)
        });
        let centre = std::array::from_fn(|axis| {
            let x = from.centre[axis];
            let way = to.pose.centre[axis] - x;
            let jumps = case.domain.size.get(axis).is_some_and(|size| way.abs() > 0.5 * size);
            if jumps { x } else { x + part * way }
        });
        Pose { centre, orientation, ..from }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interpolated_centres_do_not_cross_periodic_side() {
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
        let rows = Rows::read(folder.path(), &case, &[0.0, 0.25, 1.5, 2.0, 7.0], &[]);
        let near = |k: usize, x: f64, y: f64| {
            let at = rows.poses(k)(0).unwrap().centre;
            assert!((at[0] - x).abs() < 1e-12 && (at[1] - y).abs() < 1e-12, "{k}: {at:?}");
        };
        near(0, 0.5, 1.8);
        near(1, 0.6, 1.75);
        near(2, 0.9, 1.5);
        near(3, 0.1, 1.4);
        near(4, 0.1, 1.4);
        assert!(rows.poses(0)(1).is_none() && rows.poses(5)(0).is_none());
        assert_eq!(rows.fastest[&0], 5.0);
        assert_eq!(rows.column(0, "y").unwrap(), [1.8, 1.6, 1.4]);
        let empty = |folder: &Path| {
            Rows::read(folder, &case, &[0.0], &[]).poses(0)(0).map(|pose| pose.centre)
        };
        assert_eq!(
            empty(&folder.path().join("none")),
            Some([0.5, 1.8, 0.0]),
            "without rows where it starts"
        );
        assert!(
            rows.column(0, "spin").unwrap_err().to_string().contains("particles.csv lacks spin")
        );
    }
}
