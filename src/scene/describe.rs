//! Parts of a step that a scene needs or skips, with reasons, and the time of its stages.

use super::Scene;
use crate::grid::Coefficient;
use crate::method::MethodKind;
use crate::particles::Body;
use mics_run::summary::Need;

/// A part of a step, whether it is needed, and why, for either case.
fn need(what: &str, needed: bool, if_yes: &str, if_no: &str) -> Need {
    let why = if needed { if_yes } else { if_no };
    Need { what: what.to_owned(), needed, why: why.to_owned() }
}

/// Parts of a step that the scene needs or leaves out, each with its reason.
pub fn needs<const D: usize>(scene: &Scene<D>) -> Vec<Need> {
    let moves = !scene.state.waiting.is_empty() || scene.state.bodies.iter().any(Body::moves);
    [needs_of_bodies(scene, moves), needs_of_fields(scene, moves)].concat()
}

fn needs_of_bodies<const D: usize>(scene: &Scene<D>, moves: bool) -> Vec<Need> {
    let there = !scene.state.waiting.is_empty() || !scene.state.bodies.is_empty();
    let falls = scene.largest_fall() > 0.0;
    let free = scene.state.has_free_bodies();
    let touches = scene.method.contacts().is_some();
    let fractions = match scene.method.kind() {
        MethodKind::Sharp => "fractions, sharp surfaces, force",
        _ => "fractions, mixing, force",
    };
    let held =
        if free { "the case has no [contact]" } else { "no particle is free to touch another" };
    let weightless = match (scene.domain.fluid.gravity.norm() > 0.0, free) {
        (false, _) => "the case has none",
        (true, true) => "free particles weigh as much as the fluid; its weight is in the pressure",
        (true, false) => {
            "no particle is free to fall; the fluid's weight is in the pressure, but for what \
            [drive] takes of it"
        }
    };
    let in_reach = "where two are in reach; none in reach, no substeps";
    let heavy = "free particles of another density than the fluid's";
    let still = "nothing moves: found once";
    let fixed = "no particle is free to move";
    vec![
        need(fractions, there, "there are particles", "no particles"),
        need("fractions at every step", moves, "a particle moves", still),
        need("particle motion (17, 18)", free, "a particle is free", fixed),
        need("contacts (20-25)", touches, in_reach, held),
        need("gravity", falls, heavy, weightless),
    ]
}

fn needs_of_fields<const D: usize>(scene: &Scene<D>, moves: bool) -> Vec<Need> {
    let mixture = scene.method.mixture();
    let field = |c: &Coefficient| matches!(c, Coefficient::Field(_));
    let sharp = scene.method.kind() == MethodKind::Sharp;
    let varies = sharp || field(&mixture.density);
    let viscous = !matches!(mixture.viscosity, Coefficient::Uniform(0.0));
    let stress = field(&mixture.viscosity);
    let floats = !scene.domain.boundaries.fixes_pressure();
    let on_faces = match sharp {
        true => "faces are open as far as particles leave them",
        false => "a particle's density differs from the fluid's",
    };
    let changes = varies && moves;
    let stays = "the coefficients stay: operator and preconditioner are built once";
    let laplacian = "one viscosity: the Laplacian is the same and cheaper";
    let free = "no outflow fixes the pressure";
    let fixed = "an outflow fixes the pressure";
    vec![
        need("coefficient on every face", varies, on_faces, "one density everywhere"),
        need("pressure operator at every step", changes, "a particle moves", stays),
        need("diffusion", viscous, "viscosity is positive", "inviscid"),
        need("full-stress diffusion", stress, "viscosity varies", laplacian),
        need("null space of the pressure", floats, free, fixed),
    ]
}

/// The stages of the step that took time, with nanoseconds a cell and step. With sharp surfaces the
/// stage `mixing` is called `walls`: the velocity that these impose.
pub fn stages<const D: usize>(scene: &Scene<D>) -> Vec<(&'static str, f64)> {
    let sharp = scene.method.kind() == MethodKind::Sharp;
    let name = |name| if sharp && name == "mixing" { "walls" } else { name };
    let stages = scene.domain.clock.table(scene.domain.grid.total_cells());
    stages.into_iter().map(|(own, time)| (name(own), time)).collect()
}
