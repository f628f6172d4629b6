//! Contacts of bodies that are not round, beside closed forms.

use super::crowd::Dice;
use super::solids::{self, Parts, free, kinetic, momenta};
use super::*;
use crate::contact::pair::Met;
use mics_shapes::Core;

const G: f64 = 9.81;

fn stiff(stiffness: f64, restitution: f64, friction: f64) -> Material {
    Material { normal_stiffness: stiffness, ..material(1.0, restitution, friction) }
}

fn falling(slope: f64) -> Accelerations {
    accelerations(G * slope.sin(), -G * slope.cos())
}

/// Two touching spheres of radius R strike a frictionless wall, elastic: the centre leaves at
/// `J/M - v` with `J = 2 M v/(1 + cos^2/1.4)`, and turns (reference/shapes/contact_shapes.csv).
#[test]
fn dumbbell_on_frictionless_wall_leaves_as_rigid_body() {
    let radius = 0.01;
    let v = 0.5;
    let dumbbell = solids::clump(3, radius, 2, 2.0 * radius);
    for (degrees, speed, spin) in [
        (15.0, 0.20016, 0.82805),
        (30.0, 0.30233, 0.80561),
        (45.0, 0.47368, 0.74432),
        (60.0, 0.69697, 0.60606),
        (75.0, 0.90867, 0.35286),
    ] {
        let angle = f64::to_radians(degrees);
        let height = radius * (1.0 + angle.sin()) + 1e-6;
        let mut one = [free(&dumbbell, vector![0.1, height, 0.1], Vector3::z() * angle)];
        one[0].velocity.y = -v;
        let law = stiff(1e8, 1.0, 0.0);
        let mut wall = contacts(&one, law, [0.2; 3], &[0, 1, 2], Substeps::Auto);
        wall.advance(&mut one, &[Accelerations::default()], 0.02 * radius / v).unwrap();
        let [found, turned] = [one[0].velocity.y / v, one[0].spin.z.abs() * radius / v];
        println!("{degrees} degrees: {found:.5} of {speed}, {turned:.5} of {spin}");
        assert!((found / speed - 1.0).abs() < 0.01 && (turned / spin - 1.0).abs() < 0.01);
    }
}

/// An ellipse 2:1 on its flat side rocks without slip at 1.1547 sqrt(g/b).
#[test]
fn ellipse_rocks_at_its_frequency() {
    let b = 0.01;
    let tilt = 0.04f64;
    let a = 2.0 * b;
    let law = stiff(1e6, 0.5, 10.0);
    let ellipse = solids::ellipse([a, b], 0.05 * b);
    let mut one = [free(&ellipse, Vector3::zeros(), Vector3::z() * tilt)];
    let sink = one[0].mass() * G / 1e6;
    one[0].centre = vector![0.1, (a * tilt.sin()).hypot(b * tilt.cos()) - sink, 0.0];
    let mut wall = contacts(&one, law, [0.2, 0.2, 0.0], &[0, 1], Substeps::Auto);
    let dt = 1e-3;
    let mut crossings = Vec::new();
    for k in 0..700 {
        let before = one[0].orientation.scaled_axis().z;
        wall.advance(&mut one, &[falling(0.0)], dt).unwrap();
        let now = one[0].orientation.scaled_axis().z;
        if before > 0.0 && now <= 0.0 {
            crossings.push((k as f64 + before / (before - now)) * dt);
        }
    }
    let periods = crossings.len() - 1;
    let period = (crossings[periods] - crossings[0]) / periods as f64;
    let frequency = 2.0 * PI / period / (G / b).sqrt();
    println!("{periods} periods: {frequency:.5} of 1.15470");
    assert!(periods >= 3 && (frequency / 1.154_70 - 1.0).abs() < 0.01);
}

