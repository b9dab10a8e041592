"""Transfers that are kept: the same bits from the file, and broken files that say what is wrong."""

import contextlib
import copy
import json
import pickle
import zlib
from pathlib import Path

import numpy as np
import pytest

import surflux as sf
from surflux._base.array_file import read_arrays, write_arrays
from surflux.scenes import shapes
from surflux.solving.transfer import FILE_KIND, FILE_VERSION

DATA = Path(__file__).parents[3] / "data"
LAMPS = [sf.PointLight([0.4, 0.5, 1.2], [1.0, 2.0, 0.5]), sf.AreaLight([0.2, 0.2, 1.4], [0, 0.3, 0], [0.3, 0, 0], 9.0)]
KIND = FILE_KIND, FILE_VERSION


def furnished():
    """A room of quads, with a ball of points in 300 colours that shines, a two-sided sheet, and paint on the floor."""
    room = sf.Surfels.from_mesh(shapes.box(1.5, 3, inward=True)[:2], 0.05, [0.7, 0.6, 0.5])
    unit = shapes.sphere(300)
    colors = np.random.default_rng(0).uniform(0.1, 0.8, (300, 3))
    ball = sf.Surfels(
        0.3 * unit.points + [0.9, 0.8, 0.4], unit.normals, reflectance=colors, emission=0.01, specular=0.1, exponent=50
    )
    square = np.array([[0.2, 0.2, 0.8], [0.6, 0.2, 0.8], [0.6, 0.6, 0.8], [0.2, 0.6, 0.8]])
    sheet = sf.Surfels.from_mesh((square, [[0, 1, 2], [0, 2, 3]]), 0.02, 0.6, two_sided=True)
    paint = sf.Surfels.from_mesh((square * [1, 1, 0], [[0, 1, 2, 3]]), 0.02, 0.2)
    return sf.Scene(
        [room, ball, sheet, paint],
        [*LAMPS, sf.Environment(np.random.default_rng(1).uniform(size=(4, 8, 3)), up=[0, 1, 0], azimuth=30)],
        camera=sf.Camera([0.1, 0.1, 1], [1, 1, 0.3]),
        name="furnished",
        solve_options={"zeta": 0.1, "max_memory": None, "rays": np.int64(64)},
    )


@pytest.fixture(scope="module")
def transfer():
    return sf.precompute_transfer(furnished(), levels=3, bounces=2)


@pytest.fixture
def saved(transfer, tmp_path):
    return transfer.save(tmp_path / "room.transfer")


def small(path):
    """A file of few bytes, of which tests change each."""
    floor = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1]], [[0, 1, 2, 3], [0, 4, 1]]))
    return sf.precompute_transfer(sf.Scene([floor]), levels=1, rays=16).save(path)


def assert_alike(one, other):
    np.testing.assert_array_equal(one.indirect(LAMPS), other.indirect(LAMPS))
    first, second = (t.relight(LAMPS[1], reflectance=0.3, bounces=None) for t in (one, other))
    for name in ("irradiance", "direct", "radiosity", "objects"):
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name))
    points, normals = first.surfels.points[::7], first.surfels.normals[::7]
    np.testing.assert_array_equal(first.irradiance_at(points, normals), second.irradiance_at(points, normals))


def test_what_is_loaded_gives_the_same_bits(transfer, saved):
    loaded = sf.load_transfer(str(saved))
    assert_alike(transfer, loaded)
    for name in ("lighting", "bounces", "timings", "nbytes", "rays", "links"):
        assert getattr(loaded, name) == getattr(transfer, name)
    for one, other in zip(transfer.receivers, loaded.receivers, strict=True):
        np.testing.assert_array_equal(one, other)
    assert repr(loaded) == repr(transfer)


def of_the_sky(lighting):
    """A corner of a room, in which surfels see a part of the sky."""
    corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [0, 1, 1]]
    walls = sf.Surfels.from_mesh((corners, [[0, 1, 2, 3], [0, 3, 5, 4]]), 0.1, [0.7, 0.6, 0.5], specular=0.1)
    lit = sf.Scene([walls])
    return sf.precompute_transfer(lit, lighting, levels=2, rays=64)


def relit(transfer):
    rng = np.random.default_rng(2)
    if transfer.lighting == "distant":
        return transfer.relight(rng.uniform(size=(25, 3)))
    return transfer.relight(rng.uniform(size=(len(transfer.patches), 3)))


