//! The prediction (7) in the stages of the time scheme: its own, or Legendre stages where viscosity
//! binds the step more than the flow does ([`crate::scheme::legendre`] has the formulas).
//!
//! ```text
//!   u_k  = u^n + dt ( c_k rate + b_k a ),     rate = sum of w_j R(u_j) over the stages before
//!   u*   = u^n + dt ( rate + b a )
//!              R: the terms without pressure ([`super::momentum`]), a: by the last pressure
//! ```
//! Each stage's velocity is finished by the walls before its rate is taken: ghosts filled, and what
//! bodies impose. Without bodies the walls do nothing but fill ghosts.

use super::momentum::{Hears, MixtureProperties, Momentum, Rated};
use crate::Result;
use crate::clock::Stage as Lap;
use crate::domain::Domain;
use crate::grid::{Grid, VectorField};
use crate::kernels::advection::Carrier;
use crate::kernels::boundary::{self, Sides};
use crate::kernels::{diffusion, faces};
use crate::scheme::Scheme;
use crate::scheme::legendre::{self, Legendre};
use crate::state::State;

/// A velocity of a step that the walls finish.
#[derive(Clone, Copy, Debug)]
pub enum Within<'a> {
    /// Velocity of a stage, which has this part of the step's acceleration.
    Stage(f64),
    /// Velocity of a Legendre stage; the last of them is the end.
    Legendre(&'a legendre::Stage),
    /// Velocity at the end of the step, after the scheme's own stages.
    End,
}

/// Boundaries of the fluid within a step: the sides of the box, and bodies.
pub trait Walls<const D: usize> {
    /// Part of the last pressure's acceleration that u* has.
    const PRESSURE: f64;

    /// Makes a velocity `u` (m/s) of a step of `dt` (s) from the state `s` what the next rate is
    /// taken of: ghosts filled, walls imposed. Collective.
    fn finish(
        &mut self,
        domain: &mut Domain<D>,
        s: &State<D>,
        within: Within,
        dt: f64,
        u: &mut VectorField<D>,
    ) -> Result<()>;

    /// Observer of the terms of (7), if there is one.
    fn hears(&mut self) -> Option<Hears<'_, D>> {
        None
    }
}

/// The terms of (7) and the scheme that steps them.
pub struct Prediction<const D: usize> {
    /// The time scheme.
    pub scheme: Scheme,
    momentum: Momentum<D>,
    /// Velocity that a stage after the first starts from (m/s); between steps it is scratch.
    pub stage: VectorField<D>,
    /// `None` where the scheme has no such stages.
    long: Option<LegendreStages<D>>,
}

/// Coefficients and fields of Legendre stages beside the velocity of the last one.
struct LegendreStages<const D: usize> {
    /// Coefficients for three stages, for four, and so on.
    sets: Vec<Legendre>,
    /// The rate at the start of the step (m/s2).
    first: VectorField<D>,
    /// Velocity of the stage before the last one (m/s).
    before: VectorField<D>,
}

impl<const D: usize> Prediction<D> {
    /// The terms by a scheme.
    pub fn new(grid: &Grid<D>, scheme: Scheme, momentum: Momentum<D>) -> Prediction<D> {
        let long = |most: usize| LegendreStages {
            sets: (3..=most).map(Legendre::new).collect(),
            first: grid.vector_field(),
            before: grid.vector_field(),
        };
        let long = scheme.most_stages.map(long);
        Prediction { scheme, momentum, stage: grid.vector_field(), long }
    }

    /// Whether advection conserves momentum: what it takes of one cell another gets, but for the
    /// sides of the box.
    pub fn keeps_momentum(&self) -> bool {
        self.momentum.keeps_momentum()
    }

    /// Whether a step of `dt` (s) needs Legendre stages.
    pub fn is_long(&self, domain: &Domain<D>, dt: f64) -> bool {
        self.long.is_some() && self.count(domain, dt) > self.scheme.weights.len()
    }

    /// Number of stages of a step of `dt` (s).
    fn count(&self, domain: &Domain<D>, dt: f64) -> usize {
        let nu = domain.fluid.viscosity / domain.fluid.density;
        self.scheme.stages_for(dt * diffusion::limit_rate(&domain.grid.h, nu, false))
    }

    /// (7) over `dt` (s): the velocity `s.u` (m/s), ghosts filled, becomes u*, with the
    /// `acceleration` by the last pressure on faces (m/s2) in the stages. Returns the forces of
    /// this rank's sides on the fluid, where a balance is kept. Collective.
    pub fn predict(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        mixture: &MixtureProperties,
        acceleration: &VectorField<D>,
        dt: f64,
        walls: &mut impl Walls<D>,
    ) -> Result<Sides> {
        if self.is_long(domain, dt) {
            self.predict_in_legendre_stages(domain, s, mixture, acceleration, dt, walls)
        } else {
            self.predict_in_own_stages(domain, s, mixture, acceleration, dt, walls)
        }
    }

