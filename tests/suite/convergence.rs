//! Observed orders against exact solutions: the Taylor-Green vortex, advection alone, diffusion
//! alone.

use crate::support::{PERIODIC, box_case, order, petsc};
use mics::grid::Coefficient;
use mics::kernels::advection::{self, Carrier, Fluxes};
use mics::kernels::diffusion;
use mics::scene::Scene;
use std::f64::consts::PI;

const STREAM: [f64; 2] = [0.7, 0.3];
const NU: f64 = 0.004;

/// Velocity of a Taylor-Green vortex of unit period, carried by `STREAM`.
fn vortex(x: f64, y: f64, t: f64) -> [f64; 2] {
    let (x, y) = (2.0 * PI * (x - STREAM[0] * t), 2.0 * PI * (y - STREAM[1] * t));
    let decay = (-8.0 * PI * PI * NU * t).exp();
    [STREAM[0] + decay * x.sin() * y.cos(), STREAM[1] - decay * x.cos() * y.sin()]
}

/// Both velocities at t = 0.3 of a vortex that was carried and decayed, and the exact ones.
fn carried_vortex(n: usize, scheme: &str, courant: f64) -> [Vec<f64>; 2] {
    let petsc = petsc();
    let more =
        format!("[time]\nend = 1.0\nscheme = \"{scheme}\"\n[pressure]\ndivergence_limit = 1.0e-8");
    let mut scene: Scene<2> = petsc.scene(&box_case([1.0, 1.0], [n, n], NU, PERIODIC, &more));
    set_vortex(&mut scene);
    scene.start().unwrap();
    let steps = (0.3 * 2.7 * n as f64 / courant).ceil();
    for _ in 0..steps as usize {
        assert!(0.3 / steps < scene.limits().unwrap().tightest().1);
        let done = scene.step(0.3 / steps).unwrap();
        assert!(done.divergence_max < 1e-8);
    }
    let cells = || (0..2).flat_map(|a| scene.domain.grid.rows().flatten().map(move |c| (a, c)));
    let exact = |(a, c): (usize, usize)| {
        let [x, y] = scene.domain.grid.centre(c);
        vortex(x, y, 0.3)[a]
    };
    [cells().map(|(a, c)| scene.state.u[a][c]).collect(), cells().map(exact).collect()]
}

/// Root mean square difference.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    (a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>() / a.len() as f64).sqrt()
}

fn vortex_error(n: usize, scheme: &str, courant: f64) -> f64 {
    let [found, exact] = carried_vortex(n, scheme, courant);
    distance(&found, &exact)
}

fn set_vortex(scene: &mut Scene<2>) {
    for c in scene.domain.grid.rows().flatten() {
        let [x, y] = scene.domain.grid.centre(c);
        let v = vortex(x, y, 0.0);
        scene.state.u.iter_mut().zip(v).for_each(|(u, v)| u[c] = v);
    }
}

#[test]
fn advected_taylor_green_vortex_second_order_with_rk2() {
    let errors = [24, 48, 96].map(|n| vortex_error(n, "rk2", 0.5));
    println!(
        "errors {errors:?}, orders {:.2}, {:.2}",
        order(errors[0], errors[1], 2.0),
        order(errors[1], errors[2], 2.0)
    );
    assert!(order(errors[1], errors[2], 2.0) >= 1.9, "{errors:?}");
}

#[test]
fn advected_vortex_second_order_with_rk3() {
    let errors = [24, 48, 96].map(|n| vortex_error(n, "rk3", 0.8));
    assert!(order(errors[1], errors[2], 2.0) >= 1.9, "{errors:?}");
}

#[test]
fn rk2_and_rk3_second_and_euler_first_order_in_time() {
    // On one grid, so that differences between steps are errors of time alone. With all of the last
    // pressure on the faces, which take the mean of cells otherwise, a term dt h^2 keeps rk2 at
    // 1.44.
    for (scheme, n, largest, expected) in
        [("rk2", 128, 0.5, 1.9), ("rk3", 128, 0.85, 1.9), ("euler", 48, 0.2, 0.9)]
    {
        let [a, b, c] = [1.0, 0.5, 0.25]
            .map(|f| carried_vortex(n, scheme, f * largest))
            .map(|[found, _]| found);
        let observed = order(distance(&a, &b), distance(&b, &c), 2.0);
        println!(
            "{scheme}: {:e}, {:e}, observed order in time {observed:.2}",
            distance(&a, &b),
            distance(&b, &c)
        );
        assert!(observed >= expected, "{scheme}: {observed}");
    }
}

