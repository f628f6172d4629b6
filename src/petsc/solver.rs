//! The linear solve: an operator of our own, a Krylov method and a preconditioner that PETSc's
//! options choose, and, for the preconditioners that need one, the operator's matrix, its values
//! refilled straight into PETSc's storage.

use super::Session;
use super::operator::{Operator, OwnPreconditioner, Shell};
use super::session::{check, read, reason_name, write};
use crate::{Error, Result};
use petsc_sys as ffi;
use std::cell::RefCell;
use std::ptr;
use std::rc::Rc;

/// A linear system over the owned cells of every rank, and its solver.
pub struct LinearSolver {
    operator: Shell,
    /// The operator's own preconditioner, where that is in use.
    own: Option<OwnPreconditioner>,
    /// What the preconditioner is built from, where it is none of the operator's own; else null.
    matrix: ffi::Mat,
    krylov: ffi::KSP,
    null_space: ffi::MatNullSpace,
    right_side: ffi::Vec,
    solution: ffi::Vec,
    owned: usize,
    /// The user's `-ksp_rtol`, which wins over the caller's.
    fixed_rtol: Option<f64>,
    /// The user's `-ksp_atol` likewise.
    fixed_atol: Option<f64>,
    /// Whether the method tests the true residual, for which alone the caller's absolute tolerance
    /// is meant.
    tests_true_residual: bool,
    /// Whether a solve has come through: what PETSc refuses before that, an option asked for.
    proven: bool,
    max_iterations: i32,
    divergence_tolerance: f64,
    reuse: Option<Reuse>,
    /// Whether there is no iteration, but one application of the preconditioner.
    preconditioner_alone: bool,
    /// The last field: PETSc ends no earlier than what it holds.
    session: Session,
}

/// What to solve with where PETSc's options leave it open.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choice {
    /// BCGS with BoomerAMG.
    BcgsBoomeramg,
    /// Conjugate gradients with the operator's own multigrid.
    Multigrid,
    /// The operator's own transforms, which are exact where its coefficient is uniform.
    Direct,
}

/// What a solve took.
#[derive(Clone, Copy, Debug, Default)]
pub struct Solved {
    /// Krylov iterations, those of a retry included.
    pub iterations: u32,
    /// Whether a first try failed and was repeated from zero with a rebuilt preconditioner.
    pub retried: bool,
}

/// A preconditioner that outlives its matrix until iterations have grown.
#[derive(Clone, Copy, Debug, Default)]
struct Reuse {
    /// Iterations a decade of reduction with the matrix that it was built from.
    first: Option<f64>,
    /// Whether the matrix is another by now.
    stale: bool,
    /// Whether it has to be built anew before the next solve.
    due: bool,
    /// Matrices for which it is built anew in any case: it has failed on one that it was not built
    /// from.
    wait: u32,
    failures: u32,
}

impl Reuse {
    /// Whether the next solve goes on with what there is, although the matrix is another.
    fn keeps(&self) -> bool {
        self.first.is_some() && !self.due && self.wait == 0
    }

    /// Iterations after which building anew costs less than going on.
    fn patience(&self, rtol: f64) -> i32 {
        (2.0 * GROWTH * self.first.unwrap_or(0.0) * -rtol.log10()) as i32 + 5
    }

    /// Takes a solve's iterations.
    fn judge(&mut self, iterations: u32, rtol: f64) {
        let decades = -rtol.log10();
        match self.first {
            Some(first) if self.stale => {
                self.due = f64::from(iterations) > GROWTH * first * decades + 1.0
            }
            _ => self.first = Some(f64::from(iterations) / decades),
        }
    }

    fn built(&mut self) {
        *self = Reuse {
            first: None,
            stale: false,
            due: false,
            wait: self.wait.saturating_sub(1),
            ..*self
        };
    }

    /// Waits longer each time.
    fn failed(&mut self) {
        self.failures = (self.failures + 1).min(6);
        self.wait = 1 << self.failures;
    }
}

/// PETSc's `KSP_DIVERGED_ITS`: more iterations than `-ksp_max_it` allows.
const TOO_MANY: i32 = -3;

/// How to see why a solve fails.
const LOOK: &str = "look at it with `-- -ksp_monitor_true_residual -ksp_converged_reason`";

/// PETSc's `KSP_DIVERGED_NANORINF`: a number that is infinite or none.
const OVERFLOWN: i32 = -9;

