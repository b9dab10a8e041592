"""Sheets of points with two sides, whose disks must not shut each other off."""

import warnings

import numpy as np
import pytest

import surflux as sf
from surflux.scenes.coincidence import coincidence_of

SUN = sf.DirectionalLight([0, 0, -1], 10.0)
SQUARE = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])


def places(n, seed=0):
    return np.column_stack([np.random.default_rng(seed).uniform(-1, 1, (n, 2)), np.zeros(n)])


def sheet(n=600, seed=0, up=1.0, **options):
    return sf.Surfels(places(n, seed), normals=[[0, 0, up]] * n, **options)


def shell(n=600):
    normals = np.random.default_rng(1).normal(size=(n, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    return sf.Surfels(normals, normals=normals, two_sided=True)


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize("n", [2, 3, 400, 401, 1199])
def test_thinning_keeps_two_sides_together(n, seed):
    """Drawn apart, they had 3 to 5 % of their light."""
    thin = sheet(two_sided=True).thinned(n, seed)
    assert len(thin) == n - n % 2
    up, down = (thin.points[thin.normals[:, 2] * side > 0.0] for side in (1, -1))
    assert sorted(map(tuple, up)) == sorted(map(tuple, down))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        solution = sf.solve(sf.Scene([thin], [SUN]), rays=16)
    assert solution.per_surfel()[thin.normals[:, 2] > 0.0] == pytest.approx(10.0)


def test_a_shell_thinned_has_all_its_light():
    solution = sf.solve(sf.Scene([shell().thinned(500)], [SUN]), rays=64)
    s = solution.surfels
    outside = np.einsum("ij,ij->i", s.points, s.normals) > 0.0
    assert (solution.irradiance[:, 0] * s.areas)[outside].sum() == pytest.approx(10.0 * np.pi, rel=0.005)


def test_what_has_one_side_and_what_has_two_are_kept_in_proportion():
    ball = sf.Surfels(np.random.default_rng(2).normal(size=(600, 3)), normals=[[0, 0, 1]] * 600, radii=0.1)
    for n in (3, 200, 1001):
        thin = sf.concatenate([sheet(two_sided=True), ball]).thinned(n)
        assert len(thin) == n
        assert np.sum(thin.points[:, 2] == 0.0) == pytest.approx(2 * n / 3, abs=1.0)


def test_sheets_that_cross_keep_their_sides():
    """At the places where they do, four surfels stand."""
    ahead = sf.Surfels(places(300), normals=[[1, 0, 0]] * 300, radii=0.1, two_sided=True)
    thin = sf.concatenate([sheet(300, two_sided=True), ahead]).thinned(600)
    both = np.hstack([thin.points, thin.normals])
    assert {tuple(row + 0.0) for row in both} == {tuple(row * [1, 1, 1, -1, -1, -1] + 0.0) for row in both}


def test_piles_have_no_other_side():
    """Of a million points in one place, too: no pair of them is looked at."""
    pile = sf.Surfels(np.zeros((200_000, 3)), normals=[[0, 0, 1]] * 200_000, radii=0.1)
    from surflux.points.arranging import _backs

    assert np.all(_backs(pile.points, pile.normals) == -1)
    both = sf.concatenate([pile[:3], pile[:2].flipped(), sheet(2)])
    assert _backs(both.points, both.normals).tolist() == [3, 4, -1, -1, -1, -1, -1]


def test_a_sheet_in_a_larger_cloud_is_named():
    floor = sf.Surfels(3.0 * places(4000, 5) - [0, 0, 1], normals=[[0, 0, 1]] * 4000)
    cloud = sf.concatenate([floor, APART["front and back"]()[::2]])
    assert coincidence_of(sf.Scene([cloud]))[0]["shut_off"][0]["points"] > 500


APART = {
    "a random half": lambda: sheet(two_sided=True)[np.random.default_rng(3).random(1200) < 0.5],
    "of a shell": lambda: shell()[np.random.default_rng(3).random(1200) < 0.5],
    "a mesh with both faces, sampled": lambda: sf.Surfels.sample_mesh((SQUARE, [[0, 1, 2, 3], [3, 2, 1, 0]]), 800),
    "front and back": lambda: sf.concatenate([sheet(), sheet(seed=1, up=-1.0)]),
}


@pytest.mark.parametrize("name", APART)
def test_sides_sampled_apart_are_named(name):
    with pytest.warns(
        UserWarning, match=r"object 0: \d+ points of it lie beneath others that face them.*two_sided=True"
    ):
        sf.solve(sf.Scene([APART[name]()], [SUN]), rays=16)


def turned():
    matrix = np.eye(4)
    matrix[:3, :3] = np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))[0]
    return matrix