/// A vortex that viscosity takes, in steps of up to 20 times those that viscosity would allow two
/// stages.
#[test]
fn legendre_stages_second_order_in_time_when_diffusion_limited() {
    let petsc = petsc();
    let nu = 0.1;
    let exact = |x: f64, y: f64, t: f64| {
        let decay = (-8.0 * PI * PI * nu * t).exp();
        [
            decay * (2.0 * PI * x).sin() * (2.0 * PI * y).cos(),
            -decay * (2.0 * PI * x).cos() * (2.0 * PI * y).sin(),
        ]
    };
    let end = |scheme: &str, steps: usize| {
        let more = format!(
            "[time]\nend = 1.0\nscheme = \"{scheme}\"\n[pressure]\ndivergence_limit = 1.0e-8"
        );
        let mut scene: Scene<2> = petsc.scene(&box_case([1.0, 1.0], [64, 64], nu, PERIODIC, &more));
        let centres: Vec<_> =
            scene.domain.grid.rows().flatten().map(|c| (c, scene.domain.grid.centre(c))).collect();
        for (c, [x, y]) in &centres {
            let v = exact(*x, *y, 0.0);
            scene.state.u.iter_mut().zip(v).for_each(|(u, v)| u[*c] = v);
        }
        scene.start().unwrap();
        for _ in 0..steps {
            scene.step(0.2 / steps as f64).unwrap();
        }
        let u = &scene.state.u;
        let (found, exact): (Vec<_>, Vec<_>) =
            centres.iter().map(|&(c, [x, y])| (u[0][c], exact(x, y, 0.2)[0])).unzip();
        (distance(&found, &exact) / distance(&exact, &vec![0.0; exact.len()]), found)
    };
    for scheme in ["rkl2", "rkl3"] {
        let [a, b, c] = [16, 32, 64].map(|steps| end(scheme, steps));
        let observed = order(distance(&a.1, &b.1), distance(&b.1, &c.1), 2.0);
        println!(
            "{scheme}: errors {:.2e}, {:.2e}, {:.2e}, order in time {observed:.2}",
            a.0, b.0, c.0
        );
        assert!((1.9..2.3).contains(&observed) && a.0 < 0.01 && c.0 < 2e-3);
    }
}

/// Largest error of the rate `-u.grad u` of one scheme on the vortex itself (`own`), or carried by
/// the stream alone.
fn advection_error(n: usize, scheme: &str, own: bool) -> f64 {
    let petsc = petsc();
    let mut scene: Scene<2> = petsc.scene(&box_case([1.0, 1.0], [n, n], NU, PERIODIC, ""));
    set_vortex(&mut scene);
    scene.domain.boundaries.fill_velocity(&mut scene.state.u).unwrap();
    let grid = scene.domain.grid.clone();
    let mut carrier = grid.vector_field();
    let mut at_faces = grid.vector_field();
    for axis in 0..2 {
        for c in 0..carrier[axis].len() {
            carrier[axis][c] = if own { scene.state.u[axis][c] } else { STREAM[axis] };
        }
        for c in grid.face_rows(axis).flatten() {
            let mut x = grid.centre(c);
            x[axis] -= 0.5 * grid.h[axis];
            at_faces[axis][c] = if own { vortex(x[0], x[1], 0.0)[axis] } else { STREAM[axis] };
        }
    }
    let q = scene.state.u[0].clone();
    let (mut rate, mut scratch) = (grid.field(), grid.field());
    match scheme {
        "conservative" => {
            let (carrier, mut rates) =
                (Carrier { now: &at_faces, before: None }, grid.vector_field());
            let mut fluxes = Fluxes::new(&grid);
            advection::upwind5(
                &grid,
                &carrier,
                &scene.state.u,
                0.0,
                1.0,
                false,
                &mut rates,
                &mut fluxes,
            );
            [rate, _] = rates;
        }
        _ => {
            // One axis at a time, at a step so short that the path's end does not matter: the
            // interpolation's order.
            let dt = 1e-3 / n as f64;
            for axis in 0..2 {
                advection::qsi_sweep(&grid, axis, &carrier[axis], dt, &q, &mut scratch);
                for c in grid.rows().flatten() {
                    // The quadratic term of the path, u^2 dt/2 q'', is exact transport, not error:
                    // take it out.
                    rate[c] += (scratch[c] - q[c]) / dt - path_term(&scene, &carrier, axis, c, dt);
                }
            }
        }
    }
    let mut worst = 0.0f64;
    for c in grid.rows().flatten() {
        let [x, y] = grid.centre(c);
        let (u, (x, y)) = ([carrier[0][c], carrier[1][c]], (2.0 * PI * x, 2.0 * PI * y));
        let exact = -2.0 * PI * (u[0] * x.cos() * y.cos() - u[1] * x.sin() * y.sin());
        worst = worst.max((rate[c] - exact).abs());
    }
    worst
}

