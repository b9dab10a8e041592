"""Real point files, broken ones among them, in the folder that SURFLUX_DATA names."""

import os
from pathlib import Path

import numpy as np
import pytest

import surflux as sf
from quick import quick
from surflux.points.ply_arrays import load_arrays

MESH = "Surfels.from_mesh reads it as a mesh"
BROKEN = {
    "OutOfMemory.off": MESH,
    "ZeroPoints.e57": "no points: it has none",
    "autzen-utm.pcd": 1065,
    "bad-crc.e57": "pye57 cannot read it (E57Exception: checksum mismatch",
    "bad_vlr_count.las": 10,
    "cube_binary_header_with_RN_newline.ply": 8,
    "cube_uv.ply": 24,
    "diamond_with_bool.ply": "(line 13): property 'is_green' has the unknown type 'bool'",
    "empty.obj": "the file is empty",
    "empty.ply": "the file is empty",
    "float-color.ply": 3,
    "float_inf_point_cloud.ply": 13,  # of 16; three are infinitely far
    "lfs_pointer_bun_zipper_res4.ply": "(line 1): a pointer of git-lfs, not the file itself",
    "malformed.obj": "(line 28): a face has the corner 0 after 8 vertices",
    "missingheader.pcd": "(line 1): not a PCD file",
    "nancolor.obj": MESH,
    "negative_indices.obj": MESH,
    "no_vertex.ply": "no points",
    "noise-dirty.las": 1065,
    "notenoughindices.obj": "(line 9): a face of 2 corners",
    "number_formats.obj": "(line 11): '3.1+e2' is no number",
    "only_a_part_of_vertexcolors.obj": MESH,
    "platonic_shelf_big_endian.ply": 50,
    "ply_empty_header.ply": "no points",
    "point_cloud.obj": 3,
    "point_cloud_test_pos_norm.ply": 4,
    "points.ply": 4,
    "points_ascii_with_lists.ply": 5,
    "points_emptyface.ply": 1024,
    "test_extra_whitespace.ply": 3,
    "utm17_comma.pcd": 10,
    "utm17_space.pcd": 10,
    "whitespace.off": MESH,
}


def needed(name):
    """Skips a file whose reader is an extra that is not installed."""
    if name.endswith((".las", ".laz")):
        pytest.importorskip("laspy")
        pytest.importorskip("lazrs")
    if name.endswith(".e57"):
        pytest.importorskip("pye57")


@pytest.mark.scans
@pytest.mark.filterwarnings("ignore:.*without a finite place:UserWarning")
@pytest.mark.parametrize("name", BROKEN)
def test_broken_files_give_points_or_a_file_error(name):
    path = os.path.join(os.environ["SURFLUX_DATA"], "broken", name)
    assert os.path.exists(path)
    needed(name)
    if isinstance(BROKEN[name], int):
        scan = sf.read_scan(path)
        assert scan.points.shape == (BROKEN[name], 3)
        assert np.all(np.isfinite(scan.points))
        assert {len(values) for values in scan.attributes.values()} <= {len(scan)}
    else:
        with pytest.raises(sf.FileError) as caught:
            sf.read_scan(path)
        assert str(caught.value).startswith(path)
        assert BROKEN[name] in str(caught.value)


@pytest.mark.scans
def test_the_table_of_broken_files_is_complete():
    assert sorted(os.listdir(os.path.join(os.environ["SURFLUX_DATA"], "broken"))) == sorted(BROKEN)


@pytest.mark.scans
def test_details_of_real_files():
    broken = os.path.join(os.environ["SURFLUX_DATA"], "broken")
    # Blue, as floats of 0 ... 1, and an alpha that is left alone.
    blue = load_arrays(os.path.join(broken, "float-color.ply"))["reflectance"]
    np.testing.assert_array_equal(blue, [[0, 0, 0.98]] * 3)
    # All normals of this file are zero.
    assert np.all(np.isnan(load_arrays(os.path.join(broken, "point_cloud_test_pos_norm.ply"))["normals"]))
    cube = load_arrays(os.path.join(broken, "cube_binary_header_with_RN_newline.ply"))["points"]
    np.testing.assert_array_equal(np.unique(cube, axis=0), np.indices((2, 2, 2)).reshape(3, 8).T)


