"""Points that are not of the surface: repeats, and what stands alone."""

import numpy as np

from surflux.points.cleaning import first_of_each, isolated


def square(n, seed):
    """Random points of a square of side 1, uneven as scans are."""
    return np.column_stack([np.random.default_rng(seed).random((n, 2)), np.zeros(n)])


def test_repeats_count_as_the_first():
    points = square(1000, 0)
    order = np.random.default_rng(1).permutation(3000)
    many = np.tile(points, (3, 1))[order]
    first = first_of_each(many)
    assert np.array_equal(many[first], many)
    kept = first == np.arange(3000)
    assert kept.sum() == 1000
    for row in range(3000):
        assert first[row] == np.flatnonzero(order % 1000 == order[row] % 1000)[0]


def test_zero_has_one_sign():
    assert first_of_each(np.array([[0.0, 1.0, 2.0], [-0.0, 1.0, 2.0]])).tolist() == [0, 0]


def test_the_back_of_a_sheet_is_no_repeat():
    points = np.zeros((5, 3))
    normals = np.array([[0, 0, 1.0], [0, 0, -1], [0, 0.1, 1], [0, 0.1, -1], [0, 0, -1]])
    assert first_of_each(points, normals).tolist() == [0, 1, 0, 1, 1]


def test_what_stands_alone_is_found_at_any_density():
    """Half the square is a hundred times as dense: the sparse half is not alone, two points above are."""
    for seed in range(3):
        points = square(20_000, seed)
        sparse = (points[:, 0] > 0.5) & (np.arange(len(points)) % 100 > 0)
        points = points[~sparse]
        alone = np.array([[0.2, 0.5, 0.3], [0.7, 0.2, 0.9]])
        found = isolated(np.concatenate([points, alone]))
        assert found[-2:].all()
        assert found[:-2].mean() < 1e-3


def test_uneven_sampling_is_not_cleaned():
    """Of the corners of a mesh with few large faces, more than a hundredth are far from others."""
    points = np.concatenate([square(2000, 3), 5.0 * square(60, 4) + [2.0, 0.0, 0.0]])
    points[2000:, 2] = np.linspace(1, 9, 60)
    assert not isolated(points).any()
    assert not isolated(points[:10]).any()
