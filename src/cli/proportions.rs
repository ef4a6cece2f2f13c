//! Keeps runs from scenes that rays cannot resolve.

use super::exit::Failure;
use super::number_text::plain;
use crate::check::{Proportions, Trust};
use crate::scene::Scene;

/// Why a scene cannot be computed, or what may be wrong with its results; `None` where rays are exact enough.
struct Doubt {
    trust: Trust,
    got: String,
    expected: String,
}

const REMEDY: &str =
    "leave out or cut down what is far away, such as wide ground; a lost vertex makes a scene large, too";

fn doubt(scene: &Scene) -> Option<Doubt> {
    let proportions = Proportions::of(scene)?;
    let trust = proportions.trust();
    (trust != Trust::Sound).then(|| Doubt {
        trust,
        got: format!(
            "positions known to {} m, by the size of the whole scene; from {} half of all light goes less than {} m to the next surface",
            plain(proportions.accuracy_m, 2),
            proportions.from,
            plain(proportions.median_way_m, 2)
        ),
        expected: format!("positions known to {} m", plain(proportions.accuracy_wanted_m(), 2)),
    })
}

/// Refuses a scene that is too large for what is lit in it, and warns of one that nearly is.
///
/// # Errors
/// What stands there, what it takes, and what to do.
pub fn check_proportions(scene: &mut Scene, file: &str) -> Result<(), Failure> {
    match doubt(scene) {
        Some(doubt) if doubt.trust == Trust::None => Err(Failure::Usage {
            what: format!("the scene is too large for what is lit in it\n  in {file}"),
            got: doubt.got,
            expected: doubt.expected,
            remedy: REMEDY.to_owned(),
        }),
        doubt => {
            tell_first(scene, doubt);
            Ok(())
        }
    }
}

/// Adds what is doubtful to the warnings of a scene that is only looked at.
pub fn warn_of_proportions(scene: &mut Scene) {
    let doubt = doubt(scene);
    tell_first(scene, doubt);
}

/// No other warning is as grave.
fn tell_first(scene: &mut Scene, doubt: Option<Doubt>) {
    if let Some(doubt) = doubt {
        scene.warnings.insert(0, as_warning(&doubt));
    }
}

fn as_warning(doubt: &Doubt) -> String {
    let what = match doubt.trust {
        Trust::None => "too large for what is lit in it, and solve refuses it",
        _ => "large for what is lit in it, and results may be off by half a percent beyond their errors",
    };
    format!("the scene is {what}: {}; expected: {}; {REMEDY}", doubt.got, doubt.expected)
}