/// A body on a slope after some time: how far it has slid (m) and how fast it does (m/s), and by
/// what it has turned (rad).
fn on_slope(shape: &Parts, friction: f64, slope: f64, time: f64) -> (f64, f64, f64) {
    let half = 0.01;
    let law = stiff(1e6, 0.3, friction);
    let size = if shape.dimension == 2 { [0.4, 0.2, 0.0] } else { [0.4, 0.2, 0.2] };
    let mut one = [free(shape, vector![0.1, half, 0.5 * size[2]], Vector3::zeros())];
    one[0].centre.y -= one[0].mass() * G / 1e6;
    let mut wall = contacts(&one, law, size, &[0, 1, 2][..shape.dimension], Substeps::Auto);
    for _ in 0..(time / 2e-3) as usize {
        wall.advance(&mut one, &[falling(slope)], 2e-3).unwrap();
    }
    (one[0].centre.x - 0.1, one[0].velocity.norm(), one[0].orientation.angle())
}

/// The slope (degrees) at which a body tips that is lifted slowly, with friction that holds it.
fn tipping_angle(shape: &Parts) -> f64 {
    let half = 0.01;
    let dt = 2e-3;
    let size = if shape.dimension == 2 { [0.4, 0.2, 0.0] } else { [0.4, 0.2, 0.2] };
    let mut one = [free(shape, vector![0.1, half, 0.5 * size[2]], Vector3::zeros())];
    let law = stiff(1e6, 0.3, 3.0);
    let mut wall = contacts(&one, law, size, &[0, 1, 2][..shape.dimension], Substeps::Auto);
    let mut slope = 42.0;
    while one[0].orientation.angle() < 5e-3 {
        wall.advance(&mut one, &[falling(f64::to_radians(slope))], dt).unwrap();
        slope += 2.0 * dt;
    }
    slope
}

/// A cube that spins on its face stops by friction: the moment of a patch is `mu N s`, with s the
/// distance of its corners from the middle.
#[test]
fn friction_stops_spinning_cube() {
    let h = 0.01;
    let mu = 0.3;
    let mut one = [free(&solids::cuboid([h; 3], 5e-4), vector![0.1, h, 0.1], Vector3::zeros())];
    let law = stiff(1e5, 0.3, mu);
    one[0].centre.y -= 4.0f64.powf(-0.25) * one[0].mass() * G / 1e5;
    one[0].spin.y = 20.0;
    let mut wall = contacts(&one, law, [0.2; 3], &[0, 1, 2], Substeps::Auto);
    let spread = 0.95 * h * f64::sqrt(2.0);
    let slowing = mu * G * spread / (2.0 / 3.0 * h * h);
    for k in 1..60 {
        wall.advance(&mut one, &[falling(0.0)], 1e-3).unwrap();
        let expected = (20.0 - slowing * 1e-3 * f64::from(k)).max(0.0);
        assert!((one[0].spin.y - expected).abs() < 0.2, "{k}: {} {expected}", one[0].spin.y);
    }
    assert!(one[0].spin.norm() < 1e-6, "{}", one[0].spin);
}

/// A square and a cube slide where `tan = mu`, and tip at 45 degrees where friction holds them.
#[test]
fn square_and_cube_on_slope_slide_and_tip() {
    let h = 0.01;
    let skin = 5e-5;
    for shape in [solids::rectangle([h, h], skin), solids::cuboid([h; 3], skin)] {
        let mu = 0.5f64;
        // Put down suddenly it slides a little at first.
        let (slid, speed, turned) = on_slope(&shape, mu, (0.99 * mu).atan(), 0.3);
        println!("{}D below mu: {slid:.1e} m, {speed:.1e} m/s", shape.dimension);
        assert!(slid < 1e-3 && speed < 1e-6 && turned < 1e-3, "{slid:e} {speed:e} {turned:e}");
        let slope = (1.2 * mu).atan();
        let speed = |time: f64| on_slope(&shape, mu, slope, time).1;
        let gained = (speed(0.3) - speed(0.15)) / 0.15;
        let expected = G * (slope.sin() - mu * slope.cos());
        println!("{}D slides at {gained:.6} m/s2 of {expected:.6}", shape.dimension);
        assert!((gained / expected - 1.0).abs() < 0.01, "{gained} {expected}");
        let (_, speed, _) = on_slope(&shape, mu, (1.01 * mu).atan(), 0.3);
        assert!(speed > 5e-3, "{speed}");
        let tips = tipping_angle(&shape);
        println!("{}D tips at {tips:.2} degrees", shape.dimension);
        assert!((tips / 45.0 - 1.0).abs() < 0.01, "{tips}");
    }
}

