//! Momentum in a box with sides, sharp surfaces: what everything in it gains is what its sides,
//! gravity and contacts give. The two are summed from different numbers: the one from all cells and
//! bodies, the other from the fields beside the sides.

use crate::support::{PERIODIC, SHARP, box_case, petsc};
use mics::grid::BoundaryKind;
use mics::scene::Scene;
use nalgebra::Vector3;

const FALLING: &str = "gravity = [0.3, -1.0]\nviscosity";

/// Free discs, one of which strikes the floor, and one that is held.
fn discs() -> String {
    let disc = |place: [f64; 2], more: &str| {
        format!(
            "[[particle]]\nshape = {{ disc = {{ diameter = 0.25 }} }}\nposition = {place:?}\n\
            {more}\n"
        )
    };
    [
        &disc([0.6, 0.14], "density = 2.65\nvelocity = [0.4, -0.5]\nspin = 3.0"),
        &disc([1.2, 0.7], "density = 0.5"),
        &disc([1.5, 0.3], "motion = \"fixed\""),
        "[contact]\nnormal_stiffness = 500.0\nfriction = 0.3\n",
        SHARP,
    ]
    .concat()
}

/// Steps a scene and returns, of all steps, the largest momentum, what the sides give in a step,
/// and what is missing.
fn follow<const D: usize>(scene: &mut Scene<D>, steps: usize, dt: f64) -> [f64; 3] {
    let mut most = [0.0f64; 3];
    for _ in 0..steps {
        scene.step(dt).unwrap();
        let audit = scene.state.balance.as_ref().unwrap();
        let now = [audit.momentum.norm(), audit.impulses.boundary().norm(), audit.error.norm()];
        most.iter_mut().zip(now).for_each(|(most, now)| *most = most.max(now));
    }
    most
}

#[test]
fn momentum_balance_of_sides_gravity_and_contacts() {
    let petsc = petsc();
    let moving = ["\"wall\"", "\"slip\"", "\"wall\"", "{ moving_wall = [1.0, 0.0] }"];
    let stream = ["{ inflow_parabola = [1.0, 0.0] }", "\"outflow\"", "\"wall\"", "\"slip\""];
    for sides in [moving, stream] {
        // Viscosity asks for the four stages of rkl2 at 0.2 Pa s.
        for (scheme, viscosity) in [("rk2", 0.01), ("rk3", 0.01), ("rkl2", 0.2)] {
            let more = format!(
                "{}[time]\nend = 1.0\nscheme = \"{scheme}\"\n[pressure]\ndivergence_limit = 1e-8",
                discs()
            );
            let text = box_case([2.0, 1.0], [64, 32], viscosity, sides, &more)
                .replace("viscosity", FALLING);
            let mut scene: Scene<2> = petsc.scene(&text);
            let [momentum, boundary, error] = follow(&mut scene, 60, 4e-3);
            println!(
                "{sides:?} {scheme}: momentum {momentum:.3}, sides {boundary:.2e} a step, missing \
                {error:.1e}"
            );
            assert!(
                boundary > 1e-3 && error < 1e-12,
                "{sides:?} {scheme}: {error:e} of {boundary:e}"
            );
        }
    }
}

#[test]
fn momentum_balance_in_3d() {
    let petsc = petsc();
    let text = "name = \"b\"\n[domain]\nsize = [1.5, 1.0, 1.0]\ncells = [24, 16, 16]\n[fluid]\n\
        density = 1.0\n\
        viscosity = 0.02\ngravity = [0.2, 0.1, -1.0]\n[boundary]\nwest = \"wall\"\neast = \
            \"slip\"\nsouth = \"periodic\"\n\
        north = \"periodic\"\nbottom = \"wall\"\ntop = { moving_wall = [1.0, 0.5, 0.0] }\n\
            [coupling]\nwall = \"sharp\"\n\
        [[particle]]\nshape = { sphere = { diameter = 0.5 } }\nposition = [0.7, 0.4, 0.6]\n\
        density = 2.65\n\
        [time]\nend = 1.0\n[pressure]\ndivergence_limit = 1e-8";
    let mut scene: Scene<3> = petsc.scene(text);
    let [_, boundary, error] = follow(&mut scene, 20, 5e-3);
    assert!(boundary > 1e-3 && error < 1e-12, "{error:e} of {boundary:e}");
}

/// Advection along paths keeps no momentum, and the audit has to say so: a balance that closes
/// whatever happens is none.
#[test]
fn momentum_balance_detects_non_conservative_term() {
    let petsc = petsc();
    let sides = ["\"wall\"", "\"slip\"", "\"wall\"", "{ moving_wall = [1.0, 0.0] }"];
    for sides in [sides, PERIODIC] {
        let more = discs()
            + "[initial]\nvelocity = [0.5, 0.2]\n[time]\nend = 1.0\n\
                scheme = \"euler\"\nadvection = \"qsi\"\n\
               [pressure]\ndivergence_limit = 1e-8";
        let text = box_case([2.0, 1.0], [64, 32], 0.01, sides, &more).replace("viscosity", FALLING);
        let mut scene: Scene<2> = petsc.scene(&text);
        let mut lost = 0.0f64;
        for _ in 0..20 {
            // The momentum of all cells and bodies is counted; the audit has the impulses on them.
            let before = scene.state.balance.as_ref().unwrap().momentum;
            scene.step(4e-3).unwrap();
            let audit = scene.state.balance.as_ref().unwrap();
            lost = lost.max(audit.error.norm() / (audit.momentum - before).norm());
        }
        println!("{sides:?}: {:.2} % of a step's change", 100.0 * lost);
        assert!(lost > 1e-4, "{sides:?}: {lost:e}");
    }
}

