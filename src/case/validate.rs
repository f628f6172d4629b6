//! The rules of a case that its types cannot say: ranges, lengths, contradictions, geometry. Each refusal names the key
//! and what would be right. Stability limits belong to the scene.

use std::collections::HashSet;

use super::*;

/// A refusal: the dotted path of the key, and what would be right.
pub(super) struct Fault {
    pub key: String,
    pub message: String,
}

type Check = Result<(), Fault>;

const AXES: [&str; 3] = ["x", "y", "z"];

/// Returns the refusal of a key with a formatted message unless the condition holds.
macro_rules! ensure {
    ($holds:expr, $key:expr, $($message:tt)+) => {
        let holds: bool = $holds;
        if !holds {
            return Err(Fault { key: $key.into(), message: format!($($message)+) });
        }
    };
}

fn positive(key: &str, value: f64, unit: &str) -> Check {
    ensure!(value > 0.0 && value.is_finite(), key, "must be positive and finite ({unit}), not {value:?}");
    Ok(())
}

fn not_negative(key: &str, value: f64, unit: &str) -> Check {
    let holds = value >= 0.0 && value.is_finite();
    ensure!(holds, key, "must be zero or positive, and finite ({unit}), not {value:?}");
    Ok(())
}

fn finite(key: &str, values: &[f64], unit: &str) -> Check {
    for (i, value) in values.iter().enumerate() {
        ensure!(value.is_finite(), format!("{key}.{i}"), "must be a finite number ({unit}), not {value:?}");
    }
    Ok(())
}

/// One finite number for each axis.
fn vector(key: &str, value: &[f64], dimension: usize, unit: &str) -> Check {
    let count = value.len();
    ensure!(count == dimension, key, "a {dimension}D case needs {dimension} numbers here ({unit}), not {count}");
    finite(key, value, unit)
}

/// A computed number to five digits, without the noise of its rounding.
fn short(value: f64) -> String {
    format!("{:?}", format!("{value:.4e}").parse().unwrap_or(value))
}

/// Checks what the types leave open; the first refusal is returned.
pub(super) fn validate(case: &Case) -> Check {
    let plain = case.name.chars().all(|c| c.is_ascii_alphanumeric() || "-_.".contains(c));
    let holds = plain && !["", ".", ".."].contains(&case.name.as_str());
    ensure!(holds, "name", "\"{}\" cannot name a folder: use letters, digits, `-`, `_` and `.`", case.name);
    domain(&case.domain)?;
    let dimension = case.dimension();
    positive("fluid.density", case.fluid.density, "kg/m3")?;
    not_negative("fluid.viscosity", case.fluid.viscosity, "Pa s")?;
    if let Some(gravity) = &case.fluid.gravity {
        vector("fluid.gravity", gravity, dimension, "m/s2")?;
    }
    boundary(case)?;
    for (index, body) in case.particle.iter().enumerate() {
        particle(case, body, index)?;
    }
    overlaps(case)?;
    if let Some(velocity) = &case.initial.velocity {
        vector("initial.velocity", velocity, dimension, "m/s")?;
    }
    not_negative("initial.perturbation", case.initial.perturbation.unwrap_or(0.0), "m/s")?;
    let planar = dimension == 2 || case.coupling.fraction != FractionRule::Polygon;
    ensure!(planar, "coupling.fraction", "polygon is for discs in 2D only; in 3D choose \"exact\"");
    time(case)?;
    let Pressure { divergence_limit, tightening, max_iterations, .. } = case.pressure;
    positive("pressure.divergence_limit", divergence_limit, "1/s")?;
    let holds = tightening > 0.0 && tightening <= 1.0;
    ensure!(holds, "pressure.tightening", "must be above 0 and at most 1, not {tightening:?}");
    ensure!(max_iterations >= 1, "pressure.max_iterations", "must be at least 1");
    measures(case)?;
    cadence("output.particles", &case.output.particles)?;
    case.output.fields.as_ref().map_or(Ok(()), |fields| cadence("output.fields", fields))
}

