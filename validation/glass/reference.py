"""Transmittance of a clear pane at 0 to 80 degrees: all inner reflections, beside CIE 171's column (Schlick, one interface)."""
import csv
from math import cos, pi, radians, sin, sqrt, tan
from pathlib import Path

HERE = Path(__file__).parent
INDEX, INTENSITY, HEIGHT = 1.52, 1000.0, 2.0
CIE = [.96, .96, .96, .96, .96, .95, .93, .84, .59]


def transmittance(degrees):
    c = cos(radians(degrees))
    inside = sqrt(1 - (sin(radians(degrees)) / INDEX) ** 2)
    faces = [((c - INDEX * inside) / (c + INDEX * inside)) ** 2, ((INDEX * c - inside) / (INDEX * c + inside)) ** 2]
    return sum((1 - r) / (1 + r) for r in faces) / 2


with open(HERE / "reference.csv", "w", newline="") as file:
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(["angle", "x", "y", "z", "transmittance", "pane", "cie"])
    for step, published in enumerate(CIE):
        degrees = 10 * step
        x = HEIGHT * tan(radians(degrees))
        clear = INTENSITY * cos(radians(degrees)) ** 3 / HEIGHT**2
        writer.writerow([degrees, repr(x), 0.0, 0.0, repr(transmittance(degrees)),
                         repr(transmittance(degrees) * clear), repr(published * clear)])
with open(HERE / "points.csv", "w", newline="") as file:
    file.write("x,y,z,nx,ny,nz\n")
    for step in range(9):
        file.write(f"{HEIGHT * tan(radians(10 * step))!r},0,0,0,0,1\n")
