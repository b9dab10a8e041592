import numpy as np
import pytest

import surflux as sf
from surflux.scenes import patterns, shapes
from surflux.scenes.transform import make_transform


@pytest.mark.parametrize("inward", [False, True])
def test_a_box_has_its_area_and_faces_one_way(inward):
    vertices, faces, side = shapes.box([1, 2, 3], [2, 3, 4], inward)
    s = sf.Surfels.from_mesh((vertices, faces))
    assert len(s) == 2 * (2 * 3 + 3 * 4 + 2 * 4)
    assert s.areas.sum() == pytest.approx(22)
    # Gauss: the flux of the position through the surface is three times the volume.
    flux = (s.areas * (s.points * s.normals).sum(axis=1)).sum()
    assert flux == pytest.approx(-18 if inward else 18)
    middle = {"left": (0, 0), "right": (0, 1), "front": (1, 0), "back": (1, 2), "floor": (2, 0), "ceiling": (2, 3)}
    for number, name in enumerate(shapes.SIDES):
        axis, value = middle[name]
        assert s.points[side == number][:, axis] == pytest.approx(value, abs=1e-15)


def test_a_room_has_as_many_patches_as_asked():
    assert len(shapes.box(3.5, 20, True)[1]) == 6 * 400


def test_a_rectangle_faces_along_u_cross_v():
    s = sf.Surfels.from_mesh(shapes.rectangle([1, 0, 0], [0, 2, 0], [0, 0, 3], [4, 5]))
    assert len(s) == 20
    assert (s.normals == [1, 0, 0]).all()
    assert s.areas.sum() == pytest.approx(6)
    assert s.areas.std() < 1e-12


@pytest.mark.parametrize("level", range(5))
def test_icosphere(level):
    points, faces = shapes.icosphere(level)
    assert len(points) == 10 * 4**level + 2
    assert len(faces) == 20 * 4**level
    assert np.linalg.norm(points, axis=1) == pytest.approx(np.ones(len(points)))
    assert (np.linalg.det(points[faces]) > 0).all()  # all turned to the outside
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    assert len(points) - len(np.unique(edges, axis=0)) + len(faces) == 2  # Euler
    assert shapes.icosphere_level(len(points)) == level
    assert shapes.icosphere_level(len(points) + 1) is None


@pytest.mark.parametrize("points", [642, 1000])
def test_sphere(points):
    s = shapes.sphere(points, 0.8)
    assert len(s) == points
    assert np.linalg.norm(s.points, axis=1) == pytest.approx(np.full(points, 0.8))
    assert (s.points / 0.8) == pytest.approx(s.normals)
    assert np.abs(s.points.mean(axis=0)).max() < 0.001
    # In a hexagonal lattice of cells of 4 pi r^2 / n, their corners lie at 1.1 times the radius of a disk of that area,
    # in a square one at 1.25 times; disks reach a tenth farther.
    even = np.sqrt(4 * 0.64 / points)
    assert 1.1 * even < s.radii.min() < s.radii.max() < 1.7 * even


@pytest.mark.slow
@pytest.mark.parametrize(("make", "inside"), [(shapes.blob, [[0, 0, 0]]), (shapes.knot, None)])
def test_organic_shapes_have_exact_normals(make, inside):
    s = make(2000, seed=2)
    assert len(s) == 2000
    # A step along a smooth surface is perpendicular to the mean of the normals at its ends, to second order: the RMS
    # sine is 0.0018 and 0.0026 here, a quarter of that at half the step. Normals off by 0.02 would make it 0.012.
    distance = np.linalg.norm(s.points[:, None] - s.points[None, :], axis=2)
    i, j = np.nonzero((distance > 0) & (distance < 0.12) & (s.normals @ s.normals.T > 0.8))
    step, mean_normal = s.points[j] - s.points[i], s.normals[i] + s.normals[j]
    lengths = np.linalg.norm(step, axis=1) * np.linalg.norm(mean_normal, axis=1)
    assert len(i) > 1000
    assert np.sqrt(np.mean(((step * mean_normal).sum(axis=1) / lengths) ** 2)) < 0.004
    if inside is not None:
        assert ((s.points - inside) * s.normals).sum(axis=1).min() > 0
    assert (make(2000, seed=2).points == s.points).all()
    assert (make(2000, seed=3).points != s.points).any()


