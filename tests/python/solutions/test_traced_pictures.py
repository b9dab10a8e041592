"""Pictures of `solve` with direct light by rays from every subpixel."""

import numpy as np
import pytest

import surflux as sf
from surflux.bench.pictures import unproject

SUN = sf.DirectionalLight([0.9, 0.1, -1.0], 5.0)
CAMERA = sf.Camera([0.5, -0.9, 1.3], [0.5, 0.5, 0.1], fov=50)
FROM_BELOW = sf.Camera([0.5, -1.2, 0.25], [0.5, 0.5, 0.4], fov=60)  # sees the front of a lamp


def floor_and_shelf(lights=(SUN,)):
    """A floor of coarse patches, and over it a black square, which casts a shadow beside it."""
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    floor = sf.Surfels.from_mesh((square, [[0, 1, 2, 3]]), patch_area=0.01, reflectance=[0.8, 0.5, 0.2])
    shelf = sf.Surfels.from_mesh((0.3 * square + [0.1, 0.4, 0.3], [[0, 1, 2, 3]]), reflectance=0.0, two_sided=True)
    return sf.Scene([floor, shelf], lights=list(lights), camera=CAMERA)


@pytest.mark.parametrize("camera", [CAMERA, sf.Camera([0.5, -0.9, 1.3], [0.5, 0.5, 0.1], height=1.4)])
@pytest.mark.parametrize("solver", [sf.solve, sf.solve_meshless])
def test_borders_of_shadows_are_where_the_light_has_them(solver, camera):
    if solver is sf.solve_meshless and camera is not CAMERA:
        pytest.skip("a basis is drawn in perspective alone")
    size = (160, 120)
    found = solver(floor_and_shelf()).render(camera, size, samples=1, layers=True, direct="traced")
    on_floor = (found["index"] >= 0) & (found["albedo"][..., 0] > 0.5)
    if camera.height is None:
        places = unproject(camera, found["depth"], size)[on_floor]
    else:  # x, y in the image, from its middle, along the axes of the view
        forward = np.subtract(camera.target, camera.eye) / np.linalg.norm(np.subtract(camera.target, camera.eye))
        right = np.cross(forward, [0, 0, 1]) / np.linalg.norm(np.cross(forward, [0, 0, 1]))
        y, x = np.nonzero(on_floor)
        step = camera.height / size[1]
        across = (x + 0.5 - size[0] / 2)[:, None] * right + (y + 0.5 - size[1] / 2)[:, None] * np.cross(forward, right)
        places = np.array(camera.eye) + step * across + found["depth"][on_floor][:, None] * forward
    assert np.abs(places[:, 2]).max() < 1e-5
    above = places[:, :2] - 0.3 * np.array([0.9, 0.1])  # where the light passes the height of the shelf
    inside = np.minimum(above - [0.1, 0.4], [0.4, 0.7] - above).min(axis=1)  # by how far it meets it
    clear = np.abs(inside) > 1e-4
    lit = 5.0 / np.sqrt(1 + 0.9**2 + 0.1**2)
    expected = np.where(inside < 0, lit, 0.0)[:, None] * [0.8, 0.5, 0.2] / np.pi
    assert (inside > 0).sum() > 200
    np.testing.assert_allclose(found["direct"][on_floor][clear], expected[clear], rtol=1e-5, atol=1e-6)


LIGHTS = {
    "sky": [sf.Environment(1.0)],
    "lamp": [sf.AreaLight([0.3, 0.3, 0.9], [0, 0.4, 0], [0.4, 0, 0], 12.0)],
    "sky and point": [sf.Environment(1.0), sf.PointLight([0.7, 0.2, 0.9], 1.0)],
}


