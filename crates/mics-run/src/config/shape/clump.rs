//! A clump of discs (2D) or spheres (3D), listed or in a file.

use super::{Described, Reader};
use crate::config::fault::{Fault as Refusal, positive};
use crate::config::source::{Source, factor, named, one_of};
use mics_shapes::{Fault, Shape as Geometry};
use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A clump: exactly one of `discs` (2D), `spheres` (3D) and `file`.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Clump {
    /// Its discs.
    pub discs: Option<Vec<Ball>>,
    /// Its spheres.
    pub spheres: Option<Vec<Ball>>,
    /// A CSV file of them, relative to the case file, with columns x, y (z in 3D) and diameter.
    pub file: Option<String>,
    /// Factor on the file's lengths (0.001 for mm), default 1.
    pub scale: Option<f64>,
    /// Diameter of the disc or sphere of its volume (m), to which it is scaled; default as it is.
    pub diameter: Option<f64>,
}

/// A disc or sphere of a clump.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ball {
    /// Its centre (m).
    pub at: Vec<f64>,
    /// Its diameter (m).
    pub diameter: f64,
}

impl Described for Clump {
    fn dimension(&self) -> Option<usize> {
        None
    }

    fn file(&self) -> Option<&str> {
        self.file.as_deref()
    }

    fn read(self, reader: &mut Reader, key: &str) -> Result<Clump, Refusal> {
        let Clump { discs, spheres, file, scale, .. } = self;
        let (own, other) =
            if reader.dimension == 2 { ("discs", "spheres") } else { ("spheres", "discs") };
        let [(own_balls, other_balls)] =
            [if reader.dimension == 2 { (discs, spheres) } else { (spheres, discs) }];
        ensure!(
            other_balls.is_none(),
            format!("{key}.{other}"),
            "discs are for 2D, spheres for 3D; this case is {}D: give {own}",
            reader.dimension
        );
        one_of(key, &[(own, own_balls.is_some()), ("file", file.is_some())])?;
        let factor = factor(key, scale, file.is_some())?;
        let balls = match file {
            None => own_balls.unwrap_or_default(),
            Some(file) => {
                let path = reader.folder.join(named(&file, key)?);
                let key = format!("{key}.file");
                let source = Source { path: &path, key: &key };
                let columns: &[&str] = match reader.dimension {
                    2 => &["x", "y", "diameter"],
                    _ => &["x", "y", "z", "diameter"],
                };
                let rows = source.rows(columns, own)?;
                let ball = |(line, row): (u64, Vec<f64>)| {
                    let (at, diameter) = row.split_at(reader.dimension);
                    let diameter = factor * diameter[0];
                    if diameter > 0.0 {
                        return Ok(Ball { at: at.iter().map(|x| factor * x).collect(), diameter });
                    }
                    let what = format!("column `diameter` must be positive (m), not {diameter:?}");
                    Err(source.refuse_line(line, &what))
                };
                rows.into_iter().map(ball).collect::<Result<_, _>>()?
            }
        };
        let holds = !balls.is_empty();
        ensure!(holds, format!("{key}.{own}"), "is empty: give one at least");
        for (k, Ball { at, diameter }) in balls.iter().enumerate() {
            let key = format!("{key}.{own}.{k}");
            crate::config::fault::vector(&format!("{key}.at"), at, reader.dimension, "m")?;
            positive(&format!("{key}.diameter"), *diameter, "m")?;
        }
        let balls = Some(balls);
        Ok(match reader.dimension {
            2 => Clump { discs: balls, ..Clump::default() },
            _ => Clump { spheres: balls, ..Clump::default() },
        })
    }

    fn solid(&self) -> Result<Arc<dyn Geometry>, Fault> {
        let ball = |ball: &Ball| {
            let at = Vector3::from_fn(|a, _| ball.at.get(a).copied().unwrap_or(0.0));
            (at, 0.5 * ball.diameter)
        };
        let dimension = if self.discs.is_some() { 2 } else { 3 };
        let balls: Vec<_> = self.discs.iter().chain(&self.spheres).flatten().map(ball).collect();
        Ok(Arc::new(mics_shapes::Clump::new(dimension, &balls)?))
    }

    fn detail(&self) -> String {
        let balls = |of: &Option<Vec<Ball>>| of.as_ref().map_or(0, Vec::len);
        match self.discs {
            Some(_) => format!(" of {} discs", balls(&self.discs)),
            None => format!(" of {} spheres", balls(&self.spheres)),
        }
    }
}
