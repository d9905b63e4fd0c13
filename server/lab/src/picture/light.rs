//! Lighting of surfaces.

use super::camera::Camera;
use super::color::Color;
use nalgebra::Vector3;

/// Lights and gloss of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderStyle {
    /// Strength of the key light, which casts shadows.
    pub key: f32,
    /// Strength of the fill light, which casts none.
    pub fill: f32,
    /// Strength of the sky light from above.
    pub sky: f32,
    /// Strength of the light reflected by the ground.
    pub bounce: f32,
    /// Strength of the highlight.
    pub gloss: f32,
}

impl RenderStyle {
    /// Emphasis on shape: a strong key light, a faint highlight.
    pub const STUDIO: Self = Self { key: 0.80, fill: 0.10, sky: 0.55, bounce: 0.26, gloss: 0.05 };
    /// Emphasis on colors that represent values: even light, no highlight.
    pub const CHART: Self = Self { key: 0.42, fill: 0.10, sky: 0.74, bounce: 0.48, gloss: 0.0 };
}

/// Appearance of a surface at a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finish {
    /// Color.
    pub color: Color,
    /// Share of light that is reflected as by a mirror at normal incidence: 0 for matte surfaces, 0.04 for glazes, more for metals.
    pub reflectance: f32,
}

/// Lights placed for a camera.
pub(super) struct Lights {
    style: RenderStyle,
    /// Unit vector towards the key light.
    pub key: Vector3<f32>,
    fill: Vector3<f32>,
}

/// Linear colors of warm key light, cool fill light and sky, of about equal brightness.
const KEY_TINT: [f32; 3] = [1.04, 1.0, 0.93];
const FILL_TINT: [f32; 3] = [0.90, 0.98, 1.14];
const SKY_TINT: [f32; 3] = [0.97, 1.0, 1.05];

/// Ground shadows fainter than this are omitted, so that they end before the border of the picture.
const FAINT: f32 = 0.015;

/// Exponent of the highlight.
const SHININESS: i32 = 36;

/// Brightness of the key light in a mirror, and the cosines between which its edge fades.
const LAMP: f32 = 14.0;
const LAMP_EDGE: [f32; 2] = [0.965, 0.985];

/// Brightness above which highlights are compressed instead of clipped.
const KNEE: f32 = 0.80;

impl Lights {
    /// Places the key light at the upper left behind the camera, and the fill light at the right.
    pub fn new(style: RenderStyle, camera: &Camera) -> Self {
        let key = camera.right * -0.62 + camera.back * 0.62 + Vector3::y() * 0.85;
        let fill = camera.right * 0.85 + camera.back * 0.45 + Vector3::y() * 0.10;
        Self { style, key: key.normalize(), fill: fill.normalize() }
    }

    /// Light that leaves a surface towards the eye (unit vector `view`); `sky` and `key` are the visible shares of both lights.
    pub fn shade(&self, finish: Finish, normal: &Vector3<f32>, view: &Vector3<f32>, sky: f32, key: f32) -> [f32; 3] {
        let style = &self.style;
        let above = 0.5 + 0.5 * normal.y;
        let ambient = (style.bounce + (style.sky - style.bounce) * above) * sky;
        let direct = style.key * normal.dot(&self.key).max(0.0) * key;
        let fill = style.fill * normal.dot(&self.fill).max(0.0) * sky;
        let half = (self.key + view).normalize();
        let gloss = style.gloss * normal.dot(&half).max(0.0).powi(SHININESS) * key;
        let mirrored = self.mirrored(finish.reflectance, normal, view, sky, key);
        [0, 1, 2].map(|k| {
            let arriving = ambient * SKY_TINT[k] + direct * KEY_TINT[k] + fill * FILL_TINT[k];
            soften(finish.color.0[k] * arriving + gloss + mirrored)
        })
    }

    /// Light of the ground, the sky and the key light that is reflected as by a mirror.
    ///
    /// Based on: C. Schlick, *An inexpensive BRDF model for physically-based rendering* (Fresnel term), 1994.
    fn mirrored(&self, reflectance: f32, normal: &Vector3<f32>, view: &Vector3<f32>, sky: f32, key: f32) -> f32 {
        if reflectance == 0.0 {
            return 0.0;
        }
        let cosine = normal.dot(view).clamp(0.0, 1.0);
        let mirror = normal * (2.0 * cosine) - view;
        let above = (0.5 + 2.0 * mirror.y).clamp(0.0, 1.0);
        let [rim, disk] = LAMP_EDGE;
        let lamp = LAMP * ((mirror.dot(&self.key) - rim) / (disk - rim)).clamp(0.0, 1.0);
        let arriving = (self.style.bounce + (self.style.sky - self.style.bounce) * above) * sky + lamp * key;
        (reflectance + (1.0 - reflectance) * (1.0 - cosine).powi(5)) * arriving
    }

    /// Darkness of the ground where these shares of sky and key light arrive: 0 in full light.
    pub fn ground_shadow(&self, sky: f32, key: f32) -> f32 {
        let direct = self.style.key * self.key.y;
        let whole = self.style.sky + direct;
        let dark = 1.0 - (self.style.sky * sky + direct * key) / whole;
        (dark - FAINT).max(0.0) / (1.0 - FAINT)
    }
}

/// Keeps values below the knee and compresses larger ones towards 1.
fn soften(value: f32) -> f32 {
    if value <= KNEE { value } else { KNEE + (1.0 - KNEE) * (1.0 - (-(value - KNEE) / (1.0 - KNEE)).exp()) }
}
