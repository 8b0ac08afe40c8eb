//! The pictures of a field, one after the other: an animated PNG, which browsers and most viewers play.

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};

use crate::data::atomic;
use crate::figures::drawing::png::SOFTWARE;

/// Name of the animation in the folder of the pictures.
pub const NAME: &str = "pressure.apng";
/// Time a picture is shown, as a fraction of a second.
const DELAY: (u16, u16) = (2, 25);

/// Width, height and 8-bit RGB pixels of a picture.
type Picture = (u32, u32, Vec<u8>);

/// Joins all pictures of the field in `folder`, in the order of their times; `None` when there are none.
///
/// # Errors
/// When a picture cannot be read or has another size than the first, or the animation cannot be written.
pub fn animate(folder: &Path) -> Result<Option<PathBuf>> {
    let mut pictures = Vec::new();
    for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let name = entry?.file_name().to_string_lossy().into_owned();
        if name.starts_with("pressure_") && name.ends_with("us.png") {
            pictures.push(folder.join(name));
        }
    }
    // Times in the names have leading zeros.
    pictures.sort();
    let Some(first) = pictures.first() else {
        return Ok(None);
    };
    let (width, height, _) = read(first)?;
    let mut bytes = Vec::new();
    {
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::High);
        encoder.add_text_chunk("Software".into(), SOFTWARE.into())?;
        encoder.set_animated(u32::try_from(pictures.len())?, 0)?;
        encoder.set_frame_delay(DELAY.0, DELAY.1)?;
        let mut writer = encoder.write_header()?;
        for picture in &pictures {
            let (own_width, own_height, pixels) = read(picture)?;
            ensure!(
                (own_width, own_height) == (width, height),
                "{}: {own_width} x {own_height} pixels, the first picture has {width} x {height}; use a folder \
                for each simulation",
                picture.display()
            );
            writer.write_image_data(&pixels)?;
        }
        writer.finish()?;
    }
    let path = folder.join(NAME);
    atomic::write(&path, &bytes)?;
    Ok(Some(path))
}

/// Reads a picture.
fn read(path: &Path) -> Result<Picture> {
    let read = || -> Result<Picture> {
        let mut reader = png::Decoder::new(BufReader::new(File::open(path)?)).read_info()?;
        let size = reader.output_buffer_size().context("is too large")?;
        let mut pixels = vec![0; size];
        let info = reader.next_frame(&mut pixels)?;
        ensure!(
            info.color_type == png::ColorType::Rgb && info.bit_depth == png::BitDepth::Eight,
            "is no picture of a field"
        );
        pixels.truncate(info.buffer_size());
        Ok((info.width, info.height, pixels))
    };
    read().with_context(|| path.display().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figures::drawing::png::write_png;

    #[test]
    fn pictures_become_frames_in_the_order_of_their_times() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(animate(folder.path()).unwrap(), None);
        for (time, shade) in [("000000900", 20), ("000000010", 250)] {
            let file = folder.path().join(format!("pressure_{time}us.png"));
            write_png(&file, 3, 2, &[shade; 18]).unwrap();
        }
        let file = animate(folder.path()).unwrap().unwrap();
        let decoder = png::Decoder::new(BufReader::new(File::open(&file).unwrap()));
        let mut reader = decoder.read_info().unwrap();
        assert_eq!(reader.info().animation_control().unwrap().num_frames, 2);
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        for shade in [250, 20] {
            reader.next_frame(&mut pixels).unwrap();
            assert_eq!(pixels, [shade; 18]);
        }
        write_png(
            &folder.path().join("pressure_000001000us.png"),
            2,
            2,
            &[0; 12],
        )
        .unwrap();
        let error = animate(folder.path()).unwrap_err().to_string();
        assert!(error.contains("2 x 2 pixels"), "{error}");
    }
}
