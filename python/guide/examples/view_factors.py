"""
View factors in a cube
======================

Which share of what one patch of the floor emits reaches each other patch. All shares add up to 1, and between whole
faces they are those of the closed form.
"""

import numpy as np

import surflux as sf
from surflux.scenes import shapes

vertices, faces, side = shapes.box(1.0, patches=12, inward=True)
cube = sf.Surfels.from_mesh((vertices, faces))
F = sf.form_factors(sf.Scene([cube]))
floor = np.flatnonzero(side == 4)
for name, number, known in (("ceiling", 5, 0.1998248957), ("a wall", 0, 0.2000437761)):
    found = F[np.ix_(floor, np.flatnonzero(side == number))].sum(axis=1).mean()
    print(f"floor to {name}: {found:.8f}, in closed form {known:.8f}")
patch = floor[30]
print(f"all of patch {patch}: {F[patch].sum():.9f}")
camera = sf.Camera([0.5, -1.3, 0.7], [0.5, 0.5, 0.47])
sf.view(cube, values={"%": 100 * F[patch]}, color="%", screenshot="cube.png", size=(640, 480), camera=camera)
