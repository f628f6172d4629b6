//! `mics film`: a run as an animated PNG or a GIF, a frame a snapshot of its fields, or some of the
//! frames beside each other for a paper.

use crate::figure;
use crate::figure::Format;
use crate::plot::{Reel, Run, View, dated, evenly, nearest, newest_snapshot, numbered};
use mics_run::file::replace_by;
use mics_run::interrupt::Interrupt;
use mics_run::not_a_run;
use mics_run::{Error, Result};
use std::fs;
use std::path::{Path, PathBuf};

/// Frames a second.
const RATE: f64 = 10.0;
/// The slowest and the fastest that can be asked for.
const RATES: [f64; 2] = [0.1, 100.0];
/// Pixels of the longer side of the flow.
const SIZE: u32 = 600;
/// Snapshots that make a good film, for advice.
const GOOD: f64 = 50.0;

/// Options of `mics film`.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct Request {
    /// The run's folder.
    pub run: PathBuf,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub view: View,
    /// Begin with the snapshot next to this time (s) [default: the first].
    #[arg(long, value_name = "TIME", allow_negative_numbers = true)]
    pub from: Option<f64>,
    /// End with the snapshot next to this time (s) [default: the last].
    #[arg(long, value_name = "TIME", allow_negative_numbers = true)]
    pub to: Option<f64>,
    /// Frames a second [default: 10].
    #[arg(long, value_name = "RATE", allow_negative_numbers = true, conflicts_with = "strip")]
    pub fps: Option<f64>,
    /// Instead of a film, so many of its frames beside each other as one picture, PNG and SVG.
    #[arg(long, value_name = "FRAMES")]
    pub strip: Option<usize>,
    /// The file, FILE.png or FILE.gif, of several planes FILE_2.png as well [default:
    /// figures/FIELD_film.png of the run, of a strip FIELD_frames.png].
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
}

/// Makes the film or the strip that is asked for, one for each plane that figures of the run show;
/// returns the files.
///
/// # Errors
/// When the request contradicts itself, the folder does not hold a run with two snapshots in that
/// time, a file is damaged or cannot be written, or somebody interrupts; no part of a film is left
/// then.
pub fn make(request: &Request) -> Result<Vec<PathBuf>> {
    request.check()?;
    let run = Run::read(&request.run, &[])?;
    let mut frames = request.frames(&run)?;
    if let Some(count) = request.strip {
        if count > frames.len() {
            return Err(Error::Usage(format!(
                "--strip {count}: there are {} snapshots; give {} at most, or {}",
                frames.len(),
                frames.len(),
                cure(&run)
            )));
        }
        frames = evenly(frames.len(), count).map(|k| frames[k].clone()).collect();
    }
    let view = View {
        size: request.view.size.or(request.strip.is_none().then_some(SIZE)),
        ..request.view.clone()
    };
    let reels = Reel::of(&run, &view, &frames)?;
    let mut written = Vec::new();
    for (number, reel) in reels.iter().enumerate().rev() {
        let stem =
            |kind: &str| Ok::<_, Error>(numbered(&request.stem(&run, &reel.name(kind))?, number));
        match request.strip {
            Some(_) => written.extend(reel.picture(&stem("frames")?)?),
            None => {
                let path = stem("film")?;
                let name = path.file_name().unwrap_or_default().to_string_lossy();
                let path = path.with_file_name(format!("{name}.{}", request.ending()));
                film(reel, &path, request.fps.unwrap_or(RATE))?;
                written.push(path);
            }
        }
    }
    Ok(written)
}

/// Writes a film as a whole or not at all.
fn film(reel: &Reel, path: &Path, rate: f64) -> Result<()> {
    let interrupt = Interrupt::listen()?;
    let frame = |k: usize| match interrupt.asked() {
        true => {
            Err(Error::Interrupted(format!("{}: interrupted, and not written", path.display())))
        }
        false => reel.titled(k),
    };
    // Numbers do not get shorter, so that the last title is the widest.
    let widest = reel.titled(reel.len().saturating_sub(1))?.title;
    let format = if path.extension().is_some_and(|ending| ending == "gif") {
        Format::Gif
    } else {
        Format::Png
    };
    replace_by(path, |file| {
        figure::film(file, format, path, (0..reel.len()).map(frame), reel.len(), &widest, rate)
    })
}

