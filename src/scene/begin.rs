//! A scene that begins where another run ended.

use super::Scene;
use crate::config::Case;
use crate::method::energy;
use crate::output::snapshot::Snapshot;
use crate::state::{Balance, State};
use crate::{Error, Result};

impl<const D: usize> Scene<D> {
    /// Goes on from the `state` in which a run of the case `before` ended: with all that lasts, where grid, walls, bodies and the fluid's density are the same.
    /// Returns whether they are; if not, nothing is changed. Collective.
    ///
    /// # Errors
    /// When bodies are elsewhere than the case has them.
    pub fn go_on_from(&mut self, case: &Case, before: &Case, state: State<D>) -> Result<bool> {
        let method = |case: &Case| (case.coupling.wall, super::build::extrapolates(case));
        let grid = |case: &Case| (case.domain.clone(), (0..D).map(|a| case.periodic(a)).collect::<Vec<_>>());
        let density = |case: &Case| case.fluid.density;
        let same = method(case) == method(before) && grid(case) == grid(before) && density(case) == density(before);
        let alike = state.walls.is_some() == self.state.walls.is_some();
        if !same || !alike || state.bodies.len() != self.state.bodies.len() {
            return Ok(false);
        }
        let fresh = std::mem::replace(&mut self.state, state);
        let s = &mut self.state;
        (s.time, s.steps, s.substeps) = (0.0, 0, 0);
        let bodies = std::mem::replace(&mut s.bodies, fresh.bodies);
        for (k, (body, ended)) in s.bodies.iter_mut().zip(&bodies).enumerate() {
            if (body.centre - ended.centre).norm() > 1e-9 * body.radius() {
                return Err(Error::Usage(format!(
                    "initial.from: particle {k} is elsewhere in that run's newest checkpoint than in its particles.csv: bring it \
                     to its end with --resume"
                )));
            }
            (body.angle, body.orientation) = (ended.angle, ended.orientation);
        }
        if self.method.contacts().is_none_or(|contacts| contacts.check(&s.touching).is_err()) {
            s.touching = fresh.touching;
        }
        (s.drive, s.waiting) = (fresh.drive, fresh.waiting);
        s.balance = fresh.balance.map(|_| Balance::default());
        self.resume()?;
        self.method.rebalance(&self.domain, &mut self.state)?;
        energy::start(&mut self.domain, &mut self.state, &mut self.method)?;
        Ok(true)
    }

    /// Takes the velocity of a snapshot, on whatever grid, interpolated to this one's cells, and makes a consistent start of it.
    /// Collective.
    ///
    /// # Errors
    /// When it has no velocity, or the first projection fails.
    pub fn start_from(&mut self, snapshot: &Snapshot) -> Result<()> {
        let missing = || Error::Usage("initial.from: the last snapshot of that run has no velocity".into());
        let velocity = &snapshot.array("velocity").ok_or_else(missing)?.values;
        let grid = &self.domain.grid;
        for c in grid.rows().flatten() {
            let place = grid.centre(c);
            // By axis, the two cells beside the place and the share of the upper one; across a period the first follows the last.
            let between: [[(usize, f64); 2]; 3] = std::array::from_fn(|a| {
                if a >= D {
                    return [(0, 1.0), (0, 0.0)];
                }
                let (n, at) = (snapshot.cells[a] as i64, place[a] / snapshot.h[a] - 0.5);
                let (low, share) = (at.floor() as i64, at - at.floor());
                let cell = |i: i64| if grid.periodic[a] { i.rem_euclid(n) } else { i.clamp(0, n - 1) } as usize;
                [(cell(low), 1.0 - share), (cell(low + 1), share)]
            });
            for axis in 0..D {
                let mut sum = 0.0;
                for (k, j, i) in (0..8).map(|corner| (corner >> 2, corner >> 1 & 1, corner & 1)) {
                    let [(x, wx), (y, wy), (z, wz)] = [between[0][i], between[1][j], between[2][k]];
                    if wx * wy * wz > 0.0 {
                        let cell = x + snapshot.cells[0] * (y + snapshot.cells[1] * z);
                        sum += wx * wy * wz * velocity.get(3 * cell + axis).copied().unwrap_or(0.0);
                    }
                }
                self.state.u[axis][c] = sum;
            }
        }
        self.start()
    }
}
