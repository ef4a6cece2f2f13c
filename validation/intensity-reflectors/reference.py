"""Far-field intensities of a lamp over a diffuse sheet and over a mirror, in closed form.

An isotropic lamp of I = 100 cd hangs over the middle of a rectangle that looks up.

Diffuse sheet of reflectance rho: what falls on it is I * omega, omega the solid angle that it fills for the lamp, and leaves it by
the cosine law: I_reflected = rho * I * omega * cos(theta) / pi. Large mirror: the image, rho * I, over the upper half of space.
Direct light is told at the table's directions, reflected light as the mean over the cells about them.
"""

import csv
import math

PLANES, STEPS, INTENSITY_CD = 4, 12, 100.0
SHEET = dict(half_x=1.0, half_y=0.5, height=0.4, reflectance=0.9)
MIRROR_REFLECTANCE = 0.8


def solid_angle(a, b, h):
    """Solid angle of a rectangle of half sides a and b, seen from the height h over its middle."""
    return 4.0 * math.asin(a * b / math.sqrt((a * a + h * h) * (b * b + h * h)))


def cell(step):
    """Bounds of the angle from the zenith of a cell; gamma is told from the zenith, where the table aims."""
    half = math.pi / STEPS / 2.0
    middle = math.pi * step / STEPS
    return max(middle - half, 0.0), min(middle + half, math.pi)


def mean_over_upper_half(step, antiderivative):
    """Mean over a cell of what shines into the upper half alone; `antiderivative` is that of f(theta) sin(theta)."""
    low, high = cell(step)
    top = min(high, math.pi / 2.0)
    if top <= low:
        return 0.0
    return (antiderivative(top) - antiderivative(low)) / (math.cos(low) - math.cos(high))


def is_hidden(plane, step):
    """Whether the sheet hides the lamp from below in a direction."""
    theta, c = math.pi * step / STEPS, 2.0 * math.pi * plane / PLANES
    if step <= STEPS // 2:
        return False
    reach = SHEET["height"] * math.tan(math.pi - theta)
    return abs(reach * math.cos(c)) < SHEET["half_x"] and abs(reach * math.sin(c)) < SHEET["half_y"]


def directions():
    """Plane and step of every entry in the order of luxmc."""
    yield 0, 0
    for step in range(1, STEPS):
        for plane in range(PLANES):
            yield plane, step
    yield 0, STEPS


omega = solid_angle(SHEET["half_x"], SHEET["half_y"], SHEET["height"])
with open("reference.csv", "w", newline="") as file:
    table = csv.writer(file, lineterminator="\n")
    table.writerow(["set", "c_deg", "gamma_deg", "intensity_cd"])
    for plane, step in directions():
        cosine = mean_over_upper_half(step, lambda theta: 0.5 * math.sin(theta) ** 2)
        direct = 0.0 if is_hidden(plane, step) else INTENSITY_CD
        value = direct + SHEET["reflectance"] * INTENSITY_CD * omega / math.pi * cosine
        table.writerow(["sheet", 360 * plane // PLANES, 180 * step // STEPS, repr(value)])
    for plane, step in directions():
        share = mean_over_upper_half(step, lambda theta: -math.cos(theta))
        direct = INTENSITY_CD if step <= STEPS // 2 else 0.0
        value = direct + MIRROR_REFLECTANCE * INTENSITY_CD * share
        table.writerow(["mirror", 360 * plane // PLANES, 180 * step // STEPS, repr(value)])
