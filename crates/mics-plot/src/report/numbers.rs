//! The dimensionless numbers of a run, each with its definition.

use super::Run;
use mics_run::config::{Case, Motion, Particle, Stream, stream};
use mics_run::drag::boundary_layer;
use mics_run::words::rounded;

/// A dimensionless number.
pub struct Number {
    /// Its name.
    pub name: &'static str,
    /// Its value.
    pub value: f64,
    /// Its definition, with the numbers that it is made of.
    pub definition: String,
}

fn number(name: &'static str, value: f64, definition: impl Into<String>) -> Number {
    Number { name, value, definition: definition.into() }
}

/// The dimensionless numbers that the case and what the run did give.
pub fn numbers(run: &Run) -> Vec<Number> {
    let mut all = of_stream(run.case());
    all.extend(of_fastest(run));
    all.extend(of_particles(run.case()));
    all.extend(of_oscillations(run.case()));
    let courant = run.column("cfl").iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let definition = "largest sum over axes of |u| dt/h, over all steps";
    all.push(number("Courant", courant, definition));
    all.retain(|number| number.value.is_finite());
    all
}

/// Reynolds numbers of the stream, of measures with a speed of their own and of cells.
fn of_stream(case: &Case) -> Vec<Number> {
    let Some(Stream { speed, length, of, reynolds }) = stream(case) else { return Vec::new() };
    let nu = case.fluid.kinematic_viscosity();
    let h = case.widest_spacing();
    let origin = if case.sides().any(|(_, s)| !s.inflow().is_empty()) {
        "the fastest inflow"
    } else if case.initial.velocity.iter().any(|v| *v != 0.0) {
        "the velocity at the start"
    } else if case.drive.is_some() {
        "the drive"
    } else {
        "the fastest wall"
    };
    let [u, l, kinematic, width] = [speed, length, nu, h].map(rounded);
    let definition =
        format!("U L/nu with U = {u} m/s of {origin}, L = {l} m, the {of}, nu = {kinematic} m2/s");
    let mut all = vec![number("Re", reynolds, definition)];
    // A measure may refer to another speed, and so to another Re.
    let speeds = case.measure.iter().filter_map(|m| m.speed).filter(|s| *s != speed);
    let mut speeds: Vec<f64> = speeds.collect();
    speeds.sort_by(f64::total_cmp);
    speeds.dedup();
    all.extend(speeds.into_iter().map(|s| {
        let definition = format!("the same with their own U = {} m/s", rounded(s));
        number("Re of the measures", s * length / nu, definition)
    }));
    if !case.particle.is_empty() {
        let definition = format!(
            "spacings across a boundary layer, 1.2 L/sqrt(Re) over h = {width} m; under 1 it is \
            not resolved"
        );
        all.push(number("delta/h", boundary_layer(length, reynolds) / h, definition));
    }
    all.push(number("Re_h", speed * h / nu, format!("U h/nu, of the grid, h = {width} m")));
    all
}

/// Numbers of the free particle with the largest Reynolds number.
fn of_fastest(run: &Run) -> Vec<Number> {
    let case = run.case();
    let nu = case.fluid.kinematic_viscosity();
    let free = run.fastest.iter().filter_map(|(id, speed)| {
        let p = case.particle.get(*id).filter(|p| nu > 0.0 && p.is_free())?;
        Some((*id, *speed, p.shape.diameter()))
    });
    // Among equal ones it is always the same one: a table in memory has no order.
    let fastest = free.max_by(|a, b| (a.1 * a.2).total_cmp(&(b.1 * b.2)).then(b.0.cmp(&a.0)));
    let Some((id, speed, d)) = fastest else { return Vec::new() };
    let reynolds = speed * d / nu;
    let definition = format!(
        "V d/nu of the particle that reaches most, {}, with its largest speed V = {} m/s and d = \
        {} m",
        case.called(id),
        rounded(speed),
        rounded(d)
    );
    let layer = boundary_layer(d, reynolds) / case.widest_spacing();
    let across = "spacings across the boundary layer of that particle, 1.2 d/sqrt(Re_p) over h";
    vec![number("Re_p", reynolds, definition), number("delta_p/h", layer, across)]
}

/// Numbers of the smallest particle, and of the one that falls hardest.
fn of_particles(case: &Case) -> Vec<Number> {
    let smallest = case.particle.iter().map(|p| p.shape.thickness()).fold(f64::INFINITY, f64::min);
    let round = case.particle.iter().all(|p| p.shape.is_round());
    let of = if round { "the smallest particle" } else { "the thinnest part of any particle" };
    let definition = format!("cells across {of}; under 4 its flow is not resolved");
    let mut all = vec![number("d/h", smallest / case.widest_spacing(), definition)];
    let g = case.fluid.weight();
    let ratio = |p: &Particle| p.density() / case.fluid.density;
    let galileo = |p: &Particle| {
        ((ratio(p) - 1.0).abs() * g * p.shape.diameter().powi(3)).sqrt()
            / case.fluid.kinematic_viscosity()
    };
    let free = case.particle.iter().enumerate().filter(|(_, p)| g > 0.0 && p.is_free());
    if let Some((id, p)) = free.max_by(|a, b| galileo(a.1).total_cmp(&galileo(b.1))) {
        let name = case.called(id);
        all.push(number("s", ratio(p), format!("density of {name} over the fluid's")));
        let definition = format!("sqrt(|s - 1| g d^3)/nu of {name}, g = {} m/s2", rounded(g));
        all.push(number("Ga", galileo(p), definition));
    }
    all
}

/// Numbers of particles that swing as told.
fn of_oscillations(case: &Case) -> Vec<Number> {
    let of = |(id, p): (usize, &Particle)| {
        let Motion::Prescribed(told) = &p.motion else { return None };
        let swing = told.oscillation.as_ref()?;
        let d = p.shape.diameter();
        let u = swing.speed();
        let f = swing.frequency;
        let name = case.called(id);
        let reynolds = u * d / case.fluid.kinematic_viscosity();
        let of_speed = format!("U d/nu of {name}, U = {} m/s its largest speed", rounded(u));
        let of_way = format!("U/(f d) of {name}, f = {} 1/s", rounded(f));
        Some([number("Re of the swing", reynolds, of_speed), number("KC", u / (f * d), of_way)])
    };
    case.particle.iter().enumerate().filter_map(of).flatten().collect()
}
