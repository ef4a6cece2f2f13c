#!/usr/bin/env python3
"""Measures what 30 % less and 30 % more of tuned numbers cost, and writes measured.csv.

    cargo build --release        # the dependencies, which are used again
    python3 validation/tuning/measure.py

The product has no switch for its numbers. This script copies the project to target/tuning/, turns the numbers below into functions that
multiply them by what an environment variable says, and builds that copy once. Then it solves rooms of the proving ground and two sample
scenes, with the usual numbers and with one number changed at a time, by the same seeds, and compares the work to the same stated error: rays,
those of pilots too, added up over the seeds. Rays do not depend on the machine. Chance remains, since a run that a look ends later is longer at
once: how much the rays of a case scatter from seed to seed with the usual numbers is printed first.
"""
import csv
import json
import math
import os
import re
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
COPY = ROOT / "target" / "tuning"
POINTS, GIVEN, ADAPTIVE = ["--maps", "receivers"], ["--elements", "given"], ["--maps", "elements"]
# What is solved: a room of the proving ground, or a sample scene, its maps and its target.
CASES = {
    "furnished": (POINTS, "1%"),
    "coffers": (POINTS, "1%"),
    "corridor": (POINTS, "1%"),
    "white": (POINTS, "1%"),
    "cube": (GIVEN, "1%"),
    "office": (ADAPTIVE, "3%"),
}
SCENES = ("cube", "office")
ROOM_SEED, SEEDS, AT_ONCE = 2, range(3), 2
FACTORS = ("0.7", "1.3")
NUMBERS = [
    ("solver/gathering.rs", "EDGES_AN_ERROR"),
    ("solver/gathering.rs", "RAYS_OF_A_SHORT_WALK"),
    ("estimators/gathering.rs", "EDGES_FROM_CELLS"),
    ("solver/choice.rs", "RAYS_OF_A_WALK_WORTH_GATHERING"),
    ("solver/job/gathering.rs", "WORK_OF_A_GATHERING_RAY"),
    ("solver/job/gathering.rs", "WALKS_OF_AN_ENTRY"),
    ("solver/job/gathering.rs", "DIRECT_SHARE"),
    ("solver/job/gathering.rs", "RAYS_OF_A_FILL"),
    ("solver/job/gathering.rs", "RAYS_OF_A_WALK"),
    ("solver/job/gathering.rs", "MOST_GROWTH"),
    ("control/gathering.rs", "FILLED"),
    ("solver/pilot.rs", "USUAL_SURVEY"),
    ("solver/pilot.rs", "SHARE_OF_ERROR"),
    ("estimators/control_variate.rs", "SAMPLES_PER_UNCERTAINTY"),
    ("estimators/direct.rs", "SHARE_OF_BOUND"),
    ("transport/selection_by_cell.rs", "PLACES"),
    ("transport/selection_by_cell.rs", "SHARE_OF_RUN"),
    ("maps/residual_state.rs", "TO_BELIEVE"),
    ("caches/light.rs", "ENOUGH_SAMPLES"),
    ("sampling/guide.rs", "EVEN"),
    ("solver/guide.rs", "WORTHWHILE"),
    ("solver/local/plan.rs", "IN_FAVOUR_OF_CHAINS"),
]
FACTOR_OF = '''//! Factors of numbers, for `validation/tuning/measure.py` alone.

/// A number times the factor that the environment names for it.
pub fn tuned(name: &str, usual: f64) -> f64 {
    static CHANGED: std::sync::OnceLock<Option<(String, f64)>> = std::sync::OnceLock::new();
    let read = || {
        let text = std::env::var("LUXMC_TUNED").ok()?;
        let (name, factor) = text.split_once('=')?;
        Some((name.to_owned(), factor.parse().ok()?))
    };
    match CHANGED.get_or_init(read) {
        Some((changed, factor)) if changed == name => factor * usual,
        _ => usual,
    }
}
'''


