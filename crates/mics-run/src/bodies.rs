//! Bodies as ParaView opens them (`.vtp`): a point at each centre with what a glyph of it needs,
//! and the surfaces of those that are not round, beside the fields of the same time. With the key
//! `output.surfaces` there are the surfaces of all, with pressure and shear.
//!
//! ```text
//!   id, radius (m), diameter (m), velocity (m/s), spin (rad/s), force (N), orientation (w, x, y,
//! z); pressure (Pa), shear (Pa)
//!              a sphere: Glyph, scaled by radius, which is 0 of what is not round
//!              the others: their surfaces, whose points have the velocity there
//!              pressure, shear: on the surface; at a centre their means over it
//! ```

use crate::{Error, Result};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Beginning of the names of files with bodies, before the number of their step.
pub const PREFIX: &str = "bodies-";

/// Beginning of the names of files with the surfaces of obstacles: one file where none moves; where
/// any does, the number of the step follows.
pub const OBSTACLES: &str = "obstacles";

/// Where a body is at a moment.
#[derive(Clone, Copy, Debug)]
pub struct Pose {
    /// Its centre (m).
    pub centre: [f64; 3],
    /// Speed of its centre (m/s).
    pub speed: f64,
    /// Its rotation since the start, where that is known.
    pub orientation: Option<UnitQuaternion<f64>>,
}

impl Pose {
    /// The pose of a body of which only the centre (m) is known.
    pub fn at(centre: [f64; 3]) -> Pose {
        Pose { centre, speed: 0.0, orientation: None }
    }
}

/// The file with the bodies of a snapshot's moment.
pub fn beside(snapshot: &Path) -> PathBuf {
    let mut name = std::ffi::OsString::from(PREFIX);
    name.push(snapshot.file_stem().unwrap_or_default());
    name.push(".vtp");
    snapshot.with_file_name(name)
}

/// Reads the bodies of a snapshot's moment, by their numbers in a case of so many particles: these,
/// and after them all obstacles where any of them moves.
///
/// # Errors
/// As those of [`read`].
pub fn of(snapshot: &Path, particles: usize) -> Result<HashMap<usize, Pose>> {
    let mut all = read(&beside(snapshot))?;
    let step = snapshot.file_stem().unwrap_or_default().to_string_lossy();
    let obstacles = read(&snapshot.with_file_name(format!("{OBSTACLES}-{step}.vtp")))?;
    // The file lists all obstacles; older versions number them after the particles.
    let first = obstacles.keys().copied().min().unwrap_or(0);
    all.extend(obstacles.into_iter().map(|(id, pose)| (particles + id - first, pose)));
    Ok(all)
}

/// Reads the bodies of a file, by their numbers; none where there is no file, since a moment
/// without bodies has no file.
///
/// # Errors
/// When the file cannot be read or is not of that form.
pub fn read(path: &Path) -> Result<HashMap<usize, Pose>> {
    match std::fs::read_to_string(path) {
        Ok(text) => parse(&text).ok_or_else(|| {
            Error::Usage(format!(
                "{}: not bodies that mics wrote; run the case again",
                path.display()
            ))
        }),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(HashMap::new()),
        Err(e) => Err(Error::io(path)(e)),
    }
}

fn parse(text: &str) -> Option<HashMap<usize, Pose>> {
    let numbers = |name: &str| -> Option<Vec<f64>> {
        let from = text.find(&format!("Name=\"{name}\""))?;
        let values = text[from..].split(['>', '<']).nth(1)?;
        values.split_ascii_whitespace().map(|number| number.parse().ok()).collect()
    };
    let [ids, velocity, turned, centres] =
        [numbers("id")?, numbers("velocity")?, numbers("orientation")?, numbers("Points")?];
    // Points of surfaces follow those at the centres.
    let count = text.split("NumberOfVerts=\"").nth(1)?.split('"').next()?.parse().ok()?;
    let pose = |(k, id): (usize, &f64)| {
        let [v, at] = [&velocity, &centres]
            .map(|all| all.get(3 * k..3 * k + 3).map(Vector3::from_column_slice));
        let q = turned.get(4 * k..4 * k + 4)?;
        let orientation =
            Some(UnitQuaternion::from_quaternion(Quaternion::new(q[0], q[1], q[2], q[3])));
        Some((*id as usize, Pose { centre: at?.into(), speed: v?.norm(), orientation }))
    };
    ids.iter().enumerate().take(count).map(pose).collect()
}
