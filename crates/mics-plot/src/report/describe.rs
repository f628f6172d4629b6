//! The case in words and its dimensionless numbers, each with its definition.

use super::Run;
use mics_run::config::{
    Advection, Case, Contact, Motion, Particle, Scheme, Step, Substeps, WallRule,
};
use mics_run::drag::boundary_layer;
use mics_run::words::rounded;

/// What the case is: pairs of a term and its lines.
pub fn scene(case: &Case) -> Vec<(&'static str, Vec<String>)> {
    let times = |v: &[f64]| v.iter().map(|x| rounded(*x)).collect::<Vec<_>>().join(" x ");
    let cells = case.domain.cells.iter().map(usize::to_string).collect::<Vec<_>>().join(" x ");
    let h = case.spacings();
    let sides = case.sides().map(|(name, side)| format!("{name}: {}", side.describe()));
    let lines = |of: Vec<(String, String)>| -> Vec<String> {
        of.into_iter().map(|(label, words)| format!("{label}: {words}")).collect()
    };
    let particles = match case.particle.len() {
        0 => vec!["none".into()],
        _ => lines(case.describe_particles()),
    };
    let wall = match case.coupling.wall {
        WallRule::Sharp => "sharp surfaces: faces are open as far as particles leave them",
        WallRule::Mixing => "the paper's mixing of fluid and particle in cells",
    };
    let mut terms = vec![
        (
            "Box",
            vec![
                format!("{} m, {cells} cells", times(&case.domain.size)),
                format!("spacing h = {} m", times(&h)),
            ],
        ),
        ("Fluid", fluid(case)),
        ("Boundaries", sides.collect()),
        ("Particles", particles),
        ("Coupling", vec![wall.into()]),
    ];
    if !case.obstacle.is_empty() {
        terms.push(("Obstacles", lines(case.describe_obstacles())));
    }
    if let Some(drive) = &case.drive {
        terms.push(("Drive", vec![drive.describe()]));
    }
    if let Some(c) = &case.contact {
        terms.push(("Contacts", contacts(c)));
    }
    terms.push(("Time", time(case)));
    terms.push((
        "Pressure",
        vec![format!("until every cell's |D| is below {:e} 1/s", case.pressure.divergence_limit)],
    ));
    terms
}

/// Its density, viscosity and gravity.
fn fluid(case: &Case) -> Vec<String> {
    let nu = case.fluid.viscosity / case.fluid.density;
    let mut fluid = vec![format!(
        "density {} kg/m3, viscosity {} Pa s (kinematic {} m2/s)",
        rounded(case.fluid.density),
        rounded(case.fluid.viscosity),
        rounded(nu)
    )];
    if case.fluid.gravity.iter().any(|g| *g != 0.0) {
        let gravity = case.fluid.gravity.iter().map(|g| rounded(*g)).collect::<Vec<_>>().join(", ");
        fluid.push(format!("gravity ({gravity}) m/s2"));
    }
    fluid
}

/// The steps, their scheme and that of advection.
fn time(case: &Case) -> Vec<String> {
    let scheme = match case.time.scheme() {
        Scheme::Euler => "Euler",
        Scheme::Rk2 => "two-stage Runge-Kutta",
        Scheme::Rk3 => "three-stage Runge-Kutta",
        Scheme::Rkl2 => {
            "two-stage Runge-Kutta, Runge-Kutta-Legendre where viscosity asks for more stages"
        }
        Scheme::Rkl3 => {
            "three-stage Runge-Kutta, Runge-Kutta-Legendre where viscosity asks for more stages"
        }
    };
    let advection = match case.time.advection {
        Advection::Upwind5 => "fifth-order upwind, conservative",
        Advection::Qsi => "QSI, semi-Lagrangian",
    };
    let steps = match case.time.length() {
        Step::Fixed(step) => format!("steps of {step} s"),
        Step::Courant(number) => format!("steps by a Courant number of {number}"),
    };
    vec![
        format!("to t = {} s, {steps}", case.time.end),
        format!("{scheme}; advection: {advection}"),
    ]
}

/// The laws of contact, each pair of materials that has its own in a line, and the substeps.
fn contacts(contact: &Contact) -> Vec<String> {
    let substeps = match contact.substeps {
        Substeps::Count(n) => format!("{n} substeps a step"),
        _ => "substeps by the time of a contact".into(),
    };
    contact.describe().into_iter().chain([substeps]).collect()
}

/// A dimensionless number.
pub struct Number {
    /// Its name.
    pub name: &'static str,
    /// Its value.
    pub value: f64,
    /// What it is, with the numbers that it is made of.
    pub definition: String,
}

/// A list of numbers that leaves out what is not finite.
#[derive(Default)]
struct Numbers(Vec<Number>);

impl Numbers {
    fn add(&mut self, name: &'static str, value: f64, definition: String) {
        if value.is_finite() {
            self.0.push(Number { name, value, definition });
        }
    }
}

/// The dimensionless numbers that the case and what the run did give.
pub fn numbers(run: &Run) -> Vec<Number> {
    let case = &run.case;
    let mut all = Numbers::default();
    let h = case.spacings().into_iter().fold(0.0, f64::max);
    of_stream(case, h, &mut all);
    of_particles(run, h, &mut all);
    of_oscillations(case, &mut all);
    let courant = run.column("cfl").iter().copied().fold(0.0, f64::max);
    if courant > 0.0 {
        all.add("Courant", courant, "largest sum over axes of |u| dt/h, over all steps".into());
    }
    all.0
}