OBJECTS_APART = {
    "two clouds": lambda: [sheet(), sheet(seed=1, up=-1.0)],
    "two clouds, turned": lambda: [o.transformed(turned()) for o in OBJECTS_APART["two clouds"]()],
    "a cloud and a mesh": lambda: [sf.Surfels.from_mesh((SQUARE, [[0, 1, 2, 3]]), 0.1), sheet(up=-1.0)],
    "two shells": lambda: [
        sf.Surfels(p, normals=side * p) for p, side in ((shell(2000).points[::2], 1), (shell(1200).points[::2], -1))
    ],
}


@pytest.mark.parametrize("name", OBJECTS_APART)
def test_sides_that_are_objects_of_their_own_are_named(name):
    """They had no light, without a word."""
    with pytest.warns(UserWarning, match=r"object 1: \d+ points of it lie beneath object 0, which faces them"):
        sf.solve(sf.Scene(OBJECTS_APART[name](), [SUN]), rays=16)


def test_what_stands_or_hangs_is_not():
    corners = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
    box = sf.Surfels.sample_mesh(
        (corners, [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]]), 3000
    )
    slab = np.array(corners) * [1, 1, 0.02]
    slab = sf.Surfels.sample_mesh((slab, [[0, 2, 3, 1], [4, 5, 7, 6]]), 1000)
    floor = sf.Surfels(2.0 * places(2000, 7), normals=[[0, 0, 1]] * 2000)
    for objects in ([box, floor], [slab, floor], [box, sf.Surfels.from_mesh((2 * SQUARE, [[0, 1, 2, 3]]), 0.1)]):
        assert coincidence_of(sf.Scene(objects, [SUN]))[0]["shut_off"] == []


@pytest.mark.parametrize(
    "surfels",
    [
        sheet(two_sided=True),
        shell(),
        sf.concatenate([sheet(), sheet().flipped()]),
        sf.concatenate([sheet(), sf.Surfels(places(600, 1) - [0, 0, 1e-3], normals=[[0, 0, -1]] * 600)]),
    ],
    ids=["a sheet", "a shell", "a flipped copy", "a plate of a millimetre"],
)
def test_sheets_with_two_sides_and_plates_are_not(surfels):
    assert coincidence_of(sf.Scene([surfels], [SUN]))[0]["shut_off"] == []


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_the_two_sides_may_be_two_objects(seed):
    """They shut each other off: a bowl had 13 and 25 % of the light of a sky, a sheet none."""
    n = np.random.default_rng(seed).normal(size=(1500, 3))
    n = n[n[:, 2] < 0.0] / np.linalg.norm(n[n[:, 2] < 0.0], axis=1)[:, None]
    outside = sf.Surfels(n, normals=n, reflectance=0.5)
    inside = sf.Surfels(n, normals=-n, reflectance=0.5)
    light = [
        sf.solve(sf.Scene(objects, [sf.Environment(1.0)]), seed=seed).per_surfel().reshape(2, -1).mean(axis=1)
        for objects in ([outside, inside], [sf.concatenate([outside, inside])])
    ]
    assert light[1][0] == pytest.approx(np.pi, rel=1e-3)
    assert light[0] == pytest.approx(light[1], rel=0.01)


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize("transport", ["pairs", "rays"])
def test_the_outside_of_a_bowl_of_points_sees_nothing_of_its_inside(seed, transport):
    """By pairs it had 2.8 % less light: parts of its disks, which stand off it, faced the backs of neighbours."""
    n = np.random.default_rng(seed).normal(size=(1000, 3))
    n = n[n[:, 2] < 0.0] / np.linalg.norm(n[n[:, 2] < 0.0], axis=1)[:, None]
    sky = sf.Environment(1.0)
    both, inside = (
        sf.solve(sf.Scene([bowl], [sky]), transport=transport, seed=seed).per_surfel().mean(axis=1)
        for bowl in (sf.Surfels(n, normals=n, two_sided=True), sf.Surfels(n, normals=-n))
    )
    assert both[: len(n)] == pytest.approx(np.pi, rel=1e-4)
    assert both[len(n) :].mean() == pytest.approx(inside.mean(), rel=0.005)
