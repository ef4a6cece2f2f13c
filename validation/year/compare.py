"""Errors of a year of daylight that its replicas do not show: hours of the year against runs of `luxmc solve`, and against years of single hours.

    python3 validation/year/compare.py patches --out out/year-check     the sky in patches of uniform luminance, MF 1 to 4
    python3 validation/year/compare.py suns --out out/year-check        reflected light of the sun, from nodes on its paths
    python3 validation/year/compare.py hours --out out/year-check       whether the stated errors of hours hold, mostly with a low sun

Rooms: scenes/daylight-office.json, scenes/atrium.json, and a room with a reveal of 0.5 m and slats before its window. Each has a few points. The tables
of patches give root mean squares, after subtraction of the errors that both runs state. Sky and sun are compared separately: for the skies small black
squares far away hide the suns, and the suns shine in a sky of 1 lx. A year of few hours has the suns of these hours as nodes and the same walks as the
whole year, so nearly all of the difference between the two is the error of the nodes. `hours` draws some hours of a year by a seed, two of three with the
sun below 20 degrees. It computes them again in a year of these hours alone, with other walks, to a third of the error: 95 % of them should lie within 2.13
combined errors (Student's t of 15 degrees of freedom). The sky has 1000 lx. The ground is black.
All tables are Markdown. Needs only Python.
"""
import argparse
import csv
import json
import math
import pathlib
import random
import statistics
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
SITE = ["latitude_deg,52", "longitude_deg,13", "time_zone_hours,1"]
# Month, day, middle of the hour, lx of the sun across its rays and of the sky on a plane.
SKIES = [(3, 10, 12.5, 70_000, 14_000), (6, 21, 9.5, 80_000, 12_000), (12, 15, 12.5, 40_000, 9_000), (9, 5, 15.5, 30_000, 25_000),
         (4, 20, 10.5, 5_000, 30_000), (11, 10, 13.5, 0, 12_000), (7, 1, 17.5, 50_000, 10_000), (2, 1, 10.5, 20_000, 10_000)]
SUN_LX = 100_000
FAR_M = 4000
# Error of a point over its value from which on a rim of the sun is seen from it, and over how many medians of the plane the sun lights it straight.
RIM, BRIGHT = 0.1, 3
DAYS = [(1, 20), (3, 5), (5, 25), (8, 3), (11, 1)]
HOURS = [9.5, 12.5, 15.5]
# Elevations in degrees between which two of three drawn hours lie, and the least of all; errors within which 95 % of differences are.
LOW_DEG, LEAST_DEG, T_15 = 20, 2, 2.13
CLEAR_SKY_LX = 1000
LENGTHS = [31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31]


def rectangle(name, origin, u, v, material="paint", two_sided=False):
    return {"name": name, "type": "rectangle", "origin": origin, "u": u, "v": v, "material": material, "two_sided": two_sided}


def slats():
    """4 m × 4 m × 3 m, a window of 3 m × 1.5 m to the south in a reveal, and before it slats of 8 cm turned by 30°."""
    parts = [rectangle("floor", [0, 0, 0], [4, 0, 0], [0, 4, 0]), rectangle("ceiling", [0, 0, 3], [0, 4, 0], [4, 0, 0]),
             rectangle("back", [0, 4, 0], [4, 0, 0], [0, 0, 3]), rectangle("left", [0, 0, 0], [0, 4, 0], [0, 0, 3]),
             rectangle("right", [4, 0, 0], [0, 0, 3], [0, 4, 0]), rectangle("front 1", [0, 0, 0], [0, 0, 3], [.5, 0, 0]),
             rectangle("front 2", [3.5, 0, 0], [0, 0, 3], [.5, 0, 0]), rectangle("front 3", [.5, 0, 0], [0, 0, 1], [3, 0, 0]),
             rectangle("front 4", [.5, 0, 2.5], [0, 0, .5], [3, 0, 0]), rectangle("sill", [.5, -.5, 1], [3, 0, 0], [0, .5, 0]),
             rectangle("soffit", [.5, -.5, 2.5], [0, .5, 0], [3, 0, 0]), rectangle("reveal 1", [.5, -.5, 1], [0, .5, 0], [0, 0, 1.5]),
             rectangle("reveal 2", [3.5, -.5, 1], [0, 0, 1.5], [0, .5, 0])]
    for number in range(15):
        parts.append(rectangle(f"slat {number + 1}", [.5, -.6, 1.03 + .1 * number], [3, 0, 0], [0, .07, .04], two_sided=True))
    return {"version": 1, "materials": {"paint": {"type": "diffuse", "reflectance": 0.6}}, "geometry": parts, "luminaires": [], "receivers": []}