    fn predict_in_own_stages<W: Walls<D>>(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        mixture: &MixtureProperties,
        acceleration: &VectorField<D>,
        dt: f64,
        walls: &mut W,
    ) -> Result<Sides> {
        let Prediction { scheme, momentum, stage, .. } = self;
        let mut sides = Sides::zeros();
        for (k, &weight) in scheme.weights.iter().enumerate() {
            if k > 0 {
                let (of_rate, part) = scheme.stages[k - 1];
                let rate = momentum.rate();
                let [of_rate, of_pressure] = [dt * of_rate, dt * part];
                faces::step_cells(
                    &domain.grid,
                    &s.u,
                    of_rate,
                    rate,
                    of_pressure,
                    acceleration,
                    stage,
                );
                domain.clock.lap(Lap::Update);
                domain.set_time(s.time + part * dt);
                walls.finish(domain, s, Within::Stage(part), dt, stage)?;
            }
            let u = if k == 0 { &s.u } else { &*stage };
            let carrier = carrier(s, dt);
            sides += weight * stress(domain, s, mixture, &carrier, u);
            let rated = Rated { u, carrier: &carrier, dt, weight, fresh: k == 0 };
            momentum.add(domain, mixture, &rated, walls.hears())?;
        }
        let rate = momentum.rate();
        faces::step_cells(&domain.grid, &s.u, dt, rate, W::PRESSURE * dt, acceleration, stage);
        domain.clock.lap(Lap::Update);
        domain.set_time(s.time + dt);
        walls.finish(domain, s, Within::End, dt, stage)?;
        std::mem::swap(&mut s.u, stage);
        Ok(sides)
    }

    fn predict_in_legendre_stages<W: Walls<D>>(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        mixture: &MixtureProperties,
        acceleration: &VectorField<D>,
        dt: f64,
        walls: &mut W,
    ) -> Result<Sides> {
        let count = self.count(domain, dt);
        let Prediction { momentum, stage: last, long, .. } = self;
        let Some(LegendreStages { sets, first, before }) = long else {
            return Ok(Sides::zeros());
        };
        let legendre = &sets[count - 3];
        let mut sides = Sides::zeros();
        let mut weight = legendre.weight;
        for (k, stage) in legendre.stages.iter().enumerate() {
            let u = if k == 0 { &s.u } else { &*last };
            let carrier = carrier(s, dt);
            sides += weight * stress(domain, s, mixture, &carrier, u);
            let rated = Rated { u, carrier: &carrier, dt, weight: 1.0, fresh: true };
            momentum.add(domain, mixture, &rated, None)?;
            let part = dt * stage.part();
            if k == 0 {
                momentum.swap_rate(first);
                for (field, u) in before.iter_mut().zip(&s.u) {
                    field.copy_from_slice(u);
                }
                faces::step_cells(&domain.grid, &s.u, part, first, part, acceleration, last);
            } else {
                let terms = [
                    (stage.start, &s.u),
                    (stage.last, &*last),
                    (dt * stage.rate, momentum.rate()),
                    (dt * stage.first, &*first),
                ];
                faces::recur_cells(&domain.grid, stage.before, terms, part, acceleration, before);
                std::mem::swap(last, before);
            }
            domain.clock.lap(Lap::Update);
            domain.set_time(s.time + stage.time * dt);
            walls.finish(domain, s, Within::Legendre(stage), dt, last)?;
            weight = stage.weight;
        }
        domain.set_time(s.time + dt);
        std::mem::swap(&mut s.u, last);
        if W::PRESSURE < 1.0 {
            faces::add_to_cells(&domain.grid, (W::PRESSURE - 1.0) * dt, acceleration, &mut s.u);
            domain.clock.lap(Lap::Update);
        }
        Ok(sides)
    }
}

/// The face velocities that carry in a step of `dt` (s): in the middle of it, for schemes of second
/// order, which keep those of the step before.
fn carrier<const D: usize>(s: &State<D>, dt: f64) -> Carrier<'_, D> {
    let extrapolates = !s.faces_before[0].is_empty() && s.dt > 0.0;
    let before = extrapolates.then(|| (&s.faces_before, 0.5 * dt / s.dt));
    Carrier { now: &s.faces, before }
}

/// The forces of this rank's sides on the fluid by a velocity `u` (m/s), where a balance is kept.
fn stress<const D: usize>(
    domain: &mut Domain<D>,
    s: &State<D>,
    mixture: &MixtureProperties,
    carrier: &Carrier<D>,
    u: &VectorField<D>,
) -> Sides {
    if s.balance.is_none() {
        return Sides::zeros();
    }
    let density = domain.fluid.density;
    let sides = boundary::stress(&domain.grid, carrier, u, density, &mixture.viscosity);
    domain.clock.lap(Lap::Force);
    sides
}
