use std::path::{Path, PathBuf};

use super::*;

/// Potential flow past a disc, with its mirror flow inside the disc, so that nothing but the disc
/// itself stops a line.
fn flow_past_a_disc(cells: [usize; 2], size: [f64; 2]) -> Plane {
    let disc = Disc {
        centre: [0.3 * size[0], 0.5 * size[1]],
        radius: 0.1 * size[1],
        shade: 0.5,
        ..Disc::default()
    };
    let labels = ["x (m)".to_owned(), "y (m)".to_owned()];
    let mut plane = Plane {
        cells,
        size,
        discs: vec![disc.clone()],
        labels,
        title: "a < b & c".to_owned(),
        ..Plane::default()
    };
    for k in 0..cells[0] * cells[1] {
        let centre = |k: usize, axis: usize| (k as f64 + 0.5) * size[axis] / cells[axis] as f64;
        let x = centre(k % cells[0], 0) - disc.centre[0];
        let y = centre(k / cells[0], 1) - disc.centre[1];
        let square = x * x + y * y;
        let part = disc.radius.powi(2) / (x * x + y * y).max(1e-12);
        plane.velocity[0].push(1.0 - part * (x * x - y * y) / square.max(1e-12));
        plane.velocity[1].push(-2.0 * part * x * y / square.max(1e-12));
        plane.values.push(y * (-square / 0.1).exp());
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

fn written(draw: impl Fn(&Path) -> mics_run::Result<[PathBuf; 2]>) -> ([u32; 2], String) {
    let folder = tempfile::tempdir().unwrap();
    let [png, svg] = draw(&folder.path().join("re1.5")).unwrap();
    assert!(png.ends_with("re1.5.png") && svg.ends_with("re1.5.svg"));
    let text = std::fs::read_to_string(svg).unwrap();
    assert_well_formed(&text);
    (png_size(&png), text)
}

#[test]
fn field_figure_as_png_and_svg_with_embedded_image() {
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
fn constant_and_empty_fields_are_drawn() {
    let good = flow_past_a_disc([24, 12], [2.0, 1.0]);
    for value in [0.0, f64::NAN, f64::INFINITY] {
        let values = vec![value; good.values.len()];
        let plane = Plane { velocity: [values.clone(), values.clone()], values, ..good.clone() };
        assert!(trace::streamlines(&plane, 0.1).is_empty());
        written(|stem| vorticity(&plane, stem));
        written(|stem| streamlines(&plane, stem));
    }
    let mut holed = good.clone();
    holed.velocity[0].iter_mut().step_by(7).for_each(|u| *u = f64::NAN);
    written(|stem| vorticity(&holed, stem));
    for cells in [[24, 1], [1, 24], [1, 1]] {
        let plane = flow_past_a_disc(cells, cells.map(|count| count as f64));
        written(|stem| vorticity(&plane, stem));
    }
}

#[test]
fn plane_with_wrong_value_count_is_an_error() {
    let plane = Plane { cells: [2, 2], size: [1.0, 1.0], ..Plane::default() };
    for draw in [vorticity, streamlines] {
        let message = draw(&plane, Path::new("figures/wake")).unwrap_err().to_string();
        assert!(message.starts_with("figures/wake: "), "{message}");
        assert!(draw(&Plane::default(), Path::new("wake")).is_err());
    }
    let message =
        curves(&Axes::default(), &[], Path::new("/no/such/folder/cd")).unwrap_err().to_string();
    assert!(message.starts_with("/no/such/folder/cd.png: "), "{message}");
}

#[test]
fn streamlines_are_spaced_and_outside_discs() {
    let plane = flow_past_a_disc([160, 64], [4.0, 1.6]);
    let separation = 0.09;
    let lines = trace::streamlines(&plane, separation);
    assert!(lines.len() > 12, "{}", lines.len());
    assert_eq!(lines, trace::streamlines(&plane, separation));
    let distance = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    let Disc { centre, radius, .. } = plane.discs[0].clone();
    for (index, line) in lines.iter().enumerate() {
        for pair in line.windows(2) {
            for part in [0.0, 0.25, 0.5, 0.75, 1.0] {
                let at = [0, 1].map(|k| pair[0][k] + part * (pair[1][k] - pair[0][k]));
                assert!(distance(at, centre) > radius, "{at:?} is in the disc");
                assert!(
                    (0..2).all(|k| (-1e-12..=plane.size[k] + 1e-12).contains(&at[k])),
                    "{at:?} is outside"
                );
            }
            let mut others = lines[..index].iter().flatten();
            // The last point of a line lies on the edge, which may be nearer.
            assert!(others.all(|other| distance(*other, pair[0]) > 0.4 * separation));
        }
    }
}

#[test]
fn streamlines_of_vortex_are_closed() {
    let mut plane = flow_past_a_disc([64, 64], [1.0, 1.0]);
    plane.discs.clear();
    for k in 0..64 * 64 {
        plane.velocity[0][k] = 31.5 - (k / 64) as f64;
        plane.velocity[1][k] = (k % 64) as f64 - 31.5;
    }
    let lines = trace::streamlines(&plane, 0.05);
    assert!(lines.iter().filter(|line| line.first() == line.last()).count() > 5);
}

#[test]
fn curves_have_gaps_outside_their_axes() {
    let series = |label: &str, points: &[(f64, f64)], style| Series {
        label: label.to_owned(),
        points: points.to_vec(),
        style,
    };
    let points =
        [(0.1, 240.0), (1.0, 27.0), (f64::NAN, 1.0), (-1.0, 3.0), (10.0, 4.0), (100.0, 1.1)];
    let styles = [SeriesStyle::Line, SeriesStyle::Dashed, SeriesStyle::Markers];
    let all = styles.map(|style| series("drag", &points, style));
    let axes = Axes { x_label: "Re".to_owned(), log_x: true, log_y: true, ..Axes::default() };
    let (_, svg) = written(|stem| curves(&axes, &all, stem));
    assert_eq!(svg.matches(">\ndrag\n<").count(), 3);
    assert!(
        [">\n0.1\n<", ">\n100\n<"].iter().all(|label| svg.contains(label)),
        "decades are plain numbers"
    );
    for points in [
        &[][..],
        &[(1.0, 2.0)],
        &[(0.0, 0.0), (1.0, 0.0)],
        &[(f64::NAN, f64::NAN)],
        &[(1e300, -1e300), (0.0, 1e-300)],
    ] {
        for style in styles {
            written(|stem| curves(&Axes::default(), &[series("", points, style)], stem));
            written(|stem| curves(&axes, &[series("", points, style)], stem));
        }
    }
}

#[test]
fn legend_placed_off_the_curves() {
    // Width of the figure, and where its legend's text begins.
    let legend = |points: Vec<(f64, f64)>| {
        let one = [Series { label: "legend".into(), points, style: SeriesStyle::Line }];
        let ([width, _], svg) = written(|stem| curves(&Axes::default(), &one, stem));
        let text =
            svg.split(">\nlegend\n<").next().unwrap().rsplit_once("<text ").unwrap().1.to_owned();
        let place = |axis: &str| -> f64 {
            text.split_once(&format!("{axis}=\""))
                .unwrap()
                .1
                .split('"')
                .next()
                .unwrap()
                .parse()
                .unwrap()
        };
        (width, place("x"), place("y"))
    };
    let (narrow, high_right, high) = legend(vec![(0.0, 1.0), (0.1, 0.0), (2.0, 0.0)]);
    let (same, low_right, low) = legend(vec![(0.0, 0.0), (0.1, 1.0), (2.0, 1.0)]);
    assert_eq!((narrow, high_right), (same, low_right));
    assert!(low > high, "{low} is below {high}");
    // A curve that fills the plot.
    let (wide, beside, _) = legend((0..400).map(|k| (f64::from(k), f64::from(k % 2))).collect());
    assert!(wide > narrow + 50 && beside > high_right, "{wide}, {beside}");
}

#[test]
fn thinned_history_keeps_extremes() {
    let points = (0..200_000)
        .map(|k| (f64::from(k), if k == 77_777 { 9.0 } else { f64::from(k % 2) }))
        .collect();
    let history = Series { label: String::new(), points, style: SeriesStyle::Line };
    let (_, svg) = written(|stem| curves(&Axes::default(), std::slice::from_ref(&history), stem));
    assert!(svg.len() < 200_000, "{}", svg.len());
}

/// A hill of positive vorticity on the left and one of negative on the right, with a disc in the
/// middle.
fn two_hills(height: f64) -> Plane {
    let mut plane = flow_past_a_disc([80, 40], [2.0, 1.0]);
    plane.discs = vec![Disc { centre: [1.0, 0.5], radius: 0.12, shade: 1.0, ..Disc::default() }];
    for (cell, value) in plane.values.iter_mut().enumerate() {
        let [x, y] = [(cell % 80) as f64 + 0.5, (cell / 80) as f64 + 0.5].map(|k| k / 40.0);
        let hill = |from: f64| (-((x - from).powi(2) + (y - 0.5).powi(2)) / 0.08).exp();
        *value = height * (hill(0.5) - hill(1.5));
    }
    plane
}

/// The places of every polyline of the width of a contour line in a figure's text.
fn isolines(svg: &str) -> Vec<Vec<[f64; 2]>> {
    let lines = svg.split("<polyline").skip(1).filter(|tag| tag.contains("stroke-width=\"2\""));
    let number = |text: &str| text.parse().unwrap();
    let points =
        |tag: &str| tag.split_once("points=\"").unwrap().1.split('"').next().unwrap().to_owned();
    let places = |text: String| {
        text.split_whitespace()
            .map(|at| at.split_once(',').unwrap())
            .map(|(x, y)| [number(x), number(y)])
            .collect()
    };
    lines.map(points).map(places).collect()
}

#[test]
fn vorticity_contours_solid_and_dashed() {
    let plane = two_hills(100.0);
    let (_, svg) =
        written(|stem| vorticity_strip(std::slice::from_ref(&plane), "hills", Some(20.0), stem));
    let lines = isolines(&svg);
    let span = |line: &[[f64; 2]], k: usize| {
        let along = || line.iter().map(|at| at[k]);
        (along().fold(f64::INFINITY, f64::min), along().fold(0.0, f64::max))
    };
    let size = |line: &[[f64; 2]]| {
        (0..2).map(|k| span(line, k)).map(|(low, high)| high - low).fold(0.0, f64::max)
    };
    let longest = |part: &dyn Fn(f64) -> bool| {
        lines.iter().filter(|l| part(span(l, 0).0)).map(|l| size(l)).fold(0.0, f64::max)
    };
    // The panel is 3 x 1200 wide, its middle at half of that; the colour bar is right of it.
    let middle = 2100.0;
    let whole = lines.iter().filter(|l| span(l, 0).1 < middle && l.first() == l.last()).count();
    assert_eq!(whole, 4, "20, 40, 60, 80 are one closed line each");
    assert!(longest(&|x| x < middle) > 600.0);
    let right = |x: f64| (middle..3850.0).contains(&x);
    assert!(longest(&right) < 20.0, "dashes, {}", longest(&right));
    assert!(lines.iter().filter(|l| right(span(l, 0).0)).count() > 100);
}

#[test]
fn strip_panels_share_colours_and_refuse_dense_contours() {
    let panels = [0.1, 0.2, 0.3]
        .map(|time: f64| Plane { title: format!("t = {time} s"), ..two_hills(100.0 * time) });
    let ([width, height], svg) = written(|stem| vorticity_strip(&panels, "hills", None, stem));
    assert!((700..1000).contains(&width) && (1000..1200).contains(&height), "{width} x {height}");
    assert!(
        ["(a) t = 0.1 s", "(b) t = 0.2 s", "(c) t = 0.3 s"].iter().all(|label| svg.contains(label))
    );
    assert!(svg.contains("contour lines every 5 1/s"), "a quarter of what is common, rounded");
    let (_, svg) = written(|stem| streamlines_strip(&panels, "hills", stem));
    assert!(svg.contains("hills: streamlines") && svg.contains("(c) t = 0.3 s"));
    let said =
        vorticity_strip(&panels, "hills", Some(1e-3), Path::new("wake")).unwrap_err().to_string();
    assert!(said.contains("every 0.001 1/s") && said.contains("--interval 5"), "{said}");
    for none in [&[][..], &[Plane::default()]] {
        assert!(vorticity_strip(none, "", None, Path::new("wake")).is_err());
        assert!(streamlines_strip(none, "", Path::new("wake")).is_err());
    }
}

#[test]
fn window_labels_and_falling_axis() {
    let plane = Plane { corner: [10.0, 3.0], ..flow_past_a_disc([40, 20], [2.0, 1.0]) };
    let (_, svg) =
        written(|stem| vorticity_strip(std::slice::from_ref(&plane), "part", None, stem));
    assert!([">\n10.0\n<", ">\n12.0\n<", ">\n3.0\n<"].iter().all(|label| svg.contains(label)));
    let line = [Series {
        label: "a".into(),
        points: vec![(0.0, 0.0), (5.0, 1.0)],
        style: SeriesStyle::Line,
    }];
    let place = |falling_x: bool, label: &str| {
        let (_, svg) = written(|stem| curves(&Axes { falling_x, ..Axes::default() }, &line, stem));
        let before = svg
            .split(&format!(">\n{label}\n<"))
            .next()
            .unwrap()
            .rsplit_once("<text x=\"")
            .unwrap()
            .1
            .to_owned();
        before.split('"').next().unwrap().parse::<f64>().unwrap()
    };
    assert!(place(false, "1") < place(false, "4") && place(true, "1") > place(true, "4"));
}

#[test]
fn line_colours_are_distinct_and_overlaps_dashed() {
    let line = |offset: f64| Series {
        label: String::new(),
        points: (0..20).map(|k| (f64::from(k), offset + f64::from(k * k))).collect(),
        style: SeriesStyle::Line,
    };
    let all: Vec<Series> = (0..15).map(|k| line(10.0 * f64::from(k))).collect();
    let (_, svg) = written(|stem| curves(&Axes::default(), &all, stem));
    let colour = |line: &str| line.split("stroke=\"").nth(1)?.split('"').next().map(str::to_owned);
    let wide = svg
        .split('<')
        .filter(|tag| tag.starts_with("polyline") && tag.contains("stroke-width=\"6\""));
    let colours: std::collections::HashSet<String> = wide.filter_map(colour).collect();
    assert_eq!(colours.len(), 15, "{colours:?}");
    let pieces = |all: &[Series]| {
        let (_, svg) = written(|stem| curves(&Axes::default(), all, stem));
        svg.matches("stroke-width=\"6\"").count()
    };
    assert_eq!(pieces(&[line(0.0), line(90.0)]), 2);
    assert!(pieces(&[line(0.0), line(0.0)]) > 5, "the second one shows the first in its gaps");
}

#[test]
fn chart_layout_below_or_beside() {
    let line = Series {
        label: String::new(),
        points: vec![(0.0, 1.0), (1.0, 2.0)],
        style: SeriesStyle::Line,
    };
    let axes =
        |label: &str| Axes { y_label: label.into(), note: "small print".into(), ..Axes::default() };
    let of = |count: usize, beside: bool| {
        let panels = (0..count).map(|k| (axes(&format!("plot {k}")), vec![line.clone()])).collect();
        let all = Chart { panels, beside };
        written(|stem| chart(&all, stem))
    };
    let ([one, low], _) = of(1, false);
    let ([same, high], svg) = of(3, false);
    let ([wide, _], _) = of(2, true);
    assert!(one == same && high > low && wide > one, "{one} x {low}, {same} x {high}, {wide}");
    assert_eq!(svg.matches("small print").count(), 1);
    assert!((0..3).all(|k| svg.contains(&format!("plot {k}"))));
}
