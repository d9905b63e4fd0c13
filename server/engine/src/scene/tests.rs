use super::*;
use nalgebra::{Point3, Vector3};
use shatter_fracture::database::Tables;
use shatter_fracture::pipeline::{self, ElementChoice, SurfaceKind};
use shatter_proto::effect::{Effect, Effects};
use shatter_proto::request::{Lift, Quality, Request, RequestedCriterion};

fn object(text: &str) -> Result<SceneObject, Error> {
    Scene::parse(&format!("[objects.vase]\n{text}"), Path::new("")).map(|scene| scene.objects["vase"].clone())
}

fn check(text: &str, at: &str, hint: &str) {
    let error = object(text).expect_err(text);
    assert_eq!(error.at, at, "{error}");
    assert!(error.message.contains(hint), "{error}");
}

#[test]
fn unknown_keys_are_rejected_with_a_suggestion() {
    check("material = \"glas\"", "objects.vase.material", "\"glass\"");
    check("efects = []", "objects.vase.efects", "`effects`");
    check("effects = [\"bond\"]", "bond", "`bonds`");
    check("allow = [\"normal\"]", "normal", "`normals`");
    check("lift = \"euclidian\"", "objects.vase.lift", "`euclidean`");
    check("quality = \"drift\"", "objects.vase.quality", "`draft`");
    check("shape = \"vaze\"", "objects.vase.shape", "`vase`");
    check("effects = [\"tensile\"]", "tensile", "`elastic`");
    for database in ["", "a/b", "..\\\\b", "/databases/vase.shatter", ".vase"] {
        check(&format!("database = \"{database}\""), "objects.vase.database", "without folders");
    }
    check("database = 3", "objects.vase.database", "is 3; it must be a string");
    check("effects = []\nvolume_min_m3 = 0.1", "objects.vase.volume_min_m3", "`slivers`");
    for size_m in ["0.0", "1e-300", "inf"] {
        let reason = "it must be a number of meters from 1e-9 to 1e9";
        check(&format!("fragment_size_m = {size_m}"), "objects.vase.fragment_size_m", reason);
    }
    check("gamma_j_m2 = 1e-320", "objects.vase.gamma_j_m2", "is 1e-320; it must be a number from 1e-30 to 1e30");
    check(
        "fragments_max = 5000000000",
        "objects.vase.fragments_max",
        "is 5000000000; it must be a whole number from 1 to 4294967295",
    );
    for sites in [0, 513] {
        let reason = format!("is {sites}; it must be a whole number from 1 to 512");
        check(&format!("sites_max = {sites}"), "objects.vase.sites_max", &reason);
    }
    check("bytes_max = -1", "objects.vase.bytes_max", "is -1; it must be a whole number from 1 to 9223372036854775807");
    check("examples = 2000000", "objects.vase.examples", "is 2000000; it must be a whole number from 0 to 1048576");
    check("elastic_spacing = 7", "objects.vase.elastic_spacing", "is 7; it must be a number from 0.002 to 0.25");
    for own in
        ["elastic_spacing = 0.05", "crack_spacing = 0.03", "elements = \"auto\"", "surface = \"exact\"", "examples = 0"]
    {
        let key = format!("objects.vase.{}", own.split(' ').next().unwrap());
        check(own, &key, "needs `shape`; for a mesh of your own, remove it and bake with `--");
    }
    check("surface = \"exakt\"", "objects.vase.surface", "`exact`");
    check("elements = \"quadric\"", "objects.vase.elements", "`quadratic`");
    let coarse = "elastic_spacing = 0.03\ncrack_spacing = 0.05";
    check(coarse, "objects.vase.crack_spacing", "is 0.05; it must be 0.03, the value of `elastic_spacing`, or less");
    check("effects = \"hulls\"", "objects.vase.effects", "is \"hulls\"; it must be a list");
    check("sites_max = \"many\"", "objects.vase.sites_max", "is \"many\"; it must be a whole number");
    let held = |anchor: &str| format!("allow = [\"anchored\"]\nanchors = [{anchor}]");
    check(&held("{ centre = [0, 0, 0], radius_m = 1 }"), "objects.vase.anchors[0].centre", "`center`");
    for half in ["{}", "{ center = [0, 0, 0] }", "{ center = [0, 0, 0], radius_m = 1, min = [0, 0, 0] }"] {
        check(&held(half), "objects.vase.anchors[0]", "a box");
    }
    check(&held("{ center = [0, 0], radius_m = 1 }"), "objects.vase.anchors[0].center", "a list of 2 values");
    check(&held("{ center = [0, 0, nan], radius_m = 1 }"), "objects.vase.anchors[0]", "finite");
    check(
        &held("{ center = [0, 0, 0], radius_m = 0 }"),
        "objects.vase.anchors[0].radius_m",
        "is 0; it must be a number above 0",
    );
    check(&held("{ min = [0, 0, 0], max = [1, 0, 1] }"), "objects.vase.anchors[0].max", "`min`");
    check(&held(""), "objects.vase.anchors", "at least one");
    check("effects = [\"elastic\", \"gravity\"]", "gravity", "`anchored`");
    check("anchors = [{ center = [0, 0, 0], radius_m = 1 }]", "objects.vase.anchors", "`anchored`");
    let ball = held("{ center = [0, 0, 0], radius_m = 1 }");
    check(&format!("{ball}\ngravity_m_s2 = [0, -1, 0]"), "objects.vase.gravity_m_s2", "`gravity`");
    let pulled = ball.replace("\"]", "\", \"gravity\"]");
    for gravity in ["inf", "nan", "-1e300"] {
        check(&format!("{pulled}\ngravity_m_s2 = [0, {gravity}, 0]"), "objects.vase.gravity_m_s2", "from -1e6 to 1e6");
    }
    let scene = |text: &str| Scene::parse(text, Path::new("")).unwrap_err().at;
    assert_eq!(scene("objets = 1"), "objets");
    assert_eq!((scene(""), scene("[objects]")), ("objects".to_owned(), "objects".to_owned()));
    assert_eq!(scene("title = 3\n[objects.a]"), "title");
    assert_eq!(scene("[objects.\"a/b\"]"), "a/b");
}

