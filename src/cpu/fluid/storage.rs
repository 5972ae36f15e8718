//! Memory of the populations: one mapping for all arrays, backed by huge pages where the system has them.
//!
//! A step walks through 38 streams at once. With 4 KiB pages that costs a page walk per stream every 64 cache lines, and hardware
//! prefetch stops there. Arrays that all begin at the same place in a page compete for the same sets of the cache. So each begins a
//! few lines further.

use std::ops::{Index, IndexMut, Range};

use memmap2::MmapMut;

use super::stored::Stored;
use crate::lattice::DIRECTION_COUNT;
use crate::lattice::grid::LINE_BYTES;

/// Lines by which the arrays' places in a page differ: nineteen of them spread over the 64 lines.
const STAGGER: usize = 3;

/// One array per direction, each beginning on a cache line.
#[derive(Debug)]
pub struct Storage<P> {
    map: MmapMut,
    /// Elements from array to array.
    stride: usize,
    /// Elements of an array.
    length: usize,
    element: std::marker::PhantomData<P>,
}

impl<P: Stored> Storage<P> {
    /// Arrays of `length` zeros; memory is touched when it is first written. Out of memory, the program stops as any allocation does.
    #[must_use]
    pub fn new(length: usize) -> Self {
        const PAGE_LINES: usize = 64;
        let lines = (length * size_of::<P>()).div_ceil(LINE_BYTES);
        let lines = lines + (PAGE_LINES + STAGGER - lines % PAGE_LINES) % PAGE_LINES;
        let bytes = DIRECTION_COUNT * lines * LINE_BYTES;
        let Ok(map) = MmapMut::map_anon(bytes) else {
            // Ends as any allocation of this size does.
            std::hint::black_box(Vec::<u8>::with_capacity(bytes));
            std::alloc::handle_alloc_error(std::alloc::Layout::new::<u8>())
        };
        // Advice only: without huge pages all works, some percent slower.
        #[cfg(target_os = "linux")]
        let _ = map.advise(memmap2::Advice::HugePage);
        Self {
            map,
            stride: lines * LINE_BYTES / size_of::<P>(),
            length,
            element: std::marker::PhantomData,
        }
    }

    fn range(&self, array: usize) -> Range<usize> {
        let first = array * self.stride;
        first..first + self.length
    }

    /// All arrays.
    pub fn arrays_mut(&mut self) -> [&mut [P]; DIRECTION_COUNT] {
        let length = self.length;
        let mut arrays = bytemuck::cast_slice_mut::<u8, P>(&mut self.map).chunks_mut(self.stride);
        std::array::from_fn(|_| match arrays.next() {
            Some(array) => &mut array[..length],
            None => Default::default(),
        })
    }
}

impl<P: Stored> Clone for Storage<P> {
    fn clone(&self) -> Self {
        let mut copy = Self::new(self.length);
        copy.map.copy_from_slice(&self.map);
        copy
    }
}

impl<P: Stored> Index<usize> for Storage<P> {
    type Output = [P];

    #[inline(always)]
    fn index(&self, array: usize) -> &[P] {
        &bytemuck::cast_slice(&self.map)[self.range(array)]
    }
}

impl<P: Stored> IndexMut<usize> for Storage<P> {
    #[inline(always)]
    fn index_mut(&mut self, array: usize) -> &mut [P] {
        let range = self.range(array);
        &mut bytemuck::cast_slice_mut(&mut self.map)[range]
    }
}
