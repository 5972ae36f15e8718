use super::*;

/// Rigid rotation about y with 3 rad/s and pressure x + 10 z, on 6 × 4 × 5 cells of 0.5 m.
fn turning() -> FluidFrame {
    let cells = [6, 4, 5];
    let mut frame = FluidFrame {
        finer: Vec::new(),
        origin_m: DVec3::splat(0.25),
        cell_size_m: 0.5,
        cells,
        velocity_m_s: Vec::new(),
        pressure_pa: Vec::new(),
    };
    for k in 0..cells[2] {
        for _ in 0..cells[1] {
            for i in 0..cells[0] {
                let [x, z] = [i, k].map(|n| 0.5 * n as f32);
                // Anticlockwise to an eye that looks along +y: x to the right, z up.
                frame.velocity_m_s.push([-3.0 * z, 0.0, 3.0 * x]);
                frame.pressure_pa.push(x + 10.0 * z);
            }
        }
    }
    frame
}

#[test]
fn a_rigid_rotation_has_twice_its_rate_as_vorticity() {
    let frame = turning();
    let plane = Plane::new(&frame, Axis::Y, 0.9).unwrap();
    let slice = plane.slice(FlowQuantity::Vorticity, SliceDepth::Behind);
    assert_eq!(slice.counts, [6, 5]);
    assert!(
        slice.values.iter().all(|w| (w - 6.0).abs() < 1e-4),
        "{slice:?}"
    );
    let all = std::slice::from_ref(&slice);
    assert_eq!(range(FlowQuantity::Vorticity, all), {
        let top = f64::from(slice.values.iter().copied().fold(0.0, f32::max));
        [-top, top]
    });
    let pressure = plane.slice(FlowQuantity::Pressure, SliceDepth::Behind);
    assert_eq!(pressure.values[0], 0.0);
    assert_eq!(pressure.values[6 * 4 + 5], 2.5 + 20.0);
}

#[test]
fn arrows_point_with_the_velocity() {
    let frame = turning();
    let plane = Section::new(&frame, Axis::Y, 0.9).unwrap();
    let arrows = plane.arrows(10.0, 1.0);
    // All cells but the one at rest.
    assert_eq!(arrows.len(), 29);
    for arrow in &arrows {
        let [tail, tip] = [arrow.points_m[0], arrow.points_m[1]];
        let middle = 0.5 * (tail + tip) - DVec3::new(0.25, 0.0, 0.25);
        let expected = DVec3::new(-3.0 * middle.z, 0.0, 3.0 * middle.x) * (0.9 * 0.5 / 10.0);
        assert!((tip - tail).distance(expected) < 1e-6, "{arrow:?}");
    }
    assert!(plane.arrows(0.0, 1.0).is_empty());
}

/// Coarse cells in a box of finer ones are left out, but for a rim; what is shown and drawn inside is the box's.
#[test]
fn finer_cells_stand_for_those_that_they_cover() {
    let mut frame = turning();
    let mut finer = turning();
    // Four cells of the frame along each axis, from its second on.
    finer.cell_size_m = 0.25;
    finer.cells = [8, 8, 6];
    finer.origin_m = frame.origin_m + DVec3::splat(0.5 - 0.125);
    let count = finer.cells.iter().product();
    finer.velocity_m_s = vec![[7.0, 0.0, 0.0]; count];
    finer.pressure_pa = vec![0.0; count];
    frame.finer.push(finer);
    let plane = Section::new(&frame, Axis::Y, 0.9).unwrap();
    let slices = plane.slices(FlowQuantity::Speed, SliceDepth::Behind);
    let holes = |slice: &Slice| slice.values.iter().filter(|v| v.is_nan()).count();
    assert_eq!(slices.iter().map(holes).collect::<Vec<_>>(), [2, 0]);
    assert!(
        slices[1]
            .values
            .iter()
            .all(|speed| (speed - 7.0).abs() < 1e-5)
    );
    let arrows = plane.arrows(10.0, 1.0);
    let along = |arrow: &&Polyline| {
        let way = arrow.points_m[1] - arrow.points_m[0];
        (way.x - 0.9 * 0.5 * 0.7).abs() < 1e-6 && way.z.abs() < 1e-6
    };
    assert_eq!(arrows.iter().filter(along).count(), 12);
    // Beside the box all is as without it.
    assert_eq!(Section::new(&frame, Axis::Y, -5.0).unwrap().planes.len(), 1);
}
