//! Options of `mics plot`, and the checks that they do not contradict each other.

use super::View;
use mics_run::{Error, Result};
use std::path::PathBuf;

/// Options of `mics plot`. Without figures: the last state, forces, speeds and paths of each run,
/// Cd(Re) and St(Re) of all; or vorticity and streamlines alone, where times or a plane, a window
/// or a size say something of the flow.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct Request {
    /// Run folders.
    #[arg(required = true)]
    pub runs: Vec<PathBuf>,
    /// Draw this figure only; several with commas.
    #[arg(long = "figure", value_name = "FIGURE", value_delimiter = ',')]
    pub figures: Vec<Figure>,
    /// Times (s) of a strip's panels, or the one of a picture of the flow, e.g. 0.1,0.2,0.3:
    /// the nearest snapshots, of convergence the nearest step; without --figure and --field of
    /// vorticity and streamlines [default: of a strip six from start to end, else the last].
    #[arg(long, value_name = "TIMES", value_delimiter = ',', allow_negative_numbers = true)]
    pub times: Vec<f64>,
    /// Vorticity (1/s) from one contour line of vorticity-strip to the next [default: a round
    /// one].
    #[arg(long, value_name = "VALUE", allow_negative_numbers = true)]
    pub interval: Option<f64>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub view: View,
    /// Direction from the box to the eye of --figure solids, of any length [default: from before
    /// it, above and to the left: -0.6,-1,0.6 where z is up].
    #[arg(long, value_name = "X,Y,Z", value_delimiter = ',', allow_hyphen_values = true)]
    pub eye: Vec<f64>,
    /// Draw these columns of the tables of a run (docs/output.md names them), of steps.csv, of
    /// particles and obstacles or of profile.csv: wx,wy in two panels, pressure_fx+viscous_fx in
    /// one.
    #[arg(long, value_name = "COLUMN", value_delimiter = ',')]
    pub columns: Vec<String>,
    /// The column that --columns are over [default: time, or the first of their table].
    #[arg(long, value_name = "COLUMN")]
    pub over: Option<String>,
    /// Draw paths, loads, speeds and columns of this particle only, by its number (from 0) or its
    /// name, or loads and columns of the obstacle of a name; several with commas [default: all, of
    /// more than seven by material and size].
    #[arg(long = "particle", value_name = "PARTICLE", value_delimiter = ',')]
    pub particles: Vec<String>,
    /// Draw loads, speeds and columns of several runs, as of several seeds, as their mean with the
    /// area that they spread over.
    #[arg(long)]
    pub mean: bool,
    /// Where figures go that are named or of several runs [default: figures/ of the run, of
    /// several the first].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// A figure that can be asked for by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Figure {
    /// Vorticity and streamlines of the last state.
    Vorticity,
    /// Streamlines of the last state, coloured by speed.
    Streamlines,
    /// The colours of --field alone, with bodies coloured by --bodies and marked so that their
    /// turning shows; beside each other at several --times.
    Field,
    /// Vorticity at several times, with contour lines that are dashed where it is negative (Figs.
    /// 7, 11, 14).
    VorticityStrip,
    /// Streamlines at several times (Fig. 6).
    StreamlinesStrip,
    /// Bodies and obstacles of a 3D run as shaded surfaces, bodies coloured by --bodies, seen from
    /// --eye.
    Solids,
    /// Paths of particles in their box, of all runs in one picture, beside the band of a position
    /// measure (Fig. 9).
    Paths,
    /// Forces on particles and obstacles over time, of all runs in one picture: of few a line each,
    /// of many by material and size.
    Forces,
    /// Torques on particles and obstacles over time, as forces.
    Torques,
    /// Velocities of free particles over time, of all runs in one picture: of few a line each, of
    /// many by material and size.
    Speeds,
    /// The columns of --columns, of all runs in one picture.
    Columns,
    /// Mean velocity and solid fraction across layers of cells, where the case has
    /// `statistics.profile`.
    Profile,
    /// Velocity and pressure over time at probes of one point, where the case has some.
    Probes,
    /// Mean velocity and pressure along probes of several points, where the case has some.
    ProbeLines,
    /// Residuals of the pressure solves of the last step that has a history, or of the one next to
    /// --times, and |D| over their C-HSMAC iterations, where the case has `pressure.history`; of
    /// all runs in one picture.
    Convergence,
    /// Iterations of the pressure and |D| over the steps, of all runs in one picture.
    ConvergenceSteps,
    /// Drag coefficient over Re of all runs, beside the references of their cases; of one body in
    /// an unbounded stream beside a formula (Fig. 4).
    Drag,
    /// Strouhal number over Re of all runs, beside the references of their cases (Fig. 5).
    Strouhal,
}

