//! What a scene needs and skips, and what solves its pressure, in words.

use super::Scene;
use crate::Result;
use crate::grid::Coefficient;
use crate::method::Kind;
use crate::particles::Body;

/// What a scene may need, whether it does, and why.
type Need = (&'static str, bool, String);

/// A need with the reason for either case.
fn need(what: &'static str, needed: bool, if_yes: &str, if_no: &str) -> Need {
    (what, needed, (if needed { if_yes } else { if_no }).to_owned())
}

impl<const D: usize> Scene<D> {
    /// What the scene needs and what it leaves out, each with its reason.
    pub fn needs(&self) -> Vec<Need> {
        let moves = !self.state.waiting.is_empty() || self.state.bodies.iter().any(Body::moves);
        let fields = self.needs_of_pressure_and_viscosity(moves);
        self.needs_of_bodies(moves).into_iter().chain(fields).collect()
    }

    fn needs_of_bodies(&self, moves: bool) -> [Need; 5] {
        let there = !self.state.waiting.is_empty() || !self.state.bodies.is_empty();
        let falls = self.largest_fall() > 0.0;
        let free = self.state.has_free_bodies();
        let touches = self.method.contacts().is_some();
        let fractions = match self.method.kind() {
            Kind::Sharp => "fractions, sharp surfaces, force",
            _ => "fractions, mixing, force",
        };
        let no_contacts = match free {
            true => "the case has no [contact]",
            false => "no particle is free to touch another",
        };
        let no_fall = match (self.domain.fluid.gravity.norm() > 0.0, free) {
            (false, _) => "the case has none",
            (true, true) => {
                "free particles weigh as much as the fluid; its weight is in the pressure"
            }
            (true, false) => {
                "no particle is free to fall; the fluid's weight is in the pressure, but for what \
                [drive] takes of it"
            }
        };
        let in_reach = "where two are in reach; none in reach, no substeps";
        let no_motion = "no particle is free to move";
        [
            need(fractions, there, "there are particles", "no particles"),
            need("fractions at every step", moves, "a particle moves", "nothing moves: found once"),
            need("particle motion (17, 18)", free, "a particle is free", no_motion),
            need("contacts (20-25)", touches, in_reach, no_contacts),
            need("gravity", falls, "free particles of another density than the fluid's", no_fall),
        ]
    }

    fn needs_of_pressure_and_viscosity(&self, moves: bool) -> [Need; 5] {
        let mixture = self.method.mixture();
        let field = |c: &Coefficient| matches!(c, Coefficient::Field(_));
        let sharp = self.method.kind() == Kind::Sharp;
        let varies = sharp || field(&mixture.density);
        let inviscid = matches!(mixture.viscosity, Coefficient::Uniform(0.0));
        let fixed = self.domain.boundaries.fixes_pressure();
        let on_faces = match sharp {
            true => "faces are open as far as particles leave them",
            false => "a particle's density differs from the fluid's",
        };
        [
            need("coefficient on every face", varies, on_faces, "one density everywhere"),
            need(
                "pressure operator at every step",
                varies && moves,
                "a particle moves",
                "the coefficients stay: operator and preconditioner are built once",
            ),
            need("diffusion", !inviscid, "viscosity is positive", "inviscid"),
            need(
                "full-stress diffusion",
                field(&mixture.viscosity),
                "viscosity varies",
                "one viscosity: the Laplacian is the same and cheaper",
            ),
            need(
                "null space of the pressure",
                !fixed,
                "no outflow fixes the pressure",
                "an outflow fixes the pressure",
            ),
        ]
    }

    /// The stages of the step that took time, with nanoseconds a cell and step. What the paper's
    /// method calls mixing is, with sharp surfaces, the velocity that these impose.
    pub fn stages(&self) -> Vec<(&'static str, f64)> {
        let sharp = self.method.kind() == Kind::Sharp;
        let name = |name| if sharp && name == "mixing" { "walls" } else { name };
        let stages = self.domain.clock.table(self.domain.grid.total_cells());
        stages.into_iter().map(|(own, time)| (name(own), time)).collect()
    }

    /// The solver of the pressure equation and why it is taken, as `cg + boxmg (auto: ...)`.
    pub fn solver(&self) -> Result<String> {
        let solver = self.domain.projection.solver();
        let reason =
            if solver.chosen_by_options()? { "PETSc's options" } else { self.solver_reason };
        Ok(format!("{} ({reason})", solver.describe()?))
    }
}