def grid(name, origin, u, v, columns, rows):
    return {"name": name, "type": "grid", "origin": origin, "u": u, "v": v, "columns": columns, "rows": rows}


def rooms():
    office = json.loads((ROOT / "scenes/daylight-office.json").read_text())
    office["receivers"] = [grid("plane", [.5, .5, .85], [4, 0, 0], [0, 5.5, 0], 3, 4)]
    atrium = json.loads((ROOT / "scenes/atrium.json").read_text())
    atrium["receivers"] = [grid("plane", [2, 1, .85], [16, 0, 0], [0, 10, 0], 4, 3)]
    blinds = slats()
    blinds["receivers"] = [grid("plane", [.5, .5, .85], [3, 0, 0], [0, 3, 0], 3, 4)]
    for scene in (office, atrium, blinds):
        scene["materials"]["black"] = {"type": "diffuse", "reflectance": 0}
    return {"office": office, "atrium": atrium, "reveal and slats": blinds}


def towards(hour):
    height, turn = (math.radians(float(hour[key])) for key in ("sun_elevation_deg", "sun_azimuth_deg"))
    return [math.cos(height) * math.sin(turn), math.cos(height) * math.cos(turn), math.sin(height)]


def cover(number, sun, middle):
    """A black square of 0.9° before the sun, so far that it hides it from a whole room about `middle`."""
    across = [-sun[1], sun[0], 0]
    length = math.hypot(*across)
    across = [a / length for a in across]
    up = [sun[1] * across[2] - sun[2] * across[1], sun[2] * across[0] - sun[0] * across[2], sun[0] * across[1] - sun[1] * across[0]]
    half = FAR_M * math.tan(math.radians(.45))
    corner = [m + FAR_M * s - half * (a + b) for m, s, a, b in zip(middle, sun, across, up)]
    return rectangle(f"cover {number}", corner, [2 * half * a for a in across], [2 * half * b for b in up], "black", True)


class Check:
    def __init__(self, arguments):
        self.luxmc, self.out = arguments.luxmc, pathlib.Path(arguments.out)
        self.out.mkdir(parents=True, exist_ok=True)
        self.rooms = [(name, scene) for name, scene in rooms().items() if arguments.room in (None, name)]

    def run(self, command, scene, luminaires, name, *more):
        path = self.out / f"{name}.json"
        path.write_text(json.dumps(dict(scene, luminaires=luminaires)))
        ended = subprocess.run([self.luxmc, command, path, "--out", self.out / name, "--quiet", *map(str, more)], capture_output=True, text=True)
        if ended.returncode not in (0, 1, 3):
            raise SystemExit(ended.stderr)
        return self.out / name

    def year(self, scene, hours, name, target, subdivision=2, more=()):
        """Of each hour its row and every point's lx with its error; and what the year says of itself."""
        weather = self.out / "weather.csv"
        rows = [f"{month},{day},{hour},{sun},{sky}" for month, day, hour, sun, sky in hours]
        columns = "month,day,hour,direct_normal_illuminance_lx,diffuse_horizontal_illuminance_lx"
        weather.write_text("\n".join([*SITE, columns, *rows]) + "\n")
        sky = {"name": "sky", "type": "sky", "luminance_distribution": "overcast", "horizontal_illuminance_lx": 1000}
        out = self.run("year", scene, [sky], name, "--weather", weather, "--target-error", target, "--hourly", "--occupied", "0-24",
                       "--sky-subdivision", subdivision, *more)
        lit = list(csv.DictReader((out / "year-hours.csv").open()))
        both = [[list(map(float, row[4:])) for row in list(csv.reader((out / f"hourly{part}-plane.csv").open()))[1:]] for part in ("", "-error")]
        found = {(int(hour["month"]), int(hour["day"]), float(hour["hour"])): (hour, [[point[k] for point in part] for part in both])
                 for k, hour in enumerate(lit)}
        return found, json.loads((out / "summary.json").read_text())

    def solve(self, scene, luminaire, name, target):
        """lx, errors and direct lx of every point."""
        out = self.run("solve", scene, [luminaire], name, "--maps", "receivers", "--target-error", target)
        rows = list(csv.DictReader((out / "receivers.csv").open()))
        return [[float(row[key]) for row in rows] for key in ("illuminance_lx", "standard_error_lx", "direct_lx")]