/// Relative change of the energy of two bodies by an impact, and their largest gain on the way (of
/// the energy at the start); `None` where they miss each other.
fn impact(shape: &Parts, law: Material, dice: &mut Dice) -> Option<[f64; 2]> {
    let flat = shape.dimension == 2;
    let mut any = |size: f64| {
        let z = if flat { 0.0 } else { dice.about_zero() };
        size * vector![dice.about_zero(), dice.about_zero(), z]
    };
    let spin = |v: Vector3<f64>| if flat { Vector3::z() * (v.x + v.y) } else { v };
    let middle = vector![0.1, 0.1, if flat { 0.0 } else { 0.1 }];
    let v = 0.5;
    let turns = [spin(any(3.0)), spin(any(3.0))];
    let mut two = turns.map(|turn| free(shape, middle, turn));
    let radius = two[0].radius();
    let way = any(1.0).normalize();
    two[0].centre -= 1.01 * radius * way;
    let aside = any(0.7 * radius);
    two[1].centre += 1.01 * radius * way + aside - aside.dot(&way) * way;
    two[0].velocity = v * way + any(0.1 * v);
    two[1].velocity = -v * way + any(0.1 * v);
    two[0].spin = spin(any(0.5 * v / radius));
    two[1].spin = spin(any(0.5 * v / radius));
    let size = if flat { [0.2, 0.2, 0.0] } else { [0.2; 3] };
    let mut pair = contacts(&two, law, size, &[0, 1, 2][..shape.dimension], Substeps::Auto);
    let start = kinetic(&two);
    let momentum = momenta(&two);
    let mut touched = false;
    let mut most = 0.0f64;
    let mut after = 0;
    for _ in 0..60 {
        pair.advance(&mut two, &[Accelerations::default(); 2], 0.04 * radius / v).unwrap();
        let touches = pair.outcome().impulse(0).linear != Vector3::zeros();
        touched |= touches;
        after = if touches || !touched { 0 } else { after + 1 };
        most = most.max(kinetic(&two) / start - 1.0);
        if after > 3 {
            break;
        }
    }
    let end = momenta(&two);
    assert!((end[0] - momentum[0]).norm() < 1e-12 * two[0].mass() * v);
    let turning = (end[1] - momentum[1]).norm() / (two[0].mass() * v * radius);
    assert!(turning < 1e-4, "angular momentum changed by {turning:e}");
    touched.then(|| [kinetic(&two) / start - 1.0, most])
}

/// A hundred random elastic impacts of each shape keep their energy, and some with losses never
/// gain any.
#[test]
fn random_impacts_bring_no_energy() {
    for dimension in [2, 3] {
        for (name, shape) in solids::all(dimension) {
            for (e, friction, impacts) in [(1.0, 0.0, 100), (1.0, 0.3, 100), (0.5, 0.3, 100)] {
                let mut dice = Dice(11);
                let mut count = 0;
                let [mut rise, mut fall] = [0.0f64; 2];
                let mut over = 0;
                while count < impacts {
                    let law = stiff(if dimension == 2 { 3e7 } else { 1e6 }, e, friction);
                    let Some([change, most]) = impact(&shape, law, &mut dice) else { continue };
                    count += 1;
                    rise = rise.max(most);
                    fall = fall.max(-change);
                    over += usize::from(most > 1e-5);
                }
                println!(
                    "{dimension}D {name}, e = {e}, mu = {friction}: rises {rise:.1e} ({over} over \
                    1e-5), falls {fall:.1e}"
                );
                assert!(rise < 1e-3, "{name} {e} {friction}: {rise:e}");
                assert!(friction > 0.0 || fall < 1e-3, "{name}: {fall:e}");
            }
        }
    }
}

