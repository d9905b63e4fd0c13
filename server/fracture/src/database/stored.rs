//! Comparison of a stored object with the result of a bake.

use super::bake_error::BakeError;
use super::bake_request::{self, BakeRequest};
use super::bake_step::BakeStep;
use super::{Tables, input_hash, load, stuffed};
use crate::cancel_token::CancelToken;
use crate::lift::LiftKind;
use crate::pipeline::{MissingLift, PreparedObject};
use crate::surface::{CrackSheets, RawMesh, Surface};
use std::path::Path;

/// The object in `file`, if a bake of `raw` would give the same one; additional tables are ignored.
///
/// A file that cannot be read counts as absent. Spacings that the request leaves open require the computation of
/// lattices, reported to `progress`; nothing more expensive is done. Errors: those of a bake up to that step.
///
/// # Errors
/// Those of a bake as far as that.
pub fn stored(
    file: &Path,
    raw: RawMesh,
    request: &BakeRequest,
    token: &CancelToken,
    progress: &mut dyn FnMut(BakeStep),
) -> Result<Option<PreparedObject>, BakeError> {
    let Ok(prepared) = load(file) else {
        return Ok(None);
    };
    bake_request::check(request)?;
    progress(BakeStep::Surface);
    let surface = Surface::repair(raw)?;
    let sheets = request.cracks.as_ref().map(|raw| CrackSheets::new(raw, &surface.frame)).transpose();
    if !alike(&prepared, &surface, sheets.map_err(BakeError::Cracks)?.as_ref(), request) {
        return Ok(None);
    }
    let own = &prepared.parameters;
    let asked = [request.elastic_spacing, request.crack_spacing];
    if asked == [Some(own.elastic_spacing), Some(own.crack_spacing)] {
        return Ok(Some(prepared));
    }
    if request.crack_spacing.is_some_and(|spacing| spacing != own.crack_spacing) {
        return Ok(None);
    }
    let (parameters, ..) = stuffed::lattices(request, &surface, token, progress)?;
    Ok((parameters == *own).then_some(prepared))
}

/// True if everything except the spacings equals the result of a bake.
fn alike(prepared: &PreparedObject, surface: &Surface, sheets: Option<&CrackSheets>, request: &BakeRequest) -> bool {
    let own = &prepared.parameters;
    let parameters = bake_request::parameters(request, surface, [own.elastic_spacing, own.crack_spacing]);
    prepared.report.input_hash == input_hash(surface, sheets)
        && prepared.name == request.name
        && prepared.impacts == request.examples
        && prepared.gamma_j_m2 == bake_request::gamma(request, &parameters)
        && request.kappa.is_none_or(|kappa| prepared.kappa == kappa)
        && *own == parameters
        && lacking(prepared, request.tables()).is_none()
}

/// Name of a table in `tables` that the object lacks, although a bake could compute it.
pub fn lacking(prepared: &PreparedObject, tables: Tables) -> Option<&'static str> {
    let unprepared = |index: usize| {
        let of = |absent: &MissingLift| absent.body == index && absent.lift == LiftKind::SurfaceDiffusion;
        prepared.report.unprepared.iter().any(of)
    };
    let bodies = || prepared.bodies.iter().enumerate();
    let absent = [
        ("elastic", tables.elastic && bodies().any(|(_, body)| body.solid.is_none())),
        ("interior", tables.interior && bodies().any(|(_, body)| body.interior.is_none())),
        (
            "surface_diffusion",
            tables.surface_diffusion
                && bodies().any(|(index, body)| body.surface_diffusion.is_none() && !unprepared(index)),
        ),
        ("attributes", tables.attributes && bodies().any(|(_, body)| body.outer.is_none())),
        ("skin", tables.skin && prepared.skin.is_none()),
    ];
    absent.into_iter().find(|(_, absent)| *absent).map(|(name, _)| name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::database::{bake, save};
    use crate::scene::Materials;
    use crate::surface::shapes;

    /// A request, and a file with the object that it makes of a bar, with the interior lift only.
    fn baked(spacings: [Option<f64>; 2]) -> (BakeRequest, tempfile::TempDir) {
        let materials = Materials::parse(crate::scene::MATERIALS).unwrap();
        let [elastic_spacing, crack_spacing] = spacings;
        let tables = Tables { interior: true, ..Tables::NONE };
        let glass = materials.get("glass").unwrap().clone();
        let request = BakeRequest { elastic_spacing, crack_spacing, tables, ..BakeRequest::new("bar", "glass", glass) };
        let folder = tempfile::tempdir().unwrap();
        let prepared = bake(bar(), &request, &CancelToken::default(), &mut |_| {}).unwrap();
        save(&prepared, &folder.path().join("bar.shatter")).unwrap();
        (request, folder)
    }

    fn bar() -> RawMesh {
        shapes::cuboid([0.4, 0.2, 0.2])
    }

    #[track_caller]
    fn check(folder: &tempfile::TempDir, raw: RawMesh, request: &BakeRequest, wanted: bool) {
        let file = folder.path().join("bar.shatter");
        let found = stored(&file, raw, request, &CancelToken::default(), &mut |_| {}).unwrap();
        assert_eq!(found.is_some(), wanted, "{request:?}");
    }

    #[test]
    fn any_parameter_that_differs_makes_another_object() {
        let (request, folder) = baked([Some(0.12), Some(0.09)]);
        check(&folder, bar(), &request, true);
        check(&folder, shapes::cuboid([0.4, 0.2, 0.21]), &request, false);
        let mut stone = request.clone();
        stone.material.density_kg_m3 *= 2.0;
        for other in [
            stone,
            BakeRequest { name: "rod".to_owned(), ..request.clone() },
            BakeRequest { material_name: "crystal".to_owned(), ..request.clone() },
            BakeRequest { fragment_size_m: Some(0.01), ..request.clone() },
            BakeRequest { gamma_j_m2: Some(3.0), ..request.clone() },
            BakeRequest { elastic_spacing: Some(0.11), ..request.clone() },
            BakeRequest { elastic_spacing: None, ..request.clone() },
            BakeRequest { crack_spacing: Some(0.1), ..request.clone() },
            BakeRequest { crack_spacing: None, ..request.clone() },
            BakeRequest { kappa: Some(0.5), ..request.clone() },
            BakeRequest { examples: 3, ..request.clone() },
            BakeRequest { seed: 1, ..request.clone() },
            BakeRequest { tables: Tables::ALL, ..request.clone() },
        ] {
            check(&folder, bar(), &other, false);
        }
        let less = Tables { interior: false, ..request.tables };
        check(&folder, bar(), &BakeRequest { tables: less, ..request.clone() }, true);
        std::fs::write(folder.path().join("bar.shatter"), "damaged").unwrap();
        check(&folder, bar(), &request, false);
    }

    #[test]
    fn spacings_that_are_left_open_are_those_that_a_bake_chooses() {
        let (request, folder) = baked([None, None]);
        check(&folder, bar(), &request, true);
        check(&folder, bar(), &BakeRequest { crack_spacing: Some(0.09), ..request.clone() }, false);
    }
}
