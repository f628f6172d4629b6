use std::path::{Path, PathBuf};

use super::*;

/// Potential flow past a disc, with its mirror flow inside the disc, so that nothing but the disc itself stops a line.
fn flow_past_a_disc(cells: [usize; 2], size: [f64; 2]) -> Plane {
    let disc = Disc { centre: [0.3 * size[0], 0.5 * size[1]], radius: 0.1 * size[1] };
    let labels = ["x (m)".to_owned(), "y (m)".to_owned()];
    let mut plane = Plane { cells, size, discs: vec![disc], labels, title: "a < b & c".to_owned(), ..Plane::default() };
    for k in 0..cells[0] * cells[1] {
        let centre = |k: usize, axis: usize| (k as f64 + 0.5) * size[axis] / cells[axis] as f64;
        let x = centre(k % cells[0], 0) - disc.centre[0];
        let y = centre(k / cells[0], 1) - disc.centre[1];
        let (square, part) = (x * x + y * y, disc.radius.powi(2) / (x * x + y * y).max(1e-12));
        plane.u.push(1.0 - part * (x * x - y * y) / square.max(1e-12));
        plane.v.push(-2.0 * part * x * y / square.max(1e-12));
        plane.vorticity.push(y * (-square / 0.1).exp());
    }
    plane
}

fn png_size(path: &Path) -> [u32; 2] {
    let bytes = std::fs::read(path).unwrap();
    assert_eq!(&bytes[..8], b"\x89PNG\r\n\x1a\n");
    [16, 20].map(|at| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap()))
}

/// Every tag is closed by its own name.
fn assert_well_formed(svg: &str) {
    let mut open = Vec::new();
    for tag in svg.split('<').skip(1) {
        let (tag, _) = tag.split_once('>').expect("a tag ends");
        let name = tag.trim_start_matches('/').split([' ', '/']).next().unwrap();
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name));
        } else if !tag.ends_with('/') {
            open.push(name);
        }
    }
    assert!(svg.starts_with("<svg") && open.is_empty());
}

fn written(draw: impl Fn(&Path) -> crate::Result<[PathBuf; 2]>) -> ([u32; 2], String) {
    let folder = tempfile::tempdir().unwrap();
    let [png, svg] = draw(&folder.path().join("re1.5")).unwrap();
    assert!(png.ends_with("re1.5.png") && svg.ends_with("re1.5.svg"));
    let text = std::fs::read_to_string(svg).unwrap();
    assert_well_formed(&text);
    (png_size(&png), text)
}

#[test]
fn a_field_becomes_a_png_and_a_small_svg_with_one_embedded_image_for_field_and_bar() {
    let plane = flow_past_a_disc([160, 64], [4.0, 1.6]);
    let ([width, height], svg) = written(|stem| vorticity(&plane, stem));
    assert!((1100..1300).contains(&width) && (450..650).contains(&height), "{width} x {height}");
    assert_eq!(svg.matches("data:image/png;base64,").count(), 2);
    assert!(svg.len() < 1_500_000 && svg.contains("a &lt; b &amp; c"), "{}", svg.len());
    let tall = flow_past_a_disc([16, 48], [1.0, 3.0]);
    let ([width, height], _) = written(|stem| streamlines(&tall, stem));
    assert!(height > width && height < 1200, "{width} x {height}");
}

#[test]
fn fields_that_say_nothing_are_drawn_without_streamlines_or_panics() {
    let good = flow_past_a_disc([24, 12], [2.0, 1.0]);
    for value in [0.0, f64::NAN, f64::INFINITY] {
        let values = vec![value; good.u.len()];
        let plane = Plane { u: values.clone(), v: values.clone(), vorticity: values, ..good.clone() };
        assert!(trace::streamlines(&plane, 0.1).is_empty());
        written(|stem| vorticity(&plane, stem));
        written(|stem| streamlines(&plane, stem));
    }
    let mut holed = good.clone();
    holed.u.iter_mut().step_by(7).for_each(|u| *u = f64::NAN);
    written(|stem| vorticity(&holed, stem));
    for cells in [[24, 1], [1, 24], [1, 1]] {
        let plane = flow_past_a_disc(cells, cells.map(|count| count as f64));
        written(|stem| vorticity(&plane, stem));
    }
}

