"""Errors are exceptions with the command line's words, a class for each exit code."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest
from conftest import SCENES, room

import luxmc


def test_a_bad_scene_is_refused_in_the_programs_words(program: str, tmp_path: Path) -> None:
    bad = tmp_path / "bad.json"
    bad.write_text((SCENES / "cube.json").read_text().replace('"diffuse"', '"difuse"', 1))
    ran = subprocess.run([program, "inspect", str(bad)], capture_output=True, text=True)
    with pytest.raises(luxmc.RefusedError) as refused:
        luxmc.Scene.load(bad)
    assert f"luxmc: error: {refused.value}\n" == ran.stderr
    assert refused.value.exit_code == ran.returncode == 2
    assert isinstance(refused.value, (luxmc.LuxmcError, ValueError))


def test_maps_that_are_not_there_are_refused_in_the_programs_words(program: str, tmp_path: Path) -> None:
    options = ["solve", str(SCENES / "cube.json"), "--out", str(tmp_path / "out"), "--maps", "table"]
    ran = subprocess.run([program, *options], capture_output=True, text=True)
    with pytest.raises(luxmc.RefusedError) as refused:
        luxmc.solve(luxmc.Scene.load(SCENES / "cube.json"), maps="table")
    assert f"luxmc: error: {refused.value}\n" == ran.stderr


@pytest.mark.parametrize(
    "vertices, says",
    [
        (np.eye(3) * np.nan, "NaN"),
        (np.eye(3)[:, :2], "list of three numbers"),
        (np.array([["a", "b", "c"]] * 3, dtype=object), "number"),
    ],
)
def test_bad_arrays_are_refused_by_the_reader(vertices: np.ndarray, says: str) -> None:
    tent = {"name": "tent", "type": "mesh", "vertices": vertices, "faces": [[0, 1, 2]], "material": "paint"}
    with pytest.raises(luxmc.RefusedError, match=says):
        luxmc.Scene(**room(geometry=[tent]))


def test_what_no_scene_can_hold_is_a_type_error() -> None:
    with pytest.raises(TypeError, match="set"):
        luxmc.Scene(**room(title={1, 2}))


@pytest.mark.parametrize(
    "options, says",
    [
        ({"target_error": 1.5}, "target_error"),
        ({"target_error": float("nan")}, "target_error"),
        ({"time_limit": -1}, "time_limit"),
        ({"chains": 0}, "chains"),
        ({"seed": -1}, "seed"),
        ({"threads": 0}, "threads"),
        ({"method": "magic"}, "no such method"),
        ({"elements": "magic"}, "adaptive or given"),
        ({"method": "radiosity", "chains": 5}, "traces no chains"),
    ],
)
def test_bad_options_are_refused(scene: luxmc.Scene, options: dict, says: str) -> None:
    with pytest.raises(luxmc.RefusedError, match=says):
        luxmc.solve(scene, **options)


def test_a_missed_target_is_told_and_raised_on_request(scene: luxmc.Scene) -> None:
    result = luxmc.solve(scene, target_error=1e-4, chains=16, method="collision")
    assert (result.target_met, result.exit_code, result.stop_reason) == (False, 3, "chains")
    with pytest.raises(luxmc.TargetMissedError, match="target not met") as missed:
        result.check()
    assert missed.value.result is result and missed.value.exit_code == 3
    assert luxmc.solve(scene, target_error=0.1).check().exit_code == 0


def test_a_place_that_cannot_be_written_is_an_error_of_its_own(scene: luxmc.Scene, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    result = luxmc.solve(scene, chains=16)
    with pytest.raises(luxmc.UnwrittenError) as unwritten:
        result.save(tmp_path / "file")
    assert unwritten.value.exit_code == 4
    with pytest.raises(luxmc.RefusedError, match="svg"):
        result.save(tmp_path / "out", plots="pdf")


def test_maps_and_files_that_are_not_there_are_named(scene: luxmc.Scene) -> None:
    result = luxmc.solve(scene, chains=16, maps="desk")
    assert "elements" not in result and list(result) == ["desk"]
    with pytest.raises(KeyError, match="'desk'"):
        result["desks"]
    with pytest.raises(AttributeError, match="illuminance_lx"):
        result["desk"].luminance_cd_m2


def test_a_photometric_file_that_is_none_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.ies").write_text("not a luminaire")
    with pytest.raises(luxmc.RefusedError):
        luxmc.read_photometry(tmp_path / "a.ies")
    with pytest.raises(luxmc.RefusedError, match="h1|height"):
        luxmc.sobolev(2.0, 0.5, 0.5, [0.0])
