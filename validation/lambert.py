"""Lambert's polygon formula (1760) in plain Python, for the reference programs beside it.

It shares nothing with luxmc: written for itself, in another language, with another way to clip.
"""
import csv
from math import acos, pi, sqrt


def _sub(a, b): return tuple(p - q for p, q in zip(a, b))
def _dot(a, b): return sum(p * q for p, q in zip(a, b))
def _cross(a, b): return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
def _norm(a): return sqrt(_dot(a, a))


def configuration_factor(point, normal, corners):
    """E/M at a point from a uniform diffuse polygon of exitance M; corners either way round."""
    # Keep what stands above the receiver's horizon.
    relative = [_sub(corner, point) for corner in corners]
    above = []
    for index, here in enumerate(relative):
        there = relative[(index + 1) % len(relative)]
        h, t = _dot(here, normal), _dot(there, normal)
        if h >= 0:
            above.append(here)
        if (h > 0 > t) or (h < 0 < t):
            above.append(tuple(p + (q - p) * h / (h - t) for p, q in zip(here, there)))
    total = 0.0
    for index, here in enumerate(above):
        there = above[(index + 1) % len(above)]
        axis = _cross(here, there)
        length = _norm(axis)
        if length > 0:
            angle = acos(max(-1.0, min(1.0, _dot(here, there) / (_norm(here) * _norm(there)))))
            total += angle * _dot(axis, normal) / length
    return abs(total) / (2 * pi)


def write(folder, header, rows):
    """Writes reference.csv; `rows` hold texts and numbers."""
    with open(folder / "reference.csv", "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        for row in rows:
            writer.writerow([repr(cell) if isinstance(cell, float) else cell for cell in row])


def write_points(folder, name, points):
    """Writes a points file for luxmc: (position, normal) pairs."""
    with open(folder / name, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["x", "y", "z", "nx", "ny", "nz"])
        for position, normal in points:
            writer.writerow([*position, *normal])
