import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import surflux as sf
from surflux.pictures.camera import Camera, facing, upright
from surflux.pictures.framing import framing


def test_projection_follows_the_conventions():
    camera = Camera((0, -4, 0), (0, 0, 0), fov=90.0)
    # At depth 4 the picture is 8 high: up is towards row 0, right (+x when looking along +y) to higher columns.
    points = [[0, 0, 0], [0, 0, 4], [4, 0, 0], [0, 4, -8]]
    expected = [[100, 50, 4], [100, 0, 4], [150, 50, 4], [100, 100, 8]]
    np.testing.assert_allclose(camera.project(points, (200, 100)), expected, atol=1e-12)


@given(
    st.integers(0, 10_000),
    st.floats(10.0, 120.0),
    st.sampled_from([0.5, 1.0, 16 / 9]),
    st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda d: np.hypot(d[0], d[1]) > 0.1),
)
def test_fit_has_all_points_in_the_picture(seed, fov, aspect, direction):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(30, 3)) * rng.uniform(0.1, 10.0, 3) + rng.normal(size=3) * 1e3
    camera = Camera.fit(points, direction, fov=fov, aspect=aspect)
    column, row, depth = camera.project(points, (1000 * aspect, 1000)).T
    assert (depth > 0).all()
    assert column.min() >= 0
    assert column.max() <= 1000 * aspect
    assert row.min() >= 0
    assert row.max() <= 1000
    near = depth.min() / np.linalg.norm(points - 0.5 * (points.min(axis=0) + points.max(axis=0)), axis=1).max()
    assert near > 0.05 - 1e-6
    # Not needlessly small either: the closest margins are 1/2.1 - 1/2 of the picture, 2.4 %, on opposite sides.
    if near > 0.05 + 1e-6:
        margins = np.array([[column.min() / aspect, 1000 - column.max() / aspect], [row.min(), 1000 - row.max()]])
        assert np.ptp(margins, axis=1).min() < 0.01
        assert margins.min() == pytest.approx(500 - 500 / 1.05, abs=0.01)


def test_one_point_can_be_framed():
    camera = Camera.fit([[5.0, 6.0, 7.0]])
    np.testing.assert_allclose(camera.target, [5, 6, 7])
    assert np.linalg.norm(camera.eye - camera.target) > 0


def test_a_dictionary_takes_it_there_and_back():
    camera = Camera((1, 2, 3), (4, 5, 6), (0, 1, 0), 30)
    assert camera.to_dict() == {"eye": [1, 2, 3], "target": [4, 5, 6], "up": [0, 1, 0], "fov": 30}
    assert Camera(**camera.to_dict()) == camera
    assert eval(repr(camera), {"Camera": Camera}) == camera
    assert camera != Camera((1, 2, 3), (4, 5, 6), (0, 1, 0), 31)


def test_nothing_of_it_can_be_changed_from_outside():
    eye = np.zeros(3)
    camera = Camera(eye, (0, 1, 0))
    eye[0] = 9
    camera.eye[1] = 9
    np.testing.assert_array_equal(camera.eye, [0, 0, 0])


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        ({"eye": (0, 0)}, "eye"),
        ({"eye": (0, 0, np.nan)}, "eye"),
        ({"eye": "here"}, "eye"),
        ({"target": (0, np.inf, 0)}, "target"),
        ({"target": (0, 0, 0)}, "target"),
        ({"up": (0, 0, 0)}, "up"),
        ({"up": (0, 2, 0)}, "up"),
        ({"up": (0, 1, 0, 0)}, "up"),
        ({"fov": 0.0}, "fov"),
        ({"fov": 180.0}, "fov"),
        ({"fov": np.nan}, "fov"),
        ({"fov": "wide"}, "fov"),
    ],
)
def test_refuses_by_name(arguments, name):
    with pytest.raises(ValueError, match=f"^{name}: "):
        Camera(**{"eye": (0, 0, 0), "target": (0, 1, 0), **arguments})