/// A cube that lies flat is as stiff as a corner within 4^(2/p), rests still, and one dropped flat
/// comes to rest.
#[test]
fn cube_lying_flat_rests() {
    let half = 0.01;
    for drop in [0.0, 1e-4] {
        let mut one =
            [free(&solids::cuboid([half; 3], 5e-4), vector![0.1, 0.1, 0.1], Vector3::zeros())];
        one[0].centre.y = half + drop;
        let law = stiff(1e5, 0.3, 0.5);
        let mut wall = contacts(&one, law, [0.2; 3], &[0, 1, 2], Substeps::Auto);
        for _ in 0..300 {
            wall.advance(&mut one, &[falling(0.0)], 1e-3).unwrap();
        }
        let sunk = half - one[0].centre.y;
        let whole = one[0].mass() * G / 1e5;
        println!(
            "sinks {:.4} of a corner's depth, {:.1e} m/s",
            sunk / whole,
            one[0].velocity.norm()
        );
        assert!((sunk / whole - 4.0f64.powf(-0.25)).abs() < 0.01, "{}", sunk / whole);
        assert!(one[0].velocity.norm() < 1e-9 && one[0].spin.norm() < 1e-7, "{:?}", one[0]);
        assert!(one[0].orientation.angle() < 1e-6);
    }
}

/// A sphere slides over the face of a fixed box, over its edge and down: it keeps its energy.
#[test]
fn sphere_over_face_and_edge_of_box_keeps_energy() {
    let half = [0.03, 0.01, 0.03];
    let mut block = free(&solids::cuboid(half, 5e-4), vector![0.05, 0.05, 0.05], Vector3::zeros());
    block.motion = Motion::Fixed;
    let sphere = body(Shape::Sphere, 0.005, vector![0.06, 0.065, 0.052], vector![0.1, 0.0, 0.03]);
    let mut two = [block, sphere];
    let law = stiff(1e5, 1.0, 0.0);
    two[1].centre.y -= two[1].mass() * G / 1e5;
    let mut pair = contacts(&two, law, [0.2; 3], &[0, 1, 2], Substeps::Auto);
    let energy = |pair: &Contacts, two: &[Body]| {
        kinetic(&two[1..])
            + two[1].mass() * G * two[1].centre.y
            + pair.stored(two, |_| Vector3::zeros())
    };
    let start = energy(&pair, &two);
    let mut worst = 0.0f64;
    let mut flew = false;
    let start = start + 0.5 * 1e5 * (two[1].mass() * G / 1e5).powi(2);
    let scale = kinetic(&two[1..]);
    for _ in 0..280 {
        pair.advance(&mut two, &[Accelerations::default(), falling(0.0)], 1e-3).unwrap();
        worst = worst.max((energy(&pair, &two) - start).abs() / scale);
        flew |= two[1].centre.x > 0.08 && !pair.outcome().bodies[1].touched;
    }
    println!("energy changed by {worst:.1e} of {scale:.1e} J, {:?}", two[1].centre);
    assert!(flew && two[1].centre.y < 0.06 && worst < 1e-3, "{worst:e} {:?}", two[1].centre);
}

/// A heap of mixed shapes in a box.
fn heap(dimension: usize) -> Vec<Body> {
    // Bodies that are round where they lie rock on and on.
    let mut shapes = solids::all(dimension);
    shapes.retain(|(name, _)| !name.starts_with("ellips"));
    let mut dice = Dice(5);
    let flat = dimension == 2;
    let one = |k: usize| {
        let z = if flat { 0.0 } else { 0.025 * (1.0 + (k / 4 % 2) as f64) };
        let centre = vector![0.025 * (1.0 + (k % 2) as f64), 0.025 * (1.0 + (k / 2) as f64), z];
        let turn = if flat { vector![0.0, 0.0, 1.0] } else { vector![0.3, 0.5, 0.7] };
        let mut body = free(&shapes[k % shapes.len()].1, centre, 3.0 * dice.about_zero() * turn);
        body.velocity = 0.1 * vector![dice.about_zero(), dice.about_zero(), 0.0];
        body.id = k;
        body
    };
    (0..10).map(one).collect()
}

