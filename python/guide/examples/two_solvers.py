"""
Two solvers
===========

``solve`` has one value on each surfel, ``solve_meshless`` a smooth field between points of its own: on coarse patches
that shows. Left ``solve``, right ``solve_meshless``, whose direct light is found at each pixel.
"""

import numpy as np

import surflux as sf

scene = sf.examples.colonnade()
by_surfels = sf.solve(scene)
meshless = sf.solve_meshless(scene)
for name, solution in (("solve", by_surfels), ("solve_meshless", meshless)):
    print(f"{name}: own estimate {solution.error:.1%}, {sum(solution.timings.values()):.1f} s")
left = by_surfels.render(scene.camera, (400, 300))
right = meshless.render(scene.camera, (400, 300), direct="traced", rays=16)
sf.write_image("two_solvers.png", np.hstack([left, right]))
