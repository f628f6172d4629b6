//! Means and second moments over time, of the fluid outside the bodies and of the bodies, in every
//! cell and in layers of cells.
//!
//! ```text
//!   w_f = sum dt (1 - alpha)        w_s = sum dt alpha           alpha: what bodies fill of a cell
//!   fluid:   U = sum dt (1 - alpha) u/w_f     u'v' = sum dt (1 - alpha) u v/w_f - U V
//!              and of the pressure
//!   bodies:  sum dt alpha (v + omega x r)/w_s,     solid fraction w_s/(w_f + w_s)
//! ```
//! A sample counts for the time since the last one. A layer has the same sums over its cells.
//!
//! Where bodies are free, the balance of momentum of everything in the box is summed over the same
//! time T, every step of it:
//!
//! ```text
//!   ( M(end) - M(start) )/T = (1/T) sum dt ( drive + gravity + sides + contacts with walls
//!                 + held bodies ) + passages + missing
//! ```
//! M is of the state at two moments and the forces are of all steps between them: what is missing
//! shows what either lost.

use super::rows::{renamed, repeat, with_old_names};
use super::snapshot::slices;
use super::vti::{Writer, head};
use crate::archive::{Archive, Checkpointed};
use crate::clock::Stage;
use crate::config::{Axis, Case, Statistics as Plan};
use crate::grid::{Grid, VectorField, simd};
use crate::petsc::Session;
use crate::scene::Scene;
use crate::state::{Balance, Impulses, State};
use crate::{Error, Result};
use mics_run::file::replace;
use mics_run::folder::{BALANCE, FIELDS, PROFILE};
use mics_run::vti::Head;
use nalgebra::Vector3;
use std::fmt::Write as _;
use std::path::Path;

/// Names of the components of a velocity.
const COMPONENTS: [&str; 3] = ["u", "v", "w"];

/// Sums over time.
pub struct Statistics<const D: usize> {
    plan: Plan,
    /// Time that has been counted, and that waits for the next sample (s).
    counted: f64,
    waiting: f64,
    /// `sum dt (1 - alpha)` times velocity, its products (xx, xy, yy; xx, xy, yy, xz, yz, zz),
    /// pressure and its square.
    velocity: VectorField<D>,
    products: Vec<Vec<f64>>,
    pressure: [Vec<f64>; 2],
    /// `sum dt alpha` and the same times the bodies' velocity; empty without bodies.
    solid: Vec<f64>,
    solid_velocity: Vec<Vec<f64>>,
    /// The balance of momentum over the time that has been counted, and over what waits for the
    /// next sample; `None` where none is kept.
    balance: Option<[Window; 2]>,
    /// Names of the obstacles.
    obstacles: Vec<String>,
}

/// The balance of momentum over steps one after the other.
#[derive(Clone, Debug, Default, PartialEq)]
struct Window {
    /// Momentum of everything in the box before the first and after the last of them (kg m/s);
    /// `None` of no steps.
    ends: Option<(Vector3<f64>, Vector3<f64>)>,
    /// Impulses on it over these steps (N s), by their cause.
    impulses: Impulses,
    /// Impulse of each obstacle on the fluid over them (N s), a part of the `held` ones.
    obstacles: Vec<Vector3<f64>>,
    /// Momentum that came with bodies, less what went, between the steps (kg m/s).
    passages: Vector3<f64>,
}

impl Window {
    /// Goes on with `next`.
    fn append(&mut self, next: Window) {
        let Some((before, after)) = next.ends else { return };
        if let Some((_, last)) = self.ends {
            self.passages += before - last;
        }
        self.ends = Some((self.ends.map_or(before, |ends| ends.0), after));
        self.impulses += next.impulses;
        self.passages += next.passages;
        self.obstacles.resize(next.obstacles.len(), Vector3::zeros());
        self.obstacles.iter_mut().zip(next.obstacles).for_each(|(sum, more)| *sum += more);
    }

