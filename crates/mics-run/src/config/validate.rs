//! The rules of a case that its types cannot say: ranges, lengths, contradictions, geometry. Each
//! refusal names the key and what would be right. Stability limits belong to the scene.

mod boundary;
mod measures;

use super::particle::{Overlap, overlap, particle};
use super::*;
use crate::config::fault::{AXES, Check, Within, not_negative, positive, vector};
pub(in crate::config) use measures::{measures, name_particles};

/// Checks what the types leave open; the first refusal is returned. [`measures()`] comes later:
/// their particles may be of swarms.
pub(in crate::config) fn validate(case: &Case) -> Check {
    let plain = case.name.chars().all(|c| c.is_ascii_alphanumeric() || "-_.".contains(c));
    let holds = plain && !["", ".", ".."].contains(&case.name.as_str());
    ensure!(
        holds,
        "name",
        "\"{}\" cannot name a folder: use letters, digits, `-`, `_` and `.`",
        case.name
    );
    domain(&case.domain).within("domain")?;
    let dimension = case.dimension();
    fluid(&case.fluid, dimension).within("fluid")?;
    boundary::boundary(case)?;
    for (index, body) in case.particle.iter().enumerate() {
        particle(case, body, index).within(format_args!("particle.{index}"))?;
    }
    if let Some(Overlap { first, second, words }) = overlap(case) {
        ensure!(
            false,
            format!("particle.{second}.position"),
            "particle {second} overlaps particle {first}: {words}"
        );
    }
    for (index, swarm) in case.swarm.iter().enumerate() {
        swarm.check(case, index).within(format_args!("swarm.{index}"))?;
    }
    if let Some(contact) = &case.contact {
        contact.check().within("contact")?;
    }
    if let Some(drive) = &case.drive {
        drive.check(case).within("drive")?;
    }
    if let Some(statistics) = &case.statistics {
        statistics.check(case).within("statistics")?;
    }
    for (index, probe) in case.probe.iter().enumerate() {
        probe.check(case, index).within(format_args!("probe.{index}"))?;
    }
    initial(case).within("initial")?;
    if case.coupling.wall == WallRule::Sharp {
        long_cells(case)?;
    }
    case.time.check(case).within("time")?;
    case.output.check(case).within("output")?;
    pressure(&case.pressure).within("pressure")
}

/// Checks the fluid.
fn fluid(fluid: &Fluid, dimension: usize) -> Check {
    positive("density", fluid.density, "kg/m3")?;
    not_negative("viscosity", fluid.viscosity, "Pa s")?;
    if fluid.gravity.is_empty() {
        return Ok(());
    }
    vector("gravity", &fluid.gravity, dimension, "m/s2")
}

/// Checks the initial state.
fn initial(case: &Case) -> Check {
    if !case.initial.velocity.is_empty() {
        vector("velocity", &case.initial.velocity, case.dimension(), "m/s")?;
    }
    not_negative("perturbation", case.initial.perturbation, "m/s")?;
    positive("taylor_green", case.initial.taylor_green, "m/s")?;
    let periodic = case.sides().all(|(_, side)| *side == Side::Periodic);
    let holds = case.initial.taylor_green.is_none() || periodic;
    ensure!(holds, "taylor_green", "a vortex of Taylor and Green is periodic: all sides must be");
    if let Some(axis) = case.initial.couette {
        axis.check("couette", case.dimension())?;
        let mut pair = case.boundary.ends(axis.index());
        let walls = pair.all(|s| matches!(s, Side::Wall | Side::MovingWall(_)));
        let mut pair = case.boundary.ends(axis.index());
        let moves = pair.any(|s| matches!(s, Side::MovingWall(_)));
        let x = AXES[axis.index()];
        let cure = "make one of its two sides { moving_wall = [...] }, and both walls";
        ensure!(walls && moves, "couette", "no walls shear the fluid along {x}: {cure}");
    }
    Ok(())
}

/// Checks the stopping rule of the pressure equation.
fn pressure(chosen: &Pressure) -> Check {
    let &Pressure { divergence_limit, tightening, max_iterations, .. } = chosen;
    positive("divergence_limit", divergence_limit, "1/s")?;
    let holds = tightening > 0.0 && tightening <= 1.0;
    ensure!(holds, "tightening", "must be above 0 and at most 1, not {tightening:?}");
    ensure!(max_iterations >= 1, "max_iterations", "must be at least 1");
    if let History::Every(often) = chosen.history {
        often.check("history")?;
    }
    Ok(())
}

/// Largest aspect ratio of cells beside sharp surfaces; measured, 6 holds too, and 8 feeds energy
/// to the flow.
const LONGEST_CELLS: f64 = 4.0;

