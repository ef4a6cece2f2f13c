"""A point source between two parallel mirrors x = 0 and x = 4: sums over its images at 8k + 1 and 8k - 1."""
import csv
from math import pi
from pathlib import Path

HERE = Path(__file__).parent
PLACES = [0.5, 1.0, 2.0, 3.0, 3.5]
REFLECTANCES = [0.5, 0.9, 0.99]
INTENSITY = 10_000 / (4 * pi)
HEIGHT = 2.0


def illuminance(x, reflectance):
    total = 0.0
    for k in range(-4000, 4001):
        for image, bounces in ((8 * k + 1, abs(2 * k)), (8 * k - 1, abs(2 * k - 1))):
            total += reflectance**bounces * INTENSITY * HEIGHT / ((x - image) ** 2 + HEIGHT**2) ** 1.5
    return total


with open(HERE / "reference.csv", "w", newline="") as file:
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(["x", "y", "z"] + [f"rho_{r}" for r in REFLECTANCES])
    for x in PLACES:
        writer.writerow([x, 0.0, 0.0] + [repr(illuminance(x, r)) for r in REFLECTANCES])
with open(HERE / "points.csv", "w", newline="") as file:
    file.write("x,y,z,nx,ny,nz\n" + "".join(f"{x},0,0,0,0,1\n" for x in PLACES))
