"""Two scanned bunnies in a room, data/two_bunnies.toml (D04 fig. 7a), from the file to the picture."""

from pathlib import Path

import numpy as np
import pytest

import surflux as sf

pytestmark = [pytest.mark.scans, pytest.mark.slow]
WALLS, BUNNY = 2400, 4000  # 6 walls of 20 x 20 patches; thinned to 4000


@pytest.fixture(scope="module")
def solution():
    return sf.solve(sf.load_scene(Path(__file__).parents[3] / "data" / "two_bunnies.toml", surfels=WALLS + 2 * BUNNY))


@pytest.fixture(scope="module")
def picture(solution):
    return solution.render(size=(400, 300), layers=True)


def test_every_surfel_has_a_finite_value(solution):
    assert len(np.unique(solution.parents)) == WALLS + 2 * BUNNY
    for values in (solution.radiosity, solution.irradiance, solution.direct):
        assert np.all(np.isfinite(values))
    assert solution.radiosity.min() >= 0.0
    assert solution.radiosity.max() < 40.0  # less than the lamps, which are the brightest


def test_it_is_right_by_its_own_account(solution):
    assert 0.0 < solution.error < 0.05
    figures = solution.history[-1]
    ends = figures["power_absorbed"] + figures["power_escaped"] + figures["power_into_backs"]
    assert figures["power_in"] == pytest.approx(ends, rel=1e-3)
    assert figures["power_escaped"] < 1e-7 * figures["power_in"]  # the room is closed, but for a ray along an edge
    # Four lamps of .36 m2 and exitance 40 in three channels; what shines on the lamps' own ceiling and beside is none.
    assert figures["power_in"] == pytest.approx(3 * 4 * 0.36 * 40, rel=0.03)


def test_colour_bleeds_from_the_green_walls(solution):
    """The marble is nearly grey, .67 .66 .64: what makes it green comes from the side walls."""
    marble = solution.objects == 1
    rho = solution.surfels.reflectance[marble].mean(axis=0)
    red, green, blue = solution.radiosity[marble].mean(axis=0) / rho
    assert green > 1.1 * red
    assert green > 1.1 * blue
    # Direct light is white.
    np.testing.assert_allclose(solution.direct[:, 1], solution.direct[:, 0], rtol=1e-12)


def test_shadows_lie_under_the_bunnies(solution):
    s = solution.surfels
    floor = np.flatnonzero((s.points[:, 2] == 0) & (solution.objects == 0))
    under = np.linalg.norm(s.points[floor, :2] - [1.05, 2.1], axis=1) < 0.35
    assert under.sum() > 5
    assert solution.direct[floor[under], 0].mean() < 0.5 * np.median(solution.direct[floor, 0])


def test_the_picture_is_whole(picture, solution):
    """Inside the room's rim, 3.5 m wide at 4.9 m before a camera of 40 degrees, no pixel is left open or black."""
    image, depth = picture["radiance"], picture["depth"]
    assert np.all(np.isfinite(image))
    # The front wall is seen through from behind; its rim is at 1.75 / (4.9 tan 20) = .98 of half the height.
    height, width = depth.shape
    half = int(0.97 * 0.5 * height)
    inside = np.s_[height // 2 - half : height // 2 + half, width // 2 - half : width // 2 + half]
    assert np.all(np.isfinite(depth[inside]))
    # The darkest paint is .03 to .1 in all channels, under the median irradiance; a tenth of that for the shade.
    assert image[inside].max(axis=2).min() > 0.1 * 0.1 * np.median(solution.irradiance) / np.pi
    # Both bunnies are in it, and green bleeding on the marble one.
    index = picture["index"][inside]
    seen = np.where(index < 0, -1, solution.objects[index])
    marble, spotted = seen == 1, seen == 2
    assert marble.mean() > 0.02
    assert spotted.mean() > 0.02
    red, green, blue = picture["indirect"][inside][marble].mean(axis=0)
    assert green > 1.2 * red
    assert green > 1.2 * blue
