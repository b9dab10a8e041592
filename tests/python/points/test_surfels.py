import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import surflux as sf


def grid(n=4):
    x, y = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
    return np.stack([x.ravel(), y.ravel(), np.zeros(n * n)], axis=1).astype(float)


def flat(n=4, **options):
    points = grid(n)
    return sf.Surfels(points, np.tile([0.0, 0.0, 1.0], (len(points), 1)), radii=options.pop("radii", 1.0), **options)


def test_materials_take_every_shape():
    n = 16
    one_each = np.linspace(0, 0.9, n)
    rgb_each = np.random.default_rng(0).uniform(0, 0.99, (n, 3))
    assert (flat(reflectance=0.3).reflectance == 0.3).all()
    assert (flat(reflectance=[0.1, 0.2, 0.3]).reflectance == [0.1, 0.2, 0.3]).all()
    assert (flat(reflectance=one_each).reflectance == one_each[:, None]).all()
    assert (flat(reflectance=rgb_each).reflectance == rgb_each).all()
    assert (flat(emission=100.0).emission == 100.0).all()
    # With three surfels, three numbers are one colour.
    s = sf.Surfels(np.eye(3), np.eye(3), radii=1, reflectance=[0.1, 0.2, 0.3])
    assert (s.reflectance == [0.1, 0.2, 0.3]).all()


def test_integer_and_single_precision_input():
    s = sf.Surfels(np.arange(6).reshape(2, 3), np.eye(3, dtype=np.float32)[:2], radii=[1, 2])
    assert s.points.dtype == s.normals.dtype == s.radii.dtype == np.float64
    assert s.radii.tolist() == [1.0, 2.0]


@given(st.integers(0, 2**32), st.floats(-300, 300))
def test_normals_come_out_unit_whatever_their_length(seed, exponent):
    d = np.random.default_rng(seed).normal(size=(5, 3))
    unit = d / np.linalg.norm(d, axis=1, keepdims=True)
    s = sf.Surfels(np.zeros((5, 3)), unit * 10.0**exponent, radii=1)
    assert np.abs(s.normals - unit).max() < 1e-15


def test_unit_normals_stay_bit_by_bit():
    d = np.random.default_rng(1).normal(size=(1000, 3))
    unit = sf.Surfels(d, d, radii=1).normals
    assert (sf.Surfels(d, unit, radii=1).normals == unit).all()


def test_survey_coordinates_keep_every_bit():
    points = grid() * 0.001 + [5.1e6, 4.3e5, 120.0]
    assert (sf.Surfels(points, np.tile([0, 0, 1], (16, 1)), radii=0.001).points == points).all()


def test_input_is_copied():
    points = grid()
    s = sf.Surfels(points, np.tile([0, 0, 1], (16, 1)), radii=1)
    points[:] = 7
    assert (s.points == grid()).all()


def test_areas_are_open_until_given_and_can_be_taken_back():
    s = flat()
    assert s.areas is None
    assert repr(s) == "Surfels(16 surfels, no areas)"
    s.areas = np.arange(16.0)
    assert s.areas.tolist() == list(range(16))
    assert repr(s) == "Surfels(16 surfels, area 120)"
    s.areas = 2.0
    assert s.areas.sum() == 32.0
    s.areas = None
    assert s.areas is None


def test_selections_agree_with_numpy():
    s = flat(areas=np.arange(16.0), reflectance=np.linspace(0, 0.9, 16), emission=np.arange(16.0))
    for chosen in (s.points[:, 0] > 1.5, [3, 1, 1, -1], slice(2, 11, 3), np.array([5], np.uint8)):
        part = s[chosen]
        for name in ("points", "normals", "radii", "areas", "reflectance", "emission"):
            assert (getattr(part, name) == getattr(s, name)[chosen]).all()
    assert (s[5].points == s.points[5]).all()
    assert [len(one) for one in s] == [1] * 16  # iteration ends
    assert len(s) == 16


