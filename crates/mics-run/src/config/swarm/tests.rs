//! Swarms: places, gaps, packings, files and what is written out.

use super::*;
use crate::config::load;
use crate::config::particle::{distance, overlap};
use crate::config::validate::validate;
use std::f64::consts::PI;

/// A box of 2 by 1 (by 1) m, periodic along x, with walls elsewhere, and these further keys.
fn text(dimension: usize, keys: &str) -> String {
    let size = &[2.0, 1.0, 1.0][..dimension];
    let cells = &[16, 8, 8][..dimension];
    let lids = if dimension == 3 { "bottom = \"wall\"\ntop = \"wall\"" } else { "" };
    format!(
        "name = \"box\"\ntime.end = 1.0\ndomain = {{ size = {size:?}, cells = {cells:?} }}\n\
        fluid = {{ density = 1.0, viscosity = 0.1 }}\n{keys}\n\
        [boundary]\nwest = \"periodic\"\neast = \"periodic\"\nsouth = \"wall\"\n\
        north = \"wall\"\n{lids}"
    )
}

/// The case with its swarms turned into particles, or key and message of its refusal.
fn expanded(dimension: usize, keys: &str, csv: &str) -> Result<Case, (String, String)> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("gravel.csv"), csv).unwrap();
    let mut case = toml::from_str(&text(dimension, keys)).unwrap();
    let checked =
        validate(&case).and_then(|()| expand(&mut case, folder.path(), |_| Err(String::new())));
    checked.map(|()| case).map_err(|fault| (fault.key, fault.message))
}

fn good(dimension: usize, keys: &str) -> Case {
    expanded(dimension, keys, "").unwrap()
}

#[test]
fn swarm_of_3000_bodies_is_placed_quickly() {
    let start = crate::cpu::thread_seconds();
    let case = good(
        2,
        "swarm = [{ count = 3000, region = { min = [0.0, 0.0], max = [2.0, 1.0] }, diameter = { \
        uniform = [0.01, 0.025] } }]",
    );
    let spent = crate::cpu::thread_seconds() - start;
    assert!(spent < 0.5, "{spent} s");
    assert_eq!((case.particle.len(), case.swarm.len()), (3000, 0));
    assert!(overlap(&case).is_none());
    let diameters = || case.particle.iter().map(|particle| particle.shape.bounding_diameter());
    assert!(
        diameters().all(|d| (0.01..=0.025).contains(&d)) && diameters().is_sorted_by(|a, b| a >= b)
    );
    assert!((diameters().sum::<f64>() / 3000.0 - 0.0175).abs() < 3e-4);
    // Across the periodic faces too.
    assert!(
        case.particle
            .iter()
            .any(|particle| particle.position[0] < 0.25 * particle.shape.bounding_diameter())
    );
}

#[test]
fn dense_swarm_is_packed() {
    let keys = "particle = [{ shape = { disc = { diameter = 0.8 } }, position = [0.1, 0.5], motion \
        = \"fixed\" }]\n\
        swarm = [{ count = COUNT, region = { min = [0.6, 0.0], max = [1.6, 1.0] }, diameter = \
        0.02, gap = 1e-4 }]";
    // 47 % at random; 75 % packed; 88 % is more than discs at random can fill.
    for count in [1500, 2400] {
        let case = good(2, &keys.replace("COUNT", &count.to_string()));
        assert_eq!(case.particle.len(), count + 1);
        assert!(overlap(&case).is_none());
        for grain in &case.particle[1..] {
            let [x, y] = grain.position[..] else { panic!("2D") };
            assert!((0.61..=1.59).contains(&x) && (0.0101..=0.9899).contains(&y), "{x} {y}");
        }
    }
    let (key, message) = expanded(2, &keys.replace("COUNT", "2800"), "").unwrap_err();
    assert!(
        key == "swarm.0.count"
            && message.contains("2800 do not fit: with their gaps they would cover 88.8 %"),
        "{message}"
    );
}

#[test]
fn swarm_of_two_sphere_sizes_fills_half_of_periodic_box() {
    let case = good(
        3,
        "swarm = [{ count = 1000, region = { min = [0.0, 0.0, 0.0], max = [2.0, 1.0, 1.0] }, \
        diameter = { uniform = [0.115, 0.135] } }]",
    );
    let volume: f64 =
        case.particle.iter().map(|p| p.shape.bounding_diameter().powi(3)).sum::<f64>() * PI / 6.0;
    assert!((0.5..0.53).contains(&(0.5 * volume)), "{volume}");
    assert!(overlap(&case).is_none());
    assert!(
        case.particle.iter().any(|p| p.position[0] < 0.02)
            && case.particle.iter().any(|p| p.position[0] > 1.98)
    );
}

