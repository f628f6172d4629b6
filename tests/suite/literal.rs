//! Eq. (19) as the paper prints it, against sums written out by hand.

use crate::motion::disc;
use crate::support::{PERIODIC, box_case, petsc};
use mics::method::MethodKind;
use mics::scene::Scene;
use nalgebra::Vector3;

/// Cells along each side of the box of 1 m.
const N: usize = 32;
const H: f64 = 1.0 / N as f64;
const RADIUS: f64 = 0.13;
/// Centre of the disc (m), off the grid's symmetries.
const CENTRE: [f64; 2] = [0.513, 0.481];
const VISCOSITY: f64 = 0.07;
/// Rate of the stagnation flow u = (A x, -A y) about the box's middle (1/s).
const RATE: f64 = 1.3;
/// The step (s).
const DT: f64 = 1e-4;

/// A value of a cell or of its low face.
type At<'a, T> = &'a dyn Fn(usize, usize) -> T;

struct Sums {
    convective: Vector3<f64>,
    pressure: Vector3<f64>,
    viscous: Vector3<f64>,
    torque: Vector3<f64>,
}

/// Where the middle of a cell lies (m).
fn middle(i: usize, j: usize) -> Vector3<f64> {
    Vector3::new((i as f64 + 0.5) * H, (j as f64 + 0.5) * H, 0.0)
}

/// The three parts of (19) and the moment of (18) in a stagnation flow, cell by cell: `-u.grad u =
/// -A^2 (x, y)`, and `div( mu e )/rho` with `e = diag(2A, -2A)`, so that only the gradient of the
/// mixture's mu counts. The pressure, which is mixed in the bodies at the end of a step, is known
/// by what it took from the faces, `dp/dn = (U* - U) rho/dt` by (8) and (13); its gradient at a
/// cell as in (16) is the mean of that at two faces. `after` has U at the low faces of a cell.
fn by_hand(density: f64, inner: f64, alpha: At<f64>, after: At<[f64; 2]>) -> Sums {
    let mu = |i: usize, j: usize| VISCOSITY + alpha(i, j) * (inner - VISCOSITY);
    let rho = |i: usize, j: usize| 1.0 + alpha(i, j) * (density - 1.0);
    let from_middle = |i: usize, j: usize| middle(i, j) - Vector3::new(0.5, 0.5, 0.0);
    let convective = |i: usize, j: usize| -RATE * RATE * from_middle(i, j);
    let viscous = |i: usize, j: usize| {
        let [x, y] = [mu(i + 1, j) - mu(i - 1, j), mu(i, j - 1) - mu(i, j + 1)];
        Vector3::new(x, y, 0.0) * (RATE / (rho(i, j) * H))
    };
    let predicted = |i: usize, j: usize| {
        let at = from_middle(i, j);
        RATE * Vector3::new(at.x, -at.y, 0.0) + DT * (convective(i, j) + viscous(i, j))
    };
    let slope = |i: usize, j: usize, axis: usize| {
        let (k, l) = if axis == 0 { (i - 1, j) } else { (i, j - 1) };
        let whole = 0.5 * (predicted(k, l) + predicted(i, j))[axis];
        (whole - after(i, j)[axis]) / DT * 0.5 * (rho(k, l) + rho(i, j))
    };
    let zero = Vector3::zeros;
    let mut sums = Sums { convective: zero(), pressure: zero(), viscous: zero(), torque: zero() };
    for (i, j) in (0..N).flat_map(|i| (0..N).map(move |j| (i, j))).filter(|c| alpha(c.0, c.1) > 0.0)
    {
        let gradient = Vector3::new(
            0.5 * (slope(i, j, 0) + slope(i + 1, j, 0)),
            0.5 * (slope(i, j, 1) + slope(i, j + 1, 1)),
            0.0,
        );
        let share = alpha(i, j) * H * H * density;
        let pressure = gradient / -rho(i, j);
        sums.convective += share * convective(i, j);
        sums.pressure += share * pressure;
        sums.viscous += share * viscous(i, j);
        if alpha(i, j) < 1.0 {
            let arm = middle(i, j) - Vector3::new(CENTRE[0], CENTRE[1], 0.0);
            let all = convective(i, j) + pressure + viscous(i, j);
            sums.torque += arm.cross(&(share * all));
        }
    }
    sums
}

