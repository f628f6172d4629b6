//! The linear solve: an operator of our own, a Krylov method and a preconditioner that PETSc's
//! options choose, and, for the preconditioners that need one, the operator's matrix, its values
//! refilled straight into PETSc's storage.

use super::Session;
use super::choice::{
    Choice, bad_option, default_options, number, refuse_empty_views, refuse_what_ends_the_program,
    relative_tolerance, writes_numbers,
};
use super::failure::check;
use super::history::{History, System};
use super::layout::Layout;
use super::operator::{BOXMG, Operator, Shell};
use super::reuse::Reuse;
use super::structured::Structured;
use super::vector::{Pattern, read, write};
use crate::{Error, Result};
use petsc_sys as ffi;
use std::cell::RefCell;
use std::ptr;
use std::rc::Rc;

/// A linear system over the owned cells of every rank, and its solver.
pub struct LinearSolver {
    pub(super) operator: Shell,
    /// Whether the operator's own preconditioner is in use.
    pub(super) own: bool,
    /// What the preconditioner is built from, where it is none of the operator's own; else null.
    pub(super) matrix: ffi::Mat,
    /// Where its entries go, in hypre's structured form.
    pub(super) structured: Option<Structured>,
    pub(super) krylov: ffi::KSP,
    pub(super) null_space: ffi::MatNullSpace,
    pub(super) right_side: ffi::Vec,
    pub(super) solution: ffi::Vec,
    pub(super) owned: usize,
    /// The user's `-ksp_rtol`, which wins over the caller's.
    pub(super) fixed_rtol: Option<f64>,
    /// The user's `-ksp_atol` likewise.
    pub(super) fixed_atol: Option<f64>,
    /// Whether the method tests the true residual, for which alone the caller's absolute tolerance
    /// is meant.
    pub(super) tests_true_residual: bool,
    /// Whether a solve has come through: what PETSc refuses before that, an option asked for.
    pub(super) proven: bool,
    pub(super) max_iterations: i32,
    pub(super) divergence_tolerance: f64,
    pub(super) reuse: Reuse,
    /// Whether the Krylov method's operator is another than the matrix.
    pub(super) differs: bool,
    /// Whether there is no iteration, but one application of the preconditioner.
    pub(super) preconditioner_alone: bool,
    /// Whether the user has the operator written as a matrix.
    pub(super) writes_operator: bool,
    /// The residuals of its solves, where they are asked for.
    pub(super) history: History,
    /// The last field: PETSc ends no earlier than what it holds.
    pub(super) session: Session,
}