    /// The window of one step, after which the state is `state`.
    fn of<const D: usize>(step: &Balance, state: &State<D>) -> Window {
        let held = state.bodies.iter().zip(&state.exchange).filter(|(body, _)| body.is_obstacle());
        Window {
            ends: Some((step.before, step.momentum)),
            impulses: step.impulses,
            obstacles: held.map(|(_, e)| -state.dt * e.held()).collect(),
            ..Window::default()
        }
    }

    /// `balance.csv`: a row an axis, mean forces (N) over the time `counted` (s).
    /// Parts of `held` by the obstacles of these names follow.
    fn table(&self, dimension: usize, counted: f64, obstacles: &[String]) -> Option<String> {
        let (before, after) = self.ends?;
        let change = after - before;
        let missing = change - self.impulses.total() - self.passages;
        let parts: String = obstacles.iter().map(|name| format!(",held_{name}")).collect();
        let names = Impulses::NAMES.join(",");
        let head = with_old_names(&format!("axis,duration,change,{names},passages,missing{parts}"));
        let renamed = renamed(&head);
        let mut text = head + "\n";
        for axis in 0..dimension {
            let _ = write!(text, "{},{counted:?}", ["x", "y", "z"][axis]);
            let terms =
                [&[change][..], &self.impulses.vectors(), &[self.passages, missing]].concat();
            for term in terms.iter().chain(&self.obstacles) {
                let _ = write!(text, ",{:?}", term[axis] / counted);
            }
            repeat(&mut text, &renamed);
            text.push('\n');
        }
        Some(text)
    }
}

impl Checkpointed for Window {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        let Window { ends, impulses, obstacles, passages } = self;
        ends.serialize(archive)?;
        obstacles.serialize(archive)?;
        impulses.serialize(archive)?;
        passages.serialize(archive)
    }
}

/// The pairs of axes that products have.
fn pairs(dimension: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..dimension).flat_map(|b| (0..=b).map(move |a| (a, b)))
}

impl<const D: usize> Statistics<D> {
    /// Empty sums for a case's scene; `None` where the case asks for no statistics.
    pub fn of_case(scene: &Scene<D>, case: &Case) -> Option<Statistics<D>> {
        let plan = case.statistics.as_ref()?;
        // Bodies that have yet to come in count too.
        let grid = &scene.domain.grid;
        let bodies = case.has_bodies();
        let fields = |count: usize| (0..count).map(|_| grid.field()).collect::<Vec<_>>();
        Some(Statistics {
            plan: plan.clone(),
            counted: 0.0,
            waiting: 0.0,
            velocity: grid.vector_field(),
            products: fields(pairs(D).count()),
            pressure: [grid.field(), grid.field()],
            solid: if bodies { grid.field() } else { Vec::new() },
            solid_velocity: fields(if bodies { D } else { 0 }),
            balance: scene.state.balance.map(|_| Default::default()),
            obstacles: (0..case.obstacle.len())
                .map(|k| case.obstacle[k].name.clone().unwrap_or(k.to_string()))
                .collect(),
        })
    }

    /// Takes the state after a step; the one at time 0 counts for no time.
    pub fn take(&mut self, scene: &mut Scene<D>) {
        if scene.state.steps > 0 {
            scene.domain.clock.lap(Stage::Logs);
            self.sample(scene);
            scene.domain.clock.lap(Stage::Statistics);
        }
    }

    fn sample(&mut self, scene: &Scene<D>) {
        let s = &scene.state;
        let ended = self.plan.until.is_some_and(|until| s.time > until * (1.0 + 1e-12));
        if s.time - s.dt < self.plan.from * (1.0 - 1e-12) || ended {
            return;
        }
        self.waiting += s.dt;
        if let (Some([_, pending]), Some(step)) = (&mut self.balance, &s.balance) {
            pending.append(Window::of(step, s));
        }
        if !s.steps.is_multiple_of(self.plan.every) {
            return;
        }
        let weight = std::mem::take(&mut self.waiting);
        self.counted += weight;
        if let Some([window, pending]) = &mut self.balance {
            window.append(std::mem::take(pending));
        }
        self.add_cells(&scene.domain.grid, weight, scene);
        self.take_bodies(weight, scene);
    }

