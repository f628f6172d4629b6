//! Record of a step's solves: |D| before and after each C-HSMAC iteration, and the residuals of its
//! solve.

use crate::petsc::History;

/// The C-HSMAC iterations since the last [`Solves::clear`].
#[derive(Debug, Default)]
pub(super) struct Solves {
    recording: bool,
    iterations: Vec<Iteration>,
}

/// A C-HSMAC iteration.
#[derive(Clone, Copy, Debug)]
struct Iteration {
    /// Number of its projection in the step, from 1.
    projection: u32,
    /// The largest |D| (1/s) before it and, where another look followed, after it.
    before: f64,
    after: Option<f64>,
    /// The first of its attempts.
    attempt: usize,
}

/// An iteration of a solve: a row of `solves.csv`.
#[derive(Clone, Copy, Debug)]
pub struct SolveRow {
    /// Which projection of the step, from 1: contacts at work take several.
    pub projection: u32,
    /// Which C-HSMAC iteration of the step, from 1.
    pub outer: u32,
    /// Which attempt at its solve, from 1.
    pub attempt: u32,
    /// Krylov iterations so far.
    pub krylov: u32,
    /// The norm of the residual ([`crate::petsc::Attempt::norm`]).
    pub norm: &'static str,
    /// The residual: 1/s2 in the 2-norm over all cells.
    pub residual: f64,
    /// The residual over that of a solution of zero.
    pub relative: f64,
    /// The residual below which the solve ends; `None` where the method tests none.
    pub tolerance: Option<f64>,
    /// The largest |D| (1/s) before the solve.
    pub before: f64,
    /// The largest |D| (1/s) after the solve; `None` after a rough one, whose velocities change
    /// before |D| is found again, and after one that failed.
    pub after: Option<f64>,
}

impl Solves {
    /// Forgets all solves, and sets whether the next ones are recorded.
    pub fn clear(&mut self, recording: bool) {
        self.recording = recording;
        self.iterations.clear();
    }

    /// Takes note that a solve begins, the `first` of its projection or a later one, with this
    /// largest |D| (1/s); so many attempts were made before.
    pub fn begin(&mut self, first: bool, divergence: f64, attempts: usize) {
        if !self.recording {
            return;
        }
        let last = self.iterations.last().map_or(0, |iteration| iteration.projection);
        let projection = last + u32::from(first);
        let attempt = attempts;
        self.iterations.push(Iteration { projection, before: divergence, after: None, attempt });
    }

    /// Takes the largest |D| (1/s) after the last solve.
    pub fn end(&mut self, divergence: f64) {
        if let Some(last) = self.iterations.last_mut() {
            last.after = Some(divergence);
        }
    }

    /// The rows of all solves.
    pub fn rows<'a>(&'a self, history: &'a History) -> impl Iterator<Item = SolveRow> + 'a {
        let all = history.attempts();
        let ends = self.iterations.iter().skip(1).map(|next| next.attempt).chain([all.len()]);
        let of_iteration = move |(k, (iteration, end)): (usize, (&'a Iteration, usize))| {
            let attempts = all.get(iteration.attempt..end).unwrap_or_default();
            attempts.iter().enumerate().flat_map(move |(attempt, solve)| {
                let rows = history.residuals(solve).iter();
                rows.map(move |(krylov, residual)| SolveRow {
                    projection: iteration.projection,
                    outer: k as u32 + 1,
                    attempt: attempt as u32 + 1,
                    krylov: *krylov,
                    norm: solve.norm,
                    residual: *residual,
                    relative: solve.relative(*residual),
                    tolerance: solve.tolerance,
                    before: iteration.before,
                    after: iteration.after,
                })
            })
        };
        self.iterations.iter().zip(ends).enumerate().flat_map(of_iteration)
    }
}
