// Pictures: background, surfaces, slices ("sheets") and lines on pixels of four samples. Depth is 1 at the near plane and falls
// with distance. Places on the screen are counted in samples, GRID to a pixel along either axis, as the software rasteriser
// counts them (src/render/raster.rs), from the top left corner unless said otherwise.

const GRID: f32 = 2.0;

// Values below HOLE_LIMIT are holes of a sheet; the host writes them as HOLE.
const HOLE_LIMIT: f32 = -1.0e29;
const HOLE: f32 = -1.0e30;

struct RasterView {
    background_top: vec4<f32>,
    background_bottom: vec4<f32>,
    // Direction towards the lamp, and its share of the directed light.
    lamp: vec4<f32>,
    scale: vec2<f32>,
    size: vec2<f32>,
    near: f32,
    far: f32,
    depth_slope: f32,
    ambient: f32,
    perspective: u32,
    veils: u32,
    unused: vec2<u32>,
}

// The first two rows over the third are the place on the sheet, the fourth is the depth; all are affine functions of the place
// on the screen relative to the viewport's centre.
struct RasterSheet {
    first_place: vec4<f32>,
    second_place: vec4<f32>,
    weight: vec4<f32>,
    depth: vec4<f32>,
    opacity: f32,
    first_value: u32,
    columns: u32,
    rows: u32,
}

@group(0) @binding(0) var<uniform> view: RasterView;
@group(0) @binding(1) var<storage, read> sheets: array<RasterSheet>;
// Fractions of the colour scale.
@group(0) @binding(2) var<storage, read> sheet_values: array<f32>;
// 256 for each sheet, red in the lowest byte.
@group(0) @binding(3) var<storage, read> sheet_colours: array<u32>;

// Clip coordinates of view coordinates [m].
fn clip_place(point: vec3<f32>) -> vec4<f32> {
    let lateral = view.scale * point.xy;
    if view.perspective == 1u {
        return vec4<f32>(lateral, view.near, point.z);
    }
    return vec4<f32>(lateral, (view.far - point.z) * view.depth_slope, 1.0);
}

// Background -----------------------------------------------------------------------------------------------------------------

@vertex
fn background_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    // One triangle that holds the whole viewport.
    let x = select(-1.0, 3.0, index == 1u);
    let y = select(-1.0, 3.0, index == 2u);
    return vec4<f32>(x, y, 0.0, 1.0);
}

@fragment
fn background_fragment(@builtin(position) place: vec4<f32>) -> @location(0) vec4<f32> {
    return mix(view.background_top, view.background_bottom, GRID * place.y / view.size.y);
}

// Surfaces -------------------------------------------------------------------------------------------------------------------

struct SurfacePoint {
    @builtin(position) place: vec4<f32>,
    @location(0) @interpolate(perspective, centroid) normal: vec3<f32>,
    @location(1) @interpolate(flat) colour: vec4<f32>,
}

@vertex
fn surface_vertex(
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) colour: vec4<f32>,
) -> SurfacePoint {
    return SurfacePoint(clip_place(position), normal, colour);
}

@fragment
fn surface_fragment(point: SurfacePoint) -> @location(0) vec4<f32> {
    let normal = point.normal / max(length(point.normal), 1.0e-30);
    let lamp = max(dot(normal, view.lamp.xyz), 0.0);
    let eye = max(-normal.z, 0.0);
    let light = view.ambient + (1.0 - view.ambient) * mix(eye, lamp, view.lamp.w);
    return vec4<f32>(light * point.colour.rgb, 1.0);
}

// Sheets ---------------------------------------------------------------------------------------------------------------------

struct SheetPoint {
    @builtin(position) place: vec4<f32>,
    @location(0) @interpolate(flat) sheet: u32,
}

@vertex
fn sheet_vertex(@location(0) position: vec3<f32>, @location(1) sheet: u32) -> SheetPoint {
    return SheetPoint(clip_place(position), sheet);
}

// Bilinear interpolation between cell centres, held constant at the rim; HOLE next to a hole.
fn sheet_value(sheet: u32, place: vec2<f32>) -> f32 {
    let columns = sheets[sheet].columns;
    let rows = sheets[sheet].rows;
    let last = vec2<f32>(f32(columns - 1u), f32(rows - 1u));
    let position = clamp(place * (last + 1.0) - 0.5, vec2<f32>(0.0), last);
    let low = vec2<u32>(position);
    let high = min(low + 1u, vec2<u32>(columns - 1u, rows - 1u));
    let share = position - vec2<f32>(low);
    let start = sheets[sheet].first_value;
    let a = sheet_values[start + low.y * columns + low.x];
    let b = sheet_values[start + low.y * columns + high.x];
    let c = sheet_values[start + high.y * columns + low.x];
    let d = sheet_values[start + high.y * columns + high.x];
    if min(min(a, b), min(c, d)) < HOLE_LIMIT {
        return HOLE;
    }
    return mix(mix(a, b, share.x), mix(c, d, share.x), share.y);
}

// Place on a sheet that a place on the screen shows, and a positive number where it lies in front of the eye.
fn sheet_place(sheet: u32, screen: vec3<f32>) -> vec3<f32> {
    let weight = dot(sheets[sheet].weight.xyz, screen);
    let place = vec2<f32>(
        dot(sheets[sheet].first_place.xyz, screen),
        dot(sheets[sheet].second_place.xyz, screen),
    );
    return vec3<f32>(place / weight, weight);
}

fn from_centre(pixel: vec2<f32>) -> vec3<f32> {
    return vec3<f32>(GRID * pixel - 0.5 * view.size, 1.0);
}