/// The failure of solves that met a number that is infinite or none: no solver cures that.
fn overflown() -> Error {
    Error::Run(
        "the pressure equation holds numbers that are infinite or none: a density, a viscosity, a \
        length or a velocity of the case is \
         too large or too small for double precision, or the flow has grown beyond it; look at \
         their exponents and units"
            .into(),
    )
}

/// Growth of the iterations at which a preconditioner is built anew.
const GROWTH: f64 = 1.3;

/// A choice's options, on the true residual, with a coarsest solve that a singular matrix allows.
fn default_options(session: &Session, choice: Choice, dimension: usize) -> Result<()> {
    session.forget_default_options()?;
    let (method, preconditioner) = match choice {
        Choice::BcgsBoomeramg => ("bcgs", "hypre"),
        Choice::Multigrid => ("cg", "boxmg"),
        Choice::Direct => ("preonly", "transform"),
    };
    // A method without iterations is for the preconditioner that it was chosen with.
    let iterates = choice != Choice::Direct || session.has_option("-pc_type")?;
    session
        .default_option("-ksp_type", if iterates && method == "preonly" { "cg" } else { method })?;
    session.default_option("-ksp_max_it", "500")?;
    // The side on which, or the norm in which, each method tests the true residual.
    match session.option("-ksp_type")?.as_deref() {
        Some("bcgs" | "fbcgs" | "fbcgsr" | "gmres" | "fgmres" | "lgmres" | "gcr" | "tfqmr") => {
            session.default_option("-ksp_pc_side", "right")?
        }
        Some("cg" | "pipecg" | "groppcg" | "fcg" | "cr") => {
            session.default_option("-ksp_norm_type", "unpreconditioned")?
        }
        _ => {}
    }
    session.default_option("-pc_type", preconditioner)?;
    // Else gamg and mg smooth with the operator, free bodies included, by the eigenvalues of the
    // matrix: no longer positive.
    session.default_option("-pc_use_amat", "false")?;
    if session.option("-pc_type")?.as_deref() == Some("gamg") {
        // Its own smoother goes by estimates of eigenvalues that are too small: as a preconditioner
        // of cg it is indefinite among free bodies.
        session.default_option("-mg_levels_ksp_type", "richardson")?;
        session.default_option("-mg_levels_pc_type", "sor")?;
    }
    if session.option("-pc_type")?.as_deref() == Some("hypre") {
        session.default_option("-pc_hypre_type", "boomeramg")?;
        session.default_option("-pc_hypre_boomeramg_relax_type_coarse", "symmetric-SOR/Jacobi")?;
        let threshold = if dimension == 2 { "0.25" } else { "0.5" };
        session.default_option("-pc_hypre_boomeramg_strong_threshold", threshold)?;
        if dimension == 3 {
            // Sparser levels: a quarter less time at 64^3, and less memory. In 2D they gain
            // nothing.
            session.default_option("-pc_hypre_boomeramg_coarsen_type", "HMIS")?;
            session.default_option("-pc_hypre_boomeramg_interp_type", "ext+i")?;
            session.default_option("-pc_hypre_boomeramg_P_max", "4")?;
        }
    }
    Ok(())
}

/// Refuses options with which this PETSc ends the program.
fn refuse_what_ends_the_program(session: &Session) -> Result<()> {
    let levels = number(session, "-pc_mg_levels")?.unwrap_or(1.0);
    if session.option("-pc_type")?.as_deref() == Some("mg") && levels > 1.0 {
        return Err(Error::Usage(
            "PETSc option -pc_type mg with -pc_mg_levels: its coarser levels have to be given, and \
            here is none but the grid itself; \
             -pc_type gamg or hypre find theirs from the matrix"
                .into(),
        ));
    }
    match session
        .options()?
        .split(" -")
        .find(|option| option.contains("ksp_monitor") && option.contains("hdf5"))
    {
        Some(option) => Err(Error::Usage(format!(
            "PETSc option -{}: its monitors cannot write HDF5; give ascii:FILE",
            option.trim_start_matches('-')
        ))),
        None => Ok(()),
    }
}

/// Refuses to write a matrix that there is none of: the operator is applied row by row, and so is
/// what `own` preconditioners need of it.
fn refuse_empty_views(session: &Session, own: bool) -> Result<()> {
    for (name, none) in [("-ksp_view_mat", true), ("-ksp_view_pmat", own)] {
        let value = session.option(name)?.unwrap_or_default();
        let numbers =
            ["binary", "hdf5", "matlab", "draw"].iter().any(|kind| value.starts_with(kind));
        if none && numbers {
            return Err(Error::Usage(format!(
                "PETSc option {name} {value}: there is no matrix to write, the operator is applied \
                with the free bodies in it; \
                 -ksp_view_pmat with -pc_type hypre or gamg writes the one of the fluid"
            )));
        }
    }
    Ok(())
}

