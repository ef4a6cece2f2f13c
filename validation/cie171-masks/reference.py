"""Illuminances behind a facade's opening with an overhang or a wall before it, after CIE 171:2006, cases 5.13 and 5.14.

The opening is cut where the mask's edge lies as a point sees it. Past the edge stands the sky; on the mask its luminance,
0.3/π of what it receives there from sky and ground past the room's outside, which is black. In per cent of the
illuminance of an open horizontal plane, sky alone; the ground reflects 30 %. Needs numpy.
"""
import sys
from math import pi
from pathlib import Path

import numpy

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))
from lambert import configuration_factor, write, write_points  # noqa: E402
from skies import (GROUND, TYPES, dump, gauss, hemisphere, published, quads, relative, scale, seen, sky,  # noqa: E402
                   window, write_room)

MASK = 0.3
WIDE = (-20, 24)
POINTS = [(name, 4 - y) for name, y in zip("ABCDEFGH", (.25, .75, 1.25, 1.75, 2.25, 2.75, 3.25, 3.75))]
CORNERS = [(x, y, z) for x in (0, 4) for y in (0, 4) for z in (0, 3)]
CORNER, U, V = window((1, 3), (1, 2))


def outline(eye):
    """Convex outline of the room on the facade's plane y = 0, as a place before it sees it: (x, z) counter-clockwise."""
    shown = []
    for corner in CORNERS:
        share = -eye[1] / (corner[1] - eye[1])
        shown.append((eye[0] + share * (corner[0] - eye[0]), eye[2] + share * (corner[2] - eye[2])))
    shown = sorted(set(shown))
    halves = []
    for line in (shown, shown[::-1]):
        hull = []
        for p in line:
            while len(hull) > 1 and ((hull[-1][0] - hull[-2][0]) * (p[1] - hull[-2][1])
                                     - (hull[-1][1] - hull[-2][1]) * (p[0] - hull[-2][0])) <= 1e-12:
                hull.pop()
            hull.append(p)
        halves.append(hull[:-1])
    return halves[0] + halves[1]


def above(polygon, height):
    """The part of a polygon above a height."""
    kept = []
    for here, there in zip(polygon, polygon[1:] + polygon[:1]):
        h, t = here[1] - height, there[1] - height
        if h >= 0:
            kept.append(here)
        if h * t < 0:
            share = h / (h - t)
            kept.append((here[0] + share * (there[0] - here[0]), height))
    return kept


def below(polygon, height):
    return [(x, -z) for x, z in above([(x, -z) for x, z in polygon], -height)]


def factor(eye, normal, polygon):
    return configuration_factor(eye, normal, [(x, 0.0, z) for x, z in polygon]) if len(polygon) > 2 else 0.0


RULE = gauss(10)


def sky_behind(kind, eye, polygon):
    """∫ L cos over the part of the sky that a polygon of the facade's plane hides from a place that faces it."""
    total = 0.0
    for second, third in zip(polygon[1:], polygon[2:]):
        a, b, c = (numpy.array(corner) for corner in (polygon[0], second, third))
        area = abs((b - a)[0] * (c - a)[1] - (b - a)[1] * (c - a)[0])
        s, t = RULE[0][:, None], RULE[0][None, :]
        weights = RULE[1][:, None] * RULE[1][None, :] * s * area
        flat = a + s[..., None] * ((b - a) + t[..., None] * (c - b))
        offset = numpy.stack([flat[..., 0] - eye[0], numpy.full(weights.shape, -eye[1]), flat[..., 1] - eye[2]], axis=-1)
        square = (offset ** 2).sum(axis=-1)
        towards = offset / numpy.sqrt(square)[..., None]
        total += float((relative(kind, towards, 180) * towards[..., 1] ** 2 / square * weights).sum())
    return total


def on_overhang(_, eye):
    """What the underside of the overhang receives: the ground past the room."""
    return GROUND * 100 * (1 - factor(eye, (0, 0, -1), outline(eye)))


def on_wall(kind, eye):
    """What the wall's side towards the room receives."""
    room = outline(eye)
    ground = GROUND * 100 * (0.5 - factor(eye, (0, 1, 0), below(room, eye[2])))
    return ground + SCALES[kind] * (NORTH[kind] - sky_behind(kind, eye, above(room, eye[2])))


SCALES = {kind: scale(kind, 180) for kind in TYPES}
NORTH = {kind: hemisphere(kind, (0, 1, 0), 180) for kind in TYPES}
# The hidden sky against Lambert's formula where it is even.
facade, eye = [(0.0, 1.0), (4.0, 1.0), (4.0, 3.0), (0.0, 3.0)], (2.5, -6.0, 1.0)
assert abs(sky_behind(5, eye, facade) / relative(5, numpy.array([0., 0., 1.]), 180) / pi / factor(eye, (0, 1, 0), facade) - 1) < 1e-7

