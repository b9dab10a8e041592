"""A closed surface of which a part is turned over along a plane, with folds that are thinner than points are apart."""

import numpy as np
import pytest

import surflux as sf


def finned(count, seed):
    """A ball with twelve fins from pole to pole, .07 thick where they are half as high as at the equator (.4)."""
    theta, phi = np.linspace(0, np.pi, 181), np.linspace(0, 2 * np.pi, 1440, endpoint=False)
    t, p = (a.ravel() for a in np.meshgrid(theta, phi, indexing="ij"))
    r = 0.7 + 0.4 * np.exp(8.0 * (np.cos(12.0 * p) - 1.0)) * np.sin(t) ** 2
    vertices = r[:, None] * np.column_stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)])
    i, j = (a.ravel() for a in np.meshgrid(np.arange(180), np.arange(1440), indexing="ij"))
    after = (j + 1) % 1440
    quads = np.column_stack([i, i + 1, i + 1, i]) * 1440 + np.column_stack([j, j, after, after])
    faces = np.concatenate([quads[i < 179][:, [0, 1, 2]], quads[i > 0][:, [0, 2, 3]]])  # none without area
    return sf.Surfels.sample_mesh((vertices, faces), count, seed)


def houses(seed):
    """Points and normals of four houses without floors on a square of 10, every .2."""
    ground = [[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0]], [[0, 1, 2, 3]]
    parts = [sf.Surfels.sample_mesh(ground, 2000, seed)]
    for k, place in enumerate([[-2.5, -2.5, 0], [2.5, -2.5, 0], [-2.5, 2.5, 0], [2.5, 2.5, 0]]):
        corners = [[x, y, z] for z in (0, 2) for y in (-1.5, 1.5) for x in (-1, 1)]
        faces = [[4, 5, 7, 6], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]]
        parts.append(sf.Surfels.sample_mesh((np.add(corners, place), faces), 333, seed + k + 1))
    return (np.concatenate([getattr(p, name) for p in parts]) for name in ("points", "normals"))


def beyond_planes(surfels, seed):
    """Masks of what lies beyond three planes: some 20 to 70 % of the surfels."""
    rng = np.random.default_rng(seed)
    for share in (0.3, 0.5, 0.8):
        along = surfels.points @ rng.normal(size=3)
        yield along > np.quantile(along, share)


def told(surfels, turned):
    """The share of surfels of which inward_patches says rightly whether they are turned over."""
    return np.mean((sf.inward_patches(surfels.flipped(turned)) > 0) == turned)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_part_of_what_has_thin_fins_is_found_and_what_is_right_stays(seed):
    s = finned(10_000, seed)
    assert told(s, np.zeros(len(s), bool)) == 1.0
    assert told(s, np.ones(len(s), bool)) >= 0.999
    for part in beyond_planes(s, seed):
        assert told(s, part) >= 0.998


SAMPLINGS = {
    "all": lambda path, whole: whole,
    "read 20 000": lambda path, whole: sf.read(path, points=20_000),
    "thinned to 20 000": lambda path, whole: whole.thinned(20_000),
    "20 000 at random": lambda path, whole: at_random(whole, 20_000),
}


def at_random(whole, count):
    rows = np.random.default_rng(0).permutation(len(whole))[:count]
    return sf.Surfels(whole.points[rows], normals=whole.normals[rows])


@pytest.mark.scans
@pytest.mark.slow
@pytest.mark.parametrize("sampling", list(SAMPLINGS))
@pytest.mark.parametrize("name", ["buddha_50k", "dragon_50k"])
def test_a_part_of_a_statue_is_found_however_it_is_sampled(name, sampling, scans):
    path = scans / "statues" / f"{name}.ply"
    s = SAMPLINGS[sampling](path, sf.read(path))
    assert told(s, np.zeros(len(s), bool)) == 1.0
    for part in beyond_planes(s, 0):
        assert told(s, part) >= 0.993


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_where_nothing_tells_which_part_is_turned_over_lines_of_change_are_found(seed):
    """Houses on ground that goes on beneath them, coarsely sampled: of the seams no sheet can be made."""
    points, normals = houses(seed)
    assert not sf.facing(points, normals).unsure.any()
    assert not sf.facing(points, -normals).unsure.any()
    for place in (0.3, -1.0, 1.5):
        found = sf.facing(points, np.where(points[:, :1] > place, -normals, normals))
        assert not found.turned.any()
        assert found.unsure.sum() > 50
        assert np.all(np.abs(points[found.unsure, 0] - place) < 1.5)  # points lie .2 apart