@fragment
fn sheet_fragment(point: SheetPoint) -> @location(0) vec4<f32> {
    // Where a pixel's four samples lie.
    var offsets = array<vec2<f32>, 4>(
        vec2<f32>(-0.125, -0.375),
        vec2<f32>(0.375, -0.125),
        vec2<f32>(-0.375, 0.125),
        vec2<f32>(0.125, 0.375),
    );
    var sum = vec3<f32>(0.0);
    var count = 0.0;
    for (var k = 0u; k < 4u; k++) {
        let place = sheet_place(point.sheet, from_centre(point.place.xy + offsets[k])).xy;
        let value = sheet_value(point.sheet, place);
        if value > HOLE_LIMIT {
            let shade = u32(255.0 * clamp(value, 0.0, 1.0) + 0.5);
            sum += unpack4x8unorm(sheet_colours[256u * point.sheet + shade]).rgb;
            count += 1.0;
        }
    }
    if count == 0.0 {
        discard;
    }
    // The rim of a hole is smoothed by opacity: naga 30 writes a sample mask that Vulkan's validation refuses.
    return vec4<f32>(sum / count, 0.25 * count * sheets[point.sheet].opacity);
}

// Share of the light from a place on the screen at a depth that passes the translucent sheets in front.
fn passing(pixel: vec2<f32>, depth: f32) -> f32 {
    let screen = from_centre(pixel);
    var passes = 1.0;
    for (var sheet = 0u; sheet < view.veils; sheet++) {
        let nearness = dot(sheets[sheet].depth.xyz, screen);
        let place = sheet_place(sheet, screen);
        let hit = place.z > 0.0 && nearness > depth && nearness <= 1.0
            && all(place.xy >= vec2<f32>(0.0)) && all(place.xy <= vec2<f32>(1.0));
        if hit && sheet_value(sheet, place.xy) > HOLE_LIMIT {
            passes *= 1.0 - sheets[sheet].opacity;
        }
    }
    return passes;
}

// Lines ----------------------------------------------------------------------------------------------------------------------

struct LinePoint {
    @builtin(position) place: vec4<f32>,
    @location(0) @interpolate(flat) ends: vec4<f32>,
    // Half the width [samples] and the opacity.
    @location(1) @interpolate(flat) look: vec2<f32>,
    @location(2) @interpolate(flat) colour: vec4<f32>,
}

// Corner `index` of a strip of three rectangles along the line: one before its start, the stretch itself, one past its end.
// The outer two keep the depth of the ends; all reach `reach` samples to either side.
fn strip_corner(index: u32, ends: vec4<f32>, depths: vec2<f32>, reach: f32) -> vec4<f32> {
    let span = ends.zw - ends.xy;
    let length = length(span);
    let along = select(vec2<f32>(1.0, 0.0), span / max(length, 1.0e-30), length > 1.0e-6);
    let across = vec2<f32>(-along.y, along.x) * select(-reach, reach, (index & 1u) == 1u);
    let station = index / 2u;
    let start = station < 2u;
    let end = select(ends.zw, ends.xy, start);
    let beyond = select(0.0, select(reach, -reach, start), station == 0u || station == 3u);
    let place = (end + beyond * along + across) / view.size;
    return vec4<f32>(
        2.0 * place.x - 1.0,
        1.0 - 2.0 * place.y,
        select(depths.y, depths.x, start),
        1.0,
    );
}

@vertex
fn line_vertex(
    @builtin(vertex_index) index: u32,
    @location(0) ends: vec4<f32>,
    @location(1) depths: vec2<f32>,
    @location(2) look: vec2<f32>,
    @location(3) colour: vec4<f32>,
) -> LinePoint {
    // Room for the smooth rim and for pixels of which it covers but a part.
    return LinePoint(strip_corner(index, ends, depths, look.x + 2.5), ends, look, colour);
}

fn line_coverage(at: vec2<f32>, ends: vec4<f32>, radius: f32) -> f32 {
    let span = ends.zw - ends.xy;
    let offset = at - ends.xy;
    let t = clamp(dot(offset, span) / max(dot(span, span), 1.0e-30), 0.0, 1.0);
    return clamp(radius + 0.5 - distance(offset, t * span), 0.0, 1.0);
}

@fragment
fn line_fragment(point: LinePoint) -> @location(0) vec4<f32> {
    let radius = point.look.x;
    let at = GRID * point.place.xy;
    let coverage = 0.25
        * (line_coverage(at + vec2<f32>(-0.5, -0.5), point.ends, radius)
            + line_coverage(at + vec2<f32>(0.5, -0.5), point.ends, radius)
            + line_coverage(at + vec2<f32>(-0.5, 0.5), point.ends, radius)
            + line_coverage(at + vec2<f32>(0.5, 0.5), point.ends, radius));
    let opacity = coverage * point.look.y * passing(point.place.xy, point.place.z);
    if opacity <= 0.0 {
        discard;
    }
    return vec4<f32>(point.colour.rgb, opacity);
}

// The part of a line that hides what is behind it.
@vertex
fn line_core_vertex(
    @builtin(vertex_index) index: u32,
    @location(0) ends: vec4<f32>,
    @location(1) depths: vec2<f32>,
    @location(2) look: vec2<f32>,
) -> @builtin(position) vec4<f32> {
    return strip_corner(index, ends, depths, look.x);
}

@fragment
fn line_core_fragment() -> @location(0) vec4<f32> {
    return vec4<f32>(0.0);
}
