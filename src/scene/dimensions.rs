//! Scenes of two and of three dimensions, compiled once with the library. Generic code is compiled
//! again by each program that names it, and a whole step takes a minute.
//!
//! ```text
//!   Scene<D>::extended, step  ->  D = 2: plane, step_plane     (machine code of the library)
//!                                 D = 3: space, step_space
//! ```

use super::{Report, Scene};
use crate::config::Case;
use crate::force::Force;
use crate::particles::Body;
use crate::petsc::Session;
use crate::{Error, Result};
use std::any::Any;
use std::sync::Arc;

/// As [`Scene::extended`].
pub(super) fn build<const D: usize>(
    session: &Session,
    case: &Case,
    bodies: Option<Vec<Body>>,
    forces: Vec<Arc<dyn Force>>,
) -> Result<Scene<D>> {
    let made = if D == 2 {
        same(plane(session, case, bodies, forces))
    } else {
        same(space(session, case, bodies, forces))
    };
    made.unwrap_or_else(|| Err(other_dimension()))
}

/// As [`Scene::step`].
pub(super) fn step<const D: usize>(scene: &mut Scene<D>, dt: f64) -> Result<Report> {
    let scene: &mut dyn Any = scene;
    if let Some(scene) = scene.downcast_mut() {
        return step_plane(scene, dt);
    }
    scene.downcast_mut().map_or_else(|| Err(other_dimension()), |scene| step_space(scene, dt))
}

fn plane(
    session: &Session,
    case: &Case,
    bodies: Option<Vec<Body>>,
    forces: Vec<Arc<dyn Force>>,
) -> Result<Scene<2>> {
    Scene::build(session, case, bodies, forces)
}

fn space(
    session: &Session,
    case: &Case,
    bodies: Option<Vec<Body>>,
    forces: Vec<Arc<dyn Force>>,
) -> Result<Scene<3>> {
    Scene::build(session, case, bodies, forces)
}

fn step_plane(scene: &mut Scene<2>, dt: f64) -> Result<Report> {
    scene.advance(dt)
}

fn step_space(scene: &mut Scene<3>, dt: f64) -> Result<Report> {
    scene.advance(dt)
}

/// The value, if its type is the one that is asked for.
fn same<A: 'static, B: 'static>(value: A) -> Option<B> {
    let value: Box<dyn Any> = Box::new(value);
    value.downcast().ok().map(|value| *value)
}

fn other_dimension() -> Error {
    Error::Usage("a scene has two or three dimensions".into())
}
