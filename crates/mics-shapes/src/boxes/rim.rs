//! Parts that a body of two dimensions fills of the boxes of a lattice: its outline is cut by the
//! lines once, and rows of boxes summed up from their ends.
//!
//! ```text
//!     row of boxes along x     A = sum over pieces of  integral of (x - x_i) dy + h C_(i+1)
//!    +----+----+----+----+     C_(i+1) = C_i - sum over pieces of  integral of dy
//!    |   _|____|__  |    |
//!    |  / |    |  \ |    |     with x_i the low line of a box of the length h, and C_i how much
//!    +-/--+----+---\+----+     of that line is covered; moments likewise
//! ```
//! A piece of an arc counts as its chord, and what lies between the two is added: of the unit disc
//! with the angle phi between its ends the area `(phi - sin phi)/2`, and the first moment `c^3/12`
//! along the normal of the chord of length c.

use super::Tile;
use super::rows::place;
use nalgebra::{Matrix2, Vector2, Vector3};
use std::cell::RefCell;

/// No number.
const NONE: u32 = u32::MAX;

/// Integrals over the pieces of the outline in a box, by dy, x from its low line: 1 and y; x;
/// x^2/2 and x y.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    height: f64,
    moment: f64,
    area: f64,
    first: Vector2<f64>,
}

impl Sum {
    /// Adds a straight piece.
    fn add(&mut self, from: &Vector2<f64>, to: &Vector2<f64>, low: f64) {
        let rise = to.y - from.y;
        let [a, b] = [from.x - low, to.x - low];
        let [p, q] = [from.y, to.y];
        self.height += rise;
        self.moment += 0.5 * rise * (p + q);
        self.area += 0.5 * rise * (a + b);
        let across = (2.0 * a + b) * p + (a + 2.0 * b) * q;
        self.first += rise / 6.0 * Vector2::new(a * a + a * b + b * b, across);
    }
}

/// The region between an arc and its chord.
#[derive(Clone, Copy, Debug, Default)]
struct Bulge {
    /// Its area (m2).
    area: f64,
    /// The integral of the place over it (m3).
    first: Vector2<f64>,
}

/// A curve along which neither x nor y turns back.
trait Curve {
    /// Where it crosses a line normal to an axis (m).
    fn crossing(&self, axis: usize, line: f64) -> Vector2<f64>;

    /// The region between it and its chord from one of its points to another.
    fn bulge(&self, from: &Vector2<f64>, to: &Vector2<f64>) -> Bulge;
}

/// A straight side, by its end and by its way from there.
struct Side {
    end: Vector2<f64>,
    way: Vector2<f64>,
}

impl Curve for Side {
    fn crossing(&self, axis: usize, line: f64) -> Vector2<f64> {
        let mut place = self.end + (line - self.end[axis]) / self.way[axis] * self.way;
        place[axis] = line;
        place
    }

    fn bulge(&self, _: &Vector2<f64>, _: &Vector2<f64>) -> Bulge {
        Bulge::default()
    }
}

/// An ellipse: the unit disc times a matrix, about a centre.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stretched {
    centre: Vector2<f64>,
    axes: Matrix2<f64>,
    back: Matrix2<f64>,
    density: f64,
    /// Half widths along the axes of the lattice (m), and the points of the unit disc that reach as
    /// far.
    widths: [f64; 2],
    furthest: [Vector2<f64>; 2],
}

impl Stretched {
    /// The unit disc times a matrix of positive determinant (m), about a centre (m).
    pub fn new(centre: Vector2<f64>, axes: Matrix2<f64>) -> Stretched {
        let rows = [0, 1].map(|a| axes.row(a).transpose());
        let density = axes.determinant();
        let back = Matrix2::new(axes.m22, -axes.m12, -axes.m21, axes.m11) / density;
        let widths = rows.map(|row| row.norm());
        let furthest = [0, 1].map(|a| rows[a] / widths[a]);
        Stretched { centre, axes, back, density, widths, furthest }
    }

