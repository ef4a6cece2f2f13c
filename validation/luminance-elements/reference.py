#!/usr/bin/env python3
"""Writes reference.csv: the luminance of elements towards an eye, by hand.

A point source and its image by a mirror (x = 0, of 0.9) light a diffuse floor and a glossy plate, both in z = 0, which see neither each other nor
themselves: a standing mirror leaves the height of a ray as it is. An element of the floor has ρ E/π; one of the plate the lobe and what makes up for
its losses besides (docs/methods.md, section 9); one of the mirror shows the floor where its image lies. Elements are the two triangles of each
rectangle, and are looked at in their middles.
"""
from math import cos, pi, sqrt

EYE = (1.0, 1.5, 3.0)
LAMP, INTENSITY = (1.5, 0.5, 2.0), 1000.0
MIRROR, FLOOR = 0.9, 0.5
DIFFUSE, GLOSS, EXPONENT = 0.3, 0.2, 20.0


def unit(a, b):
    """Direction and distance from a to b."""
    way = tuple(q - p for p, q in zip(a, b))
    length = sqrt(sum(p * p for p in way))
    return tuple(p / length for p in way), length


def middles(origin, u, v):
    """Of the two triangles of a rectangle."""
    corner = [tuple(o + i * p + j * q for o, p, q in zip(origin, u, v)) for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))]
    return [tuple(sum(c) / 3 for c in zip(corner[0], corner[k], corner[k + 1])) for k in (1, 2)]


def sources(place):
    """Direction to the lamp and to its image, and the illuminance by each."""
    for lamp, share in ((LAMP, 1.0), ((-LAMP[0], LAMP[1], LAMP[2]), MIRROR)):
        towards, distance = unit(place, lamp)
        yield towards, share * INTENSITY * towards[2] / distance**2


def kept(cosine, steps=600):
    """Share of a lobe of 1 over the larger cosine that goes up, for light at an angle of this cosine."""
    sine = sqrt(1 - cosine**2)
    total = 0.0
    for i in range(steps):
        to_mirrored = ((i + 0.5) / steps) ** (1 / (EXPONENT + 1))
        across = sqrt(1 - to_mirrored**2)
        for j in range(steps):
            out = to_mirrored * cosine + across * sine * cos(2 * pi * (j + 0.5) / steps)
            total += max(out, 0.0) / max(cosine, out)
    return total / steps**2


def plate(place):
    leaving, _ = unit(place, EYE)
    mean = sum(2 * (k + 0.5) / 200 * (1 - kept((k + 0.5) / 200, 120)) / 200 for k in range(200))
    luminance = 0.0
    for towards, lx in sources(place):
        alpha = max(-towards[0] * leaving[0] - towards[1] * leaving[1] + towards[2] * leaving[2], 0.0)
        lobe = GLOSS * (EXPONENT + 1) / (2 * pi) * alpha**EXPONENT / max(towards[2], leaving[2])
        rest = GLOSS * (1 - kept(towards[2])) * (1 - kept(leaving[2])) / (pi * mean)
        luminance += (DIFFUSE / pi + lobe + rest) * lx
    return luminance


def floor(place):
    return FLOOR / pi * sum(lx for _, lx in sources(place))


def mirror(place):
    image = (-EYE[0], EYE[1], EYE[2])
    beyond = place[2] / (image[2] - place[2])
    spot = tuple(p + beyond * (p - q) for p, q in zip(place, image))
    assert 0 < spot[0] < 2 and -1 < spot[1] < 2
    return MIRROR * floor(spot)


rows = [("floor", floor(p)) for p in middles((0, -1, 0), (2, 0, 0), (0, 3, 0))]
rows += [("plate", plate(p)) for p in middles((2.5, -1, 0), (1, 0, 0), (0, 2, 0))]
rows += [("mirror", mirror(p)) for p in middles((0, -1, 0), (0, 4, 0), (0, 0, 1.5))]
with open("reference.csv", "w") as file:
    file.write("set,luminance_cd_m2\n")
    file.writelines(f"{name},{luminance:.9g}\n" for name, luminance in rows)
