"""Lines that mypy --strict has to complain about, all that are marked and no others; nothing runs them."""

import surflux as sf

square = ([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]])
floor = sf.Surfels.from_mesh(square, patch_area="small")  # refused
floor = sf.Surfels.from_mesh(7)  # refused
sf.Surfels([[0, 0, 0]], colour=0.5)  # refused
sf.Surfels([[0, 0, 0]], threads="all")  # refused
floor.points = [[0, 0, 0]]  # refused
floor.thinned("half")  # refused
floor.to_pyvista("squares")  # refused
sf.effective_areas([[0, 0, 0]])  # refused
sf.effective_areas(floor, backend="cuda")  # refused
sf.concatenate(floor)  # refused
sf.PointLight([0, 0, 1])  # refused
sf.SpotLight([0, 0, 1], [0, 0, -1], 1.0, cone="wide")  # refused
camera = sf.Camera([0, -4, 1], [0, 0, 1], fov="wide")  # refused
scene = sf.Scene([floor], lights=[floor])  # refused
sf.Scene([square])  # refused
scene.lights.append(sf.PointLight([0, 0, 1], 1.0))  # refused
sf.solve(floor)  # refused
sf.solve(scene, 0.1)  # refused
solution = sf.solve(scene, transport="photons")  # refused
sf.solve(scene, progress="bar")  # refused
sf.solve_meshless(scene, level=3)  # refused
row = sf.form_factors(scene).row  # refused
sf.form_factors(scene, return_escape=True).sum()  # refused
sf.form_factor_operator(scene, rays="many")  # refused
sf.precompute_transfer(scene, "sideways")  # refused
sf.LampRenderer(scene)  # refused
solution.render(size=800)  # refused
solution.render(backgrounds=0.0)  # refused
solution.render(layers=True).mean()  # refused
solution.render(layers="depth")  # refused
sf.Page(solution, colors="radiosity")  # refused
sf.Page(sf.precompute_transfer(scene), environment=1.0)  # refused
sf.animate_environment(sf.precompute_transfer(scene), [1.0], "a.gif")  # refused
sf.turn_environment(sf.precompute_transfer(scene, "distant"))  # refused
solution.per_face("normals")  # refused
solution.irradiance_at([[0, 0, 0]])  # refused
solution.save(1)  # refused
sf.load_solution(solution)  # refused
sf.Gaussians.of(floor)  # refused
sf.Gaussians.of(solution, color_space="sRGB")  # refused
sf.load_gaussians("room.glb", (0, 1, 0))  # refused
sf.write_image("out.png", "picture", exposure="bright")  # refused
sf.reed("scan.ply")  # refused