@pytest.mark.parametrize("fov", [0.1, 0.8, np.pi / 4, 1.99])
def test_an_angle_that_may_be_in_radians_is_warned_of(fov):
    """0.8 radians are 45.8 degrees, .1 and 1.99 are 5.73 and 114."""
    meant = f"{fov * 180 / np.pi:.3g} degrees"
    said = rf"^fov: {fov:g} degrees are .*; if these are radians, {meant} are meant$"
    with pytest.warns(UserWarning, match=said):
        assert Camera((0, -4, 0), (0, 0, 0), fov=fov).fov == fov


@pytest.mark.parametrize("how", [{"fov": 2.0}, {"fov": 20}, {"fov": 0.09}, {"fov": 0.8, "height": 2.0}])
def test_angles_of_lenses_and_of_orthographic_cameras_are_taken_without_a_word(how, recwarn):
    Camera((0, -4, 0), (0, 0, 0), **how)
    assert not recwarn.list


@pytest.mark.parametrize("fov", [-10.0, 0.0, 180.0, 200.0])
def test_angles_that_no_camera_has_are_refused_in_the_same_words(fov):
    with pytest.raises(ValueError, match=f"^fov: wanted degrees between 0 and 180, got {fov:g}$"):
        Camera((0, -4, 0), (0, 0, 0), fov=fov)


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        ({"points": np.zeros((0, 3))}, "points"),
        ({"points": np.zeros((4, 2))}, "points"),
        ({"points": [[np.nan, 0, 0]]}, "points"),
        ({"direction": (0, 0, 0)}, "direction"),
        ({"direction": (0, 0, 1)}, "up"),
        ({"up": (0, 0, 0)}, "up"),
        ({"up": (0, 0)}, "up"),
        ({"aspect": 0.0}, "aspect"),
        ({"fov": -1.0}, "fov"),
    ],
)
def test_fit_refuses_by_name(arguments, name):
    with pytest.raises(ValueError, match=f"^{name}: "):
        Camera.fit(**{"points": [[0, 0, 0], [1, 1, 1]], **arguments})


@given(st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda d: np.linalg.norm(d) > 0.1))
def test_by_default_the_view_is_from_slightly_above_for_any_up(up):
    up = np.array(up)
    camera = Camera.fit([[-1, -1, -1], [1, 1, 1]], up=up)
    assert (camera.up == up).all()
    view = (camera.target - camera.eye) / np.linalg.norm(camera.target - camera.eye)
    # Next to -z the rotation that takes +z there is known to some 1e-5 only.
    expected = -0.45 / np.linalg.norm([0.6, 1, 0.45])
    assert view @ up / np.linalg.norm(up) == pytest.approx(expected, abs=1e-4)


@pytest.mark.parametrize(
    ("up", "direction"),
    [((0, 0, 2), (-0.6, 1, -0.45)), ((0, 1, 0), (-0.6, -0.45, -1)), ((0, 0, -1), (-0.6, -1, 0.45))],
)
def test_the_default_view_turns_with_up(up, direction):
    camera = Camera.fit([[-1, -1, -1], [1, 1, 1]], up=up)
    view = camera.target - camera.eye
    np.testing.assert_allclose(view / np.linalg.norm(view), direction / np.linalg.norm(direction), atol=1e-12)


