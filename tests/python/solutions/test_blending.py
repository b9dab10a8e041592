"""Which surfels blend in pictures: those of one object, and of a mesh those of one material."""

import pickle

import numpy as np
import pytest

import surflux as sf
from surflux.scenes import shapes
from surflux.solutions.blending import blended_groups
from surflux.solutions.painting import Painter

CAMERA, SIDE = sf.Camera([0.5, -1.5, 0.5], [0.5, 0, 0.5], fov=40), 120
CELLS, WHITE, BLACK = 12, 0.8, 0.02


def wall(reflectance=None):
    """A white square in the plane y = 0, in cells, with a black pane in its middle."""
    x = np.linspace(0, 1, CELLS + 1)
    vertices = np.stack([*np.meshgrid(x, [0.0], x, indexing="ij")], -1).reshape(-1, 3)
    corner = (np.arange(CELLS)[:, None] * (CELLS + 1) + np.arange(CELLS)).ravel()[:, None]
    faces = corner + np.array([0, CELLS + 1, CELLS + 2, 1])
    middles = vertices[faces].mean(axis=1)
    pane = np.abs(middles - [0.5, 0, 0.5]).max(axis=1) < 0.25
    reflectance = np.where(pane, BLACK, WHITE) if reflectance is None else reflectance
    return sf.Surfels.from_mesh((vertices, faces), patch_area=1.01 / CELLS**2, reflectance=reflectance)


def places():
    """(x, z) that the pixels of a picture see of the wall, and their reflectance; 0 beside it."""
    half = 1.5 * np.tan(np.radians(20))
    at = ((np.arange(SIDE) + 0.5) / SIDE * 2 - 1) * half
    x, z = np.meshgrid(0.5 + at, 0.5 - at)
    off = np.maximum(np.abs(x - 0.5), np.abs(z - 0.5))
    return x, z, np.where(off < 0.25, BLACK, np.where(off < 0.5, WHITE, 0.0))


@pytest.fixture(scope="module")
def lit_evenly():
    """Where all surfaces have H = pi."""
    return sf.solve(sf.Scene([wall()], lights=[sf.Environment(1.0)]))


def test_what_is_painted_on_a_face_ends_where_the_face_does(lit_evenly):
    *_, rho = places()
    for layer in ("radiance", "albedo", "direct"):
        picture = lit_evenly.render(CAMERA, (SIDE, SIDE), samples=1, layers=[layer])[layer]
        np.testing.assert_allclose(picture[..., 1], rho, atol=1e-3)
    flat = Painter().layers(lit_evenly, CAMERA, (SIDE, SIDE), samples=1, layers=["radiance"])["radiance"]
    np.testing.assert_allclose(flat[..., 1], rho, atol=1e-3)


def test_light_beside_another_material_is_that_of_surfels_of_the_own():
    """Of a lamp before the wall, I cos / d^2. Blended across, white beside the pane is off by 20 % (RMS)."""
    lamp = np.array([0.8, -0.4, 0.7])
    solution = sf.solve(sf.Scene([wall()], lights=[sf.PointLight(lamp, 1.0)]), insert=False)
    x, z, rho = places()
    away = np.stack([x - lamp[0], 0 * x - lamp[1], z - lamp[2]], axis=-1)
    wanted = rho / np.pi * -lamp[1] / np.linalg.norm(away, axis=-1) ** 3
    found = solution.render(CAMERA, (SIDE, SIDE), samples=1)[..., 1]
    assert np.sqrt(np.mean((found - wanted) ** 2) / np.mean(wanted**2)) < 0.05


def test_a_meshless_basis_is_drawn_with_the_colour_of_the_face():
    solution = sf.solve_meshless(sf.Scene([wall()], lights=[sf.Environment(1.0)]), levels=1, rays=16)
    *_, rho = places()
    found = solution.render(CAMERA, (SIDE, SIDE), samples=1, layers=["albedo"])["albedo"]
    np.testing.assert_allclose(found[..., 1], rho, atol=1e-3)


def groups_of(objects, dark=None):
    surfels = sf.Scene(objects).surfels
    surfels = surfels.replace(areas=np.ones(len(surfels)))
    objects = np.repeat(np.arange(len(objects)), [len(one) for one in objects])
    light = np.ones((len(surfels), 3))
    solution = sf.Solution(
        surfels, parents=np.arange(len(surfels)), objects=objects, radiosity=light, irradiance=light, direct=light
    )
    return blended_groups(solution, dark)


def parts(groups):
    return np.unique(groups, return_inverse=True)[1]


