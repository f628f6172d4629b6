//! The shipped cases that have references, and how they are varied to meet more of them.

use mics_run::published::cylinder_reference;

/// A shipped case, as it is compiled into the program, and how it is run.
pub(super) struct Row {
    pub name: String,
    pub text: &'static str,
    pub set: Vec<String>,
    pub quick: bool,
}

macro_rules! shipped {
    ($path:literal) => {
        include_str!(concat!("../../cases/", $path))
    };
}

const WAKE: &str = shipped!("cylinder-wake/case.toml");
const SPHERE: &str = shipped!("settling-sphere/case.toml");
const LET_GO: &str = shipped!("sphere-let-go/case.toml");

/// The cases with references, in the order in which they are run: the short ones of `--quick`
/// first.
pub(super) fn shipped() -> Vec<Row> {
    let mut rows = as_they_are();
    rows.extend(settling_in_oils());
    rows.push(sphere_without_mass());
    rows.extend(spheroids_in_shear());
    rows.extend(wakes_at_other_reynolds_numbers());
    rows.sort_by_key(|row| !row.quick);
    rows
}

/// Cases with the references that stand in them, and finer ones.
fn as_they_are() -> Vec<Row> {
    let row = |name: &str, text: &'static str, set: &[&str], quick: bool| Row {
        name: name.into(),
        text,
        set: set.iter().map(|given| given.to_string()).collect(),
        quick,
    };
    let settling = shipped!("settling-disc/case.toml");
    vec![
        row("lid-driven-cavity", shipped!("lid-driven-cavity/case.toml"), &[], true),
        row("cylinder-wake Re 100", WAKE, &[], true),
        row("settling-disc N 8", settling, &[], true),
        row(
            "neutral-disc-in-couette slow",
            shipped!("neutral-disc-in-couette/slow.toml"),
            &[],
            true,
        ),
        row(
            "drafting-kissing-tumbling",
            shipped!("drafting-kissing-tumbling/case.toml"),
            &[],
            true,
        ),
        row("sphere-let-go s 1.5", LET_GO, &[], true),
        row("poiseuille", shipped!("poiseuille/case.toml"), &[], true),
        row("tilted-channel", shipped!("tilted-channel/case.toml"), &[], true),
        row("backward-step", shipped!("backward-step/case.toml"), &[], true),
        row("open-channel", shipped!("open-channel/case.toml"), &[], true),
        row("sphere-array phi 0.125", shipped!("sphere-array/case.toml"), &[], true),
        row("taylor-green", shipped!("taylor-green/case.toml"), &[], false),
        row("sheared-bed A1", shipped!("sheared-bed/case.toml"), &[], false),
        row("random-array phi 0.2", shipped!("random-array/case.toml"), &[], false),
        row("poiseuille-duct", shipped!("poiseuille/duct.toml"), &[], false),
        row("neutral-disc-in-couette", shipped!("neutral-disc-in-couette/case.toml"), &[], false),
        row("channel-cylinder 2D-1", shipped!("channel-cylinder/steady.toml"), &[], false),
        row("channel-cylinder 2D-2", shipped!("channel-cylinder/case.toml"), &[], false),
        row("oscillating-cylinder", shipped!("oscillating-cylinder/case.toml"), &[], false),
        row(
            "settling-disc N 16",
            settling,
            &["domain.cells=[128,384]", "measure.0.tolerance=0.01"],
            false,
        ),
        row("settling-disc heavier", shipped!("settling-disc/heavier.toml"), &[], false),
        row("approach", shipped!("approach/case.toml"), &[], false),
        row("settling-sphere Re 11.6", SPHERE, &[], false),
        row("settling-cube", shipped!("settling-cube/case.toml"), &[], false),
        row("sphere-in-couette", shipped!("sphere-in-couette/case.toml"), &[], false),
        row("ellipse-in-shear", shipped!("ellipse-in-shear/case.toml"), &[], false),
        row("settling-ellipse", shipped!("settling-ellipse/case.toml"), &[], false),
        row("square-cylinder", shipped!("square-cylinder/case.toml"), &[], false),
        row("jeffery 2D r 2", shipped!("jeffery/case.toml"), &[], false),
        row("sphere-stream unbounded", shipped!("sphere-stream/unbounded.toml"), &[], false),
    ]
}