def test_the_knot_is_closed_and_faces_outwards():
    # Gauss over uniform samples: the mean normal of a closed surface is 0, and its volume is positive.
    s = shapes.knot(4000)
    assert np.abs(s.normals.mean(axis=0)).max() < 0.02
    assert (s.points * s.normals).sum(axis=1).mean() > 0


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: shapes.box(0), r"^size: wanted values above 0, got 0"),
        (lambda: shapes.box([1, 2]), r"^size: wanted shape \(3,\), got \(2,\)"),
        (lambda: shapes.box(1, 0), r"^patches: wanted a whole number"),
        (lambda: shapes.box(1, [1, 2]), r"^patches: wanted one whole number or 3, got 2"),
        (lambda: shapes.rectangle(edge_v=[2, 0, 0]), r"^edge_v: wanted a vector that spans an area"),
        (lambda: shapes.sphere(3), r"^points: wanted a whole number from 12"),
        (lambda: shapes.sphere(radius=-1), r"^radius: wanted"),
        (lambda: shapes.blob(bumps=1), r"^bumps: wanted"),
        (lambda: shapes.knot(windings=(2, 4)), r"^windings: wanted two numbers without a common divisor, got 2 and 4"),
        (lambda: shapes.knot(swelling=1.0), r"^swelling: wanted"),
        (lambda: patterns.pattern_colors("plaid", [[0, 0, 0]], [[0] * 3] * 2), r"^pattern: wanted one of 'marble'"),
        (lambda: patterns.pattern_colors("spots", [[0, 0, 0]], [[0.1] * 3]), r"^colors: wanted at least 2, got 1"),
        (lambda: patterns.pattern_colors("spots", [[0, 0, 0]], [[1.0] * 3] * 2), r"^colors: wanted values in \[0, 1\)"),
        (lambda: patterns.pattern_colors("spots", [[0, 0, 0]], [[0] * 3] * 2, 0), r"^size: wanted values above 0"),
        (lambda: make_transform(scale=0), r"^scale: wanted values above 0"),
        (lambda: make_transform(rotate=90), r"^rotate: wanted shape \(3,\)"),
        (lambda: make_transform(translate=[0, 0]), r"^translate: wanted shape \(3,\)"),
    ],
)
def test_refusals(call, message):
    with pytest.raises(ValueError, match=message):
        call()


def test_checker_alternates_by_cubes():
    p = np.array([[0.05, 0.05, 0], [0.15, 0.05, 0], [0.15, 0.15, 0], [-0.05, 0.05, 0], [0.05, 0.05, 0.1]])
    colors = patterns.pattern_colors("checker", p, [[0, 0, 0], [0.5, 0.6, 0.7]], 0.1)
    assert colors[:, 0].tolist() == [0, 0.5, 0, 0.5, 0.5]
    # A plane on the border of two layers is not torn by rounding.
    plane = np.array([[0.05, 0.05, 1e-17], [0.05, 0.05, -1e-17]])
    assert np.ptp(patterns.pattern_colors("checker", plane, [[0] * 3, [0.5] * 3], 0.1)) == 0


def test_marble_stays_between_its_colours_and_is_smooth():
    random = np.random.default_rng(0)
    p = random.uniform(-5, 5, (20000, 3))
    white, dark = np.array([0.9, 0.85, 0.8]), np.array([0.2, 0.2, 0.3])
    c = patterns.pattern_colors("marble", p, [white, dark], 0.5)
    t = (c - white) / (dark - white)
    assert t.std(axis=1).max() < 1e-12  # on the line between the two
    assert -1e-12 < t.min() < 0.01
    assert 0.9 < t.max() <= 1 + 1e-12
    assert 0.2 < t.mean() < 0.5  # light with dark veins
    step = patterns.pattern_colors("marble", p + 1e-5, [white, dark], 0.5) - c
    assert np.abs(step).mean() < 1e-3


