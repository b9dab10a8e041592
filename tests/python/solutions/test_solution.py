"""What solve gives: files that keep it, pictures of it, progress on the way."""

import dataclasses
import math
import os
import signal
import sys
import threading

import numpy as np
import pytest

import surflux as sf
from scenes import ball_inside, cube_inside, patch, solve_own

ARRAYS = ("radiosity", "irradiance", "direct")
CAMERA = sf.Camera([0.5, 0.06, 0.5], [0.5, 1.0, 0.45], fov=80)


@pytest.fixture(scope="module")
def solved():
    """A room with coloured walls and a ball under a lamp; it sees itself from inside."""
    room = cube_inside(8, [0.7, 0.6, 0.5])
    ball = ball_inside(162, 0.2, [0.5, 0.6, 0.4], rho=[0.3, 0.6, 0.3], sign=1)
    lamp = sf.AreaLight([0.35, 0.65, 0.98], [0.3, 0, 0], [0, -0.3, 0], [20.0, 18.0, 16.0])
    return solve_own(sf.Scene([room, ball], [lamp], camera=CAMERA))


def test_a_program_may_have_numpy_raise_of_all(solved, tmp_path):
    solved.save(tmp_path / "room.ply")
    with np.errstate(all="raise"):
        assert len(sf.load_solution(tmp_path / "room.ply").surfels) == len(solved.surfels)


def test_all_of_it_comes_back(solved, tmp_path):
    solved.save(tmp_path / "room.ply")
    back = sf.load_solution(tmp_path / "room.ply")
    for name in ARRAYS:  # as float, relative rounding 2^-24
        np.testing.assert_allclose(getattr(back, name), getattr(solved, name), rtol=6e-8, atol=1e-30)
    assert back.parents.dtype == solved.parents.dtype
    assert np.array_equal(back.parents, solved.parents)
    assert np.array_equal(back.objects, solved.objects)
    assert np.array_equal(back.cut, solved.cut)
    for name in ("points", "radii", "areas", "triangles", "triangle_surfel"):
        assert np.array_equal(getattr(back.surfels, name), getattr(solved.surfels, name)), name
    for name in ("normals", "reflectance", "emission"):
        np.testing.assert_allclose(getattr(back.surfels, name), getattr(solved.surfels, name), rtol=2e-7, atol=1e-7)
    assert (back.error, back.timings, back.history, back.camera) == (
        solved.error,
        solved.timings,
        solved.history,
        solved.camera,
    )
    # The lamp that it shows came back too; pictures differ by the rounding of floats.
    here, there = solved.render(size=(60, 45)), back.render(size=(60, 45))
    assert np.mean(np.abs(here - there) > 1e-4 * here.max()) < 0.01


@pytest.mark.parametrize("kind", ["points", "disks", "patches"])
def test_to_pyvista_carries_all_that_was_found(solved, kind):
    found = solved.to_pyvista(kind)
    data = found.point_data if kind == "points" else found.cell_data
    owner = np.arange(len(solved.surfels)) if kind == "points" else data["surfel"]
    for name in (*ARRAYS, "levels", "parents", "objects", "cut"):
        there = {"levels": "level", "parents": "parent", "objects": "object"}.get(name, name)
        np.testing.assert_array_equal(data[there], getattr(solved, name)[owner], err_msg=name)
    np.testing.assert_allclose(
        np.bincount(owner, data["area"])[np.unique(owner)], solved.surfels.areas[np.unique(owner)]
    )
    units = dict(line.split(": ") for line in found.field_data["units"])
    assert units == {"radius": "length", "area": "length^2", "emission": "W/m2"} | dict.fromkeys(ARRAYS, "W/m2")


def test_an_error_that_was_not_estimated_comes_back(solved, tmp_path):
    s = solved.surfels
    indices = {"parents": solved.parents, "objects": solved.objects}
    bare = sf.Solution(s, **indices, **{name: getattr(solved, name) for name in ARRAYS})
    bare.save(tmp_path / "bare.ply")
    back = sf.load_solution(tmp_path / "bare.ply")
    assert math.isnan(back.error)
    assert back.cut is None
    assert (back.camera, back.timings, back.history) == (None, {}, [])
    assert repr(back) == f"Solution({len(s)} surfels, error unknown, 0 s)"


