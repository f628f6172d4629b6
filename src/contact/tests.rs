//! Tests of the contacts: of one contact here, of many in [`crowd`].

mod correction;
mod crowd;
mod friction;
mod gaps;
mod obstacles;
mod shapes;
mod solids;
mod tips;

use super::law::{Law, integrated_restitution};
use super::pair::Pair;
use super::*;
use crate::geometry::{Disc, Sphere};
use crate::numerics::CONTACT_SUBSTEPS;
use crate::particles::{Freedom, Motion};
use nalgebra::vector;
use std::f64::consts::PI;
use std::sync::Arc;

const FREE: Freedom = Freedom { translation: [true; 3], rotation: [true; 3] };
const PLANE: Freedom = Freedom { translation: [true, true, false], rotation: [false, false, true] };

#[derive(Clone, Copy, Debug)]
enum Shape {
    Disc,
    Sphere,
}

fn body(shape: Shape, radius: f64, centre: Vector3<f64>, velocity: Vector3<f64>) -> Body {
    let (mut body, freedom) = match shape {
        Shape::Disc => (Body::new(Arc::new(Disc { radius }), 2500.0, 1.0, centre), PLANE),
        Shape::Sphere => (Body::new(Arc::new(Sphere { radius }), 2500.0, 1.0, centre), FREE),
    };
    body.velocity = velocity;
    body.motion = Motion::Free(freedom);
    body
}

fn material(exponent: f64, restitution: f64, friction: f64) -> Material {
    Material {
        normal_stiffness: if exponent == 1.0 { 1e6 } else { 1e8 },
        exponent,
        tangential_ratio: 2.0 / 7.0,
        friction,
        rolling_friction: 0.0,
        damping: Damping::Restitution(restitution),
        printed_sign: false,
    }
}

/// The walls that end a box of `size` normal to the given axes.
fn walls(size: [f64; 3], axes: &[usize]) -> Vec<Wall> {
    let wall = |axis, high: bool| Wall {
        axis,
        high,
        at: if high { size[axis] } else { 0.0 },
        velocity: Vector3::zeros(),
        material: 0,
        side: WallSide::Closed,
    };
    axes.iter().flat_map(|&a| [wall(a, false), wall(a, true)]).collect()
}

/// Contacts, and their state from step to step.
struct Touched {
    law: Contacts,
    touching: Touching,
}

impl Touched {
    fn new(law: Contacts) -> Touched {
        Touched { touching: law.untouched(), law }
    }

    fn advance(
        &mut self,
        bodies: &mut [Body],
        accelerations: &[Accelerations],
        dt: f64,
    ) -> Result<usize> {
        let Touched { law, touching } = self;
        let outcome = law.advance(bodies, touching, accelerations, |_, body| body.inertia(), dt)?;
        Ok(outcome.substeps)
    }
}

impl std::ops::Deref for Touched {
    type Target = Contacts;

    fn deref(&self) -> &Contacts {
        &self.law
    }
}

/// One material, in a box of `size` with walls normal to `axes` and the others periodic.
fn contacts(
    bodies: &[Body],
    law: Material,
    size: [f64; 3],
    axes: &[usize],
    substeps: Substeps,
) -> Touched {
    let periods = std::array::from_fn(|a| (!axes.contains(&a) && size[a] > 0.0).then_some(size[a]));
    let laws = Laws::new(1, |_, _| law);
    let law = Contacts::new(
        bodies,
        vec![0; bodies.len()],
        walls(size, axes),
        laws,
        size,
        periods,
        substeps,
    );
    Touched::new(law)
}

fn accelerations(x: f64, y: f64) -> Accelerations {
    Accelerations { acceleration: vector![x, y, 0.0], ..Accelerations::default() }
}

/// Advances without acceleration until the pair has parted; returns the steps found in contact.
fn collide(contacts: &mut Touched, bodies: &mut [Body], dt: f64) -> usize {
    let still = vec![Accelerations::default(); bodies.len()];
    let mut touched = 0;
    for _ in 0..100_000 {
        contacts.advance(bodies, &still, dt).unwrap();
        let touches = contacts.outcome().impulse(0) != Impulse::default();
        touched += usize::from(touches);
        if touched > 0 && !touches {
            return touched;
        }
    }
    panic!("they have not met, or not parted");
}