#[test]
fn an_object_uses_the_database_of_its_name_or_a_named_one() {
    let text =
        "[objects.vase]\n[objects.near]\ndatabase = \"statue\"\n[objects.far]\ndatabase = \"statue\"\neffects = []";
    let databases = Scene::parse(text, Path::new("")).unwrap().databases();
    let pairs: Vec<_> = databases.iter().map(|(object, database)| (object.as_str(), database.as_str())).collect();
    assert_eq!(pairs, [("far", "statue"), ("near", "statue"), ("vase", "vase")]);
}

#[test]
fn a_database_is_baked_for_all_objects_that_are_made_of_it() {
    let both = |near: &str, far: &str| {
        let far = format!("[objects.far]\ndatabase = \"statue\"\n{far}");
        Scene::parse(&format!("{far}\n[objects.near]\ndatabase = \"statue\"\n{near}"), Path::new("")).unwrap()
    };
    const STATUE: &str = "shape = \"statue\"\nmaterial = \"plaster\"\nexamples = 60\ncrack_spacing = 0.02";
    let request = |far: &str| both(STATUE, far).recipes().unwrap()["statue"].bake("statue").unwrap().1;
    let alone = request("effects = []");
    assert_eq!((alone.name.as_str(), alone.examples, alone.crack_spacing), ("statue", 60, Some(0.02)));
    let plain = Tables { attributes: false, skin: false, ..Tables::ALL };
    assert_eq!(alone.tables, Tables { surface_diffusion: false, ..plain });
    assert_eq!(request("effects = [\"interior\"]\nlift = \"surface_diffusion\"").tables, plain);
    assert_eq!(request("elastic_spacing = 0.03\nmaterial = \"plaster\"").elastic_spacing, Some(0.03));
    let surfaces = ["", "surface = \"lattice\"", "surface = \"exact\""].map(|key| request(key).surface);
    assert_eq!(surfaces, [SurfaceKind::Exact, SurfaceKind::Lattice, SurfaceKind::Exact]);
    let elements = ["", "elements = \"linear\""].map(|key| request(key).elements);
    assert_eq!(elements, [ElementChoice::Auto, ElementChoice::Linear]);
    assert_eq!(request("quality = \"film\"").quality, pipeline::Preset::Film, "finer lattices serve coarser requests");
    let reversed = both(&format!("{STATUE}\neffects = []"), "").recipes().unwrap()["statue"].bake("statue").unwrap().1;
    assert_eq!(reversed.tables, alone.tables);
    // γ is each object's own.
    let sized = |near: &str, far: &str| {
        both(&format!("{STATUE}\n{near}"), far).recipes().unwrap()["statue"].bake("x").unwrap().1.fragment_size_m
    };
    let [small, large] = ["fragment_size_m = 0.01", "fragment_size_m = 0.02"];
    assert_eq!((sized(small, ""), sized(small, small), sized(small, large)), (Some(0.01), Some(0.01), None));
    for (key, value) in [
        ("shape", "\"mug\""),
        ("material", "\"glass\""),
        ("elastic_spacing", "0.05"),
        ("crack_spacing", "0.03"),
        ("elements", "\"linear\""),
        ("examples", "0"),
    ] {
        let error =
            both(&format!("{STATUE}\nelastic_spacing = 0.04\nelements = \"quadratic\""), &format!("{key} = {value}"))
                .recipes()
                .unwrap_err();
        assert_eq!(error.at, format!("objects.near.{key}"), "{error}");
        assert!(error.message.contains("objects.far") && error.message.contains("`statue`"), "{error}");
    }
}

