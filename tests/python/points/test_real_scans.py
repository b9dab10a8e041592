"""Real scans in the folder that SURFLUX_DATA names: counts and boxes as its manifest says."""

import os

import numpy as np
import pytest

import surflux as sf

# Points, those without a finite place, whether there are normals and colours; the least and the largest coordinates.
SCANS = {
    "autzen_trim.laz": (110_000, 0, False, True, (636001.8, 848935.2, 406.26), (637179.2, 849497.9, 520.51)),
    "bunnyDouble.e57": (30_571, 0, False, False, (-0.094689, 0.040011, -0.061873), (0.061009, 0.18732, 0.058799)),
    "milk_color.pcd": (13_704, 0, False, True, (-0.14008, -0.26378, 0.714), (0.013807, -0.011729, 0.891)),
    "office1.pcd": (307_200, 52_744, False, True, (-2.6455, -2.1964, 1.833), (1.5044, 1.5812, 5.364)),
    "redwood_livingroom_fragment.pcd": (113_662, 0, True, True, (1.152, 0.81527, 0.72641), (3.5195, 2.7617, 1.5304)),
    "region_growing_rgb_tutorial.pcd": (
        307_200,
        47_353,
        False,
        True,
        (-1.0721, -1.5806, 0.843),
        (1.8102, 0.40809, 3.821),
    ),
    "region_growing_tutorial.pcd": (108_104, 0, False, True, (-3838.3, 4065.6, 12776), (1366.7, 11727, 14681)),
    "room_scan1.pcd": (112_586, 0, False, False, (-13.8, -6.4928, -1.3517), (15.447, 7.9796, 1.7091)),
    "simple.las": (1065, 0, False, True, (635619.8, 848899.7, 406.59), (638982.6, 853535.4, 586.38)),
    "table_scene_mug_stereo_textured.pcd": (
        307_200,
        97_920,
        False,
        True,
        (-0.45643, -0.51074, 0.69001),
        (0.71518, 0.17923, 2.5927),
    ),
}


@pytest.mark.scans
def test_the_table_of_scans_is_complete(scans):
    assert sorted(os.listdir(scans / "scans")) == sorted(SCANS)


@pytest.mark.scans
@pytest.mark.parametrize("name", SCANS)
@pytest.mark.filterwarnings("ignore:.*without a finite place:UserWarning")
def test_scans_have_the_points_and_boxes_of_their_manifest(scans, name):
    count, missing, normals, colors, low, high = SCANS[name]
    scan = sf.read_scan(scans / "scans" / name)
    assert len(scan) == count - missing
    np.testing.assert_allclose(scan.points.min(axis=0), low, rtol=1e-4, atol=1e-5)
    np.testing.assert_allclose(scan.points.max(axis=0), high, rtol=1e-4, atol=1e-5)
    assert (scan.normals is not None) == normals
    assert (scan.reflectance is not None) == colors
