"""Surfaces that lie in one place: each has the light that it would have alone, once, on its own side."""

import json

import numpy as np
import pytest
from numpy.testing import assert_allclose

import surflux as sf
from quick import quick
from scenes import patch
from surflux.cli import commands
from surflux.scenes.coincidence import coincidence_of

SQUARE = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]
CARPET = [[-0.43, -0.5, 0], [0.57, -0.5, 0], [0.57, 0.5, 0], [-0.43, 0.5, 0]]
LAMP = {"corner": [-0.4, -0.2, 0.5], "edge_u": [0, 0.6, 0], "edge_v": [0.9, 0, 0], "exitance": 2.0}
TABLE = [[0, 1, 2, 3], [4, 5, 6, 7]]

SOLVERS = {
    "pairs": lambda scene: sf.solve(scene, transport="pairs", insert=False, tolerance=1e-7),
    "rays": lambda scene: sf.solve(scene, transport="rays", insert=False, tolerance=1e-7),
    "meshless": lambda scene: sf.solve_meshless(scene, levels=2, tolerance=1e-7),
}
every_solver = pytest.mark.parametrize("solver", SOLVERS.values(), ids=SOLVERS)


def carpeted(height=0.0, turned=False):
    """A floor of 2 x 2 with a carpet of 1 x 1 in the same mesh."""
    vertices = SQUARE + [[x, y, height] for x, y, _ in CARPET]
    faces = [TABLE[0], TABLE[1][::-1] if turned else TABLE[1]]
    return sf.Surfels.from_mesh((vertices, faces), patch_area=0.02)


def alone(corners):
    return sf.Surfels.from_mesh((corners, [[0, 1, 2, 3]]), patch_area=0.02)


def box(emission=1.0, rho=0.5, n=5):
    """The inside of a unit cube whose floor alone glows: the floor first, then the rest."""
    x, y, z, o = np.array([1.0, 0, 0]), np.array([0, 1.0, 0]), np.array([0, 0, 1.0]), np.zeros(3)
    faces = [(z, y, x), (o, y, z), (x, z, y), (o, z, x), (y, x, z)]
    return [patch(o, x, y, rho, emission, n**-2), *(patch(*f, rho, 0.0, n**-2) for f in faces)]


@pytest.mark.slow
@every_solver
@pytest.mark.parametrize("height", [0.0, 1e-7, -1e-7])
def test_a_carpet_in_a_floor_of_one_mesh(solver, height):
    scene = sf.Scene([carpeted(height)], [sf.AreaLight(**LAMP)])
    # Unoccluded means over patches are a sum of closed forms in float64: what each has alone.
    apart = [solver(sf.Scene([alone(part)], [sf.AreaLight(**LAMP)])).direct for part in (SQUARE, CARPET)]
    solution = solver(scene)
    assert np.allclose(solution.direct, np.concatenate(apart), rtol=1e-6, atol=0)
    assert np.isclose(solution.surfels.areas.sum(), 4.0, rtol=1e-8)


def test_the_reference_finds_the_same_on_either():
    points = [[0.05, 0.05, 0.0], [0.3, 0.3, 0.0], [-0.8, 0.7, 0.0]]
    lamp = [sf.AreaLight(**LAMP)]
    both, one = (
        sf.reference_irradiance(sf.Scene([s], lamp), points, [[0, 0, 1]] * 3, samples=64)[0]
        for s in (carpeted(), alone(SQUARE))
    )
    assert np.array_equal(both, one)


@every_solver
def test_one_floor_as_two_objects(solver):
    solution = solver(sf.Scene([alone(SQUARE), alone(SQUARE)], [sf.Environment(1.0)]))
    assert np.allclose(solution.irradiance, np.pi, rtol=1e-6)
    assert np.isclose(solution.surfels.areas.sum(), 4.0, rtol=1e-8)


