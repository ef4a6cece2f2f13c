//! `summary.json`: the run as one object.

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use serde_json::{Map, Value, json};

use super::ResultFile;
use super::daylight::daylight_entries;
use super::energy::energy_entry;
use super::leaving_light::{LeavingLight, leaving_light};
use super::schedule::{Power, floor_area_m2};
use super::verdicts::verdict_entries;
use crate::base::position_index::POSITION_INDEX;
use crate::maps::{MapResult, StatisticalCheck, TableKind};
use crate::scene::{Background, Luminaire, Quantity, Scene};
use crate::solver::{Activity, GlareRating, MoreShares, Portion, Solution, Spending, worst_of_sets};

/// Version of the scene file that this program reads.
const SCENE_FILE_VERSION: u32 = 1;

/// Facts on a run for its summary that are neither in the scene nor in the solution.
#[derive(Clone, Debug)]
pub struct RunRecord {
    /// Scene file as the user named it.
    pub scene: String,
    /// Seconds of reading the scene.
    pub read_s: f64,
    /// Seconds of making and writing all other files.
    pub write_s: f64,
    /// Seconds from process start.
    pub wall_s: f64,
    /// Worker threads.
    pub threads: usize,
    /// Largest number of bytes of memory in use at any time so far.
    pub peak_memory_bytes: u64,
    /// Accuracy in m of the points at which rays hit.
    pub position_accuracy_m: f64,
    /// All files of the run, without the summary.
    pub files: Vec<String>,
    /// Whether this is a whole run or a part of one.
    pub part: PartOfRun,
}

/// Whether results belong to a whole run or to a part of one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PartOfRun {
    /// A whole run.
    Whole,
    /// One share of a run, or a part of the receivers.
    Portion(Portion),
    /// A merge of shares.
    Merged {
        /// Number of shares.
        shares: usize,
        /// Number of parts into which the receivers of each share are divided.
        receivers_parts: u32,
        /// Total computing seconds of all shares.
        compute_s: f64,
        /// How many more shares the target needs, if one is set.
        more: Option<MoreShares>,
    },
}

impl PartOfRun {
    /// The summary's entries for share, part of the receivers and merge; null if they do not apply.
    fn entries(self) -> [Value; 3] {
        match self {
            PartOfRun::Whole => [Value::Null, Value::Null, Value::Null],
            PartOfRun::Portion(Portion { share, part }) => {
                let one_of = |number: u32, of: u32| json!({ "number": number, "of": of });
                let share = share.map_or(Value::Null, |share| one_of(share.number, share.of));
                [share, part.map_or(Value::Null, |part| one_of(part.number, part.of)), Value::Null]
            }
            PartOfRun::Merged { shares, receivers_parts, compute_s, more } => {
                let more = match more {
                    Some(MoreShares::None) => json!(0),
                    Some(MoreShares::About(more)) => json!(more.expected),
                    Some(MoreShares::NoNumber) | None => Value::Null,
                };
                let merged = json!({
                    "shares": shares,
                    "receivers_parts": receivers_parts,
                    "compute_s": compute_s,
                    "more_shares_needed": more,
                });
                [Value::Null, Value::Null, merged]
            }
        }
    }
}

/// The summary of a run.
pub fn summary_file(scene: &Scene, solution: &Solution, record: &RunRecord) -> ResultFile {
    let (flux_balance, flux_balance_note) = or_note(&solution.flux_balance, |balance| {
        json!({
            "emitted_lm": balance.emitted_lm,
            "absorbed_lm": balance.absorbed_lm,
            "escaped_lm": balance.escaped_lm,
            "back_face_lm": balance.back_face_lm,
            "truncated_lm": balance.truncated_lm,
        })
    });
    let (map_check, map_check_note) = or_note(&solution.map_check, |check| {
        json!({
            "absorbed_by_map_lm": check.absorbed_by_map_lm,
            "standard_error_lm": check.standard_error_lm,
            "z_score": check.z_score,
        })
    });
    let [share, receivers_part, merged] = record.part.entries();
    let warnings: Vec<&String> = scene.warnings.iter().chain(&solution.warnings).collect();
    let intensities = leaving_light(scene, solution);
    let run = json!({
        "scene": record.scene,
        "title": scene.title,
        "seed": solution.seed,
        "share": share,
        "receivers_part": receivers_part,
        "merged": merged,
        "method": solution.method,
        "chains": solution.chains,
        "rays": solution.rays,
        "spent": spent(&solution.spending),
        "replicas": solution.replicas,
        "threads": record.threads,
        "peak_memory_bytes": record.peak_memory_bytes,
        "surfaces": scene.surfaces.len(),
        "triangles": scene.triangles.len(),
        "elements": solution.elements.len(),
        "read_s": record.read_s,
        "build_s": solution.build_s,
        "compute_s": solution.compute_s,
        "write_s": record.write_s,
        "wall_s": record.wall_s,
        "target_error": solution.target_error,
        "estimated_error": solution.stated_error(),
        "target_met": solution.target_met,
        "stop_reason": solution.stop_reason.name(),
    });
    let found = json!({
        "maps": solution.maps.iter().map(|map| map_entry(map, &intensities)).collect::<Vec<Value>>(),
        "glare": worst_of_sets(&solution.glare).into_iter().map(|worst| glare_entry(scene, worst)).collect::<Vec<Value>>(),
        "verdicts": verdict_entries(scene, solution),
        "daylight_factors": daylight_entries(scene, solution),
        "flux_balance": flux_balance,
        "flux_balance_note": flux_balance_note,
        "map_check": map_check,
        "map_check_note": map_check_note,
        "position_accuracy_m": record.position_accuracy_m,
        "luminous_flux_lm": scene.luminous_flux_lm(),
        "electric_power": power_entry(scene, solution),
        "energy": energy_entry(scene),
        "luminaires": null,
        "paths_not_found": solution.paths_not_found,
        "warnings": warnings,
        "notes": solution.notes,
        "files": record.files,
        "versions": versions(),
    });
    let entries = [run, found].into_iter().flat_map(|part| part.as_object().cloned().unwrap_or_default());
    let entries = entries.collect::<serde_json::Map<String, Value>>();
    let summary = Summary { rest: Some(&entries), luminaires: &scene.luminaires };
    let mut bytes = serde_json::to_vec_pretty(&summary).expect("a JSON value has text keys alone");
    bytes.push(b'\n');
    ResultFile { name: "summary.json".to_owned(), bytes }
}

