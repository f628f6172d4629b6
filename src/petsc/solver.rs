//! The linear solve: an operator of our own, a Krylov method and a preconditioner that PETSc's
//! options choose, and, for the preconditioners that need one, the operator's matrix.
//!
//! ```text
//!   solve:  an older preconditioner, if it is worth a try  ->  one of this matrix
//!                                       -> anew, from zero  ->  failure, with both reasons
//! ```

use super::Session;
use super::choice::{
    Choice, default_options, refuse_empty_views, refuse_what_ends_the_program, writes_numbers,
};
use super::failure::{Ended, OVERFLOWN, failed_once, failed_twice, overflown};
use super::history::{History, System};
use super::krylov::Krylov;
use super::layout::Layout;
use super::matrix::{Constants, Matrix};
use super::operator::{BOXMG, Operator, Shell};
use super::reuse::Reuse;
use super::vector::{Pattern, Vectors};
use crate::{Error, Result};
use std::cell::RefCell;
use std::rc::Rc;

/// A linear system over the owned cells of every rank, and its solver. PETSc's objects are
/// destroyed in the order of the fields: whoever uses another one goes first.
pub struct LinearSolver {
    krylov: Krylov,
    vectors: Vectors,
    /// The matrix that the preconditioner is built from, where it is none of the operator's own.
    matrix: Option<Matrix>,
    operator: Shell,
    /// Whether the Krylov method's operator is another than the matrix.
    differs: bool,
    reuse: Reuse,
    /// Why terms of low rank are refused, where they are.
    refusal: Option<&'static str>,
    /// The residuals of its solves, where they are asked for.
    history: History,
    /// The last field: PETSc ends no earlier than what it holds.
    session: Session,
}

/// Numbers of iterations and setups of a solve.
#[derive(Clone, Copy, Debug, Default)]
pub struct Solved {
    /// Krylov iterations, those of a retry included.
    pub iterations: u32,
    /// Whether a first try failed and was repeated from zero with a rebuilt preconditioner.
    pub retried: bool,
    /// Setups of the preconditioner.
    pub setups: u32,
}

impl LinearSolver {
    /// A system whose rows are the cells of this rank by `layout`, with that operator; `pattern`
    /// gives the entries of its matrix, where one is needed, in PETSc's numbers of rows (this
    /// rank's) and columns. `singular` says that constants solve the homogeneous system.
    ///
    /// # Errors
    /// When an option names something that this PETSc does not have.
    pub fn new(
        session: &Session,
        choice: Choice,
        layout: &Layout,
        operator: Rc<RefCell<dyn Operator>>,
        singular: bool,
        pattern: impl FnOnce() -> Pattern,
    ) -> Result<LinearSolver> {
        let chosen = session.user_option("-ksp_type")? || session.user_option("-pc_type")?;
        let owned = layout.local.iter().product();
        default_options(session, choice, layout)?;
        refuse_what_ends_the_program(session)?;
        let preconditioner = session.option("-pc_type")?.unwrap_or_default();
        let own = preconditioner.as_bytes() == BOXMG.to_bytes();
        if own {
            operator.borrow().accept()?;
        }
        refuse_empty_views(session, own, singular)?;
        let mut operator = Shell::new(session, operator, owned)?;
        let reuse = match own {
            true => Reuse::default(),
            false => Reuse::by_options(session, choice == Choice::BcgsBoomeramg && !chosen)?,
        };
        let matrix = (!own).then(|| Matrix::new(session, layout, pattern())).transpose()?;
        if let Some(matrix) = matrix.as_ref().filter(|matrix| matrix.multiplies()) {
            // SAFETY: both matrices are alive; the solver made below destroys this one before the
            // shell, and multiplies only before that.
            unsafe {
                operator.go_with(session, matrix.handle)?;
                operator.multiply_by(matrix.handle);
                // Our own preconditioners keep constants out by themselves.
                if singular {
                    let constants = Constants::new(session)?;
                    constants.give_to(matrix.handle)?;
                    constants.give_to(operator.matrix)?;
                }
            }
        }
        let from = matrix.as_ref().map_or(operator.matrix, |matrix| matrix.handle);
        // SAFETY: the solver made below destroys these two before the matrices.
        let (vectors, krylov) = unsafe {
            let vectors = Vectors::new(operator.matrix, owned)?;
            (vectors, Krylov::new(session, layout, operator.matrix, from)?)
        };
        Ok(LinearSolver {
            krylov,
            vectors,
            matrix,
            operator,
            differs: true,
            reuse,
            refusal: refusal_of_low_rank(session)?,
            history: History::default(),
            session: session.clone(),
        })
    }

