"""Makes sphere.obj: a unit sphere seen from inside, of rings between circles of latitude, cut at the equator."""
from math import cos, pi, sin
from pathlib import Path

RINGS, SECTORS = 64, 96


def point(ring, sector):
    polar, azimuth = pi * ring / RINGS, 2 * pi * sector / SECTORS
    z = 0.0 if 2 * ring == RINGS else cos(polar)
    return sin(polar) * cos(azimuth), sin(polar) * sin(azimuth), z


lines = ["# Unit sphere seen from inside; upper and lower half, made by mesh.py."]
lines += ["v 0 0 1", "v 0 0 -1"]
lines += ["v %.17g %.17g %.17g" % point(ring, sector) for ring in range(1, RINGS) for sector in range(SECTORS)]


def number(ring, sector):
    if ring in (0, RINGS):
        return 1 if ring == 0 else 2
    return 3 + (ring - 1) * SECTORS + sector % SECTORS


for ring in range(RINGS):
    if ring == 0 or 2 * ring == RINGS:
        lines.append("usemtl " + ("upper" if ring == 0 else "lower"))
    for sector in range(SECTORS):
        a, b = number(ring, sector), number(ring, sector + 1)
        c, d = number(ring + 1, sector + 1), number(ring + 1, sector)
        if ring > 0:
            lines.append(f"f {a} {b} {c}")
        if ring < RINGS - 1:
            lines.append(f"f {a} {c} {d}")
Path(__file__).with_name("sphere.obj").write_text("\n".join(lines) + "\n")
