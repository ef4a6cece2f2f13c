"""Results: maps as numpy arrays, tables, summary, files and plots."""

from __future__ import annotations

import csv
import html
import io
import json
import os
from functools import cached_property
from pathlib import Path
from typing import Any, Dict, Iterator, List, Optional, Tuple, Union

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._errors import RunInterruptedError, TargetMissedError
from ._scene import Scene

Array = NDArray[np.float64]


class Map:
    """One map of a result: a receiver set, or ``elements``, the elements of all surfaces.

    Arrays have one entry for each point or each side of an element. Order and numbers are the same as in ``receivers.csv`` and
    ``elements.csv``. A set of luminances has its values in cd/m² (``luminance_cd_m2``), a set of intensities in cd (``intensity_cd``,
    one entry for each end of the axis and for each direction between). Any other set has its values in lx (``illuminance_lx``).
    """

    def __init__(self, told: Dict[str, Any], result: "Result") -> None:
        self._told = told
        self._result = result

    @property
    def name(self) -> str:
        """Name of the receiver set, or ``elements``."""
        return str(self._told["name"])

    @property
    def kind(self) -> str:
        """``elements``, ``grid``, ``points``, ``fan`` or ``view``."""
        return str(self._told["kind"])

    @property
    def quantity(self) -> str:
        """The quantity: ``perpendicular``, ``cylindrical``, ``semi-cylindrical``, ``luminance``, ``ugr``, ``intensity``."""
        return str(self._told["quantity"])

    @property
    def unit(self) -> str:
        """``lx``, ``cd/m²`` or ``cd``."""
        return str(self._told["unit"])

    @property
    def shape(self) -> Optional[Tuple[int, int]]:
        """Rows and columns of a grid or a view; ``values.reshape(map.shape)`` is the picture. None for other kinds."""
        shape = self._told["shape"]
        return None if shape is None else (int(shape[0]), int(shape[1]))

    @property
    def method(self) -> str:
        """The method that computed the map."""
        return str(self._told["method"])

    @property
    def bound(self) -> bool:
        """Whether the target applies to the map."""
        return bool(self._told["bound"])

    @property
    def target_met(self) -> Optional[bool]:
        """Whether the map met its target. None without a target."""
        met: Optional[bool] = self._told["target_met"]
        return met

    @property
    def estimated_error(self) -> float:
        """Stated relative RMS error of the map as a whole."""
        return float(self._told["estimated_error"])

    @property
    def random_error(self) -> float:
        """Part of the stated error that is random."""
        return float(self._told["random_error"])

    @property
    def bias(self) -> float:
        """Part of the stated error that is the bias of the method."""
        return float(self._told["bias"])

    @property
    def discretisation_error(self) -> float:
        """Part of the stated error that comes from the size of the elements."""
        return float(self._told["discretisation_error"])

    def _array(self, key: str, unit: str, name: str) -> Array:
        if self.unit != unit:
            others = {
                "lx": "illuminance_lx, standard_error_lx",
                "cd/m²": "luminance_cd_m2, standard_error_cd_m2",
                "cd": "intensity_cd, standard_error_cd",
            }
            other = others[self.unit]
            raise AttributeError(f"the map {self.name!r} is in {self.unit} and has no {name}; it has {other}")
        found: Optional[Array] = self._told[key]
        if found is None:
            raise AttributeError(f"the map {self.name!r} has no {name}: {self.method} computes no halves")
        return found

    @property
    def illuminance_lx(self) -> Array:
        """Illuminance in lx. For glare ratings, illuminance of the background at the eye."""
        return self._array("value", "lx", "illuminance_lx")

    @property
    def standard_error_lx(self) -> Array:
        """Its standard error; 0 means exact."""
        return self._array("standard_error", "lx", "standard_error_lx")

    @property
    def direct_lx(self) -> Array:
        """Direct illuminance in lx: light that has met no surface on its way."""
        return self._array("direct", "lx", "direct_lx")

    @property
    def indirect_lx(self) -> Array:
        """Indirect illuminance in lx: all other light."""
        return self._array("indirect", "lx", "indirect_lx")

    @property
    def even_lx(self) -> Array:
        """Illuminance from the even half of the run, which is independent of the odd half."""
        return self._array("even", "lx", "even_lx")

    @property
    def odd_lx(self) -> Array:
        """Illuminance from the odd half of the run."""
        return self._array("odd", "lx", "odd_lx")

    @property
    def luminance_cd_m2(self) -> Array:
        """Luminance in cd/m²."""
        return self._array("value", "cd/m²", "luminance_cd_m2")

    @property
    def standard_error_cd_m2(self) -> Array:
        """Its standard error; 0 means exact."""
        return self._array("standard_error", "cd/m²", "standard_error_cd_m2")

    @property
    def intensity_cd(self) -> Array:
        """Luminous intensity in cd towards ``normals``."""
        return self._array("value", "cd", "intensity_cd")

    @property
    def standard_error_cd(self) -> Array:
        """Its standard error; 0 means exact."""
        return self._array("standard_error", "cd", "standard_error_cd")

    @property
    def values(self) -> Array:
        """The values of the map, in its ``unit``."""
        found: Array = self._told["value"]
        return found

    @property
    def standard_errors(self) -> Array:
        """The standard errors of ``values``, in the same unit."""
        found: Array = self._told["standard_error"]
        return found

    @property
    def positions(self) -> Array:
        """Points, or centroids of elements, in m (n × 3)."""
        found: Array = self._told["positions"]
        return found

    @property
    def normals(self) -> Array:
        """Unit normals, or directions of view (n × 3)."""
        found: Array = self._told["normals"]
        return found

    @property
    def weights(self) -> Array:
        """Weights in averages: the area of each element, or of each point that has one, in m²."""
        found: Array = self._told["weights"]
        return found

    @property
    def inside(self) -> NDArray[np.bool_]:
        """Whether a point lies inside a closed solid. Points inside do not count in averages."""
        found: NDArray[np.bool_] = self._told.get("inside", np.zeros(len(self.values), bool))
        return found

    @property
    def corners(self) -> Array:
        """Corners of the elements in m (n × 3 × 3)."""
        if self.kind != "elements":
            raise AttributeError(f"the map {self.name!r} is no map of elements and has no corners")
        found: Array = self._told["corners"]
        return found

    @cached_property
    def surfaces(self) -> NDArray[np.str_]:
        """The surface of each element."""
        if self.kind != "elements":
            raise AttributeError(f"the map {self.name!r} is no map of elements and has no surfaces")
        names: NDArray[np.str_] = np.array(self._told["surface_names"], dtype=str)
        found: NDArray[np.str_] = names[self._told["surface_numbers"]]
        return found

    @property
    def average(self) -> float:
        """Weighted mean of all values but those of points inside solids: Ē of a receiver set."""
        counts = ~self.inside
        return float(np.average(self.values[counts], weights=self.weights[counts])) if counts.any() else 0.0

    def to_pandas(self) -> Any:
        """This map's rows of ``receivers.csv``, ``luminance.csv``, ``ugr.csv``, ``intensity.csv`` or ``elements.csv`` (needs pandas)."""
        if self.kind == "elements":
            return self._result._frame("elements.csv")
        file = {"luminance": "luminance.csv", "ugr": "ugr.csv", "intensity": "intensity.csv"}.get(self.quantity, "receivers.csv")
        frame = self._result._frame(file)
        return frame[frame["receiver"] == self.name].reset_index(drop=True)

    def plot(self, ax: Any = None, **keys: Any) -> Any:
        """Draws a grid or a view in false colours, or points in plan; see ``Result.plot``."""
        from ._plot import plot_map

        return plot_map(self, ax, **keys)

    def __len__(self) -> int:
        return len(self.values)

    def __repr__(self) -> str:
        error = f"{100 * self.estimated_error:.2g} %"
        return f"<luxmc.Map {self.name!r}: {self.kind}, {len(self)} values in {self.unit}, stated error {error}>"


