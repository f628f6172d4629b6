//! The prediction (7) in Legendre stages, where viscosity binds the step more than the flow does
//! ([`legendre`](crate::scheme::legendre) has the formulas).

use super::momentum::{Mixture, Momentum};
use crate::Result;
use crate::clock::Stage as Lap;
use crate::domain::Domain;
use crate::grid::{Grid, VectorField};
use crate::kernels::boundary::{self, Sides};
use crate::kernels::{diffusion, faces};
use crate::particles::Body;
use crate::scheme::Scheme;
use crate::scheme::legendre::{Legendre, Stage};
use crate::state::State;

/// What the stages need beside the state.
pub struct Stabilised<const D: usize> {
    /// Of three stages, of four, and so on.
    sets: Vec<Legendre>,
    /// The rate at the start of the step (m/s2).
    first: VectorField<D>,
    /// Velocities of the last stage and of the one before it (m/s).
    last: VectorField<D>,
    before: VectorField<D>,
}

/// What a stage's velocity (m/s) is made into before its rate is taken: its ghosts filled, walls
/// imposed.
pub type Finish<'a, const D: usize> =
    &'a mut dyn FnMut(&mut Domain<D>, &[Body], &Stage, &mut VectorField<D>) -> Result<()>;

impl<const D: usize> Stabilised<D> {
    /// That of a scheme which has such stages.
    pub fn new(grid: &Grid<D>, scheme: &Scheme) -> Option<Stabilised<D>> {
        let sets = (3..=scheme.most_stages?).map(Legendre::new).collect();
        Some(Stabilised {
            sets,
            first: grid.vector_field(),
            last: grid.vector_field(),
            before: grid.vector_field(),
        })
    }

    /// Whether a step of `dt` (s) needs them.
    pub fn is_for(&self, domain: &Domain<D>, scheme: &Scheme, dt: f64) -> bool {
        stages(domain, scheme, dt) > scheme.weights.len()
    }

    /// (7) over `dt` (s): the velocity `s.u` (m/s), ghosts filled, becomes that at the end of the
    /// step with the `acceleration` on faces (m/s2), as the last stage was left by `finish`.
    /// Returns the forces of this rank's sides on the fluid, where a balance is kept. Collective.
    #[allow(clippy::too_many_arguments)]
    pub fn predict(
        &mut self,
        momentum: &mut Momentum<D>,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        mixture: &Mixture,
        acceleration: &VectorField<D>,
        dt: f64,
        finish: Finish<D>,
    ) -> Result<Sides> {
        let Stabilised { sets, first, last, before } = self;
        let count = stages(domain, &momentum.scheme, dt);
        let legendre = &sets[count - 3];
        let mut sides = Sides::zeros();
        let mut weight = legendre.weight;
        for (k, stage) in legendre.stages.iter().enumerate() {
            let u = if k == 0 { &s.u } else { &*last };
            let carrier = momentum.carrier(s, dt);
            if s.balance.is_some() {
                let density = domain.fluid.density;
                let viscosity = &mixture.viscosity;
                sides += weight * boundary::stress(&domain.grid, &carrier, u, density, viscosity);
                domain.clock.lap(Lap::Force);
            }
            momentum.add_weighted(domain, (1.0, true), mixture, &carrier, u, dt, None)?;
            if k == 0 {
                momentum.swap_rate(first);
                for (field, u) in before.iter_mut().zip(&s.u) {
                    field.copy_from_slice(u);
                }
                let rate = (dt * stage.part(), &*first);
                faces::step_cells(
                    &domain.grid,
                    Some(&s.u),
                    rate,
                    (dt * stage.part(), acceleration),
                    last,
                );
            } else {
                let rates = [(dt * stage.rate, momentum.rate()), (dt * stage.first, &*first)];
                let terms = [(stage.start, &s.u), (stage.last, &*last), rates[0], rates[1]];
                faces::recur_cells(
                    &domain.grid,
                    stage.before,
                    terms,
                    (dt * stage.part(), acceleration),
                    before,
                );
                std::mem::swap(last, before);
            }
            domain.clock.lap(Lap::Update);
            finish(domain, &s.bodies, stage, last)?;
            weight = stage.weight;
        }
        std::mem::swap(&mut s.u, last);
        Ok(sides)
    }
}

/// How many stages a step of `dt` (s) takes.
fn stages<const D: usize>(domain: &Domain<D>, scheme: &Scheme, dt: f64) -> usize {
    let nu = domain.fluid.viscosity / domain.fluid.density;
    scheme.stages_for(dt * diffusion::limit_rate(&domain.grid.h, nu, false))
}
