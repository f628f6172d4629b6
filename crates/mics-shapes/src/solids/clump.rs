//! A clump: the union of balls (discs in 2D) that may overlap, counted once.
//!
//! ```text
//!      .---. .---.        the plane in which two balls have equal powers, |x - c|^2 - r^2, holds
//!     /     X     \       their common circle: each ball has its own side of it, and what lies in
//!    (   o  |  o   )      none of the other sides is the union, exactly
//!     \     X     /
//!      '---' '---'        inside the nearest point is on a free part of a sphere, or on the circle
//! ```

use crate::boxes::convex::{self, Convex};
use crate::boxes::{ball, rim};
use crate::surface::balls::{Arc, Ball, Seam, arcs_of, circle, radical_plane, unconnected};
use crate::surface::moments::Moments;
use crate::surface::patches;
use crate::{Fault, Lattice, Nearest, Part, Shape, SurfacePoint, Tile};
use nalgebra::{Matrix2, Matrix3, Vector3};
use std::cell::RefCell;
use std::f64::consts::TAU;

/// A clump of balls.
#[derive(Clone, Debug)]
pub struct Clump {
    dimension: usize,
    balls: Vec<Ball>,
    seams: Vec<Seam>,
    /// Points of the surface on three spheres; in 2D on two circles (m).
    corners: Vec<Vector3<f64>>,
    /// Outline of a clump in 2D.
    arcs: Vec<Arc>,
    parts: Vec<Part>,
    radius: f64,
    volume: f64,
    inertia: Matrix3<f64>,
}

thread_local! {
    /// Room for the parts of a box, and the numbers of the balls that reach it.
    static ROOM: RefCell<(Convex, Vec<u32>)> =
        RefCell::new((Convex::with_capacity(64), Vec::with_capacity(64)));
}

impl Clump {
    /// A clump of balls with these centres and radii (m), discs in the plane z = 0 in two
    /// dimensions; it is moved so that its centre of volume is the origin.
    ///
    /// # Errors
    ///
    /// There is no ball, one has no place or no positive radius, or they are not connected.
    pub fn new(dimension: usize, balls: &[(Vector3<f64>, f64)]) -> Result<Clump, Fault> {
        let kind = if dimension == 2 { "disc" } else { "sphere" };
        if balls.is_empty() {
            return Err(Fault(format!("a clump needs one {kind} at least")));
        }
        for (k, (centre, radius)) in balls.iter().enumerate() {
            let whole = centre.iter().chain([radius]).all(|x| x.is_finite());
            if !whole || *radius <= 0.0 {
                let why =
                    format!("{kind} {} of the clump has no place or no positive radius", k + 1);
                return Err(Fault(why));
            }
        }
        let mut all: Vec<Ball> =
            balls.iter().map(|&(centre, radius)| Ball { centre, radius }).collect();
        if dimension == 2 {
            all.iter_mut().for_each(|ball| ball.centre.z = 0.0);
        }
        if let Some(alone) = unconnected(&all) {
            let why = format!(
                "{kind} {} of the clump touches none that {kind} 1 is joined to",
                alone + 1
            );
            return Err(Fault(why));
        }
        // A ball within another one adds nothing.
        let within = |k: usize| {
            let one = all[k];
            all.iter().enumerate().any(|(j, other)| {
                let inside = (other.centre - one.centre).norm() + one.radius <= other.radius;
                j != k && inside && (*other != one || j < k)
            })
        };
        let kept: Vec<Ball> = (0..all.len()).filter(|k| !within(*k)).map(|k| all[k]).collect();
        Ok(Clump::of(dimension, kept))
    }

    fn of(dimension: usize, balls: Vec<Ball>) -> Clump {
        let mut body = Clump {
            dimension,
            balls,
            seams: Vec::new(),
            corners: Vec::new(),
            arcs: Vec::new(),
            parts: Vec::new(),
            radius: 0.0,
            volume: 0.0,
            inertia: Matrix3::zeros(),
        };
        body.find_seams();
        let (volume, centroid, _) = body.moments();
        body.volume = volume;
        body.balls.iter_mut().for_each(|ball| ball.centre -= centroid);
        body.seams.iter_mut().for_each(|seam| seam.middle -= centroid);
        body.corners.iter_mut().for_each(|corner| *corner -= centroid);
        body.inertia = body.moments().2;
        body.parts = body.balls.iter().map(|ball| Part::ball(ball.centre, ball.radius)).collect();
        body.radius = body.reach();
        body
    }

    /// Radius of the sphere about the origin that holds all balls (m).
    fn reach(&self) -> f64 {
        self.balls.iter().map(|ball| ball.centre.norm() + ball.radius).fold(0.0, f64::max)
    }

