"""Scenes: loaded from files, or built from dictionaries and numpy arrays."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any, Iterable, List, Mapping, Optional, Union

import numpy as np
from numpy.typing import ArrayLike

from . import _core

PathLike = Union[str, "os.PathLike[str]"]


def _plain(value: Any) -> Any:
    """Converts what JSON does not support: arrays to lists, numpy numbers to numbers, paths to texts."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, tuple):
        return list(value)
    raise TypeError(f"a scene cannot hold a {type(value).__name__}: {value!r}")


class Scene:
    """A scene that luxmc has read and found valid.

    ``Scene.load(path)`` reads a scene file. ``Scene(...)`` builds a scene from the same keys as the file (``docs/formats.md``). Numpy
    arrays may replace lists of numbers. In both cases the same reader checks everything and raises ``RefusedError`` for invalid
    input.

    >>> import luxmc, numpy as np
    >>> scene = luxmc.Scene(
    ...     materials={"paint": {"type": "diffuse", "reflectance": 0.5}},
    ...     geometry=[{"name": "room", "type": "box", "min": np.zeros(3), "max": [4, 3, 2.5], "facing": "inward",
    ...                "material": "paint"}],
    ...     luminaires=[{"name": "lamp", "type": "point", "position": [2, 1.5, 2.2], "luminous_flux_lm": 3000}],
    ...     receivers=[{"name": "desk", "type": "grid", "surface": "room/floor", "height": 0.75, "spacing": 0.5}])
    >>> scene
    <luxmc.Scene 'scene': 6 surfaces, 1 luminaire, receivers: desk>
    >>> scene.inspect()["totals"]["triangles"]
    12
    """

    def __init__(
        self,
        *,
        materials: Mapping[str, Mapping[str, Any]],
        geometry: Iterable[Mapping[str, Any]],
        luminaires: Iterable[Mapping[str, Any]],
        receivers: Iterable[Mapping[str, Any]] = (),
        title: str = "",
        length_unit: str = "m",
        base_dir: PathLike = ".",
        name: str = "scene",
    ) -> None:
        description: dict[str, Any] = {"version": 1, "title": title, "length_unit": length_unit}
        description["materials"] = materials
        description["geometry"] = list(geometry)
        description["luminaires"] = list(luminaires)
        description["receivers"] = list(receivers)
        self._read(description, base_dir, name)

    def _read(self, description: Mapping[str, Any], base_dir: PathLike, name: str) -> None:
        self._text: Optional[str] = json.dumps(description, default=_plain, ensure_ascii=False)
        self._base_dir = Path(base_dir)
        self._core = _core.Scene.from_json(self._text, self._base_dir, name)
        self._path: Optional[Path] = None

    @classmethod
    def load(cls, path: PathLike) -> "Scene":
        """Reads a scene file and all files that it names."""
        scene = cls.__new__(cls)
        scene._core = _core.Scene.load(Path(path))
        scene._path = Path(path)
        scene._base_dir = Path(path).parent
        scene._text = None
        return scene

    @classmethod
    def from_dict(cls, description: Mapping[str, Any], *, base_dir: PathLike = ".", name: str = "scene") -> "Scene":
        """Builds a scene from the full content of a scene file as a dictionary, such as a changed ``to_dict()``.

        Files that it names are read from ``base_dir``.
        """
        scene = cls.__new__(cls)
        scene._read(description, base_dir, name)
        return scene

    def to_dict(self) -> dict[str, Any]:
        """A copy of the scene file as a dictionary, to be changed and given to ``from_dict``."""
        found: dict[str, Any] = json.loads(self._json())
        return found

    def _json(self) -> str:
        if self._text is None:
            assert self._path is not None
            return self._path.read_text(encoding="utf-8-sig")
        return self._text

    def save(self, path: PathLike) -> None:
        """Writes the scene file. The command line computes the same bytes from it.

        Files that it names are not copied: save the scene into the folder of these files.
        """
        Path(path).write_text(json.dumps(self.to_dict(), indent=1, ensure_ascii=False), encoding="utf-8")

    def inspect(self) -> dict[str, Any]:
        """The output of ``luxmc inspect --json``: surfaces, luminaires, receivers, totals."""
        found: dict[str, Any] = json.loads(self._core.inspect())
        return found

    @property
    def base_dir(self) -> Path:
        """The folder from which files of the scene are read."""
        return self._base_dir

    @property
    def name(self) -> str:
        """The scene's name in messages and results. For a loaded scene, the file that it was loaded from."""
        return self._core.name

    @property
    def title(self) -> str:
        """The ``title`` of the scene file."""
        return self._core.title

    @property
    def surfaces(self) -> List[str]:
        """Names of all surfaces. Each part of a geometry is a surface of its own."""
        return self._core.surfaces

    @property
    def luminaires(self) -> List[str]:
        """Names of all luminaires. Each luminaire of an array is listed."""
        return self._core.luminaires

    @property
    def receivers(self) -> List[str]:
        """Names of the receiver sets."""
        return self._core.receivers

    @property
    def warnings(self) -> List[str]:
        """Warnings of the scene reader."""
        return self._core.warnings

    def __repr__(self) -> str:
        lamps = len(self.luminaires)
        receivers = ", ".join(self.receivers) or "none"
        return (
            f"<luxmc.Scene {self.name!r}: {len(self.surfaces)} surfaces, {lamps} luminaire{'s' if lamps != 1 else ''}, "
            f"receivers: {receivers}>"
        )


def mesh(name: str, vertices: ArrayLike, faces: ArrayLike, material: str, **keys: Any) -> dict[str, Any]:
    """A mesh geometry of vertices (n × 3) and faces (m × 3, or lists of any numbers of corners), for ``Scene(geometry=[...])``.

    The front of a face is the side from which its corners run counter-clockwise. ``keys`` are further keys of the geometry, such as
    ``max_element_edge``.

    >>> import luxmc, numpy as np
    >>> roof = luxmc.mesh("roof", np.eye(3), np.array([[0, 1, 2]]), "paint", two_sided=True)
    >>> sorted(roof)
    ['faces', 'material', 'name', 'two_sided', 'type', 'vertices']
    """
    corners = faces.tolist() if isinstance(faces, np.ndarray) else faces
    places = np.asarray(vertices, dtype=float).tolist()
    return {"name": name, "type": "mesh", "vertices": places, "faces": corners, "material": material, **keys}


def points(
    name: str, positions: ArrayLike, normals: ArrayLike = (0.0, 0.0, 1.0), areas: Optional[ArrayLike] = None, **keys: Any
) -> dict[str, Any]:
    """A receiver set of points (n × 3) with normals (n × 3, or one for all), for ``Scene(receivers=[...])``.

    ``areas`` are the weights of the points in averages. ``keys`` are further keys of the receiver, such as ``quantity``.

    >>> import luxmc
    >>> luxmc.points("probes", [[1, 2, 0.8]])["points"]
    [[1.0, 2.0, 0.8, 0.0, 0.0, 1.0]]
    """
    places = np.asarray(positions, dtype=float)
    columns = [places, np.broadcast_to(np.asarray(normals, dtype=float), places.shape)]
    if areas is not None:
        columns.append(np.broadcast_to(np.asarray(areas, dtype=float), places.shape[:1])[:, np.newaxis])
    return {"name": name, "type": "points", "points": np.concatenate(columns, axis=1).tolist(), **keys}


def schema() -> dict[str, Any]:
    """The JSON Schema of the scene file."""
    found: dict[str, Any] = json.loads(_core.schema())
    return found