def test_arrays_are_read_only(solved):
    for name in (*ARRAYS, "parents"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(solved, name)[0] = 0


PROPERTIES = [
    *("x", "y", "z", "nx", "ny", "nz", "radius", "area"),
    *(f"{name}_{c}" for name in ("reflectance", "emission", *ARRAYS) for c in "rgb"),
    "parent",
    "object",
]
ROWS = [[*(0, 0, 0, 0, 0, 1, 0.1, 0.03), *[0.5] * 3, *[0] * 3, *[0.5] * 9, k, 0] for k in range(3)]
ABOUT = '{"solution":1,"error":null,"timings":{},"history":[],"camera":null,"lamps":[]}'


def written(path, *, without=(), change=None, about=ABOUT):
    """An ascii PLY of a solution of three surfels, damaged as told."""
    kept = [k for k, name in enumerate(PROPERTIES) if name not in without]
    rows = [list(row) for row in ROWS]
    for name, value in (change or {}).items():
        rows[1][PROPERTIES.index(name)] = value
    lines = ["ply", "format ascii 1.0", f"comment surflux {about}", "element vertex 3"]
    lines += [f"property double {PROPERTIES[k]}" for k in kept]
    lines += ["end_header", *(" ".join(str(row[k]) for k in kept) for row in rows)]
    path.write_text("\n".join(lines) + "\n")
    return path


def test_the_undamaged_file_is_a_solution(tmp_path):
    back = sf.load_solution(written(tmp_path / "good.ply"))
    assert back.parents.tolist() == [0, 1, 2]
    assert back.radiosity.tolist() == [[0.5] * 3] * 3


def test_surfels_without_area_that_share_a_parent_have_a_level(tmp_path):
    assert sf.load_solution(written(tmp_path / "a.ply", change={"parent": 0, "area": 0})).levels.tolist() == [0, 0, 0]


def about(**changes):
    """ABOUT with other JSON texts for some keys; None leaves the key out."""
    there = {"solution": "1", "error": "null", "timings": "{}", "history": "[]", "camera": "null", "lamps": "[]"}
    there |= changes
    return "{" + ",".join(f'"{key}":{value}' for key, value in there.items() if value is not None) + "}"


DAMAGED = [
    ({"without": ["parent"]}, "no parent"),
    ({"without": ["object"]}, "no object"),
    ({"change": {"object": -1}}, "vertex 1: object is -1; wanted the index of an object"),
    ({"without": ["nx", "ny", "nz"]}, "no normals"),
    ({"without": ["nx"]}, "but no nx"),
    ({"without": ["radius"]}, "no radii"),
    ({"without": ["area"]}, "no areas"),
    ({"without": ["reflectance_r", "reflectance_g", "reflectance_b"]}, "no reflectance"),
    ({"without": ["emission_r", "emission_g", "emission_b"]}, "no emission"),
    ({"without": ["radiosity_r", "radiosity_g", "radiosity_b"]}, "holds points but no solution"),
    ({"without": ["irradiance_r", "irradiance_g", "irradiance_b"]}, "holds points but no solution"),
    ({"without": ["direct_r", "direct_g", "direct_b"]}, "holds points but no solution"),
    ({"without": ["direct_g"]}, "no direct_g"),
    ({"without": ["x", "y", "z"]}, "no points"),
    ({"change": {"parent": -1}}, "vertex 1: parent is -1"),
    ({"change": {"parent": 0.5}}, "vertex 1: parent is 0.5"),
    ({"change": {"parent": "nan"}}, "vertex 1: parent is nan"),
    ({"change": {"parent": 2**32}}, "vertex 1: parent is"),
    ({"change": {"parent": 3}}, "vertex 1: parent is 3; wanted the index of a surfel"),
    ({"change": {"object": 2**31 - 1}}, "vertex 1: object is 2.14748e.09; wanted the index of an object"),
    ({"change": {"nz": 0}}, "normals: wanted finite numbers"),
    ({"change": {"nz": "nan"}}, "normals: wanted finite numbers"),
    ({"change": {"x": "inf"}}, "points?|x"),
    ({"change": {"radius": 0}}, "vertex 1: radius is 0"),
    ({"change": {"area": -1}}, "vertex 1: area is -1"),
    ({"change": {"reflectance_g": 1}}, "vertex 1: reflectance is 1"),
    ({"change": {"emission_r": -1}}, "vertex 1: emission is -1"),
    ({"change": {"radiosity_b": "nan"}}, "vertex 1: radiosity is nan"),
    ({"change": {"irradiance_b": "inf"}}, "vertex 1: irradiance is inf"),
    ({"about": ""}, "holds points but no solution"),
    ({"about": "{}"}, "holds points but no solution"),
    ({"about": "[1]"}, "holds points but no solution"),
    ({"about": about(solution="2")}, "holds points but no solution"),
    ({"about": '{"solution":1'}, "no valid JSON"),
    ({"about": '{"solution":1,"a":' * 100_000}, "no valid JSON"),
    *(({"about": about(**{key: None})}, f"damaged .*{key}") for key in ("error", "timings", "history", "camera")),
    ({"about": about(lamps=None)}, "damaged .*lamps"),
    ({"about": about(error='"much"')}, "damaged"),
    ({"about": about(error="1" + "0" * 400)}, "damaged"),
    ({"about": about(timings="5")}, "damaged"),
    ({"about": about(timings='{"solve":"long"}')}, "damaged"),
    ({"about": about(history="[1]")}, "damaged"),
    ({"about": about(history="7")}, "damaged"),
    ({"about": about(camera="[1,2]")}, "damaged"),
    ({"about": about(camera='{"eye":[0,0,0]}')}, "damaged"),
    ({"about": about(camera='{"eye":[0,0,0],"target":[0,0,0]}')}, "damaged"),
    ({"about": about(camera='{"eye":[0,0,0],"target":[0,1,0],"lens":1}')}, "damaged"),
    ({"about": about(lamps="[[1]]")}, "damaged"),
    ({"about": about(lamps="[[[0,0,0],[1,0,0],[1,0,0],[1,1,1]]]")}, "damaged"),
    ({"about": about(lamps="{}3")}, "no valid JSON"),
]


@pytest.mark.parametrize(("damage", "reason"), DAMAGED, ids=lambda value: str(value)[:50])
def test_damaged_files(damage, reason, tmp_path):
    path = written(tmp_path / "bad.ply", **damage)
    with pytest.raises(sf.FileError, match=rf"^{path}.*({reason})"):
        sf.load_solution(path)


def test_other_files(tmp_path):
    with pytest.raises(sf.FileError, match=r"missing\.ply"):
        sf.load_solution(tmp_path / "missing.ply")
    sf.Surfels([[0, 0, 0]], [[0, 0, 1]], radii=0.1).save(tmp_path / "points.ply")
    with pytest.raises(sf.FileError, match=r"holds points but no solution; `surflux solve .*points.ply` makes one"):
        sf.load_solution(tmp_path / "points.ply")
    with pytest.raises(sf.FileError, match="folder"):
        sf.load_solution(written(tmp_path / "a.ply")).save(tmp_path / "no" / "folder" / "a.ply")


def test_a_picture_and_its_layers(solved):
    layers = solved.render(size=(120, 90), layers=True)
    assert {name: a.shape[2:] for name, a in layers.items()} == {
        **dict.fromkeys(("radiance", "direct", "indirect", "albedo", "normal"), (3,)),
        **dict.fromkeys(("alpha", "depth", "index", "level"), ()),
    }
    # Inside of a closed room every pixel shows something.
    assert np.isfinite(layers["depth"]).all()
    seen = layers["index"] >= 0
    assert np.array_equal(layers["radiance"], solved.render(size=(120, 90)))
    # B = E + rho D + rho (H - D), blended with the same weights; the sum of two rounds in float32.
    np.testing.assert_allclose(
        layers["direct"] + layers["indirect"], layers["radiance"], rtol=1e-5, atol=1e-6 * layers["radiance"].max()
    )
    # What is seen of a surfel is B / pi: the pixel of a patch lies between the least and the greatest of all.
    luminance = solved.radiosity / np.pi
    assert layers["radiance"][seen].min() >= luminance.min() * (1 - 1e-5)
    # Nothing of the lamp is in the indirect layer, and it is what the picture's brightest pixels show.
    assert layers["indirect"].max() <= (solved.surfels.reflectance * (solved.irradiance - solved.direct)).max() / np.pi
    # The ball is in view, at its distance: its front is .54 - .2 away along the view, from y = .06 to .4.
    ball = layers["index"] >= 384
    assert 0.02 < ball.mean() < 0.5
    assert layers["depth"][ball].min() == pytest.approx(0.34, abs=0.03)


def test_the_lamp_is_seen_as_it_shines(solved):
    # Looking straight up at it: exitance / pi.
    up = sf.Camera([0.5, 0.5, 0.7], [0.5, 0.5, 1.0], up=(0, 1, 0), fov=20)
    picture = solved.render(up, size=(20, 20))
    np.testing.assert_allclose(picture[5:15, 5:15], np.tile(np.array([20, 18, 16]) / np.pi, (10, 10, 1)), rtol=1e-5)


def test_without_a_camera_all_is_in_view():
    one = sf.solve(sf.Scene([patch([0, 0, 0], [1, 0, 0], [0, 0, 1])], [sf.DirectionalLight([0, 1, 0], np.pi)]))
    picture = one.render(size=(90, 60), background=[0.0, 0.0, 5.0])
    # The patch faces the default view, along +y: rho E / pi = .5 on it, the background around it.
    blue = picture[..., 2] == 5.0
    assert blue[0].all()
    assert blue[-1].all()
    assert 0.1 < 1 - blue.mean() < 0.9
    np.testing.assert_allclose(picture[30, 45], 0.5, rtol=1e-5)


@pytest.mark.parametrize(
    ("argument", "values"),
    [
        ("camera", [5, "front", [0, 0, 1]]),
        ("size", [None, 800, (800,), (800, 0), (800.0, 600), (1, 2, 3), "ab", (800, 20_000)]),
        ("background", [None, -1, [1, 2], float("nan"), "black"]),
        ("samples", [0, 9, 1.5, None, True]),
        ("layers", [1, None, "radiance", ["radiance", "colour"], [3]]),
        ("culling", [1, None, "back"]),
        ("progress", [1, "bar"]),
        ("threads", [0, 1.5]),
    ],
)
def test_render_refuses(solved, argument, values):
    for value in values:
        with pytest.raises(ValueError, match=rf"^{argument}: wanted"):
            solved.render(**{argument: value})


@pytest.mark.slow
def test_plot_shows_what_was_solved(solved, tmp_path):
    """Off screen: the floor of the room from above, through the ceiling, whose back is not drawn."""
    from PIL import Image

    above = sf.Camera([0.5, 0.5, 3.0], [0.5, 0.5, 0.0], up=(0, 1, 0), fov=30)
    shown = {}
    for color in ("radiosity", "irradiance", "direct", "area", "radius", "level"):
        path = tmp_path / f"{color}.png"
        assert str(solved.plot(color, screenshot=path, camera=above, size=(200, 200))) == str(path)
        shown[color] = np.asarray(Image.open(path).convert("RGB")).astype(float)
    # Under the ball it is dark, beside it light; direct light leaves its shadow black.
    floor = solved.surfels.points[:, 2] == 0.0
    assert solved.direct[floor].min() < 0.1 * solved.direct[floor].max()
    assert not np.array_equal(shown["direct"], shown["irradiance"])
    # The ball, whose top is in the middle, is green: twice the reflectance is .73 of white by the sRGB curve.
    red, green, blue = shown["radiosity"][85, 100]
    assert green - max(red, blue) > 20
    assert np.all(shown["radiosity"][2, 2] == 255)
    with pytest.raises(ValueError, match=r"^color: wanted one of .*direct.*irradiance.*radiosity"):
        solved.plot("taste", screenshot=tmp_path / "taste.png")


def scene_of_some_time():
    return sf.Scene([cube_inside(12), ball_inside(400, 0.2, [0.5, 0.5, 0.5], sign=1)], [sf.PointLight([0.1] * 3, 1)])


@pytest.mark.parametrize("work", [sf.solve, sf.form_factors], ids=lambda f: f.__name__)
@pytest.mark.slow
def test_progress_is_told(work):
    told = []
    work(scene_of_some_time(), progress=lambda done, total: told.append((done, total)) or True)
    assert len(told) > 10
    assert all(isinstance(done, int) and isinstance(total, int) and 0 <= done <= total for done, total in told)
    # Several stages, each from few to all.
    assert sum(done == total for done, total in told) >= 2


@pytest.mark.parametrize("work", [sf.solve, sf.form_factors], ids=lambda f: f.__name__)
@pytest.mark.parametrize("after", [0, 5, 15])
def test_false_cancels(work, after):
    count = 0

    def stop(done, total):
        nonlocal count
        count += 1
        return count <= after

    with pytest.raises(sf.Cancelled):
        work(scene_of_some_time(), progress=stop)
    assert count == after + 1  # and it is not asked again


@pytest.mark.parametrize("work", [sf.solve, sf.form_factors], ids=lambda f: f.__name__)
@pytest.mark.slow
def test_what_a_callback_raises_comes_out(work):
    class Broken(Exception):
        pass

    def raises(done, total):
        raise Broken("on purpose")

    scene = scene_of_some_time()
    with pytest.raises(Broken, match="on purpose"):
        work(scene, progress=raises)
    # And the next run is none the worse.
    work(scene)


def test_ctrl_c_without_any_callback():
    scene = sf.Scene([cube_inside(30)])  # 5400 surfels: seconds
    timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        sf.solve(scene, transport="pairs")
    timer.join()


@pytest.mark.parametrize("work", [sf.solve, sf.form_factors], ids=lambda f: f.__name__)
@pytest.mark.slow
def test_bars_go_to_stderr(work, capfd, monkeypatch):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    work(scene_of_some_time(), progress=True)
    out, err = capfd.readouterr()
    assert out == ""
    for stage in ("areas", "exchange", "closure"):
        assert stage in err
    work(scene_of_some_time())
    assert capfd.readouterr() == ("", "")


def test_a_solution_keeps_its_lamps_apart_from_the_scene(solved):
    assert [dataclasses.astuple(lamp)[0] for lamp in solved._lamps] == [(0.35, 0.65, 0.98)]