    /// Volume (m3; m2), centre of volume (m), and moments of inertia about the origin (m5; m4).
    fn moments(&self) -> (f64, Vector3<f64>, Matrix3<f64>) {
        if self.dimension == 2 {
            let mut all = Moments::default();
            for Arc { disc, directions: [p, q] } in &self.arcs {
                let Ball { centre, radius } = &self.balls[*disc];
                all.add_arc(&centre.xy(), *radius, p, q);
            }
            return (all.area, (all.first / all.area).push(0.0), all.inertia());
        }
        let mut whole = 0.0;
        let mut first = Vector3::zeros();
        let mut second = Matrix3::zeros();
        let everything = [0, 1, 2].map(|a| Vector3::ith(a, 2.0 * self.reach()));
        self.each_cell(&Vector3::zeros(), &everything, |ball, body| {
            let c = ball.centre;
            let radius = ball.radius;
            let (volume, own) = ball::moments(body, &c, radius);
            let arm = own - volume * c;
            second += ball::second_moments(body, &c, radius, volume);
            second += c * arm.transpose() + arm * c.transpose() + volume * c * c.transpose();
            whole += volume;
            first += own;
        });
        (whole, first / whole, convex::inertia(&second))
    }

    /// Calls with each ball that reaches a parallelepiped, and the part of that on its own side of
    /// all others.
    fn each_cell(
        &self,
        middle: &Vector3<f64>,
        half: &[Vector3<f64>; 3],
        mut found: impl FnMut(&Ball, &Convex),
    ) {
        let reach = half.iter().map(|edge| edge.norm_squared()).sum::<f64>().sqrt();
        ROOM.with_borrow_mut(|(body, near)| {
            near.clear();
            near.extend((0..self.balls.len() as u32).filter(|k| {
                let Ball { centre, radius } = &self.balls[*k as usize];
                (centre - middle).norm_squared() < (radius + reach).powi(2)
            }));
            for k in near.iter() {
                let one = &self.balls[*k as usize];
                body.set_box(middle, half);
                for j in near.iter().filter(|j| *j != k) {
                    let (n, offset) = radical_plane(one, &self.balls[*j as usize]);
                    body.cut(&n, offset);
                }
                found(one, body);
            }
        });
    }

    /// Whether a point of the sphere of a ball lies in none of the others.
    fn is_free(&self, point: &Vector3<f64>, but: [usize; 2]) -> bool {
        let slack = 1e-9 * self.radius;
        self.balls.iter().enumerate().all(|(k, ball)| {
            but.contains(&k) || (point - ball.centre).norm() >= ball.radius - slack
        })
    }

    /// Finds the seams, and where these meet.
    fn find_seams(&mut self) {
        let n = self.balls.len();
        let pairs = (0..n).flat_map(|k| (k + 1..n).map(move |j| [k, j]));
        let seams: Vec<Seam> = pairs
            .filter_map(|balls| {
                let [one, other] = balls.map(|k| &self.balls[k]);
                let (middle, axis, radius) = circle(one, other)?;
                Some(Seam { balls, middle, axis, radius })
            })
            .collect();
        let mut corners = Vec::new();
        for seam in &seams {
            let Seam { middle, axis, radius, .. } = *seam;
            if self.dimension == 2 {
                let side = Vector3::new(-axis.y, axis.x, 0.0);
                corners.extend([1.0, -1.0].map(|sign| (middle + sign * radius * side, *seam)));
                continue;
            }
            let others = (0..n).filter(|k| !seam.balls.contains(k)).map(|k| &self.balls[k]);
            for ball in others {
                let out = ball.centre - middle;
                let across = out - out.dot(&axis) * axis;
                // On the circle at the angle to that direction whose cosine this is.
                let cos = (radius * radius + out.norm_squared() - ball.radius.powi(2))
                    / (2.0 * radius * across.norm());
                if cos.abs() <= 1.0 {
                    let u = across.normalize();
                    let sin = (1.0 - cos * cos).sqrt();
                    let v = axis.cross(&u);
                    let points = [sin, -sin].map(|sin| middle + radius * (cos * u + sin * v));
                    corners.extend(points.map(|point| (point, *seam)));
                }
            }
        }
        let free = corners.iter().filter(|(point, seam)| self.is_free(point, seam.balls));
        self.corners = free.map(|(point, _)| *point).collect();
        if self.dimension == 2 {
            self.arcs = (0..n).flat_map(|disc| arcs_of(&self.balls, disc, &seams)).collect();
        } else {
            self.seams = seams;
        }
    }

