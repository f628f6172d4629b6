//! Whether this machine can hold the grid.

use crate::Result;
use crate::config::Loaded;
use crate::petsc::Session;
use crate::system::free_memory;

/// Refuses a grid that this machine's memory cannot hold, before it is tried: the system would kill
/// the run with no message. Ranks on other machines have their own memory and are not asked for.
pub fn check_memory(loaded: &Loaded, session: &Session) -> Result<()> {
    // Measured peaks: `peak_memory_bytes_per_cell` in summary.json at 1024^2 and 96 x 64 x 64.
    let per_cell = if loaded.case.dimension() == 2 { 900.0 } else { 1500.0 };
    let needed = per_cell * loaded.case.domain.cells.iter().map(|n| *n as f64).product::<f64>();
    let free = free_memory();
    session.agree(if free == 0.0 || needed < free {
        Ok(())
    } else {
        Err(loaded.error_at(
            "domain.cells",
            format!(
                "this grid takes about {:.1} GB of memory, and {:.1} GB are free here; use fewer \
                cells",
                needed / 1e9,
                free / 1e9
            ),
        ))
    })
}
