#!/usr/bin/env python3
"""Writes sphere.csv: a unit sphere about (0, 0, 0), told by its radius from a centre 0.3 m beside it, as harmonics of degree 10.

With d = 0.3 and the angle g from the direction u in which the sphere's centre lies, r(g) = d cos g + sqrt(1 - d^2 sin^2 g) = sum a_l P_l(cos g),
and by the addition theorem c_lm = 4 pi/(2l + 1) a_l Y_lm(u). What degree 10 leaves out is below 1e-6 of the radius.
"""
from math import atan2, cos, factorial, pi, sin, sqrt

DEGREE, DISTANCE_M = 10, 0.3
U = (0.48, -0.6, 0.64)


def legendre(l, x):
    before, here = 1.0, x
    if l == 0:
        return before
    for k in range(1, l):
        before, here = here, ((2 * k + 1) * x * here - k * before) / (k + 1)
    return here


def associated(l, m, x):
    """P_l^m without the sign (-1)^m."""
    here, before = 1.0, 0.0
    for k in range(1, m + 1):
        here *= (2 * k - 1) * sqrt(1 - x * x)
    for k in range(m + 1, l + 1):
        before, here = here, ((2 * k - 1) * x * here - (k - 1 + m) * before) / (k - m)
    return here


def harmonic(l, m, u):
    k = abs(m)
    norm = sqrt((2 * l + 1) / (4 * pi) * factorial(l - k) / factorial(l + k))
    phi = atan2(u[1], u[0])
    turn = 1.0 if m == 0 else sqrt(2) * (cos(k * phi) if m > 0 else sin(k * phi))
    return norm * associated(l, k, u[2]) * turn


def radius_m(x):
    return DISTANCE_M * x + sqrt(1 - DISTANCE_M**2 * (1 - x * x))


def part(l, steps=20000):
    """a_l by Simpson's rule; the integrand is smooth."""
    total = 0.0
    for i in range(steps + 1):
        x = -1 + 2 * i / steps
        weight = 1 if i in (0, steps) else 4 if i % 2 else 2
        total += weight * radius_m(x) * legendre(l, x)
    return (2 * l + 1) / 2 * total * 2 / steps / 3


with open("sphere.csv", "w") as file:
    file.write("l,m,coefficient\n")
    for l in range(DEGREE + 1):
        scale = 4 * pi / (2 * l + 1) * part(l)
        for m in range(-l, l + 1):
            file.write(f"{l},{m},{scale * harmonic(l, m, U):.15g}\n")

left_out = max(abs(radius_m(x / 500) - sum(part(l, 2000) * legendre(l, x / 500) for l in range(DEGREE + 1))) for x in range(-500, 501, 50))
print(f"left out: {left_out:.1e} m")
