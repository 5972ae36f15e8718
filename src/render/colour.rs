//! Perceptually ordered colour scales.
//!
//! Viridis, Plasma and Inferno are the sixth-degree polynomial fits by Matt Zucker (public domain)
//! of the matplotlib maps by Smith and van der Walt (CC0); Mist interpolates control points.

/// An sRGB colour, eight bits per channel, red first.
pub type Rgb = [u8; 3];

/// Colour of a value that is not a number.
pub const NO_DATA: Rgb = [170, 170, 170];

/// A map from the unit interval to colours whose lightness is monotone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ColourScale {
    /// Dark violet over green to yellow; lightness rises.
    Viridis,
    /// Dark blue over magenta to yellow; lightness rises.
    Plasma,
    /// Black over red to pale yellow; lightness rises.
    Inferno,
    /// Near white to slate blue, a quiet background; lightness falls.
    Mist,
    /// Blue over near white to red: values below and above zero in the middle of the range.
    BlueRed,
    /// Three bands for the states of fabric, told apart also by colour-blind eyes (after Okabe and Ito 2008).
    States,
}

/// Coefficients of the constant to the sixth-degree term, red, green and blue each.
type Polynomial = [[f64; 3]; 7];

const VIRIDIS: Polynomial = [
    [0.27772733, 0.00540734, 0.33409981],
    [0.10509304, 1.40461353, 1.38459016],
    [-0.33086183, 0.21484756, 0.09509516],
    [-4.63423050, -5.79910097, -19.33244096],
    [6.22826994, 14.17993337, 56.69055260],
    [4.77638500, -13.74514538, -65.35303263],
    [-5.43545586, 4.64585261, 26.31243525],
];

const PLASMA: Polynomial = [
    [0.05873234, 0.02333671, 0.54334018],
    [2.17651463, 0.23838342, 0.75396046],
    [-2.68946048, -7.45585114, 3.11079994],
    [6.13034835, 42.34618815, -28.51885465],
    [-11.10743619, -82.66631109, 60.13984767],
    [10.02306558, 71.41361770, -54.07218656],
    [-3.65871384, -22.93153465, 18.19190779],
];

const INFERNO: Polynomial = [
    [0.00021894, 0.00165100, -0.01948090],
    [0.10651342, 0.56395644, 3.93271239],
    [11.60249308, -3.97285397, -15.94239411],
    [-41.70399613, 17.43639888, 44.35414520],
    [77.16293570, -33.40235894, -81.80730926],
    [-71.31942824, 32.62606426, 73.20951986],
    [25.13112622, -12.24266895, -23.07032500],
];

/// Evenly spaced control points of Mist.
const MIST: [Rgb; 7] = [
    [250, 251, 252],
    [233, 241, 247],
    [214, 229, 240],
    [193, 215, 232],
    [169, 199, 222],
    [140, 178, 208],
    [104, 149, 187],
];

/// Evenly spaced control points of BlueRed (ends and thirds after Moreland 2009).
const BLUE_RED: [Rgb; 7] = [
    [59, 76, 192],
    [124, 159, 249],
    [192, 212, 245],
    [248, 248, 248],
    [245, 196, 173],
    [231, 116, 91],
    [180, 4, 38],
];

/// Sky blue, orange, reddish purple.
const STATES: [Rgb; 3] = [[86, 180, 233], [230, 159, 0], [204, 121, 167]];

impl ColourScale {
    /// The colour at `t`, clamped to 0…1; [`NO_DATA`] where `t` is not a number.
    #[must_use]
    pub fn at(self, t: f64) -> Rgb {
        if t.is_nan() {
            return NO_DATA;
        }
        let t = t.clamp(0.0, 1.0);
        match self {
            Self::Viridis => evaluate(&VIRIDIS, t),
            Self::Plasma => evaluate(&PLASMA, t),
            Self::Inferno => evaluate(&INFERNO, t),
            Self::Mist => interpolate(&MIST, t),
            Self::BlueRed => interpolate(&BLUE_RED, t),
            Self::States => STATES[((t * 3.0) as usize).min(2)],
        }
    }

