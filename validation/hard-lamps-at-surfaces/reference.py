"""Floor points under a Lambertian lamp of 900 cd at heights of 2 m, 2.999 m and 3 m: straight below and 1 m off."""
print("set,exact")
for height in (2.0, 2.999, 3.0):
    for off in (0.0, 1.0):
        print(f"{height:g},{900 * height**2 / (height**2 + off**2) ** 2!r}")
