//! Simple structures and test specimens: `[structure.sheet]`, `cable`, `airbag`, `disc` and `coupon`.

use glam::DVec3;

use super::body::{Airbag, Body, BodyKind, Coupon, HangingCable};
use super::cable_material::check_material;
use super::file::{self, SheetHold};
use super::problem::Problem;
use super::usual;
use super::values::{at_once, positive, vector, within};
use crate::fabric::Fabric;
use crate::geometry::{airbag, cable, coupon, fabric_surface, sheet, surfaces};

/// Most cells along a side, or rings.
const DIVISION_LIMIT: usize = 2_000;

/// Most cells of a sheet: some 5 GB.
const SHEET_CELL_LIMIT: usize = 4_000_000;

/// Most distance of the sides of a sheet, over its width.
const STRETCHED: f64 = 1.2;

fn divisions(key: &str, count: usize, least: usize) -> Result<usize, Problem> {
    if (least..=DIVISION_LIMIT).contains(&count) {
        return Ok(count);
    }
    Err(Problem::new(
        key,
        format!("{key} = {count} is out of range"),
        format!("allowed are {least} to {DIVISION_LIMIT}"),
    ))
}

/// Shapes that cannot be built in spite of sound numbers, such as cells without any area.
fn impossible(key: &str) -> Problem {
    Problem::new(
        key,
        format!("[{key}] has triangles without area"),
        "make it larger, or divide it less",
    )
}

pub(super) fn check_airbag(written: &file::Airbag, fabric: &Fabric) -> Result<Body, Problem> {
    const KEY: &str = "structure.airbag";
    let side_m = positive(&format!("{KEY}.side_m"), written.side_m)?;
    let key = format!("{KEY}.cells_per_side");
    let cells = divisions(&key, written.cells_per_side, 2)?;
    let Some(bag) = airbag::build(side_m, cells, fabric) else {
        return Err(Problem::new(
            &key,
            format!("{key} = {cells} is odd"),
            "an even number of cells has nodes in the middles of the sides",
        ));
    };
    let flat: Vec<DVec3> = bag
        .structure
        .positions_m
        .iter()
        .map(|x| x.with_z(0.0))
        .collect();
    let kind = BodyKind::Airbag(Airbag {
        middles: bag.middles,
    });
    Ok(Body::new(bag.structure, &flat, kind))
}

pub(super) fn check_disc(written: &file::Disc, fabric: &Fabric) -> Result<Body, Problem> {
    const KEY: &str = "structure.disc";
    let radius_m = positive(&format!("{KEY}.radius_m"), written.radius_m)?;
    let rings = divisions(&format!("{KEY}.rings"), written.rings, 1)?;
    let mut surface = surfaces::disk(radius_m, radius_m / rings as f64);
    for place in &mut surface.positions_m {
        // From the plane x = 0 into z = 0.
        *place = DVec3::new(place.y, place.z, place.x);
    }
    let mut structure =
        fabric_surface::build(&surface, DVec3::X, fabric).map_err(|_| impossible(KEY))?;
    for (place, held) in structure.positions_m.iter_mut().zip(&mut structure.held) {
        let share = place.length_squared() / (radius_m * radius_m);
        *held = share > 1.0 - 1e-9;
        if !*held {
            // A slight bulge to start from.
            place.z = 1e-3 * radius_m * (1.0 - share);
        }
    }
    Ok(Body::new(structure, &surface.positions_m, BodyKind::Sheet))
}

pub(super) fn check_coupon(written: &file::Coupon, fabric: &Fabric) -> Result<Body, Problem> {
    const KEY: &str = "structure.coupon";
    let key = |name: &str| format!("{KEY}.{name}");
    let shape = coupon::Coupon {
        length_m: positive(&key("length_m"), written.length_m)?,
        width_m: positive(&key("width_m"), written.width_m)?,
        cells_across: divisions(&key("cells_across"), written.cells_across, 2)?,
        warp_angle_deg: within(
            &key("warp_angle_deg"),
            written.warp_angle_deg,
            -180.0,
            180.0,
        )?,
        elongation: within(&key("elongation"), written.elongation, 1e-9, 1.0)?,
    };
    let cells_along = shape.length_m / shape.width_m * shape.cells_across as f64;
    if cells_along > (DIVISION_LIMIT * DIVISION_LIMIT) as f64 / shape.cells_across as f64 {
        return Err(Problem::new(
            key("length_m"),
            format!(
                "{KEY}.length_m = {} makes {cells_along:.1e} cells along a width of {} m with cells_across = {}",
                shape.length_m, shape.width_m, shape.cells_across
            ),
            format!(
                "at most {} cells in all are allowed: shorten it, widen it, or divide it less",
                DIVISION_LIMIT * DIVISION_LIMIT
            ),
        ));
    }
    let strip = coupon::build(&shape, fabric).ok_or_else(|| impossible(KEY))?;
    let mut structure = strip.structure;
    for (node, place) in strip.moved {
        structure.positions_m[node as usize] = place;
    }
    // Stretched a little, which the quality of triangles does not feel.
    Ok(Body::at_rest(
        structure,
        BodyKind::Coupon(Coupon {
            cross_section_m2: shape.width_m * fabric.thickness_m,
            gauge: strip.gauge,
            gauge_length_m: strip.gauge_length_m,
        }),
    ))
}

