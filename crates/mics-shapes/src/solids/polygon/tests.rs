use super::*;
use crate::scatter::{counted, feet, lattice};
use std::f64::consts::{PI, TAU};

fn regular(n: usize, radius: f64) -> Vec<[f64; 2]> {
    let at = |k: usize| TAU * k as f64 / n as f64;
    (0..n).map(|k| [radius * at(k).cos(), radius * at(k).sin()]).collect()
}

#[test]
fn square_and_its_rounding_have_exact_moments() {
    let square = [[2.0, 1.0], [3.0, 1.0], [3.0, 2.0], [2.0, 2.0]];
    let body = Polygon::new(&square, 0.0).unwrap();
    assert!((body.volume() - 1.0).abs() < 1e-15 && (body.inertia().m33 - 1.0 / 6.0).abs() < 1e-15);
    assert!((body.thickness() - 1.0).abs() < 1e-15);
    let r = 0.2;
    let body = Polygon::new(&square, r).unwrap();
    assert!((body.volume() - (1.0 - (4.0 - PI) * r * r)).abs() < 1e-14, "{}", body.volume());
    // About its own axis x: the whole less four corners of squares, plus four quarters.
    let c = 0.5 - r;
    let quarter = PI * r.powi(4) / 16.0 + 2.0 * c * r.powi(3) / 3.0 + c * c * PI * r * r / 4.0;
    let corner = r * (0.125 - c.powi(3)) / 3.0;
    let exact = 2.0 * (1.0 / 12.0 - 4.0 * corner + 4.0 * quarter);
    assert!((body.inertia().m33 - exact).abs() < 1e-14, "{} {exact}", body.inertia().m33);
    // Either order.
    let mut back = square;
    back.reverse();
    assert!((Polygon::new(&back, r).unwrap().volume() - body.volume()).abs() < 1e-15);
}

#[test]
fn many_sides_are_a_disc() {
    let n = 64;
    // Radius of a polygon of the unit disc's area.
    let radius = (PI / (0.5 * n as f64 * (TAU / n as f64).sin())).sqrt();
    let body = Polygon::new(&regular(n, radius), 0.0).unwrap();
    assert!((body.volume() - PI).abs() < 1e-13);
    println!("inertia {:.1e} off", body.inertia().m33 / (0.5 * PI) - 1.0);
    assert!((body.inertia().m33 / (0.5 * PI) - 1.0).abs() < 2e-6);
    // All rounded off it is one.
    let inner = (PI / n as f64).cos();
    let body = Polygon::new(&regular(n, 1.0), 0.999999 * inner).unwrap();
    assert!((body.volume() / (PI * inner * inner) - 1.0).abs() < 1e-8);
    assert!((body.inertia().m33 / (0.5 * PI * inner.powi(4)) - 1.0).abs() < 1e-8);
}

#[test]
fn boxes_of_a_turned_lattice_sum_to_the_polygon() {
    let points = [[0.0, 0.0], [2.0, 0.1], [2.4, 1.0], [1.0, 1.8], [0.2, 1.0]];
    for rounding in [0.0, 0.1, 0.4] {
        let body = Polygon::new(&points, rounding).unwrap();
        let (area, first) = lattice(&body);
        let feet = feet(&body, 1.5);
        println!("rounding {rounding}: area {area:.1e}, first moment {first:.1e}, feet {feet:.1e}");
        assert!(area < 1e-13 && first < 1e-13 && feet < 1e-13);
        let parts = counted(&body, 40);
        assert!(parts.0 < 1e-2 && parts.1 < 1e-2, "{rounding}: {parts:?}");
        let around: f64 = body.surface(0.05).iter().map(|patch| patch.area).sum();
        let sides: f64 = body.sides.iter().map(|side| side.length).sum();
        assert!((around - sides - TAU * rounding).abs() < 1e-12);
        let [part] = body.parts() else { panic!() };
        for k in 0..40 {
            let (sin, cos) = f64::from(k).sin_cos();
            let n = Vector3::new(cos, sin, 0.0);
            let reach = part.core.support(&n).dot(&n) + part.rounding;
            let below = body.extent(&n) - reach;
            assert!((-1e-12..0.1).contains(&below) && (rounding == 0.0 || below < 1e-12));
        }
    }
}

#[test]
fn faults_of_polygons_say_what_is_wrong() {
    let fault = |points: &[[f64; 2]], r| Polygon::new(points, r).unwrap_err().0;
    assert!(fault(&[[0.0, 0.0], [1.0, 0.0]], 0.0).contains("three corners"));
    assert!(fault(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], 0.0).contains("three corners"));
    assert!(fault(&[[0.0, 0.0], [1.0, 0.0], [0.0, f64::NAN]], 0.0).contains("corner 3"));
    let dart = [[0.0, 0.0], [2.0, 0.0], [0.5, 0.5], [0.0, 2.0]];
    assert!(fault(&dart, 0.0).contains("(0.5, 0.5) points inwards"));
    let star: Vec<[f64; 2]> = (0..5).map(|k| regular(5, 1.0)[2 * k % 5]).collect();
    assert!(fault(&star, 0.0).contains("cross"));
    assert!(fault(&regular(6, 1.0), 0.9).contains("rounding"));
    assert!(fault(&regular(6, 1.0), -0.1).contains("rounding"));
    // A corner on a side is none.
    let body = Polygon::new(&[[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [0.0, 1.0]], 0.0).unwrap();
    assert_eq!(body.sides.len(), 3);
}
