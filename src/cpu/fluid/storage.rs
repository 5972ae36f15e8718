//! Memory of the populations: one mapping for all arrays, backed by huge pages where the system has them.
//!
//! A step walks through 38 streams at once. With 4 KiB pages that costs a page walk per stream every 64 cache lines, and hardware
//! prefetch stops there; arrays that all begin at the same place in a page compete for the same sets of the cache, so each begins a
//! few lines further.

use std::ops::{Index, IndexMut, Range};

use memmap2::MmapMut;

use crate::lattice::grid::LINE_BYTES;
use crate::lattice::{DIRECTION_COUNT, Real};

/// Lines by which the arrays' places in a page differ: nineteen of them spread over the 64 lines.
const STAGGER: usize = 3;

/// One array per direction, each beginning on a cache line.
#[derive(Debug)]
pub struct Storage<T> {
    map: MmapMut,
    /// Elements from array to array.
    stride: usize,
    /// Elements of an array.
    length: usize,
    element: std::marker::PhantomData<T>,
}

impl<T: Real> Storage<T> {
    /// Arrays of `length` zeros; memory is touched when it is first written. Out of memory, the program stops as any allocation does.
    #[must_use]
    pub fn new(length: usize) -> Self {
        const PAGE_LINES: usize = 64;
        let lines = (length * size_of::<T>()).div_ceil(LINE_BYTES);
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
            stride: lines * LINE_BYTES / size_of::<T>(),
            length,
            element: std::marker::PhantomData,
        }
    }

    fn range(&self, array: usize) -> Range<usize> {
        let first = array * self.stride;
        first..first + self.length
    }

    /// All arrays.
    pub fn arrays_mut(&mut self) -> [&mut [T]; DIRECTION_COUNT] {
        let length = self.length;
        let mut arrays = bytemuck::cast_slice_mut::<u8, T>(&mut self.map).chunks_mut(self.stride);
        std::array::from_fn(|_| match arrays.next() {
            Some(array) => &mut array[..length],
            None => Default::default(),
        })
    }
}

impl<T: Real> Clone for Storage<T> {
    fn clone(&self) -> Self {
        let mut copy = Self::new(self.length);
        copy.map.copy_from_slice(&self.map);
        copy
    }
}

impl<T: Real> Index<usize> for Storage<T> {
    type Output = [T];

    #[inline(always)]
    fn index(&self, array: usize) -> &[T] {
        &bytemuck::cast_slice(&self.map)[self.range(array)]
    }
}

impl<T: Real> IndexMut<usize> for Storage<T> {
    #[inline(always)]
    fn index_mut(&mut self, array: usize) -> &mut [T] {
        let range = self.range(array);
        &mut bytemuck::cast_slice_mut(&mut self.map)[range]
    }
}
