"""The path tracer against Mitsuba 3, another one that shares no code with it, on the same triangles."""

import numpy as np
import pytest

import surflux as sf
from scenes import cube_inside
from surflux.bench import mitsuba_renderer, reference, scenes, solvers

pytest.importorskip("mitsuba")
pytest.importorskip("scipy")
PATHS = 1024


@pytest.fixture(scope="module")
def mitsuba():
    return mitsuba_renderer.load()


def test_a_closed_form_in_mitsuba(mitsuba):
    """E = 1 - rho makes B = H = 1 whatever rho is, on black walls too."""
    rho = np.linspace(0.0, 0.9, 24)
    cube = cube_inside(2, rho, 1 - rho)
    renderer = mitsuba_renderer.Renderer.of_surfels(mitsuba, sf.Scene([cube]))
    places = np.repeat(cube.points[:, None], 1024, axis=1)
    found = renderer.irradiance(places, cube.normals, cube.reflectance, cube.emission, 0, 32, "independent")
    assert found.shape == (24, 32, 3)
    mean, error = found.mean(axis=1), found.std(axis=1, ddof=1) / np.sqrt(32)
    assert np.all(error < 0.1)
    assert np.all(np.abs(mean - 1.0) < 6 * error + 1e-4)


def test_rays_meet_what_they_are_sent_to(mitsuba):
    cube = cube_inside(1)
    shelf = sf.Surfels.from_mesh(([[0, 0, 1e-5], [1, 0, 1e-5], [1, 1, 1e-5], [0, 1, 1e-5]], [[3, 2, 1, 0]]))
    renderer = mitsuba_renderer.Renderer.of_surfels(mitsuba, sf.Scene([cube, shelf]))
    met = renderer.meets(cube.points, cube.normals)
    assert met.tolist() == [True, True, True, True, False, True]  # the shelf's back is in front of the floor


@pytest.mark.slow
def test_light_of_an_image(mitsuba):
    """On planes that face six ways: no image of an Environment stands mirrored, upside down or turned.

    In Mitsuba y is up, and the middle of an image looks along z. It blends pixels, of which there are 32 for each.
    """
    image = np.random.default_rng(3).uniform(0.0, 2.0, (4, 8, 3)).astype(np.float32) ** 4
    bitmap = mitsuba.Bitmap(image.repeat(32, axis=0).repeat(32, axis=1))
    speck = {"type": "sphere", "center": [50, 0, 0], "radius": 0.001}
    theirs = mitsuba.load_dict({"type": "scene", "speck": speck, "sky": {"type": "envmap", "bitmap": bitmap}})
    normals, black = np.concatenate([np.eye(3), -np.eye(3)]), np.zeros((6, 3))
    found = mitsuba_renderer.Renderer(mitsuba, theirs).irradiance(np.zeros((6, 2**14, 3)), normals, black, black, 0, 64)
    disks = sf.Surfels(normals, normals, radii=1e-3)
    ours = sf.solve(sf.Scene([disks], [sf.Environment(image, up=[0, 1, 0], azimuth=-90)]), rays=4096).direct
    error = found.std(axis=1, ddof=1) / np.sqrt(64)
    assert np.all(np.abs(found.mean(axis=1) - ours) < 4.5 * error + 0.003 * ours)  # blended rows are half a pixel off
    assert 4.5 * error.max() < 0.1 * np.ptp(ours, axis=0).min()  # and planes are told apart


def test_scenes_that_are_no_polygons(mitsuba):
    disk = sf.Surfels([[0, 0, 0]], [[0, 0, 1]], radii=1.0)
    for scene in (sf.Scene([disk]), sf.Scene([cube_inside(1)], [sf.PointLight([0.5, 0.5, 0.5], 1.0)])):
        with pytest.raises(ValueError, match="scene: wanted polygons alone, and no lights but those that emit"):
            mitsuba_renderer.Renderer.of_surfels(mitsuba, scene)


def test_reference_in_a_room_of_spheres(mitsuba):
    scene, renderer = reference.room_of_spheres(mitsuba)
    row = reference.compare("room", scene, renderer, PATHS)
    assert row.points == 200
    assert row.passes, row
    # What the comparison could see: walls that are 5 % darker do not pass.
    room = scene.objects[0]
    darker = sf.Surfels.from_mesh((room.triangles.reshape(-1, 3), np.arange(36).reshape(12, 3)))
    assert len(darker) == len(room)
    other = sf.Scene([sf.Surfels.from_mesh(_quads(room), None, 0.95 * room.reflectance), *scene.objects[1:]])
    assert not reference.compare("darker", other, renderer, PATHS).passes


def _quads(s):
    """The quadrilaterals of patches of two triangles each, (vertices, faces)."""
    first, second = s.triangles[::2], s.triangles[1::2]
    vertices = np.concatenate([first, second[:, 2:]], axis=1).reshape(-1, 3)
    return vertices, np.arange(len(vertices)).reshape(-1, 4)


@pytest.mark.scans
def test_reference_in_the_cornell_box_of_mitsuba(mitsuba, scans):
    scene, renderer = reference.cornell(mitsuba)
    row = reference.compare("Cornell box", scene, renderer, PATHS)
    assert row.points == 200
    assert row.passes, row
    # The same triangles: that wall which is not flat could be cut in two ways.
    corners = {_corners(t) for t in scene.objects[5].triangles}
    assert len(corners) == 2
    theirs = []
    for shape in renderer.scene.shapes():
        values = mitsuba.traverse(shape)
        vertices = np.array(values["vertex_positions"]).reshape(-1, 3)
        theirs.append(vertices[np.array(values["faces"]).reshape(-1, 3)])
    assert corners <= {_corners(t) for t in np.concatenate(theirs)}
    assert sum(_area(t) for t in theirs) == pytest.approx(_area(scene.surfels.triangles), rel=1e-6)


def _corners(triangle):
    return frozenset(tuple(corner) for corner in np.round(np.float64(triangle), 2).tolist())


def _area(triangles):
    cross = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    return 0.5 * np.linalg.norm(cross, axis=1).sum()


def test_rows_of_mitsuba(mitsuba):
    if not mitsuba_renderer.is_vectorized(mitsuba):
        pytest.skip("needs Mitsuba's llvm variant")
    mode = solvers.Mode(32, 4, {}, {}, False, (16, 256), 4)
    built = scenes.build("concentric spheres", 0.25)
    few, many = solvers.of_mitsuba(mitsuba, "concentric spheres", built, mode, 1, None)
    assert (few.surfels, few.solver, few.value, many.value) == (len(built.scene.surfels), "Mitsuba", "16", "256")
    assert few.error > 2.0 * many.error > 0.0  # 16 times the samples, without a bias: a quarter in the mean
    assert many.error < 0.1
