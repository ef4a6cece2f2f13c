"""Sky components of CIE 171:2006, cases 5.9 and 5.11, under its uniform sky (type 5), in per cent.

Of the published numbers stand here those that differ from the exact ones by more than rounding.
"""
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))
from lambert import configuration_factor, write, write_points  # noqa: E402

WALL = [("A", 2.75), ("B", 2.25), ("C", 1.75), ("D", 1.25), ("E", .75), ("F", .25)]
ALONG = [("G", .25), ("H", .75), ("I", 1.25), ("J", 1.75), ("K", 2.25), ("L", 2.75), ("M", 3.25), ("N", 3.75)]


def roof(side):
    low, high = 2 - side / 2, 2 + side / 2
    return [(low, low, 3), (high, low, 3), (high, high, 3), (low, high, 3)]


def window(x, z):
    return [(x[0], 0, z[0]), (x[1], 0, z[0]), (x[1], 0, z[1]), (x[0], 0, z[1])]


under_roof = [(name, (2.0, 0.0, z), (0, 1, 0)) for name, z in WALL]
under_roof += [(name, (2.0, y, 0.0), (0, 0, 1)) for name, y in ALONG]
floor = [(name, (2.0, 4 - y, 0.0), (0, 0, 1)) for name, y in ALONG]
ceiling = [(name + "'", (2.0, 4 - y, 3.0), (0, 0, -1)) for name, y in ALONG]
SETS = [
    ("roof 1 m x 1 m", under_roof, roof(1), 100, {}),
    ("roof 4 m x 4 m", under_roof, roof(4), 100, {"A": 46.74}),
    ("window 2 m x 1 m, sky", floor, window((1, 3), (1, 2)), 100, {}),
    ("window 2 m x 1 m, ground", ceiling, window((1, 3), (1, 2)), 30, {}),
    ("window 4 m x 3 m, sky", floor, window((0, 4), (0, 3)), 100, {"N": 45.29}),
    ("window 4 m x 3 m, ground", ceiling, window((0, 4), (0, 3)), 30, {"N'": 13.59}),
]
write(HERE, ["set", "point", "x", "y", "z", "exact", "cie"],
      [[name, label, *place, scale * configuration_factor(place, normal, opening), published.get(label, "")]
       for name, points, opening, scale, published in SETS for label, place, normal in points])
write_points(HERE, "roof.csv", [(place, normal) for _, place, normal in under_roof])
write_points(HERE, "floor.csv", [(place, normal) for _, place, normal in floor])
write_points(HERE, "ceiling.csv", [(place, normal) for _, place, normal in ceiling])
