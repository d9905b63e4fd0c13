//! Parsers for the values of options.

use shatter_cli_common::choice;
use shatter_client::{
    Convention, DegreeRule, DisplacementSource, Effect, Error, Lift, Quality, Ray, RequestedCriterion,
    RequestedSurface, RetainedFragment,
};
use shatter_proto::request::ITERATIONS_MAX;
use shatter_proto::text::quoted;

/// Parses numbers separated by commas.
fn numbers<const N: usize>(text: &str, wanted: &str) -> Result<[f64; N], String> {
    let parts: Vec<&str> = text.split(',').collect();
    let parts: [&str; N] = parts.as_slice().try_into().map_err(|_| {
        format!("expected {N} numbers {wanted}, separated by commas without spaces; found {}", parts.len())
    })?;
    let mut found = [0.0_f64; N];
    for (number, part) in found.iter_mut().zip(parts) {
        let part = part.trim();
        *number = part.parse().map_err(|_| {
            format!("`{}` is not a number; write numbers and commas alone, as in 0.1,0,-0.2", quoted(part))
        })?;
        if !number.is_finite() {
            return Err(format!("`{}` is not finite; every number must be", quoted(part)));
        }
        if let Some(decimals) = zero_without_point(part) {
            return Err(format!(
                "`{part}` is ambiguous; write 0.{decimals} or 0.0{decimals}, or {decimals} for the whole number"
            ));
        }
    }
    Ok(found)
}

/// Digits after a leading zero without a decimal point, as in `05`: probably the point is missing.
fn zero_without_point(part: &str) -> Option<&str> {
    let digits = part.trim_start_matches(['-', '+']).strip_prefix('0')?;
    (!digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit())).then_some(digits)
}

/// Parses `X,Y,Z`.
pub fn vector(text: &str) -> Result<[f64; 3], String> {
    numbers(text, "X,Y,Z")
}

/// Parses `X,Y,Z,DX,DY,DZ`: origin and direction.
pub fn ray(text: &str) -> Result<Ray, String> {
    let [x, y, z, dx, dy, dz] = numbers(text, "X,Y,Z,DX,DY,DZ (origin and direction)")?;
    Ok(Ray { origin_m: [x, y, z], direction: [dx, dy, dz] })
}

/// Largest number of sites; the daemon has the last word.
const DEGREE_MAX: u32 = 512;

/// Parses a number of sites, or a rule for it.
pub fn degree(text: &str) -> Result<DegreeRule, String> {
    if text.parse::<f64>().is_ok() {
        return sites(text).map(DegreeRule::Sites);
    }
    choice(
        text,
        &[
            ("inferred", DegreeRule::Inferred),
            ("verified", DegreeRule::Verified),
            ("closed_form", DegreeRule::ClosedForm),
            ("optimised", DegreeRule::Optimized),
        ],
    )
    .map_err(|error| format!("{error}, or a whole number"))
}

/// Parses a number of sites. The daemon decides whether it is allowed, 0 included.
pub fn sites(text: &str) -> Result<u32, String> {
    text.parse().map_err(|_| format!("must be a whole number, 1 to {DEGREE_MAX}"))
}

/// Parses a number of iterations. The daemon decides whether it is allowed.
pub fn iterations(text: &str) -> Result<u32, String> {
    text.parse().map_err(|_| format!("must be a whole number, 0 to {ITERATIONS_MAX}"))
}

/// Parses a deadline, ms.
pub fn milliseconds(text: &str) -> Result<u64, String> {
    let wrong = || format!("must be a whole number of milliseconds, 1 to {}: 0 leaves no time for a result", u64::MAX);
    text.parse().ok().filter(|ms| *ms > 0).ok_or_else(wrong)
}

/// Parses the name of a lift.
pub fn lift(text: &str) -> Result<Lift, String> {
    let lifts =
        [("euclidean", Lift::Euclidean), ("interior", Lift::Interior), ("surface_diffusion", Lift::SurfaceDiffusion)];
    choice(text, &lifts)
}

