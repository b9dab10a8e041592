"""
Radiated heat
=============

A furnace of black walls: its floor is held at 900 K, the other walls, 2 mm of steel, begin at 300 K and warm up by what
reaches them past a cold block. ``K @ x`` is one exchange between all patches.
"""

import numpy as np

import surflux as sf
from surflux.scenes import shapes

furnace = sf.Surfels.from_mesh(shapes.box([2.0, 1.0, 1.0], patches=[32, 16, 16], inward=True)[:2])
vertices, faces, _ = shapes.box([0.2, 0.5, 0.35], patches=[4, 8, 6])
block = sf.Surfels.from_mesh((np.add(vertices, [1.2, 0.25, 0.2]), faces))
K = sf.form_factor_operator(sf.Scene([furnace, block]), rays=512)
sigma, capacity = 5.670374e-8, 7850 * 490 * 0.002  # W/m2/K4; J/m2/K
points = np.concatenate([furnace.points, block.points])
held = (points[:, 2] < 1e-6) | (np.arange(len(points)) >= len(furnace))
T = np.where(points[:, 2] < 1e-6, 900.0, 300.0)
for _ in range(300):  # steps of one second
    T += np.where(held, 0.0, (K @ (sigma * T**4) - sigma * T**4) / capacity)
print(f"after five minutes: ceiling {T[points[:, 2] > 1 - 1e-6].mean():.0f} K")
both, camera = sf.concatenate([furnace, block]), sf.Camera([1, -2.2, 1.1], [1, 0.5, 0.42])
sf.view(both, values={"K": T}, color="K", screenshot="heat.png", size=(640, 400), camera=camera)
