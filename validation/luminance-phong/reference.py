"""Luminance of glossy planes over the angle: walks of their own, in numpy, for Sobolev's planes with Phong's law.

Two square planes of half side 100 m, 1 m apart, an isotropic lamp of 1 cd halfway between them. An eye 10 mm above the lower plane looks
down on it, 1 m beside the lamp's foot. The reflection is luxmc's law, written anew (docs/methods.md, section 9):

    f = rho_d/pi + rho_s [ (n+1)/(2 pi) cos^n(alpha) / max(cos_i, cos_o) + (1-R_i)(1-R_o) / (pi (1-R_mean)) ]

R, the reflectance of the first term alone, is a quadrature here. Walks go backward from the eye; at every surface the lamp is looked at,
and the next direction is drawn from an even mixture of the cosine law and the lobe, so that its weight is f cos / pdf.
"""

import csv

import numpy as np

RHO_D, RHO_S, EXPONENT = 0.3, 0.4, 20
HALF_M, LAMP = 100.0, np.array([0.0, 0.0, 0.5])
EYE = np.array([1.0, 0.0, 0.01])
ANGLES_DEG = np.linspace(-75.0, 75.0, 13)
WALKS, SEED, BATCHES = 400_000, 20151, 10


def lobe_reflectance(cos_in):
    """R by the midpoint rule over the half space."""
    steps = 1500
    cos_out = (np.arange(steps) + 0.5) / steps
    turn = np.pi * (np.arange(steps) + 0.5) / steps
    sin_in, sin_out = np.sqrt(1 - cos_in**2), np.sqrt(1 - cos_out**2)
    alpha = cos_in * cos_out[:, None] + sin_in * sin_out[:, None] * np.cos(turn)[None, :]
    kernel = np.maximum(alpha, 0.0) ** EXPONENT * (cos_out / np.maximum(cos_in, cos_out))[:, None]
    return (EXPONENT + 1) / np.pi * kernel.mean() * np.pi


NODES = np.linspace(0.0, 1.0, 401)
MISSING = 1.0 - np.array([lobe_reflectance(max(c, 1e-6)) for c in NODES])
MISSING_MEAN = np.trapezoid(2 * NODES * MISSING, NODES)


def missing(cosine):
    return np.interp(cosine, NODES, MISSING)


def brdf(cos_in, cos_out, cos_alpha):
    lobe = (EXPONENT + 1) / (2 * np.pi) * np.maximum(cos_alpha, 0) ** EXPONENT / np.maximum(cos_in, cos_out)
    rest = missing(cos_in) * missing(cos_out) / (np.pi * MISSING_MEAN)
    return RHO_D / np.pi + RHO_S * (lobe + rest)


def about(axis, cosine, turn):
    """Directions at an angle from an axis."""
    helper = np.where(np.abs(axis[:, :1]) > 0.5, [[0.0, 1.0, 0.0]], [[1.0, 0.0, 0.0]])
    first = np.cross(axis, helper)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(axis, first)
    sine = np.sqrt(np.maximum(1 - cosine**2, 0))
    return cosine[:, None] * axis + (sine * np.cos(turn))[:, None] * first + (sine * np.sin(turn))[:, None] * second


def walks(direction, count, rng):
    """Mean luminance in cd/m2 of light reflected once, and of all that was reflected more often."""
    place = np.repeat(EYE[None], count, axis=0)
    towards = np.repeat(direction[None], count, axis=0)
    weight = np.ones(count)
    once, often = 0.0, 0.0
    for order in range(1, 400):
        # To the next plane; beyond its edge nothing comes from anywhere.
        up = towards[:, 2] > 0
        reach = np.where(up, 1 - place[:, 2], -place[:, 2]) / towards[:, 2]
        place = place + reach[:, None] * towards
        inside = (np.abs(place[:, :2]) < HALF_M).all(axis=1)
        place, towards, weight, up = place[inside], towards[inside], weight[inside], up[inside]
        if len(weight) == 0:
            break
        place[:, 2] = np.where(up, 1.0, 0.0)
        normal_z = np.where(up, -1.0, 1.0)
        cos_eye = np.abs(towards[:, 2])
        mirror = towards * [1, 1, -1]
        # The lamp.
        offset = LAMP - place
        square = (offset**2).sum(axis=1)
        to_lamp = offset / np.sqrt(square)[:, None]
        cos_lamp = to_lamp[:, 2] * normal_z
        found = weight * brdf(cos_lamp, cos_eye, (mirror * to_lamp).sum(axis=1)) * cos_lamp / square
        if order == 1:
            once += found.sum() / count
        else:
            often += found.sum() / count
        # The next direction.
        size = len(weight)
        by_lobe = rng.random(size) < 0.5
        turn = 2 * np.pi * rng.random(size)
        u = rng.random(size)
        normal = np.zeros((size, 3))
        normal[:, 2] = normal_z
        axis = np.where(by_lobe[:, None], mirror, normal)
        cosine = np.where(by_lobe, u ** (1 / (EXPONENT + 1)), np.sqrt(u))
        onward = about(axis, cosine, turn)
        cos_next = onward[:, 2] * normal_z
        cos_alpha = (mirror * onward).sum(axis=1)
        pdf = 0.5 * np.maximum(cos_next, 0) / np.pi
        pdf += 0.5 * (EXPONENT + 1) / (2 * np.pi) * np.maximum(cos_alpha, 0) ** EXPONENT
        safe = np.maximum(cos_next, 1e-9)
        weight = np.where(cos_next > 1e-9, weight * brdf(safe, cos_eye, cos_alpha) * safe / pdf, 0.0)
        # Roulette keeps the mean.
        stays = np.minimum(1.0, weight)
        kept = rng.random(size) < stays
        place, towards = place[kept], onward[kept]
        weight = weight[kept] / stays[kept]
    return once, often


rng = np.random.default_rng(SEED)
with open("reference.csv", "w", newline="") as file:
    table = csv.writer(file, lineterminator="\n")
    table.writerow(["angle_deg", "total_cd_m2", "multiple_cd_m2", "standard_error_cd_m2"])
    for angle_deg in ANGLES_DEG:
        # A positive angle turns the line of sight from -z about the axis y, as a fan does.
        angle = np.radians(angle_deg)
        direction = np.array([-np.sin(angle), 0.0, -np.cos(angle)])
        batches = [walks(direction, WALKS // BATCHES, rng) for _ in range(BATCHES)]
        once = np.mean([batch[0] for batch in batches])
        often = np.array([batch[1] for batch in batches])
        error = often.std(ddof=1) / np.sqrt(BATCHES)
        table.writerow([angle_deg, f"{once + often.mean():.9g}", f"{often.mean():.9g}", f"{error:.3g}"])