/// A sphere that settles in the other oils of the experiment.
fn settling_in_oils() -> [Row; 3] {
    // Density (kg/m3) and viscosity (Pa s) of the oils, time to run for (s) and speed measured
    // (m/s): settling_sphere.csv.
    let oils = [
        ("1.5", 970.0, 0.373, 2.0, 0.03599),
        ("4.1", 965.0, 0.212, 1.65, 0.05718),
        ("31.9", 960.0, 0.058, 1.0, 0.12224),
    ];
    oils.map(|(re, density, viscosity, end, speed)| {
        let set = [
            format!("fluid.density={density:?}"),
            format!("fluid.viscosity={viscosity:?}"),
            format!("time.end={end:?}"),
            format!("measure.0.reference={speed:?}"),
        ];
        Row {
            name: format!("settling-sphere Re {re}"),
            text: SPHERE,
            set: set.into(),
            quick: false,
        }
    })
}

/// A sphere of a thousandth of the fluid's density.
fn sphere_without_mass() -> Row {
    let mut light = vec![
        "particle.0.density=1.0".to_owned(),
        "time.step=0.0007".into(),
        "time.end=0.01414".into(),
    ];
    for (k, (time, speed)) in
        [(0.0007, 0.013644), (0.007, 0.13539), (0.014, 0.26953)].into_iter().enumerate()
    {
        light.push(format!("measure.{k}.when.time={time:?}"));
        light.push(format!("measure.{k}.reference={speed:?}"));
        light.push(format!("measure.{k}.tolerance=0.05"));
    }
    Row { name: "sphere-let-go s 0.001".into(), text: LET_GO, set: light, quick: false }
}

/// The spin of a spheroid in shear with its axis along the flow and across it.
fn spheroids_in_shear() -> [Row; 2] {
    let spheroid = shipped!("jeffery/spheroid.toml");
    [("along", 0, 0.2), ("across", 90, 0.8)].map(|(place, degrees, spin)| {
        let set = vec![
            format!("particle.0.orientation.degrees={degrees}"),
            format!("particle.0.spin=[0.0,0.0,-{spin:?}]"),
            "domain.cells=[64,96,48]".into(),
            "time.end=0.1".into(),
            format!(
                "measure=[{{name=\"spin\",kind=\"spin\",when={{time=0.095}},reference=-{spin:?},\
                tolerance=0.03,source=\"Jeffery 1922, exact without walls and inertia\"}}]"
            ),
        ];
        let name = format!("jeffery 3D r 2 {place}");
        Row { name, text: spheroid, set, quick: false }
    })
}

/// The wake of a cylinder at the other Reynolds numbers of its references.
fn wakes_at_other_reynolds_numbers() -> Vec<Row> {
    let others = cylinder_reference("cd").into_iter().filter(|(re, _)| *re != 100.0);
    let rows = others.map(|(re, cd)| {
        let column =
            |name: &str| cylinder_reference(name).into_iter().find(|r| r.0 == re).map(|r| r.1);
        let (end, from) = if re < 50.0 { (25.0, 24.0) } else { (40.0, 20.0) };
        let mut set =
            vec![format!("fluid.viscosity={:?}", 200.0 / re), format!("time.end={end:?}")];
        // A steady wake has no frequency, and a lift of 0 is no reference.
        let references = [Some(cd), column("st"), column("cl_amplitude").filter(|v| *v > 0.0)];
        for (k, reference) in references.into_iter().enumerate() {
            set.push(format!("measure.{k}.from={from:?}"));
            set.extend(reference.map(|v| format!("measure.{k}.reference={v:?}")));
        }
        Row { name: format!("cylinder-wake Re {re}"), text: WAKE, set, quick: re == 20.0 }
    });
    rows.collect()
}
