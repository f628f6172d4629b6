//! Cell-centred geometric multigrid, one symmetric cycle an application, so that conjugate
//! gradients may be used:
//!
//! ```text
//!   level 0   s . . . . . . . . . . . . . s      s  smoothing ([`super::level`])
//!   level 1     s . . . . . . . . . . . s
//!              the levels from 2 on are visited twice each time: iterations then do
//!   level 2       s . . . s s . . . s     not grow with the grid, at the cost of small levels only
//!   coarsest        e   e     e   e              e  exact, by the dense inverse
//! ```
//! Axes are coarsened while they are the finely divided ones, so that flat cells become square
//! first. Every rank coarsens its own box; once boxes are small, some beside each other are merged
//! ([`super::merged`]) and fewer ranks go on, one in the end. Levels that resolve bodies are never
//! merged: a merged level knows none.

use super::bodies::Bodies;
use super::bottom::Dense;
use super::lattice::Lattice;
use super::level::{Level, Single};
use super::merged::{self, Merge};
use super::sweeps::{self, Pass};
use super::whole::Whole;
use crate::petsc::Session;
use crate::{Error, Result};
use std::f64::consts::PI;

/// Settings of the multigrid, the options `-pc_boxmg_*`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tuning {
    /// Sweeps before and after the coarser level: the degree of the polynomial.
    pub smooth: usize,
    /// Levels at most.
    pub levels: usize,
    /// First level that is visited twice.
    pub twice_from: usize,
    /// Cells below which a level is solved exactly.
    pub exact: usize,
}

/// Most cells that are solved exactly: the inverse is dense.
const MOST_EXACT: usize = 256;

/// The lower end of what smoothing damps; the upper is 2.
const SMOOTH_FROM: f64 = 0.4;

impl Tuning {
    /// Reads the settings from PETSc's options.
    pub fn read(session: &Session) -> Result<Tuning> {
        let number = |name: &str, default: usize, least: usize, most: usize| {
            let Some(text) = session.used_option(name)? else { return Ok(default) };
            match text.parse() {
                Ok(n) if (least..=most).contains(&n) => Ok(n),
                _ => Err(Error::Usage(format!(
                    "PETSc option {name}: {text:?} is not a whole number from {least} to {most}"
                ))),
            }
        };
        let twice_from = match session.used_option("-pc_boxmg_cycle")?.as_deref() {
            None => 2,
            Some("w") => 1,
            Some("v") => usize::MAX,
            Some(other) => {
                return Err(Error::Usage(format!(
                    "PETSc option -pc_boxmg_cycle: {other:?} is neither v nor w; without it levels \
                    from the third on are visited twice"
                )));
            }
        };
        Ok(Tuning {
            smooth: number("-pc_boxmg_smooth", 3, 1, 20)?,
            levels: number("-pc_boxmg_levels", 30, 1, 30)?,
            twice_from,
            exact: number("-pc_boxmg_exact", 24, 1, MOST_EXACT)?,
        })
    }
}

/// Treatment of this rank's last level.
enum Bottom {
    Exact(Dense),
    /// Fewer ranks go on.
    Merged(Box<Merged>),
    /// Neither: smoothed only, where the user wants no more levels.
    Smoothed,
}

/// A level that fewer ranks go on with.
struct Merged {
    merge: Merge,
    /// The levels from this one on, where this rank goes on.
    inner: Option<Multigrid>,
    /// Bodies of these levels: none.
    bodies: Bodies,
}

impl Merged {
    fn rebuild(&mut self, level: &Level) -> Result<()> {
        let Merged { merge, inner, bodies } = self;
        merge.bring_faces(level, inner.as_mut().map(|inner| &mut inner.levels[0]))?;
        let built = inner.as_mut().map(|inner| inner.rebuild(bodies, [0.0; 3], 0.0));
        merge.agree(built.unwrap_or(Ok(())))
    }

