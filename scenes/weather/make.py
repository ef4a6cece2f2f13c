#!/usr/bin/env python3
"""Writes a synthetic year of weather as CSV, and as EPW where the name ends so: python3 make.py synthetic-52N.csv

Nothing in it was measured. The sun's light is that of a clear sky, 1367 W/m² · 0.7^(AM^0.678) with Kasten's air mass AM (Meinel and
Meinel, "Applied Solar Energy", 1976), the sky's a tenth of the sun's light outside of the air on a plane, times the sine of the sun's height
to the power of 0.9. Clouds of c, from 0 to 1, change by day as a bounded walk by a generator that anyone can run again; they leave
(1 - c)^1.5 of the sun's light, and turn 0.45 c of what is missing into light of the sky, less where they are thick.
"""
import math
import sys

LATITUDE, LONGITUDE, ZONE = 52.0, 13.0, 1.0
DAYS = [31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31]


def height(day, hour):
    """Sine of the sun's height by the day of the year and the standard time."""
    turn = 2 * math.pi * (day - 1 + (hour - 12) / 24) / 365
    declination = (0.006918 - 0.399912 * math.cos(turn) + 0.070257 * math.sin(turn) - 0.006758 * math.cos(2 * turn)
                   + 0.000907 * math.sin(2 * turn) - 0.002697 * math.cos(3 * turn) + 0.00148 * math.sin(3 * turn))
    equation = 229.18 * (0.000075 + 0.001868 * math.cos(turn) - 0.032077 * math.sin(turn)
                         - 0.014615 * math.cos(2 * turn) - 0.040849 * math.sin(2 * turn))
    solar = hour + (4 * (LONGITUDE - 15 * ZONE) + equation) / 60
    latitude = math.radians(LATITUDE)
    angle = math.radians(15 * (solar - 12))
    return math.sin(latitude) * math.sin(declination) + math.cos(latitude) * math.cos(declination) * math.cos(angle)


def hours():
    """Month, day, hour from 1 to 24, direct normal and diffuse horizontal irradiance in W/m²."""
    state, clouds, number = 1, 0.5, 0
    for month, days in enumerate(DAYS, 1):
        for day in range(1, days + 1):
            number += 1
            state = (state * 6364136223846793005 + 1442695040888963407) % 2**64
            clouds += 0.9 * (state / 2**64 - 0.5)
            clouds = -clouds if clouds < 0 else 2 - clouds if clouds > 1 else clouds
            for hour in range(1, 25):
                sine = height(number, hour - 0.5)
                if sine <= 0:
                    yield month, day, hour, 0, 0
                    continue
                degrees = math.degrees(math.asin(sine))
                mass = 1 / (sine + 0.50572 * (degrees + 6.07995) ** -1.6364)
                clear = 1367 * 0.7 ** (mass ** 0.678)
                direct = clear * (1 - clouds) ** 1.5
                diffuse = 137 * sine ** 0.9 + 0.45 * clouds * (1 - 0.4 * clouds) * (clear - direct) * sine
                yield month, day, hour, round(direct), round(diffuse)


def main(path):
    with open(path, "w", encoding="ascii") as out:
        if path.endswith(".epw"):
            out.write(f"LOCATION,synthetic,-,-,synthetic clear sky with made-up clouds,0,{LATITUDE},{LONGITUDE},{ZONE},0\n")
            for name in ["DESIGN CONDITIONS,0", "TYPICAL/EXTREME PERIODS,0", "GROUND TEMPERATURES,0",
                         "HOLIDAYS/DAYLIGHT SAVINGS,No,0,0,0", "COMMENTS 1,synthetic: nothing was measured", "COMMENTS 2,",
                         "DATA PERIODS,1,1,Data,Sunday,1/1,12/31"]:
                out.write(name + "\n")
            for month, day, hour, direct, diffuse in hours():
                out.write(f"2026,{month},{day},{hour},60,?,10,5,70,101325,0,0,300,0,{direct},{diffuse},0,0,0,0\n")
            return
        out.write(f"place,synthetic\nlatitude_deg,{LATITUDE}\nlongitude_deg,{LONGITUDE}\ntime_zone_hours,{ZONE}\n")
        out.write("month,day,hour,direct_normal_irradiance_w_m2,diffuse_horizontal_irradiance_w_m2\n")
        for month, day, hour, direct, diffuse in hours():
            out.write(f"{month},{day},{hour - 0.5},{direct},{diffuse}\n")


main(sys.argv[1])
