//! Bodies of another run: those that a case begins with, or that a swarm lists.

use crate::config::fault::{AXES, Check, Fault};
use crate::config::particle::{Overlap, below_periods, inside, overlap};
use crate::config::{By, Case, Initial, Motion, Orientation, Particle, Spin};
use std::collections::HashMap;
use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};

/// Upper bound of the bytes of a row of `particles.csv`.
const ROW: u64 = 2048;

/// Reads the dimension and the bodies of the case that a run wrote, from its text.
pub(in crate::config) type ReadBodies = fn(&str) -> Result<(usize, Vec<Particle>), String>;

/// Puts the bodies that the case begins with before its own; `folder` is the case file's, `read`
/// reads that run's case.
pub(in crate::config) fn begin(case: &mut Case, folder: &Path, read: ReadBodies) -> Check {
    let Some(run) = case.initial.from.clone().filter(|_| !case.initial.listed) else {
        return Ok(());
    };
    let key = "initial.from";
    let Initial { velocity, perturbation, taylor_green, couette, .. } = &case.initial;
    let added = *perturbation != 0.0 || taylor_green.is_some() || couette.is_some();
    ensure!(
        velocity.is_empty() && !added,
        key,
        "the fluid's velocity is that run's: remove initial.velocity, initial.perturbation, \
        initial.taylor_green and initial.couette"
    );
    let run = located(&run, folder);
    case.initial.from = Some(run.display().to_string());
    case.initial.listed = true;
    let bodies = bodies(&run, case.dimension(), key, read)?;
    case.initial.inherited = bodies.len();
    case.particle.splice(0..0, bodies);
    for body in &case.particle {
        below_periods(case, key, body.shape.bounding_diameter())?;
        inside(case, key, "a particle of that run", body)?;
    }
    if let Some(Overlap { first, second, words }) = overlap(case) {
        ensure!(
            false,
            key,
            "particle {second} overlaps particle {first}, in the order of that run and then of \
            this file: {words}"
        );
    }
    Ok(())
}

/// A run's folder as it is typed, seen from where the program runs, as `--out` is, or else from the
/// case file's folder.
pub(super) fn located(run: &str, folder: &Path) -> PathBuf {
    let typed = PathBuf::from(run);
    if typed.exists() || !folder.join(run).exists() { typed } else { folder.join(run) }
}

/// The bodies of a run as they were at its end.
pub(super) fn bodies(
    run: &Path,
    dimension: usize,
    key: &str,
    read: ReadBodies,
) -> Result<Vec<Particle>, Fault> {
    let refuse =
        |what: String| Fault { key: key.to_owned(), message: format!("{}: {what}", run.display()) };
    let case = std::fs::read_to_string(run.join("case.toml")).map_err(|_| {
        refuse("holds no run (no case.toml in it); name the folder that `mics run` wrote".into())
    })?;
    let (was, bodies) =
        read(&case).map_err(|why| refuse(format!("its case cannot be read: {why}")))?;
    let is = dimension;
    ensure!(was == is, key, "{}: that run is {was}D, and this case {is}D", run.display());
    if bodies.is_empty() {
        return Ok(bodies);
    }
    let rows = last_rows(&run.join("particles.csv"), bodies.len(), last_step(run));
    let rows = rows.map_err(|why| refuse(format!("particles.csv {why}")))?;
    if let Some(id) = bodies.iter().position(swings) {
        return Err(refuse(format!(
            "particle {id} swings, and where it is in its swing cannot be taken over: give the \
            bodies in a file, or that one by itself"
        )));
    }
    let mut there: Vec<(usize, Particle)> = bodies.into_iter().enumerate().collect();
    there.retain(|(id, body)| rows.contains_key(id) || body.motion == Motion::Fixed);
    // Fixed ones may have rows at the start only.
    for (id, body) in there.iter_mut().filter(|(_, body)| body.motion != Motion::Fixed) {
        let number = |name: &str| -> Result<f64, Fault> {
            let found = rows.get(id).and_then(|row| row.get(name)).copied();
            found.ok_or_else(|| {
                refuse(format!("particles.csv has no `{name}` of particle {id} at the end"))
            })
        };
        let along = |names: [&str; 3]| {
            names[..dimension].iter().map(|name| number(name)).collect::<Result<Vec<_>, _>>()
        };
        body.position = along(AXES)?;
        body.enter = None;
        if !body.shape.is_round() {
            body.orientation = Some(match dimension {
                2 => Orientation::Plane(number("angle")?.to_degrees()),
                _ => Orientation::By(By {
                    quaternion: [number("qw")?, number("qx")?, number("qy")?, number("qz")?],
                }),
            });
        }
        if body.motion == Motion::Free {
            body.velocity = Some(along(["vx", "vy", "vz"])?);
            body.spin = Some(match dimension {
                2 => Spin::Plane(number("wz")?),
                _ => Spin::Space([number("wx")?, number("wy")?, number("wz")?]),
            });
        }
    }
    Ok(there.into_iter().map(|(_, body)| body).collect())
}

/// Whether a body has a prescribed motion to and fro.
fn swings(body: &Particle) -> bool {
    matches!(&body.motion, Motion::Prescribed(told) if told.oscillation.is_some())
}

/// The step at which a run ended, as far as its summary says it.
fn last_step(run: &Path) -> Option<f64> {
    let text = std::fs::read_to_string(run.join("summary.json")).ok()?;
    serde_json::from_str::<serde_json::Value>(&text).ok()?["steps"].as_f64()
}

/// The rows of the last step in a run's `particles.csv`, of about so many particles, by id: the
/// numbers by their column's name. None where they are of a step before the `end`: all bodies had
/// left by then.
fn last_rows(
    path: &Path,
    count: usize,
    end: Option<f64>,
) -> Result<HashMap<usize, HashMap<String, f64>>, String> {
    let broken = |e: &dyn std::fmt::Display| format!("cannot be read: {e}");
    let mut file = File::open(path).map_err(|e| broken(&e))?;
    let length = file.metadata().map_err(|e| broken(&e))?.len();
    let mut head = vec![0; length.min(4 * ROW) as usize];
    file.read_exact(&mut head).map_err(|e| broken(&e))?;
    let head = String::from_utf8_lossy(&head);
    let names: Vec<&str> = head.lines().next().unwrap_or_default().split(',').collect();
    // The last step's rows are in the tail; its first line (cut, or the header) is skipped.
    let tail = length.min(ROW * (count as u64 + 2));
    let mut text = String::new();
    file.seek(SeekFrom::Start(length - tail)).map_err(|e| broken(&e))?;
    file.read_to_string(&mut text).map_err(|e| broken(&e))?;
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|number| number.parse().unwrap_or(f64::NAN)).collect())
        .filter(|row: &Vec<f64>| row.len() == names.len())
        .collect();
    let column =
        |name: &str| names.iter().position(|n| *n == name).ok_or(format!("has no column `{name}`"));
    let step = column("step")?;
    let id = column("id")?;
    let whole = text.ends_with('\n')
        && text.lines().last().is_some_and(|line| line.split(',').count() == names.len());
    if !whole {
        return Err("is cut off in its last line".into());
    }
    let last = rows.last().map(|row| row[step]).ok_or("has no rows")?;
    if end.is_some_and(|end| last < end) {
        return Ok(HashMap::new());
    }
    let named =
        |row: &Vec<f64>| names.iter().map(|n| (*n).to_owned()).zip(row.iter().copied()).collect();
    Ok(rows
        .iter()
        .filter(|row| row[step] == last)
        .map(|row| (row[id] as usize, named(row)))
        .collect())
}
