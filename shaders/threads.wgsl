// Threads of a dispatch, numbered along x; long dispatches are spread over two dimensions.

const WORKGROUP: u32 = 64u;

fn thread_index(group: vec3<u32>, groups: vec3<u32>, local: u32) -> u32 {
    return (group.y * groups.x + group.x) * WORKGROUP + local;
}
