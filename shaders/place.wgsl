// Puts populations where the cell at element `n` is about to gather them (populations.wgsl).
fn place(n: u32, f: Populations) {
    rest[n] = packed(f[0]);
    near_x[n] = packed(f[1]);
    far_x[n + 1u] = packed(f[2]);
    near_y[n] = packed(f[3]);
    far_y[n + STRIDE_Y] = packed(f[4]);
    near_z[n] = packed(f[5]);
    far_z[n + STRIDE_Z] = packed(f[6]);
    near_xy[n] = packed(f[7]);
    far_xy[n + 1u + STRIDE_Y] = packed(f[8]);
    near_xz[n] = packed(f[9]);
    far_xz[n + 1u + STRIDE_Z] = packed(f[10]);
    near_yz[n] = packed(f[11]);
    far_yz[n + STRIDE_Y + STRIDE_Z] = packed(f[12]);
    near_x_y[n] = packed(f[13]);
    far_x_y[n + 1u - STRIDE_Y] = packed(f[14]);
    near_x_z[n] = packed(f[15]);
    far_x_z[n + 1u - STRIDE_Z] = packed(f[16]);
    near_y_z[n] = packed(f[17]);
    far_y_z[n + STRIDE_Y - STRIDE_Z] = packed(f[18]);
}