#[test]
fn pile_of_convex_bodies_comes_to_rest() {
    for dimension in [2, 3] {
        let mut bodies = heap(dimension);
        let size = if dimension == 2 { [0.075, 0.2, 0.0] } else { [0.075, 0.2, 0.075] };
        let law = stiff(if dimension == 2 { 1e6 } else { 1.5e4 }, 0.3, 0.5);
        let mut all = contacts(&bodies, law, size, &[0, 1, 2][..dimension], Substeps::Auto);
        let pull = vec![falling(0.0); bodies.len()];
        let scale: f64 = bodies.iter().map(|b| b.mass() * G * b.radius()).sum();
        let room = |c: &Contacts| c.pairs.capacity();
        let mut taken = 0;
        let before = room(&all);
        for _ in 0..700 {
            taken += all.advance(&mut bodies, &pull, 1e-3).unwrap();
        }
        assert_eq!(room(&all), before, "a step of parts allocates nothing");
        let left = kinetic(&bodies) / scale;
        // Bodies round where they lie, superquadrics and clumps in 3D, rock on for a while.
        let flat = |b: &&Body| matches!(b.parts()[0].core, Core::Polytope(_));
        let faces: Vec<Body> = bodies.iter().filter(flat).cloned().collect();
        let still = kinetic(&faces) / scale;
        println!(
            "{dimension}D: {left:.1e} of m g r left, {still:.1e} with faces, {taken} substeps"
        );
        assert!(left < 5e-3 && still < 1e-9, "{dimension}D: {left:e} {still:e}");
        assert!(bodies.iter().all(|b| b.centre.y > 0.0 && b.centre.y < 0.15));
    }
}

#[test]
fn heap_of_parts_restarts_bit_for_bit() {
    for dimension in [2, 3] {
        let mut bodies = heap(dimension);
        let size = if dimension == 2 { [0.075, 0.2, 0.0] } else { [0.075, 0.2, 0.075] };
        let law = stiff(if dimension == 2 { 1e6 } else { 1.5e4 }, 0.3, 0.5);
        let begin =
            |bodies: &[Body]| contacts(bodies, law, size, &[0, 1, 2][..dimension], Substeps::Auto);
        let pull = vec![falling(0.0); bodies.len()];
        let mut all = begin(&bodies);
        for _ in 0..300 {
            all.advance(&mut bodies, &pull, 1e-3).unwrap();
        }
        let later = |(_, _, springs): &(usize, usize, Springs)| springs.parts != [0; 2];
        let count = all.touching.springs.iter().filter(|s| later(s)).count();
        println!("{dimension}D: {} springs, {count} of later parts", all.touching.springs.len());
        assert!(count > 0);
        let mut again = bodies.clone();
        let mut rest = begin(&again);
        rest.touching = all.touching.clone();
        for _ in 0..30 {
            all.advance(&mut bodies, &pull, 1e-3).unwrap();
            rest.advance(&mut again, &pull, 1e-3).unwrap();
        }
        for (one, other) in bodies.iter().zip(&again) {
            assert_eq!(one.centre, other.centre);
            assert_eq!(one.orientation, other.orientation);
            assert_eq!([one.velocity, one.spin], [other.velocity, other.spin]);
        }
        assert_eq!(all.touching, rest.touching);
    }
}

/// Two boxes that approach in a viscous fluid, without touching, keep momentum and angular
/// momentum, and lose energy.
#[test]
fn lubrication_of_parts_conserves_momentum() {
    let shapes =
        [solids::cuboid([0.01, 0.008, 0.006], 4e-4), solids::ellipsoid([0.01, 0.008, 0.006], 4e-4)];
    let mut two = [
        free(&shapes[0], vector![0.08, 0.1, 0.1], vector![0.2, -0.1, 0.3]),
        free(&shapes[1], vector![0.1003, 0.102, 0.101], vector![0.1, 0.5, 0.2]),
    ];
    two[0].velocity.x = 0.05;
    two[1].spin.z = 2.0;
    let mut pair = contacts(&two, stiff(1e6, 0.5, 0.3), [0.2; 3], &[0, 1, 2], Substeps::Auto);
    pair.law =
        pair.law.within(Medium { density: 1e-9, viscosity: 0.5, spacing: 1e-3, roughness: 1e-6 });
    let still = [Accelerations::default(); 2];
    pair.advance(&mut two, &still, 1e-5).unwrap();
    let start = momenta(&two);
    let energy = kinetic(&two);
    for _ in 0..40 {
        pair.advance(&mut two, &still, 5e-4).unwrap();
    }
    let end = momenta(&two);
    let left = kinetic(&two) / energy;
    println!("keeps {left:.4} of its energy, {:?}", pair.outcome().bodies);
    assert!((end[0] - start[0]).norm() < 1e-12 * start[0].norm());
    assert!((end[1] - start[1]).norm() < 1e-4 * start[0].norm() * 0.01);
    assert!(left < 0.95, "{left}");
}

