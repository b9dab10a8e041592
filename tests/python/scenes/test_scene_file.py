import inspect
import os
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

import surflux as sf
from surflux.scenes import scene_file, shapes
from surflux.scenes.options import ASKED, OPTIONS
from surflux.scenes.patterns import PATTERNS
from surflux.scenes.scene_object import SHAPES

DATA = Path(__file__).parents[3] / "data"
FLOOR = '[[object]]\nshape = "rectangle"\npatches = 4\n'


@pytest.fixture
def load(tmp_path):
    def write_and_load(text):
        path = tmp_path / "scene.toml"
        path.write_text(text)
        return sf.load_scene(path)

    return write_and_load


def test_the_smallest_scene(load):
    scene = load(FLOOR)
    assert repr(scene) == "Scene('scene', 1 object, 16 surfels, 0 lights)"
    assert (scene.surfels.reflectance == 0.5).all()
    assert scene.camera is None
    assert scene.solve_options == {}


def test_every_light(load):
    scene = load(
        FLOOR
        + """
[[light]]
type = "point"
position = [0, 0, 1]
intensity = 2
[[light]]
type = "spot"
position = [0, 0, 1]
direction = [0, 0, -2]
intensity = [1, 2, 3]
cone = 30
[[light]]
type = "area"
corner = [0, 0, 1]
edge_u = [1, 0, 0]
edge_v = [0, -1, 0]
exitance = 5.5
[[light]]
type = "directional"
direction = [0, 0, -1]
irradiance = 1.0
[[light]]
type = "environment"
radiance = [0.1, 0.2, 0.3]
up = [0, 1, 0]
azimuth = 30
"""
    )
    point, spot, area, sun, sky = scene.lights
    assert point == sf.PointLight([0, 0, 1], 2)
    assert spot == sf.SpotLight([0, 0, 1], [0, 0, -1], [1, 2, 3], cone=30)
    assert area == sf.AreaLight([0, 0, 1], [1, 0, 0], [0, -1, 0], 5.5)
    assert sun == sf.DirectionalLight([0, 0, -1], 1)
    assert sky.radiance == (0.1, 0.2, 0.3)
    assert sky.up == (0, 1, 0)
    assert sky.azimuth == 30


def test_walls_colour_the_sides_of_a_room(load):
    s = load(
        '[[object]]\nshape = "room"\nsize = 2\npatches = 3\nreflectance = 0.25\n'
        "walls = { left = [0.5, 0.125, 0.125], ceiling = 0.75 }"
    ).surfels
    assert (s.reflectance[s.points[:, 0] == 0] == [0.5, 0.125, 0.125]).all()
    assert (s.reflectance[s.points[:, 2] == 2] == 0.75).all()
    assert (s.reflectance == 0.25).all(axis=1).sum() == 4 * 9
    assert ((s.points - 1) * s.normals).sum(axis=1) == pytest.approx(-1)


def test_objects_are_scaled_turned_and_moved(load):
    s = load(FLOOR + "scale = 2\nrotate = [0, 90, 0]\ntranslate = [5, 0, 0]").surfels
    assert (s.normals == [1, 0, 0]).all()  # z turns to x
    assert (s.points[:, 0] == 5).all()
    assert s.areas.sum() == pytest.approx(4)
    assert s.points[:, 2].max() == pytest.approx(-0.25)


def test_patch_area_counts_after_the_scale(load):
    assert len(load('[[object]]\nshape = "rectangle"\nscale = 2\npatch_area = 0.01').surfels) == 400


def test_a_mesh_sphere_and_a_sphere_of_points(load):
    scene = load('[[object]]\nshape = "sphere"\nkind = "mesh"\npoints = 162\nradius = 2\n[[object]]\nshape = "sphere"')
    mesh, points = scene.objects
    assert len(mesh) == 320
    assert 0.95 * 16 * np.pi < mesh.areas.sum() < 16 * np.pi
    assert len(points) == 642
    assert points.areas is None


