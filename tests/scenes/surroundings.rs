//! The areas that EN 12464-1 requires around a task area, and those of a whole room.

use luxmc::scene::{Area, Measure, Quantity, ReceiverSet, Scene};

use crate::common::scene_of;

/// A floor of 8 m × 6 m with a task area of 2 m × 1 m. For the L shape a notch of 4 m × 3 m is left out.
fn about_a_desk(is_whole: bool, keys: &str) -> Scene {
    let faces = if is_whole { "[0,1,4,7],[7,4,5,6],[4,1,2,3],[4,3,8,5]" } else { "[0,1,4,7],[7,4,5,6],[4,1,2,3]" };
    scene_of(&format!(
        r#"{{ "version": 1, "materials": {{ "m": {{ "type": "diffuse", "reflectance": 0.5 }} }},
          "geometry": [ {{ "name": "floor", "type": "mesh", "material": "m", "two_sided": true,
            "vertices": [[0,0,0],[4,0,0],[8,0,0],[8,3,0],[4,3,0],[4,6,0],[0,6,0],[0,3,0],[8,6,0]], "faces": [{faces}] }} ],
          "luminaires": [ {{ "name": "lamp", "type": "point", "position": [4,2,2.5], "luminous_flux_lm": 1000 }} ],
          "receivers": [ {{ "name": "desk", "type": "grid", "origin": [3.25,2.25,0.8], "u": [1.5,0,0], "v": [0,0.5,0], "columns": 4, "rows": 2,
            {keys} }} ] }}"#
    ))
}

fn area_m2(set: &ReceiverSet) -> f64 {
    set.points.iter().map(|point| point.weight).sum()
}

/// Requirements of a set: area, measure and limit.
fn asked(set: &ReceiverSet) -> Vec<(Area, Measure, f64)> {
    set.requirements.iter().map(|required| (required.area, required.measure, required.limit)).collect()
}

/// Band and background cover the floor around the task as far as they reach, and nothing else, for any shape of the floor. Their points are
/// above it, at the height of the task.
#[test]
fn band_and_background_lie_on_the_floor() {
    let keys = r#""requirements": { "en_12464_1": "34.2" }, "surroundings": { "within": "floor" }"#;
    // 3 m × 2 m minus the task, and 8 m × 6 m minus that. For the L, also without the part in the notch.
    for (is_whole, band_m2, background_m2) in [(true, 4.0, 42.0), (false, 3.25, 30.75)] {
        let scene = about_a_desk(is_whole, keys);
        let [_, band, background] = &scene.receivers[..] else { panic!("{}", scene.receivers.len()) };
        assert_eq!((band.name.as_str(), background.name.as_str()), ("desk surroundings", "desk background"));
        assert!((area_m2(band) - band_m2).abs() < 1e-9, "{}", area_m2(band));
        assert!((area_m2(background) - background_m2).abs() < 1e-9, "{}", area_m2(background));
        for (set, [low, high]) in [(band, [2.5, 5.5]), (background, [0.0, 8.0])] {
            for point in &set.points {
                let [x, y, z] = point.position_m.to_array();
                assert!((x - 4.0).abs() > 1.0 || (y - 2.5).abs() > 0.5, "not on the task: {point:?}");
                assert!((low..=high).contains(&x) && (is_whole || x < 4.0 || y < 3.0), "{point:?}");
                assert!((z - 0.8).abs() < 1e-12 && point.normal.z > 0.999, "{point:?}");
            }
        }
        let about = |area: Area, average_lx: f64, uniformity: f64| {
            vec![(area, Measure::AverageLx, average_lx), (area, Measure::UniformityU0, uniformity)]
        };
        assert_eq!(asked(band), about(Area::Surroundings, 300.0, 0.4));
        assert_eq!(asked(background), about(Area::Background, 100.0, 0.1));
        assert!(band.requirements.iter().all(|required| required.entry.is_some_and(|entry| entry.reference == "34.2")));
    }
}

