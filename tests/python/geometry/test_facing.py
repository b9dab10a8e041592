"""Which side of a cloud is seen: bodies, rooms, plates, and what cannot be told."""

import logging

import numpy as np
import pytest

import surflux as sf
from surflux.scenes import shapes

NO_ROOM = np.array([9.0, 9.0, 9.0])


def box(count, size=(5, 4, 3), *, inward=False, seed=0):
    vertices, faces, _ = shapes.box(size=list(size), inward=inward)
    return sf.Surfels.sample_mesh((vertices, faces), count, seed)


def furnished(seed=0):
    """A closed room with two balls in the air, and its normals."""
    walls, ball = box(6000, inward=True, seed=seed), shapes.sphere(1500)
    parts = [0.5 * ball.points + at for at in ([1.2, 2, 1.1], [3.5, 1.5, 1.6])]
    return np.vstack([walls.points, *parts]), np.vstack([walls.normals, ball.normals, ball.normals])


def right(normals, truth):
    return np.sum(normals * truth, axis=1) > 0


def turned_in_pieces(points, normals, seed):
    """Half of 16 Voronoi cells turned over."""
    rng = np.random.default_rng(seed)
    seeds = points[rng.choice(len(points), 16, replace=False)]
    cell = np.argmin(np.linalg.norm(points[:, None] - seeds, axis=2), axis=1)
    return np.where(rng.permutation(16)[cell][:, None] % 2 == 0, -normals, normals)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize("thing", ["blob", "knot", "plate", "room"])
def test_pieces_that_are_turned_over_are_found(thing, seed):
    """All of them, and nothing else, for every point is in a sheet that rays see from one side alone."""
    if thing == "room":
        points, normals = furnished(seed)
    elif thing == "plate":
        plate = box(6000, (4, 3, 0.1), seed=seed)
        points, normals = plate.points, plate.normals
    else:
        s = getattr(shapes, thing)(6000)
        points, normals = s.points, s.normals
    for given in (normals, -normals, turned_in_pieces(points, normals, seed)):
        found = sf.facing(points, given)
        assert np.mean(found.turned != right(given, normals)) > 0.999
        assert not found.open.any()
    room = sf.facing(points, normals).room
    assert room.sum() == (6000 if thing == "room" else 0)


