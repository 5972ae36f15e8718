use super::*;
use crate::frame::StructureFrame;
use crate::frame::{CableKind, FabricState};
use crate::render::content::{SPEED_SCALE, range_from_zero};
use crate::render::picture::Projection;
use crate::render::{rasterise, snapshot_png_bytes};

/// A square of fabric across the stream at x = 0 with two lines to a point upstream.
fn structure() -> StructureFrame {
    let corner = |y: f64, z: f64| DVec3::new(0.0, y, z);
    StructureFrame {
        positions_m: vec![
            corner(-0.5, -0.5),
            corner(0.5, -0.5),
            corner(0.5, 0.5),
            corner(-0.5, 0.5),
            DVec3::new(-1.0, 0.0, 0.0),
        ],
        velocities_m_s: vec![DVec3::ZERO; 5],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        reactions_n: vec![DVec3::ZERO; 5],
        contact_forces_n: None,
        principal_tensions_n_m: vec![[4.0, 1.0], [8.0, 1.0]],
        tension_directions: vec![DVec3::Y; 2],
        stress_pa: vec![4e4, 8e4],
        true_stress_pa: vec![4e4, 8e4],
        von_mises_pa: vec![4e4, 8e4],
        shear_stress_pa: vec![0.0; 2],
        shear_strain: vec![0.0; 2],
        principal_strains: vec![[1e-3, 0.0]; 2],
        yield_stress_pa: None,
        rest_areas_m2: vec![1.0; 2],
        states: vec![FabricState::Taut; 2],
        cables: vec![[0, 4], [4, 2]],
        cable_kinds: vec![CableKind::SuspensionLine; 2],
        cable_tensions_n: vec![1.0; 2],
    }
}

/// 4×2×2 m of air around the origin at 3 m/s and, for y above 0, 6 m/s.
fn fluid() -> FluidFrame {
    let cells = [16, 8, 8];
    let velocity_m_s: Vec<_> = (0..1024)
        .map(|k| {
            if (k / 16) % 8 < 4 {
                [3.0, 0.0, 0.0]
            } else {
                [0.0, 6.0, 0.0]
            }
        })
        .collect();
    FluidFrame {
        finer: Vec::new(),
        origin_m: DVec3::new(-1.875, -0.875, -0.875),
        cell_size_m: 0.25,
        cells,
        pressure_pa: vec![0.0; velocity_m_s.len()],
        velocity_m_s,
    }
}

fn frame(fluid: Option<FluidFrame>, structure: Option<StructureFrame>) -> Frame {
    Frame {
        time_s: 0.045,
        step: 1,
        fluid,
        structure,
        bodies: None,
    }
}

fn height(picture: &Picture) -> f64 {
    let Projection::Orthographic { height_m } = picture.camera.projection else {
        panic!()
    };
    height_m
}

#[test]
fn everything_is_shown() {
    let options = PictureOptions {
        title: Some("Title".to_owned()),
        caption: Some("C_D 0.74".to_owned()),
        ..PictureOptions::default()
    };
    let picture = picture_of(&frame(Some(fluid()), Some(structure())), &options);
    // Nodes 0 and 2 belong to both triangles and carry the mean 6; 1 and 3 carry 4 and 8.
    assert_eq!(picture.surfaces[0].values, [16.0 / 3.0, 20.0 / 3.0]);
    assert_eq!(picture.surfaces[0].range, [0.0, 8.0]);
    assert_eq!(
        picture.polylines.len(),
        1,
        "the two lines join at the point"
    );
    assert_eq!(picture.slices[0].counts, [16, 8]);
    assert!((picture.slices[0].centre_m()).abs_diff_eq(DVec3::ZERO, 1e-12));
    let titles: Vec<&str> = picture
        .colour_bars
        .iter()
        .map(|bar| bar.title.as_str())
        .collect();
    assert_eq!(titles, ["Tension [N/m]", "Air speed [m/s]"]);
    let texts: Vec<&str> = picture
        .labels
        .iter()
        .map(|label| label.text.as_str())
        .collect();
    assert_eq!(texts, ["t = 0.0450 s", "Title", "C_D 0.74"]);
    let image = rasterise(&picture).unwrap();
    assert_eq!(image.dimensions(), (1280, 720));
}

fn speed_slice(normal: Axis, place_m: f64) -> Slice {
    let fluid = fluid();
    let plane = flow::Section::new(&fluid, normal, place_m).unwrap();
    let mut slices = plane.slices(FlowQuantity::Speed, SliceDepth::Behind);
    slices.remove(0)
}