    /// The matrix's new values, in the order of the pattern; the preconditioner follows at the next
    /// solve.
    pub fn set_values(&mut self, values: &[f64]) -> Result<()> {
        let Some(matrix) = &self.matrix else { return Ok(()) };
        self.reuse.outdate();
        matrix.set_values(values)
    }

    /// Refuses options that ignore terms of low rank: the preconditioner alone, and the matrix.
    ///
    /// # Errors
    /// When the method is `preonly`, or `-ksp_view_mat` is to write the matrix.
    pub fn refuse_without_low_rank(&self) -> Result<()> {
        self.refusal.map_or(Ok(()), |why| Err(Error::Usage(why.into())))
    }

    /// Lets `fill` write the right side: this rank's cells, x fastest. Where constants solve the
    /// homogeneous system, its mean over all ranks has to be zero, and the solution's is not.
    pub fn set_right_side(&mut self, fill: impl FnOnce(&mut [f64])) -> Result<()> {
        self.vectors.set_right_side(fill)
    }

    /// Hands the solution to `take`: this rank's cells, x fastest.
    pub fn solution<T>(&self, take: impl FnOnce(&[f64]) -> T) -> Result<T> {
        self.vectors.take_solution(take)
    }

    /// Hands the right side to `take`.
    pub fn right_side<T>(&self, take: impl FnOnce(&[f64]) -> T) -> Result<T> {
        self.vectors.take_right_side(take)
    }

    /// Forgets the history of its solves, and sets whether the next ones are recorded.
    pub fn record(&mut self, recording: bool) {
        self.history.clear(recording);
    }

    /// The residuals of its solves since [`LinearSolver::record`].
    pub fn history(&self) -> &History {
        &self.history
    }

    /// The relative tolerance that the user fixed by `-ksp_rtol`.
    pub fn fixed_rtol(&self) -> Option<f64> {
        self.krylov.fixed_rtol
    }

    /// The absolute tolerance of a solve that is asked for this one: the user's, or none where the
    /// method does not test the true residual.
    pub fn absolute_tolerance(&self, asked: f64) -> f64 {
        self.krylov.absolute_tolerance(asked)
    }

    /// The method and the preconditioner in use, as `bcgs + hypre`; of a preconditioner that serves
    /// several matrices, also when it is set up.
    pub fn describe(&self) -> Result<String> {
        let name = |n: &str| Ok::<_, Error>(self.session.option(n)?.unwrap_or_else(|| "?".into()));
        let reuses = self.matrix.is_some() && self.reuse.reuses();
        let lag = if reuses { format!(", {}", self.reuse.words()) } else { String::new() };
        Ok(format!("{} + {}{lag}", name("-ksp_type")?, name("-pc_type")?))
    }

    /// Whether the user chose the method or the preconditioner by PETSc's options.
    pub fn chosen_by_options(&self) -> Result<bool> {
        Ok(self.session.user_option("-ksp_type")? || self.session.user_option("-pc_type")?)
    }

    /// Gives the Krylov solver its operator, and the matrix to build the preconditioner from.
    fn set_operators(&mut self) -> Result<()> {
        let shell = self.operator.matrix;
        let from = self.matrix.as_ref().map_or(shell, |matrix| matrix.handle);
        // The matrix can be the operator as long as this is no other.
        let whole = self.multiplies() && !self.differs;
        // SAFETY: both are of `self`, which destroys the Krylov solver first.
        unsafe { self.krylov.set_operators(if whole { from } else { shell }, from) }
    }

    /// Whether products may be taken with a matrix.
    fn multiplies(&self) -> bool {
        self.matrix.as_ref().is_some_and(Matrix::multiplies)
    }

    /// Solves, from zero unless an option says otherwise, until the true residual is below `rtol`
    /// times the right side's norm, or below `atol` (2-norms; a method that knows another norm only
    /// goes by `rtol` in that). A solve that fails is repeated once, from zero, with a rebuilt
    /// preconditioner, unless that is the operator's own, which would be the same again.
    /// Collective.
    ///
    /// # Errors
    /// When the last try fails, with PETSc's reason for each.
    pub fn solve(&mut self, rtol: f64, atol: f64) -> Result<Solved> {
        let before = self.setups()?;
        self.choose_operator()?;
        let solved = self.solve_or_retry(rtol, atol)?;
        Ok(Solved { setups: self.setups()? - before, ..solved })
    }

    /// The method, where the user chose it.
    fn chosen_method(&self) -> Result<Option<String>> {
        let chosen = self.session.user_option("-ksp_type")?;
        if chosen { self.session.option("-ksp_type") } else { Ok(None) }
    }