@pytest.mark.slow
def test_points_beyond_those_looked_at_follow_them():
    d = np.random.default_rng(0).normal(size=(150_000, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    given = np.where(d[:, 2:] > 0.5, -d, d)
    found = sf.facing(d, given)
    # Of a random sample of 60 000, points lie .014 apart; the cap's border is a circle of radius .87.
    border = np.abs(d[:, 2] - 0.5) < 0.04
    assert np.array_equal(found.turned[~border], (d[:, 2] > 0.5)[~border])
    assert sf.facing(d, -d).inside_out.all()


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_both_sides_of_a_sheet_stay(seed):
    """Also where half of its places, or fewer, are looked at; what faces inwards and has no back is turned."""
    d = np.random.default_rng(seed).normal(size=(130_000, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    assert not sf.facing(np.vstack([d, d]), np.vstack([d, -d]), seed=seed).turned.any()
    some = d[::20]
    turned = sf.facing(np.vstack([d, some]), np.vstack([-d, some]), seed=seed).turned
    alone = np.arange(len(d)) % 20 > 0
    assert np.array_equal(turned, np.append(alone, np.zeros(len(some), bool)))


def test_a_closed_room_is_one_where_somebody_stands_in_it():
    walls = box(4000, inward=True)
    alone = sf.facing(walls.points, walls.normals)
    assert alone.inside_out.all()
    assert not alone.room.any()
    inside = sf.facing(walls.points, walls.normals, seen_from=[[2, 2, 1], NO_ROOM])
    assert inside.room.all()
    assert not inside.turned.any()
    assert np.all(inside.margin < -0.9)
    assert sf.facing(walls.points, -walls.normals, seen_from=[2, 2, 1]).turned.all()
    assert sf.facing(walls.points, walls.normals, seen_from=NO_ROOM).inside_out.all()
    for far in (1e12, 1e30):  # Embree has no rays beyond 1.8e18
        assert sf.facing(walls.points, walls.normals, seen_from=[far, 0, 0]).inside_out.all()


def test_open_sheets_stay_but_for_patches():
    x, y = np.random.default_rng(0).uniform(-1, 1, (2, 6000))
    points = np.stack([x, y, 0.2 * np.cos(2 * x)], axis=1)
    normals = np.stack([0.4 * np.sin(2 * x), 0 * x, np.ones_like(x)], axis=1)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    for sign in (1, -1):
        found = sf.facing(points, sign * normals)
        assert found.open.all()
        assert not found.turned.any()
    patch = np.hypot(x, y) < 0.3
    found = sf.facing(points, np.where(patch[:, None], -normals, normals))
    border = np.abs(np.hypot(x, y) - 0.3) < 0.03  # points lie .026 apart
    assert np.array_equal(found.turned[~border], patch[~border])


def test_what_is_open_and_turned_away_is_told():
    """The front two thirds of a ball: from its inside less light is seen."""
    s = shapes.sphere(6000)
    cap = s.points[s.points[:, 0] > -0.3]
    assert not sf.facing(cap, cap).against.any()
    found = sf.facing(cap, -cap)
    assert found.inside_out.all() or found.against.all()


@pytest.mark.parametrize("seed", [0, 10, 20])
def test_houses_on_ground_that_goes_on_beneath_them_are_not_against(seed):
    """At their feet coarse normals say otherwise than one sheet through walls and ground: its light tells nothing."""
    ground = [[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0]], [[0, 1, 2, 3]]
    parts = [sf.Surfels.sample_mesh(ground, 2000, seed)]
    for k, place in enumerate([[-2.5, -2.5, 0], [2.5, -2.5, 0], [-2.5, 2.5, 0], [2.5, 2.5, 0]]):
        corners = [[x, y, z] for z in (0, 2) for y in (-1.5, 1.5) for x in (-1, 1)]
        faces = [[4, 5, 7, 6], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]]  # no floor
        parts.append(sf.Surfels.sample_mesh((np.add(corners, place), faces), 333, seed + k + 1))
    points, normals = (np.concatenate([getattr(p, name) for p in parts]) for name in ("points", "normals"))
    for sign in (1, -1):
        found = sf.facing(points, sign * normals)
        assert found.open.all()
        assert not found.against.any()


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_leaves_stay_as_they_are(seed):
    """Small disks at random face what they do by chance: only two that nearly lie in one plane pass for one surface.

    A fifth of all pairs is within 37 degrees (cosine .8), and half of these face opposite ways: at most a tenth.
    """
    rng = np.random.default_rng(seed)
    middle, normal = rng.uniform(-1, 1, (400, 3)), rng.normal(size=(400, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    v = rng.normal(size=(400, 25, 3))
    v -= np.sum(v * normal[:, None], axis=2, keepdims=True) * normal[:, None]
    points = (middle[:, None] + 0.05 * v).reshape(-1, 3)
    normals = np.repeat(normal, 25, axis=0)
    found = sf.facing(points, normals)
    assert found.turned.mean() < 0.1
    assert found.open.mean() > 0.5


@pytest.mark.slow
def test_estimated_normals_see_rooms_and_plates(caplog):
    points, truth = furnished()
    with caplog.at_level(logging.INFO, "surflux"):
        wrong = ~right(sf.Surfels(points).normals, truth)
        corners = np.sum(np.minimum(points, [5, 4, 3] - points) < 0.15, axis=1) >= 2  # points lie .13 apart
        assert not np.any(wrong & ~corners)
        plate = box(20_000, (4, 3, 0.1))  # three times as thick as points lie apart
        upright = plate.points[:, [2, 0, 1]]
        for points, normals in ((plate.points, plate.normals), (upright, plate.normals[:, [2, 0, 1]])):
            assert right(sf.Surfels(points).normals, normals).mean() > 0.999
        sf.Surfels(upright[upright[:, 0] > 0.09])  # an open shell
    said = [record.message for record in caplog.records]
    assert "points: estimated normals face inwards, as of a room (viewpoint: elsewhere)" in said
    assert "points: estimated normals face upwards, as of a terrain seen from above (viewpoint: elsewhere)" in said
    assert "points: estimated normals face outwards, as of bodies seen from outside (viewpoint: elsewhere)" in said
    assert any("100 % of the points are on open surfaces, which may face either way" in line for line in said)


def test_does_not_depend_on_threads():
    points, normals = furnished()
    given = turned_in_pieces(points, normals, 0)
    all_, one = sf.facing(points, given), sf.facing(points, given, threads=1)
    assert np.array_equal(all_.turned, one.turned)
    assert np.array_equal(all_.margin, one.margin)


def test_few_points_are_in_no_sheet():
    found = sf.facing([[0, 0, 0], [1, 0, 0]], [[0, 0, 1], [0, 0, -1]])
    assert not found.turned.any()
    assert found.open.all()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([[0, 0]], [[0, 0, 1]]), r"points: wanted shape \(n, 3\), got \(1, 2\)"),
        (([[0, 0, 0]], [[0, 0, 1], [1, 0, 0]]), r"normals: wanted shape \(1, 3\), got \(2, 3\)"),
        (([[0, 0, 0]], [[0, 0, 0]]), "normals: wanted vectors of non-zero length"),
    ],
)
def test_refusals(arguments, message):
    with pytest.raises(ValueError, match=message):
        sf.facing(*arguments)
    with pytest.raises(ValueError, match=r"seen_from: wanted shape \(n, 3\), got \(2,\)"):
        sf.facing([[0, 0, 0]], [[0, 0, 1]], seen_from=[0, 1])
    with pytest.raises(ValueError, match="seed: wanted a whole number from 0"):
        sf.facing([[0, 0, 0]], [[0, 0, 1]], seed=-1)