/// What a solve took.
#[derive(Clone, Copy, Debug, Default)]
pub struct Solved {
    /// Krylov iterations, those of a retry included.
    pub iterations: u32,
    /// Whether a first try failed and was repeated from zero with a rebuilt preconditioner.
    pub retried: bool,
    /// How often the preconditioner was set up.
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
        let mut solver = LinearSolver {
            operator: Shell::new(session, operator, owned)?,
            own,
            matrix: ptr::null_mut(),
            structured: None,
            krylov: ptr::null_mut(),
            null_space: ptr::null_mut(),
            right_side: ptr::null_mut(),
            solution: ptr::null_mut(),
            owned,
            fixed_rtol: relative_tolerance(session)?,
            fixed_atol: number(session, "-ksp_atol")?,
            tests_true_residual: false,
            proven: false,
            max_iterations: 0,
            divergence_tolerance: 0.0,
            reuse: match own {
                true => Reuse::default(),
                false => Reuse::by_options(session, choice == Choice::BcgsBoomeramg && !chosen)?,
            },
            differs: true,
            preconditioner_alone: session.option("-ksp_type")?.as_deref() == Some("preonly"),
            writes_operator: writes_numbers(session, "-ksp_view_mat")?,
            history: History::default(),
            session: session.clone(),
        };
        if singular {
            let space = &mut solver.null_space;
            // SAFETY: an output that `solver` owns from then on and destroys when dropped.
            check("MatNullSpaceCreate", unsafe {
                ffi::MatNullSpaceCreate(session.comm(), ffi::PETSC_TRUE, 0, ptr::null(), space)
            })?;
        }
        if !own {
            solver.make_matrix(layout, pattern())?;
        }
        solver.make_krylov(layout)?;
        Ok(solver)
    }

    /// Makes the matrix that the preconditioner is built from, with the entries of a pattern.
    fn make_matrix(&mut self, layout: &Layout, pattern: Pattern) -> Result<()> {
        if let Some("pfmg" | "smg") = self.session.option("-pc_type")?.as_deref() {
            let structured = Structured::new(&self.session, layout, &pattern)?;
            self.matrix = structured.matrix;
            self.structured = Some(structured);
            return Ok(());
        }
        let Pattern { mut rows, mut columns, .. } = pattern;
        let n = self.owned as i32;
        let any = -1;
        let count = rows.len() as ffi::PetscCount;
        // SAFETY: the handle is an output that `self` owns from then on and destroys when dropped,
        // also when a later call fails; `rows` and `columns` live through the call that reads (and
        // may reorder) them.
        unsafe {
            check("MatCreate", ffi::MatCreate(self.session.comm(), &mut self.matrix))?;
            check("MatSetSizes", ffi::MatSetSizes(self.matrix, n, n, any, any))?;
            check("MatSetType", ffi::MatSetType(self.matrix, c"aij".as_ptr()))?;
            let i = rows.as_mut_ptr();
            let j = columns.as_mut_ptr();
            check("MatSetPreallocationCOO", ffi::MatSetPreallocationCOO(self.matrix, count, i, j))?;
            check(
                "MatSetOption",
                ffi::MatSetOption(self.matrix, ffi::MAT_SYMMETRIC, ffi::PETSC_TRUE),
            )?;
            self.operator.go_with(&self.session, self.matrix)?;
            self.operator.multiply_by(self.matrix);
            // Our own preconditioners keep constants out by themselves.
            if !self.null_space.is_null() {
                for matrix in [self.matrix, self.operator.matrix] {
                    check("MatSetNullSpace", ffi::MatSetNullSpace(matrix, self.null_space))?;
                }
            }
        }
        Ok(())
    }

    /// Makes the vectors and the Krylov solver, as the options say.
    fn make_krylov(&mut self, layout: &Layout) -> Result<()> {
        let on_grid = self.session.option("-pc_type")?.as_deref() == Some("mg");
        let grid = on_grid.then(|| layout.cell_grid(&self.session)).transpose()?;
        // SAFETY: as for the matrix.
        unsafe {
            let x = &mut self.solution;
            let b = &mut self.right_side;
            check("MatCreateVecs", ffi::MatCreateVecs(self.operator.matrix, x, b))?;
            check("KSPCreate", ffi::KSPCreate(self.session.comm(), &mut self.krylov))?;
            self.set_operators()?;
            if let Some(grid) = &grid {
                check("KSPSetDM", ffi::KSPSetDM(self.krylov, grid.dm))?;
                // It coarsens the grid, and makes no operator.
                let active = ffi::PETSC_FALSE;
                check("KSPSetDMActive", ffi::KSPSetDMActive(self.krylov, active))?;
            }
            check("KSPSetFromOptions", ffi::KSPSetFromOptions(self.krylov)).map_err(bad_option)?;
            let mut norm = 0;
            check("KSPGetNormType", ffi::KSPGetNormType(self.krylov, &mut norm))
                .map_err(bad_option)?;
            self.tests_true_residual = norm == ffi::KSP_NORM_UNPRECONDITIONED;
            let mut r = 0.0;
            let mut a = 0.0;
            let d = &mut self.divergence_tolerance;
            let m = &mut self.max_iterations;
            check("KSPGetTolerances", ffi::KSPGetTolerances(self.krylov, &mut r, &mut a, d, m))
        }
    }

    /// The matrix's new values, in the order of the pattern; the preconditioner follows at the next
    /// solve.
    pub fn set_values(&mut self, values: &[f64]) -> Result<()> {
        if self.matrix.is_null() {
            return Ok(());
        }
        self.reuse.outdate();
        if let Some(structured) = &self.structured {
            return structured.set_values(values);
        }
        // SAFETY: `values` has the pattern's length, which the caller made.
        check("MatSetValuesCOO", unsafe {
            ffi::MatSetValuesCOO(self.matrix, values.as_ptr(), ffi::INSERT_VALUES)
        })
    }

    /// Refuses what knows nothing of terms of low rank: the preconditioner alone, and the matrix.
    ///
    /// # Errors
    /// When the method is `preonly`, or `-ksp_view_mat` is to write the matrix.
    pub fn refuse_without_low_rank(&self) -> Result<()> {
        if self.writes_operator {
            return Err(Error::Usage(
                "PETSc option -ksp_view_mat: the operator holds the motion of free bodies (or a \
                held mean velocity), which is in no matrix here; `mics export-system` writes the \
                whole, and -ksp_view_pmat the matrix of the fluid"
                    .into(),
            ));
        }
        if self.preconditioner_alone {
            return Err(Error::Usage(
                "-ksp_type preonly solves with the preconditioner alone, which knows nothing of \
                the motion of free bodies; use cg, bcgs or gmres"
                    .into(),
            ));
        }
        Ok(())
    }

    /// Whether the matrix can be the operator, as long as this is no other.
    pub(super) fn is_assembled(&self) -> bool {
        !self.matrix.is_null() && self.structured.is_none()
    }

    /// Tells the Krylov solver what to solve for, and what to build the preconditioner from.
    pub(super) fn set_operators(&mut self) -> Result<()> {
        let from = if self.matrix.is_null() { self.operator.matrix } else { self.matrix };
        let whole = self.is_assembled() && !self.differs;
        let operator = if whole { self.matrix } else { self.operator.matrix };
        // SAFETY: handles of `self`.
        check("KSPSetOperators", unsafe { ffi::KSPSetOperators(self.krylov, operator, from) })
    }

    /// Lets `fill` write the right side: this rank's cells, x fastest.
    pub fn set_right_side(&mut self, fill: impl FnOnce(&mut [f64])) -> Result<()> {
        // SAFETY: made in `new` with `owned` entries here; `fill` cannot reach it otherwise.
        unsafe { write(self.right_side, self.owned, fill) }
    }

    /// Hands the solution to `take`: this rank's cells, x fastest.
    pub fn solution<T>(&self, take: impl FnOnce(&[f64]) -> T) -> Result<T> {
        // SAFETY: as for the right side.
        unsafe { read(self.solution, self.owned, take) }
    }

    /// Forgets the history of its solves, and says whether the next ones are recorded.
    pub fn record(&mut self, recording: bool) {
        self.history.clear(recording);
    }

    /// The residuals of its solves since [`LinearSolver::record`].
    pub fn history(&self) -> &History {
        &self.history
    }

    /// What its history is taken from.
    pub(super) fn system(&self) -> System {
        System {
            krylov: self.krylov,
            operator: self.operator.matrix,
            right_side: self.right_side,
            solution: self.solution,
        }
    }

    /// Hands the right side to `take`, after a solve without its mean where constants solve the
    /// homogeneous system.
    pub fn right_side<T>(&self, take: impl FnOnce(&[f64]) -> T) -> Result<T> {
        // SAFETY: as for the solution.
        unsafe { read(self.right_side, self.owned, take) }
    }

    /// Whether the user fixed the relative tolerance by `-ksp_rtol`.
    pub fn fixed_rtol(&self) -> Option<f64> {
        self.fixed_rtol
    }

    /// The absolute tolerance of a solve that is asked for this one: the user's, or none where the
    /// method does not test the true residual.
    pub fn absolute_tolerance(&self, asked: f64) -> f64 {
        self.fixed_atol.unwrap_or(if self.tests_true_residual { asked } else { 0.0 })
    }

    /// The method and the preconditioner in use, as `bcgs + hypre`, with when a
    /// preconditioner that serves several matrices is set up.
    pub fn describe(&self) -> Result<String> {
        let name = |n: &str| Ok::<_, Error>(self.session.option(n)?.unwrap_or_else(|| "?".into()));
        let reuses = !self.own && self.reuse.reuses();
        let lag = if reuses { format!(", {}", self.reuse.words()) } else { String::new() };
        Ok(format!("{} + {}{lag}", name("-ksp_type")?, name("-pc_type")?))
    }

    /// Whether the user chose the method or the preconditioner by PETSc's options.
    pub fn chosen_by_options(&self) -> Result<bool> {
        Ok(self.session.user_option("-ksp_type")? || self.session.user_option("-pc_type")?)
    }
}

impl Drop for LinearSolver {
    fn drop(&mut self) {
        // SAFETY: each handle is null (PETSc then does nothing) or ours; `session` outlives them
        // all.
        unsafe {
            ffi::KSPDestroy(&mut self.krylov);
            ffi::VecDestroy(&mut self.right_side);
            ffi::VecDestroy(&mut self.solution);
            ffi::MatNullSpaceDestroy(&mut self.null_space);
            ffi::MatDestroy(&mut self.matrix);
        }
    }
}
