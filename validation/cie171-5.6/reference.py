"""Configuration factors of CIE 171:2006, case 5.6, in per cent, and the published ones of its 4 m x 4 m surface."""
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))
from lambert import configuration_factor, write, write_points  # noqa: E402

WALL = [("B", .75, 35.901), ("C", 1.25, 27.992), ("D", 1.75, 21.639), ("E", 2.25, 16.716), ("F", 2.75, 12.967)]
CEILING = [("G", .25, 26.80), ("H", .75, 30.94), ("I", 1.25, 33.98), ("J", 1.75, 35.57), ("K", 2.25, 35.57),
           ("L", 2.75, 33.98), ("M", 3.25, 30.94), ("N", 3.75, 26.80)]


def factor(place, normal, side):
    low, high = 2 - side / 2, 2 + side / 2
    return 100 * configuration_factor(place, normal, [(low, low, 0), (high, low, 0), (high, high, 0), (low, high, 0)])


points = [(name, (2.0, 0.0, z), (0, 1, 0), cie) for name, z, cie in WALL]
points += [(name, (2.0, y, 3.0), (0, 0, -1), cie) for name, y, cie in CEILING]
write(HERE, ["point", "x", "y", "z", "small", "medium", "large", "cie_medium", "cie_none"],
      [[name, *place, factor(place, normal, .5), factor(place, normal, 4), factor(place, normal, 500), cie, ""]
       for name, place, normal, cie in points])
write_points(HERE, "points.csv", [(place, normal) for _, place, normal, _ in points])