fn domain(domain: &Domain) -> Check {
    let (sizes, counts) = (domain.size.len(), domain.cells.len());
    let holds = sizes == 2 || sizes == 3;
    ensure!(holds, "domain.size", "needs 2 numbers (m) for a 2D case or 3 for a 3D one, not {sizes}");
    ensure!(counts == sizes, "domain.cells", "needs {sizes} numbers, one for each in domain.size, not {counts}");
    for (axis, (&size, &cells)) in domain.size.iter().zip(&domain.cells).enumerate() {
        positive(&format!("domain.size.{axis}"), size, "m")?;
        let key = format!("domain.cells.{axis}");
        ensure!(cells >= 6, key, "must be at least 6 (the stencil reaches 3 cells to either side), not {cells}");
    }
    let total = domain.cells.iter().try_fold(1_usize, |total, cells| total.checked_mul(*cells));
    let holds = total.is_some_and(|total| total < 1 << 31);
    ensure!(holds, "domain.cells", "make 2^31 cells or more, which is more than can be numbered: use fewer");
    Ok(())
}

fn boundary(case: &Case) -> Check {
    let sides = case.sides();
    let dimension = case.dimension();
    let faces = || FACES.into_iter().zip(sides).enumerate();
    for (face, (name, side)) in faces() {
        let key = format!("boundary.{name}");
        let (axis, opposite) = (face / 2, FACES[face ^ 1]);
        let Some(side) = side else {
            ensure!(axis >= dimension, key, "missing: a 3D case needs bottom and top as well");
            continue;
        };
        ensure!(axis < dimension, key, "is for 3D only, and domain.size has two numbers: remove it");
        match side {
            Side::Periodic => {
                let paired = sides[face ^ 1] == Some(&Side::Periodic);
                let cure = format!("set both {name} and {opposite} to \"periodic\", or neither");
                ensure!(paired, key, "{name} is periodic and {opposite} is not: {cure}");
            }
            Side::Outflow | Side::Wall | Side::Slip => {}
            Side::MovingWall(velocity) => {
                let key = format!("{key}.moving_wall");
                vector(&key, velocity, dimension, "m/s")?;
                let (normal, x) = (velocity[axis], AXES[axis]);
                let key = format!("{key}.{axis}");
                ensure!(normal == 0.0, key, "a wall moves in its own plane: set {x} to 0.0 m/s, not {normal:?}");
            }
            Side::Inflow(velocity) => vector(&format!("{key}.inflow"), velocity, dimension, "m/s")?,
            Side::InflowParabola(velocity) => vector(&format!("{key}.inflow_parabola"), velocity, dimension, "m/s")?,
            Side::InflowProfile(points) => profile(&format!("{key}.inflow_profile"), points, dimension)?,
        }
    }
    let open = sides.contains(&Some(&Side::Outflow));
    for (face, (name, side)) in faces() {
        let enters = side.is_some_and(|side| side.inflow().iter().any(|velocity| velocity[face / 2] != 0.0));
        let (key, cure) = (format!("boundary.{name}"), format!("set {} = \"outflow\"", FACES[face ^ 1]));
        ensure!(open || !enters, key, "inflow without outflow: what enters at {name} cannot leave; {cure}");
    }
    Ok(())
}

fn profile(key: &str, profile: &Profile, dimension: usize) -> Check {
    let (points, velocities) = (profile.at.len(), profile.velocity.len());
    let key_at = format!("{key}.at");
    finite(&key_at, &profile.at, "m")?;
    ensure!(points >= 2, key_at, "needs at least 2 coordinates (m), not {points}");
    let increasing = profile.at.is_sorted_by(|a, b| a < b);
    ensure!(increasing, key_at, "the coordinates (m) must increase from each to the next");
    let key = format!("{key}.velocity");
    ensure!(velocities == points, key, "needs {points} velocities, one for each in `at`, not {velocities}");
    let check = |(i, velocity): (usize, &Vec<f64>)| vector(&format!("{key}.{i}"), velocity, dimension, "m/s");
    profile.velocity.iter().enumerate().try_for_each(check)
}