    /// Does `times` cycles for the b of `level`, from x = 0.
    fn cycle(&mut self, level: &mut Level, times: usize) -> Result<()> {
        let Merged { merge, inner, bodies } = self;
        merge.bring_b(level, inner.as_mut().map(|inner| &mut inner.levels[0]))?;
        if let Some(inner) = inner {
            (0..times).try_for_each(|time| inner.cycle(bodies, time == 0))?;
        }
        merge.take_x(level, inner.as_ref().map(|inner| &inner.levels[0]))
    }
}

pub(super) struct Multigrid {
    pub levels: Vec<Level>,
    bottom: Bottom,
    /// Passes before the coarser level, from zero and from a given x, and after it.
    from_zero: Vec<Pass>,
    down: Vec<Pass>,
    up: Vec<Pass>,
    tuning: Tuning,
}

impl Multigrid {
    /// The levels below the grid `whole`; `singular` says that no boundary fixes the pressure. The
    /// first `resolving` levels, two at least, stay on all ranks.
    pub fn new(
        session: &Session,
        whole: Whole,
        singular: bool,
        tuning: Tuning,
        resolving: usize,
    ) -> Multigrid {
        Multigrid::new_from(session, whole, singular, tuning, resolving.max(2))
    }

    /// As [`Multigrid::new`]; only the first `unmerged` levels stay on all of its ranks.
    pub fn new_from(
        session: &Session,
        whole: Whole,
        singular: bool,
        tuning: Tuning,
        unmerged: usize,
    ) -> Multigrid {
        let lattice = |whole: &Whole| Lattice::new(whole.local(), whole.axes);
        let mut levels = vec![Level::new(session, lattice(&whole), whole.neighbours)];
        let one_rank = whole.widths.iter().all(|parts| parts.len() == 1);
        let mut whole = whole;
        let bottom = loop {
            let factor = whole.factor();
            if one_rank && whole.cells() <= tuning.exact {
                break Bottom::Exact(Dense::new(
                    levels[levels.len() - 1].lattice,
                    whole.periodic,
                    singular,
                ));
            }
            let due = levels.len() > unmerged && merged::is_due(&whole);
            if !one_rank && (due || factor == [1; 3]) {
                let left = Tuning {
                    levels: tuning.levels.saturating_sub(levels.len() - 1).max(1),
                    twice_from: tuning.twice_from.saturating_sub(levels.len() - 1),
                    ..tuning
                };
                let (merge, merged) = Merge::new(session, &whole);
                let bodies = Bodies::new(session, whole.axes, [0.0; 3]);
                let inner =
                    merged.map(|merged| Multigrid::new_from(session, merged, singular, left, 0));
                break Bottom::Merged(Box::new(Merged { merge, inner, bodies }));
            }
            if levels.len() == tuning.levels {
                break Bottom::Smoothed;
            }
            let coarse = whole.coarser(factor);
            let distances = [&whole, &coarse].map(|w| std::array::from_fn(|a| w.distances(a)));
            if let Some(fine) = levels.last_mut() {
                fine.coarsen_by(factor, &distances[0], &distances[1]);
            }
            levels.push(Level::new(session, lattice(&coarse), coarse.neighbours));
            whole = coarse;
        };
        let root = |k: usize| {
            let middle = 0.5 * (2.0 + SMOOTH_FROM);
            let half = 0.5 * (2.0 - SMOOTH_FROM);
            middle + half * (PI * (k as f64 + 0.5) / tuning.smooth as f64).cos()
        };
        let omega: Vec<_> = (0..tuning.smooth).map(|k| (1.0 / root(k)) as Single).collect();
        let sweeps = || omega.iter().copied().map(Pass::Sweep);
        let first = [Pass::FromZero(omega[0])].into_iter();
        let from_zero = first.chain(sweeps().skip(1)).chain([Pass::Restrict]).collect();
        let down = sweeps().chain([Pass::Restrict]).collect();
        let up = [Pass::Prolong].into_iter().chain(sweeps().rev()).collect();
        Multigrid { levels, bottom, from_zero, down, up, tuning }
    }

