//! The correction of contact impulses, and the bound on their work.

use super::*;
use crate::particles::RigidVelocity;
use nalgebra::{DMatrix, DVector};

/// Steps (s): one in which nothing moves far, and one in which a contact ends.
const SHORT: f64 = 1e-6;
const LONG: f64 = 5e-3;

/// Changes of velocity and spin by the correction impulses.
fn moved(
    impulses: &Impulses,
    bodies: &[Body],
    given: &[Impulse],
) -> [(Vector3<f64>, Vector3<f64>); 2] {
    [0, 1].map(|k| (given[k].linear / bodies[k].mass(), impulses.turned_by(k, &given[k].angular)))
}

/// Two bodies pressed together, and a velocity residual of the first: the residuals of approach and
/// slip that are left, and the correction impulses along both, and the impulse before.
fn corrected(
    shape: Shape,
    friction: f64,
    medium: Medium,
    gap: f64,
    off: [f64; 2],
    dt: f64,
) -> ([f64; 2], [f64; 2], f64) {
    let along = vector![0.6, 0.8, 0.0];
    let across = vector![-0.8, 0.6, 0.0];
    let first = body(shape, 0.01, vector![0.5, 0.5, 0.5], Vector3::zeros());
    let mut bodies =
        [first.clone(), body(shape, 0.006, first.centre + (0.016 + gap) * along, Vector3::zeros())];
    let law = contacts(&bodies, material(1.0, 0.5, friction), [1.0; 3], &[], Substeps::Auto).law;
    let mut contacts = Touched::new(law.within(medium));
    let pull = Accelerations { acceleration: 2.0 * along, ..Accelerations::default() };
    contacts.advance(&mut bodies, &[pull, Accelerations::default()], dt).unwrap();
    let pressed = contacts.outcome().impulse(0).linear.norm();
    let off = off[0] * along + off[1] * across;
    let residuals =
        [RigidVelocity { velocity: off, spin: Vector3::zeros() }, RigidVelocity::default()];
    let mut given = [Impulse::default(); 2];
    let mut impulses = contacts.law.impulses();
    impulses.correct(&bodies, &residuals, &mut given, dt);

    let arm = bodies[1].centre - bodies[0].centre;
    let size = given[0].linear.norm();
    assert!((given[0].linear + given[1].linear).norm() < 1e-12 * size, "momentum");
    let turning = given[0].angular + given[1].angular + arm.cross(&given[1].linear);
    assert!(turning.norm() < 1e-9 * size * arm.norm(), "angular momentum: {turning}");

    let [(one, spun), (other, its)] = moved(&impulses, &bodies, &given);
    let overlap = 0.016 - arm.norm();
    let arms = [0.01 - 0.5 * overlap, 0.006 - 0.5 * overlap];
    let apart = residuals[0].velocity + one - other;
    let slip = apart + (arms[0] * spun + arms[1] * its).cross(&along);
    (
        [apart.dot(&along), slip.dot(&across)],
        [given[0].linear.dot(&along), given[0].linear.dot(&across)],
        pressed,
    )
}

#[test]
fn sticking_contact_correction_within_coulomb_cone() {
    for shape in [Shape::Disc, Shape::Sphere] {
        let ([normal, slip], ..) =
            corrected(shape, 0.5, Medium::default(), -1e-5, [1e-3, 1e-4], LONG);
        assert!(
            normal.abs() < 1e-8 && slip.abs() < 1e-8,
            "{shape:?}: {normal} and {slip} m/s are left"
        );
        // Friction cannot hold a large slip: it gives mu times the normal impulse, that of the
        // spring over the step included.
        let ([_, slip], [pressed, tangential], spring) =
            corrected(shape, 0.5, Medium::default(), -1e-5, [1e-3, 2.0], LONG);
        let part = tangential.abs() / (spring - pressed);
        assert!(
            slip > 0.5 && (0.45..0.55).contains(&part),
            "{shape:?}: {part} of what presses, {slip} m/s left"
        );
        // Without friction nothing holds it.
        let ([normal, slip], [pressed, tangential], _) =
            corrected(shape, 0.0, Medium::default(), -1e-5, [1e-3, 1e-4], LONG);
        assert!(
            normal.abs() < 1e-8 && tangential.abs() < 1e-9 * pressed.abs(),
            "{shape:?}: {tangential}"
        );
        assert!((slip / 1e-4 - 1.0).abs() < 1e-9, "{shape:?}: {slip}");
    }
}