pub(super) fn check_sheet(written: &file::Sheet, fabric: &Fabric) -> Result<Body, Problem> {
    const KEY: &str = "structure.sheet";
    let key = |name: &str| format!("{KEY}.{name}");
    for size in written.size_m {
        at_once(|| positive(&key("size_m"), size))?;
    }
    let [across, down] = written.divisions;
    let in_range = |n: usize| (1..=5_000).contains(&n);
    if !in_range(across) || !in_range(down) || across * down > SHEET_CELL_LIMIT {
        return Err(Problem::new(
            key("divisions"),
            format!(
                "{} = {:?} is out of range",
                key("divisions"),
                written.divisions
            ),
            format!("allowed are 1 to 5000 cells along each side, and {SHEET_CELL_LIMIT} in all"),
        ));
    }
    let hold = usual::or(key("held"), written.held, SheetHold::UpperCorners);
    let widest = match hold {
        SheetHold::Sides => STRETCHED,
        SheetHold::UpperCorners | SheetHold::UpperEdge => 1.0,
    };
    let hung_width_m = within(
        &key("hung_width_m"),
        written.hung_width_m,
        0.05 * written.size_m[0],
        widest * written.size_m[0],
    )?;
    let shape = sheet::SheetShape {
        size_m: written.size_m,
        divisions: written.divisions,
        corner_m: vector(&key("corner_m"), written.corner_m)?,
        across: DVec3::X,
        down: -DVec3::Z,
    };
    let mut structure = sheet::build(&shape, fabric, written.model).ok_or_else(|| {
        Problem::new(
            key("divisions"),
            "the cells of the spring network are too elongated for this shear modulus: a spring would push on its own",
            "make the cells squarer, or use model = \"membrane\"",
        )
    })?;
    let positions = structure.positions_m.clone();
    let [width, height] = written.size_m;
    // Gather the width in a smooth bulge, so that the start is neither flat nor torn.
    let ratio = hung_width_m / width;
    let bulge = width * (0.5 * (1.0 - ratio * ratio)).max(0.0).sqrt() / std::f64::consts::PI;
    for (place, rest) in structure.positions_m.iter_mut().zip(&positions) {
        let s = (rest.x - shape.corner_m.x) / width;
        let t = (shape.corner_m.z - rest.z) / height;
        *place = DVec3::new(
            shape.corner_m.x + s * hung_width_m,
            rest.y + bulge * (std::f64::consts::PI * s).sin() * (1.0 + 0.2 * t),
            rest.z,
        );
    }
    let (last, rows) = (across, 0..=down);
    let held: Vec<u32> = match hold {
        SheetHold::UpperCorners => vec![shape.node(0, 0), shape.node(last, 0)],
        SheetHold::UpperEdge => (0..=last).map(|i| shape.node(i, 0)).collect(),
        SheetHold::Sides => rows
            .flat_map(|j| [shape.node(0, j), shape.node(last, j)])
            .collect(),
    };
    for node in held {
        structure.held[node as usize] = true;
    }
    Ok(Body::new(structure, &positions, BodyKind::Sheet))
}

pub(super) fn check_cable(
    written: &file::HangingCable,
    gravity: Option<DVec3>,
) -> Result<Body, Problem> {
    const KEY: &str = "structure.cable";
    let material = check_material(&format!("{KEY}.material"), &written.material)?;
    let ends = [
        vector(&format!("{KEY}.ends_m"), written.ends_m[0])?,
        vector(&format!("{KEY}.ends_m"), written.ends_m[1])?,
    ];
    let span_m = ends[0].distance(ends[1]);
    let length_m = match (written.length_m, written.pretension_n) {
        (Some(length_m), None) => positive(&format!("{KEY}.length_m"), length_m)?,
        (None, Some(tension_n)) => {
            let tension_n = positive(&format!("{KEY}.pretension_n"), tension_n)?;
            span_m / (1.0 + material.law.strain_at(tension_n))
        }
        _ => {
            return Err(Problem::new(
                KEY,
                format!("[{KEY}] needs exactly one of length_m and pretension_n"),
                "give its unstretched length, or the tension in which it starts",
            ));
        }
    };
    if length_m <= span_m && written.length_m.is_some() {
        return Err(Problem::new(
            format!("{KEY}.length_m"),
            format!("a cable of {length_m} m does not reach over {span_m} m"),
            "make the cable longer than the distance of its ends, or give pretension_n instead",
        ));
    }
    if !(2..=100_000).contains(&written.segments) {
        return Err(Problem::new(
            format!("{KEY}.segments"),
            format!("{KEY}.segments = {} is out of range", written.segments),
            "allowed are 2 to 100000 segments",
        ));
    }
    let weight_n_m = material.mass_per_length_kg_m() * gravity.map_or(0.0, DVec3::length);
    Ok(Body {
        structure: cable::build(ends, length_m, written.segments, &material),
        quality: None,
        kind: BodyKind::Cable(HangingCable {
            span_m,
            length_m,
            weight_n_m,
            hangs_by_itself: true,
        }),
    })
}