def copy_with_functions():
    """The project's tracked files, with functions in place of the numbers."""
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split("\n")
    wanted = [name for name in listed if name.split("/")[0] in ("src", "benches", "examples", "scenes", "Cargo.toml", "Cargo.lock", "build.rs")]
    shutil.rmtree(COPY / "tree", ignore_errors=True)
    for name in wanted:
        (COPY / "tree" / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, COPY / "tree" / name)
    source = COPY / "tree" / "src"
    (source / "base" / "tuned.rs").write_text(FACTOR_OF)
    rooms = source / "base" / "mod.rs"
    rooms.write_text(rooms.read_text() + "pub mod tuned;\n")
    for file, name in NUMBERS:
        path = source / file
        text = path.read_text()
        line = re.search(rf"^(pub(?:\([a-z]+\))? )?const {name}: f64 = (.*);$", text, re.M)
        if not line:
            sys.exit(f"{file}: no f64 {name}")
        before, after = text[: line.start()], text[line.end() :]
        call = rf"\b{name}\b(?!\()"
        function = f'#[allow(non_snake_case)]\n{line[1] or ""}fn {name}() -> f64 {{ crate::base::tuned::tuned("{file}:{name}", {line[2]}) }}'
        path.write_text(re.sub(call, f"{name}()", before) + function + re.sub(call, f"{name}()", after))


def build():
    environment = dict(os.environ, CARGO_TARGET_DIR=os.environ.get("CARGO_TARGET_DIR", str(ROOT / "target")))
    subprocess.run(["cargo", "build", "--release", "--locked", "--bin", "luxmc"], cwd=COPY / "tree", env=environment, check=True)
    shutil.copy2(Path(environment["CARGO_TARGET_DIR"]) / "release" / "luxmc", COPY / "luxmc")


def rays(case, seed, change=None):
    """Rays of one run, its pilots' too."""
    environment = dict(os.environ)
    if change:
        environment["LUXMC_TUNED"] = change
    scene = ROOT / "scenes" / f"{case}.json" if case in SCENES else COPY / case / "room.json"
    maps, target = CASES[case]
    out = COPY / f"out-{case}-{seed}"
    command = [COPY / "luxmc", "solve", scene, "--out", out, "--quiet", "--threads", "1", "--target-error", target, *maps]
    done = subprocess.run([*command, "--seed", str(seed), "--plots", "none"], env=environment, capture_output=True, text=True)
    if done.returncode not in (0, 3):
        sys.exit(done.stderr)
    summary = json.loads((out / "summary.json").read_text())
    return sum(kind["rays"] for kind in summary["spent"].values())


def all_rays(change=None):
    """case → rays of its seeds."""
    runs = [(case, seed) for case in CASES for seed in SEEDS]
    with ThreadPoolExecutor(AT_ONCE) as pool:
        found = dict(zip(runs, pool.map(lambda run: rays(*run, change), runs)))
    return {case: [found[case, seed] for seed in SEEDS] for case in CASES}


def main():
    copy_with_functions()
    build()
    for case in CASES:
        if case not in SCENES and not (COPY / case).exists():
            new = [COPY / "luxmc", "new", "room", "--kind", case, "--seed", str(ROOM_SEED), "--out", COPY / case]
            subprocess.run(new, check=True, capture_output=True)
    rows, usual = [], all_rays()
    for case, found in usual.items():
        mean = sum(found) / len(found)
        print(case, found, f"scatter {math.sqrt(sum((one - mean) ** 2 for one in found) / (len(found) - 1)) / mean:.3f}", flush=True)
    for file, name in NUMBERS:
        for factor in FACTORS:
            changed = all_rays(f"{file}:{name}={factor}")
            for case in CASES:
                rows.append([file, name, factor, case, f"{sum(changed[case]) / sum(usual[case]):.4f}"])
                print(*rows[-1], flush=True)
        with (HERE / "measured.csv").open("w", newline="") as file_out:
            writer = csv.writer(file_out, lineterminator="\n")
            writer.writerow(["file", "name", "factor", "case", "work_over_usual"])
            writer.writerows(rows)


if __name__ == "__main__":
    main()