@pytest.mark.parametrize("chosen", [np.zeros(16, bool), [], np.zeros(0, int), slice(5, 5)], ids=repr)
def test_what_chooses_none_gives_none(chosen):
    """So that s[mask] needs no case of its own where nothing is chosen."""
    square = ([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]])
    for s in (flat(areas=2.0), sf.Surfels.from_mesh(square, patch_area=1 / 16)):
        assert len(s) == 16
        none = s[chosen]
        assert len(none) == 0
        for name in ("points", "normals", "radii", "areas", "reflectance", "emission", "triangles", "triangle_surfel"):
            assert getattr(none, name).shape == (0, *getattr(s, name).shape[1:]), name
        assert list(none) == []
        assert repr(none) == "Surfels(0 surfels, area 0)"
        assert "<td" in none._repr_html_()
        assert none.bounds.tolist() == [[np.inf] * 3, [-np.inf] * 3]
        for other in (
            none[[]],
            none[np.zeros(0, bool)],
            pickle.loads(pickle.dumps(none)),
            none.flipped(),
            none.transformed(np.diag([2.0, 2, 2, 1])),
            none.replace(reflectance=0.2, emission=np.zeros((0, 3)), radii=np.zeros(0), areas=1.0),
            sf.concatenate([none, none]),
            *sf.divide_patches([none]),
        ):
            assert len(other) == 0
        for both in (sf.concatenate([none, s]), sf.concatenate([s, none])):
            assert (both.points == s.points).all()
            assert (both.areas == s.areas).all()
        assert sf.effective_areas(none).shape == sf.inward_patches(none).shape == (0,)


def test_none_cannot_be_solved_drawn_or_saved(tmp_path):
    none = flat()[[]]
    for call in (
        lambda: sf.Scene([flat(), none]),
        lambda: sf.build_hierarchy(none),
        lambda: sf.view(none),
        lambda: sf.Page(none),
        lambda: none.plot(),
        lambda: none.plot_areas(),
        lambda: none.to_pyvista(),
        lambda: none.save(tmp_path / "none.ply"),
    ):
        with pytest.raises(ValueError, match=r"^(objects|s|thing|surfels): wanted at least one surfel.*, got none"):
            call()
    assert not list(tmp_path.iterdir())


def test_a_selection_is_a_copy():
    s = flat(areas=1.0)
    part = s[:4]
    part.areas = 9.0
    assert (s.areas == 1.0).all()


def test_two_sided_pairs_face_both_ways():
    s = flat(two_sided=True, areas=1.5)
    assert len(s) == 32
    assert (s.points[:16] == s.points[16:]).all()
    assert (s.normals[:16] == -s.normals[16:]).all()
    assert s.areas.sum() == 48.0


def test_missing_normals_and_radii_are_estimated():
    # On a plane every fit is exact, and the 6 nearest of a unit grid reach sqrt(2) inside.
    s = sf.Surfels(grid(9), viewpoint=[4, 4, 10])
    assert np.abs(s.normals - [0, 0, 1]).max() < 1e-6
    assert s.radii.reshape(9, 9)[2:-2, 2:-2] == pytest.approx(1.1 * np.sqrt(0.5), rel=1e-9)
    below = sf.Surfels(grid(9), viewpoint=[4, 4, -10])
    assert np.abs(below.normals - [0, 0, -1]).max() < 1e-6


def test_thinned_keeps_what_it_says():
    s = flat(20, reflectance=np.linspace(0, 0.9, 400), emission=np.arange(400.0), areas=1.0)
    t = s.thinned(60, seed=3)
    assert len(t) == 60
    assert t.areas is None
    where = np.array([np.flatnonzero((s.points == p).all(axis=1))[0] for p in t.points])
    assert len(set(where.tolist())) == 60
    assert (t.reflectance == s.reflectance[where]).all()
    assert (t.emission == s.emission[where]).all()
    assert (t.radii > s.radii[where]).mean() > 0.9  # they reach over the gaps
    again = s.thinned(60, seed=3)
    assert (again.points == t.points).all()
    assert (s.thinned(400).points == s.points).all()


@pytest.mark.parametrize("n", [2, 9, 400])
def test_thinned_wants_some_area(n):
    with pytest.raises(ValueError, match=r"^areas: wanted some above 0, got 0 for all surfels$"):
        flat(20, areas=0.0).thinned(n)
    assert len(flat(20, areas=np.arange(400) % 2).thinned(n)) == n


def test_thinned_patches_become_disks():
    square = ([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]])
    t = sf.Surfels.from_mesh(square, patch_area=0.01).thinned(30)
    assert len(t) == 30
    assert len(t.triangles) == 0


def test_sample_mesh_lies_on_the_mesh_and_spreads():
    square = ([[0, 0, 1], [2, 0, 1], [2, 1, 1], [0, 1, 1]], [[0, 1, 2, 3]])
    s = sf.Surfels.sample_mesh(square, 200, seed=5, reflectance=0.2)
    assert len(s) == 200
    assert (s.normals == [0, 0, 1]).all()
    assert np.abs(s.points[:, 2] - 1).max() < 1e-12
    assert s.points.min(axis=0) == pytest.approx([0, 0, 1], abs=0.1)
    assert s.points.max(axis=0) == pytest.approx([2, 1, 1], abs=0.1)
    assert s.areas is None
    # 200 points on an area of 2: as hexagons they stand 0.107 apart; sample elimination keeps at least half of that.
    distance = np.linalg.norm(s.points[:, None] - s.points[None], axis=2) + 9 * np.eye(200)
    assert distance.min() > 0.5 * np.sqrt(2 / np.sqrt(3) * 2 / 200)
    again = sf.Surfels.sample_mesh(square, 200, seed=5)
    assert (again.points == s.points).all()