@pytest.mark.parametrize("lights", LIGHTS)
def test_every_light_is_in_the_picture_once(lights):
    """On patches and on disks, with insertion, and relit."""
    floor = floor_and_shelf().objects[0]
    n = 300
    z = 1 - (2 * np.arange(n) + 1) / n
    phi = np.arange(n) * np.pi * (3 - np.sqrt(5))
    r = np.sqrt(1 - z * z)
    normals = np.stack([r * np.cos(phi), r * np.sin(phi), z], 1)
    ball = sf.Surfels([0.5, 0.5, 0.2] + 0.2 * normals, normals=normals, reflectance=0.5, emission=0.3)
    scene = sf.Scene([floor, ball], lights=LIGHTS[lights], camera=FROM_BELOW)
    solutions = [sf.solve(scene), sf.solve(scene, insert=False)]
    if lights == "lamp":
        solutions.append(sf.precompute_transfer(scene).relight(LIGHTS[lights]))
    for solution in solutions:
        one, other = (solution.render(size=(120, 90), layers=True, direct=how) for how in ("interpolated", "traced"))
        for name in ("albedo", "indirect", "alpha", "depth", "normal", "index"):
            np.testing.assert_allclose(other[name], one[name], rtol=1e-5, atol=1e-6)
        np.testing.assert_allclose(other["radiance"], other["direct"] + other["indirect"], rtol=1e-6)
        assert other["direct"].mean() == pytest.approx(one["direct"].mean(), rel=0.03)
        assert (other["level"] == one["level"])[one["index"] >= 0].all()
        lamps = one["index"] < -1
        assert lamps.any() == (lights == "lamp")
        np.testing.assert_allclose(other["radiance"][lamps], one["radiance"][lamps], rtol=1e-5)


def test_a_solution_from_a_file_has_no_scene_to_trace_in(tmp_path):
    sf.solve(floor_and_shelf()).save(tmp_path / "floor.ply")
    with pytest.raises(ValueError, match=r"^direct: wanted \"interpolated\", for a solution from a file has no scene"):
        sf.load_solution(tmp_path / "floor.ply").render(direct="traced")


def test_it_tells_how_far_it_is_and_can_be_cancelled():
    solution = sf.solve(floor_and_shelf())
    told = []
    solution.render(size=(40, 30), direct="traced", progress=lambda done, total: told.append((done, total)))
    assert told[-1] == (30, 30)
    with pytest.raises(sf.Cancelled):
        solution.render(size=(40, 30), direct="traced", progress=lambda done, total: False)


@pytest.mark.parametrize("solver", [sf.solve, sf.solve_meshless])
def test_backs_are_seen_in_the_light_of_their_fronts(solver):
    from_below = sf.Camera([0.6, 0.3, -1.5], [0.6, 0.3, 0.0], up=(0, 1, 0), fov=30)
    solution = solver(floor_and_shelf())
    one, other = (
        solution.render(from_below, (60, 60), layers=["direct"], culling=False, direct=how)["direct"]
        for how in ("interpolated", "traced")
    )
    assert one.mean() > 0.1
    assert other.mean() == pytest.approx(one.mean(), rel=0.03)


def test_frames_of_a_film_are_traced(tmp_path):
    transfer = sf.precompute_transfer(sf.Scene(floor_and_shelf().objects, camera=CAMERA), "distant")
    sky, size, means = sf.Environment(1.0), (40, 30), []
    for how in ({}, {"direct": "traced", "rays": 16}):
        paths = sf.animate_environment(transfer, sky, tmp_path / "sky%02d.exr", size, frames=2, **how)
        means.append(sf.read_image(paths[1]).mean())
    assert means[1] == pytest.approx(means[0], rel=0.05)


def test_a_band_can_be_cancelled():
    solution = sf.solve(floor_and_shelf([sf.Environment(1.0)]))
    told = []

    def stop_soon(done, total):
        told.append(done)
        return len(told) < 4

    with pytest.raises(sf.Cancelled):
        solution.render(size=(100, 80), samples=1, direct="traced", rays=256, progress=stop_soon)
    assert set(told) == {0}  # of the first of one band


def test_places_on_patches_are_in_their_planes_whatever_depths_are_off_by():
    """By as much as those of a GPU, which is more than what touches a surface."""
    surfels, size = floor_and_shelf().objects[0], (60, 40)
    drawn = sf.solve(floor_and_shelf(), insert=False).render(CAMERA, size, samples=1, layers=["depth", "index"])
    index = np.where(drawn["index"] < len(surfels), drawn["index"], -1)
    off = 1e-5 * np.random.default_rng(0).uniform(-1, 1, index.shape)
    depth = np.where(index >= 0, drawn["depth"] + off, np.inf).astype(np.float32)
    places = sf._core.seen_places(surfels._core, CAMERA._to_core(), *size, 0, depth, index)
    assert (index >= 0).sum() > 300
    assert np.abs(places[index >= 0][:, 2]).max() < 1e-12
    assert np.abs(unproject(CAMERA, depth, size)[index >= 0][:, 2]).max() > 1e-6
    assert np.all(places[index < 0] == 0)
