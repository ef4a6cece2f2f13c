"""What the tests share: a small room, and luxmc's own program where it is at hand."""

from __future__ import annotations

import os
import shutil
from pathlib import Path
from typing import Any

import pytest

import luxmc

ROOT = Path(__file__).resolve().parents[2]
SCENES = ROOT / "scenes"


def room(**changes: Any) -> dict[str, Any]:
    """The keys of a small room with a lamp and a grid."""
    keys: dict[str, Any] = {
        "materials": {"paint": {"type": "diffuse", "reflectance": 0.5}},
        "geometry": [
            {"name": "room", "type": "box", "min": [0, 0, 0], "max": [4, 3, 2.5], "facing": "inward", "material": "paint"}
        ],
        "luminaires": [{"name": "lamp", "type": "point", "position": [2, 1.5, 2.2], "luminous_flux_lm": 3000}],
        "receivers": [
            {"name": "desk", "type": "grid", "origin": [0.5, 0.5, 0.8], "u": [3, 0, 0], "v": [0, 2, 0], "columns": 7, "rows": 5}
        ],
    }
    return {**keys, **changes}


@pytest.fixture
def scene() -> luxmc.Scene:
    return luxmc.Scene(**room())


@pytest.fixture(scope="session")
def program() -> str:
    """The command line: LUXMC names it, else that which this source tree built, else that on the path."""
    built = ROOT / "target" / "release" / "luxmc"
    found = os.environ.get("LUXMC") or (str(built) if built.exists() else shutil.which("luxmc"))
    if not found:
        pytest.skip("the program luxmc is not built: cargo build --release")
    return found
