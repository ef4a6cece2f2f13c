//! Portions of a run: `--share` and `--receivers-part`, and the files of a portion.

use std::path::Path;

use super::exit::Failure;
use super::method::MethodChoice;
use crate::maps::MapKind;
use crate::output::ShareHeader;
use crate::scene::Scene;
use crate::solver::{ElementChoice, Portion, Settings, Share, ShareRecord, Solution, map_requests};

/// The options that select a portion, as on the command line.
pub fn options_of(portion: Portion) -> String {
    let share = portion.share.map(|share| format!(" --share {}/{}", share.number, share.of));
    let part = portion.part.map(|part| format!(" --receivers-part {}/{}", part.number, part.of));
    share.unwrap_or_default() + &part.unwrap_or_default()
}

/// Refuses portions that could not be merged.
///
/// # Errors
///
/// A method whose shares would all be equal, elements that would differ between shares, and a share without a known size.
pub fn check(portion: Portion, scene: &Scene, settings: &Settings, method: MethodChoice) -> Result<(), Failure> {
    let request = options_of(portion).trim().to_owned();
    let refuse = |what: &str, got: String, expected: &str, remedy: &str| {
        let [what, expected, remedy] = [what, expected, remedy].map(str::to_owned);
        Err(Failure::Usage { what, got, expected, remedy })
    };
    if let Some(name) = method.name_without_chains() {
        return refuse(
            "the error of this method is not random: every share would have the same error",
            format!("{request} --method {name}"),
            "auto, gather, collision or local",
            "leave it out, or name one of those methods",
        );
    }
    if portion.share.is_some() && settings.chains.is_none() && settings.time_limit_s.is_none() {
        return refuse(
            "a share needs a fixed amount of work",
            request,
            "--chains N or --time-limit TIME, for this share only; luxmc merge checks --target-error",
            "add --chains, such as --chains 1e7; luxmc solve --dry-run forecasts what targets take",
        );
    }
    let binds_elements = map_requests(scene, &settings.maps).contains(&(MapKind::Elements, true));
    if binds_elements && settings.elements == ElementChoice::Adaptive {
        return refuse(
            "elements that adapt to the light would differ from share to share and could not be merged",
            format!("{request} with --elements adaptive, which is the default"),
            "--elements given, or --maps of receiver sets only",
            "add --elements given; \"max_element_edge\" in the scene makes them finer",
        );
    }
    Ok(())
}

/// The header of a share's file; the caller fills in the command and the threads.
pub fn header(
    scene_digest: String,
    scene_file: &Path,
    settings: &Settings,
    solution: &Solution,
    portion: Portion,
    record: ShareRecord,
) -> ShareHeader {
    ShareHeader {
        luxmc: env!("CARGO_PKG_VERSION").to_owned(),
        scene: scene_file.display().to_string(),
        scene_path: std::path::absolute(scene_file).unwrap_or_else(|_| scene_file.to_path_buf()),
        scene_digest,
        method: settings.method.name().to_owned(),
        seed: settings.seed,
        share: portion.share.unwrap_or(Share::WHOLE),
        target_error: settings.target_error,
        command: String::new(),
        stop_reason: solution.stop_reason.name().to_owned(),
        threads: 0,
        record,
        sums_sha256: String::new(),
    }
}