impl Request {
    fn check(&self) -> Result<()> {
        let refuse = |why: String| Err(Error::Usage(why));
        self.view.check()?;
        for (name, time) in [("--from", self.from), ("--to", self.to)] {
            if let Some(time) = time.filter(|time| !time.is_finite()) {
                return refuse(format!("{name} {time}: a time is a number of seconds"));
            }
        }
        if let Some((from, to)) = self.from.zip(self.to).filter(|(from, to)| from >= to) {
            return refuse(format!("--from {from} --to {to}: a film ends after it begins"));
        }
        let [slowest, fastest] = RATES;
        if let Some(rate) = self.fps.filter(|rate| !(slowest..=fastest).contains(rate)) {
            return refuse(format!("--fps {rate}: give {slowest} to {fastest} frames a second"));
        }
        if let Some(count) = self.strip.filter(|count| *count < 2) {
            return refuse(format!(
                "--strip {count}: a strip has two frames or more; of one: mics plot --figure field"
            ));
        }
        let Some(out) = &self.out else { return Ok(()) };
        if out.is_dir() {
            return refuse(format!(
                "{}: is a folder; give --out a file, as in --out film.png",
                out.display()
            ));
        }
        let ending = out.extension().unwrap_or_default();
        if ending != "png" && (!(ending == "apng" || ending == "gif") || self.strip.is_some()) {
            let example = out.with_extension("png");
            return refuse(format!(
                "--out {}: films are animated PNG or GIF, and strips PNG; give a name that ends in \
                .png, as in --out {}, or of a film in .gif",
                out.display(),
                example.display()
            ));
        }
        Ok(())
    }

    /// The ending of a film's name.
    fn ending(&self) -> &str {
        self.out.as_ref().and_then(|out| out.extension()?.to_str()).unwrap_or("png")
    }

    /// The snapshots of the time that is asked for, with their times (s): two or more.
    fn frames(&self, run: &Run) -> Result<Vec<(f64, PathBuf)>> {
        let folder = run.folder.display();
        if !run.folder.join("fields").is_dir() {
            return Err(not_a_run(&run.folder, "it has no fields/"));
        }
        // A run without any is one of too few, and has the same cure.
        let all =
            if newest_snapshot(&run.folder).is_ok() { dated(&run.folder)? } else { Vec::new() };
        let (Some((first, _)), Some((last, _)), 2..) = (all.first(), all.last(), all.len()) else {
            let there = if all.is_empty() {
                "no snapshot".to_owned()
            } else {
                "one snapshot only".to_owned()
            };
            return Err(Error::Usage(format!(
                "{folder}: fields/ holds {there} and a film needs two or more; {}",
                cure(run)
            )));
        };
        let from = self.from.unwrap_or(*first);
        let to = self.to.unwrap_or(*last);
        // The snapshots of a moment are of the step next to it, as they are for `mics plot
        // --times`.
        let within = match from <= *last && to >= *first {
            true => &all[nearest(&all, from)..=nearest(&all, to)],
            false => &[],
        };
        if within.len() < 2 {
            let asked = [("--from", self.from), ("--to", self.to)];
            let asked =
                asked.iter().filter_map(|(name, time)| Some(format!("{name} {}", (*time)?)));
            let asked = asked.collect::<Vec<_>>().join(" ");
            return Err(Error::Usage(format!(
                "{asked}: {} of the {} snapshots of {folder}, from {first} to {last} s, lie there, \
                and a film needs two; give other times, or {}",
                within.len(),
                all.len(),
                cure(run)
            )));
        }
        Ok(within.to_vec())
    }

    /// The file's name without its ending.
    fn stem(&self, run: &Run, name: &str) -> Result<PathBuf> {
        if let Some(out) = &self.out {
            return Ok(out.with_extension(""));
        }
        let folder = run.folder.join("figures");
        fs::create_dir_all(&folder).map_err(Error::io(&folder))?;
        Ok(folder.join(name))
    }
}

/// Advice on how a run gets the snapshots that a film needs.
fn cure(run: &Run) -> String {
    let end = run.case.time.end;
    let least = end / GOOD;
    let power = 10f64.powf(least.log10().floor());
    let round = [1.0, 2.0, 5.0, 10.0]
        .map(|part| part * power)
        .into_iter()
        .find(|round| *round >= least * (1.0 - 1e-9));
    let round = round.unwrap_or(least);
    // As a decimal of few digits: 0.02, and not 0.020000000000000004.
    let digits = (-power.log10().floor()).max(0.0) as usize;
    let every = format!("{round:.digits$}").parse().unwrap_or(round);
    format!(
        "run the case again with output.fields = {{ every_time = {every} }}, about {:.0} frames of \
        its {end} s, as in --set output.fields.every_time={every}",
        end / round
    )
}