/// Gives a scene the stagnation flow.
fn set_stagnation_flow(scene: &mut Scene<2>) {
    for c in scene.domain.grid.rows().flatten() {
        let at = scene.domain.grid.centre(c);
        for (axis, rate) in [RATE, -RATE].into_iter().enumerate() {
            scene.state.u[axis][c] = rate * (at[axis] - 0.5);
            scene.state.faces[axis][c] = rate * (at[axis] - 0.5 * H - 0.5);
        }
    }
}

/// The fractions are those of the method, which have tests of their own. A particle gains what
/// the sums give over the step, and nothing else.
#[test]
fn literal_force_of_eq_19_equals_sum_over_cells() {
    let petsc = petsc();
    for density in [1.0, 1.2, 2.65, 1000.0] {
        let more = format!(
            "[[particle]]\nshape = {{ disc = {{ diameter = {:?} }} }}\nposition = {CENTRE:?}\n\
            density = {density:?}\nviscosity = 0.01\n\
            [time]\nend = 1.0\nadvection = \"upwind5\"\n[pressure]\ndivergence_limit = 1e-9\n",
            2.0 * RADIUS
        );
        let text = box_case([1.0, 1.0], [N, N], VISCOSITY, PERIODIC, &more).replacen(
            '\n',
            "\npreset = \"mics-2003\"\n",
            1,
        );
        let mut scene: Scene<2> = petsc.scene(&text);
        assert_eq!(scene.method.kind(), MethodKind::Mixture);
        let grid = scene.domain.grid.clone();
        set_stagnation_flow(&mut scene);
        let mut fractions = grid.field();
        for o in scene.method.overlaps_of(0).unwrap() {
            fractions[o.cell] = o.fraction;
        }
        scene.step(DT).unwrap();
        let cell = |i: usize, j: usize| grid.owned_index([i, j]).unwrap();
        let after = |i: usize, j: usize| [0, 1].map(|axis| scene.state.faces[axis][cell(i, j)]);
        let hand = by_hand(density, 0.01, &|i, j| fractions[cell(i, j)], &after);
        let (found, body) = (scene.state.exchange[0], &scene.state.bodies[0]);
        let force = hand.convective + hand.pressure + hand.viscous;
        for (name, found, hand) in [
            ("convective", found.remainder, hand.convective),
            ("pressure", found.pressure, hand.pressure),
            ("viscous", found.viscous, hand.viscous),
            ("torque", found.literal_torque, hand.torque),
            ("momentum", body.mass() / DT * body.velocity, force),
            ("spin", body.inertia().of(&body.spin) / DT, hand.torque),
        ] {
            println!("s = {density}, {name}: {found:?} by hand {hand:?}");
            assert!(
                (found - hand).norm() < 1e-8 * hand.norm() + 1e-14,
                "s = {density}, {name}: {found:?}, by hand {hand:?}"
            );
        }
    }
}

