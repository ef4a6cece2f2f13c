"""Makes inner.obj: a sphere of radius 0.5 seen from outside, of rings between circles of latitude."""
from math import cos, pi, sin
from pathlib import Path

RINGS, SECTORS, RADIUS = 14, 24, 0.5


def point(ring, sector):
    polar, azimuth = pi * ring / RINGS, 2 * pi * sector / SECTORS
    return RADIUS * sin(polar) * cos(azimuth), RADIUS * sin(polar) * sin(azimuth), RADIUS * cos(polar)


def number(ring, sector):
    if ring in (0, RINGS):
        return 1 if ring == 0 else 2
    return 3 + (ring - 1) * SECTORS + sector % SECTORS


lines = ["# Sphere of radius 0.5 seen from outside, made by mesh.py.", f"v 0 0 {RADIUS}", f"v 0 0 {-RADIUS}"]
lines += ["v %.17g %.17g %.17g" % point(ring, sector) for ring in range(1, RINGS) for sector in range(SECTORS)]
for ring in range(RINGS):
    for sector in range(SECTORS):
        a, b = number(ring, sector), number(ring, sector + 1)
        c, d = number(ring + 1, sector + 1), number(ring + 1, sector)
        if ring > 0:
            lines.append(f"f {a} {c} {b}")
        if ring < RINGS - 1:
            lines.append(f"f {a} {d} {c}")
Path(__file__).with_name("inner.obj").write_text("\n".join(lines) + "\n")
