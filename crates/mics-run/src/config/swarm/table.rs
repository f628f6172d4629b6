//! Bodies from a CSV file.

use std::path::Path;

use super::Swarm;
use super::kinds::{choices, kinds};
use crate::config::fault::{AXES, Check};
use crate::config::particle::{Overlap, below_periods, inside, overlap};
use crate::config::source::{self, Source};
use crate::config::{By, Case, Kind, Motion, Orientation, Particle, Spin};

/// The columns of a file, by what they hold.
struct Columns {
    place: Vec<usize>,
    diameter: Option<usize>,
    shape: Option<usize>,
    /// angle in 2D, qw, qx, qy, qz in 3D.
    turn: Option<Vec<usize>>,
    density: Option<usize>,
    velocity: Vec<Option<usize>>,
    spin: Option<usize>,
}

/// Appends the bodies of the file `path` to the case; refusals are at `key` and name the file, and
/// the line where they can.
pub(super) fn append(case: &mut Case, swarm: &Swarm, path: &Path, key: &str) -> Check {
    let source = Source { path, key };
    let text = source.text()?;
    let mut reader = source::reader(&text);
    let header = reader.headers().map_err(|e| source.malformed(&e))?.clone();
    let header_line = header.position().map_or(1, |position| position.line());
    let dimension = case.dimension();
    let columns = columns(&header, dimension, swarm)
        .map_err(|what| source.refuse_line(header_line, &what))?;
    let kinds = kinds(swarm, dimension);
    let mut choices = choices(swarm, dimension, &kinds);
    let listed = case.particle.len();
    let mut lines = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|e| source.malformed(&e))?;
        let line = record.position().map_or(0, |position| position.line());
        let refuse = |what: String| source.refuse_line(line, &what);
        let particle = choices
            .next()
            .ok_or_else(String::new)
            .and_then(|(kind, orientation)| {
                particle(swarm, kind, orientation, &kinds, &columns, &header, &record)
            })
            .map_err(refuse)?;
        below_periods(case, key, particle.shape.bounding_diameter())
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
        // Bodies before this file were clear of each other.
        let line = second.checked_sub(listed).map_or(0, |row| lines[row]);
        return Err(source.refuse_line(line, &format!("the particle overlaps {other}: {words}")));
    }
    Ok(())
}

/// Finds the columns by the names in the header, or says what is wrong with them.
fn columns(header: &csv::StringRecord, dimension: usize, swarm: &Swarm) -> Result<Columns, String> {
    let axes = &AXES[..dimension];
    let speeds = ["vx", "vy", "vz"];
    let turns = if dimension == 2 { &["angle"][..] } else { &["qw", "qx", "qy", "qz"] };
    let shaped = !swarm.solids.is_empty();
    let mut known = [axes, &["diameter", "density"]].concat();
    if shaped {
        known.push("shape");
        known.extend(turns);
    }
    if swarm.motion.as_ref().is_none_or(|motion| *motion == Motion::Free) {
        known.extend(&speeds[..dimension]);
        known.push("spin");
    }
    for (i, name) in header.iter().enumerate() {
        if !known.contains(&name) {
            let moving = speeds[..dimension].contains(&name) || name == "spin";
            let turned = turns.contains(&name) || name == "shape";
            let why = match (moving, turned) {
                (true, _) => "is for motion = \"free\" only",
                (_, true) if !shaped => "is for a swarm with shape or shapes",
                _ => "is unknown",
            };
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
    let turn: Vec<usize> = turns.iter().filter_map(|name| find(name)).collect();
    if !turn.is_empty() && turn.len() < turns.len() {
        return Err(format!("an orientation needs all of the columns {}", turns.join(", ")));
    }
    let shape = find("shape");
    if shape.is_none() && swarm.solids.len() > 1 {
        return Err("column `shape` is missing: the number of each in `shapes`, from 0".to_owned());
    }
    Ok(Columns {
        place: axes.iter().map(|name| need(name)).collect::<Result<_, _>>()?,
        diameter: if shaped { find("diameter") } else { Some(need("diameter")?) },
        shape,
        turn: (!turn.is_empty()).then_some(turn),
        density: find("density"),
        velocity: speeds[..dimension].iter().map(|name| find(name)).collect(),
        spin: find("spin"),
    })
}

/// The particle of one line, or what is wrong with it.
fn particle(
    swarm: &Swarm,
    kind: &Kind,
    orientation: Option<Orientation>,
    kinds: &[Kind],
    columns: &Columns,
    header: &csv::StringRecord,
    record: &csv::StringRecord,
) -> Result<Particle, String> {
    let number = |column: usize| {
        let name = header.get(column).unwrap_or_default();
        let text = record.get(column).unwrap_or_default();
        let number = text.parse::<f64>().ok().filter(|number| number.is_finite());
        number.ok_or(format!("column `{name}` must be a finite number, not \"{text}\""))
    };
    let positive = |column: usize, unit: &str| {
        let name = header.get(column).unwrap_or_default();
        let value = number(column)?;
        if value > 0.0 {
            Ok(value)
        } else {
            Err(format!("column `{name}` must be positive ({unit}), not {value:?}"))
        }
    };
    let place =
        columns.place.iter().map(|column| number(*column)).collect::<Result<Vec<_>, _>>()?;
    let dimension = place.len();
    let diameter = columns.diameter.map(|column| positive(column, "m")).transpose()?;
    let kind = match columns.shape {
        None => kind,
        Some(column) => chosen(kinds, number(column)?)?,
    };
    let orientation = match &columns.turn {
        None => orientation,
        Some(turn) => {
            let numbers = turn.iter().map(|column| number(*column));
            Some(turned(&numbers.collect::<Result<Vec<_>, _>>()?)?)
        }
    };
    let mut particle = swarm.particle(kind.made(diameter, orientation), place);
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

/// The kind of this number in `shapes`.
fn chosen(kinds: &[Kind], wanted: f64) -> Result<&Kind, String> {
    let found = kinds.iter().enumerate().find(|(k, _)| *k as f64 == wanted);
    found.map(|(_, kind)| kind).ok_or_else(|| {
        let last = kinds.len() - 1;
        format!("column `shape` must be a number of `shapes`, 0 to {last}, not {wanted:?}")
    })
}

/// The orientation of an angle (rad) or the four numbers of a quaternion.
fn turned(numbers: &[f64]) -> Result<Orientation, String> {
    let [w, x, y, z] = numbers[..] else {
        return Ok(Orientation::Plane(numbers[0].to_degrees()));
    };
    let orientation = Orientation::By(By { quaternion: [w, x, y, z] });
    let columns = "columns `qw` to `qz`";
    let checked = orientation.check(columns, 3);
    checked.map_err(|fault| format!("{columns}: {}", fault.message))?;
    Ok(orientation)
}
