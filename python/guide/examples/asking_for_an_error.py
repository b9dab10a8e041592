"""
Asking for an error
===================

One knob: the error that is wanted. Attempts go from coarse to fine until the solver's own estimate is met. Left
5 %, right 1 %: what differs is noise, and the borders of shadows.
"""

import numpy as np

import surflux as sf

scene = sf.examples.three_spheres()
pictures = []
for error in (0.05, 0.01):
    solution = sf.solve(scene, error=error)
    print(f"asked {error:.0%}: {solution.error:.1%} in {sum(a['seconds'] for a in solution.attempts):.1f} s")
    pictures.append(solution.render(scene.camera, (400, 380), samples=2))
sf.write_image("errors.png", np.hstack(pictures))
