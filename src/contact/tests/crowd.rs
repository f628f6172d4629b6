//! Tests of many contacts at once.

use super::*;
use crate::particles::Neighbours;

/// Numbers in [0, 1), the same every time.
pub struct Dice(pub u64);

impl Dice {
    pub fn roll(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn about_zero(&mut self) -> f64 {
        2.0 * self.roll() - 1.0
    }
}

/// Discs on a lattice of `across` columns, of radii 3 to 4 mm, 1 cm apart, thrown about at up to
/// `speed` (m/s).
fn cloud(n: usize, across: usize, speed: f64) -> Vec<Body> {
    let mut dice = Dice(7);
    let disc = |i: usize| {
        let centre = vector![(i % across) as f64 + 0.5, (i / across) as f64 + 0.5, 0.0] * 0.01;
        let velocity = vector![dice.about_zero(), dice.about_zero(), 0.0] * speed;
        let mut disc = body(Shape::Disc, 0.003 + 0.001 * dice.roll(), centre, velocity);
        disc.spin.z = 100.0 * speed * dice.about_zero();
        disc
    };
    (0..n).map(disc).collect()
}

fn kinetic(bodies: &[Body]) -> f64 {
    let of = |b: &Body| {
        0.5 * (b.mass() * b.velocity.norm_squared() + b.inertia().about(2) * b.spin.norm_squared())
    };
    bodies.iter().map(of).sum()
}

/// Energy in the springs (J), after substeps of `h` (s): the tangential ones are half a substep
/// behind.
fn elastic(contacts: &Contacts, bodies: &[Body], h: f64) -> f64 {
    let layout = contacts.layout(bodies);
    let of = |pair: &Pair| {
        let law = layout.law(pair);
        let kinematics = layout.kinematics(pair, 0.0).0;
        let tangential = law.material.tangential_ratio
            * law.material.normal_stiffness
            * kinematics.overlap.max(0.0).powf(law.material.exponent - 1.0);
        law.stored(kinematics.overlap)
            + 0.5
                * tangential
                * pair
                    .springs
                    .tangential
                    .map_or(0.0, |s| (s + 0.5 * h * kinematics.slip).norm_squared())
    };
    contacts.pairs.list.iter().map(of).sum()
}

/// The largest gain of energy in a step of a cloud in a box, and the energy left, of that at the
/// start.
fn gain(law: Material, dt: f64) -> (f64, f64) {
    let mut bodies = cloud(50, 10, 1.0);
    let mut contacts = contacts(&bodies, law, [0.1, 0.05, 0.0], &[0, 1], Substeps::Auto);
    let still = vec![Accelerations::default(); bodies.len()];
    let start = kinetic(&bodies);
    let mut last = start;
    let mut worst = f64::NEG_INFINITY;
    let mut substeps = 0;
    for _ in 0..(0.2 / dt) as usize {
        let taken = contacts.advance(&mut bodies, &still, dt).unwrap();
        let energy = kinetic(&bodies) + elastic(&contacts, &bodies, dt / taken.max(1) as f64);
        worst = f64::max(worst, (energy - last) / start);
        last = energy;
        substeps += taken;
    }
    let g = law.exponent;
    let damping = law.damping;
    let left = last / start;
    println!(
        "cloud, exponent {g}, {damping:?}: gains {worst:.1e} in a step, {left:.4} left, {substeps} \
        substeps"
    );
    (worst, left)
}

#[test]
fn colliding_cloud_never_gains_energy() {
    // Steps of a substep or two show Verlet's own fluctuation within a contact; Hertz's spring also
    // stiffens.
    for (exponent, dt, limit) in
        [(1.0, 2e-4, 1e-6), (1.0, 2e-5, 2e-6), (1.5, 2e-4, 2e-5), (1.5, 2e-5, 2e-5)]
    {
        let (worst, left) = gain(material(exponent, 0.9, 0.3), dt);
        assert!(worst < limit && left < 0.1, "{exponent} {dt}: {worst:e} {left}");
    }
}

#[test]
fn elastic_cloud_conserves_energy() {
    for exponent in [1.0, 1.5] {
        let (worst, left) = gain(material(exponent, 1.0, 0.0), 2e-4);
        assert!(worst < 5e-4 && (left - 1.0).abs() < 2e-3, "{exponent}: {worst:e} {left}");
    }
}

#[test]
fn periodic_cloud_conserves_momentum() {
    let mut bodies = cloud(50, 10, 1.0);
    let mut contacts =
        contacts(&bodies, material(1.0, 0.7, 0.3), [0.1, 0.05, 0.0], &[], Substeps::Auto);
    let still = vec![Accelerations::default(); bodies.len()];
    let momentum =
        |bodies: &[Body]| bodies.iter().map(|b| b.mass() * b.velocity).sum::<Vector3<f64>>();
    let scale: f64 = bodies.iter().map(|b| b.mass() * b.velocity.norm()).sum();
    let start = momentum(&bodies);
    let energy = kinetic(&bodies);
    for _ in 0..300 {
        contacts.advance(&mut bodies, &still, 1e-3).unwrap();
    }
    let change = (momentum(&bodies) - start).norm() / scale;
    println!("momentum changed by {change:.1e}");
    assert!(change < 1e-12 && kinetic(&bodies) < 0.5 * energy);
}

#[test]
fn sphere_pair_conserves_momentum_and_angular_momentum() {
    let mut two = [
        body(Shape::Sphere, 0.01, vector![0.05, 0.1, 0.1], vector![0.5, 0.1, 0.0]),
        body(Shape::Sphere, 0.007, vector![0.0675, 0.106, 0.102], vector![-0.5, 0.0, 0.3]),
    ];
    two[0].spin = vector![10.0, -20.0, 5.0];
    let whole = |two: &[Body]| {
        let linear: Vector3<f64> = two.iter().map(|b| b.mass() * b.velocity).sum();
        let angular: Vector3<f64> = two
            .iter()
            .map(|b| b.mass() * b.centre.cross(&b.velocity) + b.inertia().of(&b.spin))
            .sum();
        (linear, angular, kinetic(two))
    };
    let before = whole(&two);
    let mut pair = contacts(&two, material(1.0, 0.9, 0.3), [0.2; 3], &[0, 1, 2], Substeps::Auto);
    pair.advance(&mut two, &[Accelerations::default(); 2], 5e-3).unwrap();
    let after = whole(&two);
    assert!(pair.outcome().impulse(0).linear.norm() > 1e-4);
    assert!((after.0 - before.0).norm() < 1e-15 && after.2 < before.2);
    // The friction acts along the line of the middle of a substep, the bodies move to its end.
    assert!(
        (after.1 - before.1).norm() < 1e-6 * before.1.norm(),
        "{:e}",
        (after.1 - before.1).norm() / before.1.norm()
    );
}

#[test]
fn heap_of_particles_comes_to_rest() {
    let mut bodies = cloud(50, 10, 0.3);
    let mut contacts =
        contacts(&bodies, material(1.0, 0.5, 0.5), [0.1, 0.1, 0.0], &[0, 1], Substeps::Auto);
    // Nothing stops a disc that rolls on level ground: it leans a little.
    let down = vec![accelerations(-1.0, -9.81); bodies.len()];
    let fall: f64 = bodies.iter().map(|b| b.mass() * 9.81 * 0.01).sum();
    for _ in 0..1500 {
        contacts.advance(&mut bodies, &down, 1e-3).unwrap();
    }
    let rest = kinetic(&bodies) / fall;
    let places = bodies.clone();
    for _ in 0..200 {
        contacts.advance(&mut bodies, &down, 1e-3).unwrap();
    }
    let crept =
        bodies.iter().zip(&places).map(|(a, b)| (a.centre - b.centre).norm()).fold(0.0, f64::max);
    let deepest = contacts
        .pairs
        .list
        .iter()
        .map(|p| contacts.layout(&bodies).kinematics(p, 0.0).0.overlap)
        .fold(0.0, f64::max);
    println!(
        "heap: kinetic energy {rest:.1e} of a fall by 1 cm, crept {crept:.1e} m in 0.2 s, deepest \
        {deepest:.1e} m"
    );
    assert!(rest < 1e-8 && crept < 1e-6, "{rest:e} {crept:e}");
    // The walls took the weight.
    let weight: f64 = bodies.iter().map(|b| b.mass() * 9.81 * 1e-3).sum();
    assert!(
        (contacts.outcome().wall_impulse.y / -weight - 1.0).abs() < 1e-3,
        "{}",
        contacts.outcome().wall_impulse.y / -weight
    );
}

/// The pairs of bodies within their search radii, of all images up to two periods away.
fn brute_force(
    bodies: &[Body],
    search_radius: &[f64],
    size: [f64; 3],
    periodic: [bool; 3],
) -> Vec<(usize, usize, Vector3<i32>)> {
    let mut all = vec![];
    let mut images = vec![];
    for a in 0..3 {
        images.push(if periodic[a] { -2..=2 } else { 0..=0 });
    }
    for i in 0..bodies.len() {
        for j in i..bodies.len() {
            let within =
                bodies[i].radius() + bodies[j].radius() + search_radius[i] + search_radius[j];
            for (x, y, z) in images[0].clone().flat_map(|x| {
                let zs = images[2].clone();
                images[1].clone().flat_map(move |y| zs.clone().map(move |z| (x, y, z)))
            }) {
                let way = vector![x as f64 * size[0], y as f64 * size[1], z as f64 * size[2]];
                let apart = bodies[j].centre - bodies[i].centre + way;
                if (i < j || (x, y, z) > (0, 0, 0)) && apart.norm() <= within {
                    all.push((i, j, vector![x, y, z]));
                }
            }
        }
    }
    all
}

#[test]
fn cell_lists_match_brute_force_pairs() {
    let mut dice = Dice(3);
    let mut several = false;
    let mut own = false;
    for (size, periodic) in [
        ([1.0, 1.0, 1.0], [false; 3]),
        ([1.0, 1.0, 1.0], [true; 3]),
        ([0.13, 1.0, 0.1], [true, false, true]),
        ([0.21, 0.32, 0.5], [true; 3]),
        ([0.11, 0.05, 2.0], [true, false, true]),
        ([3.0, 0.2, 0.0], [true, true, false]),
        ([2.0, 0.041, 0.0], [true, true, false]),
        ([0.05, 0.041, 2.0], [true, true, false]),
    ] {
        let periods: [Option<f64>; 3] = std::array::from_fn(|a| periodic[a].then_some(size[a]));
        let shape = if size[2] == 0.0 { Shape::Disc } else { Shape::Sphere };
        let ball = |_| {
            let centre =
                vector![dice.roll() * size[0], dice.roll() * size[1], dice.roll() * size[2]];
            body(shape, 0.01 + 0.01 * dice.roll(), centre, Vector3::zeros())
        };
        let bodies: Vec<Body> = (0..300).map(ball).collect();
        let search_radius: Vec<f64> = bodies.iter().map(|_| 0.01 * dice.roll()).collect();
        let farthest =
            bodies.iter().zip(&search_radius).map(|(b, r)| b.radius() + r).fold(0.0, f64::max);
        let mut cells = Neighbours::new(&bodies, size, periods);
        cells.sort(&bodies, 2.0 * farthest);
        let mut found = vec![];
        for i in 0..bodies.len() {
            cells.around(i, &bodies, &search_radius, |j, image| {
                found.push((i, j, image.map(|n| n as i32)))
            });
        }
        let order =
            |pair: &(usize, usize, Vector3<i32>)| (pair.0, pair.1, pair.2.x, pair.2.y, pair.2.z);
        found.sort_unstable_by_key(order);
        let mut all = brute_force(&bodies, &search_radius, size, periodic);
        all.sort_unstable_by_key(order);
        assert_eq!(found, all, "{size:?}");
        assert!(all.len() > 8);
        several |= all.windows(2).any(|two| (two[0].0, two[0].1) == (two[1].0, two[1].1));
        own |= all.iter().any(|pair| pair.0 == pair.1);
    }
    assert!(several && own, "some meet on both sides of a period, and some their own images");
}

#[test]
fn neighbour_search_cost_is_linear() {
    let checks = [100usize, 1000, 3000].map(|n| {
        let across = (n as f64).sqrt() as usize;
        let size = [0.01 * across as f64, 0.01 * n.div_ceil(across) as f64, 0.0];
        let bodies = cloud(n, across, 1.0);
        let mut contacts =
            contacts(&bodies, material(1.0, 0.9, 0.3), size, &[0, 1], Substeps::Auto);
        let Contacts { setup, pairs, states, .. } = &mut contacts.law;
        pairs.search(setup, states, &bodies, 1e-4, false);
        pairs.neighbours.checks as f64 / n as f64
    });
    println!("distances per particle for 100, 1000, 3000: {checks:.2?}");
    assert!(checks.iter().all(|&c| c < 8.0) && checks[2] < 1.3 * checks[0], "{checks:?}");
}

#[test]
fn impact_chain_propagates_within_one_step() {
    // Far beyond the search_radius of a body at rest: the pairs have to be found anew on the way.
    let place = |x: f64, speed: f64| {
        body(Shape::Disc, 0.01, vector![x, 0.05, 0.0], vector![speed, 0.0, 0.0])
    };
    let mut bodies = [place(0.02, 1.0), place(0.05, 0.0), place(0.1, 0.0), place(0.15, 0.0)];
    let mut contacts =
        contacts(&bodies, material(1.0, 1.0, 0.3), [0.3, 0.1, 0.0], &[0, 1], Substeps::Auto);
    contacts.advance(&mut bodies, &[Accelerations::default(); 4], 0.15).unwrap();
    let speeds = [0, 1, 2, 3].map(|i| bodies[i].velocity.x);
    assert!(
        speeds[..3].iter().all(|v| v.abs() < 0.01) && (speeds[3] - 1.0).abs() < 0.01,
        "{speeds:?}"
    );
    // 0.01 + 0.03 + 0.03 m until the third strikes the last; contacts last 9 ms in all
    assert!(bodies[3].centre.x > 0.22 && bodies[3].centre.x < 0.24, "{}", bodies[3].centre.x);
}

#[test]
fn contact_steps_do_not_allocate() {
    let mut bodies = cloud(50, 10, 1.0);
    let mut contacts =
        contacts(&bodies, material(1.0, 1.0, 0.3), [0.1, 0.05, 0.0], &[0, 1], Substeps::Auto);
    let still = vec![Accelerations::default(); bodies.len()];
    let room = |c: &Contacts| c.pairs.capacity();
    let before = room(&contacts);
    for _ in 0..100 {
        contacts.advance(&mut bodies, &still, 1e-3).unwrap();
    }
    assert_eq!(room(&contacts), before);
}

/// Bodies closely side by side in a fluid, between walls and across a period: films among all.
fn packed(shape: Shape, layers: usize) -> (Vec<Body>, Touched) {
    let mut dice = Dice(3);
    let mut bodies = Vec::new();
    for k in 0..36 * layers {
        let mut place = || 0.5 + 0.02 * dice.about_zero();
        let at = [k % 6, k / 6 % 6, k / 36];
        let mut centre = vector![at[0] as f64 + place(), at[1] as f64 + place(), 0.0] * 0.01;
        centre.z = if layers > 1 { (at[2] as f64 + place()) * 0.01 } else { 0.0 };
        let speed = 0.3;
        let velocity = vector![dice.about_zero(), dice.about_zero(), 0.0] * speed;
        bodies.push(body(shape, 0.00485, centre, velocity));
    }
    let depth = if layers > 1 { 0.01 * layers as f64 } else { 0.0 };
    let axes = if layers > 1 { &[1, 2][..] } else { &[1] };
    let mut contacts =
        contacts(&bodies, material(1.0, 0.7, 0.3), [0.06, 0.06, depth], axes, Substeps::Auto);
    let medium = Medium { density: 1000.0, viscosity: 1.0, spacing: 0.001, roughness: 0.0 };
    contacts.law = contacts.law.within(medium);
    (bodies, contacts)
}

#[test]
fn cells_of_a_colour_act_in_any_order() {
    for (shape, layers) in [(Shape::Disc, 1), (Shape::Sphere, 4)] {
        let run = |backwards: bool| {
            let (mut bodies, mut contacts) = packed(shape, layers);
            contacts.law.pairs.colours.backwards = backwards;
            let still = vec![Accelerations::default(); bodies.len()];
            for _ in 0..20 {
                contacts.advance(&mut bodies, &still, 2e-4).unwrap();
            }
            let residuals: Vec<_> = bodies
                .iter()
                .map(|b| RigidVelocity { velocity: -0.1 * b.velocity, spin: b.spin })
                .collect();
            let mut corrections = vec![Impulse::default(); bodies.len()];
            contacts.law.impulses().correct(&bodies, &residuals, &mut corrections, 2e-4);
            (bodies, corrections, contacts.law.pairs.colours.order().to_vec())
        };
        let (bodies, corrections, order) = run(false);
        let (others, theirs, another) = run(true);
        assert!(order.len() > 2 * bodies.len() && order != another);
        assert!(corrections.iter().any(|given| given.linear.norm() > 0.0));
        for (body, other) in bodies.iter().zip(&others) {
            assert_eq!(
                [body.centre, body.velocity, body.spin],
                [other.centre, other.velocity, other.spin]
            );
        }
        assert_eq!(corrections, theirs);
    }
}
