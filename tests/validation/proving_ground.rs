//! The proving ground: rooms by kind and seed, and a small campaign in one of them.

use luxmc::scene::{ReceiverLayout, Scene};
use luxmc::validation::proving_ground::rooms::{KINDS, kind_of};
use luxmc::validation::proving_ground::{ProofSettings, ReferenceSettings, proof_csv, prove, scene_of};

use crate::cli_support::*;

/// Number of rooms of each kind that are read.
const SEEDS: u64 = 3;

fn scene(kind: &str, seed: u64) -> Scene {
    let room = kind_of(kind).unwrap().room(seed);
    scene_of(&room).unwrap_or_else(|error| panic!("{kind}, seed {seed}: {error}"))
}

#[test]
fn every_room_reads_and_has_light_and_receivers_of_every_sort() {
    assert!(KINDS.len() >= 15);
    for kind in KINDS {
        for seed in 0..SEEDS {
            let scene = scene(kind.name, seed);
            let name = format!("{}, seed {seed}", kind.name);
            assert!(scene.luminous_flux_lm() > 0.0, "{name}");
            let points: usize = scene.receivers.iter().map(|set| set.points.len()).sum();
            assert!((600..=1500).contains(&points), "{name}: {points} receivers");
            let is_grid = |layout: &ReceiverLayout| matches!(layout, ReceiverLayout::Grid { .. });
            assert!(scene.receivers.iter().any(|set| is_grid(&set.layout)), "{name}");
            for set in ["work plane", "surfaces", "corners"] {
                assert!(scene.receivers.iter().any(|known| known.name == set), "{name}: {set}");
            }
            let weights = scene.receivers.iter().flat_map(|set| &set.points).map(|point| point.weight);
            assert!(weights.clone().all(|weight| weight > 0.0 && weight.is_finite()), "{name}");
            // Receivers on surfaces are in the air. Hardly any is inside an object.
            let loose = scene.receivers.iter().filter(|set| !is_grid(&set.layout)).flat_map(|set| &set.points);
            let inside = loose.filter(|point| point.inside).count();
            assert!(inside <= 5, "{name}: {inside} inside");
        }
    }
}

#[test]
fn a_room_follows_from_kind_and_seed() {
    for kind in KINDS {
        let room = kind.room(1);
        assert_eq!(room, kind.room(1));
        let other = kind.room(2);
        assert_ne!(room.scene, other.scene, "{}", kind.name);
        assert_ne!(room.files, other.files, "{}", kind.name);
    }
    // Sizes and reflectances really differ, not only the positions of receivers.
    let sizes = |seed| scene("furnished", seed).triangles.len();
    assert!((0..4).any(|seed| sizes(seed) != sizes(seed + 1)));
}

#[test]
fn rooms_are_written_by_their_kind_and_unknown_kinds_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("attic");
    let make = |more: &[&str]| run(&[&["new", "room"][..], more].concat());
    let made = make(&["--kind", "attic", "--seed", "3", "--out", text(&out)]);
    assert_eq!(code(&made), 0, "{}", errors(&made));
    let room = kind_of("attic").unwrap().room(3);
    assert_eq!(std::fs::read_to_string(out.join("room.json")).unwrap(), room.scene);
    assert_eq!(listing(&out).len(), 1 + room.files.len());
    assert_eq!(code(&run(&["inspect", text(&out.join("room.json"))])), 0);

    let list = make(&["--kind", "list"]);
    assert!(KINDS.iter().all(|kind| results(&list).contains(kind.name)), "{}", results(&list));
    for (wrong, says) in [
        (&["--kind", "atic", "--out", text(&out)][..], "door-ajar"),
        (&["--out", text(&out)], "a room needs a kind"),
        (&["--kind", "attic", "--out", text(&out)], "exists already"),
    ] {
        let refused = make(wrong);
        assert_eq!(code(&refused), 2, "{wrong:?}");
        assert!(errors(&refused).contains(says), "{wrong:?}: {}", errors(&refused));
    }
    let office = run(&["new", "office", "--seed", "1", "--out", text(&folder.path().join("office"))]);
    assert_eq!(code(&office), 2);
    assert!(errors(&office).contains("to rooms only"), "{}", errors(&office));
}

#[test]
fn options_of_the_proving_ground_belong_to_it() {
    let folder = tempfile::tempdir().unwrap();
    let out = text(folder.path());
    for (wrong, says) in [
        (&["cube", "--rooms", "2"][..], "--rooms"),
        (&["cube", "--first-room", "20"], "--first-room"),
        (&["proving-ground", "cube"], "its own rooms"),
        (&["proving-ground", "--collision-only"], "its own rooms"),
        (&["proving-ground", "--kinds", "white,blue"], "blue"),
        (&["proving-ground", "--rival", "/nowhere/peer"], "no such program"),
    ] {
        let refused = run(&[&["validate"], wrong, &["--out", out]].concat());
        assert_eq!(code(&refused), 2, "{wrong:?}: {}", errors(&refused));
        assert!(errors(&refused).contains(says), "{wrong:?}: {}", errors(&refused));
    }
    assert!(listing(folder.path()).is_empty());
}

/// One room with a coarse target: every row exists, and the reference is made once and used again.
#[test]
fn a_small_campaign_runs_and_keeps_its_reference() {
    let folder = tempfile::tempdir().unwrap();
    let settings = ProofSettings {
        kinds: vec![kind_of("dark").unwrap()],
        rooms: 1..2,
        seeds: 2,
        targets: vec![0.2, 0.1],
        reference: ReferenceSettings { target_error: 0.05, limit_s: 10.0 },
        references: folder.path().join("references"),
        rival: None,
        patience_s: 20.0,
        threads: 1,
    };
    let told = std::sync::Mutex::new(Vec::new());
    let tell = |line: &str| told.lock().unwrap().push(line.to_owned());
    let proof = prove(&settings, &tell).unwrap();
    let made = |told: &[String]| told.iter().filter(|line| line.ends_with("reference")).count();
    assert_eq!(made(&told.lock().unwrap()), 1);

    let room = &proof.rooms[0];
    assert_eq!(proof.rooms.len(), 1);
    assert_eq!((room.kind, room.seed, room.runs.len(), room.walks.len()), ("dark", 1, 4, 2));
    let maps = || room.runs.iter().flat_map(|run| &run.maps);
    assert!(maps().all(|map| map.said_met && map.judgement.bars > 20), "{:?}", room.runs);
    // Limits: twice the coarser target, and the reference's own error. No sound run exceeds them.
    assert!(maps().all(|map| map.judgement.true_error < 0.4 && map.judgement.reference_error < 0.06));
    // Half the target error takes four times the work by walks.
    assert!((room.walks[1].rays / room.walks[0].rays - 4.0).abs() < 1e-9);

    let csv = proof_csv(&proof, &settings);
    assert_eq!(csv.lines().count(), 1 + maps().count());
    assert!(csv.lines().all(|line| !line.contains(",,") && !line.contains("NaN")));

    prove(&settings, &tell).unwrap();
    assert_eq!(made(&told.lock().unwrap()), 1, "the reference serves again");
}