#[test]
fn head_on_collision_has_given_restitution() {
    let mut worst: f64 = 0.0;
    for (exponent, e, phase) in [1.0, 1.5]
        .into_iter()
        .flat_map(|g| [0.2, 0.5, 0.9, 1.0].map(|e| (g, e)))
        .flat_map(|(g, e)| (0..8).map(move |p| (g, e, p as f64 / 8.0)))
    {
        for shape in [Shape::Disc, Shape::Sphere] {
            let law = material(exponent, e, 0.3);
            let size = [0.2, 0.2, 0.2];
            let mut first = body(shape, 0.01, vector![0.05, 0.1, 0.1], vector![0.7, 0.0, 0.0]);
            let mut second = body(shape, 0.004, vector![0.0, 0.1, 0.1], vector![-0.3, 0.0, 0.0]);
            first.density = 900.0;
            let mass = first.mass() * second.mass() / (first.mass() + second.mass());
            let step = Law::new(law).contact_time(mass, 1.0) / CONTACT_SUBSTEPS;
            second.centre.x =
                first.centre.x + first.radius() + second.radius() + (1.0 + phase) * step;
            let mut both = [first, second];
            let mut pair = contacts(&both, law, size, &[0, 1, 2], Substeps::Fixed(1));
            collide(&mut pair, &mut both, step);
            let measured = both[1].velocity.x - both[0].velocity.x;
            worst = worst.max((measured / e - 1.0).abs());
            assert!(
                (measured / e - 1.0).abs() < 0.01,
                "{shape:?} {exponent} e {e} {phase}: {measured}"
            );

            // The impact on a wall, in one long step.
            let mut one = [body(shape, 0.01, vector![0.1, 0.1, 0.1], vector![0.0, -0.5, 0.0])];
            let time = Law::new(law).contact_time(one[0].mass(), 0.5);
            one[0].centre.y = 0.01 + 0.5 * time * (0.3 + phase / 40.0);
            let mut wall = contacts(&one, law, size, &[0, 1, 2], Substeps::Auto);
            let taken = wall.advance(&mut one, &[Accelerations::default()], 2.0 * time).unwrap();
            assert!((80..90).contains(&taken), "{taken}");
            let measured = one[0].velocity.y / 0.5;
            worst = worst.max((measured / e - 1.0).abs());
            assert!(
                (measured / e - 1.0).abs() < 0.01,
                "{shape:?} on the wall, {exponent} e {e} {phase}: {measured}"
            );
            let given = one[0].mass() * 0.5 * (1.0 + measured);
            assert!((wall.outcome().impulse(0).linear.y / given - 1.0).abs() < 1e-12);
            assert_eq!(wall.outcome().wall_impulse, -wall.outcome().impulse(0).linear);
        }
    }
    println!("restitution: worst relative error {worst:.2e}");
}

#[test]
fn damping_ratio_of_schwager_and_poeschel() {
    for zeta in [0.01, 0.1, 0.5, 0.7, 0.75, 0.9, 0.999, 1.5, 3.0] {
        let theory: f64 = if zeta < 1.0 {
            let w = f64::sqrt(1.0 - zeta * zeta);
            (-zeta / w * (PI - f64::atan2(2.0 * zeta * w, w * w - zeta * zeta))).exp()
        } else {
            let w = f64::sqrt(zeta * zeta - 1.0);
            (-zeta / w * ((zeta + w) / (zeta - w)).ln()).exp()
        };
        let law = Law::new(material(1.0, theory, 0.0));
        assert!((law.zeta / zeta - 1.0).abs() < 1e-9, "zeta {zeta}: {} at e = {theory}", law.zeta);
        let integrated = integrated_restitution(1.0, zeta);
        assert!((integrated / theory - 1.0).abs() < 1e-4, "zeta {zeta}: {integrated}");
    }
    assert_eq!(Law::new(material(1.5, 1.0, 0.0)).zeta, 0.0);
}

#[test]
fn locked_axis_driving_into_wall_is_named() {
    let driven = |freedom: Freedom| {
        let mut one = [body(Shape::Disc, 0.01, vector![0.1, 0.011, 0.0], vector![0.2, -0.5, 0.0])];
        one[0].motion = Motion::Free(freedom);
        let mut wall = contacts(&one, material(1.0, 0.5, 0.0), [0.2; 3], &[0, 1], Substeps::Auto);
        wall.advance(&mut one, &[Accelerations::default()], 0.01).map_err(|e| e.to_string())
    };
    let said = driven(Freedom { translation: [true, false, false], ..PLANE }).unwrap_err();
    assert!(
        said.contains("particle 0 goes on along y at -5.000e-1 m/s, which is locked")
            && !said.contains("stiff"),
        "{said}"
    );
    assert!(
        driven(Freedom { translation: [false, true, false], ..PLANE }).is_ok(),
        "along the wall it may be"
    );
}