#[test]
fn an_objects_quality_is_a_preset() {
    let quality = |text: &str| object(text).unwrap().terms.quality;
    assert_eq!(quality(""), None);
    for preset in Quality::ALL {
        assert_eq!(quality(&format!("quality = \"{}\"", preset.name())), Some(preset));
    }
    check("quality = \"fine\"", "objects.vase.quality", "quality");
    check("criterion = \"griffith\"", "objects.vase.criterion", "`paper`");
}

#[test]
fn numbers_that_toml_cannot_hold_are_refused_with_key_and_range() {
    for (key, range) in [
        ("bytes_max", "a whole number from 1 to 9223372036854775807"),
        ("sites_max", "a whole number from 1 to 512"),
        ("fragments_max", "a whole number from 1 to 4294967295"),
        ("fragment_size_m", "a number of meters from 1e-9 to 1e9, without quotes or unit, as in 0.02"),
    ] {
        for value in ["9223372036854775808", "18446744073709551615", "99999999999999999999"] {
            let error = object(&format!("{key} = {value}")).unwrap_err();
            let column = key.len() + 4;
            assert_eq!(error.message, format!("line 2, column {column}: `{key}` is {value}; it must be {range}"));
        }
    }
}

#[test]
fn only_tables_of_allowed_effects_are_loaded() {
    let tables = |text: &str| object(text).unwrap().terms.tables();
    let none = Tables::NONE;
    assert_eq!(tables("effects = []"), none);
    assert_eq!(tables("effects = [\"bonds\"]\nallow = [\"elastic\"]"), Tables { elastic: true, ..none });
    assert_eq!(tables("effects = [\"interior\"]"), Tables { interior: true, ..none });
    let surface = tables("effects = [\"interior\"]\nlift = \"surface_diffusion\"");
    assert_eq!(surface, Tables { surface_diffusion: true, ..none });
    assert_eq!(ObjectPolicy::default().tables(), Tables::ALL);
    let learned = tables("effects = [\"interior\", \"examples\"]");
    assert_eq!(learned, Tables { interior: true, examples: true, ..none });
    assert_eq!(tables("effects = [\"interior\", \"examples\"]\nlift = \"euclidean\""), none);
}