impl LinearSolver {
    /// A system of `owned` rows on this rank, with that operator; `pattern` gives the entries of
    /// its matrix, where one is needed, in PETSc's numbers of rows (this rank's) and columns.
    /// `singular` says that constants solve the homogeneous system.
    ///
    /// # Errors
    /// When an option names something that this PETSc does not have.
    pub fn new(
        session: &Session,
        choice: Choice,
        (dimension, owned): (usize, usize),
        operator: Rc<RefCell<dyn Operator>>,
        singular: bool,
        pattern: impl FnOnce() -> (Vec<i32>, Vec<i32>),
    ) -> Result<LinearSolver> {
        let chosen = session.user_option("-ksp_type")? || session.user_option("-pc_type")?;
        default_options(session, choice, dimension)?;
        refuse_what_ends_the_program(session)?;
        let own = OwnPreconditioner::named(&session.option("-pc_type")?.unwrap_or_default());
        if let Some(own) = own {
            operator.borrow().accept(own)?;
        }
        refuse_empty_views(session, own.is_some())?;
        let fixed_rtol = number(session, "-ksp_rtol")?;
        if let Some(rtol) = fixed_rtol.filter(|rtol| *rtol >= 1.0) {
            return Err(Error::Usage(format!(
                "PETSc option -ksp_rtol: {rtol:?} asks for no reduction; give a number below 1, \
                such as 1e-8"
            )));
        }
        let mut solver = LinearSolver {
            operator: Shell::new(session, operator, owned)?,
            own,
            matrix: ptr::null_mut(),
            krylov: ptr::null_mut(),
            null_space: ptr::null_mut(),
            right_side: ptr::null_mut(),
            solution: ptr::null_mut(),
            owned,
            fixed_rtol,
            fixed_atol: number(session, "-ksp_atol")?,
            tests_true_residual: false,
            proven: false,
            max_iterations: 0,
            divergence_tolerance: 0.0,
            reuse: (choice == Choice::BcgsBoomeramg && !chosen).then(Reuse::default),
            preconditioner_alone: session.option("-ksp_type")?.as_deref() == Some("preonly"),
            session: session.clone(),
        };
        let (comm, n, any) = (session.comm(), owned as i32, -1);
        // SAFETY: every handle is an output that `solver` owns from then on and destroys when
        // dropped, also when a later call fails; `rows` and `columns` live through the call that
        // reads (and may reorder) them.
        unsafe {
            if singular {
                let space = &mut solver.null_space;
                check(
                    "MatNullSpaceCreate",
                    ffi::MatNullSpaceCreate(comm, ffi::PETSC_TRUE, 0, ptr::null(), space),
                )?;
            }
            if own.is_none() {
                let (mut rows, mut columns) = pattern();
                check("MatCreate", ffi::MatCreate(comm, &mut solver.matrix))?;
                check("MatSetSizes", ffi::MatSetSizes(solver.matrix, n, n, any, any))?;
                check("MatSetType", ffi::MatSetType(solver.matrix, c"aij".as_ptr()))?;
                check("MatSetPreallocationCOO", {
                    let count = rows.len() as ffi::PetscCount;
                    ffi::MatSetPreallocationCOO(
                        solver.matrix,
                        count,
                        rows.as_mut_ptr(),
                        columns.as_mut_ptr(),
                    )
                })?;
                check(
                    "MatSetOption",
                    ffi::MatSetOption(solver.matrix, ffi::MAT_SYMMETRIC, ffi::PETSC_TRUE),
                )?;
                solver.operator.go_with(session, solver.matrix)?;
                // Our own preconditioners keep constants out by themselves.
                if singular {
                    for matrix in [solver.matrix, solver.operator.matrix] {
                        check("MatSetNullSpace", ffi::MatSetNullSpace(matrix, solver.null_space))?;
                    }
                }
            }
            let (x, b) = (&mut solver.solution, &mut solver.right_side);
            check("MatCreateVecs", ffi::MatCreateVecs(solver.operator.matrix, x, b))?;
            check("KSPCreate", ffi::KSPCreate(comm, &mut solver.krylov))?;
            solver.set_operators()?;
            check("KSPSetFromOptions", ffi::KSPSetFromOptions(solver.krylov))
                .map_err(bad_option)?;
            let mut norm = 0;
            check("KSPGetNormType", ffi::KSPGetNormType(solver.krylov, &mut norm))
                .map_err(bad_option)?;
            solver.tests_true_residual = norm == ffi::KSP_NORM_UNPRECONDITIONED;
            let (mut r, mut a) = (0.0, 0.0);
            let (d, m) = (&mut solver.divergence_tolerance, &mut solver.max_iterations);
            check("KSPGetTolerances", ffi::KSPGetTolerances(solver.krylov, &mut r, &mut a, d, m))?;
        }
        Ok(solver)
    }

