//! Outlines and heights from files.

use super::heights::Raster;
use crate::config::fault::Fault;
use crate::config::source::Source;

/// The outlines of a CSV file (m), each with the lines of its corners; lengths are multiplied by
/// `factor`.
pub(super) type Lines = Vec<(Vec<[f64; 2]>, Vec<u64>)>;

pub(super) fn outlines(source: &Source, factor: f64) -> Result<Lines, Fault> {
    let numbered = source.header()?.iter().any(|column| column == "outline");
    let columns: &[&str] = if numbered { &["outline", "x", "y"] } else { &["x", "y"] };
    let mut all: Lines = Vec::new();
    let mut number = f64::NAN;
    for (line, row) in source.rows(columns, "corners")? {
        let (own, place) = if numbered { (row[0], &row[1..]) } else { (0.0, &row[..]) };
        if own != number {
            all.push(Default::default());
            number = own;
        }
        if let Some((points, lines)) = all.last_mut() {
            points.push([factor * place[0], factor * place[1]]);
            lines.push(line);
        }
    }
    Ok(all)
}

/// The heights of a file over a line (2D) or a raster (3D) (m).
pub(super) fn heights(source: &Source, dimension: usize, factor: f64) -> Result<Raster, Fault> {
    let grid = source.path.extension().is_some_and(|e| e.eq_ignore_ascii_case("asc"));
    let raster = match (dimension, grid) {
        (2, true) => {
            return Err(
                source.refuse("is a raster over x and y: in 2D give a CSV file with columns x, y")
            );
        }
        (2, false) => line(source)?,
        (_, true) => esri(source)?,
        (_, false) => rows(source)?,
    };
    let times = |all: Vec<f64>| all.into_iter().map(|x| factor * x).collect();
    Ok(Raster { x: times(raster.x), y: times(raster.y), heights: times(raster.heights) })
}

/// A line of x and y.
fn line(source: &Source) -> Result<Raster, Fault> {
    let rows = source.rows(&["x", "y"], "heights")?;
    if let Some(pair) = rows.windows(2).find(|pair| pair[1].1[0] <= pair[0].1[0]) {
        return Err(source.refuse_line(
            pair[1].0,
            &format!(
                "column `x` must increase from line to line, and {:?} follows {:?}",
                pair[1].1[0], pair[0].1[0]
            ),
        ));
    }
    let of = |column: usize| rows.iter().map(|(_, row)| row[column]).collect();
    Ok(Raster { x: of(0), y: vec![0.0], heights: of(1) })
}

/// A raster of rows x, y, z in any order.
fn rows(source: &Source) -> Result<Raster, Fault> {
    let rows = source.rows(&["x", "y", "z"], "heights")?;
    let coordinates = |column: usize| {
        let mut all: Vec<f64> = rows.iter().map(|(_, row)| row[column]).collect();
        all.sort_by(f64::total_cmp);
        all.dedup();
        all
    };
    let x = coordinates(0);
    let y = coordinates(1);
    let mut heights = vec![f64::NAN; x.len().saturating_mul(y.len()).min(1 << 28)];
    for (line, row) in &rows {
        let [i, j] = [(&x, row[0]), (&y, row[1])].map(|(all, v)| all.partition_point(|c| *c < v));
        match heights.get_mut(i + x.len() * j) {
            Some(height) if height.is_nan() => *height = row[2],
            Some(_) => {
                let what = format!("x = {:?}, y = {:?} is there twice", row[0], row[1]);
                return Err(source.refuse_line(*line, &what));
            }
            None => return Err(source.refuse("is no raster: its x and y differ from row to row")),
        }
    }
    if let Some(k) = heights.iter().position(|height| height.is_nan()) {
        let what = format!(
            "is no raster of {} x {} places: there is no height at x = {:?}, y = {:?}",
            x.len(),
            y.len(),
            x[k % x.len()],
            y[k / x.len()]
        );
        return Err(source.refuse(&what));
    }
    Ok(Raster { x, y, heights })
}

/// An ESRI ASCII grid: a head of keywords, then rows from north to south.
fn esri(source: &Source) -> Result<Raster, Fault> {
    let text = source.text()?;
    let mut lines =
        (1u64..).zip(text.lines()).filter(|(_, line)| !line.trim().is_empty()).peekable();
    let mut count = [0usize; 2];
    let mut corner = [None; 2];
    let mut cell = 0.0;
    let mut none = None;
    while let Some((line, text)) =
        lines.next_if(|(_, text)| text.trim_start().starts_with(char::is_alphabetic))
    {
        let mut words = text.split_whitespace();
        let key = words.next().unwrap_or_default().to_ascii_lowercase();
        let value =
            words.next().and_then(|word| word.parse::<f64>().ok()).filter(|v| v.is_finite());
        let Some(value) = value else {
            return Err(source.refuse_line(line, &format!("`{key}` must be followed by a number")));
        };
        match key.as_str() {
            "ncols" => count[0] = value as usize,
            "nrows" => count[1] = value as usize,
            "xllcorner" => corner[0] = Some((value, 0.5)),
            "yllcorner" => corner[1] = Some((value, 0.5)),
            "xllcenter" => corner[0] = Some((value, 0.0)),
            "yllcenter" => corner[1] = Some((value, 0.0)),
            "cellsize" => cell = value,
            "nodata_value" => none = Some(value),
            _ => {
                return Err(
                    source.refuse_line(line, &format!("`{key}` is no key of an ESRI ASCII grid"))
                );
            }
        }
    }
    let [Some(x), Some(y)] = corner else {
        return Err(source.refuse("needs xllcorner and yllcorner (or xllcenter, yllcenter)"));
    };
    if count.contains(&0) || cell <= 0.0 {
        return Err(source.refuse("needs ncols, nrows and cellsize, all positive"));
    }
    let mut heights = Vec::new();
    for (line, text) in lines {
        for word in text.split_whitespace() {
            let height = word.parse::<f64>().ok().filter(|h| h.is_finite() && Some(*h) != none);
            let Some(height) = height else {
                let what = format!("\"{word}\" is no height: fill places without data");
                return Err(source.refuse_line(line, &what));
            };
            heights.push(height);
        }
    }
    let [columns, rows] = count;
    if Some(heights.len()) != columns.checked_mul(rows) {
        let what = format!("has {} heights, and {columns} columns of {rows} rows", heights.len());
        return Err(source.refuse(&what));
    }
    // From south to north.
    let heights = heights.chunks(columns).rev().flatten().copied().collect();
    let along = |(start, half): (f64, f64), n: usize| {
        (0..n).map(|k| start + (k as f64 + half) * cell).collect()
    };
    Ok(Raster { x: along(x, columns), y: along(y, rows), heights })
}
