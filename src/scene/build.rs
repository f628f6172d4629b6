//! The parts of a scene from the words of its case.

use crate::case::{self, Case, Side};
use crate::grid::{Border, Grid};
use crate::petsc::Choice;
use crate::solids::contact::{Contacts, Damping, Impact, Laws, Material, Substeps, Wall};
use crate::solids::{Body, Freedom, Motion, Oscillation, Shape};
use nalgebra::{UnitQuaternion, Vector3};

/// Height of the asperities where none is given, of the smallest radius.
const ROUGHNESS: f64 = 2e-4;

/// What solves the pressure equation, and why; `uniform` says that every face has the same coefficient.
pub(super) fn solver(chosen: case::Solver, uniform: bool, ranks: usize) -> (Choice, &'static str) {
    match chosen {
        case::Solver::BcgsBoomeramg => (Choice::BcgsBoomeramg, "as the case says"),
        case::Solver::Multigrid => (Choice::Multigrid, "as the case says"),
        case::Solver::Direct if !uniform => (Choice::Multigrid, "the direct solver takes one coefficient only"),
        case::Solver::Direct if ranks > 1 => (Choice::Multigrid, "the direct solver works on one rank only"),
        case::Solver::Direct => (Choice::Direct, "as the case says"),
        case::Solver::Auto if !uniform => (Choice::Multigrid, "auto: the coefficient varies from face to face"),
        case::Solver::Auto if ranks > 1 => (Choice::Multigrid, "auto: several ranks"),
        case::Solver::Auto => (Choice::Direct, "auto: one density everywhere, solved directly"),
    }
}

/// The first D entries.
pub(super) fn axes<T: Copy + Default, const D: usize>(values: &[T]) -> [T; D] {
    std::array::from_fn(|a| values.get(a).copied().unwrap_or_default())
}

pub(super) fn sides<const D: usize>(case: &Case) -> [[&Side; 2]; D] {
    let all = case.sides();
    std::array::from_fn(|a| [0, 1].map(|s| all[2 * a + s].unwrap_or(&Side::Periodic)))
}

pub(super) fn body(p: &case::Particle, fluid: &case::Fluid) -> Body {
    let vector = |v: &Vec<f64>| Vector3::from(axes::<f64, 3>(v));
    let flat = p.position.len() == 2;
    let (velocity, spin, motion) = match &p.motion {
        case::Motion::Fixed => (None, None, Motion::Fixed),
        case::Motion::Prescribed(m) => {
            let path = m.oscillation.as_ref().map(|o| Oscillation {
                origin: vector(&p.position),
                drift: m.velocity.as_ref().map_or_else(Vector3::zeros, vector),
                amplitude: vector(&o.amplitude),
                frequency: o.frequency,
                time: 0.0,
            });
            (m.velocity.as_ref(), m.spin.as_ref(), Motion::Prescribed(path))
        }
        case::Motion::Free => {
            let turns = !p.locked.contains(&case::Lock::Rotation);
            let free = |lock| !p.locked.contains(&lock);
            let translation = [free(case::Lock::X), free(case::Lock::Y), !flat && free(case::Lock::Z)];
            let freedom = Freedom { translation, rotation: [turns && !flat, turns && !flat, turns] };
            (p.velocity.as_ref(), p.spin.as_ref(), Motion::Free(freedom))
        }
    };
    let spin = match spin {
        None => Vector3::zeros(),
        Some(case::Spin::Plane(z)) => Vector3::new(0.0, 0.0, *z),
        Some(case::Spin::Space(w)) => Vector3::from(*w),
    };
    let velocity = match &motion {
        Motion::Prescribed(Some(path)) => path.velocity(),
        _ => velocity.map_or_else(Vector3::zeros, vector),
    };
    Body {
        shape: if let case::Shape::Disc(_) = p.shape { Shape::Disc } else { Shape::Sphere },
        radius: 0.5 * p.shape.diameter(),
        density: p.density.unwrap_or(fluid.density),
        viscosity: p.viscosity.unwrap_or(fluid.viscosity),
        centre: vector(&p.position),
        velocity,
        angle: 0.0,
        orientation: UnitQuaternion::identity(),
        spin,
        motion,
    }
}

/// The impacts that the case lets expect.
pub(crate) fn impact(case: &Case, bodies: &[Body]) -> Impact {
    let gravity = case.fluid.gravity.as_ref().map_or_else(Vector3::zeros, |g| Vector3::from(axes::<f64, 3>(g)));
    let size = std::array::from_fn(|a| case.domain.size.get(a).copied().unwrap_or(1.0));
    let spacings = case.domain.size.iter().zip(&case.domain.cells).map(|(size, cells)| size / *cells as f64);
    let spacing = spacings.fold(f64::INFINITY, f64::min);
    Impact::expected(bodies, size, &gravity, case.fluid.density, case.reference_speed().unwrap_or(0.0), spacing)
}

