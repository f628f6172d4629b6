//! The fluid in the gaps between bodies.

use super::*;

/// Impulses by the fluid in the gap of two bodies over a hundredth of a millisecond.
fn film_impulses(bodies: &mut [Body], axes: &[usize]) -> Vec<Impulse> {
    let medium = Medium { density: 1000.0, viscosity: 0.1, spacing: 2e-3, ..Medium::default() };
    let fixed = contacts(bodies, material(1.0, 0.9, 0.0), [1e3; 3], axes, Substeps::Auto).law;
    let mut contacts = Touched::new(fixed.within(medium));
    contacts.advance(bodies, &vec![Accelerations::default(); bodies.len()], 1e-5).unwrap();
    (0..bodies.len()).map(|k| contacts.outcome().impulse(k)).collect()
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
    // A disc gives to one side and gets from the other: together they keep their momentum.
    let momentum: Vector3<f64> = row.iter().map(|disc| disc.velocity / count as f64).sum();
    assert!((momentum - vector![0.1, 0.3, 0.0]).norm() < 1e-12, "{momentum}");
    assert!(row.iter().all(|disc| (disc.velocity - momentum).norm() < 0.01), "{row:?}");
    row.iter().map(|disc| disc.spin.z).collect()
}

#[test]
fn lubrication_of_spinning_disc_beside_own_periodic_image() {
    for gap in [1e-4, 1e-3] {
        // With a boundary of the period within a disc, and in a gap.
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
fn lubrication_torque_at_symmetry_plane() {
    for (shape, spin) in
        [(Shape::Disc, vector![0.0, 0.0, 3.0]), (Shape::Sphere, vector![2.0, -1.0, 3.0])]
    {
        let radius = 5e-3;
        let gap = 1e-4;
        let y = 500.0;
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
        mirror.setup.walls[0].at = y;
        mirror.setup.walls[0].side = WallSide::Slip;
        let mut pair = Touched::new(pair.within(medium));
        let mut mirror = Touched::new(mirror.within(medium));
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
fn disc_rests_on_two_periodic_images_of_another() {
    let radius = 0.01;
    let length = 0.03;
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
            (contacts.outcome().impulse(1).linear.y / weight - 1.0).abs() < 1e-3,
            "{:?}",
            contacts.outcome()
        );
        // With the springs kept per image it goes on as it was.
        let mut again = two.clone();
        let still = two[1].velocity;
        let mut restarted = Touched::new(contacts.law.clone());
        restarted.touching.springs = memory;
        assert!(restarted.setup().check(&restarted.touching).is_ok());
        contacts.advance(&mut two, &accelerations, 1e-3).unwrap();
        restarted.advance(&mut again, &accelerations, 1e-3).unwrap();
        assert_eq!((two[1].centre, two[1].spin), (again[1].centre, again[1].spin));
        assert!((two[1].velocity - still).norm() < 1e-6);
    }
}

/// Far pairs do not act in every substep that others need: they give what they would alone.
#[test]
fn lubrication_of_pair_independent_of_other_substeps() {
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
        (taken, contacts.outcome().impulse(0).linear.x)
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
fn lubrication_conserves_momentum_and_ignores_rigid_motion() {
    for (shape, spin) in
        [(Shape::Disc, vector![0.0, 0.0, 3.0]), (Shape::Sphere, vector![2.0, -1.0, 3.0])]
    {
        let flat =
            |v: Vector3<f64>| if matches!(shape, Shape::Disc) { vector![v.x, v.y, 0.0] } else { v };
        let mut bodies = beside_each_other(shape, [5e-3, 1.2e-2]);
        let arm = bodies[0].centre - bodies[1].centre;
        bodies[0].velocity = flat(vector![0.02, -0.01, 0.03]);
        bodies[0].spin = spin;
        bodies[1].spin = -0.5 * spin;
        let [first, second] = [0, 1].map(|k| film_impulses(&mut bodies.clone(), &[])[k]);
        let size = first.linear.norm();
        let lever = first.linear.norm() * arm.norm();
        assert!(size > 1e-9 && first.angular.norm() > 1e-3 * lever, "{first:?}");
        assert!((first.linear + second.linear).norm() < 1e-12 * size);
        let turning = first.angular + second.angular + arm.cross(&first.linear);
        assert!(turning.norm() < 1e-4 * lever, "{turning} of {lever}");

        // As one: carried along and turned about any point.
        let drift = flat(vector![0.3, 0.2, -0.1]);
        for (body, rest) in bodies.iter_mut().zip([Vector3::zeros(), spin.cross(&arm)]) {
            body.velocity = drift - rest;
            body.spin = spin;
        }
        let still = film_impulses(&mut bodies, &[]);
        assert!(
            still.iter().all(|i| i.linear.norm() < 1e-3 * size && i.angular.norm() < 1e-3 * lever),
            "{still:?}"
        );
    }
}

/// A body that is put down to touch a wall, and its image at the other side of the box, which
/// rounds differently, have the same lubrication layer: it is ten times that of the narrowest gap
/// otherwise.
#[test]
fn gap_within_rounding_is_contact() {
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
fn lubrication_of_very_large_body_equals_wall() {
    for (shape, spin) in
        [(Shape::Disc, vector![0.0, 0.0, 3.0]), (Shape::Sphere, vector![2.0, -1.0, 3.0])]
    {
        // The pair acts in the middle of the gap, the wall at its own side: a narrow one.
        let radius = 5e-3;
        let gap = 5e-6;
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