@pytest.mark.parametrize("lighting", ["distant", "sky"])
def test_distant_light_and_the_sky_are_kept(tmp_path, lighting):
    transfer = of_the_sky(lighting)
    path = transfer.save(tmp_path / "corner.transfer")
    loaded = sf.load_transfer(path)
    assert type(loaded) is type(transfer)
    for other in (loaded, pickle.loads(pickle.dumps(transfer))):
        first, second = relit(transfer), relit(other)
        for name in ("irradiance", "direct", "radiosity"):
            np.testing.assert_array_equal(getattr(first, name), getattr(second, name))
    assert first.irradiance.max() > 0.0
    if lighting == "distant":
        towards = [relit(t).radiance_towards([0, 0, 1]) for t in (transfer, loaded)]
        np.testing.assert_array_equal(*towards)
    else:
        np.testing.assert_array_equal(transfer.coefficients([0, 5]), loaded.coefficients([0, 5]))


@pytest.mark.parametrize("lighting", ["distant", "sky"])
def test_distant_light_and_skies_that_are_wrong(tmp_path, lighting):
    """Arrays cut short, and rows that lead out of what is there."""
    path = of_the_sky(lighting).save(tmp_path / "corner.transfer")
    about, arrays = read_arrays(path, *KIND, "transfer")
    arrays = {name: np.array(values) for name, values in arrays.items()}
    own = [name for name in arrays if name.startswith(f"{lighting}/{'visibility' if lighting == 'distant' else 'sky'}")]
    assert len(own) == (2 if lighting == "distant" else 3)
    for name in own:
        write_arrays(path, *KIND, about, arrays | {name: arrays[name][:-1]})
        with pytest.raises(sf.FileError, match="its transfer is damaged"):
            sf.load_transfer(path)
    if lighting == "sky":
        begin = arrays["sky/sky_begin"].copy()
        for k, value in ((1, begin[-1] + 1), (0, 1), (2, 0)):
            wrong = begin.copy()
            wrong[k] = value
            write_arrays(path, *KIND, about, arrays | {"sky/sky_begin": wrong})
            with pytest.raises(sf.FileError, match="its transfer is damaged"):
                sf.load_transfer(path)


@pytest.mark.slow
def test_the_scene_is_whole(transfer, saved):
    """With materials, faces, lights and camera; and compiled anew it is the same."""
    scene, own = sf.load_transfer(saved).scene, transfer.scene
    assert (scene.name, scene.camera, scene.solve_options) == (own.name, own.camera, own.solve_options)
    assert list(scene.lights) == list(own.lights)
    for one, other in zip(own.objects, scene.objects, strict=True):
        for name in ("points", "normals", "radii", "areas", "reflectance", "emission", "specular", "exponent"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
        for name in ("triangles", "triangle_surfel", "faces"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    assert scene.objects[1].areas is None
    before, after = (s._coincidence() for s in (own, scene))
    np.testing.assert_array_equal(before.uncovered, after.uncovered)
    assert before.covers == after.covers
    assert before.covers
    anew = sf.Scene(scene.objects, scene.lights, solve_options=scene.solve_options)
    solved = [sf.solve(s, zeta=0.2, seed=3).irradiance for s in (own, scene, anew)]
    np.testing.assert_array_equal(solved[0], solved[1])
    np.testing.assert_array_equal(solved[0], solved[2])
    faces = [t.relight(LAMPS[0]).per_face("irradiance", 2) for t in (transfer, sf.load_transfer(saved))]
    np.testing.assert_array_equal(*faces)
    assert abs(faces[0][0] - faces[0][1]).max() > 0.01 * faces[0].max()


def test_files_that_do_not_tell_triangles_of_a_pair_apart(tmp_path):
    """As they were: the first face of a pair has all of its patches, and both have the mean over these."""
    sheet = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]]), 0.02)
    transfer = sf.precompute_transfer(sf.Scene([sheet]), levels=1)
    lamp = sf.PointLight([0.9, 0.1, 0.2], 1.0)
    path = transfer.save(tmp_path / "floor.transfer")
    about, arrays = read_arrays(path, *KIND, "transfer")
    arrays = {name: np.array(values) for name, values in arrays.items() if not name.startswith("scene/faces_")}
    merged = {"scene/faces_0": np.zeros(len(sheet), np.int64), "scene/merged_0": np.zeros(2, np.int64)}
    write_arrays(path, *KIND, about, arrays | merged)
    solution = sf.load_transfer(path).relight(lamp)
    mean = np.average(solution.irradiance, axis=0, weights=solution.surfels.areas)
    np.testing.assert_allclose(solution.per_face(), [mean, mean], rtol=1e-12)
    for wrong in (np.full(2, 2), np.zeros((2, 1), int), np.zeros(2)):
        write_arrays(path, *KIND, about, arrays | merged | {"scene/merged_0": wrong})
        with pytest.raises(sf.FileError, match="its transfer is damaged"):
            sf.load_transfer(path)


