//! Legends and labels, drawn on the finished pixels.

use image::RgbImage;

use super::canvas::MAX_SIZE_PX;
use super::colour::{Rgb, fraction};
use super::picture::{ColourBar, Label, Picture, PixelRect, TextAlign};
use super::text::{draw_label, line_height};

/// Colour of the outline and the tick marks of a bar.
const RULE: Rgb = [90, 96, 104];

/// Length of a tick mark [px].
const TICK_PX: u32 = 5;

/// Space between a bar and its title, and between a tick mark and its text [px].
const GAP_PX: u32 = 5;

/// Draws colour bars, then labels.
pub(crate) fn draw_annotations(image: &mut RgbImage, picture: &Picture) {
    picture
        .colour_bars
        .iter()
        .for_each(|bar| draw_bar(image, bar));
    picture
        .labels
        .iter()
        .for_each(|label| draw_label(image, label));
}

fn draw_bar(image: &mut RgbImage, bar: &ColourBar) {
    let PixelRect {
        x,
        y,
        width,
        height,
    } = bar.rect;
    let beyond = x.saturating_add(width) > MAX_SIZE_PX || y.saturating_add(height) > MAX_SIZE_PX;
    if beyond || width < 3 || height < 3 {
        return;
    }
    fill(image, bar.rect, |_| RULE);
    let inner = PixelRect {
        x: x + 1,
        y: y + 1,
        width: width - 2,
        height: height - 2,
    };
    let rows = f64::from(inner.height);
    fill(image, inner, |row| {
        bar.scale.at(1.0 - (f64::from(row) + 0.5) / rows)
    });

    let middle = i64::from(line_height(bar.text_size) / 2);
    let text = |text: &str, bold: bool, position_px: [i64; 2]| Label {
        text: text.to_owned(),
        position_px,
        size: bar.text_size,
        bold,
        colour: bar.text_colour,
        align: TextAlign::Left,
    };
    let title_y = i64::from(y) - i64::from(GAP_PX) - middle;
    draw_label(image, &text(&bar.title, true, [i64::from(x), title_y]));
    for tick in &bar.ticks {
        let share = fraction(tick.value, bar.range);
        if !(0.0..=1.0).contains(&share) {
            continue;
        }
        let row = y + ((1.0 - share) * f64::from(height - 1)).round() as u32;
        fill(
            image,
            PixelRect {
                x: x + width,
                y: row,
                width: TICK_PX,
                height: 1,
            },
            |_| RULE,
        );
        let left = i64::from(x + width + TICK_PX + GAP_PX);
        draw_label(image, &text(&tick.text, false, [left, i64::from(row)]));
    }
}

/// Fills what lies within the image of a rectangle; the colour may depend on the row within it.
fn fill(image: &mut RgbImage, rect: PixelRect, colour: impl Fn(u32) -> Rgb) {
    let right = rect.x.saturating_add(rect.width).min(image.width());
    let bottom = rect.y.saturating_add(rect.height).min(image.height());
    for y in rect.y..bottom {
        let colour = image::Rgb(colour(y - rect.y));
        for x in rect.x..right {
            image.put_pixel(x, y, colour);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::colour::ColourScale;
    use crate::render::picture::{TextSize, nice_ticks};

    #[test]
    fn a_bar_runs_upwards_and_has_text() {
        let mut image = RgbImage::from_pixel(160, 200, image::Rgb([255; 3]));
        let range = [0.0, 10.0];
        let bar = ColourBar {
            title: "Speed [m/s]".to_owned(),
            range,
            scale: ColourScale::Viridis,
            rect: PixelRect {
                x: 20,
                y: 40,
                width: 20,
                height: 140,
            },
            ticks: nice_ticks(range, 6),
            text_size: TextSize::Px16,
            text_colour: [0; 3],
        };
        draw_bar(&mut image, &bar);
        assert!(image.get_pixel(30, 45).0[0] > 200, "yellow at the top");
        assert!(image.get_pixel(30, 175).0[0] < 100, "violet at the bottom");
        let ink = |rect: PixelRect| {
            (rect.y..rect.y + rect.height)
                .flat_map(|y| (rect.x..rect.x + rect.width).map(move |x| (x, y)))
                .filter(|&(x, y)| image.get_pixel(x, y).0[0] < 100)
                .count()
        };
        assert!(
            ink(PixelRect {
                x: 20,
                y: 15,
                width: 120,
                height: 22
            }) > 50,
            "title"
        );
        assert!(
            ink(PixelRect {
                x: 50,
                y: 30,
                width: 40,
                height: 160
            }) > 50,
            "ticks"
        );
    }

    #[test]
    fn a_bar_beyond_the_image_is_cut() {
        let mut image = RgbImage::new(20, 20);
        let bar = ColourBar {
            title: String::new(),
            range: [0.0, 1.0],
            scale: ColourScale::Mist,
            rect: PixelRect {
                x: 15,
                y: 15,
                width: 100,
                height: 100,
            },
            ticks: nice_ticks([0.0, 1.0], 3),
            text_size: TextSize::Px16,
            text_colour: [0; 3],
        };
        draw_bar(&mut image, &bar);
        assert_eq!(image.get_pixel(15, 15).0, RULE);
    }
}
