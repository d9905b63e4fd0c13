//! Animated pictures: PNG with one palette, whose frames store only the pixels that change.
//!
//! Based on: S. Wan, P. Prusinkiewicz, S. Wong, *Variance-based color image quantization for frame buffer display* (palette), 1990.

use super::PictureSize;
use super::image::{Image, PictureError};
use std::collections::BTreeMap;

/// Frame of an animated picture.
#[derive(Clone, Debug, PartialEq)]
pub struct AnimationFrame {
    /// Opaque picture; all frames have the same size.
    pub image: Image,
    /// Time for which it is shown, ms.
    pub delay_ms: u16,
}

/// Number of colors. The first entry of the palette is transparent and marks pixels that do not change.
const COLORS: usize = 255;

/// Thresholds of ordered dithering, by the parities of row and column (Bayer 1973).
const DITHER: [[u8; 2]; 2] = [[0, 2], [3, 1]];

/// Color with six bits per channel, after dithering.
type Bin = [u8; 3];

/// Bytes of an animated PNG that repeats forever; an error without frames.
pub fn animated_png(frames: &[AnimationFrame]) -> Result<Vec<u8>, PictureError> {
    let size = frames.first().map_or(PictureSize { width: 1, height: 1 }, |first| first.image.size);
    let (colors, entries) = palette(frames);
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, size.width as u32, size.height as u32);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_palette(colors.as_flattened());
    encoder.set_trns(&[0][..]);
    encoder.set_compression(png::Compression::High);
    encoder.set_filter(png::Filter::NoFilter);
    encoder.set_animated(frames.len() as u32, 0)?;
    encoder.set_blend_op(png::BlendOp::Over)?;
    let mut writer = encoder.write_header()?;
    let mut shown = vec![0; size.width * size.height];
    for frame in frames {
        let next: Vec<u8> = bins(&frame.image).map(|bin| entries[&bin]).collect();
        let is_new = |at: usize| next[at] != shown[at];
        let [columns, rows] = changed(&is_new, size);
        let places = rows.clone().flat_map(|row| columns.clone().map(move |column| row * size.width + column));
        let part: Vec<u8> = places.map(|at| if is_new(at) { next[at] } else { 0 }).collect();
        writer.set_frame_delay(frame.delay_ms, 1000)?;
        writer.reset_frame_position()?;
        writer.set_frame_dimension(columns.len() as u32, rows.len() as u32)?;
        writer.set_frame_position(columns.start as u32, rows.start as u32)?;
        writer.write_image_data(&part)?;
        shown = next;
    }
    writer.finish()?;
    Ok(bytes)
}

/// Columns and rows with all new pixels; one pixel if there are none.
fn changed(is_new: &impl Fn(usize) -> bool, size: PictureSize) -> [std::ops::Range<usize>; 2] {
    let places = (0..size.width * size.height).filter(|at| is_new(*at)).map(|at| [at % size.width, at / size.width]);
    let bounds = places.fold(None, |bounds: Option<[[usize; 2]; 2]>, place| {
        let [low, high] = bounds.unwrap_or([place; 2]);
        Some([[0, 1].map(|k| low[k].min(place[k])), [0, 1].map(|k| high[k].max(place[k]))])
    });
    let [low, high] = bounds.unwrap_or_default();
    [0, 1].map(|k| low[k]..high[k] + 1)
}

fn bins(image: &Image) -> impl Iterator<Item = Bin> {
    let width = image.size.width;
    let bin = move |(at, pixel): (usize, &[u8; 4])| {
        let threshold = DITHER[at / width % 2][at % width % 2];
        [0, 1, 2].map(|k| pixel[k].saturating_add(threshold) >> 2)
    };
    image.pixels.iter().enumerate().map(bin)
}

/// Palette of all frames, and the entry of each bin: the set of bins with the largest error is divided at its mean, again and again.
fn palette(frames: &[AnimationFrame]) -> (Vec<[u8; 3]>, BTreeMap<Bin, u8>) {
    let mut counts = BTreeMap::<Bin, f64>::new();
    frames.iter().flat_map(|frame| bins(&frame.image)).for_each(|bin| *counts.entry(bin).or_default() += 1.0);
    let mut sets = vec![counts.into_iter().collect::<Vec<_>>()];
    while sets.len() < COLORS {
        let errors = sets.iter().map(|set| [0, 1, 2].map(|axis| error(set, axis))).enumerate();
        let axes = errors.flat_map(|(at, errors)| [0, 1, 2].map(|axis| (errors[axis], at, axis)));
        let Some((_, at, axis)) = axes.filter(|(error, ..)| *error > 0.0).max_by(|a, b| a.0.total_cmp(&b.0)) else {
            break;
        };
        let set = sets.swap_remove(at);
        let middle = mean(&set, axis);
        let (low, high) = set.into_iter().partition(|(bin, _)| f64::from(bin[axis]) < middle);
        sets.extend([low, high]);
    }
    let color = |set: &Vec<(Bin, f64)>| [0, 1, 2].map(|axis| (4.0 * mean(set, axis) + 0.5) as u8);
    let colors = std::iter::once([0; 3]).chain(sets.iter().map(color)).collect();
    let entries = (1..).zip(&sets).flat_map(|(entry, set)| set.iter().map(move |(bin, _)| (*bin, entry)));
    (colors, entries.collect())
}

fn mean(set: &[(Bin, f64)], axis: usize) -> f64 {
    let sum: f64 = set.iter().map(|(bin, count)| count * f64::from(bin[axis])).sum();
    sum / set.iter().map(|(_, count)| count).sum::<f64>()
}

/// Sum of squared distances from the mean.
fn error(set: &[(Bin, f64)], axis: usize) -> f64 {
    let middle = mean(set, axis);
    set.iter().map(|(bin, count)| count * (f64::from(bin[axis]) - middle).powi(2)).sum()
}
