//! Checks before a run that it fits into the machine's memory, since the system would end a process that does not.

use crate::maps::MapKind;
use crate::scene::{Elements, Scene};
use crate::solver::{Settings, map_requests};

use super::exit::Failure;
use crate::base::memory::{clean_up_by, limit_bytes, set_limit_bytes};
use crate::output::remove_unfinished_results;

/// Bytes of a map's entry at the peak of a run: sums of 16 replicas, levels, results, and the part of its files that is in memory.
/// Measured as 621 at most, plus a sixth (`docs/performance.md`, also for the next two).
const BYTES_PER_ENTRY: u64 = 720;
/// Bytes of a triangle while the tree is built over it, and bytes of a luminaire.
const BYTES_PER_TRIANGLE: u64 = 450;
const BYTES_PER_LUMINAIRE: u64 = 1000;

/// Approximate largest number of bytes that a run takes. Cells and the data gathered through them are not included: they get a
/// share of the memory.
pub fn needed_bytes(scene: &Scene, settings: &Settings) -> u64 {
    let entries: usize = map_requests(scene, &settings.maps)
        .into_iter()
        .map(|(kind, _)| match kind {
            MapKind::Elements => Elements::of(scene).len(),
            MapKind::Receivers(set) => scene.receivers[set].points.len(),
        })
        .sum();
    let parts = [
        (entries, BYTES_PER_ENTRY),
        (scene.triangles.len(), BYTES_PER_TRIANGLE),
        (scene.luminaires.len(), BYTES_PER_LUMINAIRE),
    ];
    parts.iter().map(|(count, bytes)| *count as u64 * bytes).sum()
}

/// Bytes that are left of the machine's memory, or of the share that the process may use. `None` if the system does not report
/// them.
fn available_bytes() -> Option<u64> {
    let file = |path: &str| std::fs::read_to_string(path).ok();
    let free = file("/proc/meminfo").and_then(|text| available_of_meminfo(&text));
    let limit = file("/sys/fs/cgroup/memory.max").and_then(|text| text.trim().parse::<u64>().ok());
    let used = file("/sys/fs/cgroup/memory.current").and_then(|text| text.trim().parse::<u64>().ok());
    let within_limit = limit.zip(used).map(|(limit, used)| limit.saturating_sub(used));
    match (free, within_limit) {
        (Some(free), Some(within)) => Some(free.min(within)),
        (free, within) => free.or(within),
    }
}

fn available_of_meminfo(text: &str) -> Option<u64> {
    let line = text.lines().find(|line| line.starts_with("MemAvailable:"))?;
    let kibibytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kibibytes * 1024)
}

/// Refuses a run that needs more memory than there is.
///
/// # Errors
///
/// The needed bytes, the available bytes, and what would need less.
pub fn check_memory(scene: &Scene, settings: &Settings) -> Result<(), Failure> {
    refuse_beyond(needed_bytes(scene, settings), limit_bytes())
}

/// Limits the memory of the process to the wanted bytes and to what the machine has left.
pub fn limit_memory(wanted: Option<u64>) {
    let available = available_bytes().unwrap_or(u64::MAX);
    set_limit_bytes(wanted.unwrap_or(u64::MAX).min(available));
    clean_up_by(remove_unfinished_results);
}

fn refuse_beyond(needed: u64, available: u64) -> Result<(), Failure> {
    if needed <= available {
        return Ok(());
    }
    let gigabytes = |bytes: u64| format!("{:.1} GB", bytes as f64 / 1e9);
    Err(Failure::Usage {
        what: "the maps do not fit into memory".to_owned(),
        got: format!("maps that need about {}", gigabytes(needed)),
        expected: format!("at most {}, which the machine has left or --memory-limit allows", gigabytes(available)),
        remedy: "use a larger max_element_edge or fewer receivers, or request fewer maps with --maps".to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_refused_with_both_numbers() {
        assert!(refuse_beyond(1 << 30, 1 << 31).is_ok());
        let said = refuse_beyond(64 << 30, 1 << 31).expect_err("too much").to_string();
        assert!(said.contains("68.7 GB") && said.contains("2.1 GB") && said.contains("--maps"), "{said}");
    }

    #[test]
    fn the_available_memory_is_read_in_kibibytes() {
        let text = "MemTotal:       100 kB\nMemFree:  1 kB\nMemAvailable:   24117248 kB\n";
        assert_eq!(available_of_meminfo(text), Some(24_117_248 * 1024));
        assert_eq!(available_of_meminfo(""), None);
    }
}
