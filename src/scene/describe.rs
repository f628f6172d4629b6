//! What a scene needs and skips, and what solves its pressure, in words.

use super::Scene;
use crate::Result;
use crate::grid::Coefficient;
use crate::method::Kind;
use crate::particles::Body;

impl<const D: usize> Scene<D> {
    /// What the scene needs and what it leaves out, each with its reason.
    pub fn needs(&self) -> Vec<(&'static str, bool, String)> {
        let (bodies, mixture) = (&self.state.bodies, self.method.mixture());
        let come = !self.state.waiting.is_empty();
        let (there, moves) = (come || !bodies.is_empty(), come || bodies.iter().any(Body::moves));
        let field = |c: &Coefficient| matches!(c, Coefficient::Field(_));
        let varies = field(&mixture.density);
        let falls = self.largest_fall() > 0.0;
        let sharp = self.method.kind() == Kind::Sharp;
        let free = self.state.has_free_bodies();
        let touches = self.method.contacts().is_some();
        let why =
            |yes: bool, if_yes: &str, if_no: &str| (if yes { if_yes } else { if_no }).to_owned();
        let inviscid = matches!(mixture.viscosity, Coefficient::Uniform(0.0));
        vec![
            (
                if sharp { "fractions, sharp walls, force" } else { "fractions, mixing, force" },
                there,
                why(there, "there are particles", "no particles"),
            ),
            (
                "fractions at every step",
                moves,
                why(moves, "a particle moves", "nothing moves: found once"),
            ),
            (
                "particle motion (17, 18)",
                free,
                why(free, "a particle is free", "no particle is free to move"),
            ),
            (
                "contacts (20-25)",
                touches,
                why(
                    touches,
                    "where two are in reach; none in reach, no substeps",
                    if free {
                        "the case has no [contact]"
                    } else {
                        "no particle is free to touch another"
                    },
                ),
            ),
            (
                "gravity",
                falls,
                why(
                    falls,
                    "free particles of another density than the fluid's",
                    match (self.domain.fluid.gravity.norm() > 0.0, free) {
                        (false, _) => "the case has none",
                        (true, true) => {
                            "free particles weigh as much as the fluid; its weight is in the \
                            pressure"
                        }
                        (true, false) => {
                            "no particle is free to fall; the fluid's weight is in the pressure, \
                            but for what [drive] takes of it"
                        }
                    },
                ),
            ),
            (
                "coefficient on every face",
                varies || sharp,
                if sharp {
                    "faces are open as far as particles leave them".into()
                } else {
                    why(
                        varies,
                        "a particle's density differs from the fluid's",
                        "one density everywhere",
                    )
                },
            ),
            (
                "pressure operator at every step",
                (varies || sharp) && moves,
                why(
                    (varies || sharp) && moves,
                    "a particle moves",
                    "the coefficients stay: operator and preconditioner are built once",
                ),
            ),
            ("diffusion", !inviscid, why(!inviscid, "viscosity is positive", "inviscid")),
            (
                "full-stress diffusion",
                field(&mixture.viscosity),
                why(
                    field(&mixture.viscosity),
                    "viscosity varies",
                    "one viscosity: the Laplacian is the same and cheaper",
                ),
            ),
            (
                "null space of the pressure",
                !self.domain.boundaries.fixes_pressure(),
                why(
                    self.domain.boundaries.fixes_pressure(),
                    "an outflow fixes the pressure",
                    "no outflow fixes the pressure",
                ),
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
