"""Illuminances through openings after CIE 171:2006, cases 5.9 to 5.12, under its uniform (type 5) and overcast (type 16) skies.

Integrals of luminance times both cosines over 1/d² on the opening, by products of Gauss-Legendre rules on parts of it; panes let
pass what Fresnel's formulas say. In per cent of π times the zenith's luminance; the ground reflects 30 %.
"""
import json
import sys
from math import asin, cos, pi, sin, sqrt
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))
from lambert import configuration_factor, write, write_points  # noqa: E402

GROUND = 0.3
WALL = [("A", 2.75), ("B", 2.25), ("C", 1.75), ("D", 1.25), ("E", .75), ("F", .25)]
ALONG = [("G", .25), ("H", .75), ("I", 1.25), ("J", 1.75), ("K", 2.25), ("L", 2.75), ("M", 3.25), ("N", 3.75)]


def legendre(count):
    """Nodes and weights on [0, 1]."""
    rule = []
    for index in range(count):
        x = cos(pi * (index + .75) / (count + .5))
        for _ in range(50):
            p, q = 1.0, x
            for k in range(2, count + 1):
                p, q = q, ((2 * k - 1) * x * q - (k - 1) * p) / k
            slope = count * (x * q - p) / (x * x - 1)
            x -= q / slope
        rule.append(((1 + x) / 2, 1 / ((1 - x * x) * slope * slope)))
    return rule


RULE = legendre(16)
PARTS = 24


def pane(cosine, index=1.52):
    """Both polarisations through a pane without absorption, all inner reflections counted."""
    theta = asin(sqrt(1 - cosine * cosine) / index)
    inner = cos(theta)
    shares = [((cosine - index * inner) / (cosine + index * inner)) ** 2,
              ((index * cosine - inner) / (index * cosine + inner)) ** 2]
    return sum((1 - r) / (1 + r) for r in shares) / 2


def sky(kind, sine):
    horizontal = {"uniform": 1, "overcast": 7 / 9}[kind]
    if sine <= 0:
        return GROUND * horizontal
    return {"uniform": 1.0, "overcast": (1 + 2 * sine) / 3}[kind]


def through(place, normal, corner, u, v, kind, glazed):
    """∫ L cos cos' / (π d²) dA in per cent; the sides u and v of the opening run along axes."""
    facing = 1 if u[1] == v[1] == 0 else 2
    # The horizon of the place cuts the opening: parts end there.
    cuts = [[k / PARTS for k in range(PARTS + 1)] for _ in range(2)]
    for axis, side in enumerate((u, v)):
        if side[2]:
            at = (place[2] - corner[2]) / side[2]
            if 0 < at < 1:
                cuts[axis] = sorted(cuts[axis] + [at])
    total = 0.0
    area = sqrt(sum(c * c for c in u)) * sqrt(sum(c * c for c in v))
    for a, b in zip(cuts[0], cuts[0][1:]):
        for s, ws in RULE:
            for c, d in zip(cuts[1], cuts[1][1:]):
                for t, wt in RULE:
                    p, q = a + (b - a) * s, c + (d - c) * t
                    offset = [corner[k] + p * u[k] + q * v[k] - place[k] for k in range(3)]
                    square = sum(x * x for x in offset)
                    distance = sqrt(square)
                    here = sum(x * n for x, n in zip(offset, normal)) / distance
                    there = abs(offset[facing]) / distance
                    if here <= 0 or there <= 0:
                        continue
                    passed = pane(there) if glazed else 1
                    weight = ws * (b - a) * wt * (d - c) * area
                    total += weight * passed * sky(kind, offset[2] / distance) * here * there / square
    return 100 * total / pi


def roof(side):
    low = 2 - side / 2
    return [low, low, 3.0], [0, side, 0], [side, 0, 0]


def window(x, z):
    return [x[0], 0.0, z[0]], [0, 0, z[1] - z[0]], [x[1] - x[0], 0, 0]


under_roof = [(name, (2.0, 0.0, z), (0, 1, 0)) for name, z in WALL]
under_roof += [(name, (2.0, y, 0.0), (0, 0, 1)) for name, y in ALONG]
behind = [(name, (2.0, 4.0, z), (0, -1, 0)) for name, z in WALL]
behind += [(name, (2.0, 4 - y, 0.0), (0, 0, 1)) for name, y in ALONG]
behind += [(name + "'", (2.0, 4 - y, 3.0), (0, 0, -1)) for name, y in ALONG]
OPENINGS = [
    ("roof 1", "roof.csv", under_roof, roof(1)),
    ("roof 4", "roof.csv", under_roof, roof(4)),
    ("window 2 x 1", "window.csv", behind, window((1, 3), (1, 2))),
    ("window 4 x 3", "window.csv", behind, window((0, 4), (0, 3))),
]


