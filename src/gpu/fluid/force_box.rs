//! The body force near the sheet, as markers leave it for the next collision.

/// The box of cells that holds all forces on the air.
#[derive(Debug)]
pub struct ForceBox {
    /// Force of its cells.
    pub(in crate::gpu) forces: wgpu::Buffer,
    /// First cell.
    pub(in crate::gpu) first: [u32; 3],
    /// Size.
    pub(in crate::gpu) size: [u32; 3],
    /// Its number.
    pub(in crate::gpu) generation: u64,
}

impl ForceBox {
    /// First cell and end of the box.
    #[must_use]
    pub fn cells(&self) -> [[i32; 3]; 2] {
        let first = self.first.map(|place| place as i32);
        [
            first,
            std::array::from_fn(|a| first[a] + self.size[a] as i32),
        ]
    }
}