/// (17): a free particle gains the force of (19), its weight less buoyancy and what contacts give.
#[test]
fn motion_of_eq_17_is_force_weight_and_contact_impulse() {
    let petsc = petsc();
    let more = [
        disc(0.2, [0.4, 0.52], 2.65, "velocity = [1.0, 0.0]"),
        disc(0.2, [0.61, 0.5], 5.0, ""),
        "[contact]\nnormal_stiffness = 1.0e2\nfriction = 0.3\n".into(),
    ]
    .concat();
    let text = box_case([1.0, 1.0], [N, N], VISCOSITY, PERIODIC, &more)
        .replacen('\n', "\npreset = \"mics-2003\"\n", 1)
        .replace("viscosity = 0.07", "gravity = [0.3, -1.0]\nviscosity = 0.07");
    let mut scene: Scene<2> = petsc.scene(&text);
    let gravity = scene.domain.fluid.gravity;
    let mut pushed = 0;
    for _ in 0..40 {
        let before = scene.state.bodies.clone();
        let dt = 2e-3;
        scene.step(dt).unwrap();
        for ((body, before), exchange) in
            scene.state.bodies.iter().zip(&before).zip(&scene.state.exchange)
        {
            let weight = (body.density - 1.0) * body.volume() * gravity;
            let gained = body.mass() / dt * (body.velocity - before.velocity);
            let given = exchange.literal() + weight + exchange.contact;
            assert!((gained - given).norm() < 1e-12 * (1.0 + given.norm()), "{gained} {given}");
            pushed += usize::from(exchange.contact.norm() > 0.01);
        }
        let [one, other] = [0, 1].map(|k| scene.state.exchange[k].contact);
        assert!((one + other).norm() < 1e-12 * (1.0 + one.norm()), "{one} {other}");
    }
    assert!(pushed > 4, "they meet: {pushed}");
}

/// (27) to (29): a body of the fluid's density and viscosity leaves the mixture uniform, so that
/// u_f and p_f are those of the flow without it.
#[test]
fn mixing_of_eq_27_to_29_equals_sum_over_cells() {
    let petsc = petsc();
    let velocity = Vector3::new(0.2, -0.1, 0.0);
    let spin = Vector3::new(0.0, 0.0, 1.5);
    let how = "motion = { prescribed = { velocity = [0.2, -0.1], spin = 1.5 } }";
    let scene = |body: &str| {
        let text = box_case([1.0, 1.0], [N, N], VISCOSITY, PERIODIC, body);
        let text = text.replacen('\n', "\npreset = \"mics-2003\"\n", 1);
        let mut scene: Scene<2> = petsc.scene(&(text + "[pressure]\ndivergence_limit = 1e-9\n"));
        set_stagnation_flow(&mut scene);
        scene.step(DT).unwrap();
        scene
    };
    let body = disc(2.0 * RADIUS, CENTRE, 1.0, &format!("{how}\nviscosity = {VISCOSITY:?}"));
    let mixed = scene(&body);
    let fluid = scene("");
    let overlaps = mixed.method.overlaps_of(0).unwrap();
    let whole: f64 = overlaps.iter().map(|o| o.fraction).sum();
    let mean = overlaps.iter().map(|o| o.fraction * fluid.state.p[o.cell]).sum::<f64>() / whole;
    let mut force = Vector3::zeros();
    let mut torque = Vector3::zeros();
    for o in overlaps {
        let before = Vector3::new(fluid.state.u[0][o.cell], fluid.state.u[1][o.cell], 0.0);
        let rigid = velocity + if o.fraction < 1.0 { spin.cross(&o.arm) } else { Vector3::zeros() };
        let change = o.fraction * (rigid - before);
        for axis in 0..2 {
            let found = mixed.state.u[axis][o.cell];
            assert!((found - before[axis] - change[axis]).abs() < 1e-9, "{found}, {before}");
        }
        force -= H * H / DT * change;
        torque -= H * H / DT * o.arm.cross(&change);
        let expected = fluid.state.p[o.cell] + o.fraction * (mean - fluid.state.p[o.cell]);
        let found = mixed.state.p[o.cell];
        assert!((found - expected).abs() < 1e-6 * mean.abs(), "{found} Pa, not {expected}");
    }
    let found = mixed.state.exchange[0];
    assert!((found.momentum - force).norm() < 1e-8 * force.norm(), "{} {force}", found.momentum);
    assert!((found.momentum_torque - torque).norm() < 1e-8 * torque.norm(), "{torque}");
}
