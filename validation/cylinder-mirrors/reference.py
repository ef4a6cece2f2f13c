"""An infinite circular cylinder with a line source: Fourier series; and the prism of 96 sides that stands for it.

Two mirrors at a distance H repeat a point source with the period H along the axis: a line source but for terms that fall like
exp(-2 pi d/H). A quarter of a period off the source's plane the largest of them vanishes.
"""
import csv
from math import cos, pi, sin, tan
from pathlib import Path

HERE = Path(__file__).parent
SIDES, PERIOD, FLUX_PER_M = 96, 0.5, 1000.0
CASES = [(0.5, 0.5), (0.5, 0.8)]
ANGLES = [0, 90, 180]

# The prism's circumference is the circle's; wall panels look inwards, panel 0 in the direction phi = 0.
corner = pi / (SIDES * sin(pi / SIDES))
with open(HERE / "wall.obj", "w") as file:
    for z in (0.0, PERIOD):
        for i in range(SIDES):
            angle = 2 * pi * (i - 0.5) / SIDES
            file.write(f"v {corner * cos(angle)!r} {corner * sin(angle)!r} {z}\n")
    for i in range(SIDES):
        a, b = i + 1, (i + 1) % SIDES + 1
        file.write(f"f {b} {a} {a + SIDES}\nf {b} {a + SIDES} {b + SIDES}\n")


def series(t, reflectance, phi):
    terms = (t**m * cos(m * phi) / (1 - reflectance / (1 - 4 * m * m)) for m in range(600))
    return FLUX_PER_M / (2 * pi) * sum(terms)


flat = pi / (SIDES * tan(pi / SIDES))
places = [(flat * cos(angle), flat * sin(angle), 0.75 * PERIOD) for angle in (pi * a / 180 for a in ANGLES)]
with open(HERE / "reference.csv", "w", newline="") as file:
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(["angle"] + [f"t_{t}_rho_{r}" for t, r in CASES])
    for angle in ANGLES:
        writer.writerow([angle] + [repr(series(t, r, pi * angle / 180)) for t, r in CASES])
with open(HERE / "points.csv", "w", newline="") as file:
    file.write("x,y,z,nx,ny,nz\n")
    for (x, y, z), angle in zip(places, ANGLES):
        file.write(f"{x!r},{y!r},{z},{-cos(pi * angle / 180)!r},{-sin(pi * angle / 180)!r},0\n")