    /// The nearest point of the surface to one inside: on a free part of a sphere, on the seam of
    /// two, or where seams meet.
    fn nearest_inside(&self, point: &Vector3<f64>) -> Option<Nearest> {
        let mut best: Option<(f64, Vector3<f64>)> = None;
        let mut offer = |foot: Vector3<f64>, but: Option<[usize; 2]>| {
            let way = (foot - point).norm();
            let free = || but.is_none_or(|but| self.is_free(&foot, but));
            if best.is_none_or(|(least, _)| way < least) && free() {
                best = Some((way, foot));
            }
        };
        for (k, ball) in self.balls.iter().enumerate() {
            let n = (point - ball.centre).try_normalize(0.0).unwrap_or_else(Vector3::x);
            offer(ball.centre + ball.radius * n, Some([k, k]));
        }
        for seam in &self.seams {
            let out = point - seam.middle;
            let across = out - out.dot(&seam.axis) * seam.axis;
            let any = || seam.axis.cross(&Vector3::ith(seam.axis.iamin(), 1.0)).normalize();
            let across = across.try_normalize(1e-12 * seam.radius).unwrap_or_else(any);
            offer(seam.middle + seam.radius * across, Some(seam.balls));
        }
        self.corners.iter().for_each(|corner| offer(*corner, None));
        let (way, foot) = best?;
        let normal = (foot - point).try_normalize(1e-12 * self.radius)?;
        Some(Nearest { distance: -way, normal })
    }

    /// Free share of a patch of the ball `k`'s surface, over a direction with an angle, and the
    /// direction of its middle.
    fn free_part(&self, k: usize, direction: &Vector3<f64>, width: f64) -> (f64, Vector3<f64>) {
        let ball = &self.balls[k];
        let at = |n: &Vector3<f64>| ball.centre + ball.radius * n;
        let middle = at(direction);
        let near = |other: &Ball| {
            ((middle - other.centre).norm() - other.radius).abs() < 1.5 * width * ball.radius
        };
        let cut = self.balls.iter().enumerate().any(|(j, other)| j != k && near(other));
        if !cut {
            return (f64::from(self.is_free(&middle, [k, k])), *direction);
        }
        let (u, v) = if self.dimension == 2 {
            (Vector3::new(-direction.y, direction.x, 0.0), Vector3::zeros())
        } else {
            let u = direction.cross(&Vector3::ith(direction.iamin(), 1.0)).normalize();
            (u, direction.cross(&u))
        };
        let n = 16;
        let mut count = 0.0;
        let mut sum = Vector3::zeros();
        for i in 0..n * n {
            let [x, y] = [i % n, i / n].map(|i| (i as f64 + 0.5) / n as f64 - 0.5);
            let n = (direction + width * (x * u + y * v)).normalize();
            if self.is_free(&at(&n), [k, k]) {
                count += 1.0;
                sum += n;
            }
        }
        (count / (n * n) as f64, sum.try_normalize(0.0).unwrap_or(*direction))
    }
}

impl Shape for Clump {
    fn dimension(&self) -> usize {
        self.dimension
    }

    fn radius(&self) -> f64 {
        self.radius
    }

    fn volume(&self) -> f64 {
        self.volume
    }

    fn inertia(&self) -> Matrix3<f64> {
        self.inertia
    }

    fn thickness(&self) -> f64 {
        2.0 * self.balls.iter().map(|ball| ball.radius).fold(f64::INFINITY, f64::min)
    }