/// Time for which a body touches a wall (s), from its impulses over short steps.
fn time_at_the_wall(law: Material, speed: f64, steps: f64) -> f64 {
    let mut one = [body(Shape::Sphere, 0.01, vector![0.1, 0.1, 0.1], vector![0.0, -speed, 0.0])];
    let step = Law::new(law).contact_time(one[0].mass(), speed) / steps;
    one[0].centre.y = 0.01 + 1.5 * speed * step;
    let mut wall = contacts(&one, law, [0.2; 3], &[0, 1, 2], Substeps::Fixed(1));
    step * collide(&mut wall, &mut one, step) as f64
}

#[test]
fn contact_duration_matches_theory() {
    let mass = body(Shape::Sphere, 0.01, Vector3::zeros(), Vector3::zeros()).mass();
    let linear = PI * (mass / 1e6).sqrt();
    assert!((time_at_the_wall(material(1.0, 1.0, 0.0), 0.5, 1000.0) / linear - 1.0).abs() < 0.003);
    // Until the force is 0 (Schwager and Poeschel), at e = 0.5.
    let law = material(1.0, 0.5, 0.0);
    let zeta = Law::new(law).zeta;
    let w = f64::sqrt(1.0 - zeta * zeta);
    let damped = (PI - f64::atan2(2.0 * zeta * w, w * w - zeta * zeta)) / w / PI * linear;
    assert!((time_at_the_wall(law, 0.5, 1000.0) / damped - 1.0).abs() < 0.003);
    // Hertz: 2.9432 d/v, with d the depth; a sphere of the lightest material is what contact_time
    // finds.
    let hertz = material(1.5, 1.0, 0.0);
    let depth = (1.25 * mass * 0.25 / hertz.normal_stiffness).powf(0.4);
    let theory = 2.943_2 * depth / 0.5;
    let spheres =
        [0.01, 0.02].map(|r| body(Shape::Sphere, r, vector![0.1, 0.1, 0.1], Vector3::zeros()));
    let time = |axes: &[usize], bodies: &[Body]| {
        let found = contacts(bodies, hertz, [0.2; 3], axes, Substeps::Auto);
        found.setup().contact_time(bodies, 0.5)
    };
    assert!(
        (time(&[0], &spheres[..1]) / theory - 1.0).abs() < 1e-4,
        "{} {theory}",
        time(&[0], &spheres[..1])
    );
    assert_eq!(time(&[], &spheres[..1]), f64::INFINITY);
    assert!(time(&[], &spheres) < theory);
    assert!((time_at_the_wall(hertz, 0.5, 1000.0) / theory - 1.0).abs() < 0.003);
}

#[test]
fn damping_given_directly() {
    let mass = body(Shape::Sphere, 0.01, Vector3::zeros(), Vector3::zeros()).mass();
    for exponent in [1.0, 1.5] {
        let asked = Law::new(material(exponent, 0.6, 0.0));
        let normal = 2.0 * asked.zeta * (mass * asked.material.normal_stiffness).sqrt();
        let law =
            Material { damping: Damping::Given { normal, tangential: 0.0 }, ..asked.material };
        let mut one = [body(Shape::Sphere, 0.01, vector![0.1, 0.1, 0.1], vector![0.0, -0.5, 0.0])];
        one[0].centre.y = 0.0101;
        let mut wall = contacts(&one, law, [0.2; 3], &[0, 1, 2], Substeps::Auto);
        wall.advance(&mut one, &[Accelerations::default()], 0.01).unwrap();
        assert!((one[0].velocity.y / 0.5 / 0.6 - 1.0).abs() < 0.005, "{}", one[0].velocity.y / 0.5);
    }
}

#[test]
fn prescribed_bodies_have_infinite_mass_in_contact() {
    let mut two = [
        body(Shape::Disc, 0.01, vector![0.05, 0.1, 0.0], vector![1.0, 0.0, 0.0]),
        body(Shape::Disc, 0.01, vector![0.0705, 0.1, 0.0], vector![0.0, 0.0, 0.0]),
    ];
    two[0].motion = Motion::Prescribed(None);
    let mut pair =
        contacts(&two, material(1.0, 0.5, 0.3), [0.2, 0.2, 0.0], &[0, 1], Substeps::Auto);
    pair.advance(&mut two, &[accelerations(5.0, 5.0), Accelerations::default()], 0.02).unwrap();
    assert_eq!(two[0].velocity, vector![1.0, 0.0, 0.0]);
    assert!((two[0].centre.x - 0.07).abs() < 1e-12);
    assert!((two[1].velocity.x - 1.5).abs() < 0.015);
    assert_eq!(pair.outcome().impulse(0).linear, -pair.outcome().impulse(1).linear);
    two[1].motion = Motion::Fixed;
    two[1].centre.x = 0.085;
    assert_eq!(pair.advance(&mut two, &[Accelerations::default(); 2], 0.01).unwrap(), 0);
    assert_eq!(two[1].centre.x, 0.085);
}