/// `u^2 dt/2 d2q/dx2 - u^3 dt^2/6 d3q/dx3` of q = sin cos along an axis.
fn path_term(scene: &Scene<2>, carrier: &[Vec<f64>; 2], axis: usize, c: usize, dt: f64) -> f64 {
    let [x, y] = scene.domain.grid.centre(c).map(|x| 2.0 * PI * x);
    let (k, u) = (2.0 * PI, carrier[axis][c]);
    let second = -k * k * x.sin() * y.cos();
    let third =
        if axis == 0 { -k.powi(3) * x.cos() * y.cos() } else { k.powi(3) * x.sin() * y.sin() };
    0.5 * u * u * dt * second - u.powi(3) * dt * dt / 6.0 * third
}

#[test]
fn advection_is_fifth_order_in_space() {
    for (scheme, own) in [("qsi", true), ("conservative", false), ("qsi", false)] {
        let e = [16, 32, 64].map(|n| advection_error(n, scheme, own));
        let observed = order(e[1], e[2], 2.0);
        println!(
            "{scheme}, {}: {e:?}, order {observed:.2}",
            if own { "vortex by itself" } else { "vortex in a stream" }
        );
        assert!(observed >= 4.5, "{scheme} {own}: {e:?}");
    }
}

#[test]
fn conservative_advection_second_order_in_varying_carrier() {
    let e = [16, 32, 64].map(|n| advection_error(n, "conservative", true));
    assert!((1.9..2.5).contains(&order(e[1], e[2], 2.0)), "{e:?}");
}

#[test]
fn qsi_fifth_order_and_damping_vanishing_with_courant_number() {
    let error = |n: usize, courant: f64| {
        let petsc = petsc();
        let mut scene: Scene<2> = petsc.scene(&box_case([1.0, 1.0], [n, n], NU, PERIODIC, ""));
        set_vortex(&mut scene);
        let grid = scene.domain.grid.clone();
        let start = scene.state.u[0].clone();
        let carrier = [vec![1.0; start.len()], vec![1.0; start.len()]];
        let steps = (n as f64 / courant).round();
        let (mut u, mut out) = (scene.state.u.clone(), grid.vector_field());
        for _ in 0..steps as usize {
            for axis in 0..2 {
                scene.domain.boundaries.fill_velocity(&mut u).unwrap();
                for i in 0..2 {
                    advection::qsi_sweep(
                        &grid,
                        axis,
                        &carrier[axis],
                        1.0 / steps,
                        &u[i],
                        &mut out[i],
                    );
                }
                std::mem::swap(&mut u, &mut out);
            }
        }
        grid.rows().flatten().map(|c| (u[0][c] - start[c]).abs()).fold(0.0, f64::max)
    };
    let e = [16, 32].map(|n| error(n, 0.4));
    assert!(order(e[0], e[1], 2.0) >= 4.5, "{e:?}");
    assert!(error(16, 1.0) < 1e-12, "a whole cell a step is exact");
}

/// u = (sin kx cos ky, -cos kx sin ky) with viscosity 1 + 0.5 sin kx: exact `div(mu (grad u + grad
/// u^T))` along x.
fn stress_error(n: usize, vary: f64) -> f64 {
    let petsc = petsc();
    let mut scene: Scene<2> = petsc.scene(&box_case([1.0, 1.0], [n, n], NU, PERIODIC, ""));
    let grid = scene.domain.grid.clone();
    let k = 2.0 * PI;
    let mut mu = grid.field();
    for c in grid.rows().flatten() {
        let [x, y] = grid.centre(c).map(|x| k * x);
        scene.state.u[0][c] = x.sin() * y.cos();
        scene.state.u[1][c] = -x.cos() * y.sin();
        mu[c] = 1.0 + vary * (x.sin() + y.cos());
    }
    scene.domain.boundaries.fill_velocity(&mut scene.state.u).unwrap();
    scene.domain.boundaries.fill_property(&mut mu).unwrap();
    let (mut rate, mut scratch) = (grid.field(), grid.field());
    diffusion::stress(
        &grid,
        &mu,
        &Coefficient::Uniform(1.0),
        &scene.state.u,
        0,
        1.0,
        &mut rate,
        &mut scratch,
    );
    let mut worst = 0.0f64;
    for c in grid.rows().flatten() {
        let [x, y] = grid.centre(c).map(|x| k * x);
        let mu = 1.0 + vary * (x.sin() + y.cos());
        // mu lap u + 2 dmu/dx du/dx + dmu/dy (du/dy + dv/dx); the last bracket vanishes for this
        // field.
        let shear = -x.sin() * y.sin() + x.sin() * y.sin();
        let exact = k
            * k
            * (-2.0 * mu * x.sin() * y.cos() + 2.0 * vary * x.cos() * x.cos() * y.cos()
                - vary * y.sin() * shear);
        worst = worst.max((rate[c] - exact).abs());
    }
    worst
}

