"""Progress, interruptions, saving, plots, exact solutions, photometric files."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest
from conftest import SCENES, room

import luxmc

#: No run of the room comes here.
OUT_OF_REACH = 1e-6


def test_a_callback_is_told_of_progress(scene: luxmc.Scene) -> None:
    told: list[luxmc.Progress] = []
    luxmc.solve(scene, target_error=OUT_OF_REACH, time_limit=1.5, progress=told.append)
    assert len(told) >= 3
    assert all(0 <= progress.fraction <= 1 for progress in told)
    rays = [progress.rays for progress in told]
    assert rays == sorted(rays) and rays[-1] > rays[0]
    assert told[-1].target_error == OUT_OF_REACH and told[-1].estimated_error is not None
    assert "target" in str(told[-1])


def test_an_exception_of_a_callback_ends_the_run(scene: luxmc.Scene) -> None:
    def fault(progress: luxmc.Progress) -> None:
        raise LookupError("of one's own")

    with pytest.raises(LookupError, match="of one's own"):
        luxmc.solve(scene, target_error=OUT_OF_REACH, progress=fault)


def test_other_threads_work_while_a_run_goes_on(scene: luxmc.Scene) -> None:
    ticks: list[int] = []
    done = threading.Event()

    def tick() -> None:
        while not done.wait(0.01):
            ticks.append(1)

    thread = threading.Thread(target=tick)
    thread.start()
    luxmc.solve(scene, target_error=OUT_OF_REACH, time_limit=1.0, threads=1)
    done.set()
    thread.join()
    assert len(ticks) >= 10


@pytest.mark.skipif(os.name == "nt", reason="signals of another process")
@pytest.mark.parametrize("progress", ["False", "lambda progress: None"])
def test_an_interruption_ends_a_run_with_what_it_has(progress: str) -> None:
    script = f"""
import os, signal, threading
import luxmc
scene = luxmc.Scene(**{room()!r})
threading.Timer(1.0, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
result = luxmc.solve(scene, target_error={OUT_OF_REACH}, progress={progress})
assert result.stop_reason == "interrupted" and result.exit_code == 130, result
assert (result["desk"].illuminance_lx > 0).all()
try:
    result.check()
except luxmc.RunInterruptedError as error:
    print("interrupted", error.exit_code)
"""
    ran = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60)
    assert ran.stdout.strip() == "interrupted 130", ran.stderr
    assert signal.SIGINT


def test_a_bar_is_drawn(scene: luxmc.Scene, capfd: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("tqdm")
    luxmc.solve(scene, target_error=0.02, progress=True)
    assert "target met" in capfd.readouterr().err


def test_results_are_saved_with_the_formats_asked_for(scene: luxmc.Scene, tmp_path: Path) -> None:
    result = luxmc.solve(scene, chains=16)
    assert result.summary["files"] == []
    result.save(tmp_path, plots="none")
    assert not list(tmp_path.glob("*.svg")) and (tmp_path / "report.html").exists()
    assert "luxmc.solve(luxmc.Scene.load(" in (tmp_path / "report.html").read_text().replace("&#39;", "'")
    result.save(tmp_path, plots="svg,png")
    assert (tmp_path / "map-desk.svg").exists() and (tmp_path / "map-desk.png").exists()
    assert "map-desk.png" in result.summary["files"]


def test_maps_are_drawn(tmp_path: Path) -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    probes = luxmc.points("probes", [[1, 1, 0.8], [2, 1, 0.8], [3, 2, 1.0]])
    view = {"direction": [1, 0, -0.3], "field_deg": [60, 40], "columns": 12, "rows": 8}
    receivers = room()["receivers"] + [
        probes,
        {"name": "wall", "type": "grid", "origin": [0.1, 0.5, 0.5], "u": [0, 2, 0], "v": [0, 0, 1.5], "columns": 6, "rows": 5},
        {"name": "view", "type": "luminance", "position": [0.5, 1.5, 1.2], "view": view},
        {"name": "fan", "type": "luminance", "position": [0.5, 1.5, 1.2],
         "fan": {"direction": [1, 0, 0], "from_deg": -30, "to_deg": 30, "count": 7}},
    ]
    result = luxmc.solve(luxmc.Scene(**room(receivers=receivers)), target_error=0.05, maps="all")
    assert result["view"].shape == (8, 12) and result["view"].unit == "cd/m²"
    assert len(result["view"].to_pandas()) == 96
    for name in ["desk", "wall", "probes", "view", "fan"]:
        axes = result.plot(name)
        axes.figure.savefig(tmp_path / f"{name}.png")
        assert (tmp_path / f"{name}.png").stat().st_size > 3000
    labels = [axes.get_ylabel() for axes in result.plot("desk", what="standard_error_lx").figure.axes]
    assert "standard error in lx" in labels
    assert result.plot("wall").get_xlabel() == "y in m" and result.plot("wall").get_ylabel() == "z in m"
    with pytest.raises(ValueError, match="receiver set"):
        result.plot("elements")


def test_the_exact_solution_is_the_command_lines(program: str) -> None:
    options = ["--h1", "0.25", "--rho1", "0.2", "--rho2", "0.7", "--r", "0,0.5,2", "--plane", "2"]
    ran = subprocess.run([program, "sobolev", *options], capture_output=True, text=True, check=True)
    wanted = np.array([[float(cell) for cell in line.split(",")] for line in ran.stdout.splitlines()[1:]])
    found = luxmc.sobolev(0.25, 0.2, 0.7, [0, 0.5, 2], plane=2)
    columns = [found.r, found.direct_lx, found.reflected_lx, found.total_lx, found.estimated_error_lx]
    assert np.array_equal(np.column_stack(columns), wanted)


def test_a_photometric_file_is_read() -> None:
    downlight = luxmc.read_photometry(SCENES / "luminaires" / "downlight.ldt")
    assert downlight.intensity_cd.shape == (len(downlight.c_deg), len(downlight.gamma_deg))
    assert downlight.c_deg[0] == 0 and downlight.c_deg[-1] == 360 and downlight.gamma_deg[0] == 0
    assert downlight.intensity_cd.max() == downlight.facts["maximum_intensity_cd"]
    # The flux by the trapezoidal rule over the table itself.
    gamma, c = np.radians(downlight.gamma_deg), np.radians(downlight.c_deg)
    over_gamma = np.trapezoid(downlight.intensity_cd * np.sin(gamma), gamma, axis=1)
    assert np.isclose(np.trapezoid(over_gamma, c), downlight.luminous_flux_lm, rtol=0.01)


def test_the_schema_knows_arrays_in_the_file() -> None:
    assert "vertices" in str(luxmc.schema())