@pytest.mark.slow
@every_solver
def test_what_is_covered_twice_sends_once(solver):
    walls = box()
    once, twice = solver(sf.Scene(walls)), solver(sf.Scene([*walls, walls[0]]))
    n = len(once.irradiance)
    weight = once.surfels.areas[:, None]
    # Pairs exchange the same light but for a billionth; rays are drawn anew for each surfel, and noise of 256 of them,
    # of a share of .2 of the hemisphere, is below .5 sqrt(.8 / (.2 * 256)) = 6 % of a surfel's, .5 % of 125.
    off = np.sqrt((weight * (twice.irradiance[:n] - once.irradiance) ** 2).sum() / (weight * once.irradiance**2).sum())
    assert off < (1e-6 if solver is SOLVERS["pairs"] else 0.06)
    means = [(weight * s.irradiance[:n]).sum() / weight.sum() for s in (once, twice)]
    assert np.isclose(*means, rtol=1e-6 if solver is SOLVERS["pairs"] else 0.01)
    assert np.isclose(twice.surfels.areas.sum(), 6.0, rtol=1e-8)


def test_the_later_of_two_is_on_top():
    # Of a white floor and a black one in the same place, the later one sends.
    black, white = (patch([-1, -1, 0], [2, 0, 0], [0, 2, 0], rho, 0.0, 0.1) for rho in (0.0, 0.8))
    wall = patch([-1, -1, 0.1], [0, 2, 0], [0, 0, 1], 0.0, 0.0, 0.1)
    sun = [sf.DirectionalLight([0.1, 0, -1], 1.0)]
    points, normals = wall.points, wall.normals
    found = [
        sf.reference_irradiance(sf.Scene([*floors, wall], sun), points, normals, samples=64)[0].mean()
        for floors in ((black, white), (white, black), (white,))
    ]
    assert found[0] == found[2] > 0.0
    assert found[1] == 0.0


@every_solver
def test_faces_that_face_opposite_ways_are_the_sides_of_a_sheet(solver):
    solution = solver(sf.Scene([carpeted(turned=True)], [sf.AreaLight(**LAMP)]))
    floor = len(alone(SQUARE))
    expected = solver(sf.Scene([alone(SQUARE)], [sf.AreaLight(**LAMP)]))
    assert_allclose(solution.direct[:floor], expected.direct, rtol=1e-6)
    assert not solution.direct[floor:].any()  # the light is over the floor
    assert np.isclose(solution.surfels.areas.sum(), 5.0, rtol=1e-12)


SHEETS = {
    "two-sided": lambda up, down: [sf.Surfels.from_mesh(up, patch_area=0.01, two_sided=True)],
    "one mesh": lambda up, down: [sf.Surfels.from_mesh((up[0], up[1] + down[1]), patch_area=0.01)],
    "concatenated": lambda up, down: [sf.concatenate([sf.Surfels.from_mesh(m, patch_area=0.01) for m in (up, down)])],
    "two objects": lambda up, down: [sf.Surfels.from_mesh(m, patch_area=0.01) for m in (up, down)],
    "other patches": lambda up, down: [sf.Surfels.from_mesh(up, patch_area=0.01), sf.Surfels.from_mesh(down, 0.003)],
}


@pytest.mark.slow
@pytest.mark.parametrize("sheet", SHEETS.values(), ids=SHEETS)
def test_a_sheet_between_two_plates_has_the_view_factors_of_squares(sheet):
    def square(z, *faces):
        return np.array([[0, 0, z], [1, 0, z], [1, 1, z], [0, 1, z]]), list(faces)

    up, down = [0, 1, 2, 3], [3, 2, 1, 0]
    plates = [sf.Surfels.from_mesh(square(0.0, up), 0.01), sf.Surfels.from_mesh(square(1.0, down), 0.01)]
    scene = sf.Scene([*plates, *sheet(square(0.5, up), square(0.5, down))])
    s = scene.surfels
    middle, normals = np.abs(s.points[:, 2] - 0.5) < 1e-6, s.normals[:, 2]
    expected = 0.415253  # unit squares .5 apart, Howell C-11
    factors, operator = sf.form_factors(scene), sf.form_factor_operator(scene, rays=256)
    for first, side in ((0, middle & (normals < 0)), (100, middle & (normals > 0))):
        plate = slice(first, first + 100)
        assert np.isclose(factors[plate][:, side].sum(axis=1).mean(), expected, atol=1e-3)
        assert np.isclose((operator @ side.astype(float))[plate].mean(), expected, atol=4e-3)


