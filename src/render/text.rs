//! Text from the pre-rasterised glyphs of Noto Sans Mono (SIL Open Font License).

use image::RgbImage;
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

use super::colour::blend;
use super::picture::{Label, TextAlign, TextSize};

fn raster_height(size: TextSize) -> RasterHeight {
    match size {
        TextSize::Px16 => RasterHeight::Size16,
        TextSize::Px20 => RasterHeight::Size20,
        TextSize::Px24 => RasterHeight::Size24,
        TextSize::Px32 => RasterHeight::Size32,
    }
}

fn weight(bold: bool) -> FontWeight {
    if bold {
        FontWeight::Bold
    } else {
        FontWeight::Regular
    }
}

/// Stands in for common characters beyond Latin-1 that the font data does not hold.
fn substitute(character: char) -> char {
    match character {
        '\u{2010}'..='\u{2015}' | '\u{2212}' => '-',
        '\u{2018}' | '\u{2019}' => '\'',
        '\u{201c}' | '\u{201d}' => '"',
        '\u{03bc}' => '\u{b5}',
        '\u{00a0}' | '\u{00ad}' | '\u{2009}' | '\u{202f}' => ' ',
        other => other,
    }
}

/// Height of a line of text [px].
#[must_use]
pub fn line_height(size: TextSize) -> u32 {
    raster_height(size).val() as u32
}

/// Width of a line of text [px].
#[must_use]
pub fn text_width(text: &str, size: TextSize, bold: bool) -> u32 {
    (text.chars().count() * get_raster_width(weight(bold), raster_height(size))) as u32
}

/// Draws a label; what lies beyond the image is cut off, an unknown character becomes `?`.
pub fn draw_label(image: &mut RgbImage, label: &Label) {
    let size = raster_height(label.size);
    let weight = weight(label.bold);
    let advance = get_raster_width(weight, size) as i64;
    let length = i64::from(text_width(&label.text, label.size, label.bold));
    let mut left = label.position_px[0].saturating_sub(match label.align {
        TextAlign::Left => 0,
        TextAlign::Centre => length / 2,
        TextAlign::Right => length,
    });
    let top = label.position_px[1].saturating_sub(size.val() as i64 / 2);
    for character in label.text.chars().map(substitute) {
        let glyph = get_raster(character, weight, size).or_else(|| get_raster('?', weight, size));
        for (row, line) in glyph.iter().flat_map(|glyph| glyph.rows()).enumerate() {
            for (column, &coverage) in line.iter().enumerate() {
                let place = (
                    left.saturating_add(column as i64),
                    top.saturating_add(row as i64),
                );
                let (Ok(x), Ok(y)) = (u32::try_from(place.0), u32::try_from(place.1)) else {
                    continue;
                };
                if let Some(pixel) = image.get_pixel_mut_checked(x, y) {
                    pixel.0 = blend(pixel.0, label.colour, f32::from(coverage) / 255.0);
                }
            }
        }
        left = left.saturating_add(advance);
    }
}

#[cfg(test)]
mod tests {
    use image::Rgb;

    use super::*;

    fn label(text: &str, x: i64, align: TextAlign) -> Label {
        Label {
            text: text.to_owned(),
            position_px: [x, 20],
            size: TextSize::Px20,
            bold: false,
            colour: [0, 0, 0],
            align,
        }
    }

    /// First and last column with ink.
    fn ink(label: &Label) -> Option<(u32, u32)> {
        let mut image = RgbImage::from_pixel(200, 40, Rgb([255; 3]));
        draw_label(&mut image, label);
        let dark = || {
            image
                .enumerate_pixels()
                .filter(|(_, _, p)| p.0[0] < 128)
                .map(|(x, _, _)| x)
        };
        Some((dark().min()?, dark().max()?))
    }

    #[test]
    fn labels_are_visible_and_aligned() {
        let width = text_width("C_D 0.74 m² 20 °", TextSize::Px20, false);
        assert!((120..200).contains(&width));
        let left = ink(&label("MMMM", 100, TextAlign::Left)).unwrap();
        let centre = ink(&label("MMMM", 100, TextAlign::Centre)).unwrap();
        let right = ink(&label("MMMM", 100, TextAlign::Right)).unwrap();
        assert!(left.0 >= 100 && right.1 < 100);
        assert!((centre.0 + centre.1).abs_diff(200) <= 3);
    }

    #[test]
    fn latin_1_is_known_and_the_rest_replaced() {
        for character in "°·²³µ±×Å".chars() {
            let glyph = get_raster(character, FontWeight::Bold, RasterHeight::Size32);
            assert!(glyph.is_some(), "{character}");
        }
        assert!(ink(&label("\u{4e2d}", 10, TextAlign::Left)).is_some());
    }

    #[test]
    fn text_beyond_the_edge_is_cut() {
        assert!(ink(&label("MMMM", -10, TextAlign::Left)).is_some());
        assert!(ink(&label("MMMM", i64::MAX, TextAlign::Left)).is_none());
        assert!(ink(&label("MMMM", i64::MIN, TextAlign::Right)).is_none());
    }
}
