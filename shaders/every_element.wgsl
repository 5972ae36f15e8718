// Forces of all elements by one workgroup; the energy of those of a thread. The host leaves out the lines of kinds that a structure lacks.
fn evaluate_elements(local: u32) -> vec2<f32> {
    var energy = vec2<f32>(0.0);
    for (var e = local; e < TRIANGLES; e += SMALL_WORKGROUP) { energy += triangle_force(e); }
    for (var e = local; e < SPRINGS; e += SMALL_WORKGROUP) { energy += spring_force(e); }
    for (var e = local; e < BENDINGS; e += SMALL_WORKGROUP) { energy += bending_force(e); }
    for (var e = local; e < CURVATURES; e += SMALL_WORKGROUP) { energy += curvature_force(e); }
    for (var e = local; e < CABLES; e += SMALL_WORKGROUP) { energy += cable_force(e); }
    for (var e = local; e < DASHPOTS; e += SMALL_WORKGROUP) { energy += dashpot_force(e); }
    for (var e = local; e < GUIDES; e += SMALL_WORKGROUP) { energy += guide_force(e); }
    for (var e = local; e < FACES; e += SMALL_WORKGROUP) { energy += face_force(e); }
    for (var e = local; e < CUT_TRIANGLES; e += SMALL_WORKGROUP) { energy += cut_triangle_force(e); }
    for (var e = local; e < MARKERS; e += SMALL_WORKGROUP) { energy += marker_force(e); }
    for (var e = local; e < PERMEABLE_MARKERS; e += SMALL_WORKGROUP) { energy += permeable_marker_force(e); }
    return energy;
}
