//! Bodies from a CSV file.

use std::path::Path;

use super::Swarm;
use crate::config::fault::{AXES, Check, Fault};
use crate::config::raw::particle::{Overlap, below_periods, inside, overlap};
use crate::config::raw::{Case, Motion, Particle, Spin};

/// The columns of a file, by what they hold.
struct Columns {
    place: Vec<usize>,
    diameter: usize,
    density: Option<usize>,
    velocity: Vec<Option<usize>>,
    spin: Option<usize>,
}

/// A file, and the key that names it.
struct Source<'a> {
    path: &'a Path,
    key: &'a str,
}

impl Source<'_> {
    fn refuse(&self, place: &str, what: &str) -> Fault {
        Fault { key: self.key.to_owned(), message: format!("{place}: {what}") }
    }

    /// The refusal of a line.
    fn refuse_line(&self, line: u64, what: &str) -> Fault {
        self.refuse(&format!("{}:{line}", self.path.display()), what)
    }

    fn malformed(&self, e: &csv::Error) -> Fault {
        let line = e.position().map_or(1, |position| position.line());
        let what = match e.kind() {
            csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
                format!("has {len} columns, and the header {expected_len}")
            }
            _ => e.to_string(),
        };
        self.refuse_line(line, &what)
    }

    fn text(&self) -> Result<String, Fault> {
        let text = std::fs::read_to_string(self.path).map_err(|e| {
            let what = match e.kind() {
                std::io::ErrorKind::NotFound => {
                    "there is no such file; its path goes from the case file's folder".to_owned()
                }
                _ => format!("cannot be read: {e}"),
            };
            self.refuse(&self.path.display().to_string(), &what)
        })?;
        // Where a line ends with two characters, the second would count as another line's.
        Ok(text.replace("\r\n", "\n"))
    }
}

/// Appends the bodies of the file `path` to the case; refusals are at `key` and name the file, and
/// the line where they can.
pub(super) fn append(case: &mut Case, swarm: &Swarm, path: &Path, key: &str) -> Check {
    let source = Source { path, key };
    let text = source.text()?;
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let header = reader.headers().map_err(|e| source.malformed(&e))?.clone();
    let header_line = header.position().map_or(1, |position| position.line());
    let dimension = case.dimension();
    let columns = columns(&header, dimension, &swarm.motion.clone().unwrap_or_default())
        .map_err(|what| source.refuse_line(header_line, &what))?;
    let listed = case.particle.len();
    let mut lines = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|e| source.malformed(&e))?;
        let line = record.position().map_or(0, |position| position.line());
        let refuse = |what: String| source.refuse_line(line, &what);
        let particle = particle(swarm, dimension, &columns, &header, &record).map_err(refuse)?;
        below_periods(case, key, particle.shape.diameter())
            .map_err(|fault| refuse(format!("column `diameter`: {}", fault.message)))?;
        inside(case, key, "the particle", &particle)
            .map_err(|fault| refuse(format!("columns `x` to `diameter`: {}", fault.message)))?;
        lines.push(line);
        case.particle.push(particle);
    }
    let file = path.display();
    ensure!(!lines.is_empty(), key, "{file} lists no particles: one a line, below the header");
    if let Some(Overlap { first, second, words }) = overlap(case) {
        let other = match first.checked_sub(listed) {
            Some(row) => format!("that of line {}", lines[row]),
            None => format!("particle {first}"),
        };
        // Those before this file were clear of each other.
        let line = second.checked_sub(listed).map_or(0, |row| lines[row]);
        return Err(source.refuse_line(line, &format!("the particle overlaps {other}: {words}")));
    }
    Ok(())
}

/// Finds the columns by the names in the header, or says what is wrong with them.
fn columns(
    header: &csv::StringRecord,
    dimension: usize,
    motion: &Motion,
) -> Result<Columns, String> {
    let axes = &AXES[..dimension];
    let speeds = ["vx", "vy", "vz"];
    let mut known = [axes, &["diameter", "density"]].concat();
    if *motion == Motion::Free {
        known.extend(&speeds[..dimension]);
        known.push("spin");
    }
    for (i, name) in header.iter().enumerate() {
        if !known.contains(&name) {
            let moving = speeds[..dimension].contains(&name) || name == "spin";
            let why = if moving { "is for motion = \"free\" only" } else { "is unknown" };
            return Err(format!("column `{name}` {why}; known here: {}", known.join(", ")));
        }
        if header.iter().take(i).any(|other| other == name) {
            return Err(format!("column `{name}` is there twice: name each once"));
        }
    }
    let find = |name: &str| header.iter().position(|column| column == name);
    let need = |name: &str| {
        let needed = format!("{} and diameter", axes.join(", "));
        find(name).ok_or(format!("column `{name}` is missing: the header must name {needed}"))
    };
    Ok(Columns {
        place: axes.iter().map(|name| need(name)).collect::<Result<_, _>>()?,
        diameter: need("diameter")?,
        density: find("density"),
        velocity: speeds[..dimension].iter().map(|name| find(name)).collect(),
        spin: find("spin"),
    })
}

/// The particle of one line, or what is wrong with it.
fn particle(
    swarm: &Swarm,
    dimension: usize,
    columns: &Columns,
    header: &csv::StringRecord,
    record: &csv::StringRecord,
) -> Result<Particle, String> {
    let number = |column: usize| {
        let (name, text) =
            (header.get(column).unwrap_or_default(), record.get(column).unwrap_or_default());
        let number = text.parse::<f64>().ok().filter(|number| number.is_finite());
        number.ok_or(format!("column `{name}` must be a finite number, not \"{text}\""))
    };
    let positive = |column: usize, unit: &str| {
        let (name, value) = (header.get(column).unwrap_or_default(), number(column)?);
        if value > 0.0 {
            Ok(value)
        } else {
            Err(format!("column `{name}` must be positive ({unit}), not {value:?}"))
        }
    };
    let place =
        columns.place.iter().map(|column| number(*column)).collect::<Result<Vec<_>, _>>()?;
    let mut particle = swarm.particle(dimension, positive(columns.diameter, "m")?, place);
    if let Some(column) = columns.density {
        particle.density = Some(positive(column, "kg/m3")?);
    }
    for (axis, column) in columns.velocity.iter().enumerate() {
        if let Some(column) = column {
            particle.velocity.get_or_insert(vec![0.0; dimension])[axis] = number(*column)?;
        }
    }
    if let Some(column) = columns.spin {
        let about_z = number(column)?;
        particle.spin = Some(match (dimension, particle.spin) {
            (2, _) => Spin::Plane(about_z),
            (_, Some(Spin::Space([x, y, _]))) => Spin::Space([x, y, about_z]),
            _ => Spin::Space([0.0, 0.0, about_z]),
        });
    }
    Ok(particle)
}
