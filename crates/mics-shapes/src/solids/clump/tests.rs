use super::*;
use crate::scatter::{counted, lattice, scatter};
use std::f64::consts::PI;

fn dumbbell(dimension: usize, apart: f64) -> Clump {
    let at = |x: f64| Vector3::new(x, 0.3, 0.0);
    Clump::new(dimension, &[(at(1.0), 0.5), (at(1.0 + apart), 0.5)]).unwrap()
}

/// Volume `8/3 pi R^3 - pi (4 R + s)(2 R - s)^2/12`, inertia of caps about the axis.
#[test]
fn two_balls_overlapping_have_exact_volume_and_inertia() {
    for s in [0.2, 0.6, 0.999, 1.0] {
        let body = dumbbell(3, s);
        let r = 0.5f64;
        let exact = 8.0 / 3.0 * PI * r.powi(3) - PI * (4.0 * r + s) * (2.0 * r - s).powi(2) / 12.0;
        assert!((body.volume() / exact - 1.0).abs() < 1e-14, "{}", body.volume());
        assert!((body.balls[0].centre + 0.5 * s * Vector3::x()).norm() < 1e-15);
        // About the axis: the discs of each ball from the cap's end to the plane between.
        let t = 0.5 * s;
        let disc = |x: f64| (r.powi(4) * x) - 2.0 / 3.0 * r * r * x.powi(3) + 0.2 * x.powi(5);
        let axial = PI * (disc(r) + disc(t));
        let along = |x: f64| {
            let area = r * r * x.powi(3) / 3.0 - x.powi(5) / 5.0;
            let arm = 0.5 * r * r * x * x - 0.25 * x.powi(4);
            (area, arm, r * r * x - x.powi(3) / 3.0)
        };
        // From -t (the plane) to r, about the place -t.
        let [(area1, arm1, whole1), (area0, arm0, whole0)] = [along(r), along(-t)];
        let square = area1 - area0 + 2.0 * t * (arm1 - arm0) + t * t * (whole1 - whole0);
        let across = 0.5 * axial + 2.0 * PI * square;
        let inertia = Matrix3::from_diagonal(&Vector3::new(axial, across, across));
        let off = (body.inertia() - inertia).norm() / across;
        println!("{s}: inertia {off:.1e} off");
        assert!(off < 1e-14, "{} {inertia}", body.inertia());
    }
    let mass = dumbbell(3, 1.0).volume() / 2.0;
    let inertia = dumbbell(3, 1.0).inertia() / (mass * 0.25);
    assert!((inertia.diagonal() - Vector3::new(0.8, 2.8, 2.8)).norm() < 1e-13);
}

#[test]
fn two_discs_overlapping_have_exact_area_and_inertia() {
    let s = 0.6;
    let r = 0.5f64;
    let body = dumbbell(2, s);
    let angle = (0.5 * s / r).acos();
    let lens = 2.0 * r * r * angle - 0.5 * s * (4.0 * r * r - s * s).sqrt();
    assert!((body.volume() / (2.0 * PI * r * r - lens) - 1.0).abs() < 1e-14);
    let inertia = dumbbell(2, 1.0).inertia();
    let one = PI * r * r;
    assert!((inertia[(2, 2)] - 2.0 * one * (0.5 * r * r + r * r)).abs() < 1e-14);
    assert!((inertia[(0, 0)] - 0.5 * one * r * r).abs() < 1e-14);
}

fn heap(dimension: usize) -> Clump {
    let at = |k: usize| {
        let z = if dimension == 3 { scatter(3 * k + 2) } else { 0.0 };
        0.5 * Vector3::new(scatter(3 * k), scatter(3 * k + 1), z)
    };
    let balls: Vec<_> = (0..7).map(|k| (at(k), 0.3 + 0.15 * scatter(50 + k))).collect();
    Clump::new(dimension, &balls).unwrap()
}