def test_spots_show_each_of_their_colours():
    p = np.random.default_rng(0).uniform(-3, 3, (20000, 3))
    colors = np.array([[0.7, 0.5, 0.2], [0.1, 0.06, 0.03], [0.5, 0.3, 0.1]])
    c = patterns.pattern_colors("spots", p, colors, 0.5)
    share = [(c == color).all(axis=1).mean() for color in colors]
    assert sum(share) == pytest.approx(1)
    assert share[0] > 0.5
    assert share[1] > 0.1
    assert share[2] > 0.02
    two = patterns.pattern_colors("spots", p, colors[:2], 0.5)
    assert (two[(c == colors[2]).all(axis=1)] == colors[0]).all()  # rings around the ground


@pytest.mark.parametrize("pattern", ["marble", "spots"])
def test_patterns_follow_their_seed_and_size(pattern):
    p = np.random.default_rng(0).uniform(-3, 3, (500, 3))
    colors = [[0.1] * 3, [0.8] * 3]
    first = patterns.pattern_colors(pattern, p, colors, 0.5, seed=1)
    assert (patterns.pattern_colors(pattern, p, colors, 0.5, seed=1) == first).all()
    assert (patterns.pattern_colors(pattern, p, colors, 0.5, seed=2**64 - 1) != first).any()
    assert np.allclose(patterns.pattern_colors(pattern, 2 * p, colors, 1.0, seed=1), first)


def test_transform_scales_then_turns_about_x_y_z_then_moves():
    t = make_transform(2.0, [90, 0, 90], [10, 0, 0])
    # (1, 2, 3) -> (2, 4, 6) -> about x (2, -6, 4) -> about z (6, 2, 4) -> moved
    assert t.points(np.array([[1.0, 2.0, 3.0]])).tolist() == [[16, 2, 4]]
    order = make_transform(1.0, [20, 30, 40], [0, 0, 0]).rotation
    by_hand = np.eye(3)
    for axis, degrees in enumerate((20, 30, 40)):
        by_hand = make_transform(1.0, np.eye(3)[axis] * degrees).rotation @ by_hand
    assert order == pytest.approx(by_hand)
    assert order @ order.T == pytest.approx(np.eye(3))
    assert np.linalg.det(order) == pytest.approx(1)


@pytest.mark.parametrize("degrees", [-450, -270, -90, -30, 0, 45, 90, 135, 180, 225, 270, 315, 360, 725])
def test_rotation_agrees_with_sine_and_cosine(degrees):
    angle = np.radians(degrees)
    wanted = [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    rotation = make_transform(1.0, [0, 0, degrees]).rotation
    assert rotation == pytest.approx(np.array(wanted), abs=1e-12)
    if degrees % 90 == 0:
        assert set(rotation.ravel().tolist()) <= {-1.0, 0.0, 1.0}


def test_transformed_surfels():
    mesh = sf.Surfels.from_mesh(shapes.box([1, 2, 3])[:2], 0.5)
    moved = make_transform(2.0, [0, 90, 0], [5, 0, 0]).surfels(mesh)
    assert moved.areas == pytest.approx(4 * mesh.areas)
    assert moved.radii == pytest.approx(2 * mesh.radii)
    assert moved.normals[:, 0] == pytest.approx(mesh.normals[:, 2])  # z turns to x
    assert moved.points[:, 0] == pytest.approx(5 + 2 * mesh.points[:, 2])
    assert moved.triangles.reshape(-1, 3)[:, 1] == pytest.approx(2 * mesh.triangles.reshape(-1, 3)[:, 1])


@pytest.mark.parametrize("off", [0.0, 1e-9, 1e-7, 1e-5])
def test_up_just_beside_down_turns_lengths_into_the_same(off):
    """Of -z with the noise of floats, 1 + z cancels: at 1e-7 lengths became 1.05 times what they are."""
    rotation = make_transform(up=[off, 0.0, -1.0]).rotation
    assert rotation @ rotation.T == pytest.approx(np.eye(3), abs=1e-12)
    assert rotation @ [off, 0.0, -1.0] == pytest.approx([0.0, 0.0, 1.0], abs=1e-9)
