//! Friction, rolling and torques on a body, through the whole step and against theory.

use crate::support::{SHARP, box_case, petsc};
use mics::particles::Body;
use mics::scene::Scene;

/// Normal stiffness of contacts with the floor (N/m).
const STIFFNESS: f64 = 2e4;

/// A disc (2D) or sphere of diameter 1 and density 1 that rests on a floor, in a gas of a
/// thousandth of that: the floor's friction, gravity (m/s2) and velocity (m/s).
pub fn on_a_floor<const D: usize>(
    wall: &str,
    friction: f64,
    gravity: [f64; 2],
    speed: f64,
) -> String {
    let (size, cells, shape) = if D == 2 {
        ("[4.0, 2.0]", "[32, 16]", "disc")
    } else {
        ("[4.0, 2.0, 1.5]", "[32, 16, 12]", "sphere")
    };
    let (third, along_z) =
        if D == 2 { ("", "") } else { (", 0.0", "bottom = \"periodic\"\ntop = \"periodic\"\n") };
    let z = if D == 2 { "" } else { ", 0.75" };
    format!(
        "name = \"floor\"\n[domain]\nsize = {size}\ncells = {cells}\n[fluid]\ndensity = 1e-3\n\
        viscosity = 1e-4\n\
         gravity = [{:?}, {:?}{third}]\n[boundary]\nwest = \"periodic\"\neast = \"periodic\"\n\
             south = \"wall\"\nnorth = \"slip\"\n\
         {along_z}[[particle]]\nshape = {{ {shape} = {{ diameter = 1.0 }} }}\ndensity = 1.0\n\
         position = [1.0, 0.5{z}]\n\
         velocity = [{speed:?}, 0.0{third}]\n[contact]\nnormal_stiffness = {STIFFNESS:?}\n\
         friction = {friction:?}\nrestitution = 0.2\n\
         {wall}[time]\nend = 1.0\n[pressure]\ndivergence_limit = 1e-5",
        gravity[0], gravity[1]
    )
}

/// The body after each step of `dt` (s).
fn followed<const D: usize>(text: &str, steps: usize, dt: f64) -> Vec<Body> {
    let petsc = petsc();
    let mut scene: Scene<D> = petsc.scene(text);
    let step = |_| {
        scene.step(dt).unwrap();
        scene.state.bodies[0].clone()
    };
    (0..steps).map(step).collect()
}

/// A body of `inertia` I/(m r^2) that is set down sliding: Coulomb's friction slows it by `mu g`
/// until it rolls, from `t = v0/(mu g (1 + m r^2/I))` on, with `v0/(1 + I/(m r^2))`.
fn expect_to_slide_and_roll<const D: usize>(wall: &str, inertia: f64) {
    let (friction, g, speed, dt) = (0.25, 4.0, 1.0, 4e-3);
    let slips = speed / (friction * g * (1.0 + 1.0 / inertia));
    let rolls = speed / (1.0 + inertia);
    let steps = (1.5 * slips / dt) as usize;
    let path = followed::<D>(&on_a_floor::<D>(wall, friction, [0.0, -g], speed), steps, dt);
    let at = |time: f64| &path[(time / dt).round() as usize - 1];
    // From after the first jolt to before it sticks.
    let (early, late) = (at(0.3 * slips), at(0.85 * slips));
    let apart = 0.55 * slips;
    let slowing = (early.velocity.x - late.velocity.x) / apart;
    let turning = (early.spin.z - late.spin.z) / apart * early.radius() * inertia;
    let last = &path[steps - 1];
    let surface = last.velocity.x + last.radius() * last.spin.z;
    println!(
        "{D}D {}: slows by {:.4} mu g, turned by {:.4} mu g, rolls at {:.4} of {rolls:.4} m/s, \
        slips by {surface:.4} m/s",
        wall.trim().replace('\n', " "),
        slowing / (friction * g),
        turning / (friction * g),
        last.velocity.x
    );
    assert!((slowing / (friction * g) - 1.0).abs() < 0.03, "{wall}: it slows by {slowing} m/s2");
    assert!(
        (turning / (friction * g) - 1.0).abs() < 0.03,
        "{wall}: friction turns it by {turning} m/s2"
    );
    assert!(
        (last.velocity.x / rolls - 1.0).abs() < 0.02,
        "{wall}: it rolls at {} m/s",
        last.velocity.x
    );
    assert!(surface.abs() < 0.03 * rolls, "{wall}: its surface slips by {surface} m/s");
}