impl Figure {
    /// Its name on the command line.
    pub(super) fn name(self) -> String {
        clap::ValueEnum::to_possible_value(&self)
            .map_or_else(String::new, |value| value.get_name().to_owned())
    }

    /// The stem of the files of a figure of curves.
    pub(super) fn file(self) -> &'static str {
        match self {
            Figure::Paths => "paths",
            Figure::Forces => "forces",
            Figure::Torques => "torques",
            Figure::Speeds => "speeds",
            Figure::Profile => "profile",
            Figure::Probes => "probes",
            Figure::ProbeLines => "probe_lines",
            Figure::Convergence => "convergence",
            Figure::ConvergenceSteps => "convergence_steps",
            Figure::Drag => "drag_over_reynolds",
            Figure::Strouhal => "strouhal_over_reynolds",
            _ => "columns",
        }
    }

    fn is_strip(self) -> bool {
        matches!(self, Figure::VorticityStrip | Figure::StreamlinesStrip)
    }

    fn is_of_the_flow(self) -> bool {
        self.is_strip() || matches!(self, Figure::Vorticity | Figure::Streamlines | Figure::Field)
    }

    fn is_of_particles(self) -> bool {
        self.is_averaged() || self == Figure::Paths
    }

    /// Whether it can be a mean of runs.
    fn is_averaged(self) -> bool {
        matches!(self, Figure::Forces | Figure::Torques | Figure::Speeds | Figure::Columns)
    }

    /// Whether several runs make one picture.
    pub(super) fn joins_runs(self) -> bool {
        !self.is_of_the_flow() && self != Figure::Solids
    }

    /// Contents of a run that it needs, for messages.
    pub(super) fn needs(self) -> &'static str {
        match self {
            Figure::Vorticity
            | Figure::Streamlines
            | Figure::Field
            | Figure::VorticityStrip
            | Figure::StreamlinesStrip => "fields",
            Figure::Solids => "three dimensions, a particle or an obstacle, and fields",
            Figure::Paths => "a particle that moves, and its rows in particles.csv",
            Figure::Forces | Figure::Torques => {
                "a particle or an obstacle, and its rows in particles.csv or obstacles.csv"
            }
            Figure::Speeds => "a free particle, and its rows in particles.csv",
            Figure::Columns => "--columns with two rows or more",
            Figure::Profile => "statistics with a profile (profile.csv)",
            Figure::Probes => "a [[probe]] of one point (probes.csv)",
            Figure::ProbeLines => "a [[probe]] of several points (probes.csv)",
            Figure::Convergence => {
                "the history of its solves (solves.csv): run it with --set pressure.history=true; \
                convergence-steps needs none"
            }
            Figure::ConvergenceSteps => "two steps or more (steps.csv)",
            Figure::Drag => "a measure of kind \"drag_coefficient\" with a value in summary.json",
            Figure::Strouhal => "a measure of kind \"strouhal\" with a value in summary.json",
        }
    }
}

impl Request {
    /// The figures that are asked for by name, or by what they show.
    pub(super) fn figures(&self) -> Vec<Figure> {
        let view = &self.view;
        if !self.figures.is_empty() {
            return self.figures.clone();
        }
        if !self.columns.is_empty() {
            return vec![Figure::Columns];
        }
        if view.field.is_some() || view.bodies.is_some() {
            return vec![Figure::Field];
        }
        // Options of the flow are of its usual figures; a range would have to be that of vorticity
        // or of speed.
        let of_the_flow = !self.times.is_empty()
            || view.plane.is_some()
            || !view.window.is_empty()
            || view.size.is_some();
        match self.times.len() {
            _ if !of_the_flow || !view.range.is_empty() => Vec::new(),
            0 | 1 => vec![Figure::Streamlines, Figure::Vorticity],
            _ => vec![Figure::StreamlinesStrip, Figure::VorticityStrip],
        }
    }