/// Given widths, 0 for none, the modified average, and a number instead of an entry.
#[test]
fn surroundings_follow_the_average_of_the_task() {
    let keys = r#""requirements": { "en_12464_1": "34.2", "modified": true }, "surroundings": { "within": "floor", "band": 1, "background": 0 }"#;
    let scene = about_a_desk(true, keys);
    let [task, band] = &scene.receivers[..] else { panic!("{}", scene.receivers.len()) };
    assert_eq!(asked(task)[0], (Area::Task, Measure::AverageLx, 1000.0));
    assert_eq!(asked(band)[0], (Area::Surroundings, Measure::AverageLx, 500.0));
    assert!((area_m2(band) - (4.0 * 3.0 - 2.0)).abs() < 1e-9, "{}", area_m2(band));
    let keys = r#""requirements": { "average_lx": 300 }, "surroundings": { "within": "floor", "band": 0 }"#;
    let scene = about_a_desk(true, keys);
    let [_, background] = &scene.receivers[..] else { panic!("{}", scene.receivers.len()) };
    assert!((asked(background)[0].2 - 200.0 / 3.0).abs() < 1e-12 && background.requirements[0].entry.is_none());
}

/// An entry's numbers for the areas of a room and for cylinders.
#[test]
fn an_entry_is_asked_of_walls_ceilings_and_cylinders() {
    let of = |keys: &str| asked(&about_a_desk(true, keys).receivers[0]);
    let walls = of(r#""requirements": { "en_12464_1": "34.2", "area": "walls" }"#);
    assert_eq!(walls, [(Area::Walls, Measure::AverageLx, 150.0), (Area::Walls, Measure::UniformityU0, 0.1)]);
    let ceiling = of(r#""requirements": { "en_12464_1": "5.1.1", "area": "ceiling" }"#);
    assert_eq!(ceiling, [(Area::Ceiling, Measure::AverageLx, 50.0), (Area::Ceiling, Measure::UniformityU0, 0.1)]);
    let heads = of(r#""quantity": "cylindrical", "requirements": { "en_12464_1": "5.36.1" }"#);
    assert_eq!(heads, [(Area::Cylinders, Measure::AverageLx, 150.0), (Area::Cylinders, Measure::UniformityU0, 0.1)]);
}

/// A receiver of a whole room becomes its task area, cylinders, walls, ceiling and observers, each with the requirements of the entry.
#[test]
fn a_room_is_asked_for_all_that_an_entry_asks() {
    let scene = scene_of(
        r#"{ "version": 1, "materials": { "m": { "type": "diffuse", "reflectance": 0.5 } },
          "geometry": [ { "name": "box", "type": "box", "min": [0,0,0], "max": [6,5,3], "facing": "inward", "material": "m" } ],
          "luminaires": [ { "name": "lamp", "type": "point", "position": [4,2,2.5], "luminous_flux_lm": 1000 } ],
          "receivers": [ { "name": "office", "type": "room", "surface": "box", "requirements": { "en_12464_1": "34.2" } } ] }"#,
    );
    let names: Vec<&str> = scene.receivers.iter().map(|set| set.name.as_str()).collect();
    assert_eq!(names, ["office task", "office cylindrical", "office walls", "office ceiling", "office observers"]);
    let [task, heads, walls, ceiling, observers] = &scene.receivers[..] else { panic!("five sets") };
    // 5 m × 4 m within the margin; 3 m high walls; the whole ceiling.
    for (set, m2) in [(task, 20.0), (heads, 20.0), (walls, 66.0), (ceiling, 30.0)] {
        assert!((area_m2(set) - m2).abs() < 1e-9, "{}: {}", set.name, area_m2(set));
    }
    assert!(task.points.iter().all(|point| (point.position_m.z - 0.8).abs() < 1e-12 && point.normal.z > 0.999));
    assert!(walls.points.iter().all(|point| point.normal.z.abs() < 1e-12));
    assert!(ceiling.points.iter().all(|point| point.normal.z < -0.999));
    assert_eq!(heads.quantity, Quantity::Cylindrical);
    assert!(observers.observers.len() % 8 == 0 && observers.observers.iter().all(|eye| eye.eye_m.z == 1.2));
    let limits: Vec<f64> = scene.receivers.iter().flat_map(asked).map(|(_, _, limit)| limit).collect();
    assert_eq!(limits, [500.0, 0.6, 150.0, 0.1, 150.0, 0.1, 100.0, 0.1, 19.0]);
}