    /// Everything that follows from the faces of the finest level, and from the `bodies` there: a
    /// face of its own conducts `unit` along each axis, and `scale` brings their weights into the
    /// same units. Collective.
    pub fn rebuild(&mut self, bodies: &mut Bodies, unit: [f64; 3], scale: f64) -> Result<()> {
        let count = self.levels.len();
        for l in 0..count {
            let (fine, coarse) = self.levels.split_at_mut(l + 1);
            let fine = &mut fine[l];
            fine.invert();
            if let Some(coarse) = coarse.first_mut() {
                fine.coarsen(coarse);
                bodies.prepare(l, fine, scale)?;
                // The level below the last one of this rank's own knows no bodies.
                bodies.descend(l, fine, coarse, unit, scale, l + 2 >= count);
            }
        }
        let last = &self.levels[self.levels.len() - 1];
        match &mut self.bottom {
            Bottom::Exact(dense) => dense.factorise(last),
            Bottom::Merged(merged) => merged.rebuild(last),
            Bottom::Smoothed => Ok(()),
        }
    }

    /// One cycle for the finest level's b, from zero or from its x. Collective.
    pub fn cycle(&mut self, bodies: &mut Bodies, from_zero: bool) -> Result<()> {
        self.visit(0, bodies, from_zero)
    }

    fn visit(&mut self, l: usize, bodies: &mut Bodies, from_zero: bool) -> Result<()> {
        let last = l + 1 == self.levels.len();
        match &mut self.bottom {
            Bottom::Exact(dense) if last => {
                dense.solve(&mut self.levels[l]);
                return Ok(());
            }
            Bottom::Merged(merged) if last => return merged.cycle(&mut self.levels[l], 1),
            _ => {}
        }
        let sweeps = self.tuning.smooth;
        let Multigrid { levels, from_zero: first, down, up, .. } = self;
        let down = if from_zero { &*first } else { &*down };
        if last {
            smooth(&mut levels[l..], None, &down[..sweeps])?;
            return smooth(&mut levels[l..], None, &up[1..]);
        }
        smooth(&mut levels[l..], Some((l, bodies)), down)?;
        let (fine, coarse) = levels.split_at_mut(l + 1);
        bodies.restrict(l, &fine[l], &mut coarse[0])?;
        let below = l + 2 == self.levels.len();
        let twice = l + 1 >= self.tuning.twice_from;
        match &mut self.bottom {
            Bottom::Merged(merged) if below => {
                merged.cycle(&mut self.levels[l + 1], 1 + usize::from(twice))?;
            }
            Bottom::Exact(_) if below => self.visit(l + 1, bodies, true)?,
            _ => {
                self.visit(l + 1, bodies, true)?;
                if twice {
                    self.visit(l + 1, bodies, false)?;
                }
            }
        }
        smooth(&mut self.levels[l..], Some((l, bodies)), &self.up)
    }
}

/// Does the passes on the first of the levels, with the corrections of its bodies if it has any.
fn smooth(
    levels: &mut [Level],
    bodies: Option<(usize, &mut Bodies)>,
    passes: &[Pass],
) -> Result<()> {
    let (level, coarse) = levels.split_at_mut(1);
    let level = &mut level[0];
    let mut coarse = coarse.first_mut();
    let mut bodies = bodies.filter(|(l, bodies)| bodies.on(*l));
    if level.layered && bodies.is_none() {
        sweeps::pass_together(level, passes, coarse);
        return Ok(());
    }
    for pass in passes {
        sweeps::pass(level, *pass, coarse.as_deref_mut())?;
        let (Some((l, bodies)), Pass::FromZero(omega) | Pass::Sweep(omega)) = (&mut bodies, pass)
        else {
            continue;
        };
        bodies.correct(*l, level, *omega, matches!(pass, Pass::FromZero(_)))?;
    }
    Ok(())
}