def test_meshes_of_many_colours_and_disks_blend_as_a_whole():
    colours = np.random.default_rng(0).uniform(0.1, 0.9, (CELLS**2, 3))
    assert len(set(groups_of([wall(colours)]))) == 1
    ball = shapes.sphere(100).replace(reflectance=np.where(np.arange(100) < 50, 0.2, 0.8))
    assert len(set(groups_of([ball]))) == 1
    # Each object goes by its own.
    found = groups_of([wall(colours), ball, wall()])
    np.testing.assert_array_equal(parts(found[:-144]), np.repeat([0, 1], [144, 100]))
    assert len(set(found)) == 4
    assert [np.count_nonzero(found == k) for k in np.unique(found[-144:])] in ([36, 108], [108, 36])


def test_rounding_parts_nothing():
    """What was inserted has means of the reflectance of what it stands for; a file has them in 7 digits."""
    cells = 0.3 * (1 + np.random.default_rng(0).uniform(-1e-15, 1e-15, (CELLS**2, 1))) * np.ones(3)
    one = wall(np.where(np.arange(CELLS**2)[:, None] < 40, cells, cells.astype(np.float32)))
    assert set(groups_of([one.replace(emission=5 * one.reflectance)])) == {0}


def test_what_is_dark_or_shines_is_by_itself():
    dark = np.arange(144) % 2 == 0
    white = (wall().reflectance[:, 0] == WHITE).astype(int)
    assert len(set(groups_of([wall()], dark))) == len(set(zip(dark, white, strict=True))) == 4
    shining = wall(WHITE).replace(emission=np.where(np.arange(144) < 20, 1.0, 0.0))
    np.testing.assert_array_equal(parts(groups_of([shining])) == parts(groups_of([shining]))[0], np.arange(144) < 20)


def test_no_light_comes_through_beneath_a_wall():
    """A wall stands on a floor, a bright lamp on one side and a dim one on the other."""
    floor = sf.Surfels.from_mesh(([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [[0, 1, 2, 3]]), 0.01)
    wall = sf.Surfels.from_mesh(
        ([[0, -1, 0], [0, 1, 0], [0, 1, 0.5], [0, -1, 0.5]], [[0, 1, 2, 3]]), 0.01, two_sided=True
    )
    lamps = [sf.PointLight([0.5, 0, 0.2], 10.0), sf.PointLight([-0.5, 0, 0.2], 0.1)]
    solution = sf.solve(sf.Scene([floor, wall], lamps))
    camera = sf.Camera([-0.2, 0, 2], [-0.2, 0, 0], [0, 1, 0], fov=40)
    picture = solution.render(camera, (120, 90), layers=["radiance", "index"])
    of_dim_side = (solution.objects == 0) & (solution.surfels.points[:, 0] < 0)
    brightest = solution.radiosity[of_dim_side].max() / np.pi
    dim = (picture["index"] >= 0) & of_dim_side[picture["index"]]
    assert dim.sum() > 1000
    assert picture["radiance"][dim].max() <= 1.0001 * brightest < 0.1 * picture["radiance"].max()
    again = pickle.loads(pickle.dumps(solution)).render(camera, (120, 90))
    np.testing.assert_array_equal(again, picture["radiance"])


@pytest.mark.filterwarnings("ignore:backs of surfaces absorb")
@pytest.mark.parametrize("solve", [sf.solve, sf.solve_meshless])
@pytest.mark.parametrize("gap", [0.01, 0.03])
def test_a_picture_before_a_wall_of_its_mesh_takes_nothing_of_its_shadow(solve, gap):
    """Its borders were a third too dark: the wall behind it, which it shades, lies within a kernel's reach."""
    x = np.linspace(0, 1, 9)
    grid = np.stack([*np.meshgrid(x, [0.0], x, indexing="ij")], -1).reshape(-1, 3)
    corner = (np.arange(8)[:, None] * 9 + np.arange(8)).ravel()[:, None]
    faces = corner + np.array([0, 9, 10, 1])
    hung = faces[np.abs(grid[faces].mean(axis=1) - [0.5, 0, 0.5]).max(axis=1) < 0.26] + len(grid)
    mesh = np.concatenate([grid, grid - [0, gap, 0]]), np.concatenate([faces, hung])
    lamp = [sf.PointLight([0.5, -3.0, 3.5], 1.0)]
    options = {"insert": False} if solve is sf.solve else {}
    found = solve(sf.Scene([sf.Surfels.from_mesh(mesh)], lamp), **options)
    alone = solve(sf.Scene([sf.Surfels.from_mesh((mesh[0], hung))], lamp), **options)
    camera = sf.Camera([0.5, -1.5, 0.5], [0.5, 0, 0.5], fov=14)  # of which the picture fills all but the rim
    pictures = [s.render(camera, (SIDE, SIDE), samples=1, layers=["direct", "depth"]) for s in (found, alone)]
    on_it = np.abs(pictures[0]["depth"] - (1.5 - gap)) < 1e-3
    assert on_it.sum() > 0.5 * SIDE**2
    np.testing.assert_allclose(pictures[0]["direct"][on_it], pictures[1]["direct"][on_it], rtol=0.01)