#[test]
fn sliding_disc_rolls_at_two_thirds_of_its_speed() {
    expect_to_slide_and_roll::<2>(SHARP, 0.5);
}

#[test]
fn sliding_sphere_rolls_at_five_sevenths_of_its_speed() {
    expect_to_slide_and_roll::<3>(SHARP, 0.4);
}

/// Down a slope whose friction holds it, a body rolls with `g sin(slope)/(1 + I/(m r^2))`.
#[test]
fn rolling_acceleration_of_disc_and_sphere_down_a_slope() {
    fn rolling<const D: usize>(inertia: f64) {
        let (along, dt) = (1.0, 4e-3);
        let path = followed::<D>(&on_a_floor::<D>(SHARP, 0.5, [along, -4.0], 0.0), 100, dt);
        let (early, late) = (&path[39], &path[99]);
        let gained = (late.velocity.x - early.velocity.x) / (60.0 * dt) * (1.0 + inertia) / along;
        println!("{D}D: {gained:.4} of g sin(slope)/(1 + I/(m r^2))");
        assert!((gained - 1.0).abs() < 0.03, "{D}D: {gained}");
    }
    rolling::<2>(0.5);
    rolling::<3>(0.4);
}

/// A free sphere of the fluid's density between walls that slide past each other along `flow`,
/// across `across`.
fn in_shear(flow: usize, across: usize, spacing: f64, viscosity: f64) -> String {
    let cells: [usize; 3] = std::array::from_fn(|a| if a == flow { 5 } else { 4 })
        .map(|d: usize| (d as f64 / spacing) as usize);
    let size: [f64; 3] = std::array::from_fn(|a| cells[a] as f64 * spacing);
    let middle = size.map(|length| 0.5 * length);
    let side = |axis: usize, sign: f64| {
        let speed: [f64; 3] =
            std::array::from_fn(|a| if a == flow { sign * 0.5 * size[across] } else { 0.0 });
        if axis == across {
            format!("{{ moving_wall = {speed:?} }}")
        } else {
            "\"periodic\"".into()
        }
    };
    let names = [["west", "east"], ["south", "north"], ["bottom", "top"]];
    let sides: String = (0..3)
        .flat_map(|axis| {
            [0, 1].map(|high| {
                format!("{} = {}\n", names[axis][high], side(axis, 2.0 * high as f64 - 1.0))
            })
        })
        .collect();
    format!(
        "name = \"shear\"\n[domain]\nsize = {size:?}\ncells = {cells:?}\n[fluid]\ndensity = 1.0\n\
        viscosity = {viscosity:?}\n\
         [boundary]\n{sides}{SHARP}[[particle]]\nshape = {{ sphere = {{ diameter = 1.0 }} }}\n\
         position = {middle:?}\n\
         [time]\nend = 100.0\nscheme = \"rk3\"\n[pressure]\ndivergence_limit = 1e-7"
    )
}

/// Starts the scene with its shear, of rate 1/s, so that the sphere is turned at once.
fn shear(scene: &mut Scene<3>, flow: usize, across: usize) {
    for c in scene.domain.grid.rows().flatten() {
        scene.state.u[flow][c] =
            scene.domain.grid.centre(c)[across] - 0.5 * scene.domain.grid.size[across];
    }
    scene.start().unwrap();
}

/// A shear flow along any axes turns the sphere the same way, component by component.
#[test]
fn sphere_spin_in_shear_equal_about_every_axis() {
    let petsc = petsc();
    let spin = |flow: usize, across: usize| {
        let mut scene: Scene<3> = petsc.scene(&in_shear(flow, across, 0.25, 0.5));
        shear(&mut scene, flow, across);
        for _ in 0..40 {
            scene.step(5e-3).unwrap();
        }
        scene.state.bodies[0].spin
    };
    for (flow, across) in [(0, 1), (1, 2), (2, 0), (1, 0), (2, 1), (0, 2)] {
        let about = 3 - flow - across;
        // The curl of the flow: -1 where (flow, across, about) is in order.
        let sign = if across == (flow + 1) % 3 { -1.0 } else { 1.0 };
        let spin = spin(flow, across);
        println!("flow along {flow}, sheared across {across}: spin {spin:?}");
        for a in 0..3 {
            let expected = if a == about { sign * 0.485 } else { 0.0 };
            // The points of its surface lie on a spiral: a thousandth of the torque is about other
            // axes.
            let allowed = if a == about { 0.05 } else { 2e-3 };
            assert!((spin[a] - expected).abs() < allowed, "along {flow}, across {across}: {spin}");
        }
    }
    let first = spin(0, 1).z;
    for (flow, across) in [(1, 2), (2, 0)] {
        let same = spin(flow, across)[3 - flow - across];
        assert!((same / first - 1.0).abs() < 5e-3, "{same} and {first} rad/s");
    }
}

