"""The sixteen skies of CIE 171:2006 and what comes through openings, for the reference programs beside it.

It shares nothing with luxmc: written for itself, in another language, by products of Gauss-Legendre rules. Needs numpy.
"""
import csv
from math import pi, radians

import numpy

GROUND = 0.3
SUN_ELEVATION_DEG = 60.0
TYPES = range(1, 17)
# Gradation and indicatrix, ISO 15469:2004, table 1.
GENERAL = {1: (4, -.7, 0, -1, 0), 2: (4, -.7, 2, -1.5, .15), 3: (1.1, -.8, 0, -1, 0), 4: (1.1, -.8, 2, -1.5, .15),
           5: (0, -1, 0, -1, 0), 6: (0, -1, 2, -1.5, .15), 7: (0, -1, 5, -2.5, .3), 8: (0, -1, 10, -3, .45),
           9: (-1, -.55, 2, -1.5, .15), 10: (-1, -.55, 5, -2.5, .3), 11: (-1, -.55, 10, -3, .45),
           12: (-1, -.32, 10, -3, .45), 13: (-1, -.32, 16, -3, .3), 14: (-1, -.15, 16, -3, .3),
           15: (-1, -.15, 24, -2.8, .15)}
WALL = [("A", 2.75), ("B", 2.25), ("C", 1.75), ("D", 1.25), ("E", .75), ("F", .25)]
ALONG = [("G", .25), ("H", .75), ("I", 1.25), ("J", 1.75), ("K", 2.25), ("L", 2.75), ("M", 3.25), ("N", 3.75)]


def gauss(count, low=0.0, high=1.0):
    nodes, weights = numpy.polynomial.legendre.leggauss(count)
    return low + (high - low) * (1 + nodes) / 2, (high - low) * weights / 2


def relative(kind, towards, sun_azimuth_deg):
    """Luminance of the sky over any factor of its own; `towards` are unit vectors that point up."""
    up = numpy.maximum(towards[..., 2], 1e-12)
    if kind == 16:
        return (1 + 2 * up) / 3
    a, b, c, d, e = GENERAL[kind]
    high, turn = radians(SUN_ELEVATION_DEG), radians(sun_azimuth_deg)
    sun = numpy.array([numpy.cos(high) * numpy.sin(turn), numpy.cos(high) * numpy.cos(turn), numpy.sin(high)])
    near = numpy.clip(towards @ sun, -1, 1)
    return (1 + a * numpy.exp(b / up)) * (1 + c * (numpy.exp(d * numpy.arccos(near)) - numpy.exp(d * pi / 2)) + e * near ** 2)


def hemisphere(kind, normal, sun_azimuth_deg):
    """∫ L cos over the sky above a plane, by rules in the sine of the height and around; 720 even steps around."""
    heights, shares = gauss(400)
    turns = (numpy.arange(720) + .5) * 2 * pi / 720
    across = numpy.sqrt(1 - heights ** 2)
    towards = numpy.stack([numpy.outer(across, numpy.sin(turns)), numpy.outer(across, numpy.cos(turns)),
                           numpy.outer(heights, numpy.ones_like(turns))], axis=-1)
    cosine = numpy.maximum(towards @ numpy.array(normal, float), 0)
    return float((relative(kind, towards, sun_azimuth_deg) * cosine * shares[:, None]).sum() * 2 * pi / 720)


def scale(kind, sun_azimuth_deg):
    """What makes the open horizontal plane receive 100 lx."""
    return 100 / hemisphere(kind, (0, 0, 1), sun_azimuth_deg)


def pane(cosine, index=1.52):
    """Both polarisations through a pane without absorption, all inner reflections counted."""
    inner = numpy.cos(numpy.arcsin(numpy.sqrt(1 - cosine ** 2) / index))
    shares = [((cosine - index * inner) / (cosine + index * inner)) ** 2,
              ((index * cosine - inner) / (index * cosine + inner)) ** 2]
    return sum((1 - r) / (1 + r) for r in shares) / 2