def test_lights_of_negative_pixels_are_kept(tmp_path):
    floor = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 1, 2]]))
    light = sf.Environment.from_harmonics([0.1, 0.0, 1.0, 0.0], height=4)
    assert light.image.min() < 0
    transfer = sf.precompute_transfer(sf.Scene([floor], [light, sf.Environment([1, 2, 3])]), levels=1)
    loaded = sf.load_transfer(transfer.save(tmp_path / "floor.transfer"))
    assert list(loaded.scene.lights) == [light, sf.Environment([1, 2, 3])]


def test_the_file_is_as_large_as_it_says(tmp_path):
    """A room in one colour: 76 bytes a triangle, some 90 a surfel, and the operator."""
    room = sf.Surfels.from_mesh(shapes.box(1.5, 12, inward=True)[:2])
    transfer = sf.precompute_transfer(sf.Scene([room]))
    size = transfer.save(tmp_path / "room.transfer").stat().st_size
    assert size == pytest.approx(transfer.nbytes + 76 * len(room.triangles) + 90 * len(room), rel=0.01)
    again = sf.load_transfer(tmp_path / "room.transfer").save(tmp_path / "again.transfer")
    assert again.read_bytes() == (tmp_path / "room.transfer").read_bytes()


def test_copies_and_pickles(transfer):
    for other in (pickle.loads(pickle.dumps(transfer)), copy.copy(transfer), copy.deepcopy(transfer)):
        assert_alike(transfer, other)
        assert repr(other) == repr(transfer)


def test_files_of_another_kind(transfer, saved, tmp_path):
    with pytest.raises(sf.FileError, match=r"nowhere\.transfer: no such file"):
        sf.load_transfer(tmp_path / "nowhere.transfer")
    with pytest.raises(sf.FileError, match="is a folder"):
        sf.load_transfer(tmp_path)
    with pytest.raises(sf.FileError, match="no folder"):
        transfer.save(tmp_path / "no" / "room.transfer")
    with pytest.raises(ValueError, match=r"path: wanted a name ending in \.transfer, got"):
        transfer.save(tmp_path / "room.npz")
    with pytest.raises(ValueError, match="path: wanted a path, got NoneType"):
        sf.load_transfer(None)
    for foreign in (b"", b"ply\nformat ascii 1.0\n", b"surflux.transfer"[:15], b"surflux.transfeR" + bytes(100)):
        saved.write_bytes(foreign)
        with pytest.raises(sf.FileError, match=r"room\.transfer: holds no transfer$"):
            sf.load_transfer(saved)


def test_files_of_another_version(saved):
    whole = bytearray(saved.read_bytes())
    whole[16] = FILE_VERSION + 1
    saved.write_bytes(whole)
    with pytest.raises(
        sf.FileError,
        match=f"holds a transfer of version {FILE_VERSION + 1}, and this surflux reads version {FILE_VERSION}",
    ):
        sf.load_transfer(saved)