@pytest.mark.slow
@pytest.mark.parametrize("gap", quick(0.0, of=[0.0, 1e-12, 1e-7, -1e-12, -1e-7]))
@every_solver
def test_adjoining_rooms_have_the_light_of_each_alone(solver, gap):
    """Walls back to back, at one place or by what rays take for one apart or into each other."""
    first = unit_room(0.0)
    alone = solver(sf.Scene([first], [sf.PointLight([0.5, 0.5, 0.5], 1.0)]))
    lights = [sf.PointLight([x, 0.5, 0.5], 1.0) for x in (0.5, 1.5 + gap)]
    scene = sf.Scene([first, unit_room(1.0 + gap)], lights)
    both = solver(scene)
    n = len(first)
    assert np.isclose(both.history[-1]["power_in"], 2 * alone.history[-1]["power_in"], rtol=2e-3)
    for part in (slice(0, n), slice(n, 2 * n)):
        assert_allclose(both.direct[part], alone.direct, rtol=1e-3)
        assert np.isclose(both.irradiance[part].mean(), alone.irradiance.mean(), rtol=5e-3)
    wall = np.flatnonzero(np.abs(first.points[:, 0] - 1.0) < 1e-9)[:5]
    found, error = sf.reference_irradiance(scene, first.points[wall], first.normals[wall], samples=1024)
    assert (np.abs(found - alone.irradiance[wall])[:, 0] < 4 * error[:, 0] + 0.03 * found[:, 0]).all()


def unit_room(x):
    """The inside of a unit cube from x on."""
    corners = np.add([[i, j, k] for k in (0, 1) for j in (0, 1) for i in (0, 1)], [x, 0, 0])
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return sf.Surfels.from_mesh((corners, faces), patch_area=0.04, reflectance=0.6)


def test_check_names_what_coincides(tmp_path, capsys):
    corners = "".join(f"v {x} {y} {z}\n" for x, y, z in SQUARE + CARPET)
    (tmp_path / "floor.obj").write_text(corners + "f 1 2 3 4\nf 5 6 7 8\n")
    path = tmp_path / "scene.toml"
    path.write_text('[[object]]\nfile = "floor.obj"\nkind = "mesh"\npatch_area = 0.02\n')
    assert commands.main(["check", str(path)]) == 0
    out = capsys.readouterr().out
    # Patches of the floor, .1414 wide at most, that the carpet of 1 x 1 touches; centred as it is but for their size.
    assert "patches coincide with later ones that face the same way (1 of area), around (" in out
    assert commands.main(["check", str(path), "--json"]) == 0
    covered = json.loads(capsys.readouterr().out)["covered"]
    inner, outer = (1 - 2 * 0.15) ** 2 / 0.02, (1 + 2 * 0.15) ** 2 / 0.018
    assert inner < covered < outer
    assert commands.main(["check", str(path), "-o", str(tmp_path / "out.ply")]) == 2
    assert "--output: is for a cloud" in capsys.readouterr().err


