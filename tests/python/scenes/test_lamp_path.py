"""Files of lamps that move: what stands between keyframes, and what is refused."""

import numpy as np
import pytest

import surflux as sf


@pytest.fixture
def read(tmp_path):
    def call(text):
        (tmp_path / "lights.toml").write_text(text)
        return sf.load_lamps(tmp_path / "lights.toml")

    return call


POINT = '[[light]]\ntype = "point"\n'


def test_lamps_that_stay_are_one_frame(read):
    text = POINT + 'position = [1, 2, 3]\nintensity = 4\n[[light]]\ntype = "directional"\n'
    frames = read(text + "direction = [0, 0, -2]\nirradiance = [1, 2, 3]")
    assert frames == [[sf.PointLight([1, 2, 3], 4), sf.DirectionalLight([0, 0, -1], [1, 2, 3])]]
    assert len(read("frames = 3\n" + POINT + "position = [1, 2, 3]\nintensity = 4")) == 3


def test_keyframes_are_spread_over_the_frames(read):
    lamp = "position = [[0, 0, 1], [4, 0, 1], [4, 8, 1]]\nintensity = [[8, 0, 4], 0]\n"
    frames = read("frames = 5\n" + POINT + lamp)
    places = [(0, 0, 1), (2, 0, 1), (4, 0, 1), (4, 4, 1), (4, 8, 1)]
    shines = [(8, 0, 4), (6, 0, 3), (4, 0, 2), (2, 0, 1), (0, 0, 0)]
    assert frames == [[sf.PointLight(*both)] for both in zip(places, shines, strict=True)]


def test_keyframes_stand_where_at_says(read):
    lamp = "position = [[0, 0, 1], [6, 0, 1]]\nintensity = 1\nat = [2, 5]\n"
    frames = read("frames = 6\n" + POINT + lamp)
    assert [light.position[0] for (light,) in frames] == [0, 0, 2, 4, 6, 6]


def test_a_circle_stops_a_frame_before_its_beginning(read):
    lamp = "position = [[0, 0, 1], [6, 0, 1]]\nintensity = 1\n"
    frames = read("frames = 4\nclosed = true\n" + POINT + lamp)
    assert [light.position[0] for (light,) in frames] == [0, 3, 6, 3]
    frames = read("frames = 4\nclosed = true\n" + POINT + lamp + "at = [2, 3]")  # 3 frames for the way back
    np.testing.assert_allclose([light.position[0] for (light,) in frames], [2, 0, 6, 4])


def test_smooth_is_a_camera_path(read):
    """Two implementations of Catmull and Rom, on the same keyframes."""
    keys = [[0, 0, 1], [3, 1, 1], [4, 4, 0], [0, 5, 2]]
    cameras = [sf.Camera(key, [9, 9, 9]) for key in keys]
    for closed in (False, True):
        text = f'frames = 13\ninterpolation = "smooth"\nclosed = {str(closed).lower()}\n'
        frames = read(text + POINT + f"position = {keys}\nintensity = 1")
        wanted = [camera.eye for camera in sf.camera_path(cameras, 13, closed=closed)]
        np.testing.assert_allclose([light.position for (light,) in frames], wanted, atol=1e-12)


def test_smooth_moves_lamps_but_not_their_power(read):
    text = 'frames = 7\ninterpolation = "smooth"\n' + POINT + "position = [0, 0, 1]\n"
    frames = read(text + "intensity = [[0, 0, 0], [6, 6, 6], [0, 0, 0], [0, 0, 0]]")
    assert [light.intensity[0] for (light,) in frames] == [0, 3, 6, 3, 0, 0, 0]


def test_cones_and_edges_may_move(read):
    spot = '[[light]]\ntype = "spot"\nposition = [0, 0, 1]\ndirection = [[1, 0, -1], [-1, 0, -1]]\nintensity = 2\n'
    area = '[[light]]\ntype = "area"\ncorner = [0, 0, 2]\nedge_u = [[1, 0, 0], [3, 0, 0]]\nedge_v = [0, 1, 0]\n'
    frames = read("frames = 3\n" + spot + "cone = [40, 20]\n" + area + "exitance = 5")
    assert [round(lights[0].cone, 9) for lights in frames] == [40, 30, 20]
    np.testing.assert_allclose(frames[1][0].direction, [0, 0, -1], atol=1e-15)
    assert [lights[1].edge_u[0] for lights in frames] == [1, 2, 3]


MOVING = "position = [[0, 0, 1], [1, 0, 1]]\nintensity = 1\n"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", r"\(light\): wanted at least one \[\[light\]\], got none"),
        (POINT + MOVING, r"\(frames\): is missing"),
        ("frames = 0\n" + POINT + MOVING, r"\(frames\): wanted .* got 0"),
        ("frame = 3\n" + POINT + MOVING, r"\(frame\): is not a key here"),
        ('interpolation = "cubic"\n' + POINT + MOVING, r'\(interpolation\): wanted one of "linear", "smooth"'),
        ("closed = 1\n" + POINT + MOVING, r"\(closed\): wanted"),
        ('[[light]]\ntype = "environment"\nradiance = 1', r"\(light 1, type\): wanted one of \"point\", \"spot\""),
        (POINT + "intensity = 1", r"\(light 1, position\): is missing"),
        (POINT + "position = [0, 0, 1]\npower = 1", r"\(light 1, power\): is not a key here"),
        (POINT + "position = [0, 0]\nintensity = 1", r"\(light 1, position\): wanted .*\(3,\)"),
        ("frames = 2\n" + POINT + "position = [[0, 0, 1], [0, 0]]\nintensity = 1", r"position\): keyframe 2: wanted"),
        ("frames = 2\n" + POINT + "position = [0, 0, 1]\nintensity = [[1, 1, 1], -1]", r"intensity\): keyframe 2: "),
        ("frames = 2\n" + POINT + MOVING + "at = [1]", r"position\): has 2 keyframes, but `at` lists 1 frame$"),
        ("frames = 2\n" + POINT + MOVING + "at = [2, 1]", r"at\): wanted ascending numbers of frames, from 1 to 2"),
        ("frames = 2\n" + POINT + MOVING + "at = [1, 3]", r"at\): wanted ascending numbers of frames, from 1 to 2"),
        ("frames = 2\n" + POINT + MOVING + 'at = "all"', r"at\): wanted real numbers"),
        (POINT + "position = [0, 0, 1]\nintensity = 1\nat = [1]", r"at\): is for keyframes, of which there are none"),
    ],
)
def test_what_is_refused_names_file_and_key(read, text, said):
    with pytest.raises(sf.FileError, match=r"lights\.toml .*" + said):
        read(text)


def test_what_goes_wrong_between_keyframes_names_the_frame(read):
    spot = '[[light]]\ntype = "spot"\nposition = [0, 0, 1]\ndirection = [[0, 0, 1], [0, 0, -1]]\nintensity = 2\n'
    with pytest.raises(sf.FileError, match=r"\(light 1, direction\): .* in frame 2"):
        read("frames = 3\n" + spot)
    cone = spot.replace("[[0, 0, 1], [0, 0, -1]]", "[0, 0, 1]") + "cone = []"
    with pytest.raises(sf.FileError, match=r"cone\): wanted a number or keyframes, got an empty list"):
        read("frames = 3\n" + cone)


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(sf.FileError, match=r"none\.toml: no such file"):
        sf.load_lamps(tmp_path / "none.toml")
    with pytest.raises(ValueError, match="path: wanted a path"):
        sf.load_lamps(3)
