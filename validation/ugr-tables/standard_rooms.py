#!/usr/bin/env python3
"""UGR of CIE 190's standard rooms by hand, for luminaires given by formulas: writes reference.csv, tables.csv and their photometric files.

    python3 standard_rooms.py

Nothing here comes from luxmc. What the values follow from:

- CIE 117:1995: UGR = 8 log10(0.25/L_b sum L^2 w/p^2); p by bilinear interpolation of its table 4.1 over T/R and H/R;
  luminaires without an index do not count.
- CIE 190:2010: H = 2 m from eye to luminaires; spacing 0.25 H, the first row at half of it from the walls; the observer at
  the middle of a wall, at the height of the reference plane; L_b = E/pi with E the mean indirect illuminance of the walls
  between reference plane and luminaires. Ceiling and floor cavities are planes of the reflectances given.
- Exchange between floor, walls and ceiling, each lit evenly, with form factors of parallel rectangles. For 4H x 8H this
  gives the transfer factors of table 5 of CIE 190 (0.115, 0.211 and 0.307 at 70/50/20), see `check`.
"""
import csv
import math
import pathlib

HEIGHT_M = 2.0
SPACING_M = 0.25 * HEIGHT_M
FOLDER = pathlib.Path(__file__).resolve().parent


def position_indices():
    """CIE 117:1995, table 4.1: rows T/R = 0, 0.1 ... 3, columns H/R = 0, 0.1 ... 1.9; nan where it has no index."""
    rows = [line.split(",") for line in (FOLDER / "position_index.csv").read_text().splitlines()[1:]]
    return [[float(cell) if cell else math.nan for cell in row[1:]] for row in rows]


TABLE = position_indices()


def position_index(along_m, aside_m, up_m):
    t, h = 10 * abs(aside_m) / along_m, 10 * up_m / along_m
    if along_m <= 0 or up_m < 0 or t > 30 or h > 19:
        return math.nan
    i, j = min(int(t), 29), min(int(h), 18)
    u, v = t - i, h - j
    total = 0.0
    for di, dj, weight in ((0, 0, (1 - u) * (1 - v)), (1, 0, u * (1 - v)), (0, 1, (1 - u) * v), (1, 1, u * v)):
        if weight > 0:
            total += weight * TABLE[i + di][j + dj]
    return total


# Luminaires: intensity in cd towards a unit vector (C0 along x, down is -z), extents along C0 and C90 in m.
LUMINAIRES = {
    "panel": (lambda x, y, z: 200 * -z, (0.3, 0.3)),
    "narrow": (lambda x, y, z: 400 * (-z) ** 3, (0.3, 0.2)),
    "batwing": (lambda x, y, z: 120 * -z * (1 + 1.5 * x * x), (0.2, 0.4)),
}


def flux_lm(intensity):
    """Of the lower half space, by the midpoint rule over cos(gamma) and over C."""
    steps, turns = 400, 64
    total = 0.0
    for i in range(steps):
        down = (i + 0.5) / steps
        sine = math.sqrt(1 - down * down)
        for k in range(turns):
            c = 2 * math.pi * k / turns
            total += intensity(sine * math.cos(c), sine * math.sin(c), -down)
    return total * 2 * math.pi / (steps * turns)


def middles(length_m, step_m):
    return [(i + 0.5) * step_m for i in range(round(length_m / step_m))]


def places(x_m, y_m):
    return [(x, y) for y in middles(y_m, SPACING_M) for x in middles(x_m, SPACING_M)]


def floor_flux_lm(intensity, x_m, y_m):
    """Direct flux of all luminaires on the reference plane, by the midpoint rule over it."""
    cell_m = 0.2
    cells = [(x, y) for y in middles(y_m, cell_m) for x in middles(x_m, cell_m)]
    total = 0.0
    for lx, ly in places(x_m, y_m):
        for x, y in cells:
            dx, dy = x - lx, y - ly
            r = math.sqrt(dx * dx + dy * dy + HEIGHT_M**2)
            total += intensity(dx / r, dy / r, -HEIGHT_M / r) / r**3
    return total * HEIGHT_M * cell_m**2


def parallel_rectangles(a_m, b_m, c_m):
    """Form factor between equal parallel rectangles a x b at distance c."""
    x, y = a_m / c_m, b_m / c_m
    x1, y1 = math.sqrt(1 + x * x), math.sqrt(1 + y * y)
    return (
        2
        / (math.pi * x * y)
        * (
            math.log(x1 * y1 / math.sqrt(1 + x * x + y * y))
            + x * y1 * math.atan(x / y1)
            + y * x1 * math.atan(y / x1)
            - x * math.atan(x)
            - y * math.atan(y)
        )
    )


