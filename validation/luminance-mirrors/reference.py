#!/usr/bin/env python3
"""Writes reference.csv: what an eye sees of a ball, a floor, a mirror and a pane, drawn by hand.

The ball lights the floor, and so do its images: by the mirror (x = 0, of 0.9), by the pane (y = 3) and by both, which meet at right angles, so
that every place of the floor has each image once and in one order. Behind the pane the ball and its image by the mirror count with what the pane
lets pass. Sheet and floor are so large that nothing ends. A line of sight is followed by the same laws. Directions are those of case.json; one is
refused where the ball may hide an image from the place that is seen.
"""
import json
from math import inf, pi, sqrt

EYE = (3.2, -0.4, 1.7)
BALL, RADIUS, FLUX = (2.0, 1.5, 1.2), 0.1, 1000.0
MIRROR, PANE_Y, INDEX, GLASS, FLOOR = 0.9, 3.0, 1.52, 0.97, 0.5
EXITANCE = FLUX / (4 * pi * RADIUS**2)


def pane(cosine):
    """Reflectance and transmittance of a thin sheet with all inner reflections, the mean of both polarisations."""
    angle_sine = sqrt(1 - cosine**2)
    inside = sqrt(1 - (angle_sine / INDEX) ** 2)
    passed = GLASS ** (1 / inside)
    reflected, through = 0.0, 0.0
    for fresnel in ((cosine - INDEX * inside) / (cosine + INDEX * inside), (INDEX * cosine - inside) / (INDEX * cosine + inside)):
        r = fresnel**2
        reflected += 0.5 * (r + r * (1 - r) ** 2 * passed**2 / (1 - (r * passed) ** 2))
        through += 0.5 * (1 - r) ** 2 * passed / (1 - (r * passed) ** 2)
    return reflected, through


def minus(a, b):
    return tuple(p - q for p, q in zip(a, b))


def dot(a, b):
    return sum(p * q for p, q in zip(a, b))


def plus(a, t, b):
    return tuple(p + t * q for p, q in zip(a, b))


def floor_lx(place):
    images = [(sx, sy, ((-BALL[0] if sx else BALL[0]), (2 * PANE_Y - BALL[1] if sy else BALL[1]), BALL[2])) for sx in (0, 1) for sy in (0, 1)]
    behind = place[1] > PANE_Y
    total = 0.0
    for by_mirror, by_pane, image in images:
        if behind and by_pane:
            continue
        way = minus(image, place)
        for _, _, other in images:
            if other != image:
                along = min(1, max(0, dot(minus(other, place), way) / dot(way, way)))
                beside = minus(plus(place, along, way), other)
                assert dot(beside, beside) > 0.3**2, f"the ball may hide an image from {place}"
        distance = sqrt(dot(way, way))
        reflected, through = pane(abs(way[1]) / distance)
        share = (MIRROR if by_mirror else 1) * (reflected if by_pane else 1) * (through if behind else 1)
        total += share * EXITANCE * (RADIUS / distance) ** 2 * way[2] / distance
    return total


def seen(eye, direction, left=8):
    if left == 0:
        return 0.0

    def to(offset, falling):
        return offset / falling if falling and offset / falling > 1e-9 else inf

    floor, mirror, sheet = to(-eye[2], direction[2]), to(-eye[0], direction[0]), to(PANE_Y - eye[1], direction[1])
    nearest = min(floor, mirror, sheet)
    middle = minus(BALL, eye)
    along = dot(middle, direction)
    beside = minus(plus(eye, along, direction), BALL)
    if 0 < along < nearest and dot(beside, beside) < RADIUS**2:
        return EXITANCE / pi
    if nearest == inf:
        return 0.0
    place = plus(eye, nearest, direction)
    x, y, z = direction
    if nearest == floor:
        return FLOOR / pi * floor_lx(place)
    if nearest == mirror:
        return MIRROR * seen(place, (-x, y, z), left - 1)
    reflected, through = pane(abs(y))
    return reflected * seen(place, (x, -y, z), left - 1) + through * seen(place, direction, left - 1)


if __name__ == "__main__":
    with open("case.json") as file:
        receivers = json.load(file)["scene"]["receivers"]
    with open("reference.csv", "w") as file:
        file.write("set,luminance_cd_m2\n")
        for receiver in receivers:
            for direction in receiver["directions"]:
                length = sqrt(dot(direction, direction))
                file.write(f"{receiver['name']},{seen(EYE, tuple(part / length for part in direction)):.9g}\n")