def cap(axis, count=2000):
    """Points of the half of a ball around an axis, which face away from its middle."""
    rng = np.random.default_rng(0)
    normals = rng.normal(size=(count, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    normals[normals @ axis < 0] *= -1
    return sf.Surfels(normals, normals)


@pytest.mark.parametrize("azimuth", [0, 30, 100, 200, 300])
def test_framing_looks_at_fronts(azimuth):
    axis = np.array([np.cos(np.radians(azimuth)), np.sin(np.radians(azimuth)), 0.0])
    camera = framing(cap(axis), (400, 300))
    towards = camera.eye - camera.target
    assert towards @ axis > 0.4 * np.linalg.norm(towards)
    np.testing.assert_array_equal(camera.up, [0, 0, 1])


def ball_with_an_ear(azimuth, tilt, count=1600):
    """A ball that is open below, and an ear: how much of a picture they fill depends on where the ear reaches."""
    rng = np.random.default_rng(round(1000 * azimuth))
    ball, ear = (d / np.linalg.norm(d, axis=1, keepdims=True) for d in rng.normal(size=(2, count, 3)))
    widths = np.array([2.0, 0.15, 0.15])
    up = np.array([[np.cos(tilt), 0, np.sin(tilt)], [0, 1, 0], [-np.sin(tilt), 0, np.cos(tilt)]])
    turn = np.array([[np.cos(azimuth), np.sin(azimuth), 0], [-np.sin(azimuth), np.cos(azimuth), 0], [0, 0, 1]])
    points = np.vstack([ball, (ear[::2] * widths + [2.3, 0, 0]) @ up]) @ turn
    normals = np.vstack([ball, (ear[::2] / widths) @ up]) @ turn
    kept = points[:, 2] > -0.5 - 0.1 * rng.random(len(points))
    return sf.Surfels(points[kept], normals[kept])


@pytest.mark.parametrize("tilt", [30, 45, 60, 75])
def test_no_body_is_framed_from_below(tilt):
    """Its rim, and what fills more of the picture, are no reason."""
    for azimuth in range(0, 360, 30):
        surfels = ball_with_an_ear(np.radians(azimuth), np.radians(tilt))
        for along in (True, False):
            camera = framing(surfels, (400, 300), along=along)
            assert camera.eye[2] > camera.target[2]


def test_a_ceiling_is_framed_from_below():
    """A ceiling and two walls under it, of a room 4 wide and 2 high."""
    x, y = np.random.default_rng(0).uniform(-2, 2, (2, 3000))
    high, flat, low = np.full(3000, 2.0), np.zeros(3000), np.abs(x)
    parts = [([x, y, high], [0, 0, -1]), ([x, high, low], [0, -1, 0]), ([-high, y, low], [1, 0, 0])]
    points, normals = np.hstack([p for p, _ in parts]).T, np.repeat([n for _, n in parts], 3000, axis=0)
    camera = framing(sf.Surfels(points, normals), (400, 300), along=False)
    assert camera.eye[2] < camera.target[2] - 0.3
    floor = sf.Surfels(np.transpose([x, y, flat]), [[0, 0, 1]] * 3000)
    room = sf.Scene([floor, sf.Surfels(points, normals)]).surfels
    camera = framing(room, (400, 300), along=False)
    assert camera.eye[2] > camera.target[2]


def test_framing_keeps_its_three_quarters_of_what_looks_alike_from_all_sides():
    ball = cap(np.array([0.0, 0, 1]))
    whole = sf.Surfels(np.vstack([ball.points, -ball.points]), np.vstack([ball.normals, -ball.normals]))
    camera = framing(whole, (400, 300))
    view = camera.target - camera.eye
    expected = np.array([-0.6, 1, -0.45])
    np.testing.assert_allclose(view / np.linalg.norm(view), expected / np.linalg.norm(expected), atol=1e-3)


# x to the right, y down, z forward: what it sees faces back to it.
def test_framing_sees_the_frame_of_a_depth_camera_as_that_saw_it():
    x, y = np.random.default_rng(0).uniform(-1, 1, (2, 3000))
    wall = sf.Surfels(np.transpose([x, y, np.full(3000, 2.0)]), [[0, 0, -1]] * 3000)
    camera = framing(wall, (400, 300))
    column, row, depth = camera.project([[0.5, 0, 2], [0, 0.5, 2]], (400, 300)).T
    assert (depth > 0).all()
    assert column[0] > 210
    assert row[1] > 160


def test_framing_leaves_out_strays_and_what_wide_disks_reach():
    ball = cap(np.array([0.0, -1, 0]))
    radii = np.where(np.arange(2001) < 2000, 0.05, 3.0)
    stray = sf.Surfels(np.vstack([ball.points, [[0, 9, 9]]]), np.vstack([ball.normals, [[0, -1, 0]]]), radii=radii)
    camera = framing(stray, (400, 300))
    row = camera.project(ball.points, (400, 300))[:, 1]
    assert np.ptp(row) > 200
    assert 0 < row.min() < row.max() < 300


UPS = [(0, 0, 1), (0, 1, 0), (1, 0, 0), (0, 0, -1), (0, -1, 0)]


def within(places, camera, size=(400, 300)):
    """The least margin that places keep in the picture of a camera, in pixels; below 0 some are cut off."""
    column, row, depth = camera.project(places, size).T
    assert (depth > 0).all()
    return min(column.min(), size[0] - column.max(), row.min(), size[1] - row.max())


# Of a box around each surfel, two opposite corners said what is to be seen.
@pytest.mark.parametrize("up", UPS)
@pytest.mark.parametrize("size", [(2, 2, 0), (2, 0.5, 0.1), (1, 1, 1)])
def test_framing_has_all_of_coarse_meshes_in_the_picture(up, size):
    signs = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)])
    faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    corners = (signs * size) @ np.roll(np.eye(3), 1 + int(np.argmax(np.abs(up))), axis=0)  # flat along up
    mesh = sf.Surfels.from_mesh((corners, faces[1:2] if size[2] == 0 else faces))
    assert within(corners, framing(mesh, (400, 300), up)) == pytest.approx(150 - 150 / 1.05, abs=3)


