//! Which of the first thousand things of a list something holds for, without a list.

/// Most that are told apart: it may hold for all others.
const MOST: usize = 1024;

/// Flags by number.
pub(crate) struct Flags {
    bits: [u64; MOST / 64],
    /// How many are set.
    pub count: usize,
}

impl Flags {
    pub fn none() -> Flags {
        Flags { bits: [0; MOST / 64], count: 0 }
    }

    pub fn add(&mut self, k: usize) {
        self.count += 1;
        if k < MOST {
            self.bits[k / 64] |= 1 << (k % 64);
        }
    }

    /// Whether one may be set.
    pub fn may(&self, k: u32) -> bool {
        let k = k as usize;
        k >= MOST || self.bits[k / 64] >> (k % 64) & 1 == 1
    }
}
