//! Vectors and matrices of strain and tension in a plane, in Voigt form (xx, yy, xy).

/// Symmetric 3×3 matrix in Voigt space.
pub type Matrix3 = [[f64; 3]; 3];

pub(crate) fn times(matrix: &Matrix3, v: &[f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

pub(crate) fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// n⊗n, as a strain, of the direction n of the smaller principal value.
pub(crate) fn smaller_direction(xx: f64, yy: f64, xy: f64) -> [f64; 3] {
    let half = 0.5 * (xx - yy);
    let radius = (half * half + xy * xy).sqrt();
    if radius == 0.0 {
        return [0.0, 1.0, 0.0];
    }
    // With 2θ the doubled angle of the larger direction, n⊗n = ½ (1 − cos 2θ, 1 + cos 2θ) and 2 n_x n_y = −sin 2θ.
    let (cosine, sine) = (half / radius, xy / radius);
    [0.5 * (1.0 - cosine), 0.5 * (1.0 + cosine), -sine]
}
