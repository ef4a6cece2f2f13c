"""luxmc computes illuminance and luminance of a lit scene, with a measured error.

>>> import luxmc
>>> scene = luxmc.Scene(
...     materials={"paint": {"type": "diffuse", "reflectance": 0.5}},
...     geometry=[{"name": "room", "type": "box", "min": [0, 0, 0], "max": [4, 3, 2.5], "facing": "inward", "material": "paint"}],
...     luminaires=[{"name": "lamp", "type": "point", "position": [2, 1.5, 2.2], "luminous_flux_lm": 3000}],
...     receivers=[{"name": "desk", "type": "grid", "surface": "room/floor", "height": 0.75, "spacing": 0.5}])
>>> result = luxmc.solve(scene, target_error=0.02)
>>> desk = result["desk"]
>>> desk.illuminance_lx.shape, desk.positions.shape
((48,), (48, 3))
>>> 110 < desk.average < 120
True

Full guide: ``docs/python.md``.
"""

from ._core import __version__
from ._errors import LuxmcError, RefusedError, RunInterruptedError, TargetMissedError, UnwrittenError
from ._result import Map, Result
from ._scene import Scene, mesh, points, schema
from ._solve import Progress, solve
from ._words import Photometry, Sobolev, read_photometry, sobolev

__all__ = [
    "LuxmcError",
    "Map",
    "Photometry",
    "Progress",
    "RefusedError",
    "Result",
    "RunInterruptedError",
    "Scene",
    "Sobolev",
    "TargetMissedError",
    "UnwrittenError",
    "__version__",
    "mesh",
    "points",
    "read_photometry",
    "schema",
    "sobolev",
    "solve",
]