def test_meshes_as_points_thinning_and_emission(load):
    s = load('[[object]]\nshape = "box"\nkind = "surfels"\npoints = 300\nthin = 100\nemission = [1, 2, 3]').surfels
    assert len(s) == 100
    assert len(s.triangles) == 0
    assert (s.emission == [1, 2, 3]).all()
    assert np.abs(np.abs(s.points - 0.5).max(axis=1) - 0.5).max() < 1e-12


def test_two_sided_objects(load):
    s = load(FLOOR + "two_sided = true").surfels
    assert len(s) == 32
    assert s.normals[:, 2].sum() == 0


def test_patterns_are_painted_where_the_surfels_stand(load):
    text = '[object.reflectance]\npattern = "checker"\ncolors = [[0.25, 0.25, 0.25], [0.75, 0.75, 0.75]]\nsize = 0.25\n'
    s = load(FLOOR + "translate = [0.25, 0, 0]\n" + text).surfels
    dark = np.floor(s.points / 0.25 + 1e-6).sum(axis=1) % 2 == 0
    assert (s.reflectance[dark] == 0.25).all()
    assert (s.reflectance[~dark] == 0.75).all()
    assert dark.sum() == 8


def test_camera_and_solve(load):
    scene = load(FLOOR + "[camera]\neye = [0, -4, 1]\ntarget = [0, 0, 1]\nfov = 30\n[solve]\nzeta = 0.1\nseed = 3\n")
    assert tuple(scene.camera.eye) == (0, -4, 1)
    assert scene.camera.fov == 30
    assert scene.solve_options == {"zeta": 0.1, "seed": 3}


def test_files_come_from_the_environment_and_beside_the_scene(tmp_path, monkeypatch, load):
    seen = []
    monkeypatch.setattr(
        "surflux.scenes.scene_object.read", lambda path, **_: seen.append(Path(path)) or shapes.sphere(42), raising=True
    )
    (tmp_path / "a").mkdir()
    for name in ("cloud.ply", "a/cloud.ply"):
        (tmp_path / name).touch()
    monkeypatch.setenv("FOLDER_OF_CLOUDS", str(tmp_path / "a"))
    s = load('[[object]]\nfile = "cloud.ply"\n[[object]]\nfile = "${FOLDER_OF_CLOUDS}/cloud.ply"\nscale = 3')
    assert set(seen) == {tmp_path / "cloud.ply", tmp_path / "a/cloud.ply"}  # read at the same time
    assert s.objects[1].radii == pytest.approx(3 * s.objects[0].radii)


