"""A program that uses what surflux offers, for mypy --strict to read; nothing runs it."""

from pathlib import Path
from typing import Any, assert_type

import numpy as np
from numpy.typing import NDArray

import surflux as sf

Floats = NDArray[np.float64]


def watch(done: int, total: int) -> bool:
    return done < total


# surfels
cloud = sf.Surfels([[0, 0, 0], [1, 0, 0]], [[0, 0, 1], [0, 0, 1]], radii=0.6, areas=1, reflectance=[0.8, 0.4, 0.4])
cloud = sf.Surfels(np.zeros((4, 3)), viewpoint=(0.0, 0.0, 3.0), two_sided=True, threads=2, progress=watch)
square = ([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]])
floor = sf.Surfels.from_mesh(square, patch_area=0.25, reflectance=None, two_sided="sheets", progress=True)
sampled = sf.Surfels.sample_mesh(Path("mesh.obj"), 100, seed=1)
assert_type(floor, sf.Surfels)
assert_type(sampled, sf.Surfels)
assert_type(sf.read("scan.ply", viewpoint=[0, 0, 9], progress=print), sf.Surfels)
assert_type(sf.read("tile.laz", format="laz", points=1000, seed=1), sf.Surfels)
scan = sf.read_scan("tile.laz", points=1000, progress=watch)
assert_type(scan, sf.Scan)
assert_type(scan.viewpoint, Floats | None)
assert_type(scan[scan.attributes["classification"] == 2].surfels(viewpoint=[0, 0, 9]), sf.Surfels)
assert_type(floor.points, Floats)
assert_type(floor.normals, Floats)
assert_type(floor.radii, Floats)
assert_type(floor.areas, Floats | None)
assert_type(floor.reflectance, Floats)
assert_type(floor.emission, Floats)
assert_type(floor.triangles, Floats)
assert_type(floor.triangle_surfel, NDArray[np.uint32])
assert_type(floor.bounds, Floats)
assert_type(len(floor), int)
assert_type(floor[floor.points[:, 0] > 0.5], sf.Surfels)
assert_type(floor[:10], sf.Surfels)
assert_type(floor[0].flipped(), sf.Surfels)
assert_type(floor.replace(emission=1.0, radii=np.ones(4)), sf.Surfels)
assert_type(floor.transformed(np.eye(4)), sf.Surfels)
assert_type(floor.thinned(50, seed=2), sf.Surfels)
assert_type(floor.save("floor.ply"), Path)
assert_type(sf.concatenate([floor, cloud]), sf.Surfels)
assert_type(sf.divide_patches([floor, sampled]), list[sf.Surfels])
assert_type(floor.to_pyvista("disks").n_cells, int)
floor.areas = sf.effective_areas(floor, method="paper", backend="cpu", progress=watch)
floor.areas = 1.0
floor.areas = None
floor.plot(color="area", screenshot="areas.png")
floor.plot_areas(pick=3)

# scenes that come along
assert_type(sf.examples.statues(surfels=5000), sf.Scene)
assert_type(sf.examples.file("street"), Path)

# functions of surfels
assert_type(sf.effective_areas(cloud), Floats)
assert_type(sf.inward_patches(cloud, rooms=True), NDArray[np.int64])
facing = sf.facing(cloud.points, cloud.normals, seen_from=[0, 0, 1], progress=watch)
assert_type(facing, sf.Facing)
assert_type(facing.turned, NDArray[np.bool_])
shares = sf.area_shares(cloud, np.argmax(cloud.radii), kappa=2.0)
assert_type(shares, sf.AreaShares)
assert_type(shares.shares, Floats)
assert_type(shares.area, float)
tree = sf.build_hierarchy(cloud, max_levels=3)
assert_type(tree, sf.Hierarchy)
assert_type(tree.areas, list[Floats])
assert_type(tree.counts, list[int])

