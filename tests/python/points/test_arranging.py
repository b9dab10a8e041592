"""Surfels put together, moved, and with other materials."""

import numpy as np
import pytest

import surflux as sf
from surflux.scenes import shapes

BOX = sf.Surfels.from_mesh(shapes.box(patches=2)[:2], reflectance=0.3)


def turned(degrees, scale=1.0, mirror=False, by=(0.0, 0.0, 0.0)):
    a = np.radians(degrees)
    matrix = np.eye(4)
    matrix[:3, :3] = scale * np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
    if mirror:
        matrix[:3, 0] *= -1
    matrix[:3, 3] = by
    return matrix


@pytest.mark.parametrize("mirror", [False, True])
def test_what_is_moved_has_the_light_that_it_had(mirror):
    """A room that is turned, mirrored, moved far and scaled: radiosity of the same emission is the same."""
    room = sf.Surfels.from_mesh(shapes.box(patches=4, inward=True)[:2], reflectance=0.5)
    room = room.replace(emission=(room.points[:, 2] > 0.99).astype(float))
    moved = room.transformed(turned(30, 4.0, mirror, (1e4, -2e4, 50)))
    assert moved.areas.sum() == pytest.approx(16 * room.areas.sum(), rel=1e-9)
    facing = np.cross(moved.triangles[:, 1] - moved.triangles[:, 0], moved.triangles[:, 2] - moved.triangles[:, 0])
    assert (np.sum(facing * moved.normals[moved.triangle_surfel], axis=1) > 0).all()
    here, there = (sf.solve(sf.Scene([s]), transport="pairs", insert=False).radiosity for s in (room, moved))
    np.testing.assert_allclose(there, here, rtol=0.02)


def test_moved_there_and_back_again():
    matrix = turned(77, 0.3, by=(1, 2, 3))
    back = BOX.transformed(matrix).transformed(np.linalg.inv(matrix))
    for name in ("points", "normals", "radii", "areas", "triangles"):
        np.testing.assert_allclose(getattr(back, name), getattr(BOX, name), rtol=1e-12, atol=1e-12, err_msg=name)


@pytest.mark.parametrize(
    ("matrix", "message"),
    [
        (np.eye(3), r"matrix: wanted .*\(4, 4\)"),
        (np.diag([1.0, 2.0, 1.0, 1.0]), "matrix: wanted one that turns"),
        (np.diag([0.0, 0.0, 0.0, 1.0]), "matrix: wanted one that turns"),
        (np.diag([1.0, 1.0, 1.0, 2.0]), "matrix: wanted a last row"),
        (np.full((4, 4), np.nan), "matrix: "),
    ],
)
def test_what_would_not_leave_disks_round_is_refused(matrix, message):
    with pytest.raises(ValueError, match=message):
        BOX.transformed(matrix)


def test_replaced_arrays_are_checked_and_the_rest_stays():
    other = BOX.replace(reflectance=[0.1, 0.2, 0.3], emission=2.0, radii=0.5, areas=1.5)
    assert other.reflectance.tolist() == [[0.1, 0.2, 0.3]] * len(BOX)
    assert (other.emission.min(), other.radii.max(), other.areas.min()) == (2.0, 0.5, 1.5)
    np.testing.assert_array_equal(other.triangles, BOX.triangles)
    assert BOX.reflectance.max() == 0.3
    with pytest.raises(ValueError, match=r"reflectance: wanted .*got 1"):
        BOX.replace(reflectance=1.0)
    with pytest.raises(ValueError, match="radii: "):
        BOX.replace(radii=[1.0, 2.0])


def test_put_together_they_are_as_they_were():
    ball = shapes.sphere(42)
    both = sf.concatenate([BOX, ball])
    assert len(both) == len(BOX) + len(ball)
    assert both.areas is None  # the ball has none
    np.testing.assert_array_equal(both[: len(BOX)].triangles, BOX.triangles)
    np.testing.assert_array_equal(both.points[len(BOX) :], ball.points)
    assert sf.concatenate([BOX, BOX]).areas.sum() == pytest.approx(2 * BOX.areas.sum())
    for wrong in ([], BOX, [BOX, None]):
        with pytest.raises(ValueError, match="surfels: wanted"):
            sf.concatenate(wrong)


def test_bounds():
    np.testing.assert_allclose(BOX.bounds, [BOX.triangles.min(axis=(0, 1)), BOX.triangles.max(axis=(0, 1))])
    np.testing.assert_array_equal(shapes.sphere(42).bounds[1], shapes.sphere(42).points.max(axis=0))
