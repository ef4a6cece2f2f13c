"""The exact solution between two planes, and photometric files."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Sobolev:
    """Illuminances of the exact solution of Sobolev's problem in lx, one for each distance."""

    #: Distances from the point of the plane below the source (foot of its perpendicular), in units of the distance of the planes.
    r: Array
    #: Direct light in lx.
    direct_lx: Array
    #: Light reflected any number of times, in lx.
    reflected_lx: Array
    #: Direct and reflected light together, in lx.
    total_lx: Array
    #: Estimated error of the total, in lx.
    estimated_error_lx: Array


def sobolev(h1: float, rho1: float, rho2: float, r: ArrayLike, plane: int = 1) -> Sobolev:
    """Exact illuminance on one of two infinite parallel diffuse planes at distance 1, lit by a point source of 1 cd at height ``h1``
    over plane 1.

    >>> import luxmc
    >>> found = luxmc.sobolev(0.5, 0.5, 0.5, [0.0, 1.0])
    >>> [round(float(lx), 9) for lx in found.direct_lx]
    [4.0, 0.357770876]
    >>> bool((found.total_lx == found.direct_lx + found.reflected_lx).all())
    True
    """
    radii = np.atleast_1d(np.asarray(r, dtype=float)).ravel()
    direct, reflected, total, error = _core.sobolev(h1, rho1, rho2, radii, plane)
    return Sobolev(radii, direct, reflected, total, error)


@dataclass(frozen=True)
class Photometry:
    """An IES LM-63 or EULUMDAT file: its intensities, and all facts that ``luxmc inspect --json`` states about it."""

    #: Intensities in cd: one row for each plane, one column for each angle.
    intensity_cd: Array
    #: Angles of the planes in degrees.
    c_deg: Array
    #: Angles within a plane in degrees; 0 is straight down for type C.
    gamma_deg: Array
    #: Flux in lm, integrated from the intensities.
    luminous_flux_lm: float
    #: All other facts, by their names in ``luxmc inspect --json``.
    facts: dict[str, Any]

    @property
    def luminaire(self) -> str:
        """Description or name of the luminaire; may be empty."""
        return str(self.facts["luminaire"])


def read_photometry(path: Union[str, "os.PathLike[str]"]) -> Photometry:
    """Reads a photometric file. Raises ``RefusedError`` for an invalid file."""
    told, intensity_cd = _core.photometry(Path(path))
    facts: dict[str, Any] = json.loads(told)
    c_deg, gamma_deg = np.array(facts.pop("c_deg"), float), np.array(facts.pop("gamma_deg"), float)
    table = intensity_cd.reshape(len(c_deg), len(gamma_deg))
    return Photometry(table, c_deg, gamma_deg, float(facts["luminous_flux_lm"]), facts)
