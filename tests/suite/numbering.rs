//! How a case numbers its bodies decides no result: the same bits in another order.

use crate::support::{columns, run};

/// Runs a case with its bodies as they are told, and in another order, and compares all rows.
fn expect_same_bits(scene: &str, bodies: &[String]) {
    let dir = tempfile::tempdir().unwrap();
    let [plain, other] = [(1, 0), (5, 3)].map(|(stride, first)| {
        let order: Vec<usize> =
            (0..bodies.len()).map(|k| (stride * k + first) % bodies.len()).collect();
        let told: String = order.iter().map(|k| bodies[*k].as_str()).collect();
        let case = dir.path().join(format!("{first}.toml"));
        std::fs::write(&case, format!("{scene}{told}")).unwrap();
        let out = dir.path().join(first.to_string());
        run(&case, &out, &[]);
        (order, out)
    });
    let [rows, steps] = ["particles.csv", "steps.csv"]
        .map(|name| [&plain, &other].map(|(_, out)| columns(&out.join(name))));
    let count = bodies.len();
    assert!(rows[0]["x"].len() > 50 * count, "{} rows", rows[0]["x"].len());
    assert!(steps[0]["spring_energy"].iter().any(|energy| *energy > 0.0), "none touch");
    for (name, values) in rows[0].iter().filter(|(name, _)| *name != "id") {
        for (row, value) in rows[1][name].iter().enumerate() {
            let here = values[row - row % count + other.0[row % count]];
            assert_eq!(value.to_bits(), here.to_bits(), "{name}, row {row}: {value:e} {here:e}");
        }
    }
    for (name, values) in steps[0].iter().filter(|(name, _)| *name != "wall") {
        let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(values), bits(&steps[1][name]), "{name}");
    }
}

/// A closed box with the bodies that follow.
fn dense(size: &str, cells: &str, gravity: &str, sides: &[&str]) -> String {
    let walls: String = sides.iter().map(|side| format!("{side} = \"wall\"\n")).collect();
    format!(
        "name = \"dense\"\n[domain]\nsize = {size}\ncells = {cells}\n[fluid]\ndensity = 1.0\n\
        viscosity = 0.0005\ngravity = {gravity}\n[boundary]\n{walls}[contact]\nfriction = 0.3\n\
        restitution = 0.6\n[time]\nend = 0.3\ncfl = 0.4\n[pressure]\ndivergence_limit = 1e-6\n\
        [coupling]\nwall = \"sharp\"\n[output]\nparticles = {{ every = 1 }}\nfigures = false\n"
    )
}

const SIDES: [&str; 6] = ["west", "east", "south", "north", "bottom", "top"];

#[test]
fn results_do_not_depend_on_numbers_of_discs() {
    let disc = |k: usize| {
        let x = 0.16 + 0.29 * (k % 4) as f64 + 0.013 * (7 * k % 5) as f64;
        let y = 0.13 + 0.24 * (k / 4) as f64 + 0.011 * (3 * k % 4) as f64;
        let speed = (5 * k % 7) as f64 / 3.0 - 1.0;
        format!(
            "[[particle]]\nshape = {{ disc = {{ diameter = {:?} }} }}\nposition = [{x:?}, {y:?}]\n\
            velocity = [{speed:?}, {:?}]\ndensity = {:?}\n",
            0.2 - 0.004 * (k % 3) as f64,
            -0.5 * speed,
            20.0 + 0.1 * k as f64
        )
    };
    let scene = dense("[1.2, 1.0]", "[48, 40]", "[0.0, -3.0]", &SIDES[..4]);
    expect_same_bits(&scene, &(0..12).map(disc).collect::<Vec<_>>());
}

#[test]
fn results_do_not_depend_on_numbers_of_spheres() {
    let sphere = |k: usize| {
        let at = [k % 2, k / 2 % 2, k / 4].map(|n| 0.19 + 0.33 * n as f64);
        let off = [7 * k % 5, 3 * k % 4, 5 * k % 3].map(|n| 0.01 * n as f64);
        let place = [0, 1, 2].map(|a| at[a] + off[a]);
        let speed = (5 * k % 7) as f64 / 3.0 - 1.0;
        format!(
            "[[particle]]\nshape = {{ sphere = {{ diameter = 0.28 }} }}\nposition = {place:?}\n\
            velocity = [{speed:?}, {:?}, {:?}]\ndensity = {:?}\n",
            -0.5 * speed,
            0.3 * speed,
            20.0 + 0.1 * k as f64
        )
    };
    let scene = dense("[0.72, 0.72, 0.72]", "[18, 18, 18]", "[0.0, 0.0, -3.0]", &SIDES);
    expect_same_bits(&scene, &(0..8).map(sphere).collect::<Vec<_>>());
}

#[test]
fn results_do_not_depend_on_numbers_of_ellipses() {
    let ellipse = |k: usize| {
        let x = 0.17 + 0.3 * (k % 3) as f64 + 0.013 * (3 * k % 4) as f64;
        let y = 0.16 + 0.28 * (k / 3) as f64 + 0.011 * (5 * k % 3) as f64;
        let speed = (5 * k % 7) as f64 / 3.0 - 1.0;
        format!(
            "[[particle]]\nshape = {{ ellipse = {{ axes = [0.27, 0.18] }} }}\n\
            position = [{x:?}, {y:?}]\norientation = {:?}\nvelocity = [{speed:?}, {:?}]\n\
            spin = {speed:?}\ndensity = 25.0\n",
            25 * k,
            -0.5 * speed
        )
    };
    let scene = dense("[1.0, 1.0]", "[40, 40]", "[0.5, -3.0]", &SIDES[..4]);
    expect_same_bits(&scene, &(0..9).map(ellipse).collect::<Vec<_>>());
}