/// Rays and seconds by activity; activities without either are left out.
fn spent(spending: &Spending) -> Value {
    let entries = Activity::ALL.into_iter().filter_map(|activity| {
        let (rays, seconds) = (spending.rays(activity), spending.seconds(activity));
        (rays > 0 || seconds > 0.0).then(|| (activity.name().to_owned(), json!({ "rays": rays, "seconds": seconds })))
    });
    Value::Object(entries.collect())
}

fn or_note<T>(outcome: &Result<T, String>, write: impl Fn(&T) -> Value) -> (Value, Value) {
    match outcome {
        Ok(value) => (write(value), Value::Null),
        Err(note) => (Value::Null, json!(note)),
    }
}

fn map_entry(map: &MapResult, intensities: &[LeavingLight]) -> Value {
    json!({
        "name": map.name,
        "estimated_error": map.error.estimated,
        "random_error": map.error.random,
        "bias": map.error.bias,
        "discretisation_error": map.error.discretisation,
        "degrees_of_freedom": map.error.degrees_of_freedom,
        "method": map.method,
        "method_reason": map.method_reason,
        "luminance": luminance_entry(map),
        "intensity": intensities.iter().find(|light| light.map.kind == map.kind).map_or(Value::Null, intensity_entry),
        "bound": map.bound,
        "target_met": map.target_met,
        "refusals": map.refusals,
        "checks": map.checks.iter().map(check_entry).collect::<Vec<Value>>(),
        "chains": map.chains,
        "dark": map.error.dark_upper_bound.is_some(),
        "dark_upper_bound_lx": map.error.dark_upper_bound,
    })
}

fn check_entry(check: &StatisticalCheck) -> Value {
    json!({
        "name": check.name,
        "passed": check.passed,
        "value": check.value.filter(|value| value.is_finite()),
        "limit": check.limit,
        "says": if check.passed { Value::Null } else { json!(check.explanation) },
    })
}

/// Mean, least and greatest luminance of a set of directions; null for illuminances.
fn luminance_entry(map: &MapResult) -> Value {
    let row = map.tables.iter().find(|row| row.kind == TableKind::Luminance);
    row.map_or(Value::Null, |row| {
        json!({
            "average_cd_m2": row.average.value,
            "average_standard_error_cd_m2": row.average.standard_error,
            "minimum_cd_m2": row.minimum.value,
            "maximum_cd_m2": row.maximum.value,
        })
    })
}

/// Total flux of an intensity distribution, and its greatest intensity.
fn intensity_entry(light: &LeavingLight) -> Value {
    json!({
        "luminous_flux_lm": light.luminous_flux_lm.value,
        "luminous_flux_standard_error_lm": light.luminous_flux_lm.standard_error,
        "light_output_ratio": light.light_output_ratio,
        "maximum_cd": light.maximum_cd.value,
        "maximum_standard_error_cd": light.maximum_cd.standard_error,
        "maximum_c_deg": light.maximum_at_deg[0],
        "maximum_gamma_deg": light.maximum_at_deg[1],
    })
}