def indirect_wall_lx(x_m, y_m, reflectances, direct_lm):
    """Mean indirect illuminance of the walls from direct flux on ceiling, walls, floor."""
    areas = [x_m * y_m, 2 * HEIGHT_M * (x_m + y_m), x_m * y_m]
    across = parallel_rectangles(x_m, y_m, HEIGHT_M)
    side = 1 - across
    back = side * areas[0] / areas[1]
    factors = [[0, side, across], [back, 1 - 2 * back, back], [across, side, 0]]
    direct_lx = [lm / area for lm, area in zip(direct_lm, areas)]
    total_lx = direct_lx
    for _ in range(200):
        total_lx = [
            direct_lx[i] + sum(factors[i][j] * reflectances[j] * total_lx[j] for j in range(3)) for i in range(3)
        ]
    return total_lx[1] - direct_lx[1]


def glare_sum(intensity, area_m2, x_m, lamps):
    """Sum of L^2 w/p^2 for the observer at the middle of the wall y = 0 who looks along y."""
    glare = 0.0
    for lx, ly in lamps:
        aside_m, along_m = lx - x_m / 2, ly
        p = position_index(along_m, aside_m, HEIGHT_M)
        if math.isnan(p):
            continue
        r = math.sqrt(aside_m**2 + along_m**2 + HEIGHT_M**2)
        cd = intensity(-aside_m / r, -along_m / r, -HEIGHT_M / r)
        projected_m2 = area_m2 * HEIGHT_M / r
        glare += cd * cd / (projected_m2 * r * r) / p**2
    return glare


def rating(name, x_h, y_h, reflectances, turned):
    """The observer looks along y from the middle of the wall y = 0; `turned` luminaires have C0 along y."""
    own, (c0_m, c90_m) = LUMINAIRES[name]
    intensity = (lambda x, y, z: own(y, -x, z)) if turned else own
    x_m, y_m = x_h * HEIGHT_M, y_h * HEIGHT_M
    lamps = places(x_m, y_m)
    all_lm = flux_lm(intensity) * len(lamps)
    on_floor_lm = floor_flux_lm(intensity, x_m, y_m)
    wall_lx = indirect_wall_lx(x_m, y_m, reflectances, [0.0, all_lm - on_floor_lm, on_floor_lm])
    glare = glare_sum(intensity, c0_m * c90_m, x_m, lamps)
    background_cd_m2 = wall_lx / math.pi
    return 8 * math.log10(0.25 / background_cd_m2 * glare), background_cd_m2, glare


def check():
    """Table 5 of CIE 190 for k = 2.67 (4H x 8H)."""
    x_m, y_m = 4 * HEIGHT_M, 8 * HEIGHT_M
    wall_m2 = 2 * HEIGHT_M * (x_m + y_m)
    published = {
        (0.7, 0.5, 0.2): (0.115, 0.211, 0.307),
        (0.7, 0.3, 0.2): (0.106, 0.117, 0.283),
        (0.5, 0.5, 0.2): (0.100, 0.187, 0.211),
        (0.5, 0.3, 0.2): (0.093, 0.104, 0.196),
        (0.3, 0.3, 0.2): (0.081, 0.092, 0.114),
    }
    for reflectances, factors in published.items():
        for source, factor in zip((2, 1, 0), factors):
            direct = [0.0, 0.0, 0.0]
            direct[source] = 1.0
            own = indirect_wall_lx(x_m, y_m, reflectances, direct) * wall_m2
            assert abs(own - factor) < 0.002, (reflectances, source, own, factor)


def write_ies(name):
    """LM-63 file by the formula: gamma in steps of 2.5 degrees, C in steps of 5 degrees."""
    intensity, (c0_m, c90_m) = LUMINAIRES[name]
    gammas = [2.5 * i for i in range(37)]
    planes = [5 * i for i in range(19)]
    lines = ["IESNA:LM-63-2002", "[TEST] by formula", f"[LUMINAIRE] {name}", "TILT=NONE"]
    # Width is along C90, length along C0.
    lines.append(f"1 -1 1 {len(gammas)} {len(planes)} 1 2 {c90_m} {c0_m} 0")
    lines.append("1 1 0")
    lines.append(" ".join(f"{g:g}" for g in gammas))
    lines.append(" ".join(f"{c:g}" for c in planes))
    for c in planes:
        row = []
        for g in gammas:
            s, z = math.sin(math.radians(g)), -math.cos(math.radians(g))
            cd = intensity(s * math.cos(math.radians(c)), s * math.sin(math.radians(c)), z)
            row.append(f"{max(0.0, float(cd)):.6g}")
        lines.append(" ".join(row))
    (FOLDER / f"{name}.ies").write_text("\n".join(lines) + "\n")


