"""
A lamp that moves
=================

How light goes from surface to surface is found once. After that each lamp is a matter of milliseconds: three frames,
with shadows sharp to the pixel.
"""

import numpy as np

import surflux as sf

scene = sf.examples.cornell_box()
transfer = sf.precompute_transfer(scene)
renderer = sf.LampRenderer(transfer, scene.camera, (300, 300))
frames = []
for x in (0.1, 0.28, 0.46):
    lamp = sf.PointLight([x, 0.2, 0.42], [0.5, 0.42, 0.3])  # metres, W/sr
    frames.append(renderer.frame(lamp))
    print(f"x = {x}: {1e3 * sum(renderer.frame_timings.values()):.0f} ms")
sf.write_image("lamp.png", np.hstack(frames))
