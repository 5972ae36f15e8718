use super::*;

/// Rigid rotation about y with 3 rad/s and pressure x + 10 z, on 6 × 4 × 5 cells of 0.5 m.
fn turning() -> FluidFrame {
    let cells = [6, 4, 5];
    let mut frame = FluidFrame {
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
    assert_eq!(range(FlowQuantity::Vorticity, &slice.values), {
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
    let plane = Plane::new(&frame, Axis::Y, 0.9).unwrap();
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