/// Midway between walls four diameters apart: of half the shear rate each wall takes `5/16 (a/h)^3`
/// (Goldman, Cox & Brenner 1967, Chem. Eng. Sci. 22, p. 653), which leaves 0.4951, and inertia up
/// to `0.31 Re^(3/2)`, Re = G a^2/nu (Saffman 1965, J. Fluid Mech. 22, p. 385, without walls),
/// which leaves 0.4927. The shear is there from the start, and the sphere takes its spin up within
/// `d^2/(15 nu)`.
#[test]
fn sphere_spin_rate_in_couette_flow() {
    let petsc = petsc();
    let known = 0.494;
    let mut scene: Scene<3> = petsc.scene(&in_shear(0, 1, 0.125, 4.0));
    shear(&mut scene, 0, 1);
    while scene.state.time < 0.25 {
        let dt = 0.9 * scene.limits().unwrap().tightest().1;
        scene.step(dt).unwrap();
    }
    let spin = scene.state.bodies[0].spin;
    println!(
        "spin {:.4} of the shear rate, known {known:.4}, after {} steps",
        -spin.z, scene.state.steps
    );
    assert!((-spin.z / known - 1.0).abs() < 0.01, "{spin} rad/s, {known}");
    assert!(spin.x.abs() < 1e-3 && spin.y.abs() < 1e-3, "{spin} rad/s");
}

/// Two discs side by side on a floor and a third on both, in gravity 1 m/s2: friction, and
/// resistance to rolling.
fn three_discs(friction: f64, rolling: f64) -> String {
    let disc = |place: [f64; 2]| {
        format!(
            "[[particle]]\nshape = {{ disc = {{ diameter = 1.0 }} }}\nposition = {place:?}\n\
            density = 1.0\n"
        )
    };
    let discs = [[2.5, 0.5], [3.5, 0.5], [3.0, 0.5 + 0.75_f64.sqrt()]].map(disc).concat();
    let contact = format!(
        "[contact]\nnormal_stiffness = {STIFFNESS:?}\nfriction = {friction:?}\n\
        rolling_friction = {rolling:?}\nrestitution = 0.2\n"
    );
    let more =
        format!("{discs}{contact}{SHARP}[time]\nend = 5.0\n[pressure]\ndivergence_limit = 1e-4");
    let sides = ["\"periodic\"", "\"periodic\"", "\"wall\"", "\"slip\""];
    // A gas of a thousandth of their density.
    box_case([6.0, 3.0], [48, 24], 1e-4, sides, &more).replacen(
        "density = 1.0",
        "density = 1e-3\ngravity = [0.0, -1.0]",
        1,
    )
}