/// Reynolds numbers of the stream, of measures with a speed of their own and of cells `h` (m) wide.
fn of_stream(case: &Case, h: f64, all: &mut Numbers) {
    let nu = case.fluid.viscosity / case.fluid.density;
    let Some(speed) = case.reference_speed().filter(|_| nu > 0.0) else { return };
    let largest = case.particle.iter().map(|p| p.shape.diameter()).fold(0.0, f64::max);
    let (length, of) = match largest {
        0.0 => (case.domain.size[1], "the height of the box"),
        d => (d, "the largest diameter"),
    };
    let re = speed * length / nu;
    let origin = if case.sides().any(|(_, s)| !s.inflow().is_empty()) {
        "the fastest inflow"
    } else if case.initial.velocity.iter().any(|v| *v != 0.0) {
        "the velocity at the start"
    } else if case.drive.is_some() {
        "the drive"
    } else {
        "the fastest wall"
    };
    let words = [speed, length, nu].map(rounded);
    let [u, l, kinematic] = &words;
    all.add(
        "Re",
        re,
        format!("U L/nu with U = {u} m/s of {origin}, L = {l} m, {of}, nu = {kinematic} m2/s"),
    );
    // A measure may refer to another speed, and so to another Re.
    let mut speeds: Vec<f64> =
        case.measure.iter().filter_map(|m| m.speed).filter(|s| *s != speed).collect();
    speeds.sort_by(f64::total_cmp);
    speeds.dedup();
    for s in speeds {
        let definition = format!("the same with their own U = {} m/s", rounded(s));
        all.add("Re of the measures", s * length / nu, definition);
    }
    if largest > 0.0 {
        all.add(
            "delta/h",
            boundary_layer(length, re) / h,
            format!(
                "spacings across a boundary layer, 1.2 L/sqrt(Re) over h = {} m; under 1 it is not \
                resolved",
                rounded(h)
            ),
        );
    }
    all.add("Re_h", speed * h / nu, format!("U h/nu, of the grid, h = {} m", rounded(h)));
}

/// Numbers of particles: of the fastest free one, the smallest, and the one that falls hardest.
fn of_particles(run: &Run, h: f64, all: &mut Numbers) {
    let case = &run.case;
    let nu = case.fluid.viscosity / case.fluid.density;
    let free = || case.particle.iter().enumerate().filter(|(_, p)| p.is_free());
    if let Some((id, speed, re)) = fastest(run).filter(|_| nu > 0.0 && free().next().is_some()) {
        let d = case.particle[id].shape.diameter();
        all.add(
            "Re_p",
            re,
            format!(
                "V d/nu of the particle that reaches most, {}, with its largest speed V = {} m/s \
                and d = {} m",
                case.called(id),
                rounded(speed),
                rounded(d)
            ),
        );
        all.add(
            "delta_p/h",
            boundary_layer(d, re) / h,
            "spacings across the boundary layer of that particle, 1.2 d/sqrt(Re_p) over h".into(),
        );
    }
    let smallest = case.particle.iter().map(|p| p.shape.thickness()).fold(f64::INFINITY, f64::min);
    let round = case.particle.iter().all(|p| p.shape.is_round());
    let of = if round { "the smallest particle" } else { "the thinnest part of any particle" };
    all.add("d/h", smallest / h, format!("cells across {of}; under 4 its flow is not resolved"));
    let g = case.fluid.gravity.iter().map(|g| g * g).sum::<f64>().sqrt();
    let ratio = |p: &Particle| p.density() / case.fluid.density;
    let galileo =
        |p: &Particle| ((ratio(p) - 1.0).abs() * g * p.shape.diameter().powi(3)).sqrt() / nu;
    let heaviest = free().max_by(|a, b| galileo(a.1).total_cmp(&galileo(b.1)));
    if let Some((id, p)) = heaviest.filter(|_| g > 0.0) {
        all.add("s", ratio(p), format!("density of {} over the fluid's", case.called(id)));
        all.add(
            "Ga",
            galileo(p),
            format!("sqrt(|s - 1| g d^3)/nu of {}, g = {} m/s2", case.called(id), rounded(g)),
        );
    }
}

/// Numbers of particles that swing as told.
fn of_oscillations(case: &Case, all: &mut Numbers) {
    let nu = case.fluid.viscosity / case.fluid.density;
    for (id, p) in case.particle.iter().enumerate() {
        let Motion::Prescribed(told) = &p.motion else { continue };
        if let Some(o) = &told.oscillation {
            let d = p.shape.diameter();
            let u = o.speed();
            all.add(
                "Re of the swing",
                u * d / nu,
                format!("U d/nu of {}, U = {} m/s its largest speed", case.called(id), rounded(u)),
            );
            all.add(
                "KC",
                u / (o.frequency * d),
                format!("U/(f d) of {}, f = {} 1/s", case.called(id), rounded(o.frequency)),
            );
        }
    }
}

/// The free particle with the largest V d: its id, V (m/s) and V d/nu.
fn fastest(run: &Run) -> Option<(usize, f64, f64)> {
    let nu = run.case.fluid.viscosity / run.case.fluid.density;
    let of = |(id, v): (&usize, &f64)| {
        let p = run.case.particle.get(*id).filter(|p| p.is_free())?;
        Some((*id, *v, v * p.shape.diameter() / nu))
    };
    // Of equal ones always the same: a table in memory has no order.
    run.particles
        .fastest
        .iter()
        .filter_map(of)
        .max_by(|a, b| a.2.total_cmp(&b.2).then(b.0.cmp(&a.0)))
}