def test_areas_of_patches_are_exact_and_nothing_is_stored():
    square = ([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]], [[0, 1, 2, 3]])
    s = sf.Surfels.from_mesh(square, patch_area=0.04)
    s.areas = None
    assert sf.effective_areas(s) == pytest.approx(np.full(100, 0.04), rel=1e-14)
    assert s.areas is None


def test_to_pyvista_carries_every_array():
    s = flat(areas=2.0, reflectance=0.25)
    cloud = s.to_pyvista()
    assert (cloud.points == s.points).all()
    assert (cloud["normals"] == s.normals).all()
    assert cloud["area"].sum() == 32.0
    assert (cloud["reflectance"] == 0.25).all()
    assert "area" not in flat().to_pyvista().point_data


def test_public_names():
    for name in sf.__all__:
        if name not in (
            "Camera",
            "Solution",
            "form_factors",
            "load_solution",
            "read",
            "read_image",
            "solve",
            "write_image",
        ):
            assert getattr(sf, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'radiosty'"):
        getattr(sf, "radiosty")  # noqa: B009
    assert set(sf.__all__) <= set(dir(sf))


@pytest.mark.parametrize("kind", ["points", "disks", "patches"])
def test_to_pyvista_draws_every_kind(kind):
    mesh = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]), patch_area=0.25)
    both = sf.concatenate([mesh.replace(emission=[1.0, 2.0, 3.0]), flat().replace(areas=1.0)])
    found = both.to_pyvista(kind)
    if kind == "points":
        owner, data = np.arange(len(both)), found.point_data
    else:
        owner, data = found.cell_data["surfel"], found.cell_data
        assert found.area == pytest.approx(both[np.unique(owner)].areas.sum() if kind == "patches" else found.area)
        assert set(owner) == set(range(len(mesh) if kind == "patches" else len(both)))
    for name in ("normals", "radii", "reflectance", "emission"):
        np.testing.assert_array_equal(data[{"radii": "radius"}.get(name, name)], getattr(both, name)[owner])
    # Whoever integrates over cells has each surfel once.
    np.testing.assert_allclose(np.bincount(owner, data["area"]), both[np.unique(owner)].areas)
    assert list(found.field_data["units"]) == ["radius: length", "emission: W/m2", "area: length^2"]


@pytest.mark.parametrize("kind", ["points", "disks", "patches"])
def test_to_pyvista_says_which_face_a_patch_came_from(kind):
    square, wall = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 0, 1], [0, 1, 1]]
    found = sf.Surfels.from_mesh((square + wall, [[0, 1, 2, 3], [0, 4, 5, 3]]), patch_area=0.25).to_pyvista(kind)
    data, at = (found.point_data, found.points) if kind == "points" else (found.cell_data, found.cell_centers().points)
    np.testing.assert_array_equal(data["face"], (at[:, 0] == 0).astype(int))
    assert "face" not in flat().to_pyvista().point_data


def test_what_to_pyvista_cannot_draw():
    with pytest.raises(ValueError, match="kind: wanted one of"):
        flat().to_pyvista("splats")
    with pytest.raises(ValueError, match="for none of these surfels is a patch of a mesh"):
        flat().to_pyvista("patches")


def test_the_core_refuses_arrays_that_do_not_fit():
    core = flat()._core
    with pytest.raises(ValueError, match="areas: wanted one for each surfel, or none"):
        core.with_areas(np.ones(len(core) + 1))
    with pytest.raises(ValueError, match="indices: wanted those of surfels"):
        core.select(np.array([len(core)], np.uint32))


def test_masked_values_are_refused():
    """What stood behind the mask was taken: -9999, as rasters have it."""
    holed = np.ma.masked_less([[0.0, 0, 0], [1, 0, 0], [-9999, 0, 0]], -9000)
    with pytest.raises(ValueError, match="points: wanted numbers throughout, got a masked array"):
        sf.Surfels(holed, [[0, 0, 1]] * 3)
    whole = sf.Surfels(np.ma.array(holed.data, mask=False), [[0, 0, 1]] * 3, radii=1.0)
    assert whole.points[2, 0] == -9999
