//! A case written out as a file that gives every key, for the run's folder; it reads back to an
//! equal case.

use super::shape::solid::Solid;
use super::{Case, Like, Obstacle, Particle, Typed, Which};
use serde::Serialize;

/// The case as TOML, of one that has been read.
pub(super) fn toml(case: &Case) -> String {
    let mut rest = case.clone();
    let particles = std::mem::take(&mut rest.particle);
    let obstacles = std::mem::take(&mut rest.obstacle);
    if rest.initial.from.is_some() {
        rest.initial.velocity.clear();
    }
    for measure in rest.measure.iter_mut().filter(|m| m.obstacle.is_some()) {
        // As a body the obstacle follows the particles; it is typed by its own number.
        measure.particle = Which::default();
        measure.particles = None;
    }
    // Bodies one by one at the end: the time that a list of tables takes grows with its square.
    let mut text = text(&rest);
    let mut before = Vec::new();
    for (index, mut body) in particles.into_iter().enumerate() {
        if let Some(solid) = body.shape.solid() {
            body.shape = referred(solid, index, &mut before).into();
        }
        text.push('\n');
        text += &self::text(&Listed { particle: [body] });
    }
    for wall in obstacles {
        text.push('\n');
        text += &self::text(&Walls { obstacle: [wall] });
    }
    text
}

/// Description in a case of the solid of the body of this number: long lists of points once, in the
/// first body that has them; `before` are such bodies.
fn referred(solid: &Solid, index: usize, before: &mut Vec<(usize, Solid)>) -> Typed {
    if solid.detail().is_empty() {
        return solid.typed();
    }
    let scaled = solid.wanted().is_some();
    let like =
        |(_, other): &&(usize, Solid)| other.wanted().is_some() == scaled && other.is_like(solid);
    if let Some((first, _)) = before.iter().find(like) {
        return Typed::Like(Like { particle: *first, diameter: solid.wanted() });
    }
    before.push((index, solid.clone()));
    solid.typed()
}

/// One of the bodies of a file.
#[derive(Serialize)]
struct Listed {
    particle: [Particle; 1],
}

/// One of the obstacles of a file.
#[derive(Serialize)]
struct Walls {
    obstacle: [Obstacle; 1],
}

fn text(part: &impl Serialize) -> String {
    toml::to_string(part).expect("numbers, texts, lists and tables with text keys are TOML")
}
