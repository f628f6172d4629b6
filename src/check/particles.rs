//! Particles of a case, described and checked beside the grid, the fluid and each other: sizes,
//! densities, contacts and overlaps.

use crate::Result;
use crate::config::{Case, Line, Loaded, Obstacle, Particle, Shape, Side, WallRule};
use crate::drag::terminal_speed;
use crate::particles::Body;
use crate::scene::Scene;
use crate::words::{brief, whole};
use nalgebra::Vector3;

/// Cells across a particle below which its flow is not resolved, and below which its forces are off
/// by many per cent.
const RESOLVED: f64 = 4.0;
const GOOD: f64 = 8.0;

/// Density ratios of particles in contact for which contacts hold.
const IN_CONTACT: std::ops::RangeInclusive<f64> = 0.5..=1e4;
/// Largest ratio of the diameters of two particles in contact for which contacts hold.
const MOST_SIZE_RATIO: f64 = 10.0;
/// Density ratios beyond which a unit may be wrong.
const USUAL: std::ops::Range<f64> = 0.01..100.0;

/// The particles and their materials, with what may be wrong with them.
pub fn describe(case: &Case) -> Vec<String> {
    let mut lines: Vec<String> = case.describe_bodies().iter().map(Line::to_string).collect();
    lines.extend(untouchable(case));
    lines.extend(unresolved(case));
    lines.extend(thin_obstacles(case));
    lines.extend(flat_films(case));
    lines.extend(unusual(case));
    lines.extend(out_of_range(case));
    lines.extend(mixture_faults(case));
    lines
}

/// Refuses free particles that are smaller than a cell: nothing of the flow around them is found,
/// and the box is most likely in another unit than they are.
pub fn refuse_below_a_cell(loaded: &Loaded) -> Result<()> {
    let case = &loaded.case;
    let free = case.particle.iter().any(Particle::is_free);
    let Some(cells) = cells_across(case).filter(|cells| free && *cells < 1.0) else {
        return Ok(());
    };
    Err(loaded.error_at(
        "domain.size",
        format!(
            "the smallest particle is {} cells across, and {RESOLVED} or more are needed: if the \
            box is in another unit than the diameters, write both in m; else give domain.cells \
            more",
            brief(cells)
        ),
    ))
}

/// Bodies that may touch where the case says nothing of contacts.
fn untouchable(case: &Case) -> Option<String> {
    let solid = |side: &Side| !matches!(side, Side::Periodic | Side::Outflow);
    let meets = case.particle.len() > 1
        || !case.obstacle.is_empty()
        || case.sides().any(|(_, side)| solid(side));
    let free = case.contact.is_none() && case.particle.iter().any(Particle::is_free);
    (free && meets).then(|| {
        "notice       the case has no [contact]: the run ends as soon as a free particle touches \
        another or a wall; an empty [contact] lets them touch"
            .into()
    })
}

/// Bodies in a fluid without viscosity, which slips along the walls of the box.
pub fn sticks(case: &Case) -> Option<String> {
    let sticks = case.fluid.viscosity == 0.0 && case.has_bodies();
    let words = "warning      bodies are no-slip even at zero viscosity: the start from rest \
        is right; drag, wakes and light bodies at walls are not";
    sticks.then(|| words.into())
}

/// Bodies that overlap at the start by so much that their springs throw them apart.
pub fn pressed<const D: usize>(case: &Case, scene: &Scene<D>) -> Option<String> {
    let stored = scene.state.energy.springs;
    let g = case.fluid.weight();
    let free = || scene.state.bodies.iter().filter(|body| body.freedom().is_some());
    // Energy (J) that they would have from a fall by a hundredth of their diameters.
    let weight = |body: &Body| (body.mass() - case.fluid.density * body.volume()).abs() * g;
    let fall = free().map(|body| 0.01 * body.shape().diameter() * weight(body)).sum::<f64>();
    let lightest = free().map(Body::mass).fold(f64::INFINITY, f64::min);
    (stored > fall && lightest.is_finite()).then(|| {
        format!(
            "warning      particles overlap at the start, and the springs of their contacts hold \
            {stored:.2e} J: they may part at up to {} m/s; place them further apart",
            brief((2.0 * stored / lightest).sqrt())
        )
    })
}

