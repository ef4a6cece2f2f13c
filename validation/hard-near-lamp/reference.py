"""Illuminances in a closed room of 4 m x 3 m x 2.5 m, reflectance 0.5, with an isotropic lamp of 1200 lm close below the
ceiling: packets from the lamp, each of whose arrivals shines on the points by Lambert's law (a convex room hides nothing).

Usage: python3 reference.py > reference.csv   (numpy; half a minute)
"""
import numpy as np

SIZE = np.array([4.0, 3.0, 2.5])
RHO, FLUX = 0.5, 1200.0
POINTS = np.array([[2.0, 1.5, 0.8], [3.0, 2.0, 0.8], [0.5, 0.5, 0.8]])
BATCH, BATCHES = 200_000, 60


def follow(origin, direction):
    """Where rays meet the box, and the inward normals there."""
    with np.errstate(divide="ignore", invalid="ignore"):
        t = np.where(direction > 0, (SIZE - origin) / direction, -origin / direction)
    t = np.where(direction == 0, np.inf, t)
    axis = np.argmin(t, axis=1)
    rows = np.arange(len(axis))
    hit = origin + t[rows, axis][:, None] * direction
    sign = np.sign(direction[rows, axis])
    hit[rows, axis] = np.where(sign > 0, SIZE[axis], 0.0)
    normal = np.zeros_like(hit)
    normal[rows, axis] = -sign
    return np.clip(hit, 0, SIZE), normal


def on_sphere(random, count):
    v = random.normal(size=(count, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


print("set,label,exact,standard_error")
for height in (2.4, 2.499, 2.4999):
    lamp = np.array([2.0, 1.5, height])
    to_lamp = lamp - POINTS
    distance = np.linalg.norm(to_lamp, axis=1)
    direct = FLUX / (4 * np.pi) * to_lamp[:, 2] / distance**3
    random = np.random.default_rng(round(height * 1e4))
    means = []
    for _ in range(BATCHES):
        origin, direction = np.tile(lamp, (BATCH, 1)), on_sphere(random, BATCH)
        lx = np.zeros(len(POINTS))
        while len(origin):
            hit, normal = follow(origin, direction)
            for k, point in enumerate(POINTS):
                offset = point - hit
                square = (offset**2).sum(axis=1)
                cosines = np.maximum((offset * normal).sum(axis=1), 0) * np.maximum(-offset[:, 2], 0)
                lx[k] += (FLUX / BATCH * RHO * cosines / (np.pi * square**2)).sum()
            goes_on = random.random(len(hit)) < RHO
            hit, normal = hit[goes_on], normal[goes_on]
            # Lambert's law: a point of the sphere that stands on the surface.
            direction = normal + on_sphere(random, len(hit))
            direction /= np.linalg.norm(direction, axis=1, keepdims=True)
            origin = hit
        means.append(direct + lx)
    means = np.array(means)
    error = means.std(axis=0, ddof=1) / np.sqrt(BATCHES)
    for label, value, spread in zip(("below", "half way", "in a corner"), means.mean(axis=0), error):
        print(f"{height},{label},{value:.5g},{spread:.2g}")
