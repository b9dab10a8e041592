"""Plain values with arrays in them compare, and are keys of dicts and members of sets, by what they hold."""

import dataclasses
import importlib
import inspect
import pkgutil
import re

import numpy as np
import pytest

import surflux as sf

IMAGE = np.arange(24.0).reshape(2, 4, 3)


def shares(index=4):
    grid = sf.Surfels([[x, y, 0] for y in range(3) for x in range(3)], normals=[[0, 0, 1]] * 9, radii=1.5)
    return sf.area_shares(grid, index, resolution=8)


# What makes a value from nothing but what is written here, and others that make a different one.
VALUES = {
    "point": (lambda: sf.PointLight(np.zeros(3), 1.0), lambda: sf.PointLight(np.ones(3), 1.0)),
    "spot": (lambda: sf.SpotLight([0, 0, 1], [0, 0, -1], 1), lambda: sf.SpotLight([0, 0, 1], [0, 0, -1], 1, cone=30)),
    "photometry": (
        lambda: sf.Photometry([0], [0, 90], [[1, 0]]),
        lambda: sf.Photometry([0], [0, 80], [[1, 0]]),
        lambda: sf.Photometry([0], [0, 90], [[0, 1]]),
    ),
    "luminaire": (
        lambda: sf.PhotometricLight([0, 0, 1], sf.Photometry([0], [0, 90], [[1, 0]])),
        lambda: sf.PhotometricLight([0, 0, 1], sf.Photometry([0], [0, 90], [[2, 0]])),
        lambda: sf.PhotometricLight([0, 0, 1], sf.Photometry([0], [0, 90], [[1, 0]]), azimuth=90),
    ),
    "area": (
        lambda: sf.AreaLight([0, 0, 1], [1, 0, 0], [0, 1, 0], np.ones(3)),
        lambda: sf.AreaLight([0, 0, 1], [1, 0, 0], [0, 1, 0], np.array([1, 1, 2])),
    ),
    "sun": (lambda: sf.DirectionalLight([0, 0, -2], 1), lambda: sf.DirectionalLight([0, 1, -2], 1)),
    "colour": (lambda: sf.Environment(1.0), lambda: sf.Environment([1.0, 1.0, 2.0]), lambda: sf.Environment(IMAGE)),
    "image": (
        lambda: sf.Environment(IMAGE),
        lambda: sf.Environment(IMAGE + np.eye(3)[0]),
        lambda: sf.Environment(IMAGE[:1]),
        lambda: sf.Environment(IMAGE, up=(0, 1, 0)),
        lambda: sf.Environment(IMAGE, azimuth=90),
    ),
    "camera": (lambda: sf.Camera([0, -4, 1], [0, 0, 1]), lambda: sf.Camera([0, -4, 1], [0, 0, 1], height=2)),
    "shares": (shares, lambda: shares(0)),
}


@pytest.mark.parametrize("name", VALUES)
def test_equal_contents_are_equal(name):
    make, *others = VALUES[name]
    one, same = make(), make()
    assert one == same
    assert hash(one) == hash(same)
    assert {one: "found"}[same] == "found"
    for other in [other() for other in others]:
        assert one != other
        assert len({one, same, other}) == 2


@pytest.mark.parametrize("name", VALUES)
def test_what_is_of_another_kind_is_not_equal(name):
    value = VALUES[name][0]()
    for other in (None, 1.0, "light", np.zeros(3), sf.PointLight([9, 9, 9], 9)):
        assert not np.any(value == other)


def test_zeros_of_either_sign_are_one_key():
    one, same = sf.Environment(0.0 * IMAGE), sf.Environment(-0.0 * IMAGE)
    assert one == same
    assert hash(one) == hash(same)


def test_what_is_compared_cannot_change():
    found = shares()
    for array in (found.neighbors, found.shares, found.frame, sf.Environment(IMAGE).image):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


HOLDS = re.compile(r"ndarray|\b(Floats|Integers|Image)\b", re.IGNORECASE)  # in an annotation, which is text


def with_arrays():
    """All dataclasses of the package that say they hold arrays."""
    for module in pkgutil.walk_packages(sf.__path__, "surflux."):
        if module.name.endswith(("__main__", "_core", "mitsuba_renderer")):
            continue
        for item in vars(importlib.import_module(module.name)).values():
            here = inspect.isclass(item) and item.__module__ == module.name and dataclasses.is_dataclass(item)
            if here and any(HOLDS.search(str(field.type)) for field in dataclasses.fields(item)):
                yield item


@pytest.mark.parametrize("kind", list(with_arrays()), ids=lambda kind: kind.__name__)
def test_no_dataclass_compares_arrays_as_tuples_do(kind):
    """Which raises where arrays have more than one entry: such a class says itself when it is equal, or never is."""
    assert not kind.__dataclass_params__.eq


def test_the_public_ones_are_among_them():
    assert {sf.AreaShares, sf.Environment, sf.Facing, sf.Scan} <= set(with_arrays())


def test_tuples_of_arrays_are_equal_to_themselves_alone():
    kinds = [getattr(sf, name) for name in sf.__all__]
    kinds = [kind for kind in kinds if inspect.isclass(kind) and issubclass(kind, tuple)]
    assert sf.SolarHours in kinds
    for kind in kinds:
        one, same = (kind(*(np.ones((2, 3)) for _ in kind._fields)) for _ in range(2))
        assert one == one
        assert one != same
        assert len({one, same, one}) == 2
        assert next(iter(one)) is one[0]


def test_what_facing_finds_is_equal_to_itself_alone():
    one, same = (sf.facing([[0, 0, 0], [1, 0, 0]], [[0, 0, 1]] * 2) for _ in range(2))
    assert one == one
    assert one != same
    assert len({one, same, one}) == 2
