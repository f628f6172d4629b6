//! What a library's user adds to a run: forces, bodies and sides of its scene, measures, outputs.

use crate::output::Output;
use crate::output::measure::Measure;
use crate::petsc::Session;
use crate::scene::{Additions, Scene};
use crate::{Error, Result};
use serde_json::{Map, Value};
use std::path::Path;

/// What a library's user adds to a run.
#[derive(Default)]
pub struct Extensions<const D: usize> {
    /// To the scene of its case.
    pub scene: Additions,
    /// To the numbers in its `summary.json`.
    pub measures: Vec<Box<dyn Measure<D>>>,
    /// To the files in its folder.
    pub outputs: Vec<Box<dyn Output<D>>>,
}

impl<const D: usize> Extensions<D> {
    /// Refuses two of a name, or one of the names of the case's measures.
    pub(super) fn refuse_names<'a>(&self, others: impl Iterator<Item = &'a str>) -> Result<()> {
        let mut names: Vec<&str> = others.collect();
        let own = self.measures.iter().map(|m| m.name());
        for name in own.chain(self.outputs.iter().map(|output| output.name())) {
            if names.contains(&name) {
                let why = "is the name of two measures or outputs: give another";
                return Err(Error::Usage(format!("{name:?} {why}")));
            }
            names.push(name);
        }
        Ok(())
    }

    /// Begins, or goes on with what was kept. Collective.
    pub(super) fn begin(
        &mut self,
        folder: &Path,
        scene: &mut Scene<D>,
        kept: Option<&str>,
    ) -> Result<()> {
        let session = scene.domain.session.clone();
        let unread = || Error::Usage("what the checkpoint has of measures is no JSON".into());
        let kept: Map<String, Value> = match kept.filter(|kept| !kept.is_empty()) {
            Some(kept) => serde_json::from_str(kept).map_err(|_| unread())?,
            None => Map::new(),
        };
        let of = |name: &str| kept.get(name).and_then(Value::as_str);
        for measure in &mut self.measures {
            let went_on = of(measure.name()).map_or(Ok(()), |kept| measure.go_on(kept));
            session.agree(went_on)?;
        }
        for output in &mut self.outputs {
            let began = output.begin(folder, scene, of(output.name()));
            session.agree(began)?;
        }
        Ok(())
    }

    /// Lets measures take the state after a step. Collective.
    pub(super) fn measure(&mut self, scene: &Scene<D>, largest_speed: f64) -> Result<()> {
        let session = &scene.domain.session;
        self.measures.iter_mut().try_for_each(|m| session.agree(m.take(scene, largest_speed)))
    }

    /// Lets outputs take the state. Collective.
    pub(super) fn write(&mut self, scene: &mut Scene<D>) -> Result<()> {
        let session = scene.domain.session.clone();
        self.outputs.iter_mut().try_for_each(|output| session.agree(output.take(scene)))
    }

    /// What a run that goes on needs; nothing where nothing was added. Collective.
    pub(super) fn kept(&mut self, session: &Session) -> Result<String> {
        let mut all = Map::new();
        for measure in &self.measures {
            all.insert(measure.name().to_owned(), measure.kept().into());
        }
        for output in &mut self.outputs {
            let kept = session.agree(output.kept())?;
            all.insert(output.name().to_owned(), kept.into());
        }
        Ok(if all.is_empty() { String::new() } else { Value::from(all).to_string() })
    }

    /// Ends the outputs. Collective.
    pub(super) fn end(&mut self, folder: &Path, scene: &mut Scene<D>) -> Result<()> {
        let session = scene.domain.session.clone();
        self.outputs.iter_mut().try_for_each(|output| session.agree(output.end(folder, scene)))
    }
}
