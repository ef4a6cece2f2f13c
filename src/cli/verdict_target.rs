//! `--target verdicts`: the goal of a run besides an error, and the options that fit it.

use serde::{Deserialize, Serialize};

use super::exit::Failure;
use crate::maps::MapKind;
use crate::scene::Scene;
use crate::solver::{MapSelection, Settings, map_requests};

/// Goal of a run, besides an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Target {
    /// The run goes on until every requirement of the scene is decided.
    Verdicts,
}

/// Parses a target, for clap.
pub fn target(text: &str) -> Result<Target, String> {
    match text {
        "verdicts" => Ok(Target::Verdicts),
        _ => Err("the only target is verdicts; --target-error sets an error".to_owned()),
    }
}

/// Adapts settings to a run for verdicts: if no maps are named, the receiver sets are computed.
///
/// # Errors
///
/// Fixed chains, and maps without requirements.
pub fn settle(settings: &mut Settings, scene: &Scene) -> Result<(), Failure> {
    if let Some(chains) = settings.chains {
        return Err(refusal(
            "a run with a fixed number of chains cannot continue until verdicts are decided",
            format!("--target verdicts --chains {chains}"),
            "--target verdicts, with --time-limit and --target-error if wished",
            "leave out --chains or --target",
        ));
    }
    if settings.maps == MapSelection::Default {
        settings.maps = MapSelection::Receivers;
    }
    let is_required =
        |kind: MapKind| matches!(kind, MapKind::Receivers(set) if !scene.receivers[set].requirements.is_empty());
    if map_requests(scene, &settings.maps).into_iter().any(|(kind, _)| is_required(kind)) {
        return Ok(());
    }
    let asks_elsewhere = scene.receivers.iter().any(|set| !set.requirements.is_empty());
    let (got, remedy) = match asks_elsewhere {
        true => (
            "--target verdicts with --maps that have no requirements",
            "name the sets that have requirements, or leave out --maps",
        ),
        false => (
            "--target verdicts with a scene without requirements",
            "give a receiver \"requirements\": { \"average_lx\": 500 }, or leave out --target",
        ),
    };
    Err(refusal("there is nothing to decide", got.to_owned(), "receivers with \"requirements\"", remedy))
}

/// Refuses an option that a run for verdicts cannot have, with the reason.
///
/// # Errors
///
/// Shares, parts of the receivers, checkpoints and dry runs.
pub fn check<const N: usize>(target: Option<Target>, beside: [(&str, bool, &str); N]) -> Result<(), Failure> {
    let refused = beside.into_iter().find(|(_, is_given, _)| target.is_some() && *is_given);
    refused.map_or(Ok(()), |(option, _, why)| {
        let remedy = format!("leave out {option}, or set --target-error in place of --target");
        Err(refusal(
            why,
            format!("--target verdicts with {option}"),
            "--target verdicts with --time-limit, --target-error or neither",
            &remedy,
        ))
    })
}

fn refusal(what: &str, got: String, expected: &str, remedy: &str) -> Failure {
    let [what, expected, remedy] = [what, expected, remedy].map(str::to_owned);
    Failure::Usage { what, got, expected, remedy }
}
