// Points that are read alone.

@group(0) @binding(1) var<storage, read> whole: array<i32>;
@group(0) @binding(2) var<storage, read> remainder: array<f32>;
