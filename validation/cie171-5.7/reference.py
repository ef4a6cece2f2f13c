"""Configuration factors of CIE 171:2006, case 5.7, in per cent, and published ones as corrected by others.

The obstruction spans the room, so that a point sees the part of the wall above the shadow of its two upper edges.
"""
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))
from lambert import configuration_factor, write, write_points  # noqa: E402

WALL = [("A", 2.75, 16.07), ("B", 2.25, 16.33), ("C", 1.75, 15.40), ("D", 1.25, 13.32), ("E", .75, 10.32), ("F", .25, 7.08)]
FLOOR = [("G", .25, 3.38), ("H", .75, 3.63), ("I", 1.25, 3.01), ("J", 1.75, 0.0), ("K", 2.25, 0.0)]
EDGES = [(2.5, 1.0), (2.7, 1.0)]


def factor(place, normal):
    _, y, z = place
    low = max(0.0, *(z + (edge_z - z) * (4 - y) / (edge_y - y) for edge_y, edge_z in EDGES))
    if low >= 3:
        return 0.0
    return 100 * configuration_factor(place, normal, [(0, 4, low), (4, 4, low), (4, 4, 3), (0, 4, 3)])


points = [(name, (2.0, 0.0, z), (0, 1, 0), cie) for name, z, cie in WALL]
points += [(name, (2.0, y, 0.0), (0, 0, 1), cie) for name, y, cie in FLOOR]
write(HERE, ["point", "x", "y", "z", "exact", "corrected"],
      [[name, *place, factor(place, normal), cie] for name, place, normal, cie in points])
write_points(HERE, "points.csv", [(place, normal) for _, place, normal, _ in points])
