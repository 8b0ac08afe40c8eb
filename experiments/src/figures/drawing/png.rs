//! Pictures as PNG files.

use std::path::Path;

use anyhow::{Context, Result};

use crate::data::atomic;

/// What every picture says of its origin.
pub const SOFTWARE: &str = "echolot";

/// Whether bytes are a picture that this program drew.
pub fn is_ours(bytes: &[u8]) -> bool {
    let reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info();
    reader.is_ok_and(|reader| {
        let texts = &reader.info().uncompressed_latin1_text;
        texts
            .iter()
            .any(|text| text.keyword == "Software" && text.text == SOFTWARE)
    })
}

/// Writes 8-bit RGB pixels, rows from the top, as PNG.
///
/// # Errors
/// When the file cannot be written.
pub fn write_png(path: &Path, width: u32, height: u32, rgb: &[u8]) -> Result<()> {
    let mut bytes = Vec::new();
    {
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::High);
        encoder.add_text_chunk("Software".into(), SOFTWARE.into())?;
        encoder
            .write_header()
            .and_then(|mut writer| writer.write_image_data(rgb))
            .with_context(|| path.display().to_string())?;
    }
    atomic::write(path, &bytes)
}
