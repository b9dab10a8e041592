"""
Sky-view factor
===============

How much of the sky each place sees: what lets streets cool at night. 1 on an open level plane.
"""

import surflux as sf

street = sf.examples.street()
view = sf.sky_view_factor(street)
ground = street.surfels.points[:, 2] < 0.01
print(f"ground {view[ground].min():.2f} to {view[ground].max():.2f}")
camera = sf.Camera([-34, -44, 38], [1, 1, 2], fov=38)
values = {"sky view": view}
sf.view(street.surfels, values=values, color="sky view", screenshot="sky_view.png", size=(640, 440), camera=camera)
