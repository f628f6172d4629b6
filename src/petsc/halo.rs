//! The halo exchange: ghost layers from the neighbouring ranks, one axis at a time.
//!
//! ```text
//!   ghosts  | owned cells                     | ghosts
//!   . . .   | a a a . . . . . . . . . . b b b | . . .
//!     ^ the neighbour below's b         the neighbour above's a ^
//! ```
//! Slabs span the stored extent of the other axes, so that doing the axes in order fills edges and
//! corners too.

use super::{Layout, Number, Session};
use crate::Result;

/// Fills ghost layers that belong to other ranks, or to this one across a period.
pub struct Halo<T = f64> {
    session: Session,
    axes: [Axis; 3],
    send: Vec<T>,
    receive: Vec<T>,
}

/// Storage of one axis: `outer` blocks of `stored` slabs of `inner` contiguous numbers.
#[derive(Clone, Copy)]
struct Axis {
    outer: usize,
    stored: usize,
    inner: usize,
    local: usize,
    ghosts: usize,
    /// Layers that an exchange fills.
    layers: usize,
    neighbours: [Option<usize>; 2],
}

impl<T: Number> Halo<T> {
    /// A halo for fields stored as `layout` says.
    pub fn new(session: &Session, layout: &Layout) -> Halo<T> {
        let total: usize = layout.stored.iter().product();
        let axes = std::array::from_fn(|a| {
            let inner: usize = layout.stored[..a].iter().product();
            Axis {
                outer: total / (inner * layout.stored[a]),
                stored: layout.stored[a],
                inner,
                local: layout.local[a],
                ghosts: layout.ghosts,
                layers: layout.ghosts,
                neighbours: layout.neighbours[a],
            }
        });
        let largest = axes.iter().map(|a: &Axis| a.outer * a.inner * a.ghosts).max().unwrap_or(0);
        let buffer = if session.size() > 1 { largest } else { 0 };
        Halo {
            session: session.clone(),
            axes,
            send: vec![T::ZERO; buffer],
            receive: vec![T::ZERO; buffer],
        }
    }

    /// Fills the first `layers` of ghosts on both sides of `axis` where a neighbour owns them.
    /// Collective, with the same number on all ranks.
    pub fn exchange(&mut self, axis: usize, layers: usize, field: &mut [T]) -> Result<()> {
        let a = Axis { layers, ..self.axes[axis] };
        match a.neighbours {
            [None, None] => return Ok(()),
            [Some(low), Some(high)] if low == self.session.rank() && high == low => {
                a.wrap(field);
                return Ok(());
            }
            _ => {}
        }
        // Downwards: my first owned layers become the ghosts above my lower neighbour; then
        // upwards.
        for (to, from, source, target) in [
            (0, 1, a.ghosts, a.ghosts + a.local),
            (1, 0, a.ghosts + a.local - layers, a.ghosts - layers),
        ] {
            let n = a.outer * a.inner * layers;
            if a.neighbours[to].is_some() {
                a.copy_out(source, field, &mut self.send);
            }
            let Halo { session, send, receive, .. } = &mut *self;
            session.swap(&send[..n], a.neighbours[to], &mut receive[..n], a.neighbours[from])?;
            if a.neighbours[from].is_some() {
                a.copy_in(target, field, &self.receive);
            }
        }
        Ok(())
    }
}

impl Axis {
    fn slab(&self, block: usize, layer: usize) -> std::ops::Range<usize> {
        let at = (block * self.stored + layer) * self.inner;
        at..at + self.layers * self.inner
    }

    fn copy_out<T: Copy>(&self, layer: usize, field: &[T], buffer: &mut [T]) {
        for (block, part) in
            buffer.chunks_exact_mut(self.layers * self.inner).take(self.outer).enumerate()
        {
            part.copy_from_slice(&field[self.slab(block, layer)]);
        }
    }

    fn copy_in<T: Copy>(&self, layer: usize, field: &mut [T], buffer: &[T]) {
        for (block, part) in
            buffer.chunks_exact(self.layers * self.inner).take(self.outer).enumerate()
        {
            field[self.slab(block, layer)].copy_from_slice(part);
        }
    }

    fn wrap<T: Copy>(&self, field: &mut [T]) {
        for block in 0..self.outer {
            field.copy_within(
                self.slab(block, self.ghosts),
                self.slab(block, self.ghosts + self.local).start,
            );
            let last = self.ghosts + self.local - self.layers;
            let below = self.ghosts - self.layers;
            field.copy_within(self.slab(block, last), self.slab(block, below).start);
        }
    }
}
