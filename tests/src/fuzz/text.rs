//! Fuzz target for configuration, materials and scenes.

use super::{choice, seed};
use shatter_engine::scene::Scene;
use shatter_fracture::scene::Materials;
use shatter_proto::Error;
use shatter_server::config::{Config, DEFAULT};
use std::path::Path;

const MATERIALS: &str = include_str!("../../../config/materials.toml");
const SCENES: [&str; 3] = [
    include_str!("../../../config/scenes/glass_shop.toml"),
    include_str!("../../../config/scenes/hero_statue.toml"),
    include_str!("../../../config/scenes/stone_arch.toml"),
];

pub(super) fn toml_seeds() -> Vec<Vec<u8>> {
    vec![seed(0, DEFAULT), seed(1, MATERIALS)]
}

pub(super) fn scene_seeds() -> Vec<Vec<u8>> {
    SCENES.map(|scene| scene.as_bytes().to_vec()).into()
}

pub(super) fn toml(input: &[u8]) -> bool {
    let Some((kind, rest)) = choice(input, 2) else { return false };
    let Ok(text) = std::str::from_utf8(rest) else { return false };
    if kind == 0 {
        return match Config::parse(text, "fuzz.toml") {
            Ok(config) => {
                assert!(config.threads() > 0 && config.requests_at_once() > 0 && config.held_max() > 0);
                // None of these must overflow.
                let _ = (config.tick(), config.drain(), config.kept(), config.watch());
                true
            }
            Err(error) => says_why(&error),
        };
    }
    match Materials::parse(text) {
        Ok(materials) => {
            for material in materials.names().map(|name| materials.get(name).expect("it is listed")) {
                let numbers = [material.young_pa, material.density_kg_m3, material.strength_pa];
                assert!(numbers.iter().all(|number| number.is_finite() && *number > 0.0), "{material:?}");
                // Poisson's ratio is checked later, when a stiffness is computed from it.
            }
            true
        }
        Err(error) => {
            assert!(!error.to_string().is_empty());
            false
        }
    }
}

pub(super) fn scene(input: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(input) else { return false };
    match Scene::parse(text, Path::new("scenes")) {
        Ok(scene) => {
            assert!(!scene.objects.is_empty() && scene.databases().len() == scene.objects.len());
            true
        }
        Err(error) => says_why(&error),
    }
}

fn says_why(error: &Error) -> bool {
    assert!(!error.message.is_empty(), "{error:?}");
    false
}
