"""Maps drawn with matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Optional, Sequence

import numpy as np

if TYPE_CHECKING:
    from ._result import Map

#: Isolux lines of a lighting plan, in lx.
ISOLUX_LX = (1, 2, 5, 10, 20, 30, 50, 75, 100, 150, 200, 300, 500, 750, 1000, 1500, 2000, 3000, 5000, 7500, 10000)


def _axes(ax: Any) -> Any:
    if ax is not None:
        return ax
    import matplotlib.pyplot as plt

    return plt.subplots()[1]


def _words(of: "Map", what: Optional[str]) -> str:
    """Name of the quantity that the colours show."""
    if what is not None:
        for unit in ("_lx", "_cd_m2"):
            what = what[: -len(unit)] if what.endswith(unit) else what
        return what.replace("_", " ")
    if of.quantity == "luminance":
        return "luminance"
    kind = {"perpendicular": "", "ugr": "background "}.get(of.quantity, f"{of.quantity} ")
    return f"{kind}illuminance"


def plot_map(
    of: "Map",
    ax: Any = None,
    *,
    what: Optional[str] = None,
    levels: Optional[Sequence[float]] = None,
    cmap: str = "viridis",
    colorbar: bool = True,
) -> Any:
    """Draws a map and returns the axes."""
    if of.kind == "elements":
        raise ValueError(
            "elements lie on all surfaces and have no plan; plot a receiver set, or use .corners, .surfaces and .illuminance_lx"
        )
    numbers = of.values if what is None else np.asarray(getattr(of, what))
    ax = _axes(ax)
    label = f"{_words(of, what)} in {of.unit}"
    if of.kind == "fan":
        ax.errorbar(np.arange(len(numbers)), numbers, of.standard_errors if what is None else None)
        ax.set(xlabel="direction", ylabel=label, title=of.name)
        return ax
    if of.kind == "view":
        drawn = ax.imshow(numbers.reshape(of.shape), cmap=cmap)
        ax.set_axis_off()
    else:
        drawn = _plan(of, ax, numbers, levels, cmap)
    if colorbar:
        ax.figure.colorbar(drawn, ax=ax, label=label)
    error = f"stated error {100 * of.estimated_error:.2g} %"
    ax.set_title(f"{of.name} ({error})")
    return ax


def _plan(of: "Map", ax: Any, numbers: Any, levels: Optional[Sequence[float]], cmap: str) -> Any:
    """Draws a grid or points, seen along the axis that is nearest to the normal of the first point."""
    along, across, names = _directions(of)
    x, y = of.positions @ along, of.positions @ across
    counts = ~of.inside
    rows, columns = of.shape or (0, 0)
    if of.kind != "grid" or min(rows, columns) < 2:
        drawn = ax.scatter(x[counts], y[counts], c=numbers[counts], cmap=cmap)
    else:
        grid = [values.reshape(of.shape) for values in (x, y, np.where(counts, numbers, np.nan))]
        drawn = ax.pcolormesh(*grid, cmap=cmap, shading="gouraud" if counts.all() else "nearest")
        wanted = levels if levels is not None else [lx for lx in ISOLUX_LX if np.nanmin(grid[2]) < lx < np.nanmax(grid[2])]
        if len(wanted) > 0:
            lines = ax.contour(*grid, levels=wanted, colors="white", linewidths=0.8)
            ax.clabel(lines, fmt="%g")
    ax.set_aspect("equal")
    ax.set(xlabel=f"{names[0]} in m", ylabel=f"{names[1]} in m")
    return drawn


def _directions(of: "Map") -> Any:
    """The two coordinate directions closest to the plane, and their names: x and y for a floor, x or y and z for a wall."""
    axis = int(np.argmax(np.abs(of.normals[0]))) if len(of) else 2
    first, second = [(1, 2), (0, 2), (0, 1)][axis]
    unit = np.eye(3)
    return unit[first], unit[second], ("xyz"[first], "xyz"[second])
