//! Colors in linear light; perceptual choices are made in OKLab.
//!
//! Based on: B. Ottosson, *A perceptual color space for image processing* (OKLab), 2020.

/// Color in linear sRGB, components between 0 and 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Color(pub [f32; 3]);

impl Color {
    /// Color from OKLab's polar form: lightness 0 to 1, chroma (0: gray; 0.1: muted; 0.25: vivid), hue in degrees.
    ///
    /// Clamped to the gamut of sRGB.
    pub fn oklch(lightness: f32, chroma: f32, hue_deg: f32) -> Self {
        let hue = hue_deg.to_radians();
        Self::oklab([lightness, chroma * hue.cos(), chroma * hue.sin()])
    }

    /// Color from OKLab (Ottosson 2020).
    fn oklab([lightness, a, b]: [f32; 3]) -> Self {
        let l = (lightness + 0.396_337_78 * a + 0.215_803_76 * b).powi(3);
        let m = (lightness - 0.105_561_346 * a - 0.063_854_17 * b).powi(3);
        let s = (lightness - 0.089_484_18 * a - 1.291_485_5 * b).powi(3);
        let red = 4.076_741_7 * l - 3.307_711_6 * m + 0.230_969_94 * s;
        let green = -1.268_438 * l + 2.609_757_4 * m - 0.341_319_4 * s;
        let blue = -0.004_196_086_3 * l - 0.703_418_6 * m + 1.707_614_7 * s;
        Self([red, green, blue].map(|x| x.clamp(0.0, 1.0)))
    }

    /// Interpolates from this color (0) to `other` (1) in linear light.
    pub fn mix(self, other: Self, share: f32) -> Self {
        Self([0, 1, 2].map(|k| self.0[k] + (other.0[k] - self.0[k]) * share))
    }

    /// Three bytes of sRGB (IEC 61966-2-1).
    pub fn srgb(self) -> [u8; 3] {
        self.0.map(encode)
    }

    /// CSS notation `#rrggbb`.
    pub fn hex(self) -> String {
        let [r, g, b] = self.srgb();
        format!("#{r:02x}{g:02x}{b:02x}")
    }
}

/// Encodes one linear component as a byte of sRGB.
pub(super) fn encode(linear: f32) -> u8 {
    let clamped = linear.clamp(0.0, 1.0);
    let curved = if clamped <= 0.003_130_8 { 12.92 * clamped } else { 1.055 * clamped.powf(1.0 / 2.4) - 0.055 };
    (curved * 255.0).round() as u8
}

/// Color map: anchors in OKLab's polar form (lightness, chroma, hue in degrees), traversed at constant speed in OKLab, so that equal
/// steps of the value look equal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ramp {
    anchors: &'static [[f32; 3]],
}

/// Color map from pale ivory through amber and crimson to deep violet.
///
/// Lightness falls monotonically, so the map works in grayscale and with any color vision; its pale end shows the shape where values are
/// small.
pub const ENERGY: Ramp = Ramp {
    anchors: &[
        [0.955, 0.020, 95.0],
        [0.895, 0.075, 86.0],
        [0.815, 0.125, 70.0],
        [0.715, 0.165, 50.0],
        [0.610, 0.190, 30.0],
        [0.500, 0.180, 8.0],
        [0.395, 0.150, -20.0],
        [0.285, 0.115, -48.0],
    ],
};

impl Ramp {
    /// Color at `share`, which is clamped to [0, 1]; NaN counts as 0.
    pub fn at(&self, share: f32) -> Color {
        Color::oklab(self.lab(share))
    }

    fn lab(&self, share: f32) -> [f32; 3] {
        let anchors: Vec<[f32; 3]> = self.anchors.iter().map(|&anchor| cartesian(anchor)).collect();
        let lengths: Vec<f32> = anchors.windows(2).map(|pair| distance(pair[0], pair[1])).collect();
        let share = if share > 0.0 { share.min(1.0) } else { 0.0 };
        let mut left = share * lengths.iter().sum::<f32>();
        for (pair, &length) in anchors.windows(2).zip(&lengths) {
            if left <= length {
                return [0, 1, 2].map(|k| pair[0][k] + (pair[1][k] - pair[0][k]) * left / length);
            }
            left -= length;
        }
        anchors[anchors.len() - 1]
    }
}

fn cartesian([lightness, chroma, hue_deg]: [f32; 3]) -> [f32; 3] {
    let hue = hue_deg.to_radians();
    [lightness, chroma * hue.cos(), chroma * hue.sin()]
}

fn distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    [0, 1, 2].map(|k| (a[k] - b[k]).powi(2)).iter().sum::<f32>().sqrt()
}

/// Turn between successive hues that keeps any number of them apart: 360° (1 − 1/φ).
const GOLDEN_TURN_DEG: f32 = 137.507_77;

/// First hue, degrees.
const FIRST_HUE_DEG: f32 = 232.0;

/// Muted color for the outer faces of fragment `id`; consecutive fragments have distant hues.
pub fn fragment_color(id: u32) -> Color {
    let lightness = [0.66, 0.74, 0.60][id as usize % 3];
    Color::oklch(lightness, 0.072, hue_deg(id))
}

/// Color of the same fragment's crack faces: lighter and warmer, with a slight tint of its hue.
pub fn crack_color(id: u32) -> Color {
    Color::oklch(0.90, 0.045, 78.0).mix(Color::oklch(0.82, 0.075, hue_deg(id)), 0.22)
}

fn hue_deg(id: u32) -> f32 {
    (FIRST_HUE_DEG + GOLDEN_TURN_DEG * (id % 360) as f32) % 360.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ramp_darkens_evenly() {
        let colors: Vec<[f32; 3]> = (0..=64).map(|k| ENERGY.lab(k as f32 / 64.0)).collect();
        let steps: Vec<f32> = colors.windows(2).map(|pair| distance(pair[0], pair[1])).collect();
        let mean = steps.iter().sum::<f32>() / steps.len() as f32;
        assert!(steps.iter().all(|step| (step / mean - 1.0).abs() < 0.05), "{steps:?}");
        assert!(colors.windows(2).all(|pair| pair[1][0] < pair[0][0]));
    }

    #[test]
    fn every_color_of_the_ramp_can_be_shown() {
        for k in 0..=64 {
            let inside = |x: &f32| (0.0..=1.0).contains(x);
            assert!(ENERGY.at(k as f32 / 64.0).0.iter().all(inside));
        }
        assert_eq!(ENERGY.at(f32::NAN), ENERGY.at(0.0));
        assert_eq!(ENERGY.at(7.0), ENERGY.at(1.0));
    }

    #[test]
    fn white_and_gray_come_out_as_such() {
        assert_eq!(Color::oklch(1.0, 0.0, 0.0).hex(), "#ffffff");
        let [r, g, b] = Color::oklch(0.5, 0.0, 0.0).srgb();
        assert!(r == g && g == b);
    }
}
