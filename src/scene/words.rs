//! What a scene needs and skips, and what solves its pressure, in words.

use super::Scene;
use crate::Result;
use crate::coupling::Coupling;
use crate::grid::Coefficient;

impl<const D: usize> Scene<D> {
    /// What the scene needs and what it leaves out, each with its reason.
    pub fn needs(&self) -> Vec<(&'static str, bool, String)> {
        let particles = self.coupling.as_ref();
        let field = |c: &Coefficient| matches!(c, Coefficient::Field(_));
        let moves = particles.is_some_and(Coupling::moves);
        let varies = field(&self.density);
        let falls = particles.is_some_and(|c| c.largest_fall() > 0.0);
        let sharp = matches!(particles, Some(Coupling::Sharp(_)));
        let flies = particles.is_some_and(Coupling::flies);
        let touches = particles.is_some_and(|c| c.contacts().is_some());
        let why = |yes: bool, if_yes: &str, if_no: &str| (if yes { if_yes } else { if_no }).to_owned();
        let inviscid = matches!(self.viscosity, Coefficient::Uniform(0.0));
        vec![
            (
                if sharp { "fractions, sharp walls, force" } else { "fractions, mixing, force" },
                particles.is_some(),
                why(particles.is_some(), "there are particles", "no particles"),
            ),
            ("fractions at every step", moves, why(moves, "a particle moves", "nothing moves: found once")),
            ("particle motion (17, 18)", flies, why(flies, "a particle is free", "no particle is free to move")),
            (
                "contacts (20-25)",
                touches,
                why(
                    touches,
                    "where two are in reach; none in reach, no substeps",
                    if flies {
                        "the case has no [contact]: a touch ends the run"
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
                    "held particles carry their own weight; the fluid's is in the pressure",
                ),
            ),
            (
                "coefficient on every face",
                varies || sharp,
                if sharp {
                    "faces are open as far as particles leave them".into()
                } else {
                    why(varies, "a particle's density differs from the fluid's", "one density everywhere")
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
                field(&self.viscosity),
                why(field(&self.viscosity), "viscosity varies", "one viscosity: the Laplacian is the same and cheaper"),
            ),
            (
                "null space of the pressure",
                !self.boundaries.fixes_pressure(),
                why(self.boundaries.fixes_pressure(), "an outflow fixes the pressure", "no outflow fixes the pressure"),
            ),
        ]
    }

    /// The solver of the pressure equation and why it is taken, as `cg + boxmg (auto: ...)`.
    pub fn solver(&self) -> Result<String> {
        let solver = self.projection.solver();
        let reason = if solver.chosen_by_options()? { "PETSc's options" } else { self.solver_reason };
        Ok(format!("{} ({reason})", solver.describe()?))
    }
}
