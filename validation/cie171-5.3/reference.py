"""Exact illuminances of CIE 171:2006, case 5.3, and the published ones beside them."""
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))
from lambert import configuration_factor, write, write_points  # noqa: E402

from math import pi  # noqa: E402

WALL = [("A", 2.75, 32.68), ("B", 2.25, 75.09), ("C", 1.75, 81.38), ("D", 1.25, 69.12), ("E", .75, 53.41), ("F", .25, 39.90)]
FLOOR = [("G", .25, 61.27), ("H", .75, 79.18), ("I", 1.25, 95.52), ("J", 1.75, 105.89), ("K", 2.25, 105.89),
         ("L", 2.75, 95.52), ("M", 3.25, 79.18), ("N", 3.75, 61.27)]
SOURCE = [(1.5, 1.5, 3), (2.5, 1.5, 3), (2.5, 2.5, 3), (1.5, 2.5, 3)]
points = [(name, (2.0, 0.0, z), (0, 1, 0), cie) for name, z, cie in WALL]
points += [(name, (2.0, y, 0.0), (0, 0, 1), cie) for name, y, cie in FLOOR]
write(HERE, ["point", "x", "y", "z", "exact", "cie"],
      [[name, *place, 1000 * pi * configuration_factor(place, normal, SOURCE), cie] for name, place, normal, cie in points])
write_points(HERE, "points.csv", [(place, normal) for _, place, normal, _ in points])