    /// The colour of `value` on a scale that runs over `range` (both in the value's own unit).
    ///
    /// An empty or reversed range puts every number at the start of the scale.
    #[must_use]
    pub fn of(self, value: f64, range: [f64; 2]) -> Rgb {
        self.at(fraction(value, range))
    }

    /// The scale sampled at 256 evenly spaced points from 0 to 1, for quick look-ups.
    #[must_use]
    pub fn table(self) -> [Rgb; 256] {
        std::array::from_fn(|i| self.at(i as f64 / 255.0))
    }
}

/// Where `value` lies in `range`: 0 at its start, 1 at its end, not clamped; 0 for an empty range,
/// NaN for a value that is not a number.
#[must_use]
pub fn fraction(value: f64, range: [f64; 2]) -> f64 {
    let width = range[1] - range[0];
    if value.is_nan() {
        f64::NAN
    } else if width > 0.0 {
        (value - range[0]) / width
    } else {
        0.0
    }
}

/// `top` laid over `bottom` with `opacity` 0…1.
#[must_use]
pub fn blend(bottom: Rgb, top: Rgb, opacity: f32) -> Rgb {
    std::array::from_fn(|c| {
        let mixed = f32::from(bottom[c]) * (1.0 - opacity) + f32::from(top[c]) * opacity;
        (mixed + 0.5) as u8
    })
}

fn evaluate(polynomial: &Polynomial, t: f64) -> Rgb {
    std::array::from_fn(|c| {
        let value = polynomial.iter().rev().fold(0.0, |sum, k| sum * t + k[c]);
        (value.clamp(0.0, 1.0) * 255.0).round() as u8
    })
}

fn interpolate<const N: usize>(points: &[Rgb; N], t: f64) -> Rgb {
    let position = t * (N - 1) as f64;
    let first = (position as usize).min(N - 2);
    blend(
        points[first],
        points[first + 1],
        (position - first as f64) as f32,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [ColourScale; 4] = [
        ColourScale::Viridis,
        ColourScale::Plasma,
        ColourScale::Inferno,
        ColourScale::Mist,
    ];

    /// Relative luminance as of WCAG 2.
    fn luminance(colour: Rgb) -> f64 {
        let linear = colour.map(|c| {
            let c = f64::from(c) / 255.0;
            if c <= 0.04045 {
                c / 12.92
            } else {
                ((c + 0.055) / 1.055).powf(2.4)
            }
        });
        0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
    }

    #[test]
    fn luminance_is_monotone() {
        for scale in ALL {
            let l: Vec<f64> = (0..=64)
                .map(|i| luminance(scale.at(f64::from(i) / 64.0)))
                .collect();
            let sign = (l[64] - l[0]).signum();
            assert!((l[64] - l[0]).abs() > 0.5, "{scale:?} spans too little");
            for pair in l.windows(2) {
                assert!(sign * (pair[1] - pair[0]) > -2e-3, "{scale:?}: {pair:?}");
            }
        }
    }

    #[test]
    fn fits_match_the_published_maps() {
        let cases = [
            (
                ColourScale::Viridis,
                [[68, 1, 84], [33, 145, 140], [253, 231, 37]],
            ),
            (
                ColourScale::Plasma,
                [[13, 8, 135], [204, 71, 120], [240, 249, 33]],
            ),
            (
                ColourScale::Inferno,
                [[0, 0, 4], [188, 55, 84], [252, 255, 164]],
            ),
        ];
        for (scale, expected) in cases {
            for (i, want) in expected.iter().enumerate() {
                let got = scale.at(i as f64 / 2.0);
                for c in 0..3 {
                    assert!(
                        got[c].abs_diff(want[c]) <= 8,
                        "{scale:?} {i}: {got:?} {want:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn odd_input_has_a_colour() {
        assert_eq!(ColourScale::Viridis.at(f64::NAN), NO_DATA);
        assert_eq!(ColourScale::Mist.of(5.0, [1.0, 1.0]), MIST[0]);
        assert_eq!(ColourScale::Mist.at(9.0), MIST[6]);
        assert_eq!(ColourScale::Mist.table()[255], MIST[6]);
    }
}
