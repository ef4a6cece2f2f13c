//! Walks and packets that land again find the same light, each path once.

use std::path::Path;

use super::walk_indirect_lx;
use crate::check::scene_from_json;
use crate::estimators::cache::{Cache, CacheAnswer, Met, WalkEvent};
use crate::estimators::receiver::Receiver;
use crate::estimators::walks_in_a_box::EmptyBox;
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::Stream;
use crate::transport::{LaterLandings, World};

const EDGE_M: f64 = 3.0;
const CUBE: EmptyBox = EmptyBox([EDGE_M; 3]);
const REFLECTANCE: f64 = 0.6;
const LM: f64 = 1000.0;
const WALKS: u64 = 60_000;

/// Sums up what later landings bring.
#[derive(Default)]
struct FoundLater {
    lx: f64,
}

impl Cache for FoundLater {
    fn look_up(&mut self, _: &Met, _: &mut Cut, _: &mut Stream) -> (CacheAnswer, u64) {
        (CacheAnswer::Nothing, 0)
    }

    fn observe(&mut self, event: &WalkEvent) {
        if let WalkEvent::Connected { weight, found } = event {
            self.lx += weight * found.later_lx;
        }
    }
}

/// A cube of one reflectance with two lamps close to two of its faces and to their edge, and perhaps bodies about one of them.
fn world(bodies: &str) -> World {
    let text = format!(
        r#"{{ "version": 1, "materials": {{ "m": {{ "type": "diffuse", "reflectance": {REFLECTANCE} }},
            "pane": {{ "type": "glass", "refractive_index": 1.5, "internal_transmittance": 0.9 }},
            "sheet": {{ "type": "translucent", "diffuse_reflectance": 0.4, "diffuse_transmittance": 0.3 }} }},
        "geometry": [ {{ "name": "r", "type": "box", "min": [0,0,0], "max": [{EDGE_M},{EDGE_M},{EDGE_M}], "facing": "inward",
            "material": "m" }} {bodies} ],
        "luminaires": [ {{ "name": "a", "type": "point", "position": [0.1,0.15,1.5], "luminous_flux_lm": {} }},
            {{ "name": "b", "type": "point", "position": [1.8,0.1,0.1], "luminous_flux_lm": {} }} ] }}"#,
        0.6 * LM,
        0.4 * LM
    );
    World::new(&scene_from_json(&text, None, Path::new(".")).expect("a valid scene"))
}

/// Mean of walks from anywhere in lx, its standard error, and the part that later landings bring.
fn mean_lx(world: &World, walks: u64, seed: u64) -> [f64; 3] {
    let mut second = FoundLater::default();
    let walk = |receiver: &Receiver, cut: &mut Cut, stream: &mut Stream| {
        walk_indirect_lx(world, receiver, &mut second, cut, stream)
    };
    let [mean_lx, variance, _] = CUBE.walks(world, (walks, seed), walk);
    [mean_lx, (variance / walks as f64).sqrt(), second.lx / walks as f64]
}

/// The mean over all faces of a closed room of one reflectance is Φ ρ/(A (1 − ρ)), also where packets land again, at any probability of
/// a connection. 60,000 walks, seed 5, α = 1e-5 (4.4 σ). Without what later landings bring, or with twice of it, the mean is rejected.
#[test]
fn later_landings_move_no_mean() {
    let mut world = world("");
    assert!(world.near_luminaires.as_ref().is_some_and(|lights| lights.later_landings() == LaterLandings::All));
    let exact_lx = LM * REFLECTANCE / (CUBE.area_m2() * (1.0 - REFLECTANCE));
    for connection_chance in [1.0, 0.25] {
        world.roulette.connection_chance = connection_chance;
        let [mean_lx, error_lx, later_lx] = mean_lx(&world, WALKS, 5);
        let off = |lx: f64| ((lx - exact_lx) / error_lx).abs();
        assert!(off(mean_lx) < 4.4, "{mean_lx} ± {error_lx} for {exact_lx} lx");
        assert!(off(mean_lx - later_lx).min(off(mean_lx + later_lx)) > 4.4, "{later_lx} of {mean_lx} ± {error_lx} lx");
    }
}

/// In a shade of sheets and behind a pane, walks with and without connections to packets have the same mean: 120,000 and 480,000 walks, seeds
/// 6 and 7, α = 1e-5. A mean without what later landings bring is rejected, and so is one with twice of it.
#[test]
fn later_landings_in_a_shade_bring_what_walks_find() {
    let sheet = |name: &str, origin: [f64; 3], u: [f64; 3]| {
        format!(
            r#", {{ "name": "{name}", "type": "rectangle", "origin": {origin:?}, "u": {u:?}, "v": [0,0,0.3], "material": "sheet" }}"#
        )
    };
    let pane = r#", { "name": "pane", "type": "rectangle", "origin": [1.4,0.05,0.25], "u": [0.8,0,0], "v": [0,0.4,0], "material": "pane" }"#;
    let bodies = [
        sheet("a", [0.05, 0.1, 1.4], [0.25, 0.0, 0.0]),
        sheet("b", [0.05, 0.3, 1.4], [0.25, 0.0, 0.0]),
        sheet("c", [0.05, 0.1, 1.4], [0.0, 0.2, 0.0]),
        sheet("d", [0.3, 0.1, 1.4], [0.0, 0.2, 0.0]),
        pane.to_owned(),
    ];
    let mut world = world(&bodies.concat());
    assert!(world.near_luminaires.as_ref().is_some_and(|lights| lights.later_landings() == LaterLandings::All));
    let [lx, error_lx, later_lx] = mean_lx(&world, 2 * WALKS, 6);
    world.near_luminaires = None;
    let [plain_lx, plain_error_lx, nothing_lx] = mean_lx(&world, 8 * WALKS, 7);
    let sigma_lx = error_lx.hypot(plain_error_lx);
    let off = |lx: f64| ((lx - plain_lx) / sigma_lx).abs();
    assert!(nothing_lx == 0.0 && off(lx) < 4.4, "{lx} ± {error_lx}, {plain_lx} ± {plain_error_lx} lx");
    assert!(off(lx - later_lx).min(off(lx + later_lx)) > 4.4, "{later_lx} of {lx} ± {sigma_lx} lx");
}