    /// Setups of the preconditioner so far.
    fn setups(&self) -> Result<u32> {
        match self.matrix {
            None => self.operator.setups(),
            Some(_) => Ok(self.reuse.setups),
        }
    }

    /// Takes the matrix itself for the operator as long as the operator has no other terms.
    fn choose_operator(&mut self) -> Result<()> {
        let differs = self.operator.differs_from_matrix()?;
        if self.multiplies() && std::mem::replace(&mut self.differs, differs) != differs {
            self.set_operators()?;
        }
        Ok(())
    }

    fn solve_or_retry(&mut self, rtol: f64, atol: f64) -> Result<Solved> {
        let atol = self.absolute_tolerance(atol);
        let (done, spent) = self.attempt_with_old_preconditioner(rtol, atol)?;
        if done {
            return Ok(Solved { iterations: spent, ..Solved::default() });
        }
        self.prepare(rtol, atol, false, self.krylov.max_iterations)?;
        let first = self.attempt()?;
        if first.reason > 0 {
            self.reuse.judge(first.iterations, rtol);
            return Ok(Solved { iterations: spent + first.iterations, ..Solved::default() });
        }
        if self.matrix.is_none() {
            return Err(match first.reason {
                OVERFLOWN => overflown(self.chosen_method()?),
                _ => failed_once(first, rtol),
            });
        }
        self.krylov.forget_preconditioner()?;
        self.set_operators()?;
        self.reuse.build();
        // With `-ksp_initial_guess_nonzero` a failed attempt's result would be the next one's
        // guess.
        self.vectors.forget_solution()?;
        let second = self.attempt()?;
        if second.reason > 0 {
            self.reuse.judge(second.iterations, rtol);
            let iterations = spent + first.iterations + second.iterations;
            return Ok(Solved { iterations, retried: true, ..Solved::default() });
        }
        Err(match [first.reason, second.reason] {
            [OVERFLOWN, OVERFLOWN] => overflown(self.chosen_method()?),
            _ => failed_twice(first, second, rtol),
        })
    }

    /// Solves with the preconditioner of an older matrix, where that is worth a try. Returns
    /// whether it is solved, and the iterations.
    fn attempt_with_old_preconditioner(&mut self, rtol: f64, atol: f64) -> Result<(bool, u32)> {
        let reuse = self.reuse;
        if !reuse.is_stale() {
            return Ok((false, 0));
        }
        let mut spent = 0;
        if reuse.keeps() {
            self.prepare(rtol, atol, true, reuse.patience(rtol).min(self.krylov.max_iterations))?;
            let Ended { reason, iterations } = self.attempt()?;
            if reason > 0 {
                self.reuse.judge(iterations, rtol);
                return Ok((true, iterations));
            }
            spent = iterations;
            self.reuse.fail();
            self.vectors.forget_solution()?;
        }
        self.reuse.build();
        Ok((false, spent))
    }

    /// Sets the tolerances of the next attempt, and whether it goes on with a preconditioner of
    /// another matrix.
    fn prepare(&mut self, rtol: f64, atol: f64, keep: bool, iterations: i32) -> Result<()> {
        self.krylov.set_tolerances(rtol, atol, iterations)?;
        if self.reuse.reuses() { self.krylov.keep_preconditioner(keep) } else { Ok(()) }
    }

    fn attempt(&mut self) -> Result<Ended> {
        let system = System {
            krylov: self.krylov.handle,
            operator: self.operator.matrix,
            right_side: self.vectors.right_side,
            solution: self.vectors.solution,
        };
        self.history.begin(system)?;
        let solved = self.krylov.solve(&mut self.vectors);
        let ended = solved.map_err(|e| self.operator.take_failure().unwrap_or(e))?;
        self.history.end(system, ended.iterations)?;
        Ok(ended)
    }
}

/// The reason why the options do not allow terms of low rank, where they do not.
fn refusal_of_low_rank(session: &Session) -> Result<Option<&'static str>> {
    if writes_numbers(session, "-ksp_view_mat")? {
        return Ok(Some(
            "PETSc option -ksp_view_mat: the operator holds the motion of free bodies (or a held \
            mean velocity), which is in no matrix here; `mics export-system` writes the whole, and \
            -ksp_view_pmat the matrix of the fluid",
        ));
    }
    let alone = session.option("-ksp_type")?.as_deref() == Some("preonly");
    Ok(alone.then_some(
        "-ksp_type preonly solves with the preconditioner alone, which knows nothing of the motion \
        of free bodies; use cg, bcgs or gmres",
    ))
}
