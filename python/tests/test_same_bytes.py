"""What Python computes and saves is what the command line computes and saves."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest
from conftest import SCENES, room

import luxmc

#: Files that hold times, and the reports, which tell how long the run took and how it is made again.
WITH_TIMES = {"convergence.csv", "convergence.svg", "summary.json", "report.html", "report.pdf"}


def by_program(program: str, scene: Path, out: Path, *options: str) -> dict[str, bytes]:
    subprocess.run([program, "solve", str(scene), "--out", str(out), "--quiet", *options], check=True, capture_output=True)
    return files_of(out)


def files_of(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.parametrize("method", ["auto", "collision", "gather"])
def test_the_files_of_a_scene_file_are_the_same(program: str, tmp_path: Path, method: str) -> None:
    scene = SCENES / "office.json"
    options = ["--chains", "64", "--seed", "3", "--maps", "receivers", "--method", method, "--threads", "2"]
    wanted = by_program(program, scene, tmp_path / "program", *options)
    result = luxmc.solve(luxmc.Scene.load(scene), chains=64, seed=3, maps="receivers", method=method, threads=1)
    result.save(tmp_path / "python")
    found = files_of(tmp_path / "python")
    assert sorted(found) == sorted(wanted)
    assert len(set(wanted) - WITH_TIMES) >= 4
    for name in set(wanted) - WITH_TIMES:
        assert found[name] == wanted[name], name
    assert result.files["receivers.csv"] == wanted["receivers.csv"]
    summary = json.loads((tmp_path / "python" / "summary.json").read_text())
    assert result.summary == summary
    assert {key for key in summary} == {key for key in json.loads(wanted["summary.json"])}
    assert summary["rays"] == json.loads(wanted["summary.json"])["rays"]


def test_another_seed_gives_other_bytes(scene: luxmc.Scene) -> None:
    one, other = (luxmc.solve(scene, chains=64, seed=seed).files["receivers.csv"] for seed in (0, 1))
    assert one != other


def test_a_scene_made_of_arrays_is_the_scene_file_that_it_saves(program: str, tmp_path: Path) -> None:
    corners = np.array([[0, 0, 0], [4, 0, 0], [4, 3, 0], [0, 3, 0], [2, 1.5, 2.5]]) / 3
    faces = [[0, 1, 2, 3], [1, 0, 4], [2, 1, 4], [3, 2, 4], [0, 3, 4]]
    probes = np.column_stack([np.linspace(0.2, 1, 7), np.full(7, 0.5), np.full(7, 0.01)])
    scene = luxmc.Scene(
        **room(
            geometry=[luxmc.mesh("tent", corners, faces, "paint", max_element_edge=np.float32(0.25))],
            luminaires=[{"name": "lamp", "type": "point", "position": corners.mean(axis=0), "intensity_cd": np.int64(100)}],
            receivers=[luxmc.points("probes", probes, areas=np.arange(1, 8) / 7)],
        )
    )
    scene.save(tmp_path / "tent.json")
    wanted = by_program(program, tmp_path / "tent.json", tmp_path / "out", "--chains", "64", "--maps", "all")
    result = luxmc.solve(scene, chains=64, maps="all")
    for name in ["receivers.csv", "elements.csv", "tables.csv"]:
        assert result.files[name] == wanted[name], name
    again = luxmc.solve(luxmc.Scene.load(tmp_path / "tent.json"), chains=64, maps="all")
    assert again.files == {**result.files, "convergence.csv": again.files["convergence.csv"]}


def test_arrays_are_the_numbers_of_the_files(scene: luxmc.Scene) -> None:
    result = luxmc.solve(scene, chains=64, maps="all")
    pandas = pytest.importorskip("pandas")
    desk, frame = result["desk"], result.to_pandas("desk")
    assert desk.shape == (5, 7) and len(desk) == len(frame) == 35
    for name in ["illuminance_lx", "standard_error_lx", "direct_lx", "indirect_lx", "even_lx", "odd_lx"]:
        assert np.array_equal(getattr(desk, name), frame[name]), name
    assert np.array_equal(desk.positions, frame[["x", "y", "z"]])
    assert np.array_equal(desk.normals, frame[["nx", "ny", "nz"]])
    assert np.allclose((desk.even_lx + desk.odd_lx) / 2, desk.illuminance_lx)
    elements, rows = result["elements"], result.to_pandas("elements")
    for name in ["illuminance_lx", "standard_error_lx", "even_lx"]:
        assert np.array_equal(getattr(elements, name), rows[name]), name
    assert np.array_equal(elements.weights, rows["area_m2"])
    assert np.array_equal(elements.positions, rows[["x", "y", "z"]])
    assert list(elements.surfaces) == list(rows["surface"])
    assert np.allclose(elements.corners.mean(axis=1), elements.positions)
    table = result.to_pandas()
    assert isinstance(table, pandas.DataFrame) and "desk" in set(table["name"])
    assert np.isclose(result.table("desk")["average_lx"], desk.average)


def test_a_method_without_halves_says_so(scene: luxmc.Scene) -> None:
    result = luxmc.solve(scene, target_error=0.05, method="radiosity", maps="all")
    with pytest.raises(AttributeError, match="no halves"):
        result["desk"].even_lx
    assert result["desk"].to_pandas()["even_lx"].isna().all()
