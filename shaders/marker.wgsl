// A marker of the immersed boundary in the order of cells. Mirrors gpu::immersed::Marker.
struct Marker {
    // Number in the box of the first cell under the kernel.
    corner: u32,
    // Rest area [cells^2].
    area: f32,
    // How its kernel is folded at faces (folded_kernels.wgsl).
    fold: u32,
    // Its number in the order of the fabric.
    number: u32,
    // Distance from the second cell under the kernel along x, y, z [cells], in 0..1.
    fraction: vec4<f32>,
}