def left(pairs):
    """Root mean square of differences without what both errors leave, and what these leave, both over the root mean square."""
    squares = sum((a - b) ** 2 for (a, _), (b, _) in pairs)
    noise = sum(s ** 2 + t ** 2 for (_, s), (_, t) in pairs)
    all_lx = sum(b ** 2 for _, (b, _) in pairs)
    return (squares - noise) / all_lx, math.sqrt(noise / all_lx)


def signed_root(square):
    return math.copysign(math.sqrt(abs(square)), square)


def patches(check, target):
    print("| room | MF | patches | stated, median hour | found, median hour | worst hour | errors of both runs |\n| --- | --- | --- | --- | --- | --- | --- |")
    for name, scene in check.rooms:
        bare, _ = check.year(scene, SKIES, "sky", "30%", 1)
        suns = {hour: towards(bare[hour[:3]][0]) for hour in SKIES}
        plane = scene["receivers"][0]
        middle = [at + (a + b) / 2 for at, a, b in zip(plane["origin"], plane["u"], plane["v"])]
        covers = [cover(number, suns[hour], middle) for number, hour in enumerate(SKIES) if hour[3]]
        scene = dict(scene, geometry=scene["geometry"] + covers)
        runs = {}
        for hour in SKIES:
            at = bare[hour[:3]][0]
            place = {"sun_elevation_deg": float(at["sun_elevation_deg"]), "sun_azimuth_deg": float(at["sun_azimuth_deg"])}
            sky = {"name": "sky", "type": "sky", "luminance_distribution": "Perez", "direct_normal_illuminance_lx": hour[3],
                   "diffuse_horizontal_illuminance_lx": hour[4], **place}
            runs[hour] = check.solve(scene, sky, "sky-run", target)
        for subdivision in range(1, 5):
            found, summary = check.year(scene, SKIES, "sky", target, subdivision)
            errors = []
            for hour, (lx, error, _) in runs.items():
                of_year = found[hour[:3]][1]
                errors.append(left(list(zip(zip(*of_year), zip(lx, error)))))
            squares, noise = [square for square, _ in errors], math.sqrt(statistics.mean(noise ** 2 for _, noise in errors))
            print(f"| {name} | {subdivision} | {summary['sky_patches']} | {100 * summary['patch_error']:.2f} % | "
                  f"{100 * signed_root(statistics.median(squares)):.2f} % | {100 * signed_root(max(squares)):.2f} % | {100 * noise:.2f} % |", flush=True)