MASKS = [(f"overhang {depth:g}", lambda y, depth=depth: 3 * y / (y + depth), lambda y: (0, 3.0), on_overhang,
          {"origin": [WIDE[0], -depth, 3], "u": [0, depth, 0], "v": [WIDE[1] - WIDE[0], 0, 0]}) for depth in (.5, 1, 2)]
MASKS += [(f"wall {height}", lambda y, height=height: height * y / (y + 6), lambda y: (1, -6.0), on_wall,
           {"origin": [WIDE[0], -6, 0], "u": [0, 0, height], "v": [WIDE[1] - WIDE[0], 0, 0]}) for height in (3, 6, 9)]


def value(kind, y, edge, plane, lit, is_overhang):
    """The sky past the mask's edge and the mask, in lx."""
    place = numpy.array([2.0, y, 0.0])
    # Where the wall rises above the room's height its light has a kink.
    kink = 3 * y / (y + 6)
    # An overhang hides what lies above its edge, a wall what lies below.
    towards, _, weights = seen(place, (0, 0, 1), CORNER, U, V, 2, 12, [edge - 1, kink - 1])
    height = place[2] + towards[..., 2] / -towards[..., 1] * y
    is_hidden = height > edge if is_overhang else height < edge
    total = (numpy.where(is_hidden, 0, SCALES[kind] * relative(kind, towards, 180)) * weights).sum()
    for at in numpy.argwhere(is_hidden):
        ray, weight = towards[tuple(at)], weights[tuple(at)]
        way = 3.0 / ray[2] if is_overhang else -(y + 6) / ray[1]
        key = (None if is_overhang else kind, *numpy.round(place + way * ray, 9))
        if key not in LIT:
            LIT[key] = lit(kind, place + way * ray)
        total += MASK / pi * LIT[key] * weight
    return float(total)


LIT = {}
tables = published(HERE)
rows, runs = [], []
write_room(HERE, "room.obj", quads("window 2 x 1"))
for name, edge, plane, lit, rectangle in MASKS:
    for kind in TYPES:
        title = f"{name} m, type {kind}"
        told = tables.get((name, kind), [""] * len(POINTS))
        is_overhang = name.startswith("overhang")
        for (label, y), cie in zip(POINTS, told):
            rows.append([title, label, 2.0, y, 0.0, f"{value(kind, y, edge(y), plane(y), lit, is_overhang):.9g}", cie])
        mask = {"name": "mask", "type": "rectangle", **rectangle, "material": "mask"}
        runs.append({"name": title, "target_error": "0.2%", "with": {"mask": mask, "sky": sky(kind, 180), "set": title}})
write(HERE, ["set", "point", "x", "y", "z", "exact", "cie"], rows)
write_points(HERE, "points.csv", [((2.0, y, 0.0), (0, 0, 1)) for _, y in POINTS])
dump({
    "title": "CIE 171:2006, cases 5.13 and 5.14: an overhang and a wall before a facade's opening",
    "physics": "A black room sees the sky through an opening that an overhang or a wall outside partly hides. The mask reflects 30 % of the light that it receives from the ground and, if it is a wall, from the sky. The illuminance of a point is the integral of luminance over everything that it sees.",
    "remarks": ["Values are in per cent of the illuminance of an open horizontal plane. Masks are 44 m wide. CIE gives its masks other luminances: one value for a whole overhang, and for walls of 6 and 9 m up to three times what the sky can give, as its critics (NVIDIA 2016) also found. There its numbers differ. Where the mask's own light counts little, they agree."],
    "sources": ["CIE 171:2006, cases 5.13 and 5.14, tables B.21 to B.26; reference.py", "ISO 15469:2004, table 1"],
    "groups": ["all", "sky"],
    "scene": {
        "version": 1,
        "materials": {"black": {"type": "diffuse", "reflectance": 0}, "mask": {"type": "diffuse", "reflectance": MASK}},
        "geometry": [{"name": "room", "type": "mesh", "file": "room.obj", "material": "black"}, "$mask"],
        "luminaires": ["$sky"],
        "receivers": [{"name": "points", "type": "points", "file": "points.csv"}],
    },
    "runs": runs,
    "compare": [{"name": "points", "what": "points", "map": "points", "labels": [label for label, _ in POINTS],
                 "truth": {"function": "reference", "column": "exact", "set": "$set"},
                 "beside": {"name": "CIE 171", "column": "cie"}, "criterion": {"true_error": "0.3%"}}],
}, HERE / "case.json")
