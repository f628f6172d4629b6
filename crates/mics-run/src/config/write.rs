//! A case written out as a file that gives every key, for the run's folder; it reads back to an
//! equal case.

use super::raw::shape::solid::Solid;
use super::raw::{self, Axis, Spin, Which};
use super::resolved::{Case, Enter, Measure, Motion, Obstacle, Particle};
use serde::Serialize;

impl Case {
    /// The case as TOML, every default filled in.
    pub fn to_toml(&self) -> String {
        // Bodies one by one at the end: the time that a list of tables takes grows with its square.
        let mut text = text(&file(self));
        let mut before = Vec::new();
        for (index, body) in self.particle.iter().enumerate() {
            let mut body = particle(body);
            if let Some(solid) = body.shape.solid() {
                body.shape = referred(solid, index, &mut before).into();
            }
            text.push('\n');
            text += &self::text(&Listed { particle: [body] });
        }
        for wall in &self.obstacle {
            text.push('\n');
            text += &self::text(&Walls { obstacle: [obstacle(wall)] });
        }
        text
    }
}

/// What a case says of the solid of the body of this number: long lists of points once, in the
/// first body that has them; `before` are such bodies.
fn referred(solid: &Solid, index: usize, before: &mut Vec<(usize, Solid)>) -> raw::Typed {
    if solid.is_brief() {
        return solid.typed();
    }
    let scaled = solid.wanted().is_some();
    let like =
        |(_, other): &&(usize, Solid)| other.wanted().is_some() == scaled && other.is_like(solid);
    if let Some((first, _)) = before.iter().find(like) {
        return raw::Typed::Like(raw::Like { particle: *first, diameter: solid.wanted() });
    }
    before.push((index, solid.clone()));
    solid.typed()
}

/// One of the bodies of a file.
#[derive(Serialize)]
struct Listed {
    particle: [raw::Particle; 1],
}

/// One of the obstacles of a file.
#[derive(Serialize)]
struct Walls {
    obstacle: [raw::Obstacle; 1],
}

fn text(part: &impl Serialize) -> String {
    toml::to_string(part).expect("numbers, texts, lists and tables with text keys are TOML")
}

/// The file that says all of the case but its bodies.
fn file(case: &Case) -> raw::Case {
    let side = |axis: usize, high: usize| case.boundary[axis][high].clone();
    let along_z = |high| (case.dimension() == 3).then(|| side(2, high));
    raw::Case {
        name: case.name.clone(),
        preset: case.preset,
        domain: case.domain.clone(),
        fluid: case.fluid.clone(),
        boundary: raw::Boundary {
            west: side(0, 0),
            east: side(0, 1),
            south: side(1, 0),
            north: side(1, 1),
            bottom: along_z(0),
            top: along_z(1),
        },
        particle: Vec::new(),
        swarm: Vec::new(),
        obstacle: Vec::new(),
        initial: case.initial.clone(),
        drive: case.drive.clone(),
        coupling: case.coupling.clone(),
        contact: case.contact.clone(),
        time: case.time.clone(),
        pressure: case.pressure.clone(),
        petsc: case.petsc.clone(),
        measure: case.measure.iter().map(|m| measure(m, case)).collect(),
        statistics: case.statistics.clone(),
        probe: case.probe.clone(),
        output: case.output.clone(),
    }
}

/// A spin (rad/s) in so many dimensions.
fn spin(spin: &[f64; 3], dimension: usize) -> Option<Spin> {
    Some(if dimension == 2 { Spin::Plane(spin[2]) } else { Spin::Space(*spin) })
}

/// An obstacle with all of its keys.
fn obstacle(o: &Obstacle) -> raw::Obstacle {
    let motion = match &o.motion {
        Motion::Prescribed { velocity, spin: about, oscillation } => {
            raw::Moved::Prescribed(raw::Prescribed {
                velocity: Some(velocity.clone()),
                spin: spin(about, velocity.len()).filter(|_| *about != [0.0; 3]),
                oscillation: oscillation.clone(),
            })
        }
        _ => raw::Moved::Fixed,
    };
    let material = Some(o.material.clone());
    raw::Obstacle { name: o.name.clone(), motion, material, ..o.wall.typed() }
}

/// A particle with all of its keys.
pub(super) fn particle(p: &Particle) -> raw::Particle {
    let of = |about: &[f64; 3]| spin(about, p.position.len());
    let (motion, mut velocity, spin, locked) = match &p.motion {
        Motion::Fixed => (raw::Motion::Fixed, None, None, Vec::new()),
        Motion::Free { velocity, spin, locked } => {
            (raw::Motion::Free, Some(velocity.clone()), of(spin), locked.clone())
        }
        Motion::Prescribed { velocity, spin, oscillation } => {
            let velocity = Some(velocity.clone());
            let oscillation = oscillation.clone();
            let prescribed = raw::Prescribed { velocity, spin: of(spin), oscillation };
            (raw::Motion::Prescribed(prescribed), None, None, Vec::new())
        }
    };
    let enter = p.enter.as_ref().map(|enter| {
        velocity.clone_from(&enter.velocity);
        let Enter { time, region, gap, seed, .. } = enter;
        raw::Enter { time: *time, region: region.clone(), gap: Some(*gap), seed: Some(*seed) }
    });
    raw::Particle {
        name: p.name.clone(),
        shape: p.shape.clone(),
        orientation: p.orientation.clone(),
        density: Some(p.density),
        viscosity: Some(p.viscosity),
        position: p.position.clone(),
        motion,
        velocity,
        spin,
        locked,
        material: Some(p.material.clone()),
        enter,
    }
}

fn measure(m: &Measure, case: &Case) -> raw::Measure {
    let target = m.target.as_ref();
    let dimension = case.dimension();
    let particles = case.particle.len();
    let of_wall = m.kind.is_of_force() && !m.kind.fits_morison();
    let obstacle =
        m.particle.checked_sub(particles).filter(|k| of_wall && *k < case.obstacle.len());
    raw::Measure {
        name: m.name.clone(),
        kind: m.kind,
        particle: if obstacle.is_some() { Which::default() } else { Which::Id(m.particle) },
        obstacle: obstacle.map(Which::Id),
        particles: (m.kind.is_of_group() && obstacle.is_none())
            .then(|| m.particles.iter().copied().map(Which::Id).collect()),
        axis: m.kind.has_axis().then(|| [Axis::X, Axis::Y, Axis::Z][m.axis]),
        region: m.region.clone().map(|[min, max]| raw::Region { min, max }),
        threshold: (m.kind == raw::MeasureKind::BedHeight).then_some(m.threshold),
        direction: m
            .direction
            .filter(|_| dimension == 3 || m.kind != raw::MeasureKind::Torque)
            .map(|direction| direction.iter().take(dimension).copied().collect()),
        from: m.from,
        when: m.when,
        speed: m.speed,
        length: m.length,
        force: m.kind.is_of_force().then_some(m.force),
        reference: target.map(|t| t.reference),
        tolerance: target.map(|t| t.tolerance),
        source: target.and_then(|t| t.source.clone()),
    }
}
