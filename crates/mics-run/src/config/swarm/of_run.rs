//! Bodies of a run as they were at its end.

use super::Swarm;
use crate::config::begin::{self, ReadBodies};
use crate::config::fault::Check;
use crate::config::particle::{Overlap, below_periods, inside, overlap};
use crate::config::{Case, Motion};
use std::path::Path;

/// Whether a file is a run's own `particles.csv`.
pub(super) fn is_of_run(file: &Path) -> bool {
    file.file_name().is_some_and(|name| name == "particles.csv")
        && file.with_file_name("case.toml").is_file()
}

/// Appends the bodies of a run as they were at its end, moved as the swarm says.
pub(super) fn append(
    case: &mut Case,
    swarm: &Swarm,
    file: &Path,
    key: &str,
    read: ReadBodies,
) -> Check {
    let run = file.parent().unwrap_or(Path::new(""));
    let own = swarm.shape.is_some() || swarm.shapes.is_some() || swarm.orientations.is_some();
    ensure!(
        !own,
        key,
        "that run says what shapes its bodies have and how they are turned: remove shape, shapes \
        and orientations"
    );
    let first = case.particle.len();
    let dimension = case.dimension();
    for mut body in begin::bodies(run, dimension, key, read)? {
        body.name = swarm.name.clone();
        body.material = swarm.material.clone().or(body.material);
        body.motion = swarm.motion.clone().unwrap_or(body.motion);
        body.locked = swarm.locked.clone();
        if body.motion != Motion::Free {
            body.velocity = None;
            body.spin = None;
        }
        below_periods(case, key, body.shape.bounding_diameter())?;
        let who = format!("{}: particle {}", file.display(), case.particle.len() - first);
        inside(case, key, &who, &body)?;
        case.particle.push(body);
    }
    if let Some(Overlap { first, second, words }) = overlap(case) {
        ensure!(
            false,
            key,
            "{}: particle {second} overlaps particle {first}: {words}",
            file.display()
        );
    }
    Ok(())
}
