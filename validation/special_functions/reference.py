"""Makes reference.csv: Bessel functions to 40 digits, by mpmath's own series and asymptotic expansions.

Run: pip install mpmath, then: python3 reference.py > reference.csv
Arguments are exact doubles (written so that they read back the same). Complex arguments lie in the closed quadrant
Re z >= 0, Im z >= 0; K0e, K1e are exp(z) K0(z), exp(z) K1(z).
"""

from mpmath import mp, mpf, mpc, besselj, bessely, besselk, exp

mp.dps = 60


def digits(value):
    return mp.nstr(value, 40, min_fixed=0, max_fixed=0)


def real_arguments(low, high, count):
    step = (mp.log(high) - mp.log(low)) / (count - 1)
    return [float(mp.e ** (mp.log(low) + i * step)) for i in range(count)]


print("function,re_z,im_z,re_value,im_value")
for name, f in [("J0", lambda x: besselj(0, x)), ("J1", lambda x: besselj(1, x)),
                ("Y0", lambda x: bessely(0, x)), ("Y1", lambda x: bessely(1, x))]:
    # The first zeros of J0, J1, Y0, Y1 to 4 digits, where the error is measured against the envelope.
    for x in real_arguments(1e-8, 1e5, 80) + [2.405, 3.832, 0.8936, 2.197, 5.52, 7.016, 3.958, 5.430]:
        print(f"{name},{x!r},0.0,{digits(f(mpf(x)))},0")
for name, f in [("K0", lambda x: besselk(0, x)), ("K1", lambda x: besselk(1, x))]:
    for x in real_arguments(1e-8, 700, 80) + [1.999, 2.0, 2.001]:
        print(f"{name},{x!r},0.0,{digits(f(mpf(x)))},0")
for name, n in [("K0e", 0), ("K1e", 1)]:
    for x in real_arguments(1e-8, 1e6, 60) + [1.999, 2.0, 2.001]:
        print(f"{name},{x!r},0.0,{digits(exp(mpf(x)) * besselk(n, mpf(x)))},0")
    for size in [1e-6, 1e-3, 0.1, 0.7, 1.5, 1.99, 2.01, 2.5, 4.0, 7.0, 12.0, 30.0, 100.0]:
        for degrees in [15, 30, 45, 60, 75, 88, 90]:
            angle = mpf(degrees) * mp.pi / 180
            re = 0.0 if degrees == 90 else float(size * mp.cos(angle))
            im = float(size * mp.sin(angle))
            z = mpc(re, im)
            value = exp(z) * besselk(n, z)
            print(f"{name},{re!r},{im!r},{digits(value.real)},{digits(value.imag)}")
