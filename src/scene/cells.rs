//! Number of cells that a grid must have for the walls that a case asks for.

use crate::Result;
use crate::config::{Case, Loaded, WallRule, load};
use crate::method::sharp;
use std::path::Path;

/// Whether there are sharp surfaces in the fluid.
fn walls_are_sharp(case: &Case) -> bool {
    case.coupling.wall == WallRule::Sharp && case.has_bodies()
}

/// Reads a case as [`load`] does, one that a scene can be built of.
///
/// # Errors
/// When the case is wrong, or its grid has too few cells for its walls.
pub fn read_case(path: &Path, overrides: &[String]) -> Result<Loaded> {
    let loaded = load(path, overrides)?;
    check_cells(&loaded)?;
    Ok(loaded)
}

/// Refuses a grid with too few cells: the profile beside a sharp surface is read from cells some
/// way off, of the box or, across a period, of one image of it.
fn check_cells(loaded: &Loaded) -> Result<()> {
    let case = &loaded.case;
    if !walls_are_sharp(case) {
        return Ok(());
    }
    let needed = sharp::ghost_width(&case.spacings()).1;
    let Some(axis) = case.domain.cells.iter().position(|cells| *cells < needed) else {
        return Ok(());
    };
    Err(loaded.error_at(
        &format!("domain.cells.{axis}"),
        format!(
            "must be at least {needed} with sharp surfaces (the profile beside them is read so far \
            away), not {}: use more \
             cells, or coupling.wall = \"mixing\"",
            case.domain.cells[axis]
        ),
    ))
}
