//! The operator's own preconditioner: one cycle of the multigrid, in single precision, made and
//! made anew when it is needed.

use super::bodies::Bodies;
use super::coefficient::Coefficient;
use super::multigrid::{Multigrid, Tuning};
use super::whole::Whole;
use crate::Result;
use crate::grid::simd;
use crate::petsc::Session;

/// The multigrid of a coefficient and of the bodies, once there is one.
pub(super) struct Preconditioner {
    session: Session,
    whole: Whole,
    /// The smallest spacing (m).
    narrowest: f64,
    made: Option<Multigrid>,
    /// Whether it has the present coefficient and bodies.
    valid: bool,
    /// The size of what it is applied to (1/s2): the same on every rank.
    size: f64,
    /// Setups so far.
    pub setups: u32,
}

impl Preconditioner {
    /// The preconditioner on a grid whose smallest spacing is `narrowest` (m).
    pub fn new(session: &Session, whole: Whole, narrowest: f64) -> Preconditioner {
        let session = session.clone();
        Preconditioner { session, whole, narrowest, made: None, valid: false, size: 1.0, setups: 0 }
    }

    /// Takes the size (1/s2) of what it is applied to from now on, within some thirty powers of
    /// ten: in single precision that has to lie around one. The same on every rank.
    pub fn set_size(&mut self, size: f64) {
        self.size = size;
    }

    /// Takes note of another coefficient, or of other bodies.
    pub fn outdate(&mut self) {
        self.valid = false;
    }

    /// The multigrid of the coefficient and the bodies. Collective.
    fn multigrid(
        &mut self,
        coefficient: &Coefficient,
        bodies: &mut Bodies,
    ) -> Result<&mut Multigrid> {
        let made = match &mut self.made {
            Some(made) => made,
            none => {
                let tuning = Tuning::read(&self.session)?;
                let whole = self.whole.clone();
                let singular = coefficient.singular;
                let resolving = bodies.resolving();
                none.insert(Multigrid::new(&self.session, whole, singular, tuning, resolving))
            }
        };
        if !self.valid {
            // In single precision the range of the coefficient has to lie around one.
            let scale = 1.0 / coefficient.largest;
            for (to, from) in made.levels[0].g.iter_mut().zip(&coefficient.g) {
                simd(
                    #[inline(always)]
                    || {
                        for (to, from) in to.iter_mut().zip(from) {
                            *to = (scale * from) as f32;
                        }
                    },
                );
            }
            let unit = coefficient.inverse_h2.map(|i| i * self.narrowest * self.narrowest);
            made.rebuild(bodies, unit, scale)?;
            self.setups += 1;
            self.valid = true;
        }
        Ok(made)
    }

    /// Sets `z` to the result of one cycle for `r`. Collective.
    pub fn apply(
        &mut self,
        coefficient: &Coefficient,
        bodies: &mut Bodies,
        r: &[f64],
        z: &mut [f64],
    ) -> Result<()> {
        let size = self.size;
        let multigrid = self.multigrid(coefficient, bodies)?;
        let down = 1.0 / size;
        let up = size / coefficient.largest;
        let finest = &mut multigrid.levels[0];
        let lattice = finest.lattice;
        let nx = lattice.n[0];
        let b = &mut finest.b;
        simd(
            #[inline(always)]
            || {
                for (s, r) in lattice.rows().zip(r.chunks_exact(nx)) {
                    b[s..][..nx].iter_mut().zip(r).for_each(
                        #[inline(always)]
                        |(b, r)| *b = (down * r) as f32,
                    );
                }
            },
        );
        multigrid.cycle(bodies, true)?;
        let x = &multigrid.levels[0].x;
        simd(
            #[inline(always)]
            || {
                for (s, z) in lattice.rows().zip(z.chunks_exact_mut(nx)) {
                    z.iter_mut().zip(&x[s..][..nx]).for_each(
                        #[inline(always)]
                        |(z, x)| *z = up * f64::from(*x),
                    );
                }
            },
        );
        Ok(())
    }
}