/// Power of the luminaires, undimmed: in total, for each m² of floor, and for each m² and 100 lx on each grid.
fn power_entry(scene: &Scene, solution: &Solution) -> Value {
    let (power, floor_m2) = (Power::of(scene), floor_area_m2(scene));
    let is_known = power.known_w > 0.0 && floor_m2 > 0.0;
    let per_m2 = is_known.then(|| power.known_w / floor_m2);
    let rows = solution.maps.iter().flat_map(|map| &map.tables);
    let grids = rows.filter(|row| row.kind == TableKind::Grid && row.average.is_known() && row.average.value > 0.0);
    let per_100_lx = grids.map(|row| {
        let per_100_lx = per_m2.map(|per_m2| per_m2 * 100.0 / row.average.value);
        json!({ "receiver": row.name, "w_m2_per_100_lx": per_100_lx })
    });
    json!({
        "installed_w": power.known_w,
        "luminaires_of_unknown_power": power.unknown,
        "floor_area_m2": floor_m2,
        "w_m2": per_m2,
        "per_100_lx": per_100_lx.collect::<Vec<Value>>(),
    })
}

/// The rating of an observer, the worst of `observers`.
fn glare_entry(scene: &Scene, (rating, observers): (&GlareRating, usize)) -> Value {
    let set = &scene.receivers[rating.set];
    let background = match set.quantity {
        Quantity::Glare(background) => background,
        _ => Background::default(),
    };
    let observer = &set.observers[rating.observer];
    let name = |index: usize| &scene.luminaires[index].name;
    let contributions: Vec<Value> = rating
        .contributions
        .iter()
        .map(|(index, sum)| json!({ "luminaire": name(*index), "share": sum / rating.glare_sum.value }))
        .collect();
    let outside: Vec<Value> = rating
        .outside
        .iter()
        .map(|(index, reason)| json!({ "luminaire": name(*index), "reason": reason.explanation() }))
        .collect();
    json!({
        "name": set.name,
        "observers": observers,
        "position_m": observer.eye_m.to_array(),
        "view_direction": observer.view.to_array(),
        "ugr": rating.ugr.map(|ugr| ugr.value),
        "standard_error": rating.ugr.map(|ugr| ugr.standard_error),
        "background_luminance_cd_m2": rating.background_cd_m2.value,
        "background_standard_error_cd_m2": rating.background_cd_m2.standard_error,
        "glare_sum_cd2_sr_m4": rating.glare_sum.value,
        "background": background.name(),
        "position_index": POSITION_INDEX,
        "contributions": contributions,
        "outside_position_index": outside,
    })
}

/// A summary whose luminaires are written one by one, since there may be a million of them.
struct Summary<'a> {
    rest: Option<&'a Map<String, Value>>,
    luminaires: &'a [Luminaire],
}

/// From this many luminaires on, equal luminaires in sequence share one entry.
const MANY_LUMINAIRES: usize = 10_000;

/// The entry of a luminaire, or of several that differ only in their positions.
#[derive(Serialize)]
struct LuminaireEntry<'a> {
    name: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    last_name: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    count: Option<usize>,
    luminous_flux_lm: f64,
    dimming: f64,
    maintenance_factor: f64,
    power_w: Option<f64>,
}

impl Serialize for Summary<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let luminaires = luminaire_entries(self.luminaires);
        let mut map = serializer.serialize_map(None)?;
        for (key, value) in self.rest.into_iter().flatten() {
            match key.as_str() {
                "luminaires" => map.serialize_entry(key, &luminaires)?,
                _ => map.serialize_entry(key, value)?,
            }
        }
        map.end()
    }
}

/// One entry for each luminaire. If there are very many, equal ones in sequence share an entry.
fn luminaire_entries(luminaires: &[Luminaire]) -> Vec<LuminaireEntry<'_>> {
    if luminaires.len() < MANY_LUMINAIRES {
        return luminaires.iter().map(luminaire_entry).collect();
    }
    let numbers = |luminaire: &Luminaire| {
        (luminaire.luminous_flux_lm, luminaire.dimming, luminaire.maintenance_factor, luminaire.power_w)
    };
    let equal = luminaires.chunk_by(|one, next| numbers(one) == numbers(next));
    equal
        .map(|equal| match equal {
            [first, .., last] => {
                LuminaireEntry { last_name: Some(&last.name), count: Some(equal.len()), ..luminaire_entry(first) }
            }
            _ => luminaire_entry(&equal[0]),
        })
        .collect()
}

fn luminaire_entry(luminaire: &Luminaire) -> LuminaireEntry<'_> {
    LuminaireEntry {
        name: &luminaire.name,
        last_name: None,
        count: None,
        luminous_flux_lm: luminaire.luminous_flux_lm,
        dimming: luminaire.dimming,
        maintenance_factor: luminaire.maintenance_factor,
        power_w: luminaire.power_w,
    }
}

fn versions() -> Map<String, Value> {
    let mut versions = Map::new();
    versions.insert("luxmc".into(), json!(env!("CARGO_PKG_VERSION")));
    versions.insert("scene_file".into(), json!(SCENE_FILE_VERSION));
    versions.insert("platform".into(), json!(format!("{}-{}", std::env::consts::ARCH, std::env::consts::OS)));
    versions
}
