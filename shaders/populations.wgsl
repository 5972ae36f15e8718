// Populations, streamed in place by esoteric pull (src/lattice/grid.rs): one buffer per direction. Of every pair the `near`
// slot lies at the cell itself, the `far` slot at its neighbour along the first direction; which buffer is which changes with
// the parity of the step, by exchanging bind groups. Elements count the ghost layer: x + y STRIDE_Y + z STRIDE_Z.

override STRIDE_Y: u32 = 4u;
override STRIDE_Z: u32 = 16u;

@group(0) @binding(0) var<storage, read_write> rest: array<Stored>;
@group(0) @binding(1) var<storage, read_write> near_x: array<Stored>;
@group(0) @binding(2) var<storage, read_write> far_x: array<Stored>;
@group(0) @binding(3) var<storage, read_write> near_y: array<Stored>;
@group(0) @binding(4) var<storage, read_write> far_y: array<Stored>;
@group(0) @binding(5) var<storage, read_write> near_z: array<Stored>;
@group(0) @binding(6) var<storage, read_write> far_z: array<Stored>;
@group(0) @binding(7) var<storage, read_write> near_xy: array<Stored>;
@group(0) @binding(8) var<storage, read_write> far_xy: array<Stored>;
@group(0) @binding(9) var<storage, read_write> near_xz: array<Stored>;
@group(0) @binding(10) var<storage, read_write> far_xz: array<Stored>;
@group(0) @binding(11) var<storage, read_write> near_yz: array<Stored>;
@group(0) @binding(12) var<storage, read_write> far_yz: array<Stored>;
@group(0) @binding(13) var<storage, read_write> near_x_y: array<Stored>;
@group(0) @binding(14) var<storage, read_write> far_x_y: array<Stored>;
@group(0) @binding(15) var<storage, read_write> near_x_z: array<Stored>;
@group(0) @binding(16) var<storage, read_write> far_x_z: array<Stored>;
@group(0) @binding(17) var<storage, read_write> near_y_z: array<Stored>;
@group(0) @binding(18) var<storage, read_write> far_y_z: array<Stored>;

// Streamed populations of the cell at element `n`, about to be collided.
fn gather(n: u32) -> Populations {
    return Populations(
        unpacked(rest[n]),
        unpacked(near_x[n]),
        unpacked(far_x[n + 1u]),
        unpacked(near_y[n]),
        unpacked(far_y[n + STRIDE_Y]),
        unpacked(near_z[n]),
        unpacked(far_z[n + STRIDE_Z]),
        unpacked(near_xy[n]),
        unpacked(far_xy[n + 1u + STRIDE_Y]),
        unpacked(near_xz[n]),
        unpacked(far_xz[n + 1u + STRIDE_Z]),
        unpacked(near_yz[n]),
        unpacked(far_yz[n + STRIDE_Y + STRIDE_Z]),
        unpacked(near_x_y[n]),
        unpacked(far_x_y[n + 1u - STRIDE_Y]),
        unpacked(near_x_z[n]),
        unpacked(far_x_z[n + 1u - STRIDE_Z]),
        unpacked(near_y_z[n]),
        unpacked(far_y_z[n + STRIDE_Y - STRIDE_Z]),
    );
}

// Sends collided populations on their way: where the next step, of the other parity, finds them.
fn scatter(n: u32, f: Populations) {
    rest[n] = packed(f[0]);
    far_x[n + 1u] = packed(f[1]);
    near_x[n] = packed(f[2]);
    far_y[n + STRIDE_Y] = packed(f[3]);
    near_y[n] = packed(f[4]);
    far_z[n + STRIDE_Z] = packed(f[5]);
    near_z[n] = packed(f[6]);
    far_xy[n + 1u + STRIDE_Y] = packed(f[7]);
    near_xy[n] = packed(f[8]);
    far_xz[n + 1u + STRIDE_Z] = packed(f[9]);
    near_xz[n] = packed(f[10]);
    far_yz[n + STRIDE_Y + STRIDE_Z] = packed(f[11]);
    near_yz[n] = packed(f[12]);
    far_x_y[n + 1u - STRIDE_Y] = packed(f[13]);
    near_x_y[n] = packed(f[14]);
    far_x_z[n + 1u - STRIDE_Z] = packed(f[15]);
    near_x_z[n] = packed(f[16]);
    far_y_z[n + STRIDE_Y - STRIDE_Z] = packed(f[17]);
    near_y_z[n] = packed(f[18]);
}
