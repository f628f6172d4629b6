//! Tests of the contacts: of one contact here, of many in [`crowd`].

mod correction;
mod crowd;

use super::*;
use crate::geometry::{Disc, Sphere};
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
    (body.velocity, body.motion) = (velocity, Motion::Free(freedom));
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

/// Contacts with what lasts of them.
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
        self.law.advance(bodies, &mut self.touching, accelerations, |_, body| body.inertia(), dt)
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

/// Advances with no acceleration until the pair has parted; the steps that found it in contact.
fn collide(contacts: &mut Touched, bodies: &mut [Body], dt: f64) -> usize {
    let still = vec![Accelerations::default(); bodies.len()];
    let mut touched = 0;
    for _ in 0..100_000 {
        contacts.advance(bodies, &still, dt).unwrap();
        let touches = contacts.impulses()[0] != Impulse::default();
        touched += usize::from(touches);
        if touched > 0 && !touches {
            return touched;
        }
    }
    panic!("they have not met, or not parted");
}

#[test]
fn a_head_on_collision_has_the_restitution_asked_for() {
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
            let step = Law::new(law).contact_time(mass, 1.0) / Numerics::default().contact_substeps;
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

            // The same against a wall, in one long step.
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
            assert!((wall.impulses()[0].linear.y / given - 1.0).abs() < 1e-12);
            assert_eq!(wall.wall_impulse(), -wall.impulses()[0].linear);
        }
    }
    println!("restitution: worst relative error {worst:.2e}");
}

#[test]
fn the_damping_ratio_is_that_of_schwager_and_poeschel() {
    for zeta in [0.01, 0.1, 0.5, 0.7, 0.75, 0.9, 0.999, 1.5, 3.0] {
        let theory: f64 = if zeta < 1.0 {
            let w = f64::sqrt(1.0 - zeta * zeta);
            (-zeta / w * (PI - f64::atan2(2.0 * zeta * w, w * w - zeta * zeta))).exp()
        } else {
            let w = f64::sqrt(zeta * zeta - 1.0);
            (-zeta / w * ((zeta + w) / (zeta - w)).ln()).exp()
        };
        let law = Law::new(material(1.0, theory, 0.0));
        assert!((law.zeta / zeta - 1.0).abs() < 2e-4, "zeta {zeta}: {} at e = {theory}", law.zeta);
    }
    assert_eq!(Law::new(material(1.5, 1.0, 0.0)).zeta, 0.0);
}

