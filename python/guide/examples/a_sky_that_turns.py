"""
A sky that turns
================

Light from all around, as five bands of spherical harmonics, on a glossy ball: the environment is turned by a third of a
circle from picture to picture, and only what it sends is computed anew.
"""

import numpy as np

import surflux as sf
from surflux.scenes import shapes

ball = shapes.sphere(2562).replace(reflectance=0.25, specular=[0.5, 0.4, 0.3], exponent=20)
table = sf.Surfels.from_mesh(shapes.rectangle([-3, -3, -1], [6, 0, 0], [0, 6, 0]), patch_area=0.03, reflectance=0.6)
transfer = sf.precompute_transfer(sf.Scene([ball, table]), "distant")
hall = np.full((32, 64, 3), 0.4)  # row 0 above
hall[3:14, 12:28] = [5.0, 4.0, 2.5]
hall[6:16, 50:60] = [0.6, 1.2, 3.0]
camera = sf.Camera([0, -6.4, 3.2], [0, 0, -0.3], fov=32)
frames = []
for azimuth in (0, 120, 240):
    solution = transfer.relight(sf.Environment(hall, azimuth=azimuth))
    frames.append(solution.render(camera, (280, 240), samples=2, background=True))
sf.write_image("turned.png", np.hstack(frames), exposure=0.35)
