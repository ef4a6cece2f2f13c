"""A Lambertian panel of 1.2 m x 0.6 m given as an IES file, against Lambert's polygon formula at 0.1, 1 and 10 times its size."""
import sys
from math import cos, pi, radians
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))
from lambert import configuration_factor, write, write_points  # noqa: E402

INTENSITY, ALONG_C0, ALONG_C90 = 1000.0, 1.2, 0.6
SITES = [("0.1, below the middle", (0.0, 0.0, -0.12), (0.0, 0.0, 1.0)), ("0.1, below a corner", (0.5, 0.25, -0.12), (0.0, 0.0, 1.0)),
         ("0.1, upright beside", (0.9, 0.0, -0.12), (-1.0, 0.0, 0.0)), ("1, below the middle", (0.0, 0.0, -1.2), (0.0, 0.0, 1.0)),
         ("1, aside", (1.0, 0.7, -1.2), (0.0, 0.0, 1.0)), ("10, below the middle", (0.0, 0.0, -12.0), (0.0, 0.0, 1.0)),
         ("10, aside and tilted", (5.0, 5.0, -12.0), (-0.6, 0.0, 0.8))]
corners = [(x * ALONG_C0 / 2, y * ALONG_C90 / 2, 0.0) for x, y in ((-1, -1), (-1, 1), (1, 1), (1, -1))]
exitance = pi * INTENSITY / (ALONG_C0 * ALONG_C90)
rows = []
for name, point, normal in SITES:
    square = sum(p * p for p in point)
    facing = -sum(p * n for p, n in zip(point, normal))
    as_point = max(0.0, INTENSITY * -point[2] * facing / square**2)
    rows.append([name, *point, exitance * configuration_factor(point, normal, corners), as_point])
write(HERE, ["site", "x", "y", "z", "panel", "point"], rows)
write_points(HERE, "points.csv", [(point, normal) for _, point, normal in SITES])

angles = [step / 2 for step in range(361)]
candela = [max(0.0, INTENSITY * cos(radians(a))) if a <= 90 else 0.0 for a in angles]
width, length = ALONG_C90, ALONG_C0
with open(HERE / "panel.ies", "w", newline="") as file:
    file.write("IES:LM-63-2019\n[TEST] computed: I = 1000 cd cos(gamma), nothing above\n[MANUFAC] luxmc samples\nTILT=NONE\n")
    file.write(f"1 -1 1 {len(angles)} 1 1 2 {width} {length} 0\n1 1.00010 10\n")
    for values in (angles, [0.0], candela):
        for start in range(0, len(values), 16):
            file.write(" ".join(f"{value:.6g}" for value in values[start:start + 16]) + "\n")
