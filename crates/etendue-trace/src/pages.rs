//! Memory for trees: huge pages where the system gives them.
//!
//! Incoherent rays jump about in tens of megabytes. With 4 KB pages most of these jumps also miss the processor's
//! cache of page addresses; with 2 MB pages next to none do. Linux gives huge pages to who asks for them
//! (`madvise`), which the standard allocator does not do.

use bytemuck::Pod;
use memmap2::{MmapMut, MmapOptions};

/// Below this size (bytes) an ordinary allocation is as good.
const SMALL: usize = 4 << 20;

/// A slice of zeroed elements, then filled in place.
pub enum Pages<T> {
    /// An ordinary allocation: small, or the system gave no mapping.
    Heap(Vec<T>),
    /// A mapping, and how many elements of it are in use.
    Mapped(MmapMut, usize),
}

impl<T: Pod> Pages<T> {
    /// `len` zeroed elements.
    pub fn zeroed(len: usize) -> Self {
        const { assert!(align_of::<T>() <= 4096, "mappings are aligned to pages") };
        let bytes = len * size_of::<T>();
        if bytes >= SMALL
            && let Ok(map) = MmapOptions::new().len(bytes).map_anon()
        {
            // Advice is advice: whoever does not take it gives small pages.
            #[cfg(target_os = "linux")]
            let _ = map.advise(memmap2::Advice::HugePage);
            return Self::Mapped(map, len);
        }
        Self::Heap(vec![T::zeroed(); len])
    }

    /// Memory held.
    pub fn bytes(&self) -> usize {
        size_of_val::<[T]>(self)
    }
}

impl<T: Pod> std::ops::Deref for Pages<T> {
    type Target = [T];
    #[inline(always)]
    fn deref(&self) -> &[T] {
        match self {
            Self::Heap(v) => v,
            Self::Mapped(m, len) => &bytemuck::cast_slice(m)[..*len],
        }
    }
}

impl<T: Pod> std::ops::DerefMut for Pages<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        match self {
            Self::Heap(v) => v,
            Self::Mapped(m, len) => &mut bytemuck::cast_slice_mut(m)[..*len],
        }
    }
}
