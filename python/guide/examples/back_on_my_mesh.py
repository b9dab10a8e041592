"""
Results back on my mesh
=======================

Light at the vertices of a mesh as it came, for programs that know nothing of surfels: ``irradiance_at`` asks the
solution there, and pyvista writes the mesh with one more array.
"""

import pyvista

import surflux as sf

mesh = pyvista.ParametricTorus(ringradius=1.0, crosssectionradius=0.4).compute_normals(split_vertices=False)
mesh = mesh.translate([0, 0, 0.4])
floor = pyvista.Plane(i_size=6, j_size=6, i_resolution=1, j_resolution=1)
parts = [sf.Surfels.from_mesh(mesh, patch_area=0.004), sf.Surfels.from_mesh(floor, patch_area=0.02)]
scene = sf.Scene(parts, lights=[sf.PointLight([1.5, -1.5, 3.0], 60), sf.Environment(0.3)])
solution = sf.solve(scene)
mesh["W/m2"] = solution.irradiance_at(mesh.points, mesh.point_normals).mean(axis=1)
mesh.save("torus.ply")  # mesh.save("torus.vtp") keeps the array, too
plotter = pyvista.Plotter(off_screen=True, window_size=(800, 600))
plotter.add_mesh(mesh, scalars="W/m2", cmap="inferno", lighting=False, scalar_bar_args={"position_y": 0.02})
plotter.camera_position = [(2.6, -3.6, 2.6), (0, 0, 0.4), (0, 0, 1)]
plotter.screenshot("torus.png")