fn particle(case: &Case, particle: &Particle, index: usize) -> Check {
    let dimension = case.dimension();
    let key = |rest: &str| format!("particle.{index}.{rest}");
    let (shape, wanted) = match particle.shape {
        Shape::Disc(_) => ("disc", 2),
        Shape::Sphere(_) => ("sphere", 3),
    };
    ensure!(dimension == wanted, key("shape"), "a disc is for 2D, a sphere for 3D; this case is {dimension}D");
    let diameter = particle.shape.diameter();
    let key_diameter = key(&format!("shape.{shape}.diameter"));
    positive(&key_diameter, diameter, "m")?;
    positive(&key("density"), particle.density.unwrap_or(1.0), "kg/m3")?;
    not_negative(&key("viscosity"), particle.viscosity.unwrap_or(0.0), "Pa s")?;
    let place = key("position");
    vector(&place, &particle.position, dimension, "m")?;
    for (axis, (&centre, &size)) in particle.position.iter().zip(&case.domain.size).enumerate() {
        let x = AXES[axis];
        if case.sides()[2 * axis] == Some(&Side::Periodic) {
            let holds = diameter < size;
            ensure!(holds, key_diameter, "must be below the periodic domain's {size:?} m along {x}, not {diameter:?}");
            let holds = (0.0..size).contains(&centre);
            let domain = format!("the domain: 0 <= {x} < {size:?} m");
            ensure!(holds, place, "particle {index} has its centre at {x} = {centre:?} m, outside {domain}");
        } else {
            let (low, high, slack) = (centre - 0.5 * diameter, centre + 0.5 * diameter, 1e-9 * diameter);
            let holds = low >= -slack && high <= size + slack;
            let extent = format!("from {} to {} m along {x}", short(low), short(high));
            let cure = format!("move it inside, or make {} and {} periodic", FACES[2 * axis], FACES[2 * axis + 1]);
            let domain = format!("the domain from 0 to {size:?} m");
            ensure!(holds, place, "particle {index} reaches {extent}, outside {domain}: {cure}");
        }
    }
    motion(&particle.motion, &key("motion"), dimension)
}

fn motion(motion: &Motion, key: &str, dimension: usize) -> Check {
    let cure = "set motion = \"fixed\" or { prescribed = { velocity = [...] } }";
    ensure!(*motion != Motion::Free, key, "free particles are not in this version: {cure}");
    let Motion::Prescribed(prescribed) = motion else { return Ok(()) };
    if let Some(velocity) = &prescribed.velocity {
        vector(&format!("{key}.prescribed.velocity"), velocity, dimension, "m/s")?;
    }
    let key = format!("{key}.prescribed.spin");
    let (spin, fits) = match &prescribed.spin {
        None => return Ok(()),
        Some(Spin::Plane(spin)) => (std::slice::from_ref(spin), dimension == 2),
        Some(Spin::Space(spin)) => (spin.as_slice(), dimension == 3),
    };
    ensure!(fits, key, "is one number in 2D and three in 3D (rad/s); this case is {dimension}D");
    ensure!(spin.iter().all(|c| c.is_finite()), key, "must be finite (rad/s), not {spin:?}");
    Ok(())
}

/// No two bodies, nor their periodic images, overlap: a sweep along x over those near enough.
fn overlaps(case: &Case) -> Check {
    let bodies = &case.particle;
    let widest = bodies.iter().map(|body| body.shape.diameter()).fold(0.0, f64::max);
    let period = |axis: usize| (case.sides()[2 * axis] == Some(&Side::Periodic)).then_some(case.domain.size[axis]);
    let periods: Vec<Option<f64>> = (0..case.dimension()).map(period).collect();
    let mut along_x: Vec<(f64, usize)> = bodies.iter().enumerate().map(|(i, body)| (body.position[0], i)).collect();
    if let Some(length) = periods[0] {
        let images = along_x.iter().filter(|(x, _)| *x <= widest).map(|&(x, i)| (x + length, i));
        along_x.extend(images.collect::<Vec<_>>());
    }
    along_x.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (rank, &(x, i)) in along_x.iter().enumerate() {
        for &(_, j) in along_x[rank + 1..].iter().take_while(|(other, _)| other - x <= widest).filter(|(_, j)| *j != i)
        {
            let apart = bodies[i].position.iter().zip(&bodies[j].position).zip(&periods);
            let apart = apart.map(|((a, b), period)| period.map_or(a - b, |l| a - b - l * ((a - b) / l).round()));
            let distance = apart.map(|d| d * d).sum::<f64>().sqrt();
            let reach = 0.5 * (bodies[i].shape.diameter() + bodies[j].shape.diameter());
            let (first, second) = (i.min(j), i.max(j));
            let key = || format!("particle.{second}.position");
            let message = || format!("{} m apart, and must be {} m or more", short(distance), short(reach));
            let holds = distance >= reach * (1.0 - 1e-9);
            ensure!(holds, key(), "particle {second} overlaps particle {first}: their centres are {}", message());
        }
    }
    Ok(())
}

