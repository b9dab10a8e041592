"""Surfels of scans some of whose columns are NaN, as in what `surflux solve` writes of points that it leaves out."""

import numpy as np
import pytest

import surflux as sf

GRID = np.stack(np.meshgrid(np.arange(20.0), np.arange(20.0), [0.0], indexing="ij"), axis=-1).reshape(-1, 3)
UP = np.tile([0.0, 0.0, 1.0], (400, 1))


def of(name, values, unknown=3):
    """Columns of one value each, NaN of some points."""
    columns = {f"{name}_{channel}": np.full(400, value) for channel, value in zip("rgb", values, strict=True)}
    columns[f"{name}_g"][unknown] = np.nan
    return columns


@pytest.mark.parametrize("name", ["radius", "area"])
def test_radii_and_areas_that_some_lack_are_estimated_of_all(caplog, name):
    columns = {"radius": np.full(400, 7.0), "area": np.full(400, 9.0)}
    columns[name][[3, 5]] = np.nan
    with caplog.at_level("INFO"):
        found = sf.Scan(GRID, UP, attributes=columns, name="a.ply").surfels()
    assert len(found) == 400
    assert np.array_equal(found.radii, sf.Surfels(GRID, UP).radii)
    assert found.areas is None
    assert f"a.ply: {name} not known (NaN) of 2 of 400 points: estimated of all" in caplog.text
    columns[name][[3, 5]] = 7.0
    known = sf.Scan(GRID, UP, attributes=columns).surfels()
    assert known.radii.tolist() == [7.0] * 400
    assert known.areas is not None


def test_reflectance_that_some_lack_is_that_of_their_colours(caplog):
    columns = of("reflectance", (0.1, 0.2, 0.3))
    with caplog.at_level("INFO"):
        grey = sf.Scan(GRID, UP, attributes=columns, name="a.ply").surfels().reflectance
    assert "a.ply: reflectance not known (NaN) of 1 of 400 points" in caplog.text
    colored = sf.Scan(GRID, UP, np.tile([0.6, 0.7, 0.8], (400, 1)), columns).surfels().reflectance
    assert grey[3] == pytest.approx([0.5] * 3)
    assert colored[3] == pytest.approx([0.6, 0.7, 0.8])
    for found in (grey, colored):
        assert np.delete(found, 3, axis=0) == pytest.approx(np.tile([0.1, 0.2, 0.3], (399, 1)))


def test_emission_that_some_lack_is_none():
    found = sf.Scan(GRID, UP, attributes=of("emission", (1.0, 2.0, 3.0))).surfels().emission
    assert found[3].tolist() == [0.0] * 3
    assert found[4] == pytest.approx([1.0, 2.0, 3.0])


@pytest.mark.parametrize("value", [np.inf, -1.0])
def test_what_is_wrong_is_still_refused(value):
    for name, columns in (("radius", {"radius": np.ones(400)}), ("emission", of("emission", (1.0, 1.0, 1.0), []))):
        columns[next(iter(columns))][3] = value
        with pytest.raises(sf.FileError, match=f"a.ply: vertex 3: {name} is {value:g}; wanted"):
            sf.Scan(GRID, UP, attributes=columns, name="a.ply").surfels()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"points": 3.0}, r"points: wanted shape \(1, 3\), got \(\)"),
        ({"points": [[0, 0]]}, r"points: wanted shape \(1, 3\), got \(1, 2\)"),
        ({"points": [[0, 0, 0]], "reflectance": 0.5}, r"reflectance: wanted shape \(1, 3\), got \(\)"),
        (
            {"points": [[0, 0, 0]], "reflectance": [[0.5, 1.2, 0]]},
            r"reflectance: wanted values in \[0, 1\], got 1\.2.*",
        ),
        (
            {"points": [[0, 0, 0]], "reflectance": [[-0.1, 0, 0]]},
            r"reflectance: wanted values in \[0, 1\], got -0\.1.*",
        ),
        ({"points": [[0, 0, 0]], "reflectance": [[np.nan, 0, 0]]}, "reflectance: wanted finite numbers, got nan.*"),
        ({"points": [[0, 0, 0]], "normals": [[0, 0, 1]] * 2}, r"normals: wanted shape \(1, 3\), got \(2, 3\)"),
        (
            {"points": [[0, 0, 0]], "attributes": {"class": [1, 2]}},
            r"class: wanted an array of 1 row, got shape \(2,\)",
        ),
        (
            {"points": np.ma.masked_array(np.zeros((2, 3)), True)},
            r"points: wanted numbers throughout, got a masked array.*",
        ),
        ({"points": [[0, 0], [0, 0, 0]]}, r"points: wanted an array of numbers, got list .*"),
        ({"points": [[0, 0, 0]], "viewpoints": None}, r"viewpoints: wanted numbers, got None"),
        ({"points": [[0, 0, 0]], "viewpoints": 3}, r"viewpoints: wanted shape \(1, 3\), got \(\)"),
        ({"points": [[0, 0, 0]], "attributes": [1]}, "attributes: wanted a dict of arrays by their names, got list"),
        (
            {"points": [[0, 0, 0]], "attributes": None},
            "attributes: wanted a dict of arrays by their names, got NoneType",
        ),
        ({"points": [[0, 0, 0]], "viewpoints": [1, 2]}, r"viewpoints: wanted shape \(1, 3\), got \(2,\)"),
    ],
)
def test_a_scan_of_arrays_that_do_not_fit_is_refused(given, message):
    """Not at the first use: writing said that laspy cannot unpack an integer."""
    with pytest.raises(ValueError, match=f"^{message}$"):
        sf.Scan(**given)


def test_a_scan_takes_attributes_of_any_kind():
    """As files have them: matrices of each point, texts, none at all; and no viewpoints."""
    points = np.random.default_rng(0).random((20, 3)) * [1, 1, 0]
    attributes = {"pose": np.zeros((20, 2, 2)), "name": ["a"] * 20}
    scan = sf.Scan(points, np.tile([0, 0, 1], (20, 1)), attributes=attributes, viewpoints=[])
    assert scan.viewpoints.shape == (0, 3)
    assert len(scan[:12].surfels()) == 12


def test_a_pit_that_faces_up_is_not_said_to_face_the_wrong_side(caplog):
    """It is seen less from above than from below, as the inside of a body is; but it is ground."""
    x, y = np.random.default_rng(0).uniform(-1, 1, (2, 6000))

    def height(x, y):
        return 0.57 / (1 + np.exp(-(np.maximum(np.abs(x), np.abs(y)) - 0.9) / 0.02))

    step = 1e-4
    slopes = [(height(x + step, y) - height(x, y)) / step, (height(x, y + step) - height(x, y)) / step]
    points, normals = np.column_stack([x, y, height(x, y)]), np.column_stack([*np.negative(slopes), np.ones_like(x)])
    assert sf.facing(points, normals).against.mean() > 0.5
    for order, told in (([0, 1, 2], False), ([0, 2, 1], True)):  # on its side, nothing says that it is ground
        caplog.clear()
        with caplog.at_level("INFO"):
            sf.Scan(points[:, order], normals[:, order], name="pit.ply").surfels(orient=True)
        assert ("face the side that is seen less" in caplog.text) == told
