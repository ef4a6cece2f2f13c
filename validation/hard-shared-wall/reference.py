"""Mean illuminance of each face of a cube of 1 m with a lamp of 1000 lm at its centre, reflectance 0.9."""
print("surface,exact")
for face in ("floor", "ceiling", "x_min", "x_max", "y_min", "y_max"):
    print(f"lit/{face},{1000 / 6 / (1 - 0.9)!r}")