@pytest.mark.parametrize("up", UPS)
@pytest.mark.parametrize("normal", [(0, 0, 1), (0, 1, 0), (1, -1, 0), (1, 2, 3)])
def test_framing_has_all_of_wide_disks_in_the_picture(up, normal):
    n = np.array(normal) / np.linalg.norm(normal)
    u = np.cross(n, [0.3, 0.5, -0.8])
    u /= np.linalg.norm(u)
    angle = np.linspace(0, 2 * np.pi, 200)[:, None]
    rim = 1.4 * (np.cos(angle) * u + np.sin(angle) * np.cross(n, u))
    centers = np.array([[-1.0, 1, 0], [1, -1, 0]])
    camera = framing(sf.Surfels(centers, [n] * 2, radii=1.4), (400, 300), up)
    # As near as the rims let it be: no box or ball around the disks is what must be seen.
    assert within((centers[:, None] + rim).reshape(-1, 3), camera) == pytest.approx(150 - 150 / 1.05, abs=3)


def test_framing_stands_what_is_up_upright_in_the_picture():
    mast = sf.Surfels([[0, y, 0] for y in range(10)], [[0, 0, 1]] * 10, radii=0.1)
    camera = framing(mast, (400, 300), (0, 1, 0))
    column, row, _ = camera.project(mast.points, (400, 300)).T
    assert np.ptp(column) < 1
    assert (np.diff(row) < 0).all()
    assert np.ptp(row) > 200


@given(*[st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda d: np.linalg.norm(d) > 0.1)] * 2)
def test_what_is_upright_is_never_along_the_view(up, view):
    view = np.array(view) / np.linalg.norm(view)
    found = upright(up, view)
    # The axis of the smallest of three coordinates, at most 3^-1/2, is the last resort.
    assert abs(view @ found) < 0.9
    if abs(view @ up) < 0.89 * np.linalg.norm(up):
        np.testing.assert_allclose(found, up / np.linalg.norm(up))


def test_along_a_diagonal_the_next_axis_is_none_to_have_up():
    diagonal = np.full(3, 3**-0.5)
    np.testing.assert_array_equal(upright(diagonal, diagonal), [1, 0, 0])
    np.testing.assert_array_equal(upright([0, 0, 1], np.array([0.0, 0, -1])), [0, 1, 0])


@pytest.mark.parametrize("size", [(400, 300), (300, 400)])
def test_who_faces_a_ball_sees_all_of_it(size):
    target, towards = np.array([1.0, 2, 3]), np.array([0.6, 0, 0.8])
    camera = facing(target, towards, 0.5, (0, 0, 1), 40.0, size)
    # Rays that touch the ball do so at sine = radius / distance towards the camera: the borders of the narrower side.
    sine = 0.5 / np.linalg.norm(camera.eye - target)
    across = np.array([[0.0, 1, 0], [-0.8, 0, 0.6]])  # to the right and up in the picture
    touched = target + 0.5 * (sine * towards + np.sqrt(1 - sine**2) * across)
    right, up = camera.project(touched, size)[:, :2] - np.array(size) / 2
    assert right[0] == pytest.approx(min(size) / 2)
    assert -up[1] == pytest.approx(min(size) / 2)
