//! Pictures as PNG files.

use std::path::Path;

use anyhow::{Context, Result};

use crate::data::atomic;

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
        encoder
            .write_header()
            .and_then(|mut writer| writer.write_image_data(rgb))
            .with_context(|| path.display().to_string())?;
    }
    atomic::write(path, &bytes)
}
