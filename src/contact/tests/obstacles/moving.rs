//! Obstacles that move, that go on across periodic sides, and that a lubrication layer parts from a
//! body.

use super::*;

/// A sphere on a belt moves as on a wall of the box that slides as fast.
#[test]
fn moving_obstacle_carries_sphere_as_sliding_wall_does() {
    let r = 0.01;
    let sphere = body(Shape::Sphere, r, vector![0.15, 1.2 * r, 0.1], Vector3::zeros());
    let law = Material { normal_stiffness: 1e5, ..material(1.0, 0.5, 0.3) };
    let belt = vector![0.2, 0.0, -0.1];
    let mut on_wall = vec![sphere.clone()];
    let mut wall = contacts(&on_wall, law, SIZE, &[0, 1, 2], Substeps::Auto);
    wall.law.setup.walls.iter_mut().filter(|w| w.axis == 1).for_each(|w| w.velocity = belt);
    let mut on_belt = vec![sphere, standing(bed(10, |_, _| BED), SIZE)];
    on_belt[0].centre.y += BED;
    on_belt[1].motion = Motion::Prescribed(None);
    on_belt[1].velocity = belt;
    let mut obstacle = contacts(&on_belt, law, SIZE, &[0, 1, 2], Substeps::Auto);
    for _ in 0..300 {
        wall.advance(&mut on_wall, &[accelerations(0.0, -G)], 1e-3).unwrap();
        obstacle.advance(&mut on_belt, &[accelerations(0.0, -G); 2], 1e-3).unwrap();
    }
    let off = on_belt[0].centre - BED * Vector3::y() - on_wall[0].centre;
    println!("{:e} m apart at {:?} m/s", off.norm(), on_wall[0].velocity);
    assert!(off.norm() < 1e-9 && on_wall[0].velocity.x > 0.05, "{off}");
    assert!((on_belt[0].spin - on_wall[0].spin).norm() < 1e-6);
}

/// A floor that rises at V throws a ball at rest up at 2 V.
#[test]
fn rising_obstacle_throws_ball_at_twice_its_speed() {
    let r = 0.01;
    let ball = body(Shape::Sphere, r, vector![0.2, BED + 1.05 * r, 0.1], Vector3::zeros());
    let mut all = [ball, standing(bed(10, |_, _| BED), SIZE)];
    all[1].motion = Motion::Prescribed(None);
    all[1].velocity.y = 0.5;
    let law = material(1.0, 1.0, 0.0);
    let mut held = contacts(&all, law, SIZE, &[0, 1, 2], Substeps::Auto);
    for _ in 0..20 {
        held.advance(&mut all, &[Accelerations::default(); 2], 2e-4).unwrap();
    }
    assert!((all[0].velocity.y - 1.0).abs() < 2e-3, "{}", all[0].velocity.y);
    assert_eq!(all[1].velocity.y, 0.5);
}

/// A cube on a turntable goes round with it.
#[test]
fn spinning_obstacle_carries_cube_round() {
    let h = 0.01;
    let arm = 0.05;
    let spin = 2.0;
    let law = Material { normal_stiffness: 1e5, ..material(1.0, 0.3, 1.0) };
    let cube = free(&solids::cuboid([h; 3], 5e-4), vector![0.2 + arm, 0.0, 0.1], Vector3::zeros());
    let mut all = [cube, standing(bed(10, |_, _| BED), SIZE)];
    all[0].centre.y = BED + h - all[0].mass() * G / 1e5 / 4.0f64.powf(0.25);
    all[0].velocity.z = -arm * spin;
    all[0].spin.y = spin;
    all[1].motion = Motion::Prescribed(None);
    all[1].spin.y = spin;
    let mut held = contacts(&all, law, SIZE, &[0, 1, 2], Substeps::Auto);
    let steps = 400;
    for _ in 0..steps {
        held.advance(&mut all, &[accelerations(0.0, -G); 2], 1e-3).unwrap();
    }
    let angle: f64 = 1e-3 * f64::from(steps) * spin;
    let place = vector![0.2 + arm * angle.cos(), all[0].centre.y, 0.1 - arm * angle.sin()];
    let off = (all[0].centre - place).norm();
    let turned = all[0].orientation.scaled_axis();
    println!("{off:e} m off its circle, turned by {turned:?} of {angle}");
    assert!(off < 2e-4 && (turned.y - angle).abs() < 0.01, "{off:e} {turned}");
}

/// Triangles of a flat bed that fill a period along x.
fn periodic_bed(size: [f64; 3]) -> Obstacle {
    let mut triangles = Vec::new();
    for (i, j) in (0..8).flat_map(|j| (0..7).map(move |i| (i, j))) {
        let at = |i: usize, j: usize| {
            vector![size[0] * i as f64 / 7.0, BED, 1.5 * size[2] * j as f64 / 8.0 - 0.05]
        };
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)];
        triangles.extend([[a, d, b], [a, c, d]]);
    }
    let room = Extent { size: Vector3::from(size), periodic: [true, false, false] };
    Obstacle::surface(&triangles, &room).unwrap()
}

