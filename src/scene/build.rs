//! The parts of a scene from the words of its case.

use crate::config::{self, Case, Side, fluid_speed};
use crate::contact::{Contacts, Damping, Impact, Laws, Material, Medium, Substeps, Wall, WallSide};
use crate::domain::Domain;
use crate::drive::Drive;
use crate::geometry::{Disc, Shape, Sphere};
use crate::grid::{Coefficient, Grid};
use crate::method::Method;
use crate::method::flow::Flow;
use crate::method::mixture::MixtureMethod;
use crate::method::momentum::{Advection, MixtureProperties, Momentum};
use crate::method::prediction::Prediction;
use crate::method::sharp::{Sharp, ghost_width};
use crate::numerics::PRESSURE_WEIGHT;
use crate::particles::{Body, Freedom, Motion, Oscillation};
use crate::petsc::Choice;
use crate::scheme::{self, Scheme};
use crate::{Error, Result};
use nalgebra::Vector3;
use std::cmp::Ordering;
use std::sync::Arc;

/// Solver of the pressure equation.
pub(super) fn solver(chosen: config::Solver) -> Choice {
    match chosen {
        config::Solver::BcgsBoomeramg => Choice::BcgsBoomeramg,
        config::Solver::Auto | config::Solver::Multigrid => Choice::Multigrid,
    }
}

/// The first D entries.
pub(super) fn axes<T: Copy + Default, const D: usize>(values: &[T]) -> [T; D] {
    std::array::from_fn(|a| values.get(a).copied().unwrap_or_default())
}

fn vector(v: &[f64]) -> Vector3<f64> {
    Vector3::from(axes::<f64, 3>(v))
}

/// Lets a body move as it is told.
fn prescribe(body: &mut Body, told: &config::Prescribed) {
    let drift = vector(&told.velocity);
    let path = told.oscillation.as_ref().map(|o| Oscillation {
        origin: body.centre,
        drift,
        amplitude: vector(&o.amplitude),
        frequency: o.frequency,
        time: 0.0,
    });
    body.velocity = path.as_ref().map_or(drift, Oscillation::velocity);
    body.spin = Vector3::from(told.about());
    body.motion = Motion::Prescribed(path);
}

/// The directions in which a free particle moves.
fn freedom(p: &config::Particle) -> Freedom {
    let flat = p.position.len() == 2;
    let free = |lock| !p.locked.contains(&lock);
    let turns = free(config::Lock::Rotation);
    Freedom {
        translation: [free(config::Lock::X), free(config::Lock::Y), !flat && free(config::Lock::Z)],
        rotation: [turns && !flat, turns && !flat, turns],
    }
}

/// The obstacle of this number of a case, of the fluid's density.
pub(super) fn obstacle(case: &Case, number: usize) -> Body {
    let o = &case.obstacle[number];
    let fluid = &case.fluid;
    let wall = o.wall();
    let shape = wall.geometry().clone();
    let mut body = Body::new(shape, fluid.density, fluid.viscosity, vector(wall.centre()));
    if let config::Motion::Prescribed(told) = &o.motion {
        prescribe(&mut body, told);
    }
    body.name = Some(case.called(case.particle.len() + number).into());
    body
}

pub(super) fn body(p: &config::Particle) -> Body {
    let radius = 0.5 * p.shape.diameter();
    let shape: Arc<dyn Shape> = match p.shape.solid() {
        Some(solid) => solid.geometry().clone(),
        None if p.shape.dimension() == 2 => Arc::new(Disc { radius }),
        None => Arc::new(Sphere { radius }),
    };
    let mut body = Body::new(shape, p.density(), p.viscosity(), vector(&p.position));
    match &p.motion {
        config::Motion::Fixed => {}
        config::Motion::Prescribed(told) => prescribe(&mut body, told),
        config::Motion::Free => {
            body.velocity = vector(&p.velocity());
            body.spin = Vector3::from(p.spin.map_or([0.0; 3], config::Spin::about));
            body.motion = Motion::Free(freedom(p));
        }
    }
    body.orientation = p.turn();
    body.angle = p.angle();
    body
}

/// Sorts the bodies by their distance from the middle of the box, and by place where that is the
/// same: how a case numbers them decides no result, nor does a mirror or an exchange of axes.
pub(super) fn sort_from_middle(bodies: &mut [Body], size: &[f64]) {
    let middle = 0.5 * vector(size);
    let distance = |body: &Body| (body.centre - middle).norm_squared();
    let by_place = |one: &Body, other: &Body| {
        let axes = one.centre.iter().zip(&other.centre).map(|(a, b)| a.total_cmp(b));
        axes.fold(Ordering::Equal, Ordering::then)
    };
    bodies.sort_by(|one, other| {
        distance(one).total_cmp(&distance(other)).then_with(|| by_place(one, other))
    });
}

