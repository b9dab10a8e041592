"""Cameras of the command line: what is not given comes from a view of everything, but what is up stays up."""

from types import SimpleNamespace

import numpy as np

import surflux as sf
from surflux.cli.pictures import camera_of


def camera(surfels, **given):
    options = {"eye": None, "target": None, "up": None, "fov": None, "size": (64, 48)}
    return camera_of(SimpleNamespace(**options | given), surfels, None)


def test_a_place_that_is_chosen_has_z_up_whatever_shows_most():
    """A frame of a depth camera is seen along z, with -y up; from another place that tilted the picture."""
    points = np.c_[np.random.default_rng(0).uniform(-1, 1, (400, 2)), np.full(400, 2.0)]
    frame = sf.Surfels(points, np.tile([0, 0, -1.0], (400, 1)))
    assert np.abs(camera(frame).up[2]) < 0.5
    np.testing.assert_array_equal(camera(frame, eye=(3.0, -4.0, 0.0)).up, [0, 0, 1])
    np.testing.assert_array_equal(camera(frame, target=(0.3, 0.0, 2.0)).up, [0, 0, 1])
    straight = camera(frame, eye=(0.0, 0.0, 0.0), target=(0.0, 0.0, 2.0))
    assert np.abs(straight.up[2]) < 0.5
    np.testing.assert_array_equal(camera(frame, eye=(3.0, -4.0, 0.0), up=(0.0, 1.0, 0.0)).up, [0, 1, 0])
