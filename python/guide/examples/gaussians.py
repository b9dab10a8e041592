"""
Gaussians for other viewers
===========================

A solved knot as Gaussians of 3D Gaussian splatting, its light baked in; read again, and shown here by their centres
alone. Viewers of splats draw them with soft edges.
"""

import pyvista

import surflux as sf
from surflux.scenes import shapes

knot = shapes.knot(20_000).replace(reflectance=[0.75, 0.6, 0.4])
floor = sf.Surfels.from_mesh(shapes.rectangle([-2, -2, -1], [4, 0, 0], [0, 4, 0]), patch_area=0.001)
lamp = sf.AreaLight([-2, -2, 3], [0, 1, 0], [1, 0, 0], 60)
solution = sf.solve(sf.Scene([knot, floor], lights=[lamp, sf.Environment(0.5)]), insert=False)
gaussians = sf.Gaussians.of(solution)
gaussians.save("knot.glb")
again, eye = sf.load_gaussians("knot.glb"), [1.7, -4.6, 2.6]
print(again)
plotter = pyvista.Plotter(off_screen=True, window_size=(640, 480))
colors = again.colors_towards(eye - again.positions).clip(0, 1)
plotter.add_points(again.positions, scalars=colors, rgb=True, point_size=13)
plotter.camera_position = [eye, (0, 0, -0.2), (0, 0, 1)]
plotter.screenshot("gaussians.png")