def rectangle(name, origin, u, v, material="black"):
    return {"name": name, "type": "rectangle", "origin": origin, "u": u, "v": v, "material": material}


def walls(name):
    """A black room of 4 m x 4 m x 3 m with the opening left free."""
    parts = [rectangle("floor", [0, 0, 0], [4, 0, 0], [0, 4, 0]), rectangle("back", [0, 4, 0], [4, 0, 0], [0, 0, 3]),
             rectangle("left", [0, 0, 0], [0, 4, 0], [0, 0, 3]), rectangle("right", [4, 0, 0], [0, 0, 3], [0, 4, 0])]
    if name.startswith("roof"):
        parts.append(rectangle("front", [0, 0, 0], [0, 0, 3], [4, 0, 0]))
        if name == "roof 1":
            for number, (x, y, w, d) in enumerate([(0, 0, 1.5, 4), (2.5, 0, 1.5, 4), (1.5, 0, 1, 1.5), (1.5, 2.5, 1, 1.5)]):
                parts.append(rectangle(f"ceiling {number + 1}", [x, y, 3], [0, d, 0], [w, 0, 0]))
    else:
        parts.append(rectangle("ceiling", [0, 0, 3], [0, 4, 0], [4, 0, 0]))
        if name == "window 2 x 1":
            for number, (x, z, w, h) in enumerate([(0, 0, 1, 3), (3, 0, 1, 3), (1, 0, 2, 1), (1, 2, 2, 1)]):
                parts.append(rectangle(f"front {number + 1}", [x, 0, z], [0, 0, h], [w, 0, 0]))
    return parts


rows, runs = [], []
for name, file, points, (corner, u, v) in OPENINGS:
    for kind in ("uniform", "overcast"):
        for glazed in (False, True):
            title = f"{name} m, {kind}{', glazed' if glazed else ''}"
            for place, (label, position, normal) in enumerate(points):
                value = through(position, normal, corner, u, v, kind, glazed)
                rows.append([title, label, *position, value])
            geometry = walls(name) + ([rectangle("pane", corner, u, v, "pane")] if glazed else [])
            runs.append({"name": title, "target_error": "0.1%", "with": {
                "geometry": geometry, "sky": kind, "points": file, "set": title, "labels": [label for label, _, _ in points]}})
# The rule against Lambert's formula, where both can tell.
lambert = 100 * configuration_factor((2.0, 0.25, 0.0), (0, 0, 1), [(1, 0, 1), (3, 0, 1), (3, 0, 2), (1, 0, 2)])
found = through((2.0, 0.25, 0.0), (0, 0, 1), *window((1, 3), (1, 2)), "uniform", False)
assert abs(found / lambert - 1) < 1e-9, (found, lambert)
write(HERE, ["set", "point", "x", "y", "z", "exact"], rows)
write_points(HERE, "roof.csv", [(place, normal) for _, place, normal in under_roof])
write_points(HERE, "window.csv", [(place, normal) for _, place, normal in behind])
case = {
    "title": "CIE 171:2006, cases 5.9 to 5.12: openings in roof and facade under skies",
    "physics": "A black room sees the sky, and the ground that reflects 30 % of its light, through an opening with or without a pane. What a point receives is the integral of luminance over what it sees of the opening.",
    "remarks": ["In per cent of π times the zenith's luminance: under the uniform sky that is the sky component. The pane is one of clear glass after Fresnel, not the one of CIE's table, which overstates panes."],
    "sources": ["CIE 171:2006, cases 5.9 to 5.12, sky types 5 and 16; reference.py", "Moon and Spencer, Illumination from a non-uniform sky, 1942"],
    "groups": ["all", "sky"],
    "scene": {
        "version": 1,
        "materials": {"black": {"type": "diffuse", "reflectance": 0},
                      "pane": {"type": "glass", "refractive_index": 1.52, "internal_transmittance": 1}},
        "geometry": "$geometry",
        "luminaires": [{"name": "sky", "type": "sky", "luminance_distribution": "$sky",
                        "zenith_luminance_cd_m2": 100 / pi, "ground_reflectance": GROUND}],
        "receivers": [{"name": "points", "type": "points", "file": "$points"}],
    },
    "runs": runs,
    "compare": [{"name": "points", "what": "points", "map": "points", "labels": "$labels",
                 "truth": {"function": "reference", "column": "exact", "set": "$set"}, "criterion": {"worst": "0.3%"}}],
}
with open(HERE / "case.json", "w") as file:
    json.dump(case, file, indent=1, ensure_ascii=False)
    file.write("\n")
