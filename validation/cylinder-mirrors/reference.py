"""An infinite circular cylinder with a line source: Fourier series; and the prism of 768 sides that stands for it.

Two mirrors at a distance H repeat a point source with the period H along the axis. The mean over a period is that of a line
source, and midpoints of 16 equal steps tell it but for terms that fall like exp(-32 pi d/H), d the distance from the source;
by symmetry 8 of them are enough. Where the source is far (t = 0.5), one point a quarter of a period off the source's plane is
enough too: there the first term, exp(-2 pi d/H), vanishes.
"""
import csv
from math import cos, pi, sin, tan
from pathlib import Path

HERE = Path(__file__).parent
SIDES, PERIOD, FLUX_PER_M = 768, 0.5, 1000.0
CASES = [(0.5, 0.5), (0.5, 0.8), (0.9, 0.5), (0.9, 0.8)]
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


def write_points(name, angles, heights):
    with open(HERE / name, "w", newline="") as file:
        file.write("x,y,z,nx,ny,nz\n")
        for c, s in ((cos(pi * a / 180), sin(pi * a / 180)) for a in angles):
            for z in heights:
                file.write(f"{flat * c!r},{flat * s!r},{z},{-c!r},{-s!r},0\n")


write_points("points.csv", ANGLES, [0.75 * PERIOD])
for angle in ANGLES:
    write_points(f"line_{angle}.csv", [angle], [(i + 0.5) / 16 * PERIOD for i in range(8)])
with open(HERE / "reference.csv", "w", newline="") as file:
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(["set", "angle"] + [f"t_{t}_rho_{r}" for t, r in CASES])
    for kind in ("points", "line"):
        for angle in ANGLES:
            name = kind if kind == "points" else f"line {angle}"
            writer.writerow([name, angle] + [repr(series(t, r, pi * angle / 180)) for t, r in CASES])