    /// Outside that of the nearest ball. Inside exact too: where the ball's own nearest point lies
    /// in another one, it may be on the circle of two spheres.
    fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        let mut least = (f64::INFINITY, 0);
        for (k, ball) in self.balls.iter().enumerate() {
            let distance = (point - ball.centre).norm() - ball.radius;
            if distance < least.0 {
                least = (distance, k);
            }
        }
        let (distance, k) = least;
        let arm = point - self.balls[k].centre;
        let normal = arm.try_normalize(0.0).unwrap_or_else(Vector3::x);
        if distance < 0.0
            && self.balls.len() > 1
            && !self.is_free(&(point - distance * normal), [k, k])
        {
            return self.nearest_inside(point).unwrap_or(Nearest { distance, normal });
        }
        Nearest { distance, normal }
    }

    fn surface(&self, spacing: f64) -> Vec<SurfacePoint> {
        let mut all = Vec::new();
        for (k, ball) in self.balls.iter().enumerate() {
            let mut add = |normal: Vector3<f64>, width: f64, area: f64| {
                let (part, normal) = self.free_part(k, &normal, width);
                let area = part * area;
                let place = ball.centre + ball.radius * normal;
                if area > 0.0 {
                    all.push(SurfacePoint { place, normal, area });
                }
            };
            if self.dimension == 2 {
                let count = 4 * (0.5 * TAU * ball.radius / spacing).ceil().max(1.0) as usize;
                let width = TAU / count as f64;
                for i in 0..count {
                    let (y, x) = (width * (i as f64 + 0.5)).sin_cos();
                    add(Vector3::new(x, y, 0.0), width, width * ball.radius);
                }
            } else {
                for (n, angle) in patches::directions(patches::divisions(ball.radius, spacing)) {
                    add(n, angle.sqrt(), angle * ball.radius * ball.radius);
                }
            }
        }
        all
    }

    fn extent(&self, n: &Vector3<f64>) -> f64 {
        let reach = self.balls.iter().map(|ball| ball.centre.dot(n) + ball.radius);
        reach.fold(f64::NEG_INFINITY, f64::max)
    }

    /// Exact, see the top.
    fn tile(&self, lattice: &Lattice, found: &mut dyn FnMut(&Tile)) {
        let Lattice { factor, orientation: turn, planes, .. } = lattice;
        if self.dimension == 2 {
            let turn = turn.matrix().fixed_view::<2, 2>(0, 0);
            return rim::tile(planes, found, |rim, planes| {
                for Arc { disc, directions } in &self.arcs {
                    let Ball { centre, radius } = &self.balls[*disc];
                    let axes = Matrix2::from_diagonal_element(factor * radius);
                    let round = rim::Stretched::new(lattice.place(centre).xy(), axes);
                    let [p, q] = directions.map(|n| turn * n);
                    rim.add_arc(planes, &round, &p, &q);
                }
            });
        }
        let counts = planes.each_ref().map(|planes| planes.len().saturating_sub(1));
        for number in 0..counts.iter().product() {
            let [nx, ny, _] = counts;
            let at = [number % nx, number / nx % ny, number / nx / ny];
            let (middle, half) = lattice.own_box(at);
            let reach = half.iter().map(|edge| edge.norm_squared()).sum::<f64>().sqrt();
            let away = |ball: &Ball| (middle - ball.centre).norm() - ball.radius;
            let nearest = self.balls.iter().map(away).fold(f64::INFINITY, f64::min);
            let whole = 8.0 * half.iter().map(|edge| edge.norm()).product::<f64>();
            let mut part = 1.0;
            let mut first = middle;
            if nearest > -reach && nearest < reach {
                part = 0.0;
                first = Vector3::zeros();
                self.each_cell(&middle, &half, |ball, body| {
                    let (volume, own) = ball::moments(body, &ball.centre, ball.radius);
                    part += volume / whole;
                    first += own / whole;
                });
            }
            if nearest < reach {
                found(&Tile::new(planes, at, part, lattice.place(&first)));
            }
        }
    }

    fn meets_itself(&self, foot: &Vector3<f64>, normal: &Vector3<f64>) -> Option<f64> {
        let way = |ball: &Ball| {
            let apart = ball.centre - foot;
            let ahead = apart.dot(normal);
            let beyond = apart.norm_squared() - ball.radius * ball.radius;
            let under = ahead * ahead - beyond;
            // From the ball's own surface the ray leaves it.
            (ahead > 0.0 && under > 0.0).then(|| (ahead - under.sqrt()).max(0.0))
        };
        self.balls.iter().filter_map(way).reduce(f64::min)
    }

    fn parts(&self) -> &[Part] {
        &self.parts
    }

    fn triangles(&self, spacing: f64) -> Vec<[Vector3<f64>; 3]> {
        let mut all = Vec::new();
        for (k, ball) in self.balls.iter().enumerate() {
            let at = |n: Vector3<f64>| ball.centre + ball.radius * n;
            let mut add = |corners: [Vector3<f64>; 3]| {
                if corners.iter().any(|corner| self.is_free(corner, [k, k])) {
                    all.push(corners);
                }
            };
            if self.dimension == 2 {
                let count = 4 * (0.5 * TAU * ball.radius / spacing).ceil().max(1.0) as usize;
                let point = |i: usize| {
                    let (y, x) = (TAU * i as f64 / count as f64).sin_cos();
                    at(Vector3::new(x, y, 0.0))
                };
                (0..count).for_each(|i| add([point(i), point(i + 1), point(i + 1)]));
            } else {
                let n = patches::divisions(ball.radius, spacing);
                patches::triangles(n).for_each(|corners| add(corners.map(at)));
            }
        }
        all
    }
}

#[cfg(test)]
mod tests;