#[test]
fn request_effects_stay_within_the_scene() {
    let terms = object("effects = [\"elastic\", \"bonds\"]\nallow = [\"interior\"]").unwrap().terms;
    let strike = |enable: &[Effect], disable: &[Effect]| Request {
        enable: Effects::of(enable.iter().copied()),
        disable: Effects::of(disable.iter().copied()),
        ..Request::default()
    };
    let on = |strike: &Request| terms.effects(strike).unwrap();
    assert_eq!(on(&strike(&[], &[])), Effects::of([Effect::Elastic, Effect::Bonds]));
    assert_eq!(on(&strike(&[], &[Effect::Bonds])), Effects::of([Effect::Elastic]));
    assert!(on(&strike(&[Effect::Interior], &[])).has(Effect::Interior));
    let refused = |effect: Effect| terms.effects(&strike(&[effect], &[])).unwrap_err();
    assert_eq!(refused(Effect::Debris).at, "debris");
    assert_eq!(
        refused(Effect::Debris).message,
        "the effect `debris` is not prepared: add \"debris\" to `effects` or `allow` of [objects.] in a scene, and serve it by `shatterd \
         serve --scene FILE`"
    );
    // Tables of effects are made by a bake.
    for effect in [Effect::Skin, Effect::Attributes] {
        let name = effect.name();
        assert_eq!(
            refused(effect).message,
            format!(
                "the effect `{name}` is not prepared: add \"{name}\" to `effects` or `allow` of [objects.] in a scene, bake the object \
                 anew by `shatterd bake` if its database has no such table, and serve it by `shatterd serve --scene FILE`"
            )
        );
    }
    let lift = Request { lift: Some(Lift::Interior), ..strike(&[], &[]) };
    assert_eq!(terms.effects(&lift).unwrap_err().at, "interior");
}

#[test]
fn anchors_and_weight_are_read() {
    let text = "effects = [\"elastic\", \"anchored\"]\nallow = [\"gravity\"]\n\
                anchors = [{ center = [0, 1, 0], radius_m = 0.5 }, { min = [0, 0, 0], max = [1, 1, 1] }]";
    let terms = object(text).unwrap().terms;
    let points = [[0.0, 1.5, 0.0], [0.9, 0.9, 0.0], [1.1, 0.0, 0.0]].map(Point3::from);
    assert_eq!(points.map(|point| terms.anchors.contains(&point)), [true, true, false]);
    assert_eq!(terms.anchors.gravity_m_s2, Some(Vector3::new(0.0, -9.81, 0.0)));
    let moon = object(&format!("{text}\ngravity_m_s2 = [0, -1.6, 0]")).unwrap().terms;
    assert_eq!(moon.anchors.gravity_m_s2, Some(Vector3::new(0.0, -1.6, 0.0)));
    let enable = |effect: Effect| Request { enable: Effects::of([effect]), ..Request::default() };
    assert!(terms.effects(&enable(Effect::Gravity)).unwrap().has(Effect::Gravity));
    for effect in [Effect::Anchored, Effect::Gravity] {
        let error = ObjectPolicy::default().effects(&enable(effect)).unwrap_err();
        assert_eq!(error.at, effect.name());
        assert!(error.message.contains("`anchors`"), "{error}");
    }
    assert!(terms.rich().on.has(Effect::Gravity) && !ObjectPolicy::default().rich().on.has(Effect::Anchored));
}

#[test]
fn a_fragment_size_gives_gamma() {
    let glass = object("material = \"glass\"\nfragment_size_m = 0.1").unwrap();
    let (_, material) = glass.material.unwrap();
    let own = glass.terms.gamma(&material).unwrap();
    let twice = object("fragment_size_m = 0.2").unwrap().terms.gamma(&material).unwrap();
    assert!((twice / own / 32.0 - 1.0).abs() < 1e-12, "the fifth power");
    assert_eq!(object("fragment_size_m = 0.1\ngamma_j_m2 = 7.0").unwrap().terms.gamma(&material), Some(7.0));
    assert_eq!(object("").unwrap().terms.gamma(&material), None);
}