/// Force of the sides on the fluid (N) by the fields as they are: pressure and shear by parabolas
/// through the cells beside them, not by what the scheme has there.
fn traction(scene: &Scene<2>, viscosity: f64) -> Vector3<f64> {
    let (grid, mut force) = (&scene.domain.grid, Vector3::zeros());
    for (axis, side) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        let Some(BoundaryKind::Velocity(value)) = &scene.domain.boundaries.kinds[axis][side] else {
            continue;
        };
        let (s, h, area) = (grid.stride[axis], grid.h[axis], grid.h[1 - axis]);
        let inwards = if side == 0 { 1.0 } else { -1.0 };
        for c in grid.rows().flatten().filter(|&c| {
            let at = grid.global_cell(c)[axis];
            at == if side == 0 { 0 } else { grid.cells[axis] - 1 }
        }) {
            let next = |k: usize| if side == 0 { c + k * s } else { c - k * s };
            let p: [f64; 3] = std::array::from_fn(|k| scene.state.p[next(k)]);
            force[axis] += inwards * area * (15.0 * p[0] - 10.0 * p[1] + 3.0 * p[2]) / 8.0;
            let u = |k: usize| scene.state.u[1 - axis][next(k)];
            let wall = value[1 - axis][grid.global_cell(c)[1 - axis] + grid.ghosts];
            force[1 - axis] -= area * viscosity * (-8.0 * wall + 9.0 * u(0) - u(1)) / (3.0 * h);
        }
    }
    force
}

#[test]
fn side_impulse_equals_traction_of_fields() {
    let petsc = petsc();
    let viscosity = 0.1;
    let (wall, lid) = ("\"wall\"", "{ moving_wall = [1.0, 0.0] }");
    // A lid between other walls has no finite shear at its ends.
    for sides in [[wall; 4], ["\"periodic\"", "\"periodic\"", wall, lid]] {
        let more = [
            "[[particle]]\nshape = { disc = { diameter = 0.25 } }\nposition = [1.1, 0.6]\n\
            density = 2.65\n",
            SHARP,
            "[pressure]\ndivergence_limit = 1e-8",
        ]
        .concat();
        let text =
            box_case([2.0, 1.0], [64, 32], viscosity, sides, &more).replace("viscosity", FALLING);
        let mut scene: Scene<2> = petsc.scene(&text);
        // Until the layers at the walls are some cells thick.
        let dt = 2e-3;
        follow(&mut scene, 150, dt);
        let (mut worst, mut most) = (Vector3::zeros(), Vector3::zeros());
        for _ in 0..20 {
            scene.step(dt).unwrap();
            let (told, found) = (
                scene.state.balance.as_ref().unwrap().impulses.boundary() / dt,
                traction(&scene, viscosity),
            );
            worst = (told - found).abs().sup(&worst);
            most = told.abs().sup(&most);
        }
        println!(
            "{sides:?}: {:.4} {:.4} N, differs by up to {:.4} {:.4} N",
            most.x, most.y, worst.x, worst.y
        );
        for a in 0..2 {
            assert!(worst[a] < 0.05 * most[a], "{sides:?} along {a}: {worst} of {most}");
        }
    }
}

/// The momentum that `steps.csv` begins with is that of the state before the first step.
#[test]
fn momentum_balance_starts_from_initial_momentum() {
    let petsc = petsc();
    let more = discs() + "[initial]\nvelocity = [0.5, 0.2]";
    let text = box_case([2.0, 1.0], [64, 32], 0.01, PERIODIC, &more);
    let mut scene: Scene<2> = petsc.scene(&text);
    let start = scene.state.balance.as_ref().unwrap().momentum;
    scene.step(4e-3).unwrap();
    let before = scene.state.balance.as_ref().unwrap().before;
    assert!((before - start).norm() < 1e-12 * before.norm(), "{start} is {before}");
}

/// The force that locks an axis of a body also takes the momentum that its turning gives the cells
/// along it, whose centroid is not the body's: by gravity, and by contacts.
#[test]
fn momentum_balance_with_locked_spinning_body() {
    let petsc = petsc();
    let disc = |place: [f64; 2], locked: &str| {
        format!(
            "[[particle]]\nshape = {{ disc = {{ diameter = 0.25 }} }}\nposition = {place:?}\n\
            density = 5.0\nspin = 2.0\n\
             velocity = [0.0, -0.4]\nlocked = [{locked}]\n"
        )
    };
    let more = format!(
        "{SHARP}{}{}[contact]\nnormal_stiffness = 500.0\nfriction = 0.3\n[initial]\n\
        velocity = [0.4, 0.0]\n\
         [pressure]\ndivergence_limit = 1e-9",
        disc([0.613, 0.142], "\"x\""),
        disc([0.71, 0.407], "\"y\"")
    )
    .replacen(
        "velocity = [0.0, -0.4]\nlocked = [\"y\"]",
        "velocity = [-0.3, 0.0]\n\
        locked = [\"y\"]",
        1,
    );
    let sides = ["\"wall\"", "\"slip\"", "\"wall\"", "\"wall\""];
    let text = box_case([1.5, 1.0], [48, 32], 0.01, sides, &more).replace("viscosity", FALLING);
    let mut scene: Scene<2> = petsc.scene(&text);
    let [momentum, _, error] = follow(&mut scene, 60, 4e-3);
    println!("{error:e} of {momentum:e}");
    assert!(error < 1e-12 * momentum, "{error:e} of {momentum:e}");
}
