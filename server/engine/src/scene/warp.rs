//! Controls for artists in a scene: the table `[objects.NAME.warp]`.

use super::anchors::regions;
use super::names::known;
use super::{elements, invalid, unsuitable, wrong_type};
use nalgebra::{Point3, Vector3};
use serde::Deserialize;
use shatter_fracture::pipeline::DEGREE_MAX;
use shatter_fracture::scene::{Grain, Paint, WarpControls, Waves, brief};
use shatter_fracture::surface::{SurfaceError, read_painted};
use shatter_proto::Error;
use shatter_proto::request::squarable;
use shatter_proto::text::number;
use std::ops::RangeInclusive;
use std::path::Path;

/// Keys of the controls for artists, the table `[objects.NAME.warp]`.
pub const WARP_KEYS: [&str; 5] = ["grain", "waves", "paint", "protect", "sites"];

/// Maximum ratio of a grain; beyond it pieces are needles that no lattice resolves.
const RATIO_MAX: f64 = 32.0;

/// Possible lengths of waves, m.
const LENGTHS_M: RangeInclusive<f64> = 1e-9..=1e9;

/// Maximum factor of pieces per volume, in either direction.
const FACTOR_MAX: f64 = 1000.0;

#[derive(Deserialize)]
struct Values {
    grain: Option<GrainValues>,
    waves: Option<WavesValues>,
    paint: Option<PaintValues>,
    #[serde(default)]
    protect: Vec<toml::Value>,
    #[serde(default)]
    sites: Vec<toml::Value>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct GrainValues {
    axis: [f64; 3],
    ratio: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WavesValues {
    length_m: f64,
    slope: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PaintValues {
    file: String,
    attribute: String,
    least: f64,
    most: f64,
}

/// Reads the table at `path`; `folder` is the base of relative file names.
pub(super) fn read(path: &str, table: &toml::Table, folder: &Path) -> Result<WarpControls, Error> {
    known(path, table.keys(), &WARP_KEYS)?;
    let values = toml::Value::Table(table.clone()).try_into();
    let values: Values = values.map_err(|error| wrong_type(path, &error, &[]))?;
    let at = |key: &str| format!("{path}.{key}");
    let controls = WarpControls {
        grain: values.grain.map(|grain| self::grain(&at("grain"), &grain)).transpose()?,
        waves: values.waves.map(|waves| self::waves(&at("waves"), &waves)).transpose()?,
        paint: values.paint.map(|paint| self::paint(&at("paint"), &paint, folder)).transpose()?,
        protected: regions(&at("protect"), &values.protect)?,
        sites_m: elements::<[f64; 3]>(&at("sites"), &values.sites)?.into_iter().map(Point3::from).collect(),
    };
    let sites = controls.sites_m.len();
    if sites > DEGREE_MAX as usize {
        return Err(invalid(at("sites"), format!("has {sites} points; give at most {DEGREE_MAX}")));
    }
    if let Some(site) = controls.sites_m.iter().position(|site| !site.iter().all(|x| x.is_finite())) {
        let value = format!("{:?}", controls.sites_m[site].coords.as_slice());
        return Err(unsuitable(format!("{path}.sites[{site}]"), &value, "three finite numbers"));
    }
    Ok(controls)
}

fn grain(path: &str, values: &GrainValues) -> Result<Grain, Error> {
    let axis = Vector3::from(squarable(values.axis));
    let length = axis.norm();
    if !length.is_normal() {
        let range = "a list of 3 finite numbers, not all 0";
        return Err(unsuitable(format!("{path}.axis"), &format!("{:?}", values.axis), range));
    }
    if !(1.0 / RATIO_MAX..=RATIO_MAX).contains(&values.ratio) {
        let range = format!("a number from {} to {RATIO_MAX}", 1.0 / RATIO_MAX);
        return Err(unsuitable(format!("{path}.ratio"), &number(values.ratio), &range));
    }
    Ok(Grain { axis: axis / length, ratio: values.ratio })
}

fn waves(path: &str, values: &WavesValues) -> Result<Waves, Error> {
    let WavesValues { length_m, slope } = *values;
    if !LENGTHS_M.contains(&length_m) {
        let range = format!("a number of meters from {:e} to {:e}", LENGTHS_M.start(), LENGTHS_M.end());
        return Err(unsuitable(format!("{path}.length_m"), &number(length_m), &range));
    }
    if !slope.is_finite() || slope <= 0.0 {
        return Err(unsuitable(format!("{path}.slope"), &number(slope), "a finite number above 0"));
    }
    Ok(Waves { length_m, slope })
}

fn paint(path: &str, values: &PaintValues, folder: &Path) -> Result<Paint, Error> {
    let PaintValues { file, attribute, least, most } = values;
    let factor = 1.0 / FACTOR_MAX..=FACTOR_MAX;
    if let Some((key, value)) =
        [("least", least), ("most", most)].into_iter().find(|(_, value)| !factor.contains(value))
    {
        let range = format!("a number from {} to {FACTOR_MAX}", 1.0 / FACTOR_MAX);
        return Err(unsuitable(format!("{path}.{key}"), &number(*value), &range));
    }
    let file = folder.join(file);
    let (points_m, values) = read_painted(&file, attribute).map_err(|error| match error {
        SurfaceError::Unreadable { .. } => invalid(path, error),
        error => invalid(path, format!("{}: {error}", brief(&file.display().to_string()))),
    })?;
    let factors = values.iter().map(|value| least + (most - least) * value.clamp(0.0, 1.0)).collect();
    Ok(Paint { points_m, factors })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_paint_name_the_file_once() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
        for (name, reason) in [("Cargo.toml", "does not begin with `ply`"), ("missing.ply", "cannot read")] {
            let values = PaintValues { file: name.to_owned(), attribute: "red".to_owned(), least: 1.0, most: 2.0 };
            let error = paint("objects.vase.warp.paint", &values, folder).unwrap_err();
            let file = folder.join(name).display().to_string();
            assert!(error.message.contains(reason) && error.message.matches(&file).count() == 1, "{error}");
        }
    }
}