#[test]
fn swarm_seed_is_reproducible() {
    let keys = "swarm = [{ count = 4, region = { min = [0.0, 0.0], max = [2.0, 1.0] }, diameter = \
        0.1, seed = SEED }]";
    let places = |seed: &str| {
        let case = good(2, &keys.replace("SEED", seed));
        case.particle.into_iter().map(|particle| particle.position).collect::<Vec<_>>()
    };
    assert_eq!(places("1"), places("1"));
    assert_ne!(places("1"), places("2"));
    // Written down once, to the last digit: what a case gave must stay what it gives.
    assert_eq!(places("1")[0], FIRST_PLACE);
}

/// Where the first of four bodies lies by seed 1.
const FIRST_PLACE: [f64; 2] = [0.5673811826074753, 0.6895492013129978];

#[test]
fn swarm_gap_to_walls_swarms_and_periodic_images() {
    let case = good(
        3,
        "swarm = [{ count = 60, region = { min = [0.0, 0.0, 0.0], max = [2.0, 1.0, 1.0] }, \
        diameter = 0.15 }, { count = 60, region = { min = [0.0, 0.0, 0.2], max = [2.0, 1.0, 0.7] \
        }, diameter = { uniform = [0.05, 0.1] }, gap = 0.03, motion = \"fixed\", material = \
        \"glass\" }]",
    );
    assert_eq!(case.particle.len(), 120);
    assert!(overlap(&case).is_none());
    for (i, new) in case.particle.iter().enumerate().skip(60) {
        let radius = 0.5 * new.shape.bounding_diameter();
        for other in &case.particle[..i] {
            let apart = distance(&new.position, &other.position, &case.periods());
            assert!(apart >= radius + 0.5 * other.shape.bounding_diameter() + 0.03);
        }
        let [_, y, z] = new.position[..] else { panic!("3D") };
        assert!(
            y >= radius + 0.03
                && y <= 1.0 - radius - 0.03
                && z >= 0.2 + radius
                && z <= 0.7 - radius
        );
        assert_eq!((&new.motion, new.material()), (&Motion::Fixed, "glass"));
    }
}

#[test]
fn swarm_from_csv_with_defaults_of_swarm() {
    let keys = "swarm = [{ from = \"gravel.csv\", density = 2.0, velocity = [1.0, 0.0], locked = \
        [\"rotation\"] }]";
    let csv = "# made by hand\ndiameter, x, y, vy, spin, density\n0.1, 0.5, 0.5, -1, 3, 4\n\
        0.2,1.0,0.5,0,0,5\n";
    let case = expanded(2, keys, csv).unwrap();
    let first = &case.particle[0];
    assert_eq!((first.shape.bounding_diameter(), &first.position[..]), (0.1, &[0.5, 0.5][..]));
    assert_eq!((first.density, first.velocity.as_deref()), (Some(4.0), Some(&[1.0, -1.0][..])));
    assert_eq!((&first.spin, &first.locked[..]), (&Some(Spin::Plane(3.0)), &[Lock::Rotation][..]));
    assert_eq!((case.particle.len(), case.particle[1].density), (2, Some(5.0)));
}

#[test]
fn swarm_case_round_trip_with_every_particle() {
    let typed = text(
        2,
        "swarm = [{ count = 20, region = { min = [0.0, 0.0], max = [2.0, 1.0] }, diameter = 0.05, \
        spin = 1.0 }]\n\
        contact = { normal_stiffness = 1e5, pair = [{ between = [\"wall\", \"default\"], friction \
        = 0.2 }] }\n\
        measure = [{ name = \"end\", kind = \"position_x\", particle = 19 }]",
    );
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("case.toml");
    std::fs::write(&file, typed).unwrap();
    let case = load(&file, &[]).unwrap().case;
    std::fs::write(&file, case.to_toml()).unwrap();
    assert_eq!(load(&file, &[]).unwrap().case, case);
    assert!(
        case.to_toml().contains("substeps = \"auto\"")
            && case.to_toml().contains("restitution = 0.5")
    );
}
