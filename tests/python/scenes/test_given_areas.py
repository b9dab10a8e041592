import numpy as np
import pytest

import surflux as sf
from surflux.scenes.coincidence import coincidence_of


def ball(n, center=(0.0, 0.0, 0.0), **options):
    normals = np.random.default_rng(0).normal(size=(n, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    return sf.Surfels(np.asarray(center) + normals, normals=normals, **options)


def with_areas(surfels, factor):
    surfels.areas = factor * sf.effective_areas(surfels)
    return surfels


SOLVERS = {
    "rays": lambda scene: sf.solve(scene, rays=16, insert=False),
    "pairs": lambda scene: sf.solve(scene, transport="pairs", insert=False),
    "meshless": lambda scene: sf.solve_meshless(scene, bounces=1),
    "operator": lambda scene: sf.form_factor_operator(scene, rays=16),
    "transfer": lambda scene: sf.precompute_transfer(scene, "local", bounces=1),
    "reference": lambda scene: sf.reference_irradiance(scene, [[0, 0, 1.1]], [[0, 0, 1]], samples=16),
}


@pytest.mark.parametrize("solver", SOLVERS)
def test_areas_that_do_not_fit_the_disks_are_named(solver):
    scene = sf.Scene([ball(300, (5, 0, 0)), with_areas(ball(400, emission=1.0), 1.25)])
    with pytest.warns(
        UserWarning, match=r"object 1: by their areas, its disks that emit send 1\.25 times what rays meet"
    ):
        SOLVERS[solver](scene)


@pytest.mark.parametrize("lighting", ["local", "distant", "sky"])
def test_without_any_area_no_light_is_transferred(lighting):
    scene = sf.Scene([ball(300, areas=0.0)])
    with pytest.raises(ValueError, match=r"^areas: wanted some above 0, got 0 for all surfels$"):
        sf.precompute_transfer(scene, lighting)


def test_given_areas_are_held_against_some_of_many_disks():
    scene = sf.Scene([with_areas(ball(35_000, emission=2.0), 0.8)])
    assert scene._coincidence().unlike_areas == [(0, pytest.approx(0.8, abs=1e-3))]
    found, lines = coincidence_of(scene)
    assert found["unlike_areas"][0]["object"] == 0
    assert any("emit send 0.8 times" in line for line in lines)


def test_areas_that_fit_or_send_nothing_pass_without_a_word():
    """Of a coarse grid of cells the exact areas are a fifth more than those of its disks: told where it emits alone."""
    cloud = ball(1000, emission=1.0)
    paper = ball(1000, (5, 0, 0), emission=1.0)
    paper.areas = sf.effective_areas(paper, method="paper")
    middles = np.stack(np.meshgrid(np.arange(10) + 0.5, np.arange(10) + 0.5, [-3.0]), axis=-1).reshape(-1, 3)
    grid = sf.Surfels(middles, normals=[[0, 0, 1]] * 100, areas=1.0)
    mesh = sf.Surfels.from_mesh(([[9, 0, 0], [10, 0, 0], [10, 1, 0]], [[0, 1, 2]]), 0.25)
    scene = sf.Scene([with_areas(cloud, 1.0), paper, mesh, grid])
    assert scene._coincidence().unlike_areas == []
    assert sf.Scene([grid.replace(emission=1.0)])._coincidence().unlike_areas == [(0, pytest.approx(1.2, abs=0.02))]
    solution = sf.solve(scene, rays=16)
    assert sf.Scene([solution.surfels])._coincidence().unlike_areas == []


def test_disks_that_lie_in_one_place_share_what_was_given():
    cloud = ball(500)
    twice = sf.Surfels(np.tile(cloud.points, (2, 1)), normals=np.tile(cloud.normals, (2, 1)), radii=0.2, emission=1.0)
    assert sf.Scene([with_areas(twice, 1.0)])._coincidence().unlike_areas == []


@pytest.mark.parametrize("side", [0, 1])
def test_disks_that_emit_are_those_that_are_looked_at(side):
    """Of two sides that lie beside each other in whatever order, and of few lamps among many points."""
    points = np.column_stack([np.random.default_rng(0).random((12_000, 2)), np.zeros(12_000)])
    sheet = sf.Surfels(points, normals=[[0, 0, 1]] * 12_000, two_sided=True)
    sheet.areas = 2.0 * sf.effective_areas(sheet)
    shines = np.arange(24_000) // 12_000 == side
    emission = np.where(shines[:, None], 1.0, 0.0) * np.ones(3)
    assert sf.Scene([sheet.replace(emission=emission)])._coincidence().unlike_areas == [(0, pytest.approx(2.0))]
    lamps = np.zeros((24_000, 3))
    lamps[[5, 777, 11_000]] = 100.0
    assert sf.Scene([sheet.replace(emission=lamps)])._coincidence().unlike_areas == [(0, pytest.approx(2.0))]


def test_tiny_disks_with_areas_of_their_own_are_taken():
    tiny = sf.Surfels(np.eye(3), normals=np.eye(3), radii=1e-31, areas=0.1)
    assert sf.Scene([tiny])._coincidence().unlike_areas == []