def seen(place, normal, corner, u, v, parts=10, nodes=16, splits=()):
    """Nodes on an opening whose sides run along axes, as a place sees them: unit vectors, and weights cos cos' dA/d².

    The horizon of the place cuts the opening, and so do `splits`, shares of the side v.
    """
    facing = 1 if u[1] == v[1] == 0 else 2
    cuts = [[k / parts for k in range(parts + 1)] for _ in range(2)]
    cuts[1] = sorted(set(cuts[1]) | {at for at in splits if 0 < at < 1})
    for axis, side in enumerate((u, v)):
        if side[2]:
            at = (place[2] - corner[2]) / side[2]
            if 0 < at < 1:
                cuts[axis] = sorted(set(cuts[axis]) | {at})
    rules = [[gauss(nodes, a, b) for a, b in zip(cut, cut[1:])] for cut in cuts]
    (p, wp), (q, wq) = [tuple(numpy.concatenate([rule[k] for rule in rules[axis]]) for k in (0, 1)) for axis in (0, 1)]
    offset = numpy.array(corner) + p[:, None, None] * numpy.array(u) + q[None, :, None] * numpy.array(v) - numpy.array(place)
    square = (offset ** 2).sum(axis=-1)
    towards = offset / numpy.sqrt(square)[..., None]
    here, there = towards @ numpy.array(normal, float), abs(towards[..., facing])
    area = numpy.linalg.norm(u) * numpy.linalg.norm(v)
    return towards, there, numpy.where(here > 0, here, 0) * there / square * wp[:, None] * wq[None, :] * area


def luminance(kind, towards, sun_azimuth_deg, factor):
    """Of sky and ground in cd/m²; the open horizontal plane receives 100 lx from the sky."""
    return numpy.where(towards[..., 2] > 0, factor * relative(kind, towards, sun_azimuth_deg), GROUND * 100 / pi)


def roof(side):
    low = 2 - side / 2
    return [low, low, 3.0], [0, side, 0], [side, 0, 0]


def window(x, z):
    return [x[0], 0.0, z[0]], [x[1] - x[0], 0, 0], [0, 0, z[1] - z[0]]


def quads(name):
    """Walls of a black room of 4 m × 4 m × 3 m with an opening left free: origin and sides; fronts look in."""
    parts = [([0, 0, 0], [4, 0, 0], [0, 4, 0]), ([0, 4, 0], [4, 0, 0], [0, 0, 3]), ([0, 0, 0], [0, 4, 0], [0, 0, 3]),
             ([4, 0, 0], [0, 0, 3], [0, 4, 0])]
    if name.startswith("roof"):
        parts.append(([0, 0, 0], [0, 0, 3], [4, 0, 0]))
        if name == "roof 1":
            parts += [([x, y, 3], [0, d, 0], [w, 0, 0])
                      for x, y, w, d in [(0, 0, 1.5, 4), (2.5, 0, 1.5, 4), (1.5, 0, 1, 1.5), (1.5, 2.5, 1, 1.5)]]
        return parts
    parts.append(([0, 0, 3], [0, 4, 0], [4, 0, 0]))
    if name == "window 2 x 1":
        parts += [([x, 0, z], [0, 0, h], [w, 0, 0]) for x, z, w, h in [(0, 0, 1, 3), (3, 0, 1, 3), (1, 0, 2, 1), (1, 2, 2, 1)]]
    return parts


def write_room(folder, name, parts):
    """Writes walls as an OBJ file."""
    lines = [f"# {name}: walls of a black room, fronts inward"]
    for origin, u, v in parts:
        corners = [origin, [a + b for a, b in zip(origin, u)], [a + b + c for a, b, c in zip(origin, u, v)],
                   [a + c for a, c in zip(origin, v)]]
        lines += ["v " + " ".join(f"{x:g}" for x in corner) for corner in corners]
    lines += [f"f {4 * k + 1} {4 * k + 2} {4 * k + 3} {4 * k + 4}" for k in range(len(parts))]
    (folder / name).write_text("\n".join(lines) + "\n")


def published(folder):
    """Numbers of CIE 171 by set and type; "-" stands for none."""
    with open(folder / "published.csv") as file:
        rows = csv.DictReader(line for line in file if not line.startswith("#"))
        return {(row["set"], int(row["type"])): ["" if told == "-" else told for told in row["points"].split()] for row in rows}


def sky(kind, sun_azimuth_deg):
    """The luminaire."""
    place = {} if kind == 16 else {"sun_elevation_deg": SUN_ELEVATION_DEG, "sun_azimuth_deg": sun_azimuth_deg}
    return {"name": "sky", "type": "sky", "luminance_distribution": "overcast" if kind == 16 else f"CIE {kind}", **place,
            "horizontal_illuminance_lx": 100, "ground_reflectance": GROUND}


def dump(case, file):
    """Writes a case, one line a run."""
    import json
    text = json.dumps({**case, "runs": "RUNS"}, indent=1, ensure_ascii=False)
    runs = ",\n  ".join(json.dumps(run, ensure_ascii=False) for run in case["runs"])
    file.write_text(text.replace('"RUNS"', f"[\n  {runs}\n ]") + "\n")