    /// The place of a point of the unit disc (m).
    fn place(&self, point: &Vector2<f64>) -> Vector2<f64> {
        self.centre + self.axes * point
    }
}

/// The part of an ellipse on which lines are crossed on these sides of its points that reach
/// furthest.
struct Arc<'a> {
    whole: &'a Stretched,
    sides: [f64; 2],
}

impl Curve for Arc<'_> {
    fn crossing(&self, axis: usize, line: f64) -> Vector2<f64> {
        let Stretched { centre, widths, furthest, .. } = self.whole;
        let along = (line - centre[axis]) / widths[axis];
        let n = furthest[axis];
        let root = ((1.0 - along) * (1.0 + along)).max(0.0).sqrt();
        let point = along * n + self.sides[axis] * root * Vector2::new(-n.y, n.x);
        let mut place = self.whole.place(&point);
        place[axis] = line;
        place
    }

    fn bulge(&self, from: &Vector2<f64>, to: &Vector2<f64>) -> Bulge {
        let Stretched { centre, axes, back, density, .. } = self.whole;
        let [p, q] = [from, to].map(|place| back * (place - centre));
        let sine = p.perp(&q);
        let chord = q - p;
        let area = 0.5 * density * (sine.atan2(p.dot(&q)) - sine);
        let first = chord.norm_squared() / 12.0 * Vector2::new(chord.y, -chord.x);
        Bulge { area, first: *density * (axes * first) + area * centre }
    }
}

/// An outline in a lattice, and room that is used again.
#[derive(Default)]
pub(crate) struct Rim {
    /// By box, one before the first of each row among them, the number of its sum.
    numbers: Vec<u32>,
    sums: Vec<Sum>,
}

thread_local! {
    static SCRATCH: RefCell<Rim> = RefCell::default();
}

/// Calls with the boxes between `planes` (m) that a body reaches; `outline` adds its sides and arcs
/// one after the other, counterclockwise.
pub(crate) fn tile(
    planes: &[Vec<f64>; 3],
    found: &mut dyn FnMut(&Tile),
    outline: impl FnOnce(&mut Rim, [&[f64]; 2]),
) {
    let [x, y, _] = planes;
    if x.len() < 2 || y.len() < 2 {
        return;
    }
    SCRATCH.with_borrow_mut(|rim| {
        rim.numbers.clear();
        rim.numbers.resize(x.len() * (y.len() - 1), NONE);
        rim.sums.clear();
        outline(rim, [x, y]);
        rim.each(planes, found);
    });
}

impl Rim {
    /// Adds a straight side (m).
    pub fn add_side(&mut self, planes: [&[f64]; 2], from: &Vector2<f64>, to: &Vector2<f64>) {
        self.walk(planes, &Side { end: *from, way: to - from }, from, to);
    }

    /// Adds the arc of an ellipse between two points of the unit disc, less than half a turn apart.
    pub fn add_arc(
        &mut self,
        planes: [&[f64]; 2],
        ellipse: &Stretched,
        from: &Vector2<f64>,
        to: &Vector2<f64>,
    ) {
        let [x, y] = ellipse.furthest;
        let mut at = *from;
        let mut place = ellipse.place(from);
        loop {
            let ahead = [x, y, -x, -y]
                .into_iter()
                .filter(|point| at.perp(point) > 0.0 && point.perp(to) > 0.0)
                .reduce(|first, other| if first.perp(&other) > 0.0 { first } else { other });
            let next = ahead.unwrap_or(*to);
            let chord = next - at;
            let middle = at + next + Vector2::new(chord.y, -chord.x);
            let sides = [x, y].map(|n| n.perp(&middle).signum());
            let end = ellipse.place(&next);
            self.walk(planes, &Arc { whole: ellipse, sides }, &place, &end);
            if ahead.is_none() {
                break;
            }
            at = next;
            place = end;
        }
    }

