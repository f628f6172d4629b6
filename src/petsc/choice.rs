//! Default solvers where PETSc's options leave it open, and options that are refused.

use super::Session;
use super::layout::Layout;
use crate::{Error, Result};

/// Solver where PETSc's options leave it open.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choice {
    /// BCGS with BoomerAMG.
    BcgsBoomeramg,
    /// Conjugate gradients with the operator's own multigrid.
    Multigrid,
}

/// A choice's options, on the true residual, with a coarsest solve that a singular matrix allows.
pub(super) fn default_options(session: &Session, choice: Choice, layout: &Layout) -> Result<()> {
    let dimension = layout.dimension();
    session.forget_default_options()?;
    let (method, preconditioner) = match choice {
        Choice::BcgsBoomeramg => ("bcgs", "hypre"),
        Choice::Multigrid => ("cg", "boxmg"),
    };
    session.default_option("-ksp_type", method)?;
    if choice == Choice::Multigrid && !session.user_option("-ksp_type")? {
        // The sums of an iteration go over the ranks at once.
        session.default_option("-ksp_cg_single_reduction", "true")?;
    }
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
    if session.option("-pc_type")?.as_deref() == Some("mg") {
        grid_multigrid_options(session, layout)?;
    }
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

/// Cells of the coarsest grid up to which it is solved densely, in less than a solve's other work.
const LARGEST_DENSE: usize = 400;

/// Sets the options of PETSc's multigrid on the grid: as many levels as all axes can be halved,
/// coarse operators by Galerkin's product of the matrix, smoothers that go by the matrix, and a
/// coarsest solve that a singular matrix allows.
fn grid_multigrid_options(session: &Session, layout: &Layout) -> Result<()> {
    let halvings = layout.halvings();
    session.default_option("-pc_mg_levels", &(halvings + 1).to_string())?;
    let levels = number(session, "-pc_mg_levels")?.unwrap_or(1.0);
    if levels > (halvings + 1) as f64 {
        return Err(Error::Usage(format!(
            "PETSc option -pc_mg_levels {levels}: each level halves the cells along all axes, \
            down to two, which this grid allows {halvings} times: at most {} levels; change \
            domain.cells, or take -pc_type gamg or hypre, which coarsen the matrix",
            halvings + 1
        )));
    }
    session.default_option("-pc_mg_galerkin", "pmat")?;
    match session.option("-pc_mg_galerkin")?.as_deref() {
        Some("pmat") => {}
        Some(other) => {
            return Err(Error::Usage(format!(
                "PETSc option -pc_mg_galerkin {other}: coarse operators are the products of the \
                matrix of the fluid (pmat); the operator itself, with the free bodies in it, is \
                applied without a matrix, and nothing assembles it on coarser grids"
            )));
        }
        None => {}
    }
    session.default_option("-mg_levels_ksp_type", "richardson")?;
    session.default_option("-mg_levels_pc_type", "sor")?;
    let coarsest = layout.whole.iter().map(|(cells, _)| cells >> (levels as usize - 1));
    if coarsest.product::<usize>() > LARGEST_DENSE {
        return session.default_option("-mg_coarse_pc_type", "gamg");
    }
    session.default_option("-mg_coarse_pc_type", "redundant")?;
    session.default_option("-mg_coarse_redundant_pc_type", "svd")
}

/// Refuses options with which this PETSc ends the program.
pub(super) fn refuse_what_ends_the_program(session: &Session) -> Result<()> {
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

/// Whether an option has a matrix written with its numbers.
pub(super) fn writes_numbers(session: &Session, name: &str) -> Result<bool> {
    let value = session.option(name)?.unwrap_or_default();
    Ok(["binary", "hdf5", "matlab", "draw"].iter().any(|kind| value.starts_with(kind)))
}

/// Refuses to write a matrix where there is none: with a preconditioner of the operator's own, and
/// of the operator of a `singular` system.
pub(super) fn refuse_empty_views(session: &Session, own: bool, singular: bool) -> Result<()> {
    for (name, of_operator) in [("-ksp_view_mat", true), ("-ksp_view_pmat", false)] {
        let why = match (own, singular && of_operator) {
            (true, _) => "there is no matrix to write, the operator is applied without one",
            (_, true) => "the operator of a closed box is the matrix less what keeps that definite",
            _ => continue,
        };
        if writes_numbers(session, name)? {
            return Err(Error::Usage(format!(
                "PETSc option {name}: {why}; `mics export-system` writes it, and -ksp_view_pmat \
                with -pc_type hypre or gamg the matrix of the fluid"
            )));
        }
    }
    Ok(())
}

/// Words of PETSc's refusals of preconditioners that cannot work here, and why.
const CANNOT: [(&str, &str); 6] = [
    (
        "Could not locate a solver type for factorization type",
        "on several ranks a factorization is one of each rank's block: take -pc_type bjacobi or \
        asm with -sub_pc_type icc or ilu; lu and cholesky of all work by \
        -pc_factor_mat_solver_type mumps",
    ),
    ("MATIS", "it needs a matrix by subdomains, which is not made here; take asm or bjacobi"),
    (
        "different mat and pmat",
        "it needs the operator as a matrix, and the operator is applied with the free bodies in \
        it; sor is the same iteration",
    ),
    ("PCSetDM()", "it is for finite elements; -pc_type mg and boxmg work on the grid"),
    ("PCPATCH", "it is for finite elements; -pc_type asm and bjacobi divide the grid"),
    ("at least two fields", "the pressure is one field"),
];

/// Turns a refusal of PETSc's into one of an option that the user gave.
pub(super) fn bad_option(error: Error) -> Error {
    match error {
        Error::Petsc { message, .. } => {
            let unknown =
                message.split_once(" type ").and_then(|(_, rest)| rest.split_whitespace().next());
            let capital = unknown.filter(|name| name.chars().any(|c| c.is_ascii_uppercase()));
            let cure = match CANNOT.iter().find(|(words, _)| message.contains(words)) {
                Some((_, why)) => format!("; {why}"),
                None => capital.map_or(String::new(), |name| {
                    format!("; names of types are in lower case: {}", name.to_lowercase())
                }),
            };
            Error::Usage(format!("PETSc refuses an option: {message}{cure}"))
        }
        other => other,
    }
}

/// The user's `-ksp_rtol`.
pub(super) fn relative_tolerance(session: &Session) -> Result<Option<f64>> {
    match number(session, "-ksp_rtol")? {
        Some(rtol) if rtol >= 1.0 => Err(Error::Usage(format!(
            "PETSc option -ksp_rtol: {rtol:?} asks for no reduction; give a number below 1, such \
            as 1e-8"
        ))),
        given => Ok(given),
    }
}

/// A numeric option of the user's.
pub(super) fn number(session: &Session, name: &str) -> Result<Option<f64>> {
    let Some(text) = session.option(name)? else { return Ok(None) };
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value >= 0.0 => Ok(Some(value)),
        _ => Err(Error::Usage(format!(
            "PETSc option {name}: {text:?} is not a tolerance; give a number such as 1e-8"
        ))),
    }
}