/// The meeting of two boxes at the end of a substep follows from that in its middle, to second
/// order.
#[test]
fn meeting_at_end_of_substep_follows_from_its_middle() {
    let shape = solids::cuboid([0.01, 0.008, 0.006], 4e-4);
    let mut two = [
        free(&shape, vector![0.03, 0.03, 0.03], vector![0.3, 0.2, 0.1]),
        free(&shape, vector![0.0303, 0.0497, 0.0295], vector![0.1, 0.4, 0.7]),
    ];
    two[0].velocity = vector![0.1, 0.5, 0.2];
    two[0].spin = vector![3.0, -8.0, 5.0];
    two[1].spin = vector![-6.0, 2.0, 9.0];
    let law = stiff(1e5, 1.0, 0.0);
    let off = |h: f64| {
        let mut held = contacts(&two, law, [0.1; 3], &[0, 1, 2], Substeps::Auto).law;
        held.meet(&two);
        let Contacts { setup, pairs, states, .. } = &mut held;
        pairs.search(setup, states, &two, 0.01, false);
        states.iter_mut().zip(&two).for_each(|(state, body)| state.turn_to_middle(body, h));
        let pair = held.pairs.list[0];
        let middle = held.layout(&two).closest(&pair, h);
        let mut moved = two.clone();
        for body in &mut moved {
            body.centre += h * body.velocity;
            body.turn_freely(h);
        }
        let exact = held.layout(&moved).closest(&pair, 0.0);
        let met = Met { meeting: middle, age: 0.5 * h, gone: 0.0 };
        let found = held.layout(&moved).at_end(&pair, &met);
        let apart = |to: &[Vector3<f64>; 2]| to[0] - to[1];
        assert!((apart(&found.arms.to) - apart(&exact.arms.to)).norm() < 1e-15);
        (found.overlap - exact.overlap).abs()
    };
    let [one, half] = [1e-4, 5e-5].map(off);
    println!("off by {one:.1e} and {half:.1e} m");
    assert!(one < 1e-7 && (3.0..5.0).contains(&(one / half)), "{one:e} {half:e}");
}

/// The gap of an ellipsoid is carried on over many substeps, that of a sphere found in each.
#[test]
fn film_slows_ellipsoid_of_equal_axes_as_a_sphere() {
    let shape = solids::ellipsoid([0.01; 3], 4e-4);
    let sphere = body(Shape::Sphere, 0.01, Vector3::zeros(), Vector3::zeros());
    let medium = Medium { density: 1000.0, viscosity: 1.0, spacing: 2e-3, ..Medium::default() };
    let slowed = |mut body: Body| {
        body.centre = vector![0.03, 0.0102, 0.03];
        body.velocity = vector![0.05, -0.1, 0.0];
        let mut one = [body];
        let law = stiff(1e5, 1.0, 0.0);
        let wall = contacts(&one, law, [0.1; 3], &[1], Substeps::Fixed(2000)).law;
        let mut wall = Touched::new(wall.within(medium));
        wall.advance(&mut one, &[Accelerations::default()], 1e-3).unwrap();
        one[0].mass() * (one[0].velocity.y + 0.1)
    };
    let [own, exact] = [free(&shape, Vector3::zeros(), Vector3::zeros()), sphere].map(slowed);
    println!("{own:e} of {exact:e} N s");
    assert!(exact > 1e-6 && (own / exact - 1.0).abs() < 1e-6, "{own} {exact}");
}

#[test]
fn overlap_beyond_the_skins_names_them() {
    let shape = solids::cuboid([0.01, 0.008, 0.006], 4e-4);
    let at = |y: f64| free(&shape, vector![0.05, y, 0.05], Vector3::zeros());
    let mut two = [at(0.03), at(0.046 - 7.5e-4)];
    let mut law = contacts(&two, stiff(1e5, 1.0, 0.0), [0.1; 3], &[1], Substeps::Auto);
    let error = law.advance(&mut two, &[Accelerations::default(); 2], 1e-4).unwrap_err();
    let error = error.to_string();
    assert!(error.contains("7.200e-4 m is the limit") && error.contains("`rounding`"), "{error}");
}
