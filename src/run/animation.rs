//! `animation.png`: the frames of a run as one animated PNG.
//!
//! While the run goes on, every frame is a file of its own, so that an interrupted run keeps them. At its end they become one file,
//! written whole or not at all, and go.

use std::io;
use std::path::Path;

use crate::output::{OutputError, write_atomically};

/// Width and height [px].
pub(super) const SIZE_PX: [u32; 2] = [960, 540];

/// Time that a frame is shown [ms].
const FRAME_MS: u16 = 80;

/// Name of a frame.
pub(super) fn frame_name(number: usize) -> String {
    format!("animation_{number:05}.png")
}

/// Joins the first `count` frames of a folder; nothing without any.
pub(super) fn join(folder: &Path, count: usize) -> Result<(), OutputError> {
    let Ok(frames) = u32::try_from(count) else {
        return Ok(());
    };
    if frames == 0 {
        return Ok(());
    }
    let [width, height] = SIZE_PX;
    write_atomically(&folder.join("animation.png"), |out| {
        let mut encoder = png::Encoder::new(out, width, height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_animated(frames, 0)?;
        encoder.set_frame_delay(FRAME_MS, 1000)?;
        let mut writer = encoder.write_header()?;
        for number in 0..count {
            let bytes = std::fs::read(folder.join(frame_name(number)))?;
            let frame = image::load_from_memory(&bytes).map_err(io::Error::other)?;
            writer.write_image_data(&frame.to_rgb8())?;
        }
        writer.finish()?;
        Ok(())
    })
}

/// Removes the files of the first `count` frames.
pub(super) fn remove_frames(folder: &Path, count: usize) {
    for number in 0..count {
        // What stays behind does no harm.
        let _ = std::fs::remove_file(folder.join(frame_name(number)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_become_one_animated_file_or_none() {
        let folder = tempfile::tempdir().unwrap();
        let [width, height] = SIZE_PX;
        for number in 0..3_u8 {
            let image = image::RgbImage::from_pixel(width, height, image::Rgb([number * 80, 9, 7]));
            image
                .save(folder.path().join(frame_name(usize::from(number))))
                .unwrap();
        }
        // The fourth is missing: the file is not written, the frames stay.
        assert!(join(folder.path(), 4).is_err());
        assert!(!folder.path().join("animation.png").exists());
        assert!(folder.path().join(frame_name(0)).exists());
        join(folder.path(), 3).unwrap();
        remove_frames(folder.path(), 3);
        assert!(!folder.path().join(frame_name(0)).exists());
        let file = std::fs::File::open(folder.path().join("animation.png")).unwrap();
        let mut reader = png::Decoder::new(io::BufReader::new(file))
            .read_info()
            .unwrap();
        assert_eq!(reader.info().animation_control().unwrap().num_frames, 3);
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        for number in 0..3_u8 {
            reader.next_frame(&mut pixels).unwrap();
            assert_eq!(pixels[..3], [number * 80, 9, 7]);
        }
        join(folder.path(), 0).unwrap();
    }
}