WRONG = [
    ("[[object]\n", r"line 1, column \d+\): "),
    ("x = \n", r"line 1, column 5\): "),
    ("x = .6\n", r"line 1, column 5\): Invalid value: in TOML a number begins with a digit, write 0\.6$"),
    ("x = [1.0, -.25]\n", r"line 1, column 11\): Invalid value: .* write -0\.25$"),
    ('a = "', r"\(.*\): "),
    ("", r"\(object\): wanted at least one \[\[object\]\], got none"),
    ("[[objects]]\nshape = 'box'", r"\(objects\): is not a key here; there is name, units, object, light"),
    ("object = 3", r"\(object\): wanted tables, each headed \[\[object\]\]"),
    ("[object]\nshape = 'box'", r"\(object\): wanted tables"),
    (FLOOR + "[lights]", r"\(lights\): is not a key here; there is name, units, object, light, camera, solve"),
    (FLOOR + "[[object]]\n", r"\(object 2, file\): wanted either file or shape"),
    (FLOOR + 'file = "a.ply"', r"\(object 1, file\): no such file: .*a\.ply"),
    ('[[object]]\nfile = "${NOT_SET_ANYWHERE}/a.ply"', r"\(object 1, file\): .* variable NOT_SET_ANYWHERE is not set"),
    ("[[object]]\nfile = 3", r"\(object 1, file\): wanted text, got 3"),
    ('[[object]]\nshape = "cone"', r'\(object 1, shape\): wanted one of "box", "room", .*, got \'cone\''),
    (FLOOR + 'kind = "voxels"', r'\(object 1, kind\): wanted one of "surfels", "mesh", got \'voxels\''),
    ('[[object]]\nshape = "blob"\nkind = "mesh"', r'\(object 1, kind\): a blob comes as "surfels" alone'),
    ('[[object]]\nshape = "box"\nkind = "surfels"', r"\(object 1, points\): wanted a whole number"),
    ('[[object]]\nshape = "sphere"\nkind = "mesh"\npoints = 100', r"\(object 1, points\): wanted 10 \* 4\^k \+ 2"),
    (FLOOR + "colour = 3", r"\(object 1, colour\): is not a key here; there is .*reflectance"),
    (FLOOR + "inward = true", r"\(object 1, inward\): is not a key here"),
    (FLOOR + "walls = {left = 0.5}", r"\(object 1, walls\): is not a key here"),
    ('[[object]]\nshape = "room"\nwalls = {top = 0.5}', r"\(object 1, walls, top\): is not a key here; there is left"),
    ('[[object]]\nshape = "room"\nwalls = {left = 1.5}', r"\(object 1, walls, left\): wanted values in \[0, 1\)"),
    ('[[object]]\nshape = "room"\nwalls = 3', r"\(object 1, walls\): wanted a table, got 3"),
    (
        '[[object]]\nshape = "room"\nkind = "surfels"\npoints = 50\nwalls = {left = 0.5}',
        r'\(object 1, walls, left\): wanted kind = "mesh"',
    ),
    (
        '[[object]]\nshape = "room"\npatches = 9\nthin = 50\nwalls = {left = 0.5}',
        r'walls, left\): wanted kind = "mesh", not',
    ),
    ('[[object]]\nshape = "room"\nsize = -1', r"\(object 1, size\): wanted values above 0, got -1"),
    ('[[object]]\nshape = "room"\nsize = "big"', r"\(object 1, size\): wanted real numbers, got text"),
    (FLOOR + "patch_area = 0", r"\(object 1, patch_area\): wanted values above 0"),
    (FLOOR + "scale = [1, 2, 3]", r"\(object 1, scale\): wanted one number, got shape \(3,\)"),
    (FLOOR + "rotate = 90", r"\(object 1, rotate\): wanted shape \(3,\)"),
    (FLOOR + "translate = [1, nan, 1]", r"\(object 1, translate\): wanted finite numbers, got nan at index 1"),
    (FLOOR + "reflectance = 1.0", r"\(object 1, reflectance\): wanted values in \[0, 1\), got 1"),
    (FLOOR + "emission = -1", r"\(object 1, emission\): wanted values at least 0, got -1"),
    (FLOOR + "two_sided = 1", r'\(object 1, two_sided\): wanted True, False or "sheets", got 1'),
    (FLOOR + "seed = -1", r"\(object 1, seed\): wanted a whole number from 0"),
    (FLOOR + "rooms = 1", r"\(object 1, rooms\): wanted True or False, got 1"),
    (FLOOR + "rooms = true", r"\(object 1, rooms\): says how orient = true turns surfels, which is not there"),
    (FLOOR + "orient = 1", r"\(object 1, orient\): wanted True or False, got 1"),
    (FLOOR + "up = [0, 1, 0]", r"\(object 1, up\): is for a file; a shape is turned by its key rotate"),
    (FLOOR + "up = [0, 0, 0]", r"\(object 1, up\): wanted vectors of non-zero length"),
    (FLOOR + "viewpoint = [0, 0, 1]", r"\(object 1, viewpoint\): is for a file of points, whose estimated normals"),
    (FLOOR + "clean = false", r"\(object 1, clean\): is for a file of points, of which isolated and repeated ones"),
    (FLOOR + "thin = 0", r"\(object 1, thin\): wanted a whole number from 2"),
    (FLOOR + "thin = 17", r"\(object 1, thin\): wanted at most 16, for there are only 16 surfels; got 17"),
    (FLOOR + 'reflectance = {pattern = "plaid"}', r'\(object 1, reflectance, pattern\): wanted one of "marble"'),
    (FLOOR + 'reflectance = {pattern = "spots"}', r"\(object 1, reflectance, colors\): is missing"),
    (
        FLOOR + 'reflectance = {pattern = "spots", colors = [[0, 0, 0], [1, 1, 1]]}',
        r"\(object 1, reflectance, colors\): wanted values in \[0, 1\), got 1",
    ),
    (
        FLOOR + 'reflectance = {pattern = "spots", colors = [[0, 0, 0], [0, 0, 0]], scale = 3}',
        r"\(object 1, reflectance, scale\): is not a key here; there is pattern, colors, size, seed",
    ),
    (FLOOR + "[[light]]", r'\(light 1, type\): wanted one of "point", .*, got nothing'),
    (FLOOR + '[[light]]\ntype = "laser"', r"\(light 1, type\): wanted one of .*, got 'laser'"),
    (FLOOR + '[[light]]\ntype = "point"\nposition = [0, 0, 0]', r"\(light 1, intensity\): is missing"),
    (FLOOR + '[[light]]\ntype = "point"\nposition = [0, 0]\nintensity = 1', r"\(light 1, position\): wanted shape"),
    (
        FLOOR + '[[light]]\ntype = "point"\npower = 3\nposition = [0, 0, 0]\nintensity = 1',
        r"\(light 1, power\): is not",
    ),
    (
        FLOOR + '[[light]]\ntype = "point"\npos = [0, 0, 0]\nintensity = 1',
        r"\(light 1, pos\): is not a key here; there is type, position, intensity",
    ),
    (FLOOR + '[[light]]\ntype = "environment"\ncolor = 1', r"\(light 1, color\): is not a key here; there is"),
    (FLOOR + "[camera]\neye = [0, 0, 0]\nlookat = [0, 1, 0]", r"\(camera, lookat\): is not a key here"),
    (FLOOR + '[[light]]\ntype = "environment"', r"\(light 1, radiance\): wanted either radiance or image"),
    (FLOOR + '[[light]]\ntype = "environment"\nimage = "no.exr"', r"\(light 1, image\): no such file: .*no\.exr"),
    (FLOOR + "[camera]\neye = [0, 0, 0]", r"\(camera, target\): is missing"),
    (FLOOR + "[camera]\neye = [0, 0, 0]\ntarget = [0, 1, 0]\nzoom = 3", r"\(camera, zoom\): is not a key here"),
    (FLOOR + "[camera]\neye = [0, 0]\ntarget = [0, 1, 0]", r"\(camera, eye\): "),
    ("camera = 3\n" + FLOOR, r"\(camera\): wanted a table, got 3"),
    (FLOOR + "[solve]\ntransport = 'light'", r"\(solve, transport\): wanted one of "),
    (FLOOR + "[solve]\nzeta = '1'", r"\(solve, zeta\): wanted real numbers, got text"),
    (FLOOR + "[solve]\nzeta = true", r"\(solve, zeta\): wanted real numbers, got booleans"),
    (FLOOR + "[solve]\ninsert = 1", r"\(solve, insert\): wanted True or False, got 1"),
    (FLOOR + "[solve]\nseed = 1.5", r"\(solve, seed\): wanted a whole number, got 1.5"),
    (FLOOR + "[solve]\nzeta = 0", r"\(solve, zeta\): wanted values above 0, got 0"),
    (FLOOR + "[solve]\ntolerance = 1", r"\(solve, tolerance\): wanted values in \(0, 1\), got 1"),
    (FLOOR + "[solve]\nmax_surfels = 0", r"\(solve, max_surfels\): wanted a whole number from 1"),
    (FLOOR + "[solve]\nrays = 8", r"\(solve, rays\): wanted a whole number from 16"),
    (FLOOR + "[solve]\nprobes = 0", r"\(solve, probes\): wanted a whole number from 1"),
    (FLOOR + "[solve]\nprobes = 65", r"\(solve, shadow_rays\): wanted at least the 65 probes, got 64"),
    (FLOOR + "[solve]\nepsilon = 1.0", r"\(solve, epsilon\): wanted values in \(0, 1\), got 1"),
    (FLOOR + "[solve]\nmax_memory = 0", r"\(solve, max_memory\): wanted values above 0, got 0"),
    (FLOOR + "[solve]\nseed = -1", r"\(solve, seed\): wanted a whole number from 0"),
    (FLOOR + "[solve]\nthreads = 2", r"\(solve, threads\): is not a key here; there is error, seconds"),
    (FLOOR + "[solve]\nspeed = 3", r"\(solve, speed\): is not a key here; there is error, seconds"),
    ("name = 3\n" + FLOOR, r"\(name\): wanted text, got 3"),
]