def ball(n, seed):
    points = np.random.default_rng(seed).normal(size=(n, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    return sf.Surfels(points, points)


def scan(seed, height=0.0, noise=1e-4, n=24):
    """A floor of 1 x 1, one point in each of n x n cells, with noise in height."""
    random = np.random.default_rng(seed)
    cells = np.stack(np.meshgrid(np.arange(n), np.arange(n)), -1).reshape(-1, 2)
    points = np.c_[(cells + random.uniform(0.2, 0.8, cells.shape)) / n, height + noise * random.normal(size=n * n)]
    return sf.Surfels(points, [[0, 0, 1]] * n * n)


@every_solver
@pytest.mark.parametrize("sizes", [(500, 500), (400, 1200)])
def test_two_scans_of_a_ball(solver, sizes):
    solution = solver(sf.Scene([ball(n, seed) for seed, n in enumerate(sizes)], [sf.Environment(1.0)]))
    assert np.allclose(solution.irradiance, np.pi, rtol=1e-6)
    # Two layers everywhere: half of either, whose areas add up to within .3 % (DESIGN section 6: a random torus).
    assert np.isclose(solution.surfels.areas.sum(), 4 * np.pi, rtol=0.003)


@pytest.mark.slow
@every_solver
def test_two_scans_of_a_floor_with_noise(solver):
    one = solver(sf.Scene([scan(1)], [sf.Environment(1.0)]))
    both = solver(sf.Scene([scan(1), scan(2)], [sf.Environment(1.0)]))
    # Noise of .1 mm over disks of some 4 cm hides no more than its slope: 2 * 1e-4 / .04 of the cosine-weighted sky.
    assert np.abs(both.irradiance / np.pi - 1).max() < 0.01
    # Together they reach somewhat farther than either, and not beyond the square that both were drawn from.
    assert one.surfels.areas.sum() < both.surfels.areas.sum() < 1.0


def test_the_reference_over_two_scans():
    floors = [scan(1), scan(2)]
    points, normals = floors[0].points[::20], floors[0].normals[::20]
    irradiance, _ = sf.reference_irradiance(sf.Scene(floors, [sf.Environment(1.0)]), points, normals, samples=256)
    assert np.abs(irradiance / np.pi - 1).max() < 0.01


def test_a_thin_sheet_on_a_floor_covers_it_and_is_spoken_of():
    # Ten times the noise above, a fortieth of a disk: a sheet, or a scan that is misplaced.
    scene = sf.Scene([scan(1), scan(2, height=1e-3)], [sf.Environment(1.0)])
    message = r"objects 0 and 1: \d+ points of them lie some 0.001 over or under"
    with pytest.warns(UserWarning, match=message):
        solution = sf.solve(scene, transport="rays", insert=False)
    n = len(scene.objects[0])
    floor, sheet = solution.irradiance[:n] / np.pi, solution.irradiance[n:] / np.pi
    inner = np.all(np.abs(scene.objects[0].points[:, :2] - 0.5) < 0.45, axis=1)
    assert floor[inner].max() < 0.05
    assert sheet.min() > 0.99
    with pytest.warns(UserWarning, match=message):
        sf.reference_irradiance(scene, [[0.5, 0.5, 0.0]], [[0, 0, 1]], samples=16)


def test_objects_that_stand_on_each_other_are_not_spoken_of(recwarn):
    unit = ball(600, 3)
    resting = sf.Surfels(0.2 * unit.points + [0.5, 0.5, 0.2], unit.normals)
    sf.solve(sf.Scene([scan(1), resting], [sf.Environment(1.0)]), transport="rays", insert=False)
    assert not [w for w in recwarn if "objects" in str(w.message)]


def test_a_floor_under_many_tiles_of_its_own_mesh_keeps_what_they_leave():
    """1024 tiles on one face: what is left of it was cut by every tile's edges, so that its pieces multiplied."""
    n, low, high = 32, -0.37, 0.41
    at = np.linspace(low, high, n + 1)
    corners = [[x, y, 0] for x in at for y in at]
    first = [4 + (n + 1) * i + j for i in range(n) for j in range(n)]
    faces = [[0, 1, 2, 3], *([k, k + n + 1, k + n + 2, k + 1] for k in first)]
    scene = sf.Scene([sf.Surfels.from_mesh((SQUARE + corners, faces))], [sf.Environment(1.0)])
    areas = sf.solve(scene, insert=False).surfels.areas
    assert areas[0] == pytest.approx(4 - (high - low) ** 2, rel=1e-6)
    assert areas.sum() == pytest.approx(4, rel=1e-6)


@pytest.mark.parametrize(
    "call",
    [
        lambda scene: sf.solve(scene, insert=False),
        lambda scene: sf.solve_meshless(scene, levels=1),
        lambda scene: sf.reference_irradiance(scene, [[0.5, 0.5, 0.1]], [[0, 0, 1]], samples=16),
    ],
    ids=["solve", "meshless", "reference"],
)
def test_a_scan_over_the_mesh_of_the_same_floor_is_spoken_of(call):
    floor = patch([-1, -1, 0], [3, 0, 0], [0, 3, 0], 0.5, 0.0, 0.04)
    scene = sf.Scene([floor, scan(1)], [sf.Environment(1.0)])
    with pytest.warns(UserWarning, match="objects 0 and 1: 576 points of object 1 lie some .* over or under the mesh"):
        call(scene)


def test_check_names_a_scan_over_a_mesh_and_the_area_of_it(tmp_path, capsys):
    scan(1).save(tmp_path / "scan.ply")
    path = tmp_path / "scene.toml"
    path.write_text(
        '[[object]]\nshape = "rectangle"\ncorner = [-1, -1, 0]\nedge_u = [3, 0, 0]\nedge_v = [0, 3, 0]\n'
        'patch_area = 0.04\n[[object]]\nfile = "scan.ply"\nkind = "surfels"\n'
    )
    assert commands.main(["check", str(path)]) == 0
    assert "objects 0 and 1: 576 points of object 1 lie some" in capsys.readouterr().out
    assert commands.main(["check", str(path), "--json"]) == 0
    (sheet,) = json.loads(capsys.readouterr().out)["close_sheets"]
    assert (sheet["mesh"], sheet["other"], sheet["points"]) == (0, 1, 576)
    # What its points reach: the square, less a strip of up to .8 cells on each side.
    assert (1 - 2 * 0.8 / 24) ** 2 < sheet["area"] < 1
    assert sheet["share"] == pytest.approx(sheet["area"] / 9, rel=1e-6)
    # The mean of |x| of a normal distribution, and four times what its standard error is.
    assert sheet["height"] == pytest.approx(1e-4 * np.sqrt(2 / np.pi), rel=4 * 0.76 / 24)


def doubled(height):
    """Two squares of 1 x 1 in one mesh, cut along different diagonals and at different places."""
    corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    over = [[0, 0, height], [1, 0, height], [1, 1, height], [0, 1, height], [0.3, 0.6, height]]
    faces = [[0, 1, 2], [0, 2, 3], [4, 5, 8], [5, 6, 8], [6, 7, 8], [7, 4, 8]]
    return sf.Surfels.from_mesh((corners + over, faces), reflectance=0.5)


@every_solver
def test_doubled_faces_cut_into_other_triangles_are_one_surface(solver):
    solution = solver(sf.Scene([doubled(0.0)], [sf.Environment(1.0)]))
    assert np.allclose(solution.irradiance, np.pi, rtol=1e-6)
    assert np.isclose(solution.surfels.areas.sum(), 1.0, rtol=1e-8)


@every_solver
def test_doubled_faces_a_hair_apart_are_spoken_of(solver):
    scene = sf.Scene([doubled(1e-5)], [sf.Environment(1.0)])
    with pytest.warns(UserWarning, match="object 0: faces lie some 1e-05 over the mesh .* on 1 of its area"):
        solver(scene)


@pytest.mark.slow
def test_what_stands_on_a_mesh_is_not_spoken_of(recwarn):
    unit = ball(600, 3)
    resting = sf.Surfels(0.2 * unit.points + [0.5, 0.5, 0.2], unit.normals)
    floor = patch([0, 0, 0], [1, 0, 0], [0, 1, 0], 0.5, 0.0, 0.001)
    sf.solve(sf.Scene([floor, resting], [sf.Environment(1.0)]), insert=False)
    assert not sf.Scene([floor, resting, *box()])._coincidence().close_sheets
    assert not [w for w in recwarn if "object" in str(w.message)]


def test_a_point_that_floats_cannot_tell_from_what_is_beside_it_is_spoken_of(recwarn):
    """Touching is twice 2^-22 of twice the distance: 1e6 m away .95 m, 1e4 m away a quarter of a disk."""
    one = scan(1)
    for distance, speaks in ((1e4, False), (1e6, True)):
        points = np.r_[one.points, [[distance, 0, 0]]]
        stray = sf.Surfels(points, [[0, 0, 1]] * len(points), radii=np.full(len(points), 0.04))
        sf.reference_irradiance(sf.Scene([stray], [sf.Environment(1.0)]), [[0.5, 0.5, 1]], [[0, 0, 1]], samples=16)
        said = [str(w.message) for w in recwarn if "object 0: 1 surfel so far" in str(w.message)]
        assert bool(said) == speaks
    assert "within up to 0.95 of them" in said[0]


@pytest.mark.parametrize(("first", "second"), [(1.0, 0.0), (0.0, 1.0), (1.0, 1.0)])
def test_what_glows_beneath_later_faces_is_spoken_of(first, second, recwarn):
    """A lamp let into a ceiling: its light is lost where the ceiling comes later, and only there."""
    lamp = patch([0.2, 0.2, 0], [0.3, 0, 0], [0, 0.3, 0], 0.5, first, 0.01)
    scene = sf.Scene([lamp, patch([0, 0, 0], [1, 0, 0], [0, 1, 0], 0.5, second, 0.01)])
    sf.reference_irradiance(scene, [[0.35, 0.35, 1]], [[0, 0, -1]], samples=16)
    said = [str(w.message) for w in recwarn if "that emit light" in str(w.message)]
    assert len(said) == (first > second)
    if said:
        assert said[0].startswith(
            "object 0: 9 patches of it that emit light lie in one place with later faces of object 1"
        )
        assert said[0] in coincidence_of(scene)[1]


def facing(gap, emission, center=(0.0, 0.0, 0.0)):
    """A glowing square of 1 x 1 that faces another, moved by a quarter."""
    lower = patch(center, [1, 0, 0], [0, 1, 0], 0.5, 0.0, 0.01)
    upper = patch(np.add(center, [0.25, 0, gap]), [0, 1, 0], [1, 0, 0], 0.5, emission, 0.01)
    return sf.Scene([lower, upper])


@every_solver
def test_a_gap_that_rays_cannot_see_is_spoken_of(solver):
    with pytest.warns(UserWarning, match=r"objects 0 and 1: .* 1e-07 apart, facing each other, on 0.75 of their area"):
        solver(facing(1e-7, 1.0))


@pytest.mark.parametrize(("gap", "emission"), [(1e-5, 1.0), (0.0, 1.0), (1e-16, 1.0), (1e-7, 0.0)])
def test_only_gaps_that_lack_light_are_spoken_of(gap, emission, recwarn):
    """Wider ones are seen; none, up to rounding, is meant; and into a dark one no light comes."""
    scene = facing(gap, emission)
    sf.reference_irradiance(scene, [[0.5, 0.5, 1]], [[0, 0, 1]], samples=16)
    assert not [w for w in recwarn if "apart" in str(w.message)]
    assert len(scene._coincidence().gaps) == (gap == 1e-7)


def test_check_names_a_gap_that_rays_cannot_see(tmp_path, capsys):
    path = tmp_path / "scene.toml"
    square = '[[object]]\nshape = "rectangle"\ncorner = [0, 0, {}]\nedge_{} = [1, 0, 0]\nedge_{} = [0, 1, 0]\n'
    path.write_text(square.format(0, "u", "v") + square.format(1e-7, "v", "u"))
    assert commands.main(["check", str(path), "--json"]) == 0
    (gap,) = json.loads(capsys.readouterr().out)["gaps"]
    assert (gap["one"], gap["other"]) == (0, 1)
    assert gap["area"] == pytest.approx(1.0, rel=1e-6)
    assert gap["width"] == pytest.approx(1e-7, rel=1e-6)