/// Lubrication takes `x/(1 + x)` of a residual, with x its resistance over the step by the mass:
/// all of it in the end.
#[test]
fn lubrication_share_of_velocity_residual() {
    for shape in [Shape::Disc, Shape::Sphere] {
        let left = |viscosity: f64| {
            let medium = Medium { density: 1000.0, viscosity, spacing: 2e-3, roughness: 1e-6 };
            corrected(shape, 0.5, medium, 1e-4, [1e-3, 1e-3], SHORT).0.map(|left| left / 1e-3)
        };
        let [thin, double, thick] = [0.1, 0.2, 1e9].map(left);
        for k in [0, 1] {
            // left = 1/(1 + x), x proportional to the viscosity.
            let [x, twice] = [thin, double].map(|left| 1.0 / left[k] - 1.0);
            assert!(x > 1e-6 && (twice / x - 2.0).abs() < 0.01, "{shape:?} {k}: {x} and {twice}");
            assert!(thick[k] < 0.01, "{shape:?} {k}: {} left", thick[k]);
        }
    }
}

/// A fluid that responds to impulses as a whole: the velocities (m/s) and spins (rad/s) of bodies
/// change by a dense matrix.
struct Response {
    inverse: DMatrix<f64>,
}

impl Response {
    /// The response of bodies in the plane (x, y, spin) with added masses of `factor` times their
    /// displaced mass, which neighbours share: each contact adds the inertia of the fluid that
    /// leaves the gap.
    fn new(bodies: &[Body], density: f64, factor: f64) -> Response {
        let n = bodies.len();
        let mut inertia = DMatrix::zeros(3 * n, 3 * n);
        for (i, body) in bodies.iter().enumerate() {
            let added = factor * density * body.volume();
            for axis in [0, 1] {
                inertia[(3 * i + axis, 3 * i + axis)] = body.mass() + added;
            }
            inertia[(3 * i + 2, 3 * i + 2)] = body.inertia().about(2);
            for (j, other) in bodies.iter().enumerate().skip(i + 1) {
                let apart = other.centre - body.centre;
                let distance = apart.norm();
                let near = (-(distance - body.radius() - other.radius()).max(0.0)
                    / (0.3 * body.radius()))
                .exp();
                let n = apart / distance;
                let shared = near * factor * density * body.volume().min(other.volume());
                for (a, b) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                    let part = shared * n[a] * n[b];
                    inertia[(3 * i + a, 3 * i + b)] += part;
                    inertia[(3 * j + a, 3 * j + b)] += part;
                    inertia[(3 * i + a, 3 * j + b)] -= part;
                    inertia[(3 * j + a, 3 * i + b)] -= part;
                }
            }
        }
        Response { inverse: inertia.try_inverse().unwrap() }
    }

    /// Adds the response to impulses, which walls are free of.
    fn apply(&self, bodies: &mut [Body], given: &[Impulse]) {
        let of = |k: usize| [given[k].linear.x, given[k].linear.y, given[k].angular.z];
        let change = &self.inverse
            * DVector::from_iterator(3 * bodies.len(), (0..bodies.len()).flat_map(of));
        for (k, body) in bodies.iter_mut().enumerate() {
            body.velocity += vector![change[3 * k], change[3 * k + 1], 0.0];
            body.spin.z += change[3 * k + 2];
        }
    }

    /// Kinetic energy of bodies and fluid (J).
    fn energy(&self, bodies: &[Body]) -> f64 {
        let of = |body: &Body| [body.velocity.x, body.velocity.y, body.spin.z];
        let v = DVector::from_iterator(3 * bodies.len(), bodies.iter().flat_map(of));
        let inertia = self.inverse.clone().try_inverse().unwrap();
        0.5 * v.dot(&(inertia * &v))
    }
}

