//! Finished pictures.

use super::PictureSize;

/// Image in 8-bit sRGB with straight alpha, row by row from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// Columns and rows.
    pub size: PictureSize,
    /// Red, green, blue, alpha per pixel; length `width · height`.
    pub pixels: Vec<[u8; 4]>,
}

/// Error of encoding a picture.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// The encoder failed.
    #[error("cannot encode the picture: {0}")]
    Encoding(#[from] png::EncodingError),
}

impl Image {
    /// Bytes of a PNG file.
    pub fn png(&self) -> Result<Vec<u8>, PictureError> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.size.width as u32, self.size.height as u32);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::Balanced);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(self.pixels.as_flattened())?;
        writer.finish()?;
        Ok(bytes)
    }

    /// Joins pictures side by side; shorter ones are filled with transparency.
    pub fn beside(pictures: &[Self]) -> Self {
        let height = pictures.iter().map(|picture| picture.size.height).max().unwrap_or(0);
        let width = pictures.iter().map(|picture| picture.size.width).sum();
        let mut pixels = vec![[0; 4]; width * height];
        let mut left = 0;
        for picture in pictures {
            for (row, line) in picture.pixels.chunks_exact(picture.size.width).enumerate() {
                let first = row * width + left;
                pixels[first..first + line.len()].copy_from_slice(line);
            }
            left += picture.size.width;
        }
        Self { size: PictureSize { width, height }, pixels }
    }
}
