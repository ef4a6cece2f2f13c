"""Mean illuminance of the far wall behind a slit of width w in the middle of a black room, lamp of 1000 lm."""
import math
print("set,exact")
for w in (0.1, 0.01, 0.001, 0.0001):
    a, b, d = 1.5 * w, 0.5, 1.5
    print(f"{w:g},{4 * 1000 / (4 * math.pi) * math.atan(a * b / (d * math.sqrt(a * a + b * b + d * d)))!r}")
