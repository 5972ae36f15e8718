use super::*;
use crate::render::colour::ColourScale;
use crate::render::picture::{Camera, LineStyle, PixelRect, Polyline, Projection, Slice};

const WHITE: Rgb = [255, 255, 255];
const BLACK: Rgb = [0, 0, 0];

/// 200×100 px that show x from −2 to 2 m and z from −1 to 1 m, seen along +y from y = −10 m.
fn picture() -> Picture {
    Picture {
        width_px: 200,
        height_px: 100,
        page: WHITE,
        viewport: PixelRect {
            x: 0,
            y: 0,
            width: 200,
            height: 100,
        },
        background: [WHITE; 2],
        camera: Camera {
            eye_m: DVec3::new(0.0, -10.0, 0.0),
            target_m: DVec3::ZERO,
            up: DVec3::Z,
            projection: Projection::Orthographic { height_m: 2.0 },
        },
        surfaces: Vec::new(),
        polylines: Vec::new(),
        slices: Vec::new(),
        labels: Vec::new(),
        colour_bars: Vec::new(),
    }
}

fn perspective() -> Projection {
    Projection::Perspective {
        vertical_fov_rad: 2.0 * (0.1f64).atan(),
    }
}

fn surface(vertices_m: Vec<DVec3>, value: f64) -> Surface {
    Surface {
        vertices_m,
        triangles: vec![[0, 1, 2]],
        values: vec![value],
        range: [0.0, 1.0],
        scale: ColourScale::Inferno,
        mesh_edges: None,
        boundary: None,
    }
}

fn triangle(y: f64) -> Vec<DVec3> {
    vec![
        DVec3::new(-1.5, y, -0.8),
        DVec3::new(1.5, y, -0.8),
        DVec3::new(0.2, y, 0.9),
    ]
}

fn slice(y: f64, value: f32, opacity: f32, depth: SliceDepth) -> Slice {
    Slice {
        origin_m: DVec3::new(-1.0, y, -0.5),
        edges_m: [2.0 * DVec3::X, DVec3::Z],
        counts: [2, 2],
        values: vec![value; 4],
        range: [0.0, 1.0],
        scale: ColourScale::Inferno,
        opacity,
        depth,
    }
}

fn line(points: [DVec3; 2], width_px: f64) -> Polyline {
    let style = LineStyle {
        width_px,
        colour: BLACK,
        opacity: 1.0,
    };
    Polyline {
        points_m: points.to_vec(),
        style,
    }
}

fn draw(picture: &Picture) -> RgbImage {
    rasterise(picture).unwrap()
}

fn at(image: &RgbImage, x: u32, y: u32) -> Rgb {
    image.get_pixel(x, y).0
}

/// Sum over the pixels of how much they differ from white, 1 for black.
fn ink(image: &RgbImage) -> f64 {
    image
        .pixels()
        .map(|p| 1.0 - f64::from(p.0[1]) / 255.0)
        .sum()
}

#[test]
fn nearer_triangle_wins_in_any_order() {
    for projection in [picture().camera.projection, perspective()] {
        let mut picture = picture();
        picture.camera.projection = projection;
        picture.surfaces = vec![surface(triangle(1.0), 1.0), surface(triangle(0.0), 0.0)];
        let first = draw(&picture);
        picture.surfaces.reverse();
        assert!(first == draw(&picture));
        assert!(at(&first, 105, 60)[0] < 20, "the near one is black");
    }
}

#[test]
fn area_is_the_projected_area() {
    // Base 3 m, height 1.7 m, 50 px/m; perspective is set up to give the same scale at y = 0.
    let expected = 0.5 * 3.0 * 1.7 * 2500.0;
    for projection in [picture().camera.projection, perspective()] {
        let mut picture = picture();
        picture.camera.projection = projection;
        picture.surfaces = vec![surface(triangle(0.0), 0.0)];
        let area = ink(&draw(&picture));
        assert!((area / expected - 1.0).abs() < 0.02, "{area} {expected}");
    }
}

#[test]
fn both_sides_are_lit_alike() {
    let mut picture = picture();
    picture.surfaces = vec![surface(triangle(0.0), 1.0)];
    let front = draw(&picture);
    picture.surfaces[0].triangles = vec![[0, 2, 1]];
    let back = draw(&picture);
    assert_eq!(at(&front, 105, 60), at(&back, 105, 60));
    assert!(at(&front, 105, 60)[0] > 180);
    assert!(
        (ink(&front) - ink(&back)).abs() < 2.0,
        "samples on an edge belong to both"
    );
}