#[test]
fn full_stress_diffusion_second_order_with_variable_viscosity() {
    let e = [16, 32, 64].map(|n| stress_error(n, 0.4));
    assert!(order(e[1], e[2], 2.0) >= 1.9, "{e:?}");
}

#[test]
fn laplacian_equals_full_stress_at_uniform_viscosity() {
    let e = [16, 32, 64].map(|n| stress_error(n, 0.0));
    assert!(order(e[1], e[2], 2.0) >= 1.9, "{e:?}");
    let petsc = petsc();
    let mut scene: Scene<2> = petsc.scene(&box_case([1.0, 1.0], [32, 32], NU, PERIODIC, ""));
    set_vortex(&mut scene);
    scene.domain.boundaries.fill_velocity(&mut scene.state.u).unwrap();
    let grid = &scene.domain.grid;
    let (mut a, mut b, mut scratch) = (grid.field(), grid.field(), grid.field());
    let rho = Coefficient::Uniform(2.0);
    diffusion::stress(grid, &vec![NU; a.len()], &rho, &scene.state.u, 0, 1.0, &mut a, &mut scratch);
    diffusion::laplacian(grid, NU, &rho, &scene.state.u[0], 1.0, &mut b);
    let gap = grid.rows().flatten().map(|c| (a[c] - b[c]).abs()).fold(0.0, f64::max);
    let size = grid.rows().flatten().map(|c| b[c].abs()).fold(0.0, f64::max);
    assert!(gap < 0.02 * size, "{gap} of {size}");
}

/// The 2D vortex in a plane of a 3D box, the third axis idle: 3D must give what 2D gives.
#[test]
fn vortex_decay_in_3d_equals_2d_in_every_plane() {
    let errors = [[0, 1, 2], [1, 2, 0], [2, 0, 1]].map(|[a, b, idle]| {
        let petsc = petsc();
        let n = 16;
        let mut cells = [n; 3];
        cells[idle] = 8;
        let sides: String = ["west", "east", "south", "north", "bottom", "top"]
            .map(|s| format!("{s} = \"periodic\"\n"))
            .concat();
        let mut scene: Scene<3> = petsc.scene(&format!(
            "name = \"t\"\n[domain]\nsize = [1.0, 1.0, 1.0]\ncells = {cells:?}\n[fluid]\n\
            density = 1.0\nviscosity = {NU}\n\
             [boundary]\n{sides}[time]\nend = 1.0\nscheme = \"rk2\"\n[pressure]\n\
                 divergence_limit = 1.0e-8"
        ));
        for c in scene.domain.grid.rows().flatten() {
            let x = scene.domain.grid.centre(c);
            let v = vortex(x[a], x[b], 0.0);
            (scene.state.u[a][c], scene.state.u[b][c], scene.state.u[idle][c]) = (v[0], v[1], 0.0);
        }
        scene.start().unwrap();
        for _ in 0..32 {
            assert!(scene.step(0.3 / 32.0).unwrap().divergence_max < 1e-8);
        }
        let mut square = 0.0;
        for c in scene.domain.grid.rows().flatten() {
            let x = scene.domain.grid.centre(c);
            let exact = vortex(x[a], x[b], 0.3);
            square += (scene.state.u[a][c] - exact[0]).powi(2)
                + (scene.state.u[b][c] - exact[1]).powi(2)
                + scene.state.u[idle][c].powi(2);
        }
        (square / (2 * scene.domain.grid.total_cells()) as f64).sqrt()
    });
    let plane = vortex_error(16, "rk2", 0.3 * 2.7 / 2.0);
    assert!(errors.iter().all(|e| (e - plane).abs() < 1e-3 * plane), "{errors:?} against {plane}");
}