    /// Whether the preconditioner is built from the operator's matrix, which has to be set then.
    pub fn needs_matrix(&self) -> bool {
        !self.matrix.is_null()
    }

    /// The matrix's new values, in the order of the pattern; the preconditioner follows at the next
    /// solve.
    pub fn set_values(&mut self, values: &[f64]) -> Result<()> {
        if self.matrix.is_null() {
            return Ok(());
        }
        if let Some(reuse) = &mut self.reuse {
            reuse.stale = true;
        }
        // SAFETY: `values` has the pattern's length, which the caller made.
        check("MatSetValuesCOO", unsafe {
            ffi::MatSetValuesCOO(self.matrix, values.as_ptr(), ffi::INSERT_VALUES)
        })
    }

    /// Refuses what would solve with the preconditioner alone, which knows nothing of the motion of
    /// free bodies.
    ///
    /// # Errors
    /// When the method is `preonly`.
    pub fn refuse_preconditioner_alone(&self) -> Result<()> {
        if self.preconditioner_alone {
            return Err(Error::Usage(
                "-ksp_type preonly solves with the preconditioner alone, which knows nothing of \
                the motion of free \
                 bodies; use cg, bcgs or gmres"
                    .into(),
            ));
        }
        Ok(())
    }

    /// Tells the Krylov solver what to solve for, and what to build the preconditioner from.
    fn set_operators(&mut self) -> Result<()> {
        let operator = self.operator.matrix;
        let from = if self.matrix.is_null() { operator } else { self.matrix };
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

    /// Whether the user fixed the relative tolerance by `-ksp_rtol`.
    pub fn fixed_rtol(&self) -> Option<f64> {
        self.fixed_rtol
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
        if !self.null_space.is_null() {
            // SAFETY: handles made in `new`.
            check("MatNullSpaceRemove", unsafe {
                ffi::MatNullSpaceRemove(self.null_space, self.right_side)
            })?;
        }
        let atol = self.fixed_atol.unwrap_or(if self.tests_true_residual { atol } else { 0.0 });
        let mut spent = 0;
        if let Some(reuse) = self.reuse.filter(|reuse| reuse.stale) {
            if reuse.keeps() {
                self.prepare(rtol, atol, true, reuse.patience(rtol).min(self.max_iterations))?;
                let (reason, iterations) = self.attempt()?;
                if reason > 0 {
                    self.judge(iterations, rtol);
                    return Ok(Solved { iterations, retried: false });
                }
                spent = iterations;
                self.reuse.iter_mut().for_each(Reuse::failed);
                self.forget_guess()?;
            }
            self.reuse.iter_mut().for_each(Reuse::built);
        }
        self.prepare(rtol, atol, false, self.max_iterations)?;
        let (first, mut iterations) = self.attempt()?;
        if first > 0 {
            self.judge(iterations, rtol);
            return Ok(Solved { iterations: spent + iterations, retried: false });
        }
        if first == OVERFLOWN && self.own.is_some() {
            return Err(overflown());
        }
        if self.own.is_some() {
            return Err(Error::Run(format!(
                "the pressure solve failed: {} after {iterations} iterations (relative tolerance \
                {rtol:.1e}); {LOOK}, try \
                 another solver (pressure.solver = \"bcgs-boomeramg\", or `-- -ksp_type cg \
                     -pc_type gamg`), or relax \
                 pressure.divergence_limit",
                reason_name(first),
            )));
        }
        // SAFETY: as above; PCReset forgets the factors, and the next solve sets up anew.
        unsafe {
            let mut pc = ptr::null_mut();
            check("KSPGetPC", ffi::KSPGetPC(self.krylov, &mut pc))?;
            check("PCReset", ffi::PCReset(pc))?;
        }
        self.set_operators()?;
        self.forget_guess()?;
        let (second, more) = self.attempt()?;
        iterations += more;
        if second > 0 {
            self.judge(more, rtol);
            return Ok(Solved { iterations: spent + iterations, retried: true });
        }
        if first == OVERFLOWN && second == OVERFLOWN {
            return Err(overflown());
        }
        Err(Error::Run(format!(
            "the pressure solve failed twice: {} after {} iterations, then, from zero with a \
            rebuilt preconditioner, {} \
             after {more} (relative tolerance {rtol:.1e}); {LOOK}, {}take the default solver \
             (pressure.solver = \"auto\", without \
             -ksp_type and -pc_type), or relax pressure.divergence_limit",
            reason_name(first),
            iterations - more,
            reason_name(second),
            if second == TOO_MANY { "allow more iterations (`-- -ksp_max_it 5000`), " } else { "" },
        )))
    }

    /// Says how far the next attempt goes, and whether it goes on with a preconditioner of another
    /// matrix.
    fn prepare(&mut self, rtol: f64, atol: f64, keep: bool, iterations: i32) -> Result<()> {
        // SAFETY: handles made in `new`.
        unsafe {
            let d = self.divergence_tolerance;
            check(
                "KSPSetTolerances",
                ffi::KSPSetTolerances(self.krylov, rtol, atol, d, iterations),
            )?;
            if self.reuse.is_none() {
                return Ok(());
            }
            let keep = if keep { ffi::PETSC_TRUE } else { ffi::PETSC_FALSE };
            check("KSPSetReusePreconditioner", ffi::KSPSetReusePreconditioner(self.krylov, keep))
        }
    }

    /// With `-ksp_initial_guess_nonzero` a failed attempt's result would be the next one's guess.
    fn forget_guess(&mut self) -> Result<()> {
        // SAFETY: a handle made in `new`.
        check("VecSet", unsafe { ffi::VecSet(self.solution, 0.0) })
    }

    fn judge(&mut self, iterations: u32, rtol: f64) {
        self.reuse.iter_mut().for_each(|reuse| reuse.judge(iterations, rtol));
    }

    fn attempt(&mut self) -> Result<(ffi::KSPConvergedReason, u32)> {
        let (mut reason, mut iterations) = (0, 0);
        // SAFETY: handles made in `new`; outputs are two integers.
        unsafe {
            check("KSPSolve", ffi::KSPSolve(self.krylov, self.right_side, self.solution)).map_err(
                |e| {
                    let ours = self.operator.take_failure();
                    ours.unwrap_or_else(|| if self.proven { e } else { bad_option(e) })
                },
            )?;
            self.proven = true;
            check("KSPGetConvergedReason", ffi::KSPGetConvergedReason(self.krylov, &mut reason))?;
            check(
                "KSPGetIterationNumber",
                ffi::KSPGetIterationNumber(self.krylov, &mut iterations),
            )?;
            if !self.null_space.is_null() {
                // Whatever constant the solver left: the solution has a mean of zero.
                check(
                    "MatNullSpaceRemove",
                    ffi::MatNullSpaceRemove(self.null_space, self.solution),
                )?;
            }
        }
        Ok((reason, iterations.max(0) as u32))
    }

    /// The method and the preconditioner in use, as `bcgs + hypre`.
    pub fn describe(&self) -> Result<String> {
        let name = |n: &str| Ok::<_, Error>(self.session.option(n)?.unwrap_or_else(|| "?".into()));
        Ok(format!("{} + {}", name("-ksp_type")?, name("-pc_type")?))
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

/// What PETSc refuses here, the user asked for.
fn bad_option(error: Error) -> Error {
    match error {
        Error::Petsc { message, .. } => {
            let unknown =
                message.split_once(" type ").and_then(|(_, rest)| rest.split_whitespace().next());
            let capital = unknown.filter(|name| name.chars().any(|c| c.is_ascii_uppercase()));
            let cure = capital.map_or(String::new(), |name| {
                format!("; names of types are in lower case: {}", name.to_lowercase())
            });
            Error::Usage(format!("PETSc refuses an option: {message}{cure}"))
        }
        other => other,
    }
}

/// A numeric option of the user's.
fn number(session: &Session, name: &str) -> Result<Option<f64>> {
    let Some(text) = session.option(name)? else { return Ok(None) };
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value >= 0.0 => Ok(Some(value)),
        _ => Err(Error::Usage(format!(
            "PETSc option {name}: {text:?} is not a tolerance; give a number such as 1e-8"
        ))),
    }
}