@pytest.mark.parametrize(("text", "message"), WRONG)
def test_errors_name_file_table_and_key(load, text, message):
    with pytest.raises(sf.FileError, match=rf"scene\.toml .*{message}"):
        load(text)


def test_a_scene_that_is_not_there(tmp_path):
    with pytest.raises(sf.FileError, match=r"none\.toml: no such file$"):
        sf.load_scene(tmp_path / "none.toml")
    with pytest.raises(sf.FileError, match=r": is a folder; wanted a scene file \(\.toml\)$"):
        sf.load_scene(tmp_path)


def test_a_scene_that_is_no_text(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_bytes(b"name = '\xff'")
    with pytest.raises(sf.FileError, match=r"scene\.toml \(byte 8\): is not UTF-8 text"):
        sf.load_scene(path)


def test_three_spheres_is_the_experiment_of_the_paper():
    # D04 8.1: a room of 3.5 m, 400 patches per wall, spheres of 0.8, 0.4 and 0.2 m of 642 points, four area lights.
    scene = sf.load_scene(DATA / "three_spheres.toml")
    room, *spheres = scene.objects
    assert len(room) == 2400
    assert room.areas == pytest.approx(np.full(2400, 3.5**2 / 400))
    assert [len(s) for s in spheres] == [642] * 3
    for sphere, radius in zip(spheres, (0.8, 0.4, 0.2), strict=True):
        center = sphere.points.mean(axis=0)
        assert np.linalg.norm(sphere.points - center, axis=1) == pytest.approx(np.full(642, radius))
        assert center[2] == pytest.approx(radius)  # at rest on the floor
        assert (center[:2] - radius > 0).all()
        assert (center[:2] + radius < 3.5).all()
    assert len(scene.lights) == 4
    for light in scene.lights:
        assert np.cross(light.edge_u, light.edge_v)[2] < 0
        assert 3.4 < light.corner[2] < 3.5


def test_statues_need_no_outside_data():
    text = (DATA / "statues.toml").read_text()
    assert all("file" not in entry for entry in tomllib.loads(text)["object"])
    scene = sf.load_scene(DATA / "statues.toml")
    room, *plinths, blob, knot = scene.objects
    assert {type(light) for light in scene.lights} == {sf.SpotLight, sf.AreaLight}
    assert (len(blob), len(knot)) == (3000, 3500)
    low, high = room.points.min(axis=0), room.points.max(axis=0)
    for statue, plinth in zip((blob, knot), plinths, strict=True):
        top = plinth.points[:, 2].max()
        assert -0.02 < statue.points[:, 2].min() - top < 0.05  # it stands, neither floating nor sunk
        assert (statue.points.min(axis=0) > low).all()
        assert (statue.points.max(axis=0) < high).all()


@pytest.mark.slow
@pytest.mark.scans
def test_two_bunnies_stand_in_the_room():
    assert "SURFLUX_DATA" in os.environ
    assert [len(s) for s in sf.load_scene(DATA / "two_bunnies.toml").objects] == [2400, 34834, 34834]
    scene = sf.load_scene(DATA / "two_bunnies.toml", surfels=10_400)
    room, marble, leopard = scene.objects
    assert len(room) == 2400
    assert len(scene.lights) == 4
    for bunny in (marble, leopard):
        assert len(bunny) == 4000
        low, high = bunny.points.min(axis=0), bunny.points.max(axis=0)
        assert 0 < low[2] < 0.02
        assert 1.2 < high[2] < 1.4
        assert (low > 0).all()
        assert (high < 3.5).all()
    gap = np.linalg.norm(marble.points[:, None, :] - leopard.points[None, ::10, :], axis=2).min()
    assert gap > 0.1
    green = room.reflectance[(room.points[:, 0] == 0) | (room.points[:, 0] == 3.5)]
    assert len(green) == 800
    assert (green[:, 1] > 2 * green[:, 0]).all()
    assert np.ptp(leopard.reflectance, axis=0).min() > 0.1
    assert leopard.reflectance.mean(axis=0)[2] < 0.5 * leopard.reflectance.mean(axis=0)[0]  # yellowish brown


def test_solve_takes_every_option_of_solve(load):
    text = (
        "transport = 'pairs'\nzeta = 0.1\ninsert = false\ntolerance = 0.001\nmax_surfels = 500\nrays = 32\nprobes = 4\n"
    )
    text += "shadow_rays = 8\nepsilon = 0.7\nmax_memory = 1000000\nseed = 2\n"
    options = load(FLOOR + "[solve]\n" + text).solve_options
    assert options == tomllib.loads(text)
    names = {*inspect.signature(sf.solve).parameters} - {"scene", "threads", "progress", "cluster", "checkpoint"}
    assert {*options} | {*ASKED} == names == {*OPTIONS}
    assert len(sf.solve(load(FLOOR + "[solve]\n" + text), **options).surfels) == 16
    asking = load(FLOOR + "[solve]\nerror = 0.05\nseconds = 60\n")
    assert asking.solve_options == {"error": 0.05, "seconds": 60}
    assert sf.solve(asking).history[-1]["wanted_error"] == 0.05


def test_the_docstring_is_enough_to_write_a_scene():
    """Every shape, light, pattern and wall, and every key of each with its default, as the code has them."""
    text = " ".join(sf.load_scene.__doc__.split())
    for name in (*SHAPES, *scene_file.LIGHT_TYPES, *PATTERNS):
        assert f'"{name}"' in text, name
    for side in shapes.SIDES:
        assert re.search(rf"{side} \((low|high) [xyz]\)", text), side
    for name in SHAPES:
        keys = text.partition(f'- "{name}": ')[2].partition(' - "')[0]
        if name == "room":
            continue  # as "box"
        for key, parameter in inspect.signature(getattr(shapes, name)).parameters.items():
            if key in ("seed", "inward"):
                continue
            default = parameter.default
            if isinstance(default, tuple):
                default = default[0] if len(set(default)) == 1 and key == "size" else list(default)
            shown = re.sub(r"\.0\b", "", str(default))
            assert f"{key} ({shown}" in keys, (name, key)
    for kind, names in scene_file.LIGHT_KEYS.items():
        keys = text.partition(f'- "{kind}": ')[2].partition(' - "')[0]
        assert all(name in keys for name in names), kind
    for name in OPTIONS:
        assert name in text.partition("[solve]:")[2]
    for section in ("Args:", "Returns:", "Raises:"):
        assert section in text


def test_an_object_is_scaled_then_turned_about_x_then_y_then_z_then_moved(load):
    """As the docstring says it, on a corner that every order but this one takes elsewhere."""
    s = load(
        '[[object]]\nshape = "rectangle"\ncorner = [1, 2, 3]\npatches = 1\nscale = 2\n'
        "rotate = [90, 90, 90]\ntranslate = [10, 20, 30]"
    ).surfels
    x, y, z = 2 * 1.5, 2 * 2.5, 2 * 3.0
    x, y, z = x, -z, y  # counter-clockwise about x
    x, y, z = z, y, -x
    x, y, z = -y, x, z
    assert s.points[0] == pytest.approx([x + 10, y + 20, z + 30])


def test_a_byte_order_mark_is_no_part_of_the_text(tmp_path):
    (tmp_path / "ball.toml").write_bytes(b'\xef\xbb\xbf[[object]]\nshape = "sphere"\n')
    assert len(sf.load_scene(tmp_path / "ball.toml").objects) == 1
