"""
Looking at a surfel
===================

Where the light of one place comes from: lines go to what sends it, as wide as their share. In the window of
``sf.view(solution)`` a click does the same.
"""

import numpy as np

import surflux as sf

scene = sf.examples.three_spheres()
solution = sf.solve(scene)
on_floor = np.linalg.norm(solution.surfels.points - [2.35, 1.2, 0.0], axis=1).argmin()
print("irradiance", solution.irradiance[on_floor].round(2), "direct", solution.direct[on_floor].round(2), "W/m2")
sf.view(solution, pick=int(on_floor), screenshot="picked.png", size=(900, 640), camera=scene.camera)