# lights and scenes
point = sf.PointLight([0.5, 0.5, 0.9], 1.0)
spot = sf.SpotLight((0, 0, 3), np.array([0, 0, -1]), [1, 2, 3], cone=30, penumbra=2.0)
area = sf.AreaLight([0, 0, 2], [1, 0, 0], [0, 1, 0], exitance=4)
sun = sf.DirectionalLight(direction=[0, 0, -1], irradiance=800.0)
sky = sf.Environment("sky.exr", up=(0, 1, 0), azimuth=90)
sky = sf.Environment(np.ones((4, 8, 3)))
assert_type(sky.harmonics(order=3), Floats)
assert_type(sf.SkyPatches(577).radiance(sky), Floats)
turned = sf.rotate_harmonics(sf.convolve_harmonics(sky.harmonics(), exponent=20), np.eye(3))
assert_type(sf.Environment.from_harmonics(turned, height=64), sf.Environment)
assert_type(sf.spherical_harmonics([[0, 0, 1]], order=5) @ sf.multiply_harmonics(turned, turned[:, 0]), Floats)
assert_type(point.position, tuple[float, float, float])
assert_type(sky.image, Floats | None)
camera = sf.Camera([0, -4, 1], [0, 0, 1], fov=40)
plan = sf.Camera.fit(floor.points, orthographic=True)
assert_type(plan, sf.Camera)
assert_type(camera.eye, Floats)
assert_type(camera.fov, float)
assert_type(camera.height, float | None)
assert_type(camera.project(floor.points, (800, 600)), Floats)
hour = sf.Sky(47.4, 8.5, "2025-06-21T12:00+02:00", altitude=400)
assert_type(hour.environment(64), sf.Environment)
assert_type(hour.patch_radiances(sf.SkyPatches(145), sun=True), Floats)
assert_type(sf.Sky.from_sun(30, 180, 700, 100).sun, sf.DirectionalLight | None)
assert_type(sf.Sky.from_epw("here.epw", 12).global_horizontal, float)
scene = sf.Scene([floor, cloud], lights=[point, spot, area, sun, sky, hour], camera=camera, name="room")
lit = sf.Scene((floor,), [point], solve_options={"zeta": 0.1})
scene.camera = None
assert_type(scene.surfels, sf.Surfels)
assert_type(scene.objects, tuple[sf.Surfels, ...])
assert_type(sf.load_scene("room.toml", surfels=1000), sf.Scene)
assert_type(sf.save_camera("room.toml", camera), Path)

# solving
solution = sf.solve(scene, zeta=0.05, insert=False, transport="rays", max_surfels=5000, threads=1, progress=True)
assert_type(solution, sf.Solution)
assert_type(sf.solve_meshless(scene, levels=3, bounces=2), sf.Solution)
factors = sf.form_factors(scene, error=0.01)
assert_type(factors, Floats)
factors, escape = sf.form_factors(scene, return_escape=True, rays=64)
assert_type(escape, Floats)
operator = sf.form_factor_operator(scene, error=0.01, progress=watch)
assert_type(operator, sf.FormFactorOperator)
assert_type(operator @ np.ones(4), Floats)
assert_type(np.ones(4) @ operator, Floats)
assert_type(operator.T @ np.ones((4, 3)), Floats)
assert_type(operator.shape, tuple[int, int])
assert_type(operator.save("room.npz"), Path)
assert_type(sf.load_operator("room.npz").standard_error(np.ones(4)), Floats)
shiny = floor.replace(specular=0.2, exponent=30)
assert_type(shiny.specular, Floats)
assert_type(shiny.exponent, Floats)
shone, error = sf.reference_radiance(scene, [[0.5, 0.5, 0.0]], [[0, 0, 1]], [[1, 0, 1]], specular=0.1, samples=64)
assert_type(shone, Floats)
irradiance, error = sf.reference_irradiance(scene, [[0.5, 0.5, 0.0]], [[0, 0, 1]], samples=64)
assert_type(error, Floats)
transfer: sf.LocalTransfer = sf.precompute_transfer(scene, "local", bounces=None, epsilon_t=0.2, progress=watch)
distant: sf.DistantTransfer = sf.precompute_transfer(scene, "distant")
radiance = distant.relight(sf.Environment(1.0), rotation=np.eye(3), specular=0.2).radiance_towards([0, 0, 1])
assert_type(radiance, Floats)
daylight: sf.SkyTransfer = sf.precompute_transfer(scene, "sky", patches=577)
coefficients: NDArray[np.float32] = daylight.coefficients([0, 1])
assert_type(daylight.relight(np.ones(len(daylight.patches))), sf.Solution)
assert_type(daylight.relight(hour), sf.Solution)
assert_type(sf.sky_view_factor(scene, "solid_angle", rays=64), Floats)
assert_type(sf.sky_view_factor(floor), Floats)
year = sf.solar_irradiation(scene, (47.4, 8.5), 2025, turbidity=3, transfer=daylight)
assert_type(year, sf.SolarIrradiation)
assert_type(year.total, Floats)
assert_type(year.hourly([0]), sf.SolarHours)
assert_type(year.hourly().total, Floats)
assert_type(sf.solar_irradiation(floor, epw="here.epw", sun_step=2).beam, Floats)
kinds: list[sf.Transfer] = [transfer, distant, daylight]
assert_type(transfer.relight([sf.PointLight([0, 0, 1], 2.0)], reflectance=[0.5, 0.4, 0.3]), sf.Solution)
assert_type(transfer.indirect(sf.PointLight([0, 0, 1], 2.0), bounces=2), Floats)
assert_type(transfer.save("room.transfer"), Path)
assert_type(sf.load_transfer("room.transfer"), sf.Transfer)
path = sf.load_lamps("lights.toml")
assert_type(sf.animate_lamps(transfer, path, "lamp%02d.png", exposure="auto"), list[Path])
moved = sf.animate_lamps(transfer, [point, [point, spot]], "lamp.gif", (80, 60), camera=camera, bounces=2, samples=1)
assert_type(moved, list[Path])
traced = sf.animate_lamps(transfer, path, "lamp%02d.png", direct="traced", penumbra_rays=4, shadow_cell=2)
assert_type(traced, list[Path])
renderer = sf.LampRenderer(transfer, camera, (320, 240), samples=2, shadow_cell=6, progress=watch)
assert_type(renderer.frame([point, spot], background=[0, 0, 1], penumbra_rays=8), NDArray[np.float32])
assert_type(renderer.frame(point, layers=["direct", "depth"], bounces=2), dict[str, NDArray[Any]])
renderer.camera = sf.Camera([0, -2, 1], [0, 0, 0])
assert_type(renderer.timings, dict[str, float])
sf.move_lamps(transfer, [point, spot], camera=camera, stops=1.0, style="disks", screenshot="lamps.png")
turned_sky = sf.animate_environment(distant, sky, "sky.gif", (80, 60), frames=8, turns=0.5, specular=0.2, samples=1)
assert_type(turned_sky, list[Path])
assert_type(sf.animate_environment(distant, np.ones(25), "sky%02d.png", axis=[0, 1, 0], camera=camera), list[Path])
sf.turn_environment(distant, sky, axis=(0, 1, 0), camera=camera, stops=1.0, style="disks", screenshot="sky.png")