#[test]
fn slice_interpolates_across_its_plane() {
    // Between cells at 3 m/s along x and 6 m/s along y: half of both vectors.
    let slice = speed_slice(Axis::Y, 0.0);
    assert!((slice.values[0] - (1.5f32.powi(2) + 3.0f32.powi(2)).sqrt()).abs() < 1e-5);
    let slice = speed_slice(Axis::Y, -9.0);
    assert_eq!(slice.values[0], 3.0);
    assert_eq!(slice.origin_m, DVec3::new(-2.0, -1.0, -1.0));
    let slice = speed_slice(Axis::X, 0.0);
    assert_eq!(
        (slice.counts, slice.values[3], slice.values[4]),
        ([8, 8], 3.0, 6.0)
    );
}

#[test]
fn given_ranges_and_box_are_kept() {
    let options = PictureOptions {
        fabric_range: Some([0.0, 50.0]),
        flow_range: Some([1.0, 9.0]),
        framing_box_m: Some([DVec3::splat(-0.6), DVec3::splat(0.6)]),
        ..PictureOptions::default()
    };
    let mut moved = structure();
    let still = picture_of(&frame(Some(fluid()), Some(structure())), &options);
    moved.positions_m.iter_mut().for_each(|p| *p *= 0.5);
    let picture = picture_of(&frame(Some(fluid()), Some(moved)), &options);
    assert_eq!(picture.surfaces[0].range, [0.0, 50.0]);
    assert_eq!(picture.slices[0].range, [1.0, 9.0]);
    assert_eq!(picture.camera, still.camera);
}

#[test]
fn wrinkles_are_orange_with_strokes_along_them() {
    let mut wrinkled = structure();
    wrinkled.states = vec![FabricState::Taut, FabricState::Wrinkled];
    let options = PictureOptions {
        fabric: FabricQuantity::Wrinkles,
        mesh_edges: false,
        ..PictureOptions::default()
    };
    let picture = picture_of(&frame(None, Some(wrinkled)), &options);
    let surface = &picture.surfaces[0];
    let colours = surface
        .values
        .iter()
        .map(|v| surface.scale.of(*v, surface.range));
    assert_eq!(
        colours.collect::<Vec<_>>(),
        [[86, 180, 233], [230, 159, 0]],
        "values are not smoothed"
    );
    // One line to the point upstream, and one stroke across the middle of the second triangle along y.
    let stroke = &picture.polylines.last().unwrap().points_m;
    assert_eq!(picture.polylines.len(), 2);
    let middle = 0.5 * (stroke[0] + stroke[1]);
    assert!(middle.abs_diff_eq(DVec3::new(0.0, -1.0 / 6.0, 1.0 / 6.0), 1e-12));
    assert_eq!((stroke[1] - stroke[0]).normalize(), DVec3::Y);
    let marks = &picture.colour_bars[0].ticks;
    assert_eq!(
        marks.iter().map(|t| &t.text[..]).collect::<Vec<_>>(),
        ["taut", "wrinkled", "slack"]
    );
    rasterise(&picture).unwrap();
}

/// A wing that is held rigid has tensions of round-off: they are no colours, and no bar says what they would mean.
#[test]
fn fabric_without_strain_is_grey() {
    let mut rigid = structure();
    rigid.principal_tensions_n_m = vec![[3e-13, 1e-13], [5e-13, -2e-13]];
    rigid.principal_strains = vec![[2e-16, -3e-13]; 2];
    rigid.states = vec![FabricState::Wrinkled; 2];
    let mut strained = rigid.clone();
    strained.principal_strains[1][1] = -1e-7;
    for quantity in FabricQuantity::ALL {
        let options = PictureOptions {
            fabric: quantity,
            ..PictureOptions::default()
        };
        let picture_of = |structure: &StructureFrame| {
            picture_of(&frame(Some(fluid()), Some(structure.clone())), &options)
        };
        let picture = picture_of(&rigid);
        assert!(picture.surfaces[0].values.iter().all(|v| v.is_nan()));
        let titles: Vec<&str> = picture.colour_bars.iter().map(|bar| &*bar.title).collect();
        assert_eq!(titles, ["Air speed [m/s]"], "{}", quantity.name());
        assert_eq!(picture.polylines.len(), 1, "no strokes along wrinkles");
        rasterise(&picture).unwrap();
        let picture = picture_of(&strained);
        assert_eq!(picture.colour_bars.len(), 2, "{}", quantity.name());
        assert!(picture.surfaces[0].values.iter().all(|v| v.is_finite()));
    }
}

