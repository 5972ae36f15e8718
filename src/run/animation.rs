//! `animation.png`: the frames of a run as one animated PNG.
//!
//! While the run goes on, every frame is a file of its own, so that an interrupted run keeps them. At its end they become one file,
//! written whole or not at all, and go. Frames that were lost meanwhile are missing in it.

use std::io;
use std::path::{Path, PathBuf};

use image::RgbImage;

use super::names::frame;
use crate::output::{OutputError, write_atomically};

/// Width and height [px].
pub(super) const SIZE_PX: [u32; 2] = [960, 540];

/// Time that a frame is shown [ms].
const FRAME_MS: u16 = 80;

/// Name of a frame.
pub(super) fn frame_name(number: usize) -> String {
    frame(&format!("animation_{number:05}.png"))
}

/// Joins those of the first `count` frames of a folder that are there and whole; returns how many are not. Nothing is written without any.
pub(super) fn join(folder: &Path, count: usize) -> Result<usize, OutputError> {
    let paths = (0..count).map(|number| folder.join(frame_name(number)));
    let whole: Vec<PathBuf> = paths.filter(|path| read(path).is_some()).collect();
    let lost = count - whole.len();
    let frames = match u32::try_from(whole.len()) {
        Ok(frames) if frames > 0 => frames,
        _ => return Ok(lost),
    };
    let [width, height] = SIZE_PX;
    write_atomically(&folder.join("animation.png"), |out| {
        let mut encoder = png::Encoder::new(out, width, height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_animated(frames, 0)?;
        encoder.set_frame_delay(FRAME_MS, 1000)?;
        let mut writer = encoder.write_header()?;
        for path in &whole {
            let frame = read(path).ok_or_else(|| io::Error::other("a frame has gone"))?;
            writer.write_image_data(&frame)?;
        }
        writer.finish()?;
        Ok(())
    })?;
    Ok(lost)
}

/// Pixels of a frame; `None` if the file is not there, or not what was written.
fn read(path: &Path) -> Option<RgbImage> {
    let bytes = std::fs::read(path).ok()?;
    let frame = image::load_from_memory(&bytes).ok()?.to_rgb8();
    let [width, height] = SIZE_PX;
    (frame.dimensions() == (width, height)).then_some(frame)
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
    use crate::output::FRAMES_FOLDER;

    #[test]
    fn frames_become_one_animated_file_or_none() {
        let folder = tempfile::tempdir().unwrap();
        let [width, height] = SIZE_PX;
        std::fs::create_dir(folder.path().join(FRAMES_FOLDER)).unwrap();
        for number in 0..3_u8 {
            let image = image::RgbImage::from_pixel(width, height, image::Rgb([number * 80, 9, 7]));
            image
                .save(folder.path().join(frame_name(usize::from(number))))
                .unwrap();
        }
        // The fourth is cut short, the fifth is missing: the others become one.
        let third = std::fs::read(folder.path().join(frame_name(2))).unwrap();
        std::fs::write(folder.path().join(frame_name(3)), &third[..third.len() / 2]).unwrap();
        assert_eq!(join(folder.path(), 5).unwrap(), 2);
        assert!(folder.path().join(frame_name(0)).exists());
        remove_frames(folder.path(), 5);
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
        std::fs::remove_file(folder.path().join("animation.png")).unwrap();
        assert_eq!(join(folder.path(), 2).unwrap(), 2);
        assert!(!folder.path().join("animation.png").exists());
    }
}