@pytest.mark.scans
@pytest.mark.parametrize(
    ("name", "points", "low", "high"),
    [
        ("armadillo_43k", 43_243, (-0.43527, -0.5734, -0.37948), (0.40334, 0.42655, 0.38333)),
        ("buddha_50k", 49_950, (-0.46095, -1.0022, -0.32388), (0.35222, 0.9775, 0.49018)),
        ("bun_zipper", 35_947, (-0.09469, 0.032987, -0.061874), (0.061009, 0.18732, 0.0588)),
        ("bunny_34834", 34_834, (-0.09469, 0.032987, -0.061874), (0.061009, 0.18732, 0.0588)),
        ("dragon_50k", 50_000, (-7.0467, 0, -3.1513), (7.0467, 9.9399, 3.1513)),
        ("lion_takanawa_342k_surfels", 341_989, (-4.985, 1.039, -3.445), (-0.789, 6.7235, 1.1235)),
    ],
)
def test_statues_have_the_points_and_boxes_of_their_manifest(name, points, low, high):
    loaded = load_arrays(os.path.join(os.environ["SURFLUX_DATA"], "statues", name + ".ply"))
    assert len(loaded["points"]) == points
    np.testing.assert_allclose(loaded["points"].min(axis=0), low, rtol=1e-4, atol=1e-6)
    np.testing.assert_allclose(loaded["points"].max(axis=0), high, rtol=1e-4, atol=1e-6)
    assert (loaded["normals"] is not None) == ("bunny_" in name or "lion" in name)
    assert (loaded["reflectance"] is not None) == ("lion" in name)


@pytest.mark.scans
@pytest.mark.parametrize("name", BROKEN)
@pytest.mark.filterwarnings("ignore:.*normals are zero:UserWarning", "ignore:.*without a finite place:UserWarning")
def test_broken_files_give_surfels_or_a_file_error(name):
    needed(name)
    path = Path(os.environ["SURFLUX_DATA"], "broken", name)
    assert path.exists()
    if isinstance(BROKEN[name], int):
        s = sf.read(path)
        assert len(s) == BROKEN[name]
        for values in (s.points, s.normals, s.radii, s.reflectance):
            assert np.all(np.isfinite(values))
    else:
        with pytest.raises(sf.FileError):
            sf.read(path)


@pytest.mark.scans
def test_the_bunny_comes_back_from_disk(tmp_path):
    bunny = sf.read(Path(os.environ["SURFLUX_DATA"], "statues", "bunny_34834.ply"))
    assert len(bunny) == 34_834
    bunny.save(tmp_path / "a.ply")
    back = sf.read(tmp_path / "a.ply")
    np.testing.assert_array_equal(back.points, bunny.points)
    np.testing.assert_array_equal(back.radii, bunny.radii)


# Of each hard file: surfels when read as points and as a mesh, or why it is not.
HARD = {
    "busted.STL": (MESH, 3831),
    "cube_no_bottom.obj": (MESH, 20),
    "multiple_isolated_triangles.obj": (MESH, 5),
    "noisy_slice_displaced.pcd": (3782, "meshes are not read from .pcd"),
    "rops_cloud.pcd": (32_087, "meshes are not read from .pcd"),
    "sofa.ply": (12_103, 20_515),  # of 18 765 faces, which stand in each other
    "wallhole.obj": (MESH, 21),
}


# Of a second and more each.
SLOW = ("noisy_slice_displaced.pcd", "rops_cloud.pcd", "sofa.ply")


@pytest.mark.scans
def test_the_table_of_hard_files_is_complete(scans):
    assert sorted(os.listdir(scans / "hard")) == sorted(HARD)


@pytest.mark.scans
@pytest.mark.parametrize("name", quick(*(name for name in HARD if name not in SLOW), of=HARD))
def test_hard_files_are_solved_or_refused_with_a_reason(name, scans):
    """Light from above on 500 surfels of each at most: finite, no brighter than the sky and lamp, all of it found."""
    path = scans / "hard" / name
    for make, wanted in zip((sf.read, sf.Surfels.from_mesh), HARD[name], strict=True):
        if isinstance(wanted, str):
            with pytest.raises(sf.FileError) as caught:
                make(path)
            assert str(caught.value).startswith(str(path))
            assert wanted in str(caught.value)
            continue
        s = make(path)
        assert len(s) == wanted
        if len(s) > 500:
            s = s.thinned(500)
        solution = sf.solve(sf.Scene([s], [sf.Environment(1.0)]))
        for values in (solution.radiosity, solution.irradiance, solution.direct):
            assert np.all(np.isfinite(values))
            assert values.min() >= 0.0
        # Under a sky of radiance 1 no surface of rho < 1 and no emission gets more than pi / (1 - rho).
        assert solution.irradiance.max() < np.pi / (1 - s.reflectance.max())
        figures = solution.history[-1]
        ends = figures["power_absorbed"] + figures["power_escaped"] + figures["power_into_backs"]
        assert ends == pytest.approx(figures["power_in"], rel=1e-3)
