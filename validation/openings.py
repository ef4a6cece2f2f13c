"""Openings in roof and facade of a black room after CIE 171:2006, cases 5.9 to 5.12: points, rooms, integrals, for the programs that
write its cases. Needs numpy.
"""
from lambert import configuration_factor, write, write_points
from skies import (ALONG, WALL, dump, hemisphere, luminance, pane, published, quads, roof, scale, seen, sky, window,
                   write_room)

under_roof = [(name, (2.0, 0.0, z), (0, 1, 0)) for name, z in WALL]
under_roof += [(name, (2.0, y, 0.0), (0, 0, 1)) for name, y in ALONG]
behind = [(name, (2.0, 4.0, z), (0, -1, 0)) for name, z in WALL]
behind += [(name, (2.0, 4 - y, 0.0), (0, 0, 1)) for name, y in ALONG]
behind += [(name + "'", (2.0, 4 - y, 3.0), (0, 0, -1)) for name, y in ALONG]
# The sun stands where the wall with points under a roof looks, and where windows look.
OPENINGS = [
    ("roof 1", "roof.csv", under_roof, roof(1), 0),
    ("roof 4", "roof.csv", under_roof, roof(4), 0),
    ("window 2 x 1", "window.csv", behind, window((1, 3), (1, 2)), 180),
    ("window 4 x 3", "window.csv", behind, window((0, 4), (0, 3)), 180),
]



def check():
    """Rules against Lambert's formula and against closed forms, where both can tell."""
    lambert = 100 * configuration_factor((2.0, 0.25, 0.0), (0, 0, 1), [(1, 0, 1), (3, 0, 1), (3, 0, 2), (1, 0, 2)])
    towards, _, weights = seen((2.0, 0.25, 0.0), (0, 0, 1), *window((1, 3), (1, 2)))
    found = (luminance(5, towards, 180, scale(5, 180)) * weights).sum()
    assert abs(found / lambert - 1) < 1e-9, (found, lambert)
    assert abs(hemisphere(16, (0, 0, 1), 0) / (7 * 3.141592653589793 / 9) - 1) < 1e-9


def write_case(folder, kinds, target_error, criterion, groups):
    """Writes a case and its reference numbers: in per cent of the illuminance of an open horizontal plane."""
    check()
    tables = published(folder)
    rows, runs = [], []
    for name, file, points, (corner, u, v), azimuth in OPENINGS:
        room = name.replace(" ", "-") + ".obj"
        write_room(folder, room, quads(name))
        nodes = [seen(position, normal, corner, u, v) for _, position, normal in points]
        for kind in kinds:
            factor = scale(kind, azimuth)
            for glazed in (False, True):
                title = f"{name} m, type {kind}{', glazed' if glazed else ''}"
                told = [] if glazed else tables.get((name, kind), [])
                for number, (label, position, normal) in enumerate(points):
                    towards, there, weights = nodes[number]
                    passed = pane(there) if glazed else 1
                    value = float((luminance(kind, towards, azimuth, factor) * weights * passed).sum())
                    rows.append([title, label, *position, f"{value:.9g}", told[number] if number < len(told) else ""])
                geometry = [{"name": "room", "type": "mesh", "file": room, "material": "black"}]
                if glazed:
                    geometry.append({"name": "pane", "type": "rectangle", "origin": corner, "u": v, "v": u, "material": "pane"})
                runs.append({"name": title, "target_error": target_error, "with": {
                    "geometry": geometry, "sky": sky(kind, azimuth), "points": file, "set": title,
                    "labels": [label for label, _, _ in points]}})
    write(folder, ["set", "point", "x", "y", "z", "exact", "cie"], rows)
    write_points(folder, "roof.csv", [(place, normal) for _, place, normal in under_roof])
    write_points(folder, "window.csv", [(place, normal) for _, place, normal in behind])
    dump({
        "title": "CIE 171:2006, cases 5.9 to 5.12: openings in roof and facade under " + ("the uniform and the overcast sky" if kinds == [5, 16] else "general skies"),
        "physics": "A black room sees the sky, and the ground that reflects 30 % of its light, through an opening with or without a pane. The illuminance of a point is the integral of luminance over the part of the opening that it sees.",
        "remarks": ["Values are in per cent of the illuminance of an open horizontal plane. CIE computed its numbers from parts of openings, so near an opening's edge they differ from the integral by up to 8 %. The pane is clear glass by Fresnel's formulas, not the pane of CIE's tables, so those tables are left out."],
        "sources": ["CIE 171:2006, cases 5.9 to 5.12, tables B.1 to B.4 and B.9 to B.14; reference.py", "ISO 15469:2004, table 1"],
        "groups": groups,
        "scene": {
            "version": 1,
            "materials": {"black": {"type": "diffuse", "reflectance": 0},
                          "pane": {"type": "glass", "refractive_index": 1.52, "internal_transmittance": 1}},
            "geometry": "$geometry",
            "luminaires": ["$sky"],
            "receivers": [{"name": "points", "type": "points", "file": "$points"}],
        },
        "runs": runs,
        "compare": [{"name": "points", "what": "points", "map": "points", "labels": "$labels",
                     "truth": {"function": "reference", "column": "exact", "set": "$set"},
                     "beside": {"name": "CIE 171", "column": "cie"}, "criterion": criterion}],
    }, folder / "case.json")
