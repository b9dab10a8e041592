"""
A clear sky on a street
=======================

A sky after Perez with its sun. Houses shade each other, and walls in the sun light those across the street.
"""

import surflux as sf

scene = sf.examples.street()
sky = sf.Sky.from_sun(altitude=40, azimuth=250, direct_normal=750, diffuse=110)  # degrees, W/m2
solution = sf.solve(sf.Scene(scene.objects, lights=[sky]))
up = solution.surfels.normals[:, 2] > 0.5
level = solution.irradiance[up].mean(axis=1)
print(f"roofs and ground: {level.min():.0f} to {level.max():.0f} W/m2")
camera = sf.Camera([-38, -34, 24], [-1, -1, 2], fov=38)
picture = solution.render(camera, (640, 400), samples=2, background=True)
sf.write_image("street.png", picture)
