"""
Beside path tracing
===================

How far a solution is off, place by place: 600 surfels of three spheres against unbiased paths of the same scene, with
bars of twice their standard error.
"""

import numpy as np
from matplotlib import pyplot

import surflux as sf

scene = sf.examples.three_spheres()
solution = sf.solve(scene)
s, draw = solution.surfels, np.random.default_rng(0)
asked = draw.choice(len(s), 600, p=s.areas / s.areas.sum())
H, noise = sf.reference_irradiance(scene, s.points[asked], s.normals[asked], samples=1024)
off, size = ((solution.irradiance[asked] - H) ** 2).sum() - (noise**2).sum(), (H**2).sum()
print(f"off by {np.sqrt(off / size):.2%}, by its own estimate {solution.error:.2%}")
figure, axes = pyplot.subplots(figsize=(6.4, 4.8))
green = H[:, 1], solution.irradiance[asked, 1]
axes.errorbar(*green, xerr=2 * noise[:, 1], fmt=".", markersize=4, elinewidth=0.5)
axes.plot([0, green[0].max()], [0, green[0].max()], color="grey", linewidth=0.8)
axes.set(xlabel="path tracing, W/m2", ylabel="sf.solve, W/m2")
figure.savefig("beside_path_tracing.png", dpi=120)
