"""
A cloud without normals
=======================

Positions alone, as a scanner has them, under a sky. Normals and radii are estimated; no surface is made.
"""

import numpy as np

import surflux as sf
from surflux.scenes import shapes

positions = shapes.knot(12_000).points
cloud = sf.Surfels(positions, reflectance=[0.8, 0.6, 0.4])  # normals face the side from which rays see each point
floor = sf.Surfels.from_mesh(shapes.rectangle([-4, -4, -0.9], [8, 0, 0], [0, 8, 0]), patch_area=0.02)
sky = np.full((32, 64, 3), [0.5, 0.6, 0.8])
sky[4:10, 12:24] = [9.0, 8.0, 6.0]  # a bright cloud in it
scene = sf.Scene([cloud, floor], lights=[sf.Environment(sky)])
solution = sf.solve(scene)
camera = sf.Camera([2.4, -4.2, 2.6], [0, 0, -0.2], fov=38)
sf.write_image("knot.png", solution.render(camera, (480, 360), samples=2, background=0.8))
