//! How far an import is.

use std::sync::atomic::{AtomicU64, Ordering};

/// Pictures and meshes of glTF files that are ready, of how many; may be read from another thread. Both numbers grow if one
/// progress serves several models or moments.
#[derive(Debug, Default)]
pub struct ImportProgress {
    done: AtomicU64,
    total: AtomicU64,
}

impl ImportProgress {
    /// Pictures and meshes that are ready.
    pub fn done(&self) -> u64 {
        self.done.load(Ordering::Relaxed)
    }

    /// Pictures and meshes that are known to be needed; 0 until the document is read.
    pub fn total(&self) -> u64 {
        self.total.load(Ordering::Relaxed)
    }

    pub(crate) fn expect(&self, more: usize) {
        self.total.fetch_add(more as u64, Ordering::Relaxed);
    }

    pub(crate) fn step(&self) {
        self.done.fetch_add(1, Ordering::Relaxed);
    }
}