#[test]
fn what_a_locked_axis_drives_into_a_wall_is_named_since_no_stiffness_stops_it() {
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

/// How long a body touches a wall (s), from its impulses over short steps.
fn time_at_the_wall(law: Material, speed: f64, steps: f64) -> f64 {
    let mut one = [body(Shape::Sphere, 0.01, vector![0.1, 0.1, 0.1], vector![0.0, -speed, 0.0])];
    let step = Law::new(law).contact_time(one[0].mass(), speed) / steps;
    one[0].centre.y = 0.01 + 1.5 * speed * step;
    let mut wall = contacts(&one, law, [0.2; 3], &[0, 1, 2], Substeps::Fixed(1));
    step * collide(&mut wall, &mut one, step) as f64
}

#[test]
fn a_contact_lasts_as_long_as_theory_says() {
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
        found.contact_time(bodies, 0.5)
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
fn damping_can_be_given_as_it_is() {
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
fn a_body_that_hits_a_wall_askew_slides_by_coulombs_law() {
    for (shape, inertia) in [(Shape::Disc, 0.5), (Shape::Sphere, 0.4)] {
        let (e, mu, speed) = (0.8, 0.1, 0.5);
        let mut law = material(1.0, e, mu);
        law.normal_stiffness *= 10.0; // the arm is the radius less the overlap
        let mut one = [body(shape, 0.01, vector![0.1, 0.0101, 0.1], vector![2.0, -speed, 0.0])];
        let mut wall = contacts(&one, law, [0.2; 3], &[1], Substeps::Auto);
        wall.advance(&mut one, &[Accelerations::default()], 2e-3).unwrap();
        let slowed = mu * (1.0 + e) * speed;
        assert!(((2.0 - one[0].velocity.x) / slowed - 1.0).abs() < 0.01, "{}", one[0].velocity.x);
        // The friction acts below the centre, backwards: the body takes up a spin about -z.
        let spin = -slowed / (inertia * 0.01);
        assert!((one[0].spin.z / spin - 1.0).abs() < 0.02, "{} {spin}", one[0].spin.z);
        assert!(one[0].spin.x == 0.0 && one[0].spin.y == 0.0 && one[0].velocity.z == 0.0);
    }
}

#[test]
fn a_wall_that_moves_drags_along() {
    let mut law = material(1.0, 0.8, 0.1);
    law.normal_stiffness *= 10.0;
    let one = body(Shape::Disc, 0.01, vector![0.1, 0.0101, 0.1], vector![0.0, -0.5, 0.0]);
    let mut fixed = [one.clone()];
    fixed[0].velocity = vector![-2.0, -0.5, 0.0];
    let mut dragged = [one];
    contacts(&fixed, law, [0.2; 3], &[1], Substeps::Auto)
        .advance(&mut fixed, &[Accelerations::default()], 1e-3)
        .unwrap();
    let mut moving = contacts(&dragged, law, [0.2; 3], &[1], Substeps::Auto);
    moving.law.walls[0].velocity.x = 2.0;
    moving.advance(&mut dragged, &[Accelerations::default()], 1e-3).unwrap();
    assert!((dragged[0].velocity.x - fixed[0].velocity.x - 2.0).abs() < 1e-9);
    assert!((dragged[0].spin.z - fixed[0].spin.z).abs() < 1e-6);
}

#[test]
fn a_body_that_sticks_to_the_wall_reverses_its_slip_but_never_gains_energy() {
    for (e, ratio) in [(1.0, 0.4), (1.0, 2.0 / 7.0), (0.9, 2.0 / 7.0), (0.5, 1.0)] {
        let law = Material { tangential_ratio: ratio, ..material(1.0, e, 10.0) };
        let mut one =
            [body(Shape::Sphere, 0.01, vector![0.1, 0.01001, 0.1], vector![0.05, -0.5, 0.0])];
        let energy = |b: &Body| {
            0.5 * (b.mass() * b.velocity.norm_squared()
                + b.inertia().about(2) * b.spin.norm_squared())
        };
        let before = energy(&one[0]);
        let mut wall = contacts(&one, law, [0.2; 3], &[1], Substeps::Auto);
        wall.advance(&mut one, &[Accelerations::default()], 5e-3).unwrap();
        let slip = one[0].velocity.x + 0.01 * one[0].spin.z;
        assert!(one[0].velocity.x < 0.05 && one[0].spin.z < 0.0 && slip < 0.02, "{one:?}");
        assert!(
            energy(&one[0]) < before * (1.0 + 2e-4),
            "e {e}: {}",
            energy(&one[0]) / before - 1.0
        );
        assert_eq!(wall.touching.springs.len(), 0);
    }
    // As printed, the damper of (22) feeds.
    let gain = |printed_sign| {
        let law = Material { printed_sign, ..material(1.0, 0.5, 10.0) };
        let mut one =
            [body(Shape::Sphere, 0.01, vector![0.1, 0.01001, 0.1], vector![0.05, -0.5, 0.0])];
        contacts(&one, law, [0.2; 3], &[1], Substeps::Auto)
            .advance(&mut one, &[Accelerations::default()], 5e-3)
            .unwrap();
        (one[0].velocity.x + 0.01 * one[0].spin.z).abs()
    };
    assert!(gain(true) > 2.0 * gain(false), "{} {}", gain(true), gain(false));
}

/// Acceleration down a slope (m/s2) of a body that starts at rest, over its last half second.
fn acceleration_down(
    shape: Shape,
    mu: f64,
    angle: f64,
    motion: Motion,
) -> (f64, Touched, [Body; 1]) {
    let size = [2.0, 0.1, 0.1];
    let law = Material { normal_stiffness: 1e6, ..material(1.0, 0.5, mu) };
    let mut one = [body(shape, 0.01, vector![0.1, 0.01, 0.05], Vector3::zeros())];
    one[0].motion = motion;
    one[0].centre.y -= one[0].mass() * 9.81 * angle.cos() / 1e6;
    let mut wall = contacts(&one, law, size, &[1], Substeps::Auto);
    let down = [accelerations(9.81 * angle.sin(), -9.81 * angle.cos())];
    let mut before = 0.0;
    for step in 0..200 {
        if step == 100 {
            before = one[0].velocity.x;
        }
        wall.advance(&mut one, &down, 2.5e-3).unwrap();
    }
    ((one[0].velocity.x - before) / 0.25, wall, one)
}

#[test]
fn a_body_slides_or_rolls_down_a_slope() {
    let angle: f64 = 0.5;
    for (shape, motion, share) in [
        (Shape::Disc, Motion::Free(PLANE), 2.0 / 3.0),
        (Shape::Sphere, Motion::Free(FREE), 5.0 / 7.0),
    ] {
        let critical = (1.0 - share) * angle.tan();
        let rolling = acceleration_down(shape, 1.2 * critical, angle, motion).0
            / (share * 9.81 * angle.sin());
        let mu = 0.6 * critical;
        let sliding = acceleration_down(shape, mu, angle, motion).0
            / (9.81 * (angle.sin() - mu * angle.cos()));
        println!("{shape:?}: rolls at {rolling:.5} and slides at {sliding:.5} of theory");
        assert!(
            (rolling - 1.0).abs() < 0.01 && (sliding - 1.0).abs() < 0.01,
            "{shape:?} {rolling} {sliding}"
        );
    }
}

#[test]
fn a_body_that_resists_rolling_lies_below_its_angle_and_slows_down_on_a_floor() {
    for (shape, motion, share) in [
        (Shape::Disc, Motion::Free(PLANE), 2.0 / 3.0),
        (Shape::Sphere, Motion::Free(FREE), 5.0 / 7.0),
    ] {
        let resists =
            |rolling_friction: f64, slope: f64, speed: f64, accelerations: Accelerations| {
                let law = Material { rolling_friction, ..material(1.0, 0.5, 0.8) };
                let mut one =
                    [body(shape, 0.01, vector![0.1, 0.01, 0.05], vector![speed, 0.0, 0.0])];
                one[0].motion = motion;
                one[0].spin.z = -speed / 0.01;
                one[0].centre.y -= one[0].mass() * 9.81 * slope.cos() / 1e6;
                let mut wall = contacts(&one, law, [2.0, 0.1, 0.1], &[1], Substeps::Auto);
                for _ in 0..200 {
                    wall.advance(&mut one, &[accelerations], 2.5e-3).unwrap();
                }
                (one, wall)
            };
        let down = |slope: f64| accelerations(9.81 * slope.sin(), -9.81 * slope.cos());
        // The normal force has the lever mu_r R, weight the lever R tan(slope).
        let (one, wall) = resists(0.2, f64::atan(0.19), 0.0, down(f64::atan(0.19)));
        assert!(
            one[0].velocity.norm() < 1e-7 && (one[0].centre.x - 0.1) < 1e-4,
            "{shape:?}: {:?}",
            one[0].velocity
        );
        assert_eq!(wall.touching.springs.len(), 1);
        let slope = f64::atan(0.3);
        let (one, _) = resists(0.2, slope, 0.0, down(slope));
        let expected = share * 9.81 * slope.cos() * (0.3 - 0.2) * 0.5;
        assert!(
            (one[0].velocity.x / expected - 1.0).abs() < 0.01,
            "{shape:?}: {} of {expected}",
            one[0].velocity.x
        );
        // On a floor it slows down at mu_r g times that share, and then lies.
        let (one, _) = resists(0.02, 0.0, 0.2, down(0.0));
        let expected = 0.2 - share * 0.02 * 9.81 * 0.5;
        assert!(
            (one[0].velocity.x / expected - 1.0).abs() < 0.01,
            "{shape:?}: {} of {expected}",
            one[0].velocity.x
        );
        let (one, wall) = resists(0.2, 0.0, 0.2, down(0.0));
        assert!(one[0].velocity.norm() < 1e-6, "{shape:?}: {:?}", one[0].velocity);
        assert!(wall.slid() < 1e-9, "nothing is taken from what lies");
    }
}

#[test]
fn a_block_below_its_friction_angle_stays_and_remembers_why() {
    let block = Motion::Free(Freedom { rotation: [false; 3], ..PLANE });
    let (_, mut wall, mut one) = acceleration_down(Shape::Disc, 0.4, f64::atan(0.35), block);
    let weight = one[0].mass() * 9.81 * f64::atan(0.35).sin();
    let memory = wall.touching.springs.clone();
    assert_eq!((memory.len(), memory[0].0, memory[0].1), (1, 0, 1));
    assert!((memory[0].2.tangential.x * 2.0 / 7.0 * 1e6 / weight - 1.0).abs() < 1e-3, "{memory:?}");
    assert!(one[0].velocity.norm() < 1e-6, "{}", one[0].velocity);
    assert!(
        (one[0].centre.x - 0.1) < 3.0 * memory[0].2.tangential.x,
        "{} {}",
        one[0].centre.x - 0.1,
        memory[0].2.tangential.x
    );
    // A restart with the memory goes on alike; one without it slips.
    let mut again = one.clone();
    let mut restarted = acceleration_down(Shape::Disc, 0.4, 0.0, block).1;
    restarted.touching.springs = memory.clone();
    let down = [accelerations(9.81 * f64::atan(0.35).sin(), -9.81 * f64::atan(0.35).cos())];
    wall.advance(&mut one, &down, 2.5e-3).unwrap();
    restarted.advance(&mut again, &down, 2.5e-3).unwrap();
    assert_eq!(one[0].centre, again[0].centre);
    let foreign = Touching { springs: vec![(0, 3, Default::default())] };
    assert!(restarted.check(&wall.touching).is_ok() && restarted.check(&foreign).is_err());
    // Lifted, it forgets.
    one[0].velocity.y = 1.0;
    wall.advance(&mut one, &down, 2.5e-3).unwrap();
    assert_eq!(wall.touching.springs.len(), 0);
    let slips = acceleration_down(Shape::Disc, 0.4, f64::atan(0.45), block).0;
    assert!(slips > 0.0);
}

/// Impulses by the fluid in the gap of two bodies over a hundredth of a millisecond.
fn film_impulses(bodies: &mut [Body], axes: &[usize]) -> Vec<Impulse> {
    let medium = Medium { density: 1000.0, viscosity: 0.1, spacing: 2e-3, ..Medium::default() };
    let fixed = contacts(bodies, material(1.0, 0.9, 0.0), [1e3; 3], axes, Substeps::Auto).law;
    let mut contacts = Touched::new(fixed.within(medium));
    contacts.advance(bodies, &vec![Accelerations::default(); bodies.len()], 1e-5).unwrap();
    contacts.impulses().to_vec()
}

/// Two of these radii at a gap of a fifth of a millimetre, askew; the first one's centre in the
/// middle of a large box.
fn beside_each_other(shape: Shape, radii: [f64; 2]) -> [Body; 2] {
    let along = if matches!(shape, Shape::Disc) {
        vector![0.6, 0.8, 0.0]
    } else {
        vector![2.0, 3.0, -6.0] / 7.0
    };
    let first = vector![500.0, 500.0, 500.0];
    let second = first + (radii[0] + radii[1] + 2e-4) * along;
    [
        body(shape, radii[0], first, Vector3::zeros()),
        body(shape, radii[1], second, Vector3::zeros()),
    ]
}

/// Spins after the fluid in the gaps has acted for a tenth of a second on a row of discs, all
/// alike, that fills a period.
fn spins_in_a_row(count: usize, gap: f64, start: f64) -> Vec<f64> {
    let medium = Medium { density: 1000.0, viscosity: 0.1, spacing: 2.5e-3, roughness: 1e-6 };
    let pitch = 0.02 + gap;
    let size = [count as f64 * pitch, 1.0, 0.0];
    let place = |k: usize| vector![(start + k as f64 * pitch).rem_euclid(size[0]), 0.5, 0.0];
    let mut row: Vec<Body> =
        (0..count).map(|k| body(Shape::Disc, 0.01, place(k), vector![0.1, 0.3, 0.0])).collect();
    row.iter_mut().for_each(|disc| disc.spin.z = 5.0);
    let law = contacts(&row, material(1.0, 0.9, 0.3), size, &[1], Substeps::Auto).law;
    let mut contacts = Touched::new(law.within(medium));
    for _ in 0..10 {
        let taken =
            contacts.advance(&mut row, &vec![Accelerations::default(); count], 0.01).unwrap();
        assert!(
            taken < 50 || count > 1,
            "{taken} substeps for a body that never touches its image"
        );
    }
    // What a disc gives to one side it gets from the other: together they keep their momentum.
    let momentum: Vector3<f64> = row.iter().map(|disc| disc.velocity / count as f64).sum();
    assert!((momentum - vector![0.1, 0.3, 0.0]).norm() < 1e-12, "{momentum}");
    assert!(row.iter().all(|disc| (disc.velocity - momentum).norm() < 0.01), "{row:?}");
    row.iter().map(|disc| disc.spin.z).collect()
}

#[test]
fn lubrication_slows_the_spin_of_a_disc_beside_its_own_image_as_in_a_row_of_any_number() {
    for gap in [1e-4, 1e-3] {
        // With a border of the period within a disc, and in a gap.
        let spins: Vec<Vec<f64>> = [(1, 0.0), (1, 0.0101), (2, 0.003), (3, 0.0), (4, 0.0)]
            .map(|(n, x)| spins_in_a_row(n, gap, x))
            .into();
        println!("gap {gap} m: {spins:?} rad/s of 5");
        assert!(spins[0][0] < 4.6 && spins[0][0] > 0.01, "{spins:?}");
        let off =
            spins.iter().flatten().map(|spin| (spin / spins[0][0] - 1.0).abs()).fold(0.0, f64::max);
        // Pairs act one after the other in a substep.
        assert!(off < 0.015, "gap {gap}: {spins:?}");
    }
}

#[test]
fn lubrication_at_a_plane_of_symmetry_turns_a_body_as_its_mirror_image_would() {
    for (shape, spin) in
        [(Shape::Disc, vector![0.0, 0.0, 3.0]), (Shape::Sphere, vector![2.0, -1.0, 3.0])]
    {
        let (radius, gap, y) = (5e-3, 1e-4, 500.0);
        let medium = Medium { density: 1000.0, viscosity: 0.1, spacing: 2e-3, ..Medium::default() };
        let flat = if matches!(shape, Shape::Disc) { 0.0 } else { 0.01 };
        let mut two = [1.0, -1.0].map(|side| {
            let place = vector![500.0, y + side * (radius + gap), 500.0];
            let mut one = body(shape, radius, place, vector![0.02, -0.01 * side, flat]);
            one.spin = vector![side * spin.x, spin.y, side * spin.z];
            one
        });
        let mut one = [two[0].clone()];
        let size = [1e3; 3];
        let pair = contacts(&two, material(1.0, 0.9, 0.0), size, &[], Substeps::Auto).law;
        let mut mirror = contacts(&one, material(1.0, 0.9, 0.0), size, &[1], Substeps::Auto).law;
        (mirror.walls[0].at, mirror.walls[0].side) = (y, WallSide::Slip);
        let (mut pair, mut mirror) =
            (Touched::new(pair.within(medium)), Touched::new(mirror.within(medium)));
        pair.advance(&mut two, &[Accelerations::default(); 2], 1e-4).unwrap();
        mirror.advance(&mut one, &[Accelerations::default()], 1e-4).unwrap();
        let turned = (two[0].spin - spin).norm();
        let off = [
            (one[0].spin - two[0].spin).norm() / turned,
            (one[0].velocity - two[0].velocity).norm() / 0.01,
        ];
        println!("{shape:?}: {:?} of {spin:?}, off by {off:?}", one[0].spin);
        assert!(
            turned > 3e-4 * spin.norm() && off[0] < 1e-3 && off[1] < 1e-4,
            "{shape:?}: {off:?}, {turned}"
        );
    }
}

/// A disc that lies in the cusp between another one and the image of that across a period of one
/// and a half diameters: it touches the same disc on both sides.
#[test]
fn a_disc_rests_on_two_images_of_another_across_a_short_period() {
    let (radius, length) = (0.01, 0.03);
    for start in [0.0, 0.004, 0.016] {
        let place = |x: f64, y: f64| vector![(start + x).rem_euclid(length), y, 0.0];
        let high = 0.05 + f64::sqrt(4.0 * radius * radius - 0.25 * length * length);
        let mut two = [(0.0, 0.05), (0.5 * length, high)]
            .map(|(x, y)| body(Shape::Disc, radius, place(x, y), Vector3::zeros()));
        two[0].motion = Motion::Fixed;
        let mut contacts =
            contacts(&two, material(1.0, 0.5, 0.5), [length, 0.1, 0.0], &[1], Substeps::Auto);
        // Aside too, within what friction holds.
        let accelerations = [Accelerations::default(), accelerations(1.0, -9.81)];
        for _ in 0..400 {
            contacts.advance(&mut two, &accelerations, 1e-3).unwrap();
        }
        let memory = contacts.touching.springs.clone();
        let images: Vec<f64> = memory.iter().map(|(.., springs)| springs.image.x).collect();
        assert!(images.len() == 2 && (images[0] - images[1]).abs() == 1.0, "{memory:?}");
        assert!(
            two[1].velocity.norm() < 1e-6
                && (two[1].centre - place(0.5 * length, high)).norm() < 1e-4,
            "{two:?}"
        );
        let weight = two[1].mass() * 9.81 * 1e-3;
        assert!(
            (contacts.impulses()[1].linear.y / weight - 1.0).abs() < 1e-3,
            "{:?}",
            contacts.impulses()
        );
        // With the springs kept per image it goes on as it was.
        let (mut again, still) = (two.clone(), two[1].velocity);
        let mut restarted = Touched::new(contacts.law.clone());
        restarted.touching.springs = memory;
        assert!(restarted.check(&restarted.touching).is_ok());
        contacts.advance(&mut two, &accelerations, 1e-3).unwrap();
        restarted.advance(&mut again, &accelerations, 1e-3).unwrap();
        assert_eq!((two[1].centre, two[1].spin), (again[1].centre, again[1].spin));
        assert!((two[1].velocity - still).norm() < 1e-6);
    }
}

/// Far pairs are not asked in every substep that others need: they get what they would get alone.
#[test]
fn the_fluid_between_two_does_the_same_beside_others_that_need_many_substeps() {
    let medium = Medium { density: 1000.0, viscosity: 0.1, spacing: 2e-3, ..Medium::default() };
    let sphere = |x: f64, speed: f64| {
        body(Shape::Sphere, 0.01, vector![x, 0.5, 0.5], vector![speed, 0.0, 0.0])
    };
    let impulse = |bodies: &mut [Body]| {
        let law = contacts(bodies, material(1.0, 0.9, 0.0), [1.0; 3], &[], Substeps::Auto).law;
        let mut contacts = Touched::new(law.within(medium));
        // A step that ends amid a stride, and another one.
        let accelerations = vec![Accelerations::default(); bodies.len()];
        let taken = contacts.advance(bodies, &accelerations, 1.234e-2).unwrap();
        (taken, contacts.impulses()[0].linear.x)
    };
    let apart = [sphere(0.1, 0.01), sphere(0.1215, -0.01)];
    let (few, alone) = impulse(&mut apart.clone());
    let [first, second] = apart;
    let (many, beside) = impulse(&mut [first, second, sphere(0.5, 0.1), sphere(0.5201, -0.1)]);
    assert!(few < 50 && many > 10 * few, "{few} {many}");
    assert!(
        alone < 0.0 && (beside / alone - 1.0).abs() < 1e-3,
        "{beside} beside others, {alone} alone"
    );
}

#[test]
fn what_fills_a_gap_takes_no_momentum_and_no_rigid_motion() {
    for (shape, spin) in
        [(Shape::Disc, vector![0.0, 0.0, 3.0]), (Shape::Sphere, vector![2.0, -1.0, 3.0])]
    {
        let flat =
            |v: Vector3<f64>| if matches!(shape, Shape::Disc) { vector![v.x, v.y, 0.0] } else { v };
        let mut bodies = beside_each_other(shape, [5e-3, 1.2e-2]);
        let arm = bodies[0].centre - bodies[1].centre;
        bodies[0].velocity = flat(vector![0.02, -0.01, 0.03]);
        (bodies[0].spin, bodies[1].spin) = (spin, -0.5 * spin);
        let [first, second] = [0, 1].map(|k| film_impulses(&mut bodies.clone(), &[])[k]);
        let (size, lever) = (first.linear.norm(), first.linear.norm() * arm.norm());
        assert!(size > 1e-9 && first.angular.norm() > 1e-3 * lever, "{first:?}");
        assert!((first.linear + second.linear).norm() < 1e-12 * size);
        let turning = first.angular + second.angular + arm.cross(&first.linear);
        assert!(turning.norm() < 1e-4 * lever, "{turning} of {lever}");

        // As one: carried along and turned about any point.
        let drift = flat(vector![0.3, 0.2, -0.1]);
        for (body, rest) in bodies.iter_mut().zip([Vector3::zeros(), spin.cross(&arm)]) {
            (body.velocity, body.spin) = (drift - rest, spin);
        }
        let still = film_impulses(&mut bodies, &[]);
        assert!(
            still.iter().all(|i| i.linear.norm() < 1e-3 * size && i.angular.norm() < 1e-3 * lever),
            "{still:?}"
        );
    }
}

/// What is put down to touch a wall, and its image at the other side of the box, which rounds
/// differently, have the same lubrication layer: it is ten times that of the narrowest gap
/// otherwise.
#[test]
fn a_gap_of_nothing_but_rounding_is_none() {
    let radius = 5e-3;
    let [touching, rounded, apart] = [0.0, 1e-12, 1e-6].map(|gap: f64| {
        let centre = vector![500.0, radius * (1.0 + gap), 500.0];
        film_impulses(&mut [body(Shape::Sphere, radius, centre, vector![0.01, 0.0, 0.0])], &[1])[0]
            .linear
            .x
    });
    assert!((rounded / touching - 1.0).abs() < 1e-6, "{rounded}, {touching} touching");
    assert!(apart / touching > 1.5, "{apart}, {touching} touching");
}

#[test]
fn a_very_large_body_is_a_wall_to_what_fills_a_gap() {
    for (shape, spin) in
        [(Shape::Disc, vector![0.0, 0.0, 3.0]), (Shape::Sphere, vector![2.0, -1.0, 3.0])]
    {
        // The pair acts in the middle of the gap, the wall at its own side: a narrow one.
        let (radius, gap) = (5e-3, 5e-6);
        let mut beside_wall =
            [body(shape, radius, vector![500.0, radius + gap, 500.0], vector![0.02, -0.01, 0.0])];
        beside_wall[0].spin = spin;
        let wall = film_impulses(&mut beside_wall.clone(), &[1])[0];
        let [small] = beside_wall;
        let mut large = body(shape, 300.0, small.centre, Vector3::zeros());
        large.centre.y -= radius + gap + 300.0;
        large.motion = Motion::Fixed;
        let large = film_impulses(&mut [small, large], &[0])[0];
        assert!(
            (wall.linear - large.linear).norm() < 2e-3 * wall.linear.norm(),
            "{wall:?} {large:?}"
        );
        assert!(
            (wall.angular - large.angular).norm() < 2e-3 * wall.angular.norm(),
            "{wall:?} {large:?}"
        );
    }
}

#[test]
fn bodies_that_are_not_free_act_with_infinite_mass_and_their_own_velocity() {
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
    assert_eq!(pair.impulses()[0].linear, -pair.impulses()[1].linear);
    two[1].motion = Motion::Fixed;
    two[1].centre.x = 0.085;
    assert_eq!(pair.advance(&mut two, &[Accelerations::default(); 2], 0.01).unwrap(), 0);
    assert_eq!(two[1].centre.x, 0.085);
}

#[test]
fn a_body_that_is_pinned_turns_but_stays() {
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
        (pair.impulses()[0].linear.x / -1e6 / 1e-4 / 1e-3 - 1.0).abs() < 0.03,
        "{:?}",
        pair.impulses()
    );
}

#[test]
fn what_a_user_can_cause_is_an_error_that_names_the_particle() {
    let says = |body: Body, substeps, dt, accelerations: Accelerations, words: &[&str]| {
        let mut still = body.clone();
        (still.centre, still.velocity) = (vector![0.15, 0.15, 0.0], Vector3::zeros());
        let mut two = [still, body];
        two[1].id = 1;
        let mut pair = contacts(&two, material(1.0, 0.5, 0.3), [0.2, 0.2, 0.0], &[1], substeps);
        pair.law.periods[0] = None;
        pair.law.neighbours = Neighbours::new(&two, pair.law.size, pair.law.periods);
        let text = pair
            .advance(&mut two, &[Accelerations::default(), accelerations], dt)
            .unwrap_err()
            .to_string();
        assert!(words.iter().all(|w| text.contains(w)), "{text}");
    };
    let disc =
        |x: f64, y: f64, v: f64| body(Shape::Disc, 0.01, vector![x, y, 0.0], vector![v, 0.0, 0.0]);
    let (auto, still) = (Substeps::Auto, Accelerations::default());
    says(disc(0.134, 0.15, 0.0), auto, 1e-3, still, &["particles 0 and 1", "0.40", "stiffer"]);
    says(disc(0.15, 0.15, 0.0), auto, 1e-3, still, &["particles 0 and 1", "2.00"]);
    says(disc(0.1, 0.003, 0.0), auto, 1e-3, still, &["particle 1 and the wall at y = 0 m", "0.70"]);
    says(disc(0.1, -0.003, 0.0), auto, 1e-3, still, &["particle 1 is beyond the wall at y = 0 m"]);
    says(disc(0.1, 0.1, -30.0), auto, 1e-2, still, &["particle 1 has left the box", "x = -0.2"]);
    says(
        disc(0.129, 0.15, 5.0),
        Substeps::Fixed(2),
        1e-2,
        still,
        &["particles 0 and 1", "contact.substeps"],
    );
    says(disc(0.129, 0.15, 5.0), auto, 1e6, still, &["particles 0 and 1", "lower the stiffness"]);
    says(disc(f64::NAN, 0.1, 0.0), auto, 1e-2, still, &["particle 1", "not a finite number"]);
    says(
        disc(0.1, 0.1, 0.0),
        auto,
        1e-2,
        accelerations(f64::NAN, 0.0),
        &["particle 1", "not a finite number"],
    );
}