    fn add_cells(&mut self, grid: &Grid<D>, weight: f64, scene: &Scene<D>) {
        let u = &scene.state.u;
        let p = &scene.state.p;
        let Statistics { velocity, products, pressure: [mean, square], .. } = self;
        simd(
            #[inline(always)]
            || {
                for row in grid.rows() {
                    for (sum, u) in velocity.iter_mut().zip(u) {
                        sum[row.clone()]
                            .iter_mut()
                            .zip(&u[row.clone()])
                            .for_each(|(sum, u)| *sum += weight * u);
                    }
                    for (sum, (a, b)) in products.iter_mut().zip(pairs(D)) {
                        let values = u[a][row.clone()].iter().zip(&u[b][row.clone()]);
                        sum[row.clone()]
                            .iter_mut()
                            .zip(values)
                            .for_each(|(sum, (a, b))| *sum += weight * a * b);
                    }
                    let sums = mean[row.clone()].iter_mut().zip(&mut square[row.clone()]);
                    for ((mean, square), p) in sums.zip(&p[row]) {
                        *mean += weight * p;
                        *square += weight * p * p;
                    }
                }
            },
        );
    }

    /// Takes out of the fluid's sums what bodies fill, and adds it to theirs.
    fn take_bodies(&mut self, weight: f64, scene: &Scene<D>) {
        let u = &scene.state.u;
        let p = &scene.state.p;
        for (body, overlaps) in scene.state.bodies.iter().zip(scene.method.overlaps_by_body()) {
            for o in overlaps {
                let c = o.cell;
                let share = weight * o.fraction;
                self.velocity.iter_mut().zip(u).for_each(|(sum, u)| sum[c] -= share * u[c]);
                for (sum, (a, b)) in self.products.iter_mut().zip(pairs(D)) {
                    sum[c] -= share * u[a][c] * u[b][c];
                }
                self.pressure[0][c] -= share * p[c];
                self.pressure[1][c] -= share * p[c] * p[c];
                self.solid[c] += share;
                let own = body.velocity_at(&o.arm);
                self.solid_velocity
                    .iter_mut()
                    .enumerate()
                    .for_each(|(a, sum)| sum[c] += share * own[a]);
            }
        }
    }

    /// Writes or reads all of it. Collective.
    ///
    /// # Errors
    /// When the archive holds another case.
    pub fn serialize(&mut self, grid: &Grid<D>, archive: &mut Archive) -> Result<()> {
        archive.label("statistics")?;
        archive.serialize([&mut self.counted, &mut self.waiting])?;
        archive.cells(grid, &mut self.velocity)?;
        archive.cells(grid, &mut self.products)?;
        archive.cells(grid, &mut self.pressure)?;
        if !self.solid.is_empty() {
            archive.cells(grid, std::slice::from_mut(&mut self.solid))?;
            archive.cells(grid, &mut self.solid_velocity)?;
        }
        self.balance.iter_mut().flatten().try_for_each(|window| window.serialize(archive))
    }

    /// Writes the files into a run's folder; nothing before the first sample. Collective.
    ///
    /// # Errors
    /// When they cannot be written.
    pub fn write(&self, scene: &Scene<D>, folder: &Path) -> Result<()> {
        if self.counted <= 0.0 {
            return Ok(());
        }
        let grid = &scene.domain.grid;
        let session = &scene.domain.session;
        let means = self.means(&|field| Ok(field.to_vec()), &vec![1.0; self.pressure[0].len()])?;
        let of = |(name, parts): &(String, Vec<Vec<f64>>)| {
            (name.clone(), if parts.len() == 1 { 1 } else { 3 })
        };
        let head =
            Head { arrays: means.iter().map(of).collect(), ..head(grid, scene.state.time, &[]) };
        let mut file = Writer::begin(session, &folder.join(FIELDS), head)?;
        for (name, parts) in &means {
            file.put(grid, name, &slices(parts));
        }
        file.commit()?;
        let counted = self.counted;
        let names = &self.obstacles;
        let table = self.balance.as_ref().and_then(|[window, _]| window.table(D, counted, names));
        let profile =
            self.plan.profile.map(|axis| self.profile(session, grid, axis)).transpose()?;
        let texts =
            [(BALANCE, table), (PROFILE, profile)].into_iter().filter(|_| session.rank() == 0);
        session.agree(
            texts
                .filter_map(|(name, text)| Some((name, text?)))
                .try_for_each(|(name, text)| replace(&folder.join(name), text.as_bytes())),
        )
    }