# solutions
assert_type(solution.surfels, sf.Surfels)
assert_type(solution.radiosity, Floats)
assert_type(solution.levels, NDArray[np.int32])
assert_type(solution.error, float)
assert_type(solution.timings, dict[str, float])
assert_type(solution.camera, sf.Camera | None)
assert_type(solution.irradiance_at([[0.3, 0.6, 0.0]], [[0, 0, 1]], direct="traced", seed=3), Floats)
assert_type(solution.per_face("direct", object=0), Floats)
picture = solution.render(camera, (400, 300), background=[0, 0, 1], samples=1)
assert_type(picture, NDArray[np.float32])
layers = solution.render(layers=["radiance", "depth"], culling=False)
assert_type(layers["depth"], NDArray[Any])
solution.render(layers=True)
solution.plot("irradiance", receivers=True)
assert_type(solution.to_pyvista("patches").n_points, int)
assert_type(solution.animate(sf.turntable(camera, 12), "turn.gif", fps=12.5, stops=1), list[Path])
assert_type(sf.camera_path([camera, plan], 20, closed=True), list[sf.Camera])
assert_type(solution.save("solved.ply"), Path)
assert_type(sf.load_solution(Path("solved.ply")), sf.Solution)

# Gaussians
gaussians = sf.Gaussians.of(solution, degree=3, exposure=2.0, stops=-1, color_space="linear", progress=watch)
assert_type(gaussians, sf.Gaussians)
assert_type(gaussians.harmonics, Floats)
assert_type(gaussians.degree, int)
assert_type(gaussians.colors_towards([0, 0, 1]), Floats)
assert_type(gaussians.save("room.glb", up=(0, 1, 0)), Path)
assert_type(sf.load_gaussians(Path("room.glb"), up=[0, 1, 0]), sf.Gaussians)
sf.Gaussians(np.zeros((1, 3)), [[1, 1, 1]], [[1, 0, 0, 0]], [0.5], np.zeros((1, 4, 3)), color_space="srgb")

# pictures and views
assert_type(sf.write_image("out.exr", picture, depth=layers["depth"]), Path)
assert_type(sf.write_image("out.png", layers, exposure="auto", stops=-1.0), Path)
assert_type(sf.read_image("out.exr", layer="depth"), NDArray[np.float32])
assert_type(sf.tone_map(picture, exposure=2.0, filmic=False), NDArray[np.float32])
page = sf.Page(solution, colors=["radiosity"], values={"mine": np.ones(4)})
assert_type(sf.Page(distant, environment=sky, axis=[0, 1, 0], colors=["radiosity"]), sf.Page)
assert_type(page.html(), str)
assert_type(page.save("page.html"), Path)
sf.view(scene, style="splats", screenshot="view.png")
assert_type(list(sf.info()), list[str])

try:
    sf.read("missing.ply")
except sf.FileError as fault:
    assert_type(fault.strerror, str | None)
except (sf.Cancelled, sf.DeviceError):
    pass

tiles: sf.SolvedTiles = sf.solve_tiles([Path("a.laz")], "lit", halo=30, lights=[sf.DirectionalLight((0, 0, -1), 1.0)])
tile: sf.SolvedTile = tiles[0]
seconds: float = tile.seconds
