//! Cutting what is drawn down to the view and a little around it.
//!
//! A device computes in single precision: what is huge, or reaches behind the eye, must be cut in double precision first. All
//! else is left as it is, and the device cuts it at the viewport's rim. The software rasteriser has no need for this.

use glam::DVec2;

use crate::render::raster::Corner;
use crate::render::strokes::Stroke;
use crate::render::view::View;

/// How far surfaces and slices reach at most to either side of the view's centre, in halves of its width and height.
const MARGIN: f64 = 4.0;

/// What lies deeper is left out: its products would not be finite in single precision.
const LARGEST_DEPTH_M: f64 = 1e25;

/// The part of a convex polygon beyond the near plane and in the view or around it, fanned out into triangles. `scale` leads
/// from view coordinates to those of the viewport, -1…1, before any division by depth.
pub(super) fn cut_polygon(view: View, scale: DVec2, corners: &[Corner]) -> Vec<[Corner; 3]> {
    // Distances from the planes that bound the view, positive inside.
    let bounds = |corner: &Corner| {
        let place = scale * corner.position.truncate();
        let depth = corner.position.z;
        let reach = MARGIN * if view.perspective { depth } else { 1.0 };
        [
            depth - view.near,
            reach - place.x,
            reach + place.x,
            reach - place.y,
            reach + place.y,
            LARGEST_DEPTH_M - depth,
        ]
    };
    let mut polygon = corners.to_vec();
    for plane in 0..6 {
        let distances: Vec<f64> = polygon.iter().map(|corner| bounds(corner)[plane]).collect();
        if distances.iter().all(|distance| *distance >= 0.0) {
            continue;
        }
        let mut rest = Vec::with_capacity(polygon.len() + 1);
        for k in 0..polygon.len() {
            let next = (k + 1) % polygon.len();
            let (a, b) = (polygon[k], polygon[next]);
            let (da, db) = (distances[k], distances[next]);
            if da >= 0.0 {
                rest.push(a);
            }
            if (da >= 0.0) != (db >= 0.0) {
                let t = da / (da - db);
                rest.push(Corner {
                    position: a.position.lerp(b.position, t),
                    normal: a.normal.lerp(b.normal, t),
                });
            }
        }
        polygon = rest;
    }
    (2..polygon.len())
        .map(|k| [polygon[0], polygon[k - 1], polygon[k]])
        .collect()
}

/// The part of a stroke on the screen and a little around it, where single precision suffices.
pub(super) fn cut_stroke(mut stroke: Stroke, screen: DVec2) -> Option<Stroke> {
    let rim = 2.0 * (stroke.radius + 4.0);
    let [a, b] = stroke.points;
    let (mut first, mut last) = (0.0f64, 1.0f64);
    for (start, end, size) in [(a.x, b.x, screen.x), (a.y, b.y, screen.y)] {
        let (low, high) = (-rim, size + rim);
        let step = end - start;
        if step == 0.0 {
            if !(low..=high).contains(&start) {
                return None;
            }
            continue;
        }
        let (enter, leave) = ((low - start) / step, (high - start) / step);
        first = first.max(enter.min(leave));
        last = last.min(enter.max(leave));
    }
    if first > last {
        return None;
    }
    let keys = stroke.keys;
    for (k, t) in [(0, first), (1, last)] {
        stroke.points[k].x = a.x + t * (b.x - a.x);
        stroke.points[k].y = a.y + t * (b.y - a.y);
        stroke.keys[k] = keys[0] + t * (keys[1] - keys[0]);
    }
    Some(stroke)
}