class Result:
    """The results of a run. ``result["work plane"]`` is a ``Map``. Iteration gives the names of the maps."""

    def __init__(self, scene: Scene, solution: _core.Solution) -> None:
        self.scene = scene
        self._solution = solution
        self._maps: Dict[str, Map] = {}

    @property
    def map_names(self) -> List[str]:
        """Names of the maps: first ``elements``, if it was computed, then the receiver sets in the order of the scene."""
        return self._solution.map_names

    def __getitem__(self, name: str) -> Map:
        if name not in self._maps:
            names = self.map_names
            if name not in names:
                raise KeyError(f"there is no map {name!r}; there are {', '.join(map(repr, names))}")
            self._maps[name] = Map(self._solution.map(names.index(name)), self)
        return self._maps[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.map_names)

    def __len__(self) -> int:
        return len(self.map_names)

    def __contains__(self, name: object) -> bool:
        return name in self.map_names

    @property
    def maps(self) -> Dict[str, Map]:
        """All maps by their names."""
        return {name: self[name] for name in self.map_names}

    @property
    def summary(self) -> Dict[str, Any]:
        """Content of ``summary.json`` as last saved, or as for a run that writes no files."""
        found: Dict[str, Any] = json.loads(self._solution.summary)
        return found

    @property
    def estimated_error(self) -> float:
        """Largest stated error of the maps to which the target applies. Infinite if no error can be stated."""
        error = self.summary["estimated_error"]
        return float("inf") if error is None else float(error)

    @property
    def target_met(self) -> Optional[bool]:
        """Whether the target was met. None without a target."""
        met: Optional[bool] = self.summary["target_met"]
        return met

    @property
    def stop_reason(self) -> str:
        """Why the run ended: ``target_met``, ``chains``, ``time_limit``, ``interrupted``, ``exact``,
        ``finest_mesh``, ``shares``, ``verdicts_decided`` or ``undecided``."""
        return str(self.summary["stop_reason"])

    @property
    def exit_code(self) -> int:
        """The exit code that the command line would return: 0, 3 (target missed) or 130 (interrupted)."""
        return self._solution.exit_code

    @property
    def closing_words(self) -> str:
        """How the run ended and where its flux went, in the words of the command line."""
        return self._solution.closing_words

    @property
    def warnings(self) -> List[str]:
        """Warnings of the scene and of the run."""
        return self._solution.warnings

    @property
    def files(self) -> Dict[str, bytes]:
        """The tables of the run, by file name: ``tables.csv``, ``receivers.csv``, …"""
        return self._files

    @cached_property
    def _files(self) -> Dict[str, bytes]:
        return self._solution.files()

    @cached_property
    def tables(self) -> List[Dict[str, Union[str, float]]]:
        """The rows of ``tables.csv``: average, minimum, maximum, uniformities, and their errors."""
        texts = ("name", "kind", "side")
        rows = csv.DictReader(io.StringIO(self._files["tables.csv"].decode("utf-8")))
        return [{key: value if key in texts else float(value) for key, value in row.items()} for row in rows]

    def table(self, name: str) -> Dict[str, Union[str, float]]:
        """The row of ``tables.csv`` for a receiver set, or for the front of a surface."""
        for row in self.tables:
            if row["name"] == name:
                return row
        names = ", ".join(repr(row["name"]) for row in self.tables)
        raise KeyError(f"there is no row {name!r} in tables.csv; there are {names}")

    def check(self) -> "Result":
        """Returns the result itself. Raises TargetMissedError for exit code 3 and RunInterruptedError for exit code 130."""
        if self.exit_code == TargetMissedError.exit_code:
            raise TargetMissedError(self.closing_words, self)
        if self.exit_code == RunInterruptedError.exit_code:
            raise RunInterruptedError(self.closing_words, self)
        return self

    def save(self, directory: Union[str, "os.PathLike[str]"], *, plots: str = "svg") -> "Result":
        """Writes the files that ``luxmc solve --out DIR`` writes. ``plots`` is ``svg``, ``png``, both separated by a comma, or ``none``."""
        self._solution.save(Path(directory), plots)
        return self

    def _frame(self, file: str) -> Any:
        import pandas

        if file not in self._files:
            raise KeyError(f"this run has no {file}; it has {', '.join(self._files)}")
        # Names such as "NA" stay texts. An empty field of a half that the method does not compute is a missing number.
        missing = {"even_lx": [""], "odd_lx": [""]}
        text = io.BytesIO(self._files[file])
        # From version 3 on, pandas reads decimals to the nearest number by default, and warns if the option is given.
        exact = {} if int(pandas.__version__.split(".")[0]) >= 3 else {"float_precision": "round_trip"}
        return pandas.read_csv(text, keep_default_na=False, na_values=missing, **exact)

    def to_pandas(self, name: Optional[str] = None) -> Any:
        """A data frame of the map with this name, or of ``tables.csv`` without a name (needs pandas)."""
        return self._frame("tables.csv") if name is None else self[name].to_pandas()

    def plot(self, name: str, ax: Any = None, **keys: Any) -> Any:
        """Draws a map with matplotlib and returns the axes: a grid in false colours with isolux lines, a view as a picture, points in
        plan. ``levels`` are the isolux lines in lx, ``cmap`` is the colour map, ``what`` selects another array, such as
        ``"standard_error_lx"``."""
        return self[name].plot(ax, **keys)

    def __repr__(self) -> str:
        return f"<luxmc.Result: {self.closing_words.splitlines()[0]}; maps: {', '.join(self.map_names)}>"

    def __str__(self) -> str:
        return f"{self._solution.table}\n{self.closing_words}"

    def _repr_html_(self) -> str:
        text = html.escape(str(self))
        return f"<pre>{text}</pre>"