/// Cells across the thinnest part of any particle; `None` without particles.
fn cells_across(case: &Case) -> Option<f64> {
    let widest = case.widest_spacing();
    case.particle
        .iter()
        .map(|p| p.shape.thickness())
        .min_by(f64::total_cmp)
        .map(|least| least / widest)
}

/// Particles that are too small for the grid.
pub fn unresolved(case: &Case) -> Option<String> {
    let smallest = cells_across(case)?;
    if smallest < RESOLVED {
        let cells = case.domain.cells.iter().map(|&n| whole((n as f64 * GOOD / smallest).ceil()));
        return Some(format!(
            "warning      a particle {} {} cells is not resolved: {RESOLVED} or more are needed; \
            domain.cells = [{}] give it {GOOD}",
            thinnest_words(case),
            if smallest < 1.0 { brief(smallest) } else { format!("{smallest:.1}") },
            cells.collect::<Vec<_>>().join(", ")
        ));
    }
    // As large as asked for, but for rounding.
    (smallest < GOOD * (1.0 - 1e-9)).then(|| {
        format!(
            "note         a particle {} {smallest:.1} cells is coarse: from {GOOD} on forces are \
            right within some per cent",
            thinnest_words(case)
        )
    })
}

/// Obstacles with parts that are too thin for the grid.
fn thin_obstacles(case: &Case) -> Vec<String> {
    let widest = case.widest_spacing();
    let thin = |(k, o): (usize, &Obstacle)| {
        let cells = o.wall().thickness() / widest;
        (cells < RESOLVED).then(|| {
            format!(
                "warning      {} is {} cells thick at its thinnest: {RESOLVED} or more are needed \
                on both sides of a wall to be resolved",
                case.called(case.particle.len() + k),
                brief(cells)
            )
        })
    };
    case.obstacle.iter().enumerate().filter_map(thin).collect()
}

/// Bodies with flat faces that may sink flat onto another face through a film that no cell
/// resolves, and that would hold them: by Reynolds' `w = mu L^n V/g^3` of two faces L long a gap g
/// apart, n = 3 per metre of depth and 4 in 3D, their speed V in a gap of a spacing is less than a
/// tenth of their terminal speed.
pub fn flat_films(case: &Case) -> Option<String> {
    let h = case.widest_spacing();
    let gravity = case.fluid.weight();
    let nu = case.fluid.kinematic_viscosity();
    let flat = |p: &Particle| matches!(p.shape.name(), "polygon" | "polyhedron");
    let faces = !case.obstacle.is_empty()
        || case.particle.iter().filter(|p| flat(p)).count() > 1
        || case.sides().any(|(_, s)| matches!(s, Side::Wall | Side::MovingWall(_)));
    let held = |p: &Particle| {
        let weight = (p.density() / case.fluid.density - 1.0).abs() * gravity;
        let terminal = terminal_speed(case.dimension() == 3, p.shape.diameter(), weight, nu);
        let film = nu * face_length(&p.shape).powi(case.dimension() as i32 + 1);
        (f64::MIN_POSITIVE..0.1 * film * terminal)
            .contains(&(weight * p.shape.volume() * h.powi(3)))
    };
    let one = case.particle.iter().position(|p| faces && flat(p) && p.is_free() && held(p))?;
    Some(format!(
        "warning      {} has flat faces: where one comes to lie flat on another, the film between \
        them has the resistance of a disc's, and it may close 60 times too fast",
        case.called(one)
    ))
}

