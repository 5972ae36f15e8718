// Nothing: what a dispatch costs by itself (src/gpu/latency.rs).

@group(0) @binding(0) var<storage, read_write> untouched: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn empty(@builtin(local_invocation_index) local: u32) {
    // No thread has this number; without the line the buffer would not be bound.
    if local == WORKGROUP {
        untouched[0] = local;
    }
}