/// Refuses long cells beside sharp surfaces, whose velocity profile has one spacing for all axes.
fn long_cells(case: &Case) -> Check {
    let spacings =
        case.domain.size.iter().zip(&case.domain.cells).map(|(size, cells)| size / *cells as f64);
    let (least, most) =
        spacings.fold((f64::INFINITY, 0.0f64), |(least, most), h| (least.min(h), most.max(h)));
    let holds = (case.particle.is_empty() && case.swarm.is_empty() && case.obstacle.is_empty())
        || most <= LONGEST_CELLS * (1.0 + 1e-9) * least;
    ensure!(
        holds,
        "domain.cells",
        "make cells {:.1} times as long as wide, and sharp surfaces hold up to {LONGEST_CELLS}: \
        choose other numbers of cells, or coupling.wall = \"mixing\"",
        most / least
    );
    Ok(())
}

/// Checks the size of the box and its cells.
fn domain(domain: &Domain) -> Check {
    let sizes = domain.size.len();
    let counts = domain.cells.len();
    let holds = sizes == 2 || sizes == 3;
    ensure!(holds, "size", "needs 2 numbers (m) for a 2D case or 3 for a 3D one, not {sizes}");
    ensure!(
        counts == sizes,
        "cells",
        "needs {sizes} numbers, one for each in domain.size, not {counts}"
    );
    for (axis, (&size, &cells)) in domain.size.iter().zip(&domain.cells).enumerate() {
        positive(&format!("size.{axis}"), size, "m")?;
        let key = format!("cells.{axis}");
        ensure!(
            cells >= 6,
            key,
            "must be at least 6 (the stencil reaches 3 cells to either side), not {cells}"
        );
    }
    let total = domain.cells.iter().try_fold(1_usize, |total, cells| total.checked_mul(*cells));
    let holds = total.is_some_and(|total| total < 1 << 31);
    ensure!(
        holds,
        "cells",
        "make 2^31 cells or more, which is more than can be numbered: use fewer"
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box of 4 by 1 (by 1) m, periodic along x, with walls elsewhere, and these further keys.
    fn refusal(dimension: usize, keys: &str) -> Option<(String, String)> {
        let size = &[4.0, 1.0, 1.0][..dimension];
        let cells = &[32, 8, 8][..dimension];
        let lids = if dimension == 3 { "bottom = \"wall\"\ntop = \"wall\"" } else { "" };
        let text = format!(
            "name = \"box\"\ntime.end = 1.0\ndomain = {{ size = {size:?}, cells = {cells:?} }}\n\
            fluid = {{ density = 1.0, viscosity = 0.1 }}\n{keys}\n\
            [boundary]\nwest = \"periodic\"\neast = \"periodic\"\nsouth = \"wall\"\n\
            north = \"wall\"\n{lids}"
        );
        let case = toml::from_str(&text).unwrap();
        validate(&case)
            .and_then(|()| super::contact::pairs(&case))
            .and_then(|()| measures(&case))
            .err()
            .map(|fault| (fault.key, fault.message))
    }

    fn discs(places: &[[f64; 2]]) -> String {
        let disc = |[x, y]: &[f64; 2]| {
            format!(
                "{{ shape = {{ disc = {{ diameter = 0.2 }} }}, motion = \"fixed\", position = \
                [{x:?}, {y:?}] }}"
            )
        };
        format!("particle = [{}]", places.iter().map(disc).collect::<Vec<_>>().join(", "))
    }

    #[test]
    fn bodies_may_touch_each_other_and_the_walls() {
        assert_eq!(refusal(2, &discs(&[[1.0, 0.1], [1.2, 0.1], [1.0, 0.9], [0.0, 0.5]])), None);
    }

    #[test]
    fn held_bodies_may_overlap() {
        let settled = discs(&[[1.0, 0.0999], [1.1999, 0.0999]]);
        assert_eq!(refusal(2, &settled), None);
        let (key, _) =
            refusal(2, &settled.replace("\"fixed\"", "\"free\", density = 2.0")).unwrap();
        assert_eq!(key, "particle.0.position");
    }

    #[test]
    fn overlap_message_has_least_distance() {
        let (_, message) = refusal(2, &discs(&[[1.0, 0.5], [1.19, 0.5]])).unwrap();
        assert!(message.contains("must be 0.196 m or more"), "{message}");
        assert_eq!(refusal(2, &discs(&[[1.0, 0.5], [1.1961, 0.5]])), None);
    }

    #[test]
    fn bodies_that_overlap_across_the_periodic_faces_are_refused() {
        let (key, message) = refusal(2, &discs(&[[3.95, 0.5], [2.0, 0.5], [0.05, 0.5]])).unwrap();
        assert_eq!(key, "particle.2.position");
        assert!(message.contains("overlaps particle 0") && message.contains("0.1"), "{message}");
    }

    #[test]
    fn body_may_cross_periodic_side_but_not_wall() {
        assert_eq!(refusal(2, &discs(&[[3.99, 0.5]])), None);
        let (key, message) = refusal(2, &discs(&[[2.0, 0.95]])).unwrap();
        assert_eq!(key, "particle.0.position");
        assert!(message.contains("particle 0") && message.contains("0 to 1.0 m"), "{message}");
        assert!(refusal(2, &discs(&[[4.0, 0.5]])).unwrap().1.contains("0 <= x < 4.0"));
    }

    #[test]
    fn overlap_check_of_thousands_of_bodies_is_fast() {
        let places: Vec<[f64; 2]> =
            (0..3000).map(|i| [f64::from(i / 300), 1e-3 + 1e-3 * f64::from(i % 300)]).collect();
        let mut case: Case = toml::from_str(
            "name = \"box\"\ntime.end = 1.0\ndomain = { size = [16.0, 1.0], cells = [128, 16] }\n\
            fluid = { density = 1.0, viscosity = 0.1 }\n\
            boundary = { west = \"periodic\", east = \"periodic\", south = \"wall\", north = \
            \"wall\" }",
        )
        .unwrap();
        case.particle = places
            .iter()
            .map(|place| Particle {
                name: None,
                shape: Typed::Disc(Round { diameter: 1e-3 }).into(),
                orientation: None,
                density: None,
                viscosity: None,
                position: place.to_vec(),
                motion: Motion::Fixed,
                velocity: None,
                spin: None,
                locked: Vec::new(),
                material: None,
                enter: None,
            })
            .collect();
        let start = crate::cpu::thread_seconds();
        assert!(validate(&case).is_ok());
        let spent = crate::cpu::thread_seconds() - start;
        assert!(spent < 0.5, "{spent} s");
    }

    #[test]
    fn cells_much_longer_than_wide_are_refused_beside_sharp_walls() {
        let long = |keys: &str| {
            let text = format!(
                "name = \"box\"\ntime.end = 1.0\n\
                domain = {{ size = [4.0, 1.0], cells = [32, 40] }}\n\
                fluid = {{ density = 1.0, viscosity = 0.1 }}\n{keys}\n[boundary]\n\
                west = \"periodic\"\neast = \"periodic\"\nsouth = \"wall\"\nnorth = \"wall\"\n"
            );
            validate(&toml::from_str(&text).unwrap()).err().map(|fault| (fault.key, fault.message))
        };
        let (key, message) = long(&discs(&[[1.0, 0.5]])).unwrap();
        assert!(
            key == "domain.cells" && message.contains("5.0 times as long as wide"),
            "{message}"
        );
        assert_eq!(
            long(&("coupling.wall = \"mixing\"\n".to_owned() + &discs(&[[1.0, 0.5]]))),
            None
        );
        assert_eq!(long(""), None, "no particles, no walls of theirs");
    }

    #[test]
    fn keys_of_other_dimension_are_refused() {
        let sphere = "particle = [{ shape = { sphere = { diameter = 0.2 } }, position = [1.0, 0.5, \
            0.5], motion = ";
        let spun = |spin: &str| format!("{sphere} {{ prescribed = {{ spin = {spin} }} }} }}]");
        assert_eq!(refusal(3, &spun("[0, 0, 1.0]")), None);
        assert_eq!(refusal(3, &spun("1.0")).unwrap().0, "particle.0.motion.prescribed.spin");
        assert_eq!(refusal(2, &spun("1.0")).unwrap().0, "particle.0.shape");
        assert_eq!(refusal(3, "initial.velocity = [1.0, 0.0]").unwrap().0, "initial.velocity");
    }

    #[test]
    fn initial_couette_flow_needs_a_moving_wall() {
        assert_eq!(refusal(2, "initial.couette = \"y\"").unwrap().0, "initial.couette");
        assert_eq!(refusal(2, "initial.couette = \"z\"").unwrap().0, "initial.couette");
    }

    #[test]
    fn coefficient_measure_needs_particle_and_speed() {
        let drag = "measure = [{ name = \"drag\", kind = \"drag_coefficient\" }]\n";
        assert_eq!(refusal(2, drag).unwrap().0, "measure.0.particle");
        let still = drag.to_owned() + &discs(&[[1.0, 0.5]]);
        assert_eq!(refusal(2, &still).unwrap().0, "measure.0.speed");
        assert_eq!(refusal(2, &(still + "\ninitial.velocity = [1.0, 0.0]")), None);
        assert_eq!(refusal(2, "measure = [{ name = \"top\", kind = \"max_speed\" }]"), None);
    }
}
