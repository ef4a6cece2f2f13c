"""Makes desks.obj: four desks, tops of wood, legs of steel; every part is a closed box that touches no other."""
from pathlib import Path

FACES = ["1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"]
lines, made = ["# Four desks, made by mesh.py. Lengths in metres; the parts stand 1 cm apart."], 0


def box(low, high):
    global made
    for corner in range(8):
        lines.append("v " + " ".join(f"{(high if corner >> axis & 1 else low)[axis]:g}" for axis in range(3)))
    for face in FACES:
        lines.append("f " + " ".join(str(made + int(number)) for number in face.split()))
    made += 8


for x in (1.0, 4.4):
    for y in (1.0, 4.2):
        lines.append("usemtl Wood")
        box((x, y, 0.71), (x + 1.6, y + 0.8, 0.74))
        lines.append("usemtl Steel")
        for leg_x in (x + 0.04, x + 1.52):
            for leg_y in (y + 0.04, y + 0.72):
                box((leg_x, leg_y, 0.0), (leg_x + 0.04, leg_y + 0.04, 0.7))
Path(__file__).with_name("desks.obj").write_text("\n".join(lines) + "\n")
