//! What a library's user lets a run write besides its own files.

use crate::Result;
use crate::scene::Scene;
use std::path::Path;

/// Something that a run writes. Every rank calls all of it, in this order, and an error on one rank
/// ends the run on all; files are rank 0's to write
/// (`scene.domain.session.rank()`, [`Rows`](super::Rows)).
pub trait Output<const D: usize> {
    /// Its name, by which a checkpoint knows it: another one than those of a run's other outputs
    /// and measures.
    fn name(&self) -> &str;

    /// Begins in a run's folder. `kept` is what [`Output::kept`] gave on rank 0 at the checkpoint
    /// that the run goes on from: what was written after it has to be dropped. It is `None` where
    /// the run begins, or went on without this output until now.
    ///
    /// # Errors
    /// When files cannot be made, or are not those of the checkpoint.
    fn begin(&mut self, folder: &Path, scene: &mut Scene<D>, kept: Option<&str>) -> Result<()>;

    /// Takes the state of the scene: at the start, of a run that does not go on from a checkpoint,
    /// and after every step.
    ///
    /// # Errors
    /// When it cannot be written.
    fn take(&mut self, scene: &mut Scene<D>) -> Result<()>;

    /// Brings all that was taken to the disk, and says what a run that goes on from here needs.
    ///
    /// # Errors
    /// When it cannot be written.
    fn kept(&mut self) -> Result<String> {
        Ok(String::new())
    }

    /// Ends: the run is done, or was interrupted.
    ///
    /// # Errors
    /// When it cannot be written.
    fn end(&mut self, folder: &Path, scene: &mut Scene<D>) -> Result<()>;
}
