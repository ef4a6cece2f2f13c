//! The most common first mistake: a room given as a box or a sphere without `"facing": "inward"`, with everything lit inside it.

use super::shells::Shell;
use crate::scene::Node;
use crate::scene::SceneError;
use crate::scene::{Emission, Scene};

/// A point this near to a solid's bounds, as a fraction of their size, counts as inside, because luminaires are put into the ceiling's
/// plane.
const ON_BOUNDS: f64 = 1e-6;

/// Refuses a scene that lies wholly inside of one outward-facing box or sphere, unless the file requests that explicitly.
pub(super) fn refuse_rooms_outward(geometry: &Node, scene: &Scene, shells: &[Shell]) -> Result<(), SceneError> {
    for node in geometry.items("a list of surfaces")? {
        let fields = node.fields("a surface")?;
        let is_solid =
            fields.get("type").is_some_and(|node| node.text().is_ok_and(|text| ["box", "sphere"].contains(&text)));
        let says_more = ["facing", "two_sided", "transform"].iter().any(|key| fields.get(key).is_some());
        if !is_solid || says_more {
            continue;
        }
        let name = fields.need_as("name", "\"room\"")?.text()?;
        let is_it = |shell: &&Shell| {
            shell.closed && shell.volume_m3 > 0.0 && scene.surface_of(shell.triangles[0]).geometry == name
        };
        if shells.iter().find(is_it).is_some_and(|shell| holds_all(scene, shell, name)) {
            let lit = if scene.receivers.is_empty() { "all luminaires" } else { "all luminaires and receivers" };
            return Err(node.refuse_as(
                "a room whose faces look outward",
                format!("{lit} lie inside of {name:?} or in its planes, on the unlit backs of its surfaces"),
                "\"facing\": \"inward\" for a room".to_owned(),
                "add \"facing\": \"inward\" to it; if a solid that encloses all light is meant, write \"facing\": \"outward\"",
            ));
        }
    }
    Ok(())
}

/// Whether all surfaces, luminaires and points lie inside a solid that emits no light itself.
fn holds_all(scene: &Scene, shell: &Shell, name: &str) -> bool {
    let [low_m, high_m] = shell.bounds_m();
    let slack_m = ON_BOUNDS * (high_m - low_m).max_element();
    let holds = |point_m: glam::DVec3| point_m.cmpge(low_m - slack_m).all() && point_m.cmple(high_m + slack_m).all();
    let is_lit_inside = |emission: &Emission| match emission {
        Emission::Area { surfaces, .. } => {
            surfaces.iter().all(|surface| scene.surfaces[*surface as usize].geometry != name)
        }
        other => other.place_m().is_some_and(holds),
    };
    !scene.luminaires.is_empty()
        && scene.luminaires.iter().all(|luminaire| is_lit_inside(&luminaire.emission))
        && scene.receivers.iter().flat_map(|set| set.placed_points()).all(|point| holds(point.position_m))
        && scene.vertices_m.iter().all(|vertex_m| holds(*vertex_m))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::check::scene_from_json;

    /// Reads a scene with these geometries, a luminaire, and receivers at a height in m.
    fn read(geometry: &str, luminaire: &str, receiver_m: f64) -> Result<(), String> {
        let text = format!(
            r#"{{ "version": 1, "materials": {{ "m": {{ "type": "diffuse", "reflectance": 0.5 }} }}, "geometry": [ {geometry} ],
            "luminaires": [ {{ "name": "lamp", {luminaire} }} ],
            "receivers": [ {{ "name": "point", "type": "grid", "origin": [1,1,{receiver_m}], "u": [1,0,0], "v": [0,1,0], "columns": 2, "rows": 2 }} ] }}"#
        );
        scene_from_json(&text, None, Path::new(".")).map(|_| ()).map_err(|error| error.to_string())
    }

    const ROOM: &str = r#"{ "name": "room", "type": "box", "min": [0,0,0], "max": [4,4,3], "material": "m" }"#;

    fn lamp(height_m: f64) -> String {
        format!(r#""type": "point", "position": [2,2,{height_m}], "luminous_flux_lm": 1000"#)
    }

    #[test]
    fn rooms_without_facing_are_refused_with_the_mend() {
        let desk = r#", { "name": "desk", "type": "box", "min": [1,1,0], "max": [2,2,0.7], "material": "m" }"#;
        for (geometry, height_m) in [(ROOM.to_owned(), 2.5), (ROOM.to_owned(), 3.0), (format!("{ROOM}{desk}"), 2.0)] {
            let error = read(&geometry, &lamp(height_m), 1.0).expect_err("a room inside out");
            assert!(error.contains("faces look outward") && error.contains("add \"facing\": \"inward\""), "{error}");
            assert!(error.contains("geometry[0]"), "{error}");
        }
    }

    #[test]
    fn solids_that_are_meant_are_read() {
        let meant = ROOM.replace("\"type\"", "\"facing\": \"outward\", \"type\"");
        let inward = ROOM.replace("\"type\"", "\"facing\": \"inward\", \"type\"");
        let floor = format!(
            r#"{ROOM}, {{ "name": "ground", "type": "rectangle", "origin": [-9,-9,-1], "u": [20,0,0], "v": [0,20,0], "material": "m" }}"#
        );
        let shining = r#""type": "area", "surface": "room", "exitance_lm_m2": 100"#;
        for (geometry, luminaire, receiver_m) in [
            (meant.as_str(), lamp(2.0), 1.0),
            (&inward, lamp(2.0), 1.0),
            (&floor, lamp(2.0), 1.0),
            (ROOM, lamp(2.0), 5.0),
            (ROOM, lamp(5.0), 1.0),
            (ROOM, shining.to_owned(), 1.0),
        ] {
            let read = read(geometry, &luminaire, receiver_m);
            assert!(read.is_ok(), "{geometry} {luminaire}: {read:?}");
        }
    }
}