/// The law of contacts between the bodies, and between them and the closed faces of the box.
pub(super) fn contacts(case: &Case, law: &case::Contact, bodies: &[Body]) -> Contacts {
    let mut names = vec![case::WALL];
    let mut material = |name| {
        names.iter().position(|n| *n == name).unwrap_or_else(|| {
            names.push(name);
            names.len() - 1
        })
    };
    let materials: Vec<usize> = case.particle.iter().map(|p| material(p.material())).collect();
    let impact = impact(case, bodies);
    let laws = Laws::new(names.len(), |a, b| {
        let pair = law.law(names[a], names[b]);
        Material {
            normal_stiffness: pair.normal_stiffness.unwrap_or_else(|| impact.stiffness(pair.exponent)),
            exponent: pair.exponent,
            tangential_ratio: pair.tangential_ratio,
            friction: pair.friction,
            damping: match pair.loss {
                case::Loss::Restitution(e) => Damping::Restitution(e),
                case::Loss::Damping(d) => Damping::Given { normal: d.normal, tangential: d.tangential },
            },
            printed_sign: law.tangential_damping == case::TangentialDamping::Printed,
        }
    });
    let size = |axis: usize| case.domain.size.get(axis).copied();
    let wall = |(face, side): (usize, Option<&Side>)| {
        let (axis, high) = (face / 2, face % 2 == 1);
        let velocity = match side? {
            Side::Wall | Side::Slip => Vector3::zeros(),
            Side::MovingWall(v) => Vector3::from(axes::<f64, 3>(v)),
            _ => return None,
        };
        Some(Wall { axis, high, at: if high { size(axis)? } else { 0.0 }, velocity, material: 0 })
    };
    let walls = case.sides().into_iter().enumerate().filter_map(wall).collect();
    let substeps = match law.substeps {
        case::Substeps::Auto => Substeps::Auto,
        case::Substeps::Count(n) => Substeps::Fixed(n as usize),
    };
    let sizes = std::array::from_fn(|a| size(a).unwrap_or(1.0));
    let periods = std::array::from_fn(|a| size(a).filter(|_| case.periodic(a)));
    let smallest = bodies.iter().fold(f64::INFINITY, |least, b| least.min(b.radius));
    let roughness = law.roughness.unwrap_or(ROUGHNESS * smallest);
    Contacts::new(bodies, materials, walls, laws, sizes, periods, substeps).rough(roughness)
}

/// The condition at a face, its profile evaluated at every stored position.
pub(super) fn border<const D: usize>(grid: &Grid<D>, axis: usize, side: &Side) -> Option<Border<D>> {
    let positions = grid.field().len() / grid.stored[axis];
    let tangential: Vec<usize> = (0..D).filter(|&a| a != axis).collect();
    // Coordinates (m) of a stored position along the face's axes; ghosts beyond the face repeat its edge.
    let at = |mut k: usize| {
        let mut x = [0.0; 2];
        for (x, &a) in x.iter_mut().zip(&tangential) {
            let i = (k % grid.stored[a] + grid.start[a]) as f64 - grid.ghosts as f64 + 0.5;
            *x = (i * grid.h[a]).clamp(0.0, grid.size[a]);
            k /= grid.stored[a];
        }
        x
    };
    let given = |velocity: &dyn Fn([f64; 2], usize) -> f64| {
        Some(Border::Velocity(std::array::from_fn(|c| (0..positions).map(|k| velocity(at(k), c)).collect())))
    };
    match side {
        Side::Periodic => None,
        Side::Outflow => Some(Border::Outflow),
        Side::Slip => Some(Border::Slip),
        Side::Wall => given(&|_, _| 0.0),
        Side::MovingWall(v) | Side::Inflow(v) => given(&|_, c| v[c]),
        Side::InflowParabola(peak) => given(&|x, c| {
            let shape = |(x, &a): (&f64, &usize)| 4.0 * x / grid.size[a] * (1.0 - x / grid.size[a]);
            peak[c] * x.iter().zip(&tangential).map(shape).product::<f64>()
        }),
        Side::InflowProfile(profile) => given(&|x, c| profile.velocity_at(x[0])[c]),
    }
}

/// A reproducible number in [-1, 1) for each integer (the finaliser of SplitMix64).
pub(super) fn scatter(n: u64) -> f64 {
    let mut z = n.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^= z >> 31;
    (z >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}
