"""Exact illuminances of CIE 171:2006, case 5.2, and the published ones beside them."""
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))
from lambert import configuration_factor, write, write_points  # noqa: E402

from math import pi  # noqa: E402

POINTS = [("A", 0, 0, 111.11), ("B", .5, 0, 105.21), ("C", 1, 0, 90.02), ("D", 1.5, 0, 71.11), ("E", .5, .5, 99.73),
          ("F", 1, .5, 85.64), ("G", 1.5, .5, 68.06), ("H", 1, 1, 74.36), ("I", 1.5, 1, 59.98), ("J", 1.5, 1.5, 49.39)]
HEIGHT = 3.0
rows = []
for name, x, y, published in POINTS:
    square = x * x + y * y + HEIGHT * HEIGHT
    lambertian = 1000 * HEIGHT * HEIGHT / square**2
    isotropic = 10_000 / (4 * pi) * HEIGHT / square**1.5
    rows.append([name, float(x), float(y), 0.0, lambertian, published, isotropic, ""])
write(HERE, ["point", "x", "y", "z", "lambertian", "lambertian_cie", "isotropic", "isotropic_cie"], rows)
write_points(HERE, "points.csv", [((x, y, 0), (0, 0, 1)) for _, x, y, _ in POINTS])
