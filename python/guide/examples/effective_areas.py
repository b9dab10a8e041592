"""
Effective areas
===============

Disks of neighbouring points overlap. Each gets its share of what they cover together, so that the shares add up to the
surface: here to that of a unit sphere, whose points were drawn at random.
"""

import numpy as np

import surflux as sf

rng = np.random.default_rng(1)
points = rng.normal(size=(1500, 3))
points /= np.linalg.norm(points, axis=1, keepdims=True)
sphere = sf.Surfels(points)
areas = sf.effective_areas(sphere)
disks = np.pi * sphere.radii**2
print(f"disks {disks.sum():.1f}, effective areas {areas.sum():.3f}, the sphere {4 * np.pi:.3f} m2")
sphere.areas = areas
camera = sf.Camera([2, -2.2, 1], [0, 0, 0], fov=40)
sf.view(sphere, values={"cm2": 1e4 * areas}, color="cm2", screenshot="areas.png", size=(640, 480), camera=camera)
