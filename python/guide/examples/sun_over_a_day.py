"""
Sun over a day
==============

kWh/m2 on each patch of a street on a day in June: the sum of eleven hours, each with its own sun and sky.
``sf.solar_irradiation`` does it for years, places and weather files.
"""

import numpy as np

import surflux as sf

street = sf.examples.street()
total = np.zeros(len(street.surfels))
for hour in range(7, 18):
    turn = np.radians(15.0 * (hour - 12))
    altitude = 18 + 47 * np.cos(turn)  # about that of latitude 48 in June
    sky = sf.Sky.from_sun(max(altitude, 5), 180 + 15.0 * (hour - 12) * 1.3, 820 * np.cos(turn / 1.6), 90)
    hourly = sf.solve(sf.Scene(street.objects, lights=[sky]), insert=False, rays=64)
    total += hourly.irradiance.mean(axis=1) / 1000.0
print(f"{total.min():.1f} to {total.max():.1f} kWh/m2")
camera = sf.Camera([-34, -44, 38], [1, 1, 2], fov=38)
values = {"kWh/m2": total}
sf.view(street.surfels, values=values, color="kWh/m2", screenshot="day.png", size=(640, 440), camera=camera)