def test_files_that_are_cut_off(saved):
    whole = saved.read_bytes()
    for length in (33, 100, 2000):
        saved.write_bytes(whole[:length])
        with pytest.raises(sf.FileError, match=f"is cut off: its header has {length - 32} of [0-9]+ bytes"):
            sf.load_transfer(saved)
    for length in (len(whole) // 2, len(whole) - 1):
        saved.write_bytes(whole[:length])
        with pytest.raises(sf.FileError, match=f"is cut off: it has {length} of {len(whole)} bytes"):
            sf.load_transfer(saved)
    saved.write_bytes(whole + b"more")
    with pytest.raises(sf.FileError, match="has 4 bytes behind its end"):
        sf.load_transfer(saved)


@pytest.mark.slow
def test_files_of_which_a_bit_was_changed(tmp_path):
    path = small(tmp_path / "floor.transfer")
    whole, rng = path.read_bytes(), np.random.default_rng(0)
    before = sf.load_transfer(path).indirect(LAMPS)
    told = set()
    for at in [*range(40), *rng.integers(40, len(whole), 400)]:
        changed = bytearray(whole)
        changed[at] ^= 1 << rng.integers(8)
        path.write_bytes(changed)
        try:
            np.testing.assert_array_equal(sf.load_transfer(path).indirect(LAMPS), before)  # between two arrays
        except sf.FileError as fault:
            told.add(str(fault).removeprefix(f"{path}: "))
    assert "its header was changed: the checksum is another one" in told
    assert "its array 'local/links' was changed: the checksum is another one" in told
    assert "its array 'scene/corners' was changed: the checksum is another one" in told


def changed(values, how):
    """An array that is wrong, or maybe only other than it was."""
    out = np.array(values)
    if how == "reversed":
        return out[::-1].copy()
    if how == "short":
        return out[:-1]
    if how == "other":  # numbers
        return np.zeros(out.shape, np.int8 if out.dtype.names is None else [("u", "<f8")])
    for name in out.dtype.names or (...,):
        field = out[name]
        floats = field.dtype.kind == "f"
        if how == "largest":
            field[...] = np.finfo(field.dtype).max if floats else np.iinfo(field.dtype).max
        elif how == "none":
            field[...] = np.nan if floats else 0
        else:
            field[...] = -field if floats else field - 1
    return out


@pytest.mark.slow
@pytest.mark.parametrize("how", ["largest", "none", "below", "reversed", "short", "other"])
def test_no_array_makes_it_crash(transfer, saved, how):
    """Someone who changes a file and mends its checksums is told what is wrong, or gets light of another scene."""
    about, arrays = read_arrays(saved, *KIND, "transfer")
    about, arrays = json.loads(json.dumps(about)), {name: np.array(values) for name, values in arrays.items()}
    refused = {}
    for name, values in arrays.items():
        if not values.size:
            continue
        write_arrays(saved, *KIND, about, arrays | {name: changed(values, how)})
        try:
            with contextlib.suppress(sf.FileError):
                sf.load_transfer(saved).indirect(LAMPS)
                continue
            sf.load_transfer(saved)
        except sf.FileError as fault:
            refused[name] = str(fault)
    assert all("its transfer is damaged (" in said for said in refused.values())
    loose = ("scene/light_", "scene/faces_")  # of any kind of numbers, and pictures of any size
    wrong = {
        "largest": {"local/links", "local/rows", "local/leaves", "scene/radii", "scene/triangle_surfel"},
        "none": {"local/rows", "local/nodes", "local/at_surfels", "local/positions", "scene/radii", "scene/object"},
        "below": {"local/level_begin", "local/receiver_of", "local/areas", "scene/object", "scene/radii"},
        "reversed": {"local/nodes", "local/level_begin", "scene/object"},
        "short": {name for name in arrays if not name.startswith(loose[0])}
        - {"scene/covers", "scene/sheets", "scene/alone", "local/level_begin"},  # whose last level is empty
        "other": {name for name in arrays if not name.startswith(loose)},
    }[how]
    assert {name for name in wrong if arrays[name].size} - set(refused) == set()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"lighting": "moon"}, r"its transfer is damaged \(lighting: wanted 'local' or .* got 'moon'\)"),
        ({"bounces": -1}, "bounces: wanted"),
        ({"scene": None}, "its transfer is damaged"),
        ({"timings": 3}, "its transfer is damaged"),
    ],
)
def test_values_that_are_wrong(saved, change, said):
    about, arrays = read_arrays(saved, *KIND, "transfer")
    arrays = {name: np.array(values) for name, values in arrays.items()}
    write_arrays(saved, *KIND, about | change, arrays)
    with pytest.raises(sf.FileError, match=said):
        sf.load_transfer(saved)
    if change.get("scene", 0) is None:
        del arrays["local/links"]
        write_arrays(saved, *KIND, about, arrays)
        with pytest.raises(sf.FileError, match="links: is missing"):
            sf.load_transfer(saved)


def with_header(path, header):
    data = header if isinstance(header, bytes) else json.dumps(header).encode()
    start = b"surflux.transfer" + b"".join(
        int(n).to_bytes(4, "little") for n in (FILE_VERSION, len(data), zlib.crc32(data), 0)
    )
    path.write_bytes(start + data)
    return path


def one_array(**changes):
    return {
        "about": {},
        "bytes": 64,
        "arrays": [{"name": "a", "type": "<f4", "shape": [1], "offset": 0, "crc": 0} | changes],
    }


@pytest.mark.parametrize(
    "header",
    [
        b"nonsense",
        b"[" * 100000,
        b"\xff\xfe",
        [],
        {"about": {}, "bytes": 40},
        {"about": {}, "bytes": "40", "arrays": []},
        one_array(shape=[1 << 60, 4]),
        one_array(shape=[1 << 70]),
        one_array(shape=[17]),
        one_array(shape=[-1]),
        one_array(type="O"),
        one_array(type=[["u", "V8"]]),
        one_array(type=[["u", "<u4", 7]]),
        one_array(name=3),
        one_array(offset=1),
    ],
    ids=str,
)
def test_headers_that_are_wrong(tmp_path, header):
    with pytest.raises(sf.FileError, match=r"x\.transfer: its header is damaged"):
        sf.load_transfer(with_header(tmp_path / "x.transfer", header))