#[test]
fn a_scene_chooses_the_criterion() {
    let criterion = |text: &str| object(text).unwrap().terms.criterion;
    assert_eq!(criterion(""), RequestedCriterion::Paper);
    for own in RequestedCriterion::ALL {
        assert_eq!(criterion(&format!("criterion = \"{}\"", own.name())), own);
    }
}

#[test]
fn a_scene_scales_the_strength() {
    let scale = |text: &str| object(text).map(|own| own.terms.strength_scale);
    assert_eq!([scale(""), scale("strength_scale = 2.5")], [Ok(1.0), Ok(2.5)]);
    let (_, material) = object("material = \"glass\"").unwrap().material.unwrap();
    let gamma = |text: &str| object(text).unwrap().terms.gamma(&material);
    assert_eq!([gamma("gamma_j_m2 = 7.0\nstrength_scale = 2.0"), gamma("strength_scale = 2.0")], [Some(28.0), None]);
    check("strength_scale = 0.0", "objects.vase.strength_scale", "from 0.001 to 1000");
    check("strength_scale = nan", "objects.vase.strength_scale", "from 0.001 to 1000");
}

#[test]
fn artist_controls_are_validated_by_name() {
    let warped = |text: &str| format!("effects = [\"warp\"]\nwarp = {{ {text} }}");
    check(&warped("grian = 1"), "objects.vase.warp.grian", "`grain`");
    check(
        &warped("grain = { axis = [0, 0, 0], ratio = 2.0 }"),
        "objects.vase.warp.grain.axis",
        "is [0.0, 0.0, 0.0]; it must be",
    );
    check(
        &warped("grain = { axis = [0, 1, 0], ratio = 99.0 }"),
        "objects.vase.warp.grain.ratio",
        "is 99; it must be a number from 0.03125 to 32",
    );
    check(&warped("waves = { length_m = -1.0, slope = 0.3 }"), "objects.vase.warp.waves.length_m", "is -1; it must be");
    check(
        &warped("protect = [{ center = [0, 0, 0], radius_m = 0.0 }]"),
        "objects.vase.warp.protect[0].radius_m",
        "is 0; it must be a number above 0",
    );
    check(&warped("sites = [[0.0, 0.0, inf]]"), "objects.vase.warp.sites[0]", "finite");
    check(&warped("sites = [[0, 0, 0], [0, 0]]"), "objects.vase.warp.sites[1]", "is a list of 2 values; it must be");
    check(&warped("protect = [1]"), "objects.vase.warp.protect[0]", "is 1; it must be a table");
    check("anchors = [\"x\"]", "objects.vase.anchors[0]", "it must be a table");
    check("effects = [\"elastic\", 1]", "objects.vase.effects[1]", "is 1; it must be");
    let points = |count: usize| warped(&format!("sites = [{}]", "[0.0, 0.0, 0.0], ".repeat(count)));
    check(&points(513), "objects.vase.warp.sites", "has 513 points; give at most 512");
    assert!(object(&points(512)).is_ok());
    check(
        &warped("paint = { file = \"no.ply\", attribute = \"red\", least = 1.0, most = 4.0 }"),
        "objects.vase.warp.paint",
        "no.ply",
    );
    check(
        &warped("paint = { file = \"no.ply\", attribute = \"red\", least = 0.0, most = 4.0 }"),
        "objects.vase.warp.paint.least",
        "is 0; it must be a number from 0.001 to 1000",
    );
    let huge = warped("grain = { axis = [1e300, 1e300, 0], ratio = 2.0 }");
    let axis = object(&huge).unwrap().terms.controls.grain.unwrap().axis;
    assert!((axis - Vector3::new(0.5f64.sqrt(), 0.5f64.sqrt(), 0.0)).norm() < 1e-15);
    check(&warped(""), "objects.vase.warp", "go together");
    check("effects = []\nwarp = { sites = [[0.0, 0.0, 0.0]] }", "objects.vase.warp", "go together");
    let whole = object(&warped("waves = { length_m = 0.1, slope = 0.5 }, sites = [[1.0, 2.0, 3.0]]")).unwrap();
    assert!(!whole.terms.controls.is_silent() && whole.terms.on.has(Effect::Warp));
}