/// A sphere rolls across a periodic side over an obstacle as over a wall of the box.
#[test]
fn sphere_rolls_on_across_periodic_side() {
    let r = 0.01;
    let sphere = body(Shape::Sphere, r, vector![0.35, 1.05 * r, 0.1], vector![0.2, 0.0, 0.03]);
    let law = Material { normal_stiffness: 1e5, ..material(1.0, 0.5, 0.3) };
    let mut on_wall = vec![sphere.clone()];
    let mut wall = contacts(&on_wall, law, SIZE, &[1, 2], Substeps::Auto);
    let mut on_bed = vec![sphere, standing(periodic_bed(SIZE), SIZE)];
    on_bed[0].centre.y += BED;
    let mut obstacle = contacts(&on_bed, law, SIZE, &[1, 2], Substeps::Auto);
    for _ in 0..600 {
        wall.advance(&mut on_wall, &[accelerations(1.0, -G)], 1e-3).unwrap();
        obstacle.advance(&mut on_bed, &[accelerations(1.0, -G); 2], 1e-3).unwrap();
        obstacle.setup().check(&obstacle.touching).unwrap();
    }
    let off = on_bed[0].path() - BED * Vector3::y() - on_wall[0].path();
    println!("{:e} m apart at x = {:.3} m", off.norm(), on_wall[0].path().x);
    assert!(off.norm() < 1e-9 && on_wall[0].path().x > 0.45, "{off}");
}

/// The fluid in the gap beside an obstacle resists as beside a wall of the box.
#[test]
fn lubrication_beside_obstacle_is_that_beside_wall() {
    let r = 0.01;
    let medium = Medium { density: 1000.0, viscosity: 0.1, spacing: 2e-3, ..Medium::default() };
    let mut ball = body(Shape::Sphere, r, vector![0.2, r + 2e-4, 0.1], vector![0.1, -0.2, 0.05]);
    ball.spin = vector![3.0, 2.0, -4.0];
    let law = material(1.0, 0.9, 0.3);
    let motion = |mut all: Vec<Body>| {
        let held = contacts(&all, law, SIZE, &[0, 1, 2], Substeps::Auto).law;
        let mut held = Touched::new(held.within(medium));
        let still = vec![Accelerations::default(); all.len()];
        for _ in 0..100 {
            held.advance(&mut all, &still, 1e-4).unwrap();
        }
        (all[0].velocity, all[0].spin)
    };
    let mut lifted = ball.clone();
    lifted.centre.y += BED;
    let [wall, obstacle] =
        [vec![ball.clone()], vec![lifted, standing(bed(10, |_, _| BED), SIZE)]].map(motion);
    println!("{wall:?} {obstacle:?}");
    assert!((wall.0 - obstacle.0).norm() < 1e-9 && (wall.1 - obstacle.1).norm() < 1e-7);
    assert!((wall.0 - ball.velocity).norm() > 0.05);
}

/// Time (s) of a second of spheres that rain on a wall of the box or on an obstacle.
fn time_of_rain(fine: usize) -> f64 {
    let r = 0.002;
    let mut dice = Dice(3);
    let mut all: Vec<Body> = (0..1000)
        .map(|k| {
            let i = k % 50;
            let j = k / 50;
            let at = vector![0.0078 * i as f64 + 0.009, 1.5 * r, 0.0095 * j as f64 + 0.01];
            let mut one = body(Shape::Sphere, r, at, vector![0.2 * dice.about_zero(), 0.0, 0.0]);
            one.centre.y += if fine > 0 { BED } else { 0.0 };
            one
        })
        .collect();
    if fine > 0 {
        all.push(standing(bed(fine, |_, _| BED), SIZE));
    }
    let law = Material { normal_stiffness: 1e3, ..material(1.0, 0.5, 0.3) };
    let mut held = contacts(&all, law, SIZE, &[0, 1, 2], Substeps::Auto);
    let push = vec![accelerations(0.0, -G); all.len()];
    let begin = std::time::Instant::now();
    let mut taken = 0;
    for _ in 0..200 {
        taken += held.advance(&mut all, &push, 1e-3).unwrap();
    }
    let time = begin.elapsed().as_secs_f64();
    println!("{fine}: {time:.3} s, {taken} substeps, {} pairs", held.pairs.list.len());
    time
}

/// A thousand spheres over an obstacle of 20,000 triangles cost about twice what they cost over a
/// wall of the box.
#[test]
#[ignore = "takes the time"]
fn cost_of_obstacle_beside_wall() {
    let wall = time_of_rain(0).min(time_of_rain(0));
    for fine in [10, 100] {
        let found = time_of_rain(fine).min(time_of_rain(fine));
        println!("{} triangles: {:.2} times the wall's", 2 * fine * fine, found / wall);
    }
}
