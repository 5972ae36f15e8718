// Blocks of springs and cables at one of their ends.

fn spring_block(e: u32, p: Piece) -> Block {
    let stretched = bitcast<f32>(springs[6u * SPRINGS + e]);
    let shortened = bitcast<f32>(springs[7u * SPRINGS + e]);
    if p.elongation > 0.0 {
        return axial(p.edge, p.length, stretched, stretched * p.elongation / p.length);
    }
    return axial(p.edge, p.length, max(shortened, 1e-3 * stretched), 0.0);
}

fn cable_block(e: u32, p: Piece) -> Block {
    let rest_length = cable_rest_length(e);
    if p.elongation > 0.0 {
        let state = cable_state(e, p.elongation / rest_length);
        return axial(p.edge, p.length, state.tangent / rest_length, state.tension / p.length);
    }
    // A slack cable has no stiffness; a thousandth keeps steps that would tighten it within bounds.
    return isotropic(1e-3 * cable_laws[cables[6u * CABLES + e]].z / rest_length);
}
