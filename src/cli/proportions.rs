//! Refuses scenes whose proportions rays cannot resolve.

use super::exit::Failure;
use super::number_text::plain;
use crate::check::{Proportions, Trust};
use crate::scene::Scene;

/// The reason why a scene cannot be computed, or why its results may be wrong. There is none if rays are exact enough.
struct Doubt {
    trust: Trust,
    /// Describes the scene, to complete "the scene is …".
    what: &'static str,
    got: String,
    expected: String,
    remedy: &'static str,
}

/// Positions in m that are known this well are good enough. The scene's size is then not the problem.
const FINE_M: f64 = 1e-4;

fn doubt(scene: &Scene) -> Option<Doubt> {
    let proportions = Proportions::of(scene)?;
    let trust = proportions.trust();
    if proportions.starts_on_surfaces() {
        let from = proportions.from;
        return Some(Doubt {
            trust: Trust::None,
            what: "obstructed where its light starts",
            got: format!(
                "half of all light from {from} meets a surface at once: they lie in its plane, on its back or facing it"
            ),
            expected: format!("{from} with free space in front of them"),
            remedy: "give a room \"facing\": \"inward\"; otherwise move them off the surface, or reverse \"aim\", \
                \"side\" or the surface",
        });
    }
    if trust == Trust::None && proportions.accuracy_m <= FINE_M {
        let (from, way) = (proportions.from, plain(proportions.median_way_m, 2));
        return Some(Doubt {
            trust,
            what: "lit from too close to a surface",
            got: format!("half of all light from {from} travels less than {way} m to the next surface"),
            expected: format!("{from} in the plane of a surface, or at least a millimetre in front of it"),
            remedy: "place a luminaire at a ceiling at the ceiling's height or below, not slightly above: move it \
                to the side that it lights",
        });
    }
    (trust != Trust::Sound).then(|| Doubt {
        trust,
        what: match trust {
            Trust::None => "too large for what is lit in it",
            _ => "large for what is lit in it, and results may be wrong by half a percent beyond their errors",
        },
        got: format!(
            "positions accurate to {} m, by the size of the whole scene; half of all light from {} travels less \
             than {} m to the next surface",
            plain(proportions.accuracy_m, 2),
            proportions.from,
            plain(proportions.median_way_m, 2)
        ),
        expected: format!("positions accurate to {} m", plain(proportions.accuracy_wanted_m(), 2)),
        remedy: "remove or shrink distant parts, such as wide ground; a stray vertex also makes a scene large",
    })
}

/// Refuses a scene that is too large for the parts that are lit, and warns of one that nearly is.
///
/// # Errors
///
/// What is wrong, what was found, what is expected, and a remedy.
pub fn check_proportions(scene: &mut Scene, file: &str) -> Result<(), Failure> {
    match doubt(scene) {
        Some(doubt) if doubt.trust == Trust::None => Err(Failure::Usage {
            what: format!("the scene is {}\n  in {file}", doubt.what),
            got: doubt.got,
            expected: doubt.expected,
            remedy: doubt.remedy.to_owned(),
        }),
        doubt => {
            tell_first(scene, doubt);
            Ok(())
        }
    }
}

/// Adds the `Doubt`, if any, to the warnings of a scene that is inspected but not solved.
pub fn warn_of_proportions(scene: &mut Scene) {
    let doubt = doubt(scene);
    tell_first(scene, doubt);
}

/// Puts the warning first, since no other is as grave.
fn tell_first(scene: &mut Scene, doubt: Option<Doubt>) {
    if let Some(doubt) = doubt {
        scene.warnings.insert(0, as_warning(&doubt));
    }
}

fn as_warning(doubt: &Doubt) -> String {
    let Doubt { trust, what, got, expected, remedy } = doubt;
    let refused = if *trust == Trust::None { ", and solve refuses it" } else { "" };
    format!("the scene is {what}{refused}: {got}; expected: {expected}; {remedy}")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A lamp in the ceiling's plane of a box that is a solid lights the back of a surface. The message names that, not the size of
    /// the scene. The same holds for a lamp slightly above a room's ceiling.
    #[test]
    fn light_that_starts_on_a_back_is_no_matter_of_size() {
        let refusal = |height_m: f64, facing: &str| {
            let text = format!(
                r#"{{ "version": 1, "materials": {{ "m": {{ "type": "diffuse", "reflectance": 0.5 }} }},
                "geometry": [ {{ "name": "room", "type": "box", "min": [0,0,0], "max": [4,4,3], "facing": "{facing}", "material": "m" }} ],
                "luminaires": [ {{ "name": "lamp", "type": "point", "position": [2,2,{height_m}], "aim": [0,0,-1], "luminous_flux_lm": 1000,
                    "distribution": "lambertian" }} ] }}"#
            );
            let mut scene = crate::scene_from_json(&text, None, std::path::Path::new(".")).expect("a valid scene");
            check_proportions(&mut scene, "room.json")
        };
        assert!(refusal(3.0, "inward").is_ok());
        let Err(Failure::Usage { what, remedy, .. }) = refusal(3.0001, "inward") else {
            panic!("a lamp above a ceiling")
        };
        assert!(what.contains("too close to a surface") && remedy.contains("ceiling"), "{what}");
        let Err(Failure::Usage { what, got, remedy, .. }) = refusal(3.0, "outward") else { panic!("a lamp on a back") };
        assert!(
            !what.contains("large") && got.contains("luminaires") && remedy.contains("\"facing\": \"inward\""),
            "{got}"
        );
    }
}