/// The pile's statics. The upper disc (weight W) presses on each lower one with N, which slips
/// below it (friction f N) and rolls out on the floor, where it has 3 W/2 and the friction F:
///
/// ```text
///   W = 2 N (cos 30 + f sin 30)     F = N sin 30 - f N cos 30     F r - f N r + M = 0,
///              |M| <= mu_r (N r/2 + 3/2 W r)
///   stands with  mu_r >= N (sin 30 - f (1 + cos 30))/(N/2 + 3 W/2)
/// ```
#[test]
fn pile_of_three_discs_stands_by_static_rolling_friction() {
    let petsc = petsc();
    let (sine, cosine) = (0.5, 0.75_f64.sqrt());
    for friction in [0.15, 0.2] {
        let pressed = 0.5 / (cosine + friction * sine);
        let needed = pressed * (sine - friction * (1.0 + cosine)) / (0.5 * pressed + 1.5);
        let sunk = [0.9, 1.1].map(|part| {
            let mut scene: Scene<2> = petsc.scene(&three_discs(friction, part * needed));
            let upper = |scene: &Scene<2>| {
                let body = scene.state.bodies.iter().find(|body| body.id == 2).unwrap();
                (body.centre.y, body.velocity.y)
            };
            let (top, _) = upper(&scene);
            while scene.state.time < 5.0 {
                scene.step(0.05).unwrap();
            }
            let (end, velocity) = upper(&scene);
            (top - end, -velocity)
        });
        println!(
            "friction {friction}: needs {needed:.4}; sinks by {:.1e} d with 0.9 of that, by {:.1e} \
            d with 1.1",
            sunk[0].0, sunk[1].0
        );
        // The springs give by 4e-4.
        assert!(sunk[0].0 > 5e-3 && sunk[0].1 > 1e-3, "friction {friction}, too little: {sunk:?}");
        assert!(
            sunk[1].0 < 1e-3 && sunk[1].1.abs() < 1e-5,
            "friction {friction}, enough: {sunk:?}"
        );
    }
}

/// Friction that holds does no work, though every contact of the pile alone would let its discs
/// slip: each disc is held by several.
#[test]
fn friction_in_standing_pile_does_no_work() {
    let petsc = petsc();
    // On a slope too, where the floor's friction bears a part of the weight.
    for (rolling, along) in [(0.0, 0.0), (0.2, 0.0), (0.2, 0.05)] {
        let text = three_discs(0.4, rolling).replacen(
            "gravity = [0.0,",
            &format!("gravity = [{along:?},"),
            1,
        );
        let mut scene: Scene<2> = petsc.scene(&text);
        let mut taken = [4.0, 8.0].map(|until| {
            while scene.state.time < until {
                scene.step(0.05).unwrap();
            }
            scene.state.energy.losses.friction
        });
        taken[1] -= taken[0];
        println!(
            "rolling friction {rolling}: {:.1e} J in four seconds, then {:.1e} J",
            taken[0], taken[1]
        );
        // Their weights would give 2 J in a fall of a diameter. By what each contact alone would
        // let slip, 1e-4 J.
        assert!(taken[1].abs() < 1e-8, "{taken:?}");
    }
}

/// A disc and a sphere of a thousandth of the fluid's density that rest under a lid which resists
/// rolling do not begin to turn, in steps of any length. The torque that the contact force allows
/// turned a body of no inertia of its own over and back in each substep: 2 rad/s for ever, or the
/// run's end.
#[test]
fn massless_body_rests_with_rolling_friction() {
    fn spins<const D: usize>(friction: f64, dt: f64) -> f64 {
        let (shape, third) = if D == 2 { ("disc", "") } else { ("sphere", ", 0.0111") };
        let list = |item: &str| vec![item; D].join(", ");
        let sides = ["west", "east", "south", "north", "bottom", "top"];
        let walls: Vec<String> =
            sides[..2 * D].iter().map(|side| format!("{side} = \"wall\"")).collect();
        let text = format!(
            "name = \"lid\"\ndomain = {{ size = [{}], cells = [{}] }}\n\
             fluid = {{ density = 1000.0, viscosity = 6e-4, gravity = [0.0, -9.81{}] }}\n\
             boundary = {{ {} }}\n\
             [[particle]]\nshape.{shape}.diameter = 0.004444\ndensity = 1.0\n\
             position = [0.0121, 0.017778{third}]\n\
             [contact]\nfriction = 0.3\nrolling_friction = {friction:?}\n[time]\nend = 1.0\n\
             step = {dt:?}\n",
            list("0.02"),
            list("18"),
            if D == 2 { "" } else { ", 0.0" },
            walls.join(", ")
        );
        let bodies = followed::<D>(&text, 12, dt);
        bodies.iter().map(|body| body.spin.norm()).fold(0.0, f64::max)
    }
    for friction in [0.1, 0.5] {
        for dt in [4e-3, 5e-4, 1e-4] {
            let [disc, sphere] = [spins::<2>(friction, dt), spins::<3>(friction, dt)];
            println!("{friction}, steps of {dt} s: {disc:.1e}, {sphere:.1e} rad/s");
            assert!(
                disc < 0.05 && sphere < 0.05,
                "{friction}, steps of {dt} s: {disc} and {sphere} rad/s"
            );
        }
    }
}