    /// The means by name and component in places that have so many `cells` each; `sum` adds a field
    /// up in each place. Zero where there was nothing to average.
    fn means(
        &self,
        sum: &dyn Fn(&[f64]) -> Result<Vec<f64>>,
        cells: &[f64],
    ) -> Result<Vec<(String, Vec<Vec<f64>>)>> {
        let all: Vec<f64> = cells.iter().map(|cells| self.counted * cells).collect();
        let solid = if self.solid.is_empty() { vec![0.0; all.len()] } else { sum(&self.solid)? };
        let over = |sums: Vec<f64>, weights: &[f64]| -> Vec<f64> {
            let part = |((sum, weight), all): ((f64, &f64), &f64)| {
                if *weight > 1e-9 * all { sum / weight } else { 0.0 }
            };
            sums.into_iter().zip(weights).zip(&all).map(part).collect()
        };
        let fluid: Vec<f64> = all.iter().zip(&solid).map(|(all, solid)| all - solid).collect();
        let mean = |field: &[f64], weights: &[f64]| Ok::<_, Error>(over(sum(field)?, weights));
        let velocity = self.velocity.iter().map(|u| mean(u, &fluid)).collect::<Result<Vec<_>>>()?;
        let pressure = mean(&self.pressure[0], &fluid)?;
        let spread = |squares: Vec<f64>, a: &[f64], b: &[f64]| -> Vec<f64> {
            squares.iter().zip(a.iter().zip(b)).map(|(square, (a, b))| square - a * b).collect()
        };
        let mut means = vec![
            ("velocity".to_owned(), velocity.clone()),
            ("pressure".to_owned(), vec![pressure.clone()]),
        ];
        for (products, (a, b)) in self.products.iter().zip(pairs(D)) {
            let name = format!("{}{}", COMPONENTS[a], COMPONENTS[b]);
            means.push((name, vec![spread(mean(products, &fluid)?, &velocity[a], &velocity[b])]));
        }
        let squares = mean(&self.pressure[1], &fluid)?;
        means.push(("pp".to_owned(), vec![spread(squares, &pressure, &pressure)]));
        if !self.solid.is_empty() {
            let own =
                self.solid_velocity.iter().map(|v| mean(v, &solid)).collect::<Result<Vec<_>>>()?;
            means.push(("solid_fraction".to_owned(), vec![over(solid, &all)]));
            means.push(("solid_velocity".to_owned(), own));
        }
        Ok(means)
    }

    /// `profile.csv`: a row a layer. Collective.
    fn profile(&self, session: &Session, grid: &Grid<D>, axis: Axis) -> Result<String> {
        let axis = axis.index();
        let layers = grid.cells[axis];
        let sum = |field: &[f64]| {
            let mut sums = vec![0.0; layers];
            grid.rows().flatten().for_each(|c| sums[grid.global_cell(c)[axis]] += field[c]);
            session.sum(&mut sums)?;
            Ok(sums)
        };
        let cells = (grid.total_cells() / layers) as f64;
        let means = self.means(&sum, &vec![cells; layers])?;
        let mut text = ["x", "y", "z"][axis].to_owned();
        for (name, parts) in &means {
            let named = |a: usize| match name.as_str() {
                "velocity" => COMPONENTS[a].to_owned(),
                "solid_velocity" => format!("solid_{}", COMPONENTS[a]),
                name => name.to_owned(),
            };
            (0..parts.len()).for_each(|a| text += &format!(",{}", named(a)));
        }
        text.push('\n');
        for k in 0..layers {
            let _ = write!(text, "{:?}", (k as f64 + 0.5) * grid.h[axis]);
            means.iter().flat_map(|(_, parts)| parts).for_each(|values| {
                let _ = write!(text, ",{:?}", values[k]);
            });
            text.push('\n');
        }
        Ok(text)
    }
}
