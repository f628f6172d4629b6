//! The `README.md` of an exported system: a page of words with the system's numbers filled in.

use super::About;
use mics::run::{BodiesInBox, Exported};
use mics_run::words::rounded;

/// Text of the page: the system, its files, and how to read and solve it.
const PAGE: &str = include_str!("readme.md");

/// The page.
pub fn page(about: &About) -> String {
    let Exported { system, step, time, dt, solver, options, petsc, .. } = about.exported;
    let places = [
        ("@CASE@", format!("{}, step {step}, solve {}", about.name, about.solve)),
        ("@VERSION@", env!("CARGO_PKG_VERSION").into()),
        ("@GRID@", grid(about.exported)),
        ("@TIME@", format!("the step from t = {} to {} s", rounded(time - dt), rounded(*time))),
        ("@BODIES@", bodies(about.exported)),
        ("@UNKNOWNS@", system.fluid.rows().to_string()),
        ("@NONZEROS@", about.nonzeros()),
        ("@SINGULAR@", if system.singular { SINGULAR } else { REGULAR }.into()),
        ("@RESIDUAL@", format!("{:.1e}", system.residual)),
        ("@RUN@", format!("{solver}: {}", about.own_solve())),
        ("@OPTIONS@", format!("`{}` (PETSc {petsc})", options.trim())),
    ];
    places.iter().fold(PAGE.to_owned(), |page, (place, text)| page.replace(place, text))
}

const SINGULAR: &str = "yes: no boundary fixes the pressure, and constants are the null space \
    (`null`); the mean is taken out of b, and x is the solution whose mean is zero";
const REGULAR: &str = "no: an outflow fixes the pressure";

fn grid(exported: &Exported) -> String {
    let cells: Vec<String> = exported.cells.iter().map(usize::to_string).collect();
    let spacing: Vec<String> = exported.spacing.iter().map(|h| rounded(*h)).collect();
    format!("{} cells of {} m", cells.join(" x "), spacing.join(" x "))
}

fn bodies(exported: &Exported) -> String {
    let BodiesInBox { count, free, density_ratios } = exported.bodies;
    let Some((least, most)) = density_ratios else { return "none in the box".into() };
    format!(
        "{count} in the box, {free} of them free; density over the fluid's: {} to {}",
        rounded(least),
        rounded(most)
    )
}
