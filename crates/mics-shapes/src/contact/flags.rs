//! Flags of the first thousand items of a list, in a few words of memory.

/// Number of items that are told apart: for all others the flag may be set.
const MOST: usize = 1024;

/// Flags by number.
pub(crate) struct Flags {
    bits: [u64; MOST / 64],
    /// Number of flags that are set.
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