#[test]
fn range_leaves_out_the_highest_values() {
    let values = (0..100).map(f64::from).chain([f64::NAN]);
    assert_eq!(range_from_zero(values), [0.0, 97.0]);
    assert_eq!(range_from_zero([0.0, -1.0].into_iter()), [0.0, 1.0]);
    assert_eq!(range_from_zero(std::iter::empty()), [0.0, 1.0]);
}

#[test]
fn whole_domain_is_wider_than_the_structure() {
    let mut small = structure();
    small.positions_m.iter_mut().for_each(|p| *p *= 0.3);
    let frame = frame(Some(fluid()), Some(small));
    let options = PictureOptions::default();
    let near = height(&picture_of(&frame, &options));
    let far = height(&picture_of(
        &frame,
        &PictureOptions {
            whole_domain: true,
            ..options
        },
    ));
    assert!(far > 1.5 * near, "{far} {near}");
}

#[test]
fn air_alone_fills_a_viewport_of_its_shape() {
    let mut thin = fluid();
    thin.cells = [16, 16, 4];
    let picture = picture_of(&frame(Some(thin), None), &PictureOptions::default());
    assert_eq!(
        picture.slices[0].counts,
        [16, 16],
        "seen along the thinnest axis"
    );
    assert!((picture.viewport.aspect() - 1.0).abs() < 0.01);
    assert!((height(&picture) - 4.0).abs() < 0.01);
    let image = rasterise(&picture).unwrap();
    let port = picture.viewport;
    let corner = image.get_pixel(port.x + 1, port.y + port.height - 2).0;
    assert_eq!(corner, SPEED_SCALE.of(3.0, picture.slices[0].range));
}

#[test]
fn structure_alone_lies_within_the_view() {
    let mut cable = structure();
    cable.triangles.clear();
    for structure in [structure(), cable] {
        let bars = usize::from(!structure.triangles.is_empty());
        let picture = picture_of(&frame(None, Some(structure)), &PictureOptions::default());
        assert_eq!(picture.colour_bars.len(), bars);
        let port = picture.viewport;
        let image = rasterise(&picture).unwrap();
        let dark = |x: u32, y: u32| image.get_pixel(x, y).0[1] < 150;
        let rows = port.y..port.y + port.height;
        let columns = port.x..port.x + port.width;
        assert!(rows.clone().any(|y| columns.clone().any(|x| dark(x, y))));
        assert!(
            !rows
                .clone()
                .any(|y| dark(columns.start, y) || dark(columns.end - 1, y))
        );
        assert!(
            !columns
                .clone()
                .any(|x| dark(x, rows.start) || dark(x, rows.end - 1))
        );
    }
}

#[test]
fn odd_frames_and_sizes_still_give_pictures() {
    let mut lost = structure();
    lost.positions_m.iter_mut().for_each(|p| *p = DVec3::NAN);
    lost.principal_tensions_n_m.clear();
    lost.cables.push([7, 8]);
    lost.cable_kinds.push(CableKind::Belt);
    let mut hollow = fluid();
    hollow.velocity_m_s.truncate(100);
    let mut empty = fluid();
    empty.cells = [0, 8, 8];
    let frames = [
        frame(None, None),
        frame(None, Some(lost.clone())),
        frame(Some(fluid()), Some(lost)),
        frame(Some(hollow), None),
        frame(Some(empty.clone()), None),
        frame(Some(empty), Some(structure())),
    ];
    for (width_px, height_px) in [(320, 180), (40, 300), (1, 1)] {
        for whole_domain in [false, true] {
            let options = PictureOptions {
                width_px,
                height_px,
                whole_domain,
                ..PictureOptions::default()
            };
            for frame in &frames {
                rasterise(&picture_of(frame, &options)).unwrap();
            }
        }
    }
}

#[test]
fn png_bytes_are_a_png() {
    let options = PictureOptions {
        width_px: 320,
        height_px: 180,
        ..PictureOptions::default()
    };
    let bytes = snapshot_png_bytes(&frame(Some(fluid()), Some(structure())), &options).unwrap();
    let image = image::load_from_memory(&bytes).unwrap();
    assert_eq!((image.width(), image.height()), (320, 180));
    let again = snapshot_png_bytes(&frame(Some(fluid()), Some(structure())), &options).unwrap();
    assert_eq!(bytes, again);
    let nothing = PictureOptions {
        width_px: 0,
        ..options
    };
    assert!(snapshot_png_bytes(&frame(None, None), &nothing).is_err());
}