/// Drive of the fluid of a case, at a factor of 1 where it varies.
pub(super) fn drive(case: &Case, drive: &config::Drive) -> Drive {
    let gravity = Vector3::from(axes::<f64, 3>(&case.fluid.gravity));
    let periodic = |axis: usize| axis < case.dimension() && case.periodic(axis);
    let along = Vector3::from_fn(|axis, _| if periodic(axis) { gravity[axis] } else { 0.0 });
    match drive {
        config::Drive::Force(force) => Drive::Fluid(Vector3::from(axes::<f64, 3>(force.vector()))),
        config::Drive::Gravity(_) => Drive::Gradient(case.fluid.density * along),
        config::Drive::MeanVelocity(held) => {
            Drive::Held { axis: held.axis.index(), velocity: held.value }
        }
    }
}

/// Whether these bodies have sharp surfaces.
pub(super) fn walls_are_sharp(case: &Case, bodies: &[Body]) -> bool {
    case.coupling.wall == config::WallRule::Sharp && (case.has_bodies() || !bodies.is_empty())
}

/// Properties of the cells: a field where those of bodies differ and are mixed in, else a number.
pub(super) fn mixture<const D: usize>(
    grid: &Grid<D>,
    case: &Case,
    bodies: &[Body],
) -> MixtureProperties {
    let property = |of_fluid: f64, of_body: fn(&Body) -> f64| {
        if walls_are_sharp(case, bodies) || bodies.iter().all(|b| of_body(b) == of_fluid) {
            Coefficient::Uniform(of_fluid)
        } else {
            Coefficient::Field(vec![of_fluid; grid.field().len()])
        }
    };
    MixtureProperties {
        density: property(case.fluid.density, |b| b.density),
        viscosity: property(case.fluid.viscosity, |b| b.viscosity),
    }
}

fn scheme(case: &Case) -> Scheme {
    match (case.time.scheme(), case.time.advection) {
        (_, config::Advection::Qsi) => scheme::QSI,
        (config::Scheme::Euler, _) => scheme::EULER,
        (config::Scheme::Rk2, _) => scheme::RK2,
        (config::Scheme::Rk3, _) => scheme::RK3,
        (config::Scheme::Rkl2, _) => scheme::RK2.stabilised(case.time.stages()),
        (config::Scheme::Rkl3, _) => scheme::RK3.stabilised(case.time.stages()),
    }
}

/// Whether the velocity that carries is extrapolated from those of two steps.
pub(super) fn extrapolates(case: &Case) -> bool {
    scheme(case).centred && case.time.advection == config::Advection::Upwind5
}

/// The method for these bodies and the impacts to expect of them, all its scratch new.
pub(super) fn method<const D: usize>(
    domain: &Domain<D>,
    case: &Case,
    bodies: &[Body],
    impact: Impact,
) -> Box<dyn Method<D>> {
    let grid = &domain.grid;
    let mixture = mixture(&domain.grid, case, bodies);
    let advection = match case.time.advection {
        config::Advection::Upwind5 => Advection::Upwind5,
        config::Advection::Qsi => {
            Advection::Qsi { from: grid.vector_field(), to: grid.vector_field() }
        }
    };
    let momentum = Momentum::new(grid, advection, &mixture);
    let prediction = Prediction::new(grid, scheme(case), momentum);
    // Where all bodies have left, walls are as sharp as before.
    let mixing = case.coupling.wall == config::WallRule::Mixture;
    if bodies.is_empty()
        && (case.particle.is_empty() || (mixing && case.particle.iter().all(|p| p.enter.is_none())))
    {
        let mut flow = Flow::new(domain, mixture, prediction, mixing);
        flow.own = (!mixing).then_some(PRESSURE_WEIGHT);
        return Box::new(flow);
    }
    let free = bodies.iter().any(|b| b.freedom().is_some())
        || case.particle.iter().any(|p| p.enter.is_some());
    let law = case.contact.as_ref().filter(|_| free).map(|law| contacts(case, law, bodies, impact));
    match case.coupling.wall {
        config::WallRule::Sharp => Box::new(Sharp::new(domain, bodies, mixture, prediction, law)),
        config::WallRule::Mixture => {
            Box::new(MixtureMethod::new(domain, bodies, mixture, prediction, law))
        }
    }
}

/// Refuses bodies that the case, or the method, cannot have.
pub(super) fn refuse_shapes<const D: usize>(case: &Case, bodies: &[Body]) -> Result<()> {
    let sharp = case.coupling.wall == config::WallRule::Sharp;
    for body in bodies {
        let dimension = body.shape().dimension();
        let round = body.shape().is_round();
        let outside = (0..D).find(|a| !(0.0..=case.domain.size[*a]).contains(&body.centre[*a]));
        let why = if dimension != D {
            format!("its shape has {dimension} dimensions, and the case {D}")
        } else if let Some(axis) = outside {
            format!("its centre is outside the box along {}", ["x", "y", "z"][axis])
        } else if case.contact.is_some()
            && !(round || body.is_obstacle() || !body.parts().is_empty())
        {
            "its shape has no convex parts that contacts could see: take [contact] out of the case"
                .into()
        } else {
            continue;
        };
        return Err(Error::Usage(format!("{}: {why}", body.called())));
    }
    let h: Vec<f64> =
        case.domain.size.iter().zip(&case.domain.cells).map(|(size, n)| size / *n as f64).collect();
    let needed = ghost_width(&h).1;
    match case.domain.cells.iter().find(|cells| **cells < needed) {
        Some(cells) if sharp && !bodies.is_empty() => Err(Error::Usage(format!(
            "sharp surfaces need {needed} cells at least along every axis, and domain.cells has \
            {cells}: use more, or \
             coupling.wall = \"mixing\""
        ))),
        _ => Ok(()),
    }
}