#[test]
fn a_plane_whose_values_do_not_fill_its_cells_is_an_error_that_names_the_figure() {
    let plane = Plane { cells: [2, 2], size: [1.0, 1.0], ..Plane::default() };
    for draw in [vorticity, streamlines] {
        let message = draw(&plane, Path::new("figures/wake")).unwrap_err().to_string();
        assert!(message.starts_with("figures/wake: "), "{message}");
        assert!(draw(&Plane::default(), Path::new("wake")).is_err());
    }
    let message = curves(&Axes::default(), &[], Path::new("/no/such/folder/cd")).unwrap_err().to_string();
    assert!(message.starts_with("/no/such/folder/cd.png: "), "{message}");
}

#[test]
fn streamlines_stay_in_the_plane_and_apart_and_never_enter_a_disc() {
    let plane = flow_past_a_disc([160, 64], [4.0, 1.6]);
    let separation = 0.09;
    let lines = trace::streamlines(&plane, separation);
    assert!(lines.len() > 12, "{}", lines.len());
    assert_eq!(lines, trace::streamlines(&plane, separation));
    let distance = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    let Disc { centre, radius } = plane.discs[0];
    for (index, line) in lines.iter().enumerate() {
        for pair in line.windows(2) {
            for part in [0.0, 0.25, 0.5, 0.75, 1.0] {
                let at = [0, 1].map(|k| pair[0][k] + part * (pair[1][k] - pair[0][k]));
                assert!(distance(at, centre) > radius, "{at:?} is in the disc");
                assert!((0..2).all(|k| (-1e-12..=plane.size[k] + 1e-12).contains(&at[k])), "{at:?} is outside");
            }
            let mut others = lines[..index].iter().flatten();
            // The last point of a line lies on the edge, which may be nearer.
            assert!(others.all(|other| distance(*other, pair[0]) > 0.4 * separation));
        }
    }
}

#[test]
fn streamlines_of_a_vortex_close() {
    let mut plane = flow_past_a_disc([64, 64], [1.0, 1.0]);
    plane.discs.clear();
    for k in 0..64 * 64 {
        (plane.u[k], plane.v[k]) = (31.5 - (k / 64) as f64, (k % 64) as f64 - 31.5);
    }
    let lines = trace::streamlines(&plane, 0.05);
    assert!(lines.iter().filter(|line| line.first() == line.last()).count() > 5);
}

#[test]
fn curves_show_what_their_axes_can_hold_and_leave_gaps_for_the_rest() {
    let series =
        |label: &str, points: &[(f64, f64)], style| Series { label: label.to_owned(), points: points.to_vec(), style };
    let points = [(0.1, 240.0), (1.0, 27.0), (f64::NAN, 1.0), (-1.0, 3.0), (10.0, 4.0), (100.0, 1.1)];
    let styles = [SeriesStyle::Line, SeriesStyle::Dashed, SeriesStyle::Markers];
    let all = styles.map(|style| series("drag", &points, style));
    let axes = Axes { x_label: "Re".to_owned(), log_x: true, log_y: true, ..Axes::default() };
    let (_, svg) = written(|stem| curves(&axes, &all, stem));
    assert_eq!(svg.matches(">\ndrag\n<").count(), 3);
    assert!([">\n0.1\n<", ">\n100\n<"].iter().all(|label| svg.contains(label)), "decades are plain numbers");
    for points in
        [&[][..], &[(1.0, 2.0)], &[(0.0, 0.0), (1.0, 0.0)], &[(f64::NAN, f64::NAN)], &[(1e300, -1e300), (0.0, 1e-300)]]
    {
        for style in styles {
            written(|stem| curves(&Axes::default(), &[series("", points, style)], stem));
            written(|stem| curves(&axes, &[series("", points, style)], stem));
        }
    }
}

#[test]
fn a_long_history_keeps_its_extremes_in_few_points() {
    let points = (0..200_000).map(|k| (f64::from(k), if k == 77_777 { 9.0 } else { f64::from(k % 2) })).collect();
    let history = Series { label: String::new(), points, style: SeriesStyle::Line };
    let (_, svg) = written(|stem| curves(&Axes::default(), std::slice::from_ref(&history), stem));
    assert!(svg.len() < 200_000, "{}", svg.len());
}