def suns(check, target):
    hours = [(month + 1, day + 1, hour + .5, SUN_LX, 1) for month, days in enumerate(LENGTHS) for day in range(days) for hour in range(3, 21)]
    few = [hour for hour in hours if hour[:2] in DAYS and hour[2] in HOURS]
    print("| room | hours | nodes' error of a point, median hour | worst hour | of the plane's mean | worst hour | mean of all hours | stated errors of a point |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    for name, scene in check.rooms:
        found, _ = check.year(scene, hours, "sun", target)
        alone, _ = check.year(scene, few, "alone", target)
        points, planes, noises = [], [], []
        for hour, (at, own) in alone.items():
            # Points that the sun lights straight stand out from the median.
            limit = BRIGHT * statistics.median(own[0])
            pairs = [pair for pair in zip(zip(*found[hour][1]), zip(*own)) if pair[1][0] < limit and pair[1][1] < RIM * pair[1][0]]
            if float(at["sun_elevation_deg"]) < 3 or len(pairs) < 3 or limit < 3:
                continue
            square = sum(lx ** 2 for _, (lx, _) in pairs)
            points.append(math.sqrt(sum((a - b) ** 2 for (a, _), (b, _) in pairs) / square))
            planes.append(sum(a - b for (a, _), (b, _) in pairs) / sum(b for _, (b, _) in pairs))
            noises.append(left(pairs)[1])
        sizes = [abs(off) for off in planes]
        numbers = [statistics.median(points), max(points), statistics.median(sizes), max(sizes)]
        cells = " | ".join(f"{100 * number:.1f} %" for number in numbers)
        print(f"| {name} | {len(points)} | {cells} | {100 * statistics.mean(planes):+.1f} % | {100 * statistics.median(noises):.1f} % |", flush=True)


def drawn_hours(found, count, seed):
    """Hours by their key, low suns first."""
    height = {hour: float(at["sun_elevation_deg"]) for hour, (at, _) in found.items()}
    low = [hour for hour in sorted(height) if LEAST_DEG < height[hour] < LOW_DEG]
    high = [hour for hour in sorted(height) if height[hour] >= LOW_DEG]
    drawn = random.Random(seed)
    return drawn.sample(low, count - count // 3) + drawn.sample(high, count // 3)


def hours(check, target, count, seed):
    every = [(month + 1, day + 1, hour + .5, SUN_LX, CLEAR_SKY_LX) for month, days in enumerate(LENGTHS) for day in range(days) for hour in range(3, 21)]
    print("| room | hours | planes within 2.13 errors | scatter over errors | points within | scatter over errors | low suns: deviation of points | stated errors | worst | mean deviation of planes |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    rms = lambda values: math.sqrt(statistics.mean(value ** 2 for value in values))
    held = lambda values: f"{sum(abs(value) <= T_15 for value in values)} of {len(values)}"
    plane_of = lambda at: (float(at["average_lx"]), float(at["average_standard_error_lx"]))
    for name, scene in check.rooms:
        found, _ = check.year(scene, every, "all", target, more=["--seed", seed])
        drawn = drawn_hours(found, count, seed)
        part = float(target.rstrip("%")) / 3
        alone, _ = check.year(scene, [hour for hour in every if hour[:3] in drawn], "alone", f"{part}%", more=["--seed", seed + 1000])
        planes, points, lows = [], [], []
        for hour in drawn:
            (at, of_year), (at_alone, own) = found[hour], alone[hour]
            both = [plane_of(at), plane_of(at_alone)]
            planes.append(((both[0][0] - both[1][0]) / math.hypot(both[0][1], both[1][1]), both[0][0] / both[1][0] - 1))
            pairs = [((a - b) / math.hypot(s, t), a / b - 1, math.hypot(s, t) / b) for a, s, b, t in zip(*of_year, *own)]
            points += [score for score, _, _ in pairs]
            if float(at["sun_elevation_deg"]) < LOW_DEG:
                lows += pairs
            print(f"  {hour} {float(at['sun_elevation_deg']):.1f} deg {both[1][0]:.0f} lx: plane {planes[-1][0]:+.1f} errors, {100 * planes[-1][1]:+.1f} %; points "
                  + " ".join(f"{score:+.1f}" for score, _, _ in pairs), file=sys.stderr, flush=True)
        print(f"| {name} | {len(planes)} | {held([score for score, _ in planes])} | {rms([score for score, _ in planes]):.2f} | {held(points)} | {rms(points):.2f} | "
              f"{100 * rms([off for _, off, _ in lows]):.2f} % | {100 * rms([error for _, _, error in lows]):.2f} % | {100 * max(abs(off) for _, off, _ in lows):.0f} % | "
              f"{100 * statistics.mean(off for _, off in planes):+.2f} % |", flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["patches", "suns", "hours"])
    parser.add_argument("--out", required=True)
    parser.add_argument("--luxmc", default=str(ROOT / "target/release/luxmc"))
    parser.add_argument("--target-error", default="1%")
    parser.add_argument("--room", choices=list(rooms()), help="only this room")
    parser.add_argument("--count", type=int, default=60, help="number of drawn hours")
    parser.add_argument("--seed", type=int, default=1, help="seed of the draw and of the year")
    given = parser.parse_args()
    if given.what == "hours":
        hours(Check(given), given.target_error, given.count, given.seed)
    else:
        {"patches": patches, "suns": suns}[given.what](Check(given), given.target_error)
