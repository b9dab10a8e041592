"""Estimated radii: disks that cover real surfaces, and overlap little."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

import surflux as sf
from surflux import _core
from surflux.meshes.patches import make_patches
from surflux.meshes.reading import read_mesh

MARGIN = 1.1
PROBES = 20_000


def share_covered(surfels, probes, scale=1.0):
    """The share of the probes within some disk's radius, in space, of its centre."""
    distance, near = cKDTree(surfels.points).query(probes, 32)
    return (distance <= scale * surfels.radii[near]).any(axis=1).mean()


@pytest.mark.scans
@pytest.mark.parametrize("name", ["bunny_34834", "armadillo_43k", "buddha_50k", "dragon_50k"])
@pytest.mark.slow
def test_disks_cover_statues(scans, name):
    polygons = read_mesh(scans / "statues" / f"{name}.ply")[:3]
    patches = make_patches(*polygons)
    area = patches.areas.sum()
    probes = _core.sample_triangles(patches.triangles, PROBES, 1)[0]
    uneven, triangle = _core.sample_triangles(patches.triangles, 10_000, 2)
    normals = patches.normals[patches.triangle_patch[triangle]]
    vertices = sf.Surfels(np.asarray(polygons[0], float))
    vertices.areas = area / len(vertices)
    clouds = {
        "vertices": (vertices, 3.4),
        "thinned": (vertices.thinned(5_000), 3.3),
        "blue noise": (sf.Surfels.sample_mesh(scans / "statues" / f"{name}.ply", 5_000, seed=3), 3.2),
        "random": (sf.Surfels(uneven, normals), 4.2),
    }
    for kind, (surfels, overlap) in clouds.items():
        assert share_covered(surfels, probes) >= 0.9995, kind
        assert share_covered(surfels, probes, 1 / MARGIN) >= 0.998, kind
        assert np.pi * (surfels.radii**2).sum() / area <= overlap, kind


def test_normals_tell_the_sheets_of_a_plate_apart():
    """Of a plate thinner than the spacing each side covers itself, whichever way its normals lean."""
    rng = np.random.default_rng(4)
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), [[0, 1, 2, 3]]
    sides = [sf.Surfels.sample_mesh(square, 1000, seed=seed).points for seed in (1, 2)]
    thickness = np.array([0, 0, 0.3 / np.sqrt(1000)])
    normals = np.repeat([[0.0, 0, -1], [0, 0, 1]], 1000, axis=0)
    plate = sf.Surfels(np.concatenate([sides[0], sides[1] + thickness]), normals)
    probes = np.column_stack([rng.uniform(0.05, 0.95, (PROBES, 2)), np.zeros(PROBES)])
    assert share_covered(plate[:1000], probes) >= 0.999
    assert share_covered(plate[1000:], probes + thickness) >= 0.999
    alone = sf.Surfels(sides[0], normals[:1000])
    assert (plate.radii[:1000] <= 1.0001 * alone.radii).mean() > 0.99
