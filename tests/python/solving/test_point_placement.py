"""Points of the meshless solver on scenes made in Python: scans, statues, rooms (L07 section 6.1)."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

import surflux as sf
from surflux import _core


def place(scene, levels, radius=0.0, seed=0, **options):
    return _core.place_points(scene._to_core(), levels, radius, seed, **options)


def levels_of(placed):
    return np.repeat(np.arange(len(placed["level_begin"]) - 1), np.diff(placed["level_begin"]))


def worst_distance(placed):
    """Least distance of two points of one object over what their levels allow."""
    radius = placed["radii"][placed["objects"]] * 0.5 ** levels_of(placed)
    worst = np.inf
    for level in np.unique(levels_of(placed)):
        # Points of this level against it and all coarser ones.
        own = np.flatnonzero(levels_of(placed) == level)
        up_to = np.flatnonzero(levels_of(placed) <= level)
        tree = cKDTree(placed["positions"][up_to])
        largest = radius[own].max()
        pairs = cKDTree(placed["positions"][own]).sparse_distance_matrix(tree, largest, output_type="coo_matrix")
        i, j = own[pairs.row], up_to[pairs.col]
        keep = (i != j) & (placed["objects"][i] == placed["objects"][j])
        i, j = i[keep], j[keep]
        allowed = radius[i] * np.einsum("ij,ij->i", placed["normals"][i], placed["normals"][j])
        distance = np.linalg.norm(placed["positions"][i] - placed["positions"][j], axis=1)
        positive = allowed > 0
        worst = min(worst, np.min(distance[positive] / allowed[positive], initial=np.inf))
    return worst


def sphere(n, sign):
    k = np.arange(n) + 0.5
    z, phi = 1 - 2 * k / n, np.pi * (1 + 5**0.5) * k
    points = np.stack([np.sqrt(1 - z * z) * np.cos(phi), np.sqrt(1 - z * z) * np.sin(phi), z], axis=1)
    return sf.Surfels(points, sign * points, areas=np.full(n, 4 * np.pi / n))


@pytest.mark.parametrize("sign", [1, -1])
def test_points_on_a_cloud_lie_near_its_surface_and_are_as_dense_as_on_a_plane(sign):
    placed = place(sf.Scene([sphere(20000, sign)]), 4)
    assert worst_distance(placed) >= 1 - 1e-12
    # Disks touch the surface at their centres alone.
    assert np.abs(np.linalg.norm(placed["positions"], axis=1) - 1).max() < 1e-12
    density = np.diff([0, *placed["level_begin"][1:]]).sum() * (placed["radii"][0] / 8) ** 2 / (4 * np.pi)
    assert 0.5 < density < 0.75  # of centres .02 apart those .03 apart: fewer than of places anywhere


def test_a_room_loses_no_point_to_rays_and_levels_quadruple():
    corners = np.array(np.meshgrid([0, 4], [0, 3], [0, 2.5])).T.reshape(-1, 3)
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    inside = sf.Surfels.from_mesh((corners, [f[::-1] for f in faces]), patch_area=0.5)
    center = np.array([2, 1.5, 1.25])
    if np.einsum("ij,ij->i", inside.normals, center - inside.points).min() < 0:
        inside = sf.Surfels.from_mesh((corners, faces), patch_area=0.5)
    assert np.einsum("ij,ij->i", inside.normals, center - inside.points).min() > 0
    placed = place(sf.Scene([inside]), 4)
    count = placed["level_begin"][1:]
    area, radius = 2 * (4 * 3 + 4 * 2.5 + 3 * 2.5), placed["radii"][0]
    # .7 points for each R^2, and more along edges, where nothing beyond them is in the way.
    for level, n in enumerate(count):
        assert n * (radius / 2**level) ** 2 / area > 0.68
    assert np.all(np.abs(count[1:] / count[:-1] - 4) < 0.4)
    assert worst_distance(placed) >= 1 - 1e-12


def test_region_and_progress():
    square = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]))
    seen = []

    def progress(done, total):
        seen.append((done, total))

    placed = place(
        sf.Scene([square]),
        3,
        region=lambda p, n, o: 0.5 - p[0] if n[2] > 0.9 and o == 0 else np.inf,
        progress=progress,
    )
    last = placed["positions"][placed["level_begin"][2] :]
    assert len(last) > 500
    assert last[:, 0].min() >= 0.5
    assert seen[-1] == (1000, 1000)
    with pytest.raises(_core.Cancelled):
        place(sf.Scene([square]), 3, progress=lambda done, total: False)


@pytest.mark.slow
@pytest.mark.scans
def test_statue_and_scan_keep_the_distance_and_lose_no_points(scans):
    bunny = sf.read(scans / "statues" / "bunny_34834.ply")
    placed = place(sf.Scene([bunny]), 5)
    assert worst_distance(placed) >= 1 - 1e-12
    # It is open below: what rays along normals meet there from behind is no reason to leave points out. R is less than
    # the scan's spacing: all but what is crowded have one.
    assert placed["level_begin"][-1] > 0.98 * len(bunny)