/// One step of bodies and a dense response: substeps, response, correction, bound. Returns the
/// energy that bodies and springs gain together, the energy that bodies gain beyond what springs
/// release, and what the bound took (J).
fn step(bodies: &mut [Body], law: &mut Touched, factor: f64, dt: f64) -> [f64; 3] {
    const DENSITY: f64 = 1000.0;
    let before: Vec<Body> = bodies.to_vec();
    law.advance(bodies, &vec![Accelerations::default(); bodies.len()], dt).unwrap();
    let motion = |body: &Body| RigidVelocity { velocity: body.velocity, spin: body.spin };
    let expected: Vec<RigidVelocity> = bodies.iter().map(motion).collect();
    let response = Response::new(bodies, DENSITY, factor);
    for (body, before) in bodies.iter_mut().zip(&before) {
        body.velocity = before.velocity;
        body.spin = before.spin;
    }
    let without = response.energy(bodies);
    let given: Vec<_> = (0..bodies.len()).map(|k| law.outcome().impulse(k)).collect();
    let mut impulses = law.law.impulses();
    let parts = impulses.find_clusters(bodies, |k| expected[k]);
    if parts {
        impulses.note_without(bodies);
    }
    response.apply(bodies, &given);
    impulses.find_response(bodies);
    let residual = |(body, expected): (&Body, &RigidVelocity)| {
        let turned = if body.is_round() { Vector3::zeros() } else { body.spin - expected.spin };
        RigidVelocity { velocity: body.velocity - expected.velocity, spin: turned }
    };
    let residuals: Vec<_> = bodies.iter().zip(&expected).map(residual).collect();
    let mut given = vec![Impulse::default(); bodies.len()];
    impulses.correct(bodies, &residuals, &mut given, dt);
    response.apply(bodies, &given);
    let late = impulses.find_late_parting(bodies);
    if late {
        let mut without = bodies.to_vec();
        let out = |i: Impulse| Impulse { linear: -i.linear, angular: -i.angular };
        let out: Vec<_> = (0..bodies.len()).map(|k| out(impulses.impulse_of_touch(k))).collect();
        response.apply(&mut without, &out);
        impulses.note_without(&without);
    }
    let taken = if parts || late { impulses.bound_work(bodies) } else { 0.0 };
    if taken > 0.0 {
        impulses.reduce(bodies, &mut given);
        response.apply(bodies, &given);
    }
    let layout = law.layout(bodies);
    let released = |pair: &Pair| pair.springs.stored - layout.stored(pair);
    let released = law.pairs.list.iter().map(released).sum::<f64>();
    let now = response.energy(bodies);
    [now - without - released, now - without - released.max(0.0), taken]
}

/// Discs, or rectangles and ellipses, of two sizes and two densities that fall on each other and
/// on a floor, by chance, with and without friction: whatever the fluid's response, their contacts
/// bring no more energy in a step than their springs release.
#[test]
fn contacts_bring_no_energy_for_any_fluid_response() {
    for parts in [false, true] {
        bring_no_energy(parts);
    }
}

/// Four bodies one on the other, the upper ones falling.
fn stack(seed: u64, parts: bool, chance: &mut impl FnMut() -> f64) -> Vec<Body> {
    let mut bodies = Vec::new();
    let mut height = 0.0;
    for k in 0..4 {
        let radius =
            if (k + seed).is_multiple_of(2) { 0.01 } else { 0.01 / (2.0 + 4.0 * chance()) };
        let place = vector![0.5 + 0.2 * radius * chance(), height + radius + 1e-5, 0.0];
        let velocity = vector![0.0, if k == 0 { 0.0 } else { -0.1 * chance() }, 0.0];
        let mut body = if parts {
            let half = [radius, 0.7 * radius];
            let shape = match k % 2 {
                0 => solids::rectangle(half, 0.05 * radius),
                _ => solids::ellipse(half, 0.05 * radius),
            };
            let mut body = solids::free(&shape, place, Vector3::z() * 3.0 * chance());
            body.centre.y = height + body.reach().y + 1e-5;
            body.velocity = velocity;
            body
        } else {
            body(Shape::Disc, radius, place, velocity)
        };
        height = body.centre.y + body.reach().y;
        body.density = if chance() < 0.5 { 1200.0 } else { 8000.0 };
        bodies.push(body);
    }
    bodies
}

fn bring_no_energy(parts: bool) {
    let mut largest = 0.0f64;
    let mut most = 0.0f64;
    let mut bounded = 0.0f64;
    let mut steps = 0;
    for seed in 0..60u64 {
        let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        let mut chance = move || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let mut bodies = stack(seed, parts, &mut chance);
        let friction = if seed % 2 == 0 { 0.0 } else { 0.4 };
        let law = contacts(
            &bodies,
            material(1.0, 0.9 * chance(), friction),
            [1.0; 3],
            &[1],
            Substeps::Auto,
        )
        .law;
        let mut law = Touched::new(law.within(Medium { density: 1000.0, ..Medium::default() }));
        let start = Response::new(&bodies, 1000.0, 1.0).energy(&bodies);
        let factor = 0.5 + 2.5 * chance();
        let mut stored = 0.0;
        for _ in 0..40 {
            let [made, beyond, taken] = step(&mut bodies, &mut law, factor, 3e-4);
            stored += made.max(0.0) / start;
            largest = largest.max(beyond / start);
            bounded += taken / start;
            steps += 1;
        }
        most = most.max(stored);
    }
    println!(
        "{steps} steps, parts {parts}: bodies gain at most {largest:.1e} of the energy beyond what \
        springs release in one of them,"
    );
    println!(
        "springs take up {most:.1e} beyond what bodies give in any scene, and the bound took \
        {bounded:.3} in all"
    );
    assert!(largest < 1e-12, "{largest}");
    assert!(most < 1e-2, "{most}");
    assert!(bounded > 0.0, "the bound was never needed");
}
