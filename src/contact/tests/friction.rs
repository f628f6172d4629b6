//! Friction and rolling along walls and down slopes.

use super::*;

#[test]
fn oblique_wall_impact_slides_by_coulomb_law() {
    for (shape, inertia) in [(Shape::Disc, 0.5), (Shape::Sphere, 0.4)] {
        let e = 0.8;
        let mu = 0.1;
        let speed = 0.5;
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
fn moving_wall_drags_body_by_friction() {
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
    moving.law.setup.walls[0].velocity.x = 2.0;
    moving.advance(&mut dragged, &[Accelerations::default()], 1e-3).unwrap();
    assert!((dragged[0].velocity.x - fixed[0].velocity.x - 2.0).abs() < 1e-9);
    assert!((dragged[0].spin.z - fixed[0].spin.z).abs() < 1e-6);
}

#[test]
fn sticking_wall_contact_never_gains_energy() {
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
fn sliding_and_rolling_down_a_slope() {
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
fn resists_rolling_on_slope_and_floor() {
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
        assert!(wall.outcome().friction_loss < 1e-9, "nothing is taken from what lies");
    }
}

#[test]
fn block_below_friction_angle_sticks() {
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
    // A restart with the springs goes on alike; one without them slips.
    let mut again = one.clone();
    let mut restarted = acceleration_down(Shape::Disc, 0.4, 0.0, block).1;
    restarted.touching.springs = memory.clone();
    let down = [accelerations(9.81 * f64::atan(0.35).sin(), -9.81 * f64::atan(0.35).cos())];
    wall.advance(&mut one, &down, 2.5e-3).unwrap();
    restarted.advance(&mut again, &down, 2.5e-3).unwrap();
    assert_eq!(one[0].centre, again[0].centre);
    let foreign = Touching { springs: vec![(0, 3, Default::default())] };
    assert!(
        restarted.setup().check(&wall.touching).is_ok()
            && restarted.setup().check(&foreign).is_err()
    );
    // A body that is lifted loses its spring.
    one[0].velocity.y = 1.0;
    wall.advance(&mut one, &down, 2.5e-3).unwrap();
    assert_eq!(wall.touching.springs.len(), 0);
    let slips = acceleration_down(Shape::Disc, 0.4, f64::atan(0.45), block).0;
    assert!(slips > 0.0);
}
