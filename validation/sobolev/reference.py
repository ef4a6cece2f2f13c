"""Makes reference.csv: Sobolev's two planes in multiple precision, independent of luxmc.

Run: pip install mpmath (gmpy2 makes it fast), then: python3 reference.py > reference.csv   (five minutes)

The reflected illuminance is an integral along a path from 0 to infinity in the right half-plane of k,

    E1 = Re Int k G(k) H(kr) dk,   G = rho2 kappa (rho1 kappa e^(-h1 k) + e^(-h2 k)) / (1 - rho1 rho2 kappa^2),

with kappa = k K1(k) and H = J0 on the real axis, or H = H0^(1), the Hankel function, on a path above it. Two paths are
used: the real axis for r < 5, and the straight line k = s (1 + i)/sqrt(2) for r >= 2; luxmc uses another path for
large r (up the imaginary axis). In between both are computed and must agree to 1e-24. The line crosses no pole: all
zeros of 1 - rho1 rho2 kappa^2 in the right half-plane lie near or left of the imaginary axis. The loss of digits at large r
(8 at r = 10^4) is paid for with 50 digits of working precision.

Every panel [a, 2a] takes 40 Gauss-Legendre nodes; the same sums with 32 nodes must agree to 1e-27.
Inputs are the doubles nearest to the written decimals, since at reflectance 0.9999 the answer amplifies a
difference in the reflectance ten thousand times.
"""

import sys

from mpmath import mp, mpf, mpc, besselj, besselk, hankel1, exp, sqrt

mp.dps = 50

HEIGHTS = [1e-3, 0.3, 0.5, 0.999]
REFLECTANCES = [(0.5, 0.5), (0.2, 0.7), (0.9999, 0.9999), (0.0, 0.6), (0.6, 0.0), (1.0, 0.9), (0.4, 0.4),
                (0.99, 0.99), (1e-3, 2e-3), (0.9999, 1.0)]
RADII = [0.0, 1e-3, 0.1, 1.0, 2.5, 3.0, 4.5, 7.0, 10.0, 25.0, 100.0, 1e3, 1e4]
REAL_BELOW, LINE_FROM = 5.0, 2.0


def outgoing(z):
    """H0^(1)(z): by mpmath, and where that is slow, from |z| = 60, by Hankel's expansion (smallest term e^-120)."""
    if z.imag > 150:
        return mpf(0)  # below e^-150, against results above 1e-13
    if abs(z) < 60:
        return hankel1(0, z)
    term = total = mpc(1)
    for n in range(1, 200):
        following = term * (2 * n - 1) ** 2 / (n * 8 * mpc(0, 1) * z)
        if abs(following) > abs(term) or abs(following) < mpf(10) ** -mp.dps:
            break
        term = following
        total += term
    return sqrt(2 / (mp.pi * z)) * exp(mpc(0, 1) * (z - mp.pi / 4)) * total


def legendre_rule(n):
    """Nodes and weights on [-1, 1] by Newton's method."""
    nodes = []
    for i in range(n):
        x = mp.cos(mp.pi * (i + mpf(3) / 4) / (n + mpf(1) / 2))
        for _ in range(60):
            p0, p1 = mpf(1), x
            for m in range(2, n + 1):
                p0, p1 = p1, ((2 * m - 1) * x * p1 - (m - 1) * p0) / m
            slope = n * (x * p1 - p0) / (x * x - 1)
            step = p1 / slope
            x -= step
            if abs(step) < mpf(10) ** (-mp.dps + 5):
                break
        nodes.append((x, 2 / ((1 - x * x) * slope * slope)))
    return nodes


def panels(width):
    edges = [mpf(0)] + [mpf(2) ** e for e in range(-66, 1)]
    while edges[-1] < 64:
        edges.append(edges[-1] + width)
    return list(zip(edges, edges[1:]))


def path(n, direction, width):
    """Points k and complex weights dk along a straight line from 0."""
    rule = legendre_rule(n)
    out = []
    for a, b in panels(width):
        for x, w in rule:
            s = (a + b) / 2 + (b - a) / 2 * x
            out.append((s * direction, w * (b - a) / 2 * direction))
    return out


class Path:
    def __init__(self, n, direction, wave, width):
        self.points = path(n, direction, width)
        self.kappa = [k * besselk(1, k) for k, _ in self.points]
        self.fall = {}
        self.wave, self.waves = wave, {}

    def falls(self, h):
        if h not in self.fall:
            self.fall[h] = [exp(-h * k) for k, _ in self.points]
        return self.fall[h]

    def kernel(self, r):
        if r not in self.waves:
            self.waves[r] = [w * k * self.wave(k * r) for k, w in self.points]
        return self.waves[r]

    def g(self, h1, h2, rho1, rho2):
        return [rho2 * q * (rho1 * q * e1 + e2) / (1 - rho1 * rho2 * q * q)
                for q, e1, e2 in zip(self.kappa, self.falls(h1), self.falls(h2))]


def dot(a, b):
    return mp.fdot(a, b).real


def main():
    line = mpc(1, 1) / sqrt(mpf(2))
    real = [Path(n, mpf(1), lambda z: besselj(0, z), 2) for n in (40, 32)]
    turned = [Path(n, line, outgoing, 2) for n in (40, 32)]
    worst_rule, worst_paths = mpf(0), mpf(0)
    print("plane,h1,rho1,rho2,r,direct_lx,reflected_lx")
    for h in HEIGHTS:
        for rhos in REFLECTANCES:
            for plane in (1, 2):
                h1, h2 = mpf(h), 1 - mpf(h)
                rho1, rho2 = mpf(rhos[0]), mpf(rhos[1])
                if plane == 2:
                    h1, h2, rho1, rho2 = h2, h1, rho2, rho1
                gs = [p.g(h1, h2, rho1, rho2) for p in real + turned]
                for radius in RADII:
                    r = mpf(radius)
                    direct = h1 / sqrt(h1 * h1 + r * r) ** 3
                    values = []
                    if radius < REAL_BELOW:
                        values.append([dot(p.kernel(r), g) for p, g in zip(real, gs[:2])])
                    if radius >= LINE_FROM:
                        values.append([dot(p.kernel(r), g) for p, g in zip(turned, gs[2:])])
                    best = values[0][0]
                    if best != 0:
                        worst_rule = max([worst_rule] + [abs(v[1] / v[0] - 1) for v in values])
                        worst_paths = max([worst_paths] + [abs(v[0] / best - 1) for v in values])
                    print(f"{plane},{h!r},{rhos[0]!r},{rhos[1]!r},{radius!r},"
                          f"{mp.nstr(direct, 25, min_fixed=0, max_fixed=0)},"
                          f"{mp.nstr(best, 25, min_fixed=0, max_fixed=0)}")
                    sys.stdout.flush()
    print(f"40 against 32 nodes: {mp.nstr(worst_rule, 3)}, real axis against line: {mp.nstr(worst_paths, 3)}", file=sys.stderr)
    assert worst_rule < mpf(10) ** -27 and worst_paths < mpf(10) ** -24


main()
