//! Shadow methods of games: equal to light samples where they are valid, and wrong by a known amount elsewhere.

use std::sync::LazyLock;

use glam::DVec3;
use luxmc::validation::studies::shadow_rivals::depth_map::DepthMap;
use luxmc::validation::studies::shadow_rivals::wedges::Wedges;
use luxmc::validation::studies::study_scene::StudyScene;

/// A ball of 0.5 m at 10 m above the ground, with boards or boxes between them.
const LAMP_M: DVec3 = DVec3::new(20.0, 20.0, 10.0);
const RADIUS_M: f64 = 0.5;
const SIZE_M: [f64; 2] = [40.0, 40.0];
const GROUND: &str = r#"{ "name": "ground", "type": "box", "min": [0,0,-1], "max": [40,40,0], "material": "black" }"#;
const BOX: &str = r#"{ "name": "box", "type": "box", "min": [18,17,2], "max": [23,22,4], "material": "black" }"#;
const SECOND: &str =
    r#"{ "name": "second", "type": "box", "min": [20.5,18,5], "max": [22.25,24,5.5], "material": "black" }"#;

fn study(geometry: &str, ball: bool) -> StudyScene {
    let lamp = if ball {
        format!(r#""type": "sphere", "center": [20,20,10], "radius": {RADIUS_M}, "luminous_flux_lm": 1000"#)
    } else {
        r#""type": "point", "position": [20,20,10], "luminous_flux_lm": 1000"#.to_owned()
    };
    StudyScene::black(&format!("{GROUND}, {geometry}"), &format!(r#"{{ "name": "lamp", {lamp} }}"#)).expect("a study")
}

/// Points along a line across the shadow of the box's edge at x = 23, 2 m to 4 m high.
fn places_m(y_m: f64) -> Vec<DVec3> {
    (0..121).map(|i| DVec3::new(23.0 + 0.025 * f64::from(i), y_m, 0.0)).collect()
}

/// Visible share of the ball at each point, by 4096 light samples.
fn exact(geometry: &str, places_m: &[DVec3]) -> Vec<f64> {
    let study = study(geometry, true);
    let lit = study.by_rays(places_m, 4096, f64::INFINITY);
    let lamp = &study.world.emitters.list()[0];
    places_m.iter().zip(&lit.lx).map(|(place_m, lx)| lx / lamp.unshadowed_lx(*place_m, DVec3::Z)).collect()
}

fn by_wedges(study: &StudyScene, radius_m: f64, places_m: &[DVec3]) -> Vec<[f64; 2]> {
    let wedges = Wedges::of(study, LAMP_M, radius_m, SIZE_M);
    assert!(wedges.edge_count() > 3);
    places_m.iter().map(|place_m| wedges.seen_from(*place_m)).map(|seen| [seen.wedges, seen.outward]).collect()
}

fn worst(found: &[f64], exact: &[f64]) -> f64 {
    found.iter().zip(exact).map(|(found, exact)| (found - exact).abs()).fold(0.0, f64::max)
}

static OF_BOX: LazyLock<StudyScene> = LazyLock::new(|| study(BOX, false));

/// Behind one box whose silhouette is the same for the whole ball, wedges are right except for the change of the cosine over the ball, some
/// 1 % of the lamp. Wedges of a ball smaller by a fifth (the planted fault) are not.
#[test]
fn wedges_of_one_box_are_those_of_rays() {
    let places_m = places_m(19.3);
    let exact = exact(BOX, &places_m);
    assert!(
        exact[0] == 0.0
            && (exact[120] - 1.0).abs() < 1e-9
            && exact.iter().filter(|share| (0.05..0.95).contains(*share)).count() > 10
    );
    let shares =
        |radius_m: f64| by_wedges(&OF_BOX, radius_m, &places_m).iter().map(|seen| seen[0]).collect::<Vec<f64>>();
    assert!(worst(&shares(RADIUS_M), &exact) < 0.02, "{}", worst(&shares(RADIUS_M), &exact));
    assert!(worst(&shares(0.8 * RADIUS_M), &exact) > 0.02, "the planted fault passed");
}

/// Where two boxes hide the same part of the ball, wedges count it twice. The result is darker than by light samples, by up to half of the
/// lamp.
#[test]
fn wedges_of_two_boxes_take_what_both_hide_twice() {
    let places_m = places_m(19.3);
    let both = format!("{BOX}, {SECOND}");
    let exact = exact(&both, &places_m);
    let shares = by_wedges(&study(&both, false), RADIUS_M, &places_m);
    let off: Vec<f64> = shares.iter().zip(&exact).map(|(seen, exact)| seen[0] - exact).collect();
    let darkest = off.iter().copied().fold(0.0, f64::min);
    assert!(off.iter().all(|off| *off < 0.02) && (-0.6..-0.3).contains(&darkest), "{off:?}");
}

/// Shadows that grow outward are black where the centre of the lamp is hidden, and light begins only beyond. They are always darker than
/// the truth.
#[test]
fn outward_shadows_are_too_dark() {
    let places_m = places_m(19.3);
    let exact = exact(BOX, &places_m);
    let outward: Vec<f64> = by_wedges(&OF_BOX, RADIUS_M, &places_m).iter().map(|seen| seen[1]).collect();
    assert!(outward.iter().zip(&exact).all(|(found, exact)| *found < exact + 0.02));
    let half = exact.iter().position(|share| *share >= 0.5).expect("a penumbra");
    assert!(outward[half - 2] == 0.0 && outward[120] == 1.0 && worst(&outward, &exact) > 0.3, "{outward:?}");
}

/// The edge of a shadow map is a ramp as wide as its filter. That of a single sample is twice as wide as its reach. Both pass through ½ at
/// the hard edge within a texel. A filter of another width (the planted fault) is detected.
#[test]
fn ramps_of_shadow_maps_are_as_wide_as_they_are_made() {
    let map = DepthMap::of(&OF_BOX, LAMP_M, SIZE_M, [800, 800]);
    assert_eq!(map.rays, 640_000);
    // The upper edge, 4 m high, hides most: x = 20 + 3 · 10/6.
    let hard_m = 25.0;
    let at = |off_m: f64| DVec3::new(hard_m + off_m, 19.3, 0.0);
    let width_m = |share: &dyn Fn(DVec3) -> f64| {
        let inside =
            (0..400).map(|i| 0.01 * f64::from(i) - 2.0).filter(|off_m| (0.02..0.98).contains(&share(at(*off_m))));
        inside.count() as f64 * 0.01
    };
    let filtered = |edge: i64| width_m(&|place_m| map.share_of_lit(place_m, edge));
    assert!((filtered(21) - 20.0 * 0.05).abs() < 0.06, "{}", filtered(21));
    assert!((filtered(25) - 20.0 * 0.05).abs() > 0.06, "the planted fault passed");
    let single = |off_m: f64| map.single_sample(at(off_m), 0.8);
    for off_m in [-0.6, -0.3, 0.0, 0.3, 0.6] {
        assert!((single(off_m) - 0.5 * (1.0 + off_m / 0.8)).abs() < 0.05, "{off_m}: {}", single(off_m));
    }
    assert_eq!([single(-1.0), single(1.0)], [0.0, 1.0]);
}