/// The impacts that the case lets expect.
pub(crate) fn impact(case: &Case, bodies: &[Body]) -> Impact {
    let gravity = Vector3::from(axes::<f64, 3>(&case.fluid.gravity));
    let size = std::array::from_fn(|a| case.domain.size.get(a).copied().unwrap_or(1.0));
    let spacings =
        case.domain.size.iter().zip(&case.domain.cells).map(|(size, cells)| size / *cells as f64);
    let spacing = spacings.fold(f64::INFINITY, f64::min);
    let density = case.fluid.density;
    let viscosity = case.fluid.viscosity;
    let fluid = Medium { density, viscosity, spacing, roughness: 0.0 };
    Impact::expected(bodies, size, &gravity, &fluid, fluid_speed(case))
}

/// The law of a pair of materials; a stiffness that is not given is by the impacts to be expected.
fn material(law: &config::Contact, between: [&str; 2], impact: &Impact) -> Material {
    let pair = law.between(between[0], between[1]);
    let stiffness = pair.normal_stiffness.given();
    Material {
        normal_stiffness: stiffness.unwrap_or_else(|| impact.stiffness(pair.exponent)),
        exponent: pair.exponent,
        tangential_ratio: pair.tangential_ratio,
        friction: pair.friction,
        rolling_friction: pair.rolling_friction,
        damping: match pair.loss {
            config::Loss::Restitution(e) => Damping::Restitution(e),
            config::Loss::Damping(d) => {
                Damping::Given { normal: d.normal, tangential: d.tangential }
            }
        },
        printed_sign: law.tangential_damping == config::TangentialDamping::Printed,
    }
}

/// A side of the box that bodies touch, of the material `slippery` where the fluid slips along it.
fn wall(case: &Case, face: usize, side: &Side, slippery: usize) -> Option<Wall> {
    let axis = face / 2;
    let high = face % 2 == 1;
    let (side, velocity) = match side {
        Side::Wall => (WallSide::Closed, Vector3::zeros()),
        Side::MovingWall(v) => (WallSide::Closed, Vector3::from(axes::<f64, 3>(v))),
        Side::Slip => (WallSide::Slip, Vector3::zeros()),
        side if !side.inflow().is_empty() => (WallSide::Inflow, Vector3::zeros()),
        _ => return None,
    };
    let material = if side == WallSide::Slip { slippery } else { 0 };
    let at = if high { case.domain.size[axis] } else { 0.0 };
    Some(Wall { axis, high, at, velocity, material, side })
}

/// The law of contacts between the bodies, and between them and the sides of the box: all but
/// outflows.
pub(super) fn contacts(
    case: &Case,
    law: &config::Contact,
    bodies: &[Body],
    impact: Impact,
) -> Contacts {
    let mut names = vec![config::WALL];
    let mut number = |name| {
        names.iter().position(|n| *n == name).unwrap_or_else(|| {
            names.push(name);
            names.len() - 1
        })
    };
    let particle = |k: usize| {
        case.particle.get(k).map_or(config::DEFAULT_MATERIAL, config::Particle::material)
    };
    // The case's obstacles are the last bodies.
    let (own, walls) = bodies.split_at(bodies.len().saturating_sub(case.obstacle.len()));
    let names_of = own.iter().map(|body| particle(body.id));
    let names_of = names_of.chain(case.obstacle.iter().map(config::Obstacle::material));
    let materials: Vec<usize> = names_of.take(own.len() + walls.len()).map(&mut number).collect();
    // Material of walls along which the fluid slips: bodies slide there without friction.
    let slippery = names.len();
    names.push(config::WALL);
    let laws = Laws::new(names.len(), |a, b| {
        let factor = if b == slippery { 0.0 } else { 1.0 };
        let pair = material(law, [names[a], names[b]], &impact);
        Material {
            friction: factor * pair.friction,
            rolling_friction: factor * pair.rolling_friction,
            ..pair
        }
    });
    let size = |axis: usize| case.domain.size.get(axis).copied();
    let sides = case.sides().enumerate();
    let walls = sides.filter_map(|(face, (_, side))| wall(case, face, side, slippery)).collect();
    let substeps = match law.substeps {
        config::Substeps::Auto => Substeps::Auto,
        config::Substeps::Count(n) => Substeps::Fixed(n as usize),
    };
    let sizes = std::array::from_fn(|a| size(a).unwrap_or(1.0));
    let periods = std::array::from_fn(|a| size(a).filter(|_| case.periodic(a)));
    Contacts::new(bodies, materials, walls, laws, sizes, periods, substeps).rough(law.roughness())
}

/// A reproducible number in [-1, 1) for each integer (the finaliser of SplitMix64).
pub(super) fn scatter(n: u64) -> f64 {
    let mut z = n.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^= z >> 31;
    (z >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}