/// Length of the largest flat face (m): in 3D the root of its area.
fn face_length(shape: &Shape) -> f64 {
    let Some(solid) = shape.solid() else { return 0.0 };
    let patches = solid.geometry().surface(shape.bounding_diameter());
    let face = |n: &Vector3<f64>| -> f64 {
        patches.iter().filter(|p| p.normal.dot(n) > 1.0 - 1e-9).map(|p| p.area).sum()
    };
    let largest = patches.iter().map(|p| face(&p.normal)).fold(0.0, f64::max);
    if shape.dimension() == 2 { largest } else { largest.sqrt() }
}

/// Words before the number of cells across the thinnest part of any particle; a round one is as
/// thin as it is large.
fn thinnest_words(case: &Case) -> &'static str {
    let thinnest =
        case.particle.iter().min_by(|a, b| a.shape.thickness().total_cmp(&b.shape.thickness()));
    if thinnest.is_none_or(|p| p.shape.is_round()) { "of" } else { "whose thinnest part is" }
}

/// Contacts outside the densities and sizes for which they hold.
fn out_of_range(case: &Case) -> Vec<String> {
    if case.contact.is_none() || case.particle.len() < 2 {
        return Vec::new();
    }
    let ratio = |p: &Particle| p.density() / case.fluid.density;
    let outside = case.particle.iter().position(|p| p.is_free() && !IN_CONTACT.contains(&ratio(p)));
    let density = outside.map(|id| {
        format!(
            "warning      {} is {} times as dense as the fluid: contacts among particles hold from \
            {} to {}",
            case.called(id),
            brief(ratio(&case.particle[id])),
            IN_CONTACT.start(),
            IN_CONTACT.end()
        )
    });
    let diameters = case.particle.iter().map(|p| p.shape.diameter());
    let [least, most] =
        [diameters.clone().fold(f64::INFINITY, f64::min), diameters.fold(0.0, f64::max)];
    let sizes = (most > MOST_SIZE_RATIO * least * (1.0 + 1e-9)).then(|| {
        format!(
            "warning      particles of {} and {} m: contacts hold for diameters up to \
            {MOST_SIZE_RATIO} times each other",
            brief(least),
            brief(most)
        )
    });
    density.into_iter().chain(sizes).collect()
}

/// Bodies of the file beside those that another run brings along.
pub fn doubled(case: &Case) -> Option<String> {
    let inherited = case.initial.inherited;
    let own = case.particle.len() - case.initial.inherited;
    (inherited > 0 && own > 0).then(|| {
        format!(
            "note         this file adds {own} to the {inherited} that come from that run: if they \
            are the same, remove its [[particle]] and [[swarm]]"
        )
    })
}

/// Densities over the fluid's with which free bodies run by the paper's method (`docs/method.md`).
const MIXTURE: std::ops::RangeInclusive<f64> = 0.1..=10.0;

/// The faults of the paper's method that the case meets.
fn mixture_faults(case: &Case) -> Option<String> {
    if case.coupling.wall != WallRule::Mixture || case.particle.is_empty() {
        return None;
    }
    let free = case.particle.iter().any(Particle::is_free);
    let far = |p: &Particle| p.is_free() && !MIXTURE.contains(&(p.density() / case.fluid.density));
    let faults = [
        (true, "forces depend on the step"),
        (free, "free bodies settle too fast (a disc of s = 1.25 by 14 to 30 %)"),
        (case.particle.iter().any(far), "bodies of this density soon end the run"),
    ];
    let faults: Vec<_> = faults.into_iter().filter(|(met, _)| *met).map(|(_, what)| what).collect();
    Some(format!(
        "warning      coupling.wall = \"mixing\" is the paper's method as printed: {}; \"sharp\" \
        has none of this (docs/method.md has how much)",
        faults.join(", ")
    ))
}

/// Free particles of a density that may be in another unit than the fluid's.
fn unusual(case: &Case) -> Option<String> {
    let ratio = |p: &Particle| p.density() / case.fluid.density;
    let id = case.particle.iter().position(|p| p.is_free() && !USUAL.contains(&ratio(p)))?;
    let s = ratio(&case.particle[id]);
    Some(format!(
        "note         {} is {s:.3e} times as dense as the fluid: if that is not meant, look at \
        both densities",
        case.called(id)
    ))
}