#[test]
fn odd_geometry_is_left_out() {
    let mut picture = picture();
    let empty = draw(&picture);
    let mut bad = triangle(0.0);
    bad[1].x = f64::NAN;
    let mut missing = surface(triangle(0.0), 0.0);
    missing.triangles = vec![[0, 1, 7]];
    let flat = surface(vec![DVec3::ZERO; 3], 0.0);
    let behind = surface(triangle(-11.0), 0.0);
    let aside = surface(
        triangle(0.0).iter().map(|p| *p + 1e30 * DVec3::X).collect(),
        0.0,
    );
    picture.surfaces = vec![surface(bad, 0.0), missing, flat, behind, aside];
    let infinite = DVec3::new(f64::INFINITY, 0.0, 0.0);
    picture.polylines = vec![
        line([DVec3::ZERO, infinite], 2.0),
        line([DVec3::ZERO; 2], f64::NAN),
    ];
    let mut folded = slice(0.0, 0.0, 1.0, SliceDepth::Tested);
    folded.edges_m[1] = folded.edges_m[0];
    picture.slices = vec![folded, slice(0.0, f32::NAN, 1.0, SliceDepth::Behind)];
    for projection in [picture.camera.projection, perspective()] {
        picture.camera.projection = projection;
        assert!(empty == draw(&picture));
    }
}

#[test]
fn near_plane_cuts_triangles_lines_and_slices() {
    let mut picture = picture();
    picture.camera.projection = perspective();
    let through = vec![
        DVec3::new(-1.0, -30.0, -0.5),
        DVec3::new(1.0, -30.0, -0.5),
        DVec3::new(0.0, 20.0, -0.5),
    ];
    picture.surfaces = vec![surface(through, 0.0)];
    assert!(ink(&draw(&picture)) > 100.0);
    picture.surfaces.clear();
    picture.polylines = vec![line(
        [DVec3::new(0.0, -30.0, -0.5), DVec3::new(0.0, 20.0, -0.5)],
        2.0,
    )];
    assert!(ink(&draw(&picture)) > 20.0);
    picture.polylines.clear();
    let mut floor = slice(0.0, 0.0, 1.0, SliceDepth::Tested);
    floor.origin_m = DVec3::new(-1.0, -30.0, -0.5);
    floor.edges_m[1] = 50.0 * DVec3::Y;
    picture.slices = vec![floor];
    assert!(ink(&draw(&picture)) > 100.0);
}

#[test]
fn lines_have_their_width_and_are_hidden() {
    let mut picture = picture();
    for width in [0.4, 1.0, 2.0, 5.0] {
        for end in [DVec3::new(1.0, 0.0, 0.0), DVec3::new(0.6, 0.0, 0.8)] {
            picture.polylines = vec![line([DVec3::ZERO, end], width)];
            let expected = 50.0 * width;
            let caps = width * width;
            let drawn = ink(&draw(&picture));
            assert!(
                (drawn - expected).abs() < 0.04 * expected + caps,
                "{width}: {drawn}"
            );
        }
    }
    picture.surfaces = vec![surface(triangle(-1.0), 1.0)];
    picture.polylines = vec![line([DVec3::ZERO, 0.5 * DVec3::X], 5.0)];
    let hidden = draw(&picture);
    picture.polylines.clear();
    assert!(hidden == draw(&picture));
}

#[test]
fn mesh_edges_lie_on_the_surface() {
    let mut picture = picture();
    picture.surfaces = vec![surface(triangle(0.0), 1.0)];
    let plain = draw(&picture);
    let style = LineStyle {
        width_px: 2.0,
        colour: BLACK,
        opacity: 1.0,
    };
    picture.surfaces[0].boundary = Some(style);
    let outlined = draw(&picture);
    assert!(at(&plain, 100, 89)[0] > 180 && at(&outlined, 100, 89)[0] < 60);
}

#[test]
fn slices_hide_and_are_hidden_by_depth() {
    let mut picture = picture();
    picture.surfaces = vec![surface(triangle(0.0), 0.0)];
    let red = |image: &RgbImage| at(image, 100, 50)[0];
    for (y, depth, shown) in [
        (-1.0, SliceDepth::Tested, true),
        (1.0, SliceDepth::Tested, false),
        (-1.0, SliceDepth::Behind, false),
    ] {
        picture.slices = vec![slice(y, 1.0, 1.0, depth)];
        assert_eq!(red(&draw(&picture)) > 200, shown, "{y} {depth:?}");
    }
    picture.slices = vec![slice(-1.0, 1.0, 0.5, SliceDepth::Tested)];
    assert!((110..=140).contains(&red(&draw(&picture))), "half of both");
}