    /// Refuses options that contradict each other or the figures that are asked for.
    pub(super) fn check(&self) -> Result<()> {
        let figures = self.figures();
        let single = figures.iter().find(|figure| !figure.joins_runs());
        if let (Some(figure), Some(out), 2..) = (single, &self.out, self.runs.len()) {
            return refuse(format!(
                "--out {}: {} is of one run, and there are {}; leave --out away, and each goes to \
                its run's figures/",
                out.display(),
                figure.name(),
                self.runs.len()
            ));
        }
        self.check_options_of_the_flow(&figures)?;
        self.view.check()?;
        if !self.particles.is_empty() && !figures.iter().any(|figure| figure.is_of_particles()) {
            return refuse(
                "--particle is of curves; ask for --figure paths, forces, torques or speeds, or \
                for --columns"
                    .into(),
            );
        }
        if figures.contains(&Figure::Columns) == self.columns.is_empty() {
            return refuse(
                "--columns and --figure columns go together; leave --figure away".into(),
            );
        }
        if self.over.is_some() && self.columns.is_empty() {
            return refuse("--over is of --columns; add them".into());
        }
        let averages = figures.iter().any(|figure| figure.is_averaged());
        if self.mean && (!averages || self.runs.len() < 2) {
            return refuse(
                "--mean is of several runs; give two or more and --figure forces, torques or \
                speeds, or --columns"
                    .into(),
            );
        }
        if let Some(time) = self.times.iter().find(|time| !time.is_finite()) {
            return refuse(format!("--times {time}: a time is a number of seconds"));
        }
        if let Some(interval) =
            self.interval.filter(|interval| !(*interval > 0.0 && interval.is_finite()))
        {
            return refuse(format!("--interval {interval}: has to be positive, in 1/s"));
        }
        Ok(())
    }

    /// Refuses what is said of the flow where no such figure is asked for.
    fn check_options_of_the_flow(&self, figures: &[Figure]) -> Result<()> {
        let view = &self.view;
        let of_the_flow =
            "ask for --figure field, vorticity, streamlines, vorticity-strip or streamlines-strip";
        let shows_the_flow = figures.iter().any(|figure| figure.is_of_the_flow());
        let solids = figures.contains(&Figure::Solids);
        let timed = shows_the_flow || solids || figures.contains(&Figure::Convergence);
        if !self.times.is_empty() && !timed {
            return refuse(format!("--times are of the flow; {of_the_flow}, or convergence"));
        }
        if self.times.len() > 1
            && !figures.iter().any(|figure| figure.is_strip() || *figure == Figure::Field)
        {
            return refuse(
                "--times: several are of a strip; ask for --figure vorticity-strip, \
                streamlines-strip or field"
                    .into(),
            );
        }
        if self.interval.is_some() && !figures.contains(&Figure::VorticityStrip) {
            return refuse(
                "--interval is of contour lines; ask for --figure vorticity-strip".into(),
            );
        }
        let options = [
            ("--window", !view.window.is_empty()),
            ("--plane", view.plane.is_some()),
            ("--range", !view.range.is_empty()),
            ("--size", view.size.is_some()),
        ];
        if let Some((option, _)) = options.iter().find(|(_, given)| *given && !shows_the_flow) {
            return refuse(format!("{option} is of the flow; {of_the_flow}"));
        }
        let coloured = figures.contains(&Figure::Field);
        if view.field.is_some() && !coloured {
            return refuse("--field is of --figure field; add it, or leave --figure away".into());
        }
        if view.bodies.is_some() && !coloured && !solids {
            return refuse(
                "--bodies is of --figure field and solids; add one, or leave --figure away".into(),
            );
        }
        if !self.eye.is_empty() {
            let is_direction = self.eye.len() == 3
                && self.eye.iter().all(|x| x.is_finite())
                && self.eye.iter().any(|x| *x != 0.0);
            if !is_direction {
                return refuse(format!(
                    "--eye {:?}: give a direction X,Y,Z, as in --eye=-1,-2,1",
                    self.eye
                ));
            }
            if !solids {
                return refuse("--eye is of --figure solids; add it".into());
            }
        }
        Ok(())
    }
}

fn refuse(why: String) -> Result<()> {
    Err(Error::Usage(why))
}
