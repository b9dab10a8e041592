"""What a solution looks like in viewers: glTF of its surfaces, read back by a library that is not ours."""

import io
import json
import struct

import numpy as np
import pytest

import surflux as sf
from surflux._base.color import white_of
from surflux.meshes.gltf_container import Container
from surflux.solutions.lit_gltf import _at_corners, _have_area


def quad(*corners):
    return np.array(corners, np.float64), [[0, 1, 2, 3]]


@pytest.fixture(scope="module")
def solution():
    """A floor and a wall that meet at an edge, a ball of points over them, far from the origin."""
    far = np.array([1e5, 2e5, 300.0])
    floor = quad([0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0])
    wall = quad([0, 4, 0], [4, 4, 0], [4, 4, 3], [0, 4, 3])
    normals = np.random.default_rng(0).normal(size=(400, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    ball = sf.Surfels(far + [2, 2, 1] + 0.5 * normals, normals=normals, reflectance=[0.7, 0.2, 0.2])
    meshes = [
        sf.Surfels.from_mesh((far + v, f), 0.1, color) for (v, f), color in ((floor, 0.5), (wall, [0.2, 0.3, 0.8]))
    ]
    lamp = sf.PointLight(far + np.array([1, 1, 2.5]), 20.0)
    return sf.solve(sf.Scene([*meshes, ball], [lamp, sf.Environment(0.1)]), rays=64)


def in_floats(s):
    return (s.triangles - np.median(s.points, axis=0)).astype(np.float32)


def parts_of(path):
    """Geometries of a file by trimesh, placed, and what its header says."""
    trimesh = pytest.importorskip("trimesh")
    data = path.read_bytes()
    if path.suffix == ".glb":
        length = struct.unpack_from("<I", data, 12)[0]
        header = json.loads(data[20 : 20 + length])
    else:
        header = json.loads(data)
    scene = trimesh.load(io.BytesIO(data), file_type=path.suffix[1:], skip_materials=True)
    placed = [
        scene.geometry[name].copy().apply_transform(scene.graph[node][0])
        for node in scene.graph.nodes_geometry
        for name in [scene.graph[node][1]]
    ]
    return placed, header


@pytest.mark.parametrize("name", ["lit.glb", "lit.gltf"])
def test_patches_come_as_lit_triangles_and_disks_as_points(solution, tmp_path, name):
    path = solution.save(tmp_path / name)
    (mesh, cloud), header = parts_of(path)
    s = solution.surfels
    assert len(mesh.faces) == np.sum(_have_area(in_floats(s)))
    assert mesh.area == pytest.approx(28.0, rel=1e-5)
    turned = s.triangles[..., [0, 2, 1]] * [1, 1, -1]  # z up becomes y up
    assert mesh.bounds == pytest.approx(np.array([turned.min((0, 1)), turned.max((0, 1))]), abs=1e-4)
    mesh.update_faces(mesh.area_faces > 1e-9)  # without slivers, which have no normal
    is_floor = mesh.face_normals[:, 1] > 0.5
    assert mesh.area_faces[is_floor].sum() == pytest.approx(16.0, rel=1e-5)
    assert mesh.face_normals[~is_floor] == pytest.approx(np.tile([0.0, 0.0, 1.0], (np.sum(~is_floor), 1)), abs=1e-5)
    assert len(cloud.vertices) == np.sum(solution.objects == 2)
    first, second = header["meshes"][0]["primitives"]
    assert (first["mode"], second["mode"]) == (4, 0)
    assert header["materials"][first["material"]]["extensions"] == {"KHR_materials_unlit": {}}
    assert header["extensionsUsed"] == ["KHR_materials_unlit"]


def test_light_varies_over_triangles_and_ends_at_edges(solution, tmp_path):
    path = solution.save(tmp_path / "lit.glb")
    (mesh, _), header = parts_of(path)
    s, white = solution.surfels, white_of(solution.radiosity)  # nothing emits
    radiosity = mesh.vertex_attributes["_RADIOSITY"]
    of_points = header["meshes"][0]["primitives"][1]["attributes"]["_IRRADIANCE"]
    assert Container(path).array(of_points, "VEC3") == pytest.approx(
        solution.irradiance[solution.objects == 2], rel=1e-6
    )
    # The mean over each triangle is about that of its patch, and of all of them exactly the light that leaves.
    means = radiosity[mesh.faces].mean(axis=1)
    owner = s.triangle_surfel[_have_area(in_floats(s))]
    leaves = np.average(solution.radiosity[owner], axis=0, weights=mesh.area_faces)
    assert np.average(means, axis=0, weights=mesh.area_faces) == pytest.approx(leaves, rel=0.02)
    assert np.sqrt(np.mean((means - solution.radiosity[owner]) ** 2)) < 0.08 * np.sqrt(
        np.mean(means**2)
    )  # by patches of 30 cm
    assert np.ptp(radiosity[mesh.faces], axis=1).max() > 0.05 * radiosity.max()
    # Where floor and wall meet, each keeps its own: grey stays grey, and blue blue.
    is_floor = Container(path).array(header["meshes"][0]["primitives"][0]["attributes"]["NORMAL"], "VEC3")[:, 2] > 0.5
    assert np.all(radiosity[is_floor, 2] < 3.0 * radiosity[is_floor, 0])  # in shadow, too
    assert np.all(radiosity[~is_floor, 2] > 3.5 * radiosity[~is_floor, 0])
    colors = np.clip(radiosity / white, 0, 1)
    assert np.asarray(mesh.visual.vertex_colors)[:, :3] / 255.0 == pytest.approx(colors, abs=0.003)


def test_a_field_that_is_linear_comes_exactly_at_inner_corners():
    x, y = np.meshgrid(np.arange(5.0), np.arange(4.0), indexing="ij")
    cells = np.stack([x[:-1, :-1], y[:-1, :-1]], axis=-1).reshape(-1, 2)
    corners = [[0, 0], [1, 0], [1, 1], [0, 1]]
    triangles = np.array([[[*(c + corners[k]), 0.0] for k in t] for c in cells for t in ((0, 1, 2), (0, 2, 3))])
    values = 30.0 + np.repeat(cells @ [2.0, -3.0] + 0.5 * (2.0 - 3.0), 2)[:, None]
    found = _at_corners(triangles, np.tile([0.0, 0.0, 1.0], (len(triangles), 1)), values)[:, 0]
    places = triangles.reshape(-1, 3)
    inner = (places[:, 0] > 0) & (places[:, 0] < 4) & (places[:, 1] > 0) & (places[:, 1] < 3)
    assert inner.sum() >= 30
    assert found[inner] == pytest.approx(30.0 + places[inner, :2] @ [2.0, -3.0])


def test_up_is_that_which_was_named(solution, tmp_path):
    (mesh, _), _ = parts_of(solution.save(tmp_path / "lit.glb", up=[0, 1, 0]))
    assert mesh.bounds[:, 2] == pytest.approx([300.0, 303.0], abs=1e-4)  # as it is
    with pytest.raises(ValueError, match=r"^up: wanted"):
        solution.save(tmp_path / "lit.glb", up=[0, 0, 0])


def test_other_names_are_refused(solution, tmp_path):
    with pytest.raises(ValueError, match=r"^path: wanted a name ending in \.ply, \.glb, \.gltf, got '.*lit\.obj'"):
        solution.save(tmp_path / "lit.obj")
    path = solution.save(tmp_path / "lit.glb")
    with pytest.raises(sf.FileError, match=r"lit\.glb"):
        sf.load_solution(path)


def test_lamps_are_white_and_do_not_darken_what_they_light(tmp_path):
    """They were what is white where they were more than a hundredth of the surfels: all else came out black."""
    floor = sf.Surfels.from_mesh(quad([-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]), 0.05)
    lamp = sf.Surfels.from_mesh(quad([-0.3, -0.3, 2], [-0.3, 0.3, 2], [0.3, 0.3, 2], [0.3, -0.3, 2]), 0.05, 0, 100.0)
    solution = sf.solve(sf.Scene([floor, lamp]), rays=64)
    (mesh,), _ = parts_of(solution.save(tmp_path / "lit.glb"))
    shown = np.asarray(mesh.visual.vertex_colors)[:, 0]
    is_floor = mesh.vertices[:, 1] < 1.0
    assert shown[~is_floor].min() == 255
    assert 150 < np.median(shown[is_floor]) < 255
    solution.save(tmp_path / "lit.ply")
    colors = sf.read_scan(tmp_path / "lit.ply").reflectance
    assert np.median(colors[solution.objects == 0]) > 0.5


def test_white_is_what_is_lit_where_that_is_more_than_a_trifle():
    light, none = np.linspace(1.0, 100.0, 1000)[:, None] * np.ones(3), np.zeros((1000, 3))
    of_all = white_of(light)
    some = none.copy()
    some[500:] = 1.0
    assert white_of(light, none) == of_all
    assert white_of(light, some) == pytest.approx(50.0, rel=0.02)  # of the others
    assert white_of(light, none + 1.0) == of_all
    some[3:] = 1.0  # three dark points are not what all is shown by
    assert white_of(light, some) == of_all
    assert white_of(np.where(some > 0, light, 0.0), some) > 90.0  # nor is what is black


def test_no_light_leaks_past_a_wall_or_a_shadow(tmp_path):
    """Corners at the foot of a wall had half the sun of its other side."""
    floor = sf.Surfels.from_mesh(quad([-2, -2, 0], [2, -2, 0], [2, 2, 0], [-2, 2, 0]), 0.1)
    wall = sf.Surfels.from_mesh(
        (quad([0, -2, 0], [0, 2, 0], [0, 2, 2], [0, -2, 2])[0], [[0, 1, 2, 3]]), 0.1, two_sided=True
    )
    scene = sf.Scene(sf.divide_patches([floor, wall]), [sf.DirectionalLight([1, 0, -0.9], 100.0)])
    path = sf.solve(scene, rays=64).save(tmp_path / "lit.glb")
    _, header = parts_of(path)
    at = header["meshes"][0]["primitives"][0]["attributes"]
    file = Container(path)
    places, normals, light = (file.array(at[name], "VEC3") for name in ("POSITION", "NORMAL", "_IRRADIANCE"))
    places = places - places.min(axis=0) + [-2, -2, 0]
    is_floor = (normals[:, 2] > 0.5) & (np.abs(places[:, 1]) < 1.9)
    foot = is_floor & (np.abs(places[:, 0]) < 1e-5)
    assert np.any(light[foot, 0] > 50.0)  # of the sunny side
    assert np.all((light[foot, 0] > 50.0) | (light[foot, 0] < 20.0)), np.sort(light[foot, 0])


def test_a_fan_of_many_triangles_is_looked_at_in_part():
    """All pairs of them took half a minute."""
    angles = np.linspace(0.0, 2.0 * np.pi, 20_001)
    rim = np.column_stack([np.cos(angles), np.sin(angles), 0.0 * angles])
    triangles = np.stack([0.0 * rim[:-1], rim[:-1], rim[1:]], axis=1)
    found = _at_corners(triangles, np.tile([0.0, 0.0, 1.0], (20_000, 1)), np.ones((20_000, 3)))
    assert found == pytest.approx(1.0)


def test_triangles_that_are_none_in_floats_are_left_out(tmp_path):
    far = [[1e5, 0, 0], [1e5 + 1e-4, 0, 0], [1e5, 1e-4, 0]]
    near = sf.Surfels(np.random.default_rng(0).normal(size=(50, 3)), normals=[[0, 0, 1]] * 50, radii=0.1)
    scene = sf.Scene([near, sf.Surfels.from_mesh((far, [[0, 1, 2]]))], [sf.Environment(1.0)])
    _, header = parts_of(sf.solve(scene, rays=16).save(tmp_path / "lit.glb"))
    assert [p["mode"] for p in header["meshes"][0]["primitives"]] == [0]
