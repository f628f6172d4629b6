//! The numbers of the method as keys of a case, for experiments.

use crate::support::{SHARP, box_case, mics, run};
use std::fs;

#[test]
fn changed_numerics_key_changes_results_and_warns() {
    let dir = tempfile::tempdir().unwrap();
    let (case, out) = (dir.path().join("case.toml"), |name: &str| dir.path().join(name));
    let sides = ["{ inflow = [1.0, 0.0] }", "\"outflow\"", "\"slip\"", "\"slip\""];
    let disc = "[[particle]]\nshape = { disc = { diameter = 0.3 } }\nposition = [0.5, 0.5]\n\
        motion = \"fixed\"\n[time]\nend = 0.05\nstep = 0.01\n[output]\nfigures = false\n\
        [[measure]]\nname = \"drag\"\nkind = \"drag_coefficient\"\nfrom = 0.02\n";
    let text = box_case([1.5, 1.0], [24, 16], 0.05, sides, &format!("{SHARP}{disc}"));
    fs::write(&case, text).unwrap();
    let changed = ["--set", "numerics.slope_image_point=0.5"];
    let drag = |name: &str, more: &[&str]| {
        let summary = run(&case, &out(name), more);
        summary["measures"]["drag"].as_f64().unwrap()
    };
    let (own, other) = (drag("own", &[]), drag("other", &changed));
    println!("drag {own} with the default, {other} with another slope");
    assert!((own - other).abs() > 1e-4 * own, "{own} and {other}");

    let words = "numerics.slope_image_point = 0.5 (default 0.7): results are an experiment";
    let log = |name: &str| fs::read_to_string(out(name).join("log.txt")).unwrap();
    assert!(log("other").contains(words) && !log("own").contains("numerics"), "{}", log("other"));
    let file = case.to_str().unwrap();
    let checked = mics(&["check", file, changed[0], changed[1]]);
    assert!(String::from_utf8_lossy(&checked.stdout).contains(words), "{checked:?}");

    // The case that the run leaves says it as well, and is the same run again.
    let kept = out("other").join("case.toml");
    let text = fs::read_to_string(&kept).unwrap();
    assert!(text.contains("[numerics]\nslope_image_point = 0.5\n"), "{text}");
    let again = run(&kept, &out("again"), &[]);
    assert_eq!(again["measures"]["drag"].as_f64().unwrap(), other);
}