#[test]
fn lines_fade_behind_translucent_slices() {
    let mut picture = picture();
    picture.slices = vec![slice(0.0, 1.0, 0.5, SliceDepth::Tested)];
    let shade = |y: f64, picture: &mut Picture| {
        let ends = [DVec3::new(-1.0, y, 0.0), DVec3::new(1.0, y, 0.0)];
        picture.polylines = vec![line(ends, 6.0)];
        at(&draw(picture), 100, 50)[0]
    };
    assert!(shade(-1.0, &mut picture) < 10);
    assert!((100..160).contains(&shade(1.0, &mut picture)));
}

#[test]
fn slices_interpolate_between_cell_centres() {
    let mut slice = slice(0.0, 0.0, 1.0, SliceDepth::Behind);
    slice.values = vec![0.0, 1.0, 2.0, 3.0];
    assert!((slice.value_at([0.25, 0.25]) - 0.0).abs() < 1e-12);
    assert!((slice.value_at([0.75, 0.25]) - 1.0).abs() < 1e-12);
    assert!((slice.value_at([0.5, 0.5]) - 1.5).abs() < 1e-12);
    assert!((slice.value_at([1.0, 1.0]) - 3.0).abs() < 1e-12);
}

#[test]
fn viewport_leaves_the_page_alone() {
    let mut picture = picture();
    picture.page = [9, 8, 7];
    picture.viewport = PixelRect {
        x: 50,
        y: 20,
        width: 100,
        height: 60,
    };
    let image = draw(&picture);
    assert_eq!(at(&image, 49, 50), [9, 8, 7]);
    assert_eq!(at(&image, 50, 20), WHITE);
    assert_eq!(at(&image, 149, 79), WHITE);
    assert_eq!(at(&image, 150, 80), [9, 8, 7]);
}

#[test]
fn impossible_pictures_are_errors() {
    let broken = |change: fn(&mut Picture)| {
        let mut picture = picture();
        change(&mut picture);
        rasterise(&picture).unwrap_err()
    };
    assert!(matches!(
        broken(|p| p.width_px = 0),
        RenderError::Size { .. }
    ));
    assert!(matches!(
        broken(|p| p.height_px = 1 << 20),
        RenderError::Size { .. }
    ));
    assert!(matches!(
        broken(|p| p.viewport.x = 1),
        RenderError::Viewport
    ));
    assert!(matches!(
        broken(|p| p.viewport.x = u32::MAX),
        RenderError::Viewport
    ));
    assert!(matches!(
        broken(|p| p.camera.up = DVec3::Y),
        RenderError::Camera { .. }
    ));
    assert!(matches!(
        broken(|p| p.camera.eye_m.x = f64::NAN),
        RenderError::Camera { .. }
    ));
    let short = |p: &mut Picture| {
        p.surfaces = vec![surface(triangle(0.0), 0.0)];
        p.surfaces[0].values.clear();
    };
    assert!(matches!(
        broken(short),
        RenderError::ValueCount {
            expected: 1,
            found: 0,
            ..
        }
    ));
    let long = |p: &mut Picture| {
        p.slices = vec![slice(0.0, 0.0, 1.0, SliceDepth::Behind)];
        p.slices[0].counts = [usize::MAX, 2];
    };
    assert!(matches!(
        broken(long),
        RenderError::ValueCount { found: 4, .. }
    ));
}

#[test]
fn neighbours_leave_no_gap() {
    let mut picture = picture();
    picture.background = [[255, 0, 0]; 2];
    for projection in [picture.camera.projection, perspective()] {
        picture.camera.projection = projection;
        let corner = |x: f64, z: f64| DVec3::new(x, 0.0, z);
        let mut square = surface(vec![corner(-0.9, -0.9), corner(0.9, -0.9)], 0.0);
        square
            .vertices_m
            .extend([corner(0.9, 0.9), corner(-0.9, 0.9)]);
        square.triangles = vec![[0, 1, 2], [2, 3, 0]];
        square.values = vec![0.0; 2];
        picture.surfaces = vec![square];
        let image = draw(&picture);
        assert!((60..140).all(|x| (10..90).all(|y| at(&image, x, y)[0] < 20)));
    }
}
