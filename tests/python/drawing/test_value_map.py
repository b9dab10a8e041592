"""Pictures of numbers with their scale."""

import numpy as np
import pytest

import surflux as sf
from pixels import pixels
from surflux.drawing import value_map


@pytest.mark.parametrize(
    ("values", "scale"),
    [
        ([0.0, 2000.0], (0.0, 2000.0, 10)),
        ([812.0, 1893.0], (800.0, 2000.0, 6)),
        ([60.0, 2050.0], (0.0, 2250.0, 9)),
        ([0.31, 0.98], (0.3, 1.0, 7)),
        ([5.0, 5.0], (2.5, 7.5, 10)),
        ([0.0, 0.0], (-0.5, 0.5, 10)),
        ([np.nextafter(5.0, 0.0), 5.0], (2.5, 7.5, 10)),
        ([np.nan, 3.0, 4.0], (3.0, 4.0, 10)),
        ([np.nan], (0.0, 1.0, 10)),
        ([-1.0, 7.0], (-1.0, 7.0, 8)),
    ],
)
def test_scales_are_round_and_hold_all(values, scale):
    assert value_map.scale_of(np.array(values)) == pytest.approx(scale)


def test_outliers_do_not_stretch_the_scale():
    values = np.linspace(100.0, 200.0, 1000)
    values[500] = 1e6
    assert value_map.scale_of(values) == pytest.approx((100.0, 200.0, 10))


def test_what_faces_the_lamp_has_the_colour_of_the_scale():
    camera = sf.Camera([0, 0, 5], [0, 0, 0], up=[0, 1, 0])  # right +x, up +y, towards the eye +z
    lamp = np.array(value_map._LAMP) / np.linalg.norm(value_map._LAMP)
    colors = np.array([[0, 0, 0], [100, 200, 50]])
    found = value_map.shaded(colors, np.array([1.0, 1.0, np.nan, 7.0]), np.array([lamp, -lamp, lamp, lamp]), camera)
    assert found.tolist() == [[100, 200, 50], [60, 120, 30], list(value_map._UNKNOWN), [100, 200, 50]]


def test_a_picture_has_its_colours_where_they_belong(tmp_path):
    """Three squares beside each other, seen from above: the least, the largest, and one without a value."""
    corners = [[x, y, 0] for x in (0, 1, 2, 3) for y in (0, 1)]
    squares = sf.Surfels.from_mesh((corners, [[0, 2, 3, 1], [2, 4, 5, 3], [4, 6, 7, 5]]))
    order = np.argsort(squares.points[:, 0])
    values = np.empty(3)
    values[order] = [0.0, 100.0, np.nan]
    camera = sf.Camera.fit(squares.triangles.reshape(-1, 3), [0, 0, -1], [0, 1, 0], aspect=0.87 * 4 / 3)
    path = value_map.value_map(
        squares, values, tmp_path / "a.png", unit="kWh/m2", title="three", camera=camera, size=(400, 300)
    )
    picture = pixels(path)
    row = picture[150]
    places = camera.project(squares.points[order], (400, 300))[:, 0] - 0.5 * value_map.SCALE * 400
    dark, bright, grey = (row[round(place)] for place in places)
    assert dark.max() < 10  # inferno begins black and ends in (252, 255, 164)
    np.testing.assert_allclose(bright / bright[1], np.array([252, 255, 164]) / 255, atol=0.01)
    assert bright[1] > 0.8 * 255
    assert np.ptp(grey) < 12
    assert (picture[:, 352:] < 128).any()  # letters and colours of the scale, on the right
    assert (picture[:30, :120] < 128).any()  # the title