/// Parses a source of displacements.
pub fn elastic(text: &str) -> Result<DisplacementSource, String> {
    choice(text, &[("reduced", DisplacementSource::Reduced), ("solve", DisplacementSource::Solve)])
}

/// Parses the name of a criterion.
pub fn criterion(text: &str) -> Result<RequestedCriterion, String> {
    choice(text, &RequestedCriterion::ALL.map(|criterion| (criterion.name(), criterion)))
}

/// Parses a kind of surface.
pub fn surface(text: &str) -> Result<RequestedSurface, String> {
    choice(text, &RequestedSurface::ALL.map(|surface| (surface.name(), surface)))
}

/// Parses the name of a preset.
pub fn quality(text: &str) -> Result<Quality, String> {
    choice(text, &Quality::ALL.map(|quality| (quality.name(), quality)))
}

/// Parses `HANDLE/FRAGMENT`.
pub fn origin(text: &str) -> Result<RetainedFragment, String> {
    let parts =
        text.split_once('/').and_then(|(handle, fragment)| Some((handle.parse().ok()?, fragment.parse().ok()?)));
    let (handle, fragment) = parts.ok_or(
        "must be HANDLE/FRAGMENT, two whole numbers: the handle that `shatter impact --keep` printed, and the id of a fragment",
    )?;
    Ok(RetainedFragment { handle, fragment })
}

/// A convention with its name.
#[derive(Clone)]
pub struct NamedConvention {
    /// Name of the convention.
    pub name: String,
    /// The convention.
    pub convention: Convention,
}

/// Parses the name of a convention.
pub fn convention(text: &str) -> Result<NamedConvention, String> {
    Ok(NamedConvention { name: text.to_owned(), convention: choice(text, &Convention::NAMED)? })
}

/// Parses the name of an effect.
pub fn effect(text: &str) -> Result<Effect, Error> {
    Effect::by_name(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_are_three_numbers_and_rays_six() {
        assert_eq!(vector("-1,0.5, 0"), Ok([-1.0, 0.5, 0.0]));
        for text in ["", "1,2", "1,2,3,4", "1,x,3"] {
            assert!(vector(text).is_err(), "{text}");
        }
        assert_eq!(vector("0,NaN,1").unwrap_err(), "`NaN` is not finite; every number must be");
        assert_eq!(vector("0,inf,1").unwrap_err(), "`inf` is not finite; every number must be");
        assert_eq!(vector("0,-05,1").unwrap_err(), "`-05` is ambiguous; write 0.5 or 0.05, or 5 for the whole number");
        assert_eq!(vector("0,-0,0.05"), Ok([0.0, -0.0, 0.05]));
        assert_eq!(ray("1,2,3,0,-1,0"), Ok(Ray { origin_m: [1.0, 2.0, 3.0], direction: [0.0, -1.0, 0.0] }));
        assert!(ray("1,2,3").unwrap_err().contains("6 numbers"));
    }

    #[test]
    fn degrees_are_rules_or_whole_numbers() {
        assert_eq!(degree("12"), Ok(DegreeRule::Sites(12)));
        assert_eq!(degree("0"), Ok(DegreeRule::Sites(0)));
        assert_eq!(degree("verified"), Ok(DegreeRule::Verified));
        for odd in ["-3", "2.5", "1e30", "NaN", "99999999999"] {
            assert_eq!(degree(odd).unwrap_err(), "must be a whole number, 1 to 512");
        }
        for odd in ["-3", "2.5", "4294967296"] {
            assert_eq!(iterations(odd).unwrap_err(), "must be a whole number, 0 to 10000");
        }
        assert_eq!(iterations("10001"), Ok(10_001), "refused by the daemon, which names its limit");
        assert!(degree("closedform").unwrap_err().contains("did you mean `closed_form`?"));
    }
}