#[test]
fn boxes_of_a_turned_lattice_sum_to_the_clump() {
    for body in [heap(2), heap(3)] {
        let (volume, first) = lattice(&body);
        let parts = counted(&body, if body.dimension == 2 { 40 } else { 16 });
        println!("{}D: {volume:.1e}, {first:.1e}, parts {parts:?}", body.dimension);
        assert!(volume < 1e-13 && first < 1e-13 && parts.0 < 1e-2 && parts.1 < 1e-2);
    }
}

/// Against points of its surface, which are found ball by ball.
#[test]
fn nearest_point_is_the_nearest_free_one() {
    for body in [heap(2), heap(3)] {
        let points = body.surface(0.02);
        let mut inside = 0;
        for k in 0..400 {
            let z = if body.dimension == 3 { scatter(3 * k + 2) } else { 0.0 };
            let point = 0.8 * Vector3::new(scatter(3 * k), scatter(3 * k + 1), z);
            let Nearest { distance, normal } = body.nearest(&point);
            let ways = points.iter().map(|patch| (patch.place - point).norm());
            let least = ways.fold(f64::INFINITY, f64::min);
            // Outside a ball's nearest point may be in no other one.
            assert!((least - distance.abs()).abs() < 0.02, "{point} {least} {distance}");
            let foot = point - distance * normal;
            let depth = body.balls.iter().map(|b| b.radius - (b.centre - foot).norm());
            let depth = depth.fold(f64::NEG_INFINITY, f64::max);
            assert!(depth < 1e-7, "{point}: {depth:e} below the surface");
            inside += usize::from(distance < 0.0);
            let covered = body.balls.iter().any(|b| (b.centre - point).norm() < b.radius);
            assert_eq!(covered, distance < 0.0);
        }
        assert!(inside > 50, "{inside}");
    }
}

#[test]
fn rays_across_the_seam_meet_the_other_ball() {
    let body = dumbbell(3, 1.0);
    // From the angle a to the axis on one ball: to the plane between at 0.5 - 0.5 cos a, and as
    // far again.
    for a in [0.1f64, 0.3, 0.5] {
        let n = Vector3::new(a.cos(), a.sin(), 0.0);
        let foot = Vector3::new(-0.5, 0.0, 0.0) + 0.5 * n;
        let way = body.meets_itself(&foot, &n).unwrap();
        let other = foot + way * n - Vector3::new(0.5, 0.0, 0.0);
        assert!((other.norm() - 0.5).abs() < 1e-12 && way > 0.0, "{way}");
    }
    assert_eq!(body.meets_itself(&Vector3::new(-1.0, 0.0, 0.0), &-Vector3::x()), None);
    assert_eq!(body.meets_itself(&Vector3::new(-0.5, 0.5, 0.0), &Vector3::y()), None);
}

#[test]
fn surface_of_two_balls_has_their_area() {
    let s = 0.6;
    let r = 0.5;
    for (dimension, exact) in
        [(2, 4.0 * r * (PI - (0.5f64 * s / r).acos())), (3, 4.0 * PI * r * (r + 0.5 * s))]
    {
        let area: f64 = dumbbell(dimension, s).surface(0.1).iter().map(|p| p.area).sum();
        println!("area {:.1e} off", area / exact - 1.0);
        assert!((area / exact - 1.0).abs() < 5e-3, "{area} {exact}");
    }
}

#[test]
fn faults_of_clumps_name_the_ball() {
    let fault = |balls: &[(Vector3<f64>, f64)]| Clump::new(3, balls).unwrap_err().0;
    assert!(fault(&[]).contains("one sphere"));
    assert!(fault(&[(Vector3::zeros(), -1.0)]).contains("sphere 1"));
    assert!(fault(&[(Vector3::zeros(), 1.0), (3.0 * Vector3::x(), 1.0)]).contains("sphere 2"));
    // One within another counts nothing.
    let nested = [(Vector3::zeros(), 1.0), (0.2 * Vector3::x(), 0.5), (Vector3::zeros(), 1.0)];
    let body = Clump::new(3, &nested).unwrap();
    assert!(body.parts().len() == 1 && (body.volume() - 4.0 / 3.0 * PI).abs() < 1e-14);
}