# CIE 190:2010, table 4: F_GL of the nineteen rooms X x Y (X across the line of sight), over H.
MULTIPLIERS = {
    (2, 2): (0.690, 0.109, 0.085, -0.016), (2, 3): (0.578, 0.200, 0.127, -0.018), (2, 4): (0.528, 0.218, 0.170, -0.017),
    (2, 6): (0.485, 0.215, 0.222, -0.012), (2, 8): (0.466, 0.207, 0.249, -0.006), (2, 12): (0.448, 0.198, 0.272, 0.005),
    (4, 2): (0.528, 0.218, 0.170, -0.017), (4, 3): (0.394, 0.275, 0.268, -0.020), (4, 4): (0.338, 0.257, 0.351, -0.018),
    (4, 6): (0.296, 0.203, 0.449, -0.006), (4, 8): (0.280, 0.165, 0.499, 0.006), (4, 12): (0.264, 0.125, 0.541, 0.027),
    (8, 4): (0.280, 0.165, 0.499, 0.006), (8, 6): (0.248, 0.058, 0.628, 0.032), (8, 8): (0.239, -0.012, 0.690, 0.058),
    (8, 12): (0.232, -0.084, 0.740, 0.098), (12, 4): (0.264, 0.125, 0.541, 0.027), (12, 6): (0.238, -0.003, 0.677, 0.063),
    (12, 8): (0.232, -0.084, 0.740, 0.098),
}  # fmt: skip
SETS = [(0.7, 0.5, 0.2), (0.7, 0.3, 0.2), (0.5, 0.5, 0.2), (0.5, 0.3, 0.2), (0.3, 0.3, 0.2)]


def zone_lm(intensity, low_deg, high_deg):
    """Flux between two angles, by the midpoint rule over cos(gamma) and over C."""
    steps, turns = 200, 64
    low, high = math.cos(math.radians(high_deg)), math.cos(math.radians(low_deg))
    total = 0.0
    for i in range(steps):
        down = low + (high - low) * (i + 0.5) / steps
        sine = math.sqrt(max(0.0, 1 - down * down))
        for k in range(turns):
            c = 2 * math.pi * k / turns
            total += intensity(sine * math.cos(c), sine * math.sin(c), -down)
    return total * 2 * math.pi * (high - low) / (steps * turns)


def whole_table(name):
    """The UGR table of a luminaire by the standard's formulas: direct flux by F_GL from zones of 10 degrees."""
    own, (c0_m, c90_m) = LUMINAIRES[name]
    zones = [zone_lm(own, 10 * k, 10 * k + 10) for k in range(9)]
    cones = (sum(zones[:4]) + 0.130 * zones[4], sum(zones[:6]), sum(zones[:7]) + 0.547 * zones[7], sum(zones))
    for (x_h, y_h), multipliers in MULTIPLIERS.items():
        x_m, y_m = x_h * HEIGHT_M, y_h * HEIGHT_M
        lamps = places(x_m, y_m)
        on_floor_lm = sum(f * lm for f, lm in zip(multipliers, cones)) * len(lamps)
        sums = []
        for turned in (False, True):
            intensity = (lambda x, y, z: own(y, -x, z)) if turned else own
            sums.append(glare_sum(intensity, c0_m * c90_m, x_m, lamps))
        for viewing, glare in zip(("crosswise", "endwise"), sums):
            for reflectances in SETS:
                direct = [0.0, cones[3] * len(lamps) - on_floor_lm, on_floor_lm]
                background = indirect_wall_lx(x_m, y_m, reflectances, direct) / math.pi
                yield [name, x_h, y_h, viewing, *reflectances, f"{8 * math.log10(0.25 / background * glare):.3f}"]


CASES = [
    ("panel", 4, 8, (0.7, 0.5, 0.2), False),
    ("panel", 8, 4, (0.7, 0.5, 0.2), False),
    ("panel", 4, 8, (0.7, 0.3, 0.2), False),
    ("panel", 4, 8, (0.5, 0.5, 0.2), False),
    ("panel", 4, 8, (0.5, 0.3, 0.2), False),
    ("panel", 4, 8, (0.3, 0.3, 0.2), False),
    ("panel", 2, 2, (0.7, 0.5, 0.2), False),
    ("narrow", 4, 8, (0.7, 0.5, 0.2), False),
    ("narrow", 8, 4, (0.5, 0.3, 0.2), False),
    ("batwing", 4, 8, (0.7, 0.5, 0.2), False),
    ("batwing", 4, 8, (0.7, 0.5, 0.2), True),
]


def run_name(name, x_h, y_h, reflectances, turned):
    """Name of the run in case.json."""
    sides = "/".join(f"{100 * reflectance:.0f}" for reflectance in reflectances)
    return f"{name}{' turned' if turned else ''} {x_h}H x {y_h}H {sides}"


def main():
    check()
    for name in LUMINAIRES:
        write_ies(name)
    with open(FOLDER / "reference.csv", "w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow("luminaire,x_h,y_h,ceiling,walls,floor,turned,ugr,background_luminance_cd_m2,glare_sum_cd2_sr_m4,set".split(","))
        for name, x_h, y_h, reflectances, turned in CASES:
            ugr, background, glare = rating(name, x_h, y_h, reflectances, turned)
            table.writerow([name, x_h, y_h, *reflectances, str(turned).lower(), f"{ugr:.3f}", f"{background:.4f}", f"{glare:.2f}", run_name(name, x_h, y_h, reflectances, turned)])
    with open(FOLDER / "tables.csv", "w", newline="") as file:
        sheet = csv.writer(file, lineterminator="\n")
        sheet.writerow("luminaire,x_h,y_h,viewing,ceiling,walls,floor,ugr".split(","))
        for name in LUMINAIRES:
            sheet.writerows(whole_table(name))


main()
