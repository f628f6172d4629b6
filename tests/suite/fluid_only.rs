//! Output on the fluid is of the fluid alone: cells inside bodies, which hold what the walls need,
//! do not count.

use crate::support::{MIXING, SHARP, STREAM, box_case, petsc};
use mics::output::snapshot::take;
use mics::scene::Scene;
use mics_run::snapshot::Snapshot;

/// Per cell of a snapshot, whether a body fills more than half of it.
fn inside(snapshot: &Snapshot) -> Vec<bool> {
    snapshot
        .array("solid_fraction")
        .unwrap()
        .values
        .iter()
        .map(|fraction| *fraction > 0.5)
        .collect()
}

#[test]
fn max_speed_excludes_ghost_cells() {
    let petsc = petsc();
    let more = format!(
        "[[particle]]\nshape = {{ disc = {{ diameter = 0.5 }} }}\nposition = [0.8, 0.77]\n\
        motion = \"fixed\"\n{SHARP}"
    );
    let mut scene: Scene<2> = petsc.scene(&box_case([3.0, 1.5], [48, 24], 1e-4, STREAM, &more));
    let mut most = 0.0f64;
    for _ in 0..150 {
        let dt = 0.5 * scene.limits().unwrap().tightest().1.min(0.05);
        let said = scene.step(dt).unwrap().largest_speed;
        let u = &scene.state.u;
        let speed = |c: usize| u[0][c].hypot(u[1][c]);
        let all = scene.domain.grid.rows().flatten().map(speed).fold(0.0, f64::max);
        let covered = scene
            .method
            .overlaps()
            .filter(|o| o.fraction > 0.5)
            .map(|o| o.cell)
            .collect::<Vec<_>>();
        let outside = scene
            .domain
            .grid
            .rows()
            .flatten()
            .filter(|c| !covered.contains(c))
            .map(speed)
            .fold(0.0, f64::max);
        assert!(
            (said / outside - 1.0).abs() < 1e-14,
            "{said} is not {outside}; of all cells {all}"
        );
        most = most.max(all / outside);
    }
    println!("inside up to {most} times the fluid's largest speed");
    assert!(most > 1.01, "this scene tells nothing: {most}");
}

#[test]
fn fields_have_rigid_velocity_inside_bodies() {
    let petsc = petsc();
    for wall in [SHARP, MIXING] {
        let more = format!(
            "[[particle]]\nshape = {{ disc = {{ diameter = 0.4 }} }}\nposition = [0.5, 0.5]\n\
             motion = {{ prescribed = {{ velocity = [0.3, -0.1], spin = 2.0 }} }}\n{wall}"
        );
        let mut scene: Scene<2> = petsc.scene(&box_case([2.0, 1.0], [64, 32], 1e-3, STREAM, &more));
        for _ in 0..20 {
            scene.step(5e-3).unwrap();
        }
        let snapshot = take(&mut scene).unwrap();
        let (inside, body) = (inside(&snapshot), &scene.state.bodies[0]);
        let velocity = &snapshot.array("velocity").unwrap().values;
        let vorticity = &snapshot.array("vorticity").unwrap().values;
        let mut counted = [0, 0];
        for (k, within) in inside.into_iter().enumerate() {
            let (i, j) = (k % 64, k / 64);
            let cell = scene.domain.grid.owned_index([i, j]).unwrap();
            counted[usize::from(within)] += 1;
            let [x, y] = [i, j].map(|n| (n as f64 + 0.5) / 32.0);
            let own = [0.3 - 2.0 * (y - body.centre.y), -0.1 + 2.0 * (x - body.centre.x)];
            let held = [scene.state.u[0][cell], scene.state.u[1][cell]];
            let expected = if within { own } else { held };
            for a in 0..2 {
                assert!(
                    (velocity[3 * k + a] - expected[a]).abs() < 1e-12,
                    "{wall}: cell {i} {j}, {within}"
                );
            }
            assert!(!within || vorticity[k] == 4.0, "{wall}: {} at {i} {j}", vorticity[k]);
        }
        assert!(counted[0] > 1500 && counted[1] > 100, "{counted:?}");
    }
}

#[test]
fn kinetic_energy_counts_fluid_outside_and_free_bodies() {
    let petsc = petsc();
    // A heavy disc and the fluid around it move as one: the energies are those of their masses.
    let more = format!(
        "[[particle]]\nshape = {{ disc = {{ diameter = 0.5 }} }}\nposition = [0.5, 0.5]\n\
        density = 7.0\nvelocity = [1.0, 0.0]\n\
         [initial]\nvelocity = [1.0, 0.0]\n{SHARP}"
    );
    let mut scene: Scene<2> =
        petsc.scene(&box_case([1.0, 1.0], [32, 32], 1e-3, crate::support::PERIODIC, &more));
    for _ in 0..3 {
        scene.step(1e-3).unwrap();
    }
    let (e, area) = (scene.state.energy, std::f64::consts::PI / 16.0);
    for (found, exact) in [
        (e.bodies, 0.5 * 7.0 * area),
        (e.fluid, 0.5 * (1.0 - area)),
        (e.kinetic(), 0.5 + 3.0 * area),
    ] {
        assert!((found / exact - 1.0).abs() < 1e-9, "{found} of {exact}");
    }
}