fn time(case: &Case) -> Check {
    let time = &case.time;
    positive("time.end", time.end, "s")?;
    let both = time.step.is_some() && time.cfl.is_some();
    ensure!(!both, "time.step", "time.step and time.cfl exclude each other: remove one of them");
    positive("time.step", time.step.unwrap_or(1.0), "s")?;
    positive("time.cfl", time.cfl.unwrap_or(1.0), "a Courant number, such as 0.4")?;
    let holds = time.advection != Advection::Qsi || time.scheme == Scheme::Euler;
    let cure = "set time.scheme = \"euler\" or choose upwind5";
    ensure!(holds, "time.advection", "qsi is a one-step scheme: {cure}");
    let holds = time.scheme != Scheme::Euler || time.advection == Advection::Qsi || case.fluid.viscosity > 0.0;
    let cure = "choose \"rk2\" or \"rk3\", or time.advection = \"qsi\"";
    ensure!(holds, "time.scheme", "euler steps with upwind advection grow without viscosity: {cure}");
    Ok(())
}

fn measures(case: &Case) -> Check {
    let mut names = HashSet::new();
    for (index, Measure { name, kind, particle, from, speed, .. }) in case.measure.iter().enumerate() {
        let key = |rest: &str| format!("measure.{index}.{rest}");
        ensure!(!name.is_empty(), key("name"), "is empty: give each measure a name");
        ensure!(names.insert(name), key("name"), "\"{name}\" names another measure already: give each its own name");
        not_negative(&key("from"), *from, "s")?;
        let end = case.time.end;
        ensure!(*from < end, key("from"), "must be before time.end = {end:?} s, not {from:?}");
        positive(&key("speed"), speed.unwrap_or(1.0), "m/s")?;
        if kind.needs_particle() {
            let count = case.particle.len();
            let holds = *particle < count;
            ensure!(holds, key("particle"), "there is no particle {particle}: the case has {count}, counted from 0");
            let holds = speed.or(case.reference_speed()).is_some();
            ensure!(holds, key("speed"), "no reference speed, as nothing moves at the start: give `speed` (m/s)");
        }
    }
    Ok(())
}