#[test]
fn pinned_body_rotates_without_translation() {
    let mut two = [
        body(Shape::Disc, 0.01, vector![0.05, 0.1, 0.0], Vector3::zeros()),
        body(Shape::Disc, 0.01, vector![0.0699, 0.1, 0.0], vector![0.0, 0.0, 0.0]),
    ];
    two[0].motion = Motion::Free(Freedom { translation: [false; 3], ..PLANE });
    two[1].motion = Motion::Prescribed(None);
    two[1].spin.z = 10.0;
    let mut pair =
        contacts(&two, material(1.0, 0.5, 0.3), [0.2, 0.2, 0.0], &[0, 1], Substeps::Auto);
    for _ in 0..20 {
        pair.advance(&mut two, &[Accelerations::default(); 2], 1e-3).unwrap();
    }
    assert_eq!(two[0].centre, vector![0.05, 0.1, 0.0]);
    assert!((two[0].spin.z + 10.0).abs() < 0.1, "{}", two[0].spin.z);
    // The damper takes it for a body that gives way.
    assert!(
        (pair.outcome().impulse(0).linear.x / -1e6 / 1e-4 / 1e-3 - 1.0).abs() < 0.03,
        "{:?}",
        pair.outcome()
    );
}

#[test]
fn contact_errors_name_the_particle() {
    let says = |body: Body, substeps, dt, accelerations: Accelerations, words: &[&str]| {
        let mut still = body.clone();
        still.centre = vector![0.15, 0.15, 0.0];
        still.velocity = Vector3::zeros();
        let mut two = [still, body];
        two[1].id = 1;
        let mut pair = contacts(&two, material(1.0, 0.5, 0.3), [0.2, 0.2, 0.0], &[1], substeps);
        pair.law.setup.periods[0] = None;
        pair.law.pairs = Pairs::new(&two, pair.law.setup.size, pair.law.setup.periods);
        let text = pair
            .advance(&mut two, &[Accelerations::default(), accelerations], dt)
            .unwrap_err()
            .to_string();
        assert!(words.iter().all(|w| text.contains(w)), "{text}");
    };
    let disc =
        |x: f64, y: f64, v: f64| body(Shape::Disc, 0.01, vector![x, y, 0.0], vector![v, 0.0, 0.0]);
    let auto = Substeps::Auto;
    let still = Accelerations::default();
    says(
        disc(0.134, 0.15, 0.0),
        auto,
        1e-3,
        still,
        &["particle 0 and particle 1", "by 4.000e-3 m", "normal_stiffness = 4.0e8"],
    );
    says(disc(0.15, 0.15, 0.0), auto, 1e-3, still, &["particle 0 and particle 1", "by 2.000e-2 m"]);
    says(
        disc(0.1, 0.003, 0.0),
        auto,
        1e-3,
        still,
        &["particle 1 and the wall at y = 0 m", "7.000e-3 m"],
    );
    says(disc(0.1, -0.003, 0.0), auto, 1e-3, still, &["particle 1 is beyond the wall at y = 0 m"]);
    says(disc(0.1, 0.1, -30.0), auto, 1e-2, still, &["particle 1 has left the box", "x = -0.2"]);
    says(
        disc(0.129, 0.15, 5.0),
        Substeps::Fixed(2),
        1e-2,
        still,
        &["particle 0 and particle 1", "contact.substeps"],
    );
    says(
        disc(0.129, 0.15, 5.0),
        auto,
        1e6,
        still,
        &["particle 0 and particle 1", "lower the stiffness"],
    );
    says(disc(f64::NAN, 0.1, 0.0), auto, 1e-2, still, &["particle 1", "not a finite number"]);
    says(
        disc(0.1, 0.1, 0.0),
        auto,
        1e-2,
        accelerations(f64::NAN, 0.0),
        &["particle 1", "not a finite number"],
    );
}
