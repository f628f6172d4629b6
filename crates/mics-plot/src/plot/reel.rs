//! Frames of one plane of a run in the same colours: what films, strips of them and single pictures
//! of a field are made of.

use super::discs::{Bodies, Colours};
use super::fields::{self, Look};
use super::{Run, View, numbered};
use crate::figure::{self, Plane};
use mics_run::Result;
use mics_run::config::Section;
use mics_run::snapshot::Snapshot;
use mics_run::{bodies, not_a_run};
use std::path::{Path, PathBuf};

/// Cells along each axis of a plane that the range of colours is found from, at most.
const SAMPLED: usize = 64;

/// Frames of a run in one plane.
pub struct Reel<'a> {
    run: &'a Run,
    view: &'a View,
    /// The snapshots and their times (s).
    frames: &'a [(f64, PathBuf)],
    section: Section,
    look: Look,
    style: figure::Style,
}

impl<'a> Reel<'a> {
    /// Reels of some snapshots with their times (s), one for each plane that figures show as things
    /// lie in the last of them. The range of colours, where it is not given, is found over all of
    /// them.
    ///
    /// # Errors
    /// When the view does not fit the run, or a file is missing or damaged.
    pub fn of(run: &'a Run, view: &'a View, frames: &'a [(f64, PathBuf)]) -> Result<Vec<Reel<'a>>> {
        view.fits(run)?;
        let index = run.folder.join("fields/bodies.pvd");
        if !run.case.particle.is_empty() && !index.exists() {
            return Err(not_a_run(
                &run.folder,
                "fields/bodies.pvd is missing, which says where the particles are",
            ));
        }
        let by = view.bodies.unwrap_or_default();
        let mut fastest: f64 = 0.0;
        for (_, path) in frames.iter().filter(|_| by == Bodies::Speed) {
            fastest = bodies::of(path, run.case.particle.len())?
                .values()
                .map(|pose| pose.speed)
                .fold(fastest, f64::max);
        }
        let times: Vec<f64> = frames.iter().map(|(time, _)| *time).collect();
        let look = Look {
            quantity: view.field.unwrap_or_default(),
            colours: Some(Colours::of(by, &run.case, fastest)),
            digits: fields::digits(&times),
        };
        let sections = match (view.plane, frames.last()) {
            (None, Some((_, last))) => {
                let poses = bodies::of(last, run.case.particle.len())?;
                fields::sections(&run.case, |id| poses.get(&id).copied())
            }
            (plane, _) => plane.into_iter().collect(),
        };
        let style = view.style();
        let reel = |section| {
            let mut reel = Reel { run, view, frames, section, look, style };
            if style.range.is_none() {
                let planes = (0..frames.len())
                    .map(|k| Ok(reel.plane(k)?.sampled(SAMPLED)))
                    .collect::<Result<Vec<_>>>()?;
                reel.style.range =
                    Some(figure::shared_range(look.quantity, &planes.iter().collect::<Vec<_>>()));
            }
            Ok(reel)
        };
        sections.into_iter().map(reel).collect()
    }

    /// Number of its frames.
    pub fn len(&self) -> usize {
        self.frames.len()
    }

    /// A frame, its time as its title.
    ///
    /// # Errors
    /// When its file is damaged, or lacks what is shown.
    pub fn plane(&self, k: usize) -> Result<Plane> {
        let path = self.frames.get(k).map(|(_, path)| path.clone()).unwrap_or_default();
        let snapshot = Snapshot::read(&path)?;
        let poses = bodies::of(&path, self.run.case.particle.len())?;
        let place = |id: usize| poses.get(&id).copied();
        let plane = fields::plane(
            &self.run.case,
            &snapshot,
            &self.run.folder,
            self.section,
            &place,
            &self.look,
        )?;
        let style = self.style;
        self.view.part(Plane { style, ..plane })
    }

    /// A frame, titled by the run's name, its time and its place.
    ///
    /// # Errors
    /// As those of [`Reel::plane`].
    pub fn titled(&self, k: usize) -> Result<Plane> {
        let plane = self.plane(k)?;
        let title = format!("{}, {}{}", self.run.case.name, plane.title, plane.place);
        Ok(Plane { title, ..plane })
    }

    /// Draws its only frame, or all of them beside each other. Writes `STEM.png` and `STEM.svg`.
    ///
    /// # Errors
    /// As those of [`Reel::plane`], and when a file cannot be written.
    pub fn picture(&self, stem: &Path) -> Result<[PathBuf; 2]> {
        if self.frames.len() == 1 {
            return figure::field(&self.titled(0)?, stem);
        }
        let planes = (0..self.frames.len()).map(|k| self.plane(k)).collect::<Result<Vec<_>>>()?;
        let place = planes.first().map_or("", |plane| &plane.place);
        figure::field_strip(&planes, &format!("{}{place}", self.run.case.name), stem)
    }

    /// Name of a file of it: by the quantity that it shows, and by `kind`.
    pub fn name(&self, kind: &str) -> String {
        format!("{}_{kind}", self.look.quantity.name())
    }
}

/// Draws the pictures of some reels, one for each plane, into a folder; the first plane's come
/// last.
///
/// # Errors
/// As those of [`Reel::picture`].
pub fn pictures(reels: &[Reel], folder: &Path) -> Result<Vec<PathBuf>> {
    let mut written = Vec::new();
    for (number, reel) in reels.iter().enumerate().rev() {
        let kind = if reel.frames.len() == 1 { "field" } else { "frames" };
        written.extend(reel.picture(&numbered(&folder.join(reel.name(kind)), number))?);
    }
    Ok(written)
}