fn cadence(key: &str, cadence: &Cadence) -> Check {
    let one = cadence.every.is_some() != cadence.every_time.is_some();
    ensure!(one, key, "give exactly one of `every` (steps) and `every_time` (s), as in {{ every = 10 }}");
    ensure!(cadence.every != Some(0), format!("{key}.every"), "must be 1 step or more, not 0");
    positive(&format!("{key}.every_time"), cadence.every_time.unwrap_or(1.0), "s")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box of 4 by 1 (by 1) m, periodic along x, with walls elsewhere, and these further keys.
    fn refusal(dimension: usize, keys: &str) -> Option<(String, String)> {
        let (size, cells) = (&[4.0, 1.0, 1.0][..dimension], &[32, 8, 8][..dimension]);
        let lids = if dimension == 3 { "bottom = \"wall\"\ntop = \"wall\"" } else { "" };
        let text = format!(
            "name = \"box\"\ntime.end = 1.0\ndomain = {{ size = {size:?}, cells = {cells:?} }}\n\
             fluid = {{ density = 1.0, viscosity = 0.1 }}\n{keys}\n\
             [boundary]\nwest = \"periodic\"\neast = \"periodic\"\nsouth = \"wall\"\nnorth = \"wall\"\n{lids}"
        );
        validate(&toml::from_str(&text).unwrap()).err().map(|fault| (fault.key, fault.message))
    }

    fn discs(places: &[[f64; 2]]) -> String {
        let disc = |[x, y]: &[f64; 2]| {
            format!("{{ shape = {{ disc = {{ diameter = 0.2 }} }}, motion = \"fixed\", position = [{x:?}, {y:?}] }}")
        };
        format!("particle = [{}]", places.iter().map(disc).collect::<Vec<_>>().join(", "))
    }

    #[test]
    fn bodies_may_touch_each_other_and_the_walls() {
        assert_eq!(refusal(2, &discs(&[[1.0, 0.1], [1.2, 0.1], [1.0, 0.9], [0.0, 0.5]])), None);
    }

    #[test]
    fn bodies_that_overlap_across_the_periodic_faces_are_refused() {
        let (key, message) = refusal(2, &discs(&[[3.95, 0.5], [2.0, 0.5], [0.05, 0.5]])).unwrap();
        assert_eq!(key, "particle.2.position");
        assert!(message.contains("overlaps particle 0") && message.contains("0.1"), "{message}");
    }

    #[test]
    fn a_body_may_straddle_a_periodic_face_but_not_a_wall() {
        assert_eq!(refusal(2, &discs(&[[3.99, 0.5]])), None);
        let (key, message) = refusal(2, &discs(&[[2.0, 0.95]])).unwrap();
        assert_eq!(key, "particle.0.position");
        assert!(message.contains("particle 0") && message.contains("0 to 1.0 m"), "{message}");
        assert!(refusal(2, &discs(&[[4.0, 0.5]])).unwrap().1.contains("0 <= x < 4.0"));
    }

    #[test]
    fn thousands_of_bodies_are_checked_in_no_time() {
        let places: Vec<[f64; 2]> = (0..3000).map(|i| [f64::from(i / 300), 1e-3 + 1e-3 * f64::from(i % 300)]).collect();
        let mut case: Case = toml::from_str(
            "name = \"box\"\ntime.end = 1.0\ndomain = { size = [16.0, 1.0], cells = [32, 8] }\n\
             fluid = { density = 1.0, viscosity = 0.1 }\n\
             boundary = { west = \"periodic\", east = \"periodic\", south = \"wall\", north = \"wall\" }",
        )
        .unwrap();
        case.particle = places
            .iter()
            .map(|place| Particle {
                shape: Shape::Disc(Round { diameter: 1e-3 }),
                density: None,
                viscosity: None,
                position: place.to_vec(),
                motion: Motion::Fixed,
            })
            .collect();
        let start = std::time::Instant::now();
        assert!(validate(&case).is_ok());
        assert!(start.elapsed().as_millis() < 500, "{:?}", start.elapsed());
    }

    #[test]
    fn what_is_for_one_dimension_is_refused_in_the_other() {
        let sphere = "particle = [{ shape = { sphere = { diameter = 0.2 } }, position = [1.0, 0.5, 0.5], motion = ";
        let spun = |spin: &str| format!("{sphere} {{ prescribed = {{ spin = {spin} }} }} }}]");
        assert_eq!(refusal(3, &spun("[0, 0, 1.0]")), None);
        assert_eq!(refusal(3, &spun("1.0")).unwrap().0, "particle.0.motion.prescribed.spin");
        assert_eq!(refusal(2, &spun("1.0")).unwrap().0, "particle.0.shape");
        assert_eq!(refusal(3, "coupling.fraction = \"polygon\"").unwrap().0, "coupling.fraction");
        assert_eq!(refusal(3, "initial.velocity = [1.0, 0.0]").unwrap().0, "initial.velocity");
    }

    #[test]
    fn a_coefficient_needs_a_particle_and_a_reference_speed() {
        let drag = "measure = [{ name = \"drag\", kind = \"drag_coefficient\" }]\n";
        assert_eq!(refusal(2, drag).unwrap().0, "measure.0.particle");
        let still = drag.to_owned() + &discs(&[[1.0, 0.5]]);
        assert_eq!(refusal(2, &still).unwrap().0, "measure.0.speed");
        assert_eq!(refusal(2, &(still + "\ninitial.velocity = [1.0, 0.0]")), None);
        assert_eq!(refusal(2, "measure = [{ name = \"top\", kind = \"max_speed\" }]"), None);
    }
}
