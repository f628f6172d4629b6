//! The system's allocator, with huge pages asked for where arrays are large.
//!
//! A field of a grid is read row by row and plane by plane: with pages of 4 kB each row is on a
//! page of its own, and the processor spends a part of its time to look up where pages are. Linux
//! gives pages of 2 MB to who asks for them (`madvise`), unless they are switched off.

use rustix::mm::{Advice, madvise};
use std::alloc::{GlobalAlloc, Layout, System};
use std::ffi::c_void;

/// Size (bytes) of a huge page of x86-64 and of AArch64 with pages of 4 kB: no smaller array has
/// one to itself.
const HUGE: usize = 2 << 20;
/// Size (bytes) of a page; a larger one refuses the request, which is no more than a wish.
const PAGE: usize = 4096;

/// The system's allocator, with huge pages for large arrays.
pub struct HugePages;

/// Asks for huge pages for the whole pages of an array.
fn advise(start: *mut u8, size: usize) {
    if size < HUGE || start.is_null() {
        return;
    }
    let skipped = start.align_offset(PAGE);
    let pages = (size - skipped) / PAGE * PAGE;
    // SAFETY: these pages lie inside an allocation that has just been made, and how they are backed
    // changes nothing of what they hold. A system that has no huge pages says so, and that is all.
    let _ = unsafe { madvise(start.add(skipped).cast::<c_void>(), pages, Advice::LinuxHugepage) };
}

// SAFETY: every call is handed on to the system's allocator as it is.
unsafe impl GlobalAlloc for HugePages {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller keeps the same promises.
        let start = unsafe { System.alloc(layout) };
        advise(start, layout.size());
        start
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller keeps the same promises.
        let start = unsafe { System.alloc_zeroed(layout) };
        advise(start, layout.size());
        start
    }

    unsafe fn realloc(&self, old: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: the caller keeps the same promises.
        let start = unsafe { System.realloc(old, layout, size) };
        advise(start, size);
        start
    }

    unsafe fn dealloc(&self, start: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the same promises.
        unsafe { System.dealloc(start, layout) }
    }
}