    /// Adds a whole ellipse.
    pub fn add_ellipse(&mut self, planes: [&[f64]; 2], ellipse: &Stretched) {
        let [x, y] = ellipse.furthest;
        for [from, to] in [[x, y], [y, -x], [-x, -y], [-y, x]] {
            self.add_arc(planes, ellipse, &from, &to);
        }
    }

    /// Cuts a curve by the lines in the order in which it crosses them.
    fn walk(
        &mut self,
        planes: [&[f64]; 2],
        curve: &impl Curve,
        from: &Vector2<f64>,
        to: &Vector2<f64>,
    ) {
        let rises = [0, 1].map(|a| to[a] > from[a]);
        let mut cell = [0, 1].map(|a| place(planes[a], from[a]));
        let exit = |axis: usize, cell: usize| {
            let line = cell.checked_sub(usize::from(!rises[axis]))?;
            let line = *planes[axis].get(line)?;
            let passed = if rises[axis] { line < to[axis] } else { line > to[axis] };
            passed.then(|| curve.crossing(axis, line))
        };
        let mut at = *from;
        let mut exits = [exit(0, cell[0]), exit(1, cell[1])];
        loop {
            let (axis, end) = match exits {
                [None, None] => break,
                [Some(x), None] => (0, x),
                [None, Some(y)] => (1, y),
                [Some(x), Some(y)] if (if rises[0] { y.x < x.x } else { y.x > x.x }) => (1, y),
                [Some(x), Some(_)] => (0, x),
            };
            self.keep(planes, cell, curve, &at, &end);
            cell[axis] = if rises[axis] { cell[axis] + 1 } else { cell[axis] - 1 };
            at = end;
            exits[axis] = exit(axis, cell[axis]);
        }
        self.keep(planes, cell, curve, &at, to);
    }

    /// Takes a piece between the lines before those of these numbers and those.
    fn keep(
        &mut self,
        [x, y]: [&[f64]; 2],
        [i, j]: [usize; 2],
        curve: &impl Curve,
        from: &Vector2<f64>,
        to: &Vector2<f64>,
    ) {
        if i == x.len() || j == 0 || j == y.len() {
            return;
        }
        let number = &mut self.numbers[i + x.len() * (j - 1)];
        if *number == NONE {
            *number = self.sums.len() as u32;
            self.sums.push(Sum::default());
        }
        // A piece before the first line counts as covering it.
        let sum = &mut self.sums[*number as usize];
        let low = x[i.max(1) - 1];
        sum.add(from, to, low);
        if i > 0 {
            let Bulge { area, first } = curve.bulge(from, to);
            sum.area += area;
            sum.first += first - area * low * Vector2::x();
        }
    }

    /// Calls with the boxes that the body reaches.
    fn each(&self, planes: &[Vec<f64>; 3], found: &mut dyn FnMut(&Tile)) {
        let [x, y, _] = planes;
        for (j, row) in self.numbers.chunks_exact(x.len()).enumerate() {
            let width = y[j + 1] - y[j];
            let mut covered = 0.0;
            let mut moment = 0.0;
            for (i, number) in row.iter().enumerate() {
                let sum = self.sums.get(*number as usize);
                if let Some(sum) = sum {
                    covered -= sum.height;
                    moment -= sum.moment;
                }
                if i == 0 {
                    continue;
                }
                let at = [i - 1, j, 0];
                let low = x[i - 1];
                let h = x[i] - x[i - 1];
                if let Some(sum) = sum {
                    let part = (sum.area + h * covered) / (h * width);
                    let first = sum.first + h * Vector2::new(0.5 * h * covered, moment);
                    let first = first / (h * width) + part * low * Vector2::x();
                    found(&Tile::new(planes, at, part, first.push(0.0)));
                } else if covered > 0.5 * width {
                    let moment = Vector3::new(low + 0.5 * h, y[j] + 0.5 * width, 0.0);
                    found(&Tile::new(planes, at, 1.0, moment));
                }
            }
        }
    }
}
