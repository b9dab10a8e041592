"""`surflux solve` of a mesh: its faces are cut into patches, lit, and taken home in their order."""

import numpy as np
import pytest

import surflux as sf
from surflux.scenes import shapes

pyvista = pytest.importorskip("pyvista")


@pytest.fixture
def bowl(here):
    """Half a ball of triangles and quads whose fronts are outside, as .ply."""
    mesh = pyvista.Sphere(radius=1.0, theta_resolution=16, phi_resolution=9, end_phi=90.0)
    mesh.save("bowl.ply")
    return pyvista.read("bowl.ply")


def test_faces_come_home_with_their_light(bowl, run):
    """Outside of what is convex each face has pi of a sky of radiance 1."""
    status, out, err = run("solve", "bowl.ply", "--mesh", "-o", "lit.vtp", "--no-image", "--light", "sky", "--rays", 32)
    assert status == 0, err
    assert "faces of the mesh, with their light: lit.vtp" in out
    assert "the mesh is lit by a sky of radiance 1 from all sides" in err
    lit = pyvista.read("lit.vtp")
    assert lit.n_cells == bowl.n_cells
    assert lit.cell_centers().points == pytest.approx(bowl.cell_centers().points, abs=1e-6)
    assert lit.cell_data["irradiance"] == pytest.approx(np.full((bowl.n_cells, 3), np.pi), rel=0.01)
    assert lit.cell_data["radiosity"] == pytest.approx(0.5 * lit.cell_data["irradiance"], rel=1e-5)


@pytest.fixture
def crate(here):
    """A box of six faces beside a plate of many vertices, as .ply: points of the box are its corners alone."""
    box = pyvista.Cube(clean=True)
    plate = pyvista.Plane(i_size=0.2, j_size=0.2, i_resolution=39, j_resolution=39, center=(1, 0, 0))
    box.append_polydata(plate).save("crate.ply")
    return "crate.ply"


def test_faces_are_taken_whose_points_do_not_cover_them(crate, run):
    """Disks of a sofa's vertices were as large as its seat."""
    few = "--no-image", "--light", "sky", "--rays", 16, "-o"
    for options, faces in (([], True), (["--no-mesh"], False), (["--thin", 1500], False), (["--keep-outliers"], False)):
        status, out, err = run("solve", crate, *options, *few, "lit.ply")
        assert status == 0, err
        said = "faces are taken, not points alone, which lie too far apart on 99 % of the surface (--no-mesh)"
        assert (said in err) == faces
        assert ("points, as read" in out) != faces
        assert ("left out because it is read as points" in err) != faces
    assert "points, as read" in run("solve", crate, *few, "lit.csv")[1]
    assert '"mesh"' in run("doctor", crate, "--json")[1]
    assert '"points"' in run("doctor", crate, "--json", "--points", 1000)[1]


def test_vertices_of_scans_stay_points_but_those_in_no_face(here, run):
    """Which are left of layers that were merged: black spots on the bunny as it was zipped."""
    ball = pyvista.Sphere(theta_resolution=60, phi_resolution=60)
    points = np.vstack([ball.points, 0.98 * ball.points[:40], ball.points[50:60]])
    pyvista.PolyData(points, faces=ball.faces).save("ball.ply")
    ask = "solve", "ball.ply", "--no-image", "--light", "sky", "--rays", 16, "-o", "lit.ply"
    _, out, err = run(*ask)
    assert "points, as read" in out
    assert f"in no face, left out of light and picture: 40 points of {len(points)} (--keep-outliers keeps them)" in err
    left_out = sf.read_scan("lit.ply").attributes["left_out"]
    np.testing.assert_array_equal(np.flatnonzero(left_out), np.arange(ball.n_points, ball.n_points + 40))
    assert "in no face" not in run(*ask, "--keep-outliers")[2]


def test_the_ground_is_cut_where_a_mesh_stands_on_it(bowl, run):
    """Nobody can be told to cut it who has no objects to name."""
    status, _, err = run("solve", "bowl.ply", "--mesh", "--ground", "-o", "lit.vtp", "--no-image", "--rays", 16)
    assert status == 0, err
    assert "walls of other objects" not in err
    lit = pyvista.read("lit.vtp")
    assert lit.n_cells == bowl.n_cells
    assert lit.cell_centers().points == pytest.approx(bowl.cell_centers().points, abs=1e-6)
    assert np.all(lit.cell_data["irradiance"] > 0.0)


def test_large_faces_are_cut(here, run):
    (here / "square.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")
    status, out, err = run("solve", "square.obj", "--no-image", "--light", "sky", "--normals", "flip", "--rays", 16)
    assert status == 0, err
    assert "face is cut into" in err
    assert "faces have no colour: each reflects 0.5 of the light" in err
    assert "solved surfels: square_solved.ply" in out
    found = sf.load_solution("square_solved.ply").surfels
    assert len(found) >= 20_000
    assert found.areas.sum() == pytest.approx(1.0)
    assert np.all(found.normals[:, 2] == -1.0)


def test_bodies_that_are_inside_out_are_told(here, run):
    """One of two: nothing but its darkness tells it from a room, and nobody was told."""
    ball, faces = shapes.icosphere(2)
    corners, both = np.vstack([ball, ball + 6.0]), np.vstack([faces, faces[:, ::-1] + len(ball)]) + 1
    text = [f"v {x} {y} {z}" for x, y, z in corners] + [f"f {a} {b} {c}" for a, b, c in both]
    (here / "balls.obj").write_text("\n".join(text))
    for ground in ([], ["--ground"]):
        status, _, err = run("solve", "balls.obj", "--light", "sky", "--no-image", "--rays", 16, *ground)
        assert status == 0, err
        assert "50 % of the surface has no light: hidden" in err


@pytest.mark.parametrize("normals", ["check", "keep"])
def test_faces_wound_against_the_others_are_turned_over(here, run, normals):
    """A sixth of the box stayed black, without a word."""
    corners = "".join(f"v {x} {y} {z}\n" for z in (0, 1) for y in (0, 1) for x in (0, 1))
    sides = ["3 4 2 1", "5 6 8 7", "1 2 6 5", "4 3 7 8", "3 1 5 7", "6 8 4 2"]  # the last one inwards
    (here / "box.obj").write_text(corners + "".join(f"f {side}\n" for side in sides))
    options = ["--light", "sky", "--no-image", "--rays", 16, "--normals", normals]
    status, _, err = run("solve", "box.obj", "-o", "lit.vtp", *options)
    assert status == 0, err
    told = "1 of 6 faces is wound against those beside, and is turned over (--normals keep)"
    assert (told in err) == (normals == "check")
    irradiance = pyvista.read("lit.vtp").cell_data["irradiance"][:, 0]
    assert irradiance == pytest.approx(np.pi * np.array([1, 1, 1, 1, 1, normals == "check"]), abs=0.01)


def test_a_mesh_whose_materials_shine_needs_no_light(here, run):
    (here / "room.mtl").write_text("newmtl lamp\nKd 0 0 0\nKe 1 1 1\nnewmtl floor\nKd .4 .4 .4\n")
    corners = "".join(f"v {x} {y} {z}\n" for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1)))
    faces = "usemtl floor\nf 1 2 3 4\nusemtl lamp\nf 8 7 6 5\n"
    (here / "room.obj").write_text(f"mtllib room.mtl\n{corners}{faces}")
    status, _, err = run("solve", "room.obj", "-o", "lit.vtp", "--no-image", "--rays", 16)
    assert status == 0, err
    assert "the mesh shines by itself: no other light is added" in err
    # From square to square at a distance of their side: F = .1998 (Howell C-11).
    irradiance = pyvista.read("lit.vtp").cell_data["irradiance"][0]
    assert irradiance == pytest.approx(0.1998 * np.pi * np.ones(3), rel=0.005)


def test_faces_that_turn_their_backs_to_the_origin_are_no_frame(here, run):
    """A table top above the origin, and a bumpy one before it: pictures were taken from the origin, and empty."""
    (here / "top.obj").write_text("v 0 0 5\nv 2 0 5\nv 2 2 5\nv 0 2 5\nf 1 2 3 4\n")
    x, y = np.meshgrid(*2 * [np.linspace(-1, 1, 60)])
    corners = np.stack([x, y, 2.0 + 0.4 * np.cos(2 * x) * np.cos(2 * y)], axis=-1).reshape(-1, 3)
    a = (np.arange(59)[:, None] * 60 + np.arange(59)).ravel() + 1
    quads = np.stack([a, a + 1, a + 61, a + 60], axis=1)
    lines = ["v {} {} {}\n".format(*c) for c in corners] + ["f {} {} {} {}\n".format(*q) for q in quads]
    (here / "bumps.obj").write_text("".join(lines))
    for name in ("top.obj", "bumps.obj"):
        status, _, err = run("solve", name, "--rays", 16, "--size", "80x60")
        assert status == 0, err
        assert "depth camera" not in err
        assert "the picture is empty" not in err


def test_a_terrain_that_is_wound_downwards_is_turned_over(here, run):
    """It was black, its picture blank, without a word. --normals keep leaves it, and then says what that means."""
    corners = [(x, y, 0.1 * np.sin(3.0 * x)) for y in np.linspace(0, 2, 9) for x in np.linspace(0, 2, 9)]
    quads = [(k, k + 9, k + 10, k + 1) for j in range(8) for k in range(9 * j + 1, 9 * j + 9)]
    lines = ["v {} {} {}\n".format(*c) for c in corners] + ["f {} {} {} {}\n".format(*q) for q in quads]
    (here / "hill.obj").write_text("".join(lines))
    status, _, err = run("solve", "hill.obj", "--no-image", "--rays", 16)
    assert status == 0, err
    assert "faces of a terrain: 100 % face down, and are turned over" in err
    assert "warning" not in err
    assert np.all(sf.load_solution("hill_solved.ply").surfels.normals[:, 2] > 0.0)
    status, _, err = run("check", "hill.obj")
    assert "100 % face down, which `surflux solve` turns over" in err
    for given in (["--normals", "keep"], ["--up", "0,-1,0"]):
        status, _, err = run("solve", "hill.obj", "--no-image", "--rays", 16, "--light", "sun", *given)
        assert status == 0, err
        assert "turned over" not in err
        assert np.all(sf.load_solution("hill_solved.ply").surfels.normals[:, 2] < 0.0)
        assert ("shines on backs of surfels alone" in err) == (given[0] == "--normals")  # -y up: seen from aside


def test_an_obj_file_of_points_stays_a_cloud(here, run):
    points = np.random.default_rng(0).normal(size=(300, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    (here / "ball.obj").write_text("".join(f"v {x} {y} {z}\n" for x, y, z in points))
    status, out, err = run("solve", "ball.obj", "-o", "lit.csv", "--no-image", "--rays", 16)
    assert status == 0, err
    assert "300 points, as read, with their light: lit.csv" in out


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--thin", 100), "--thin: is for a cloud"),
        (("--keep-outliers",), "--keep-outliers: is for a cloud"),
        (("-o", "lit.csv"), "-o: wanted a name ending in .ply, .glb, .gltf, .vtp, got 'lit.csv'"),
    ],
)
def test_what_a_mesh_does_not_take_is_refused(bowl, run, options, said):
    status, _, err = run("solve", "bowl.ply", "--mesh", *options)
    assert (status, said in err) == (2, True), err


def test_faces_that_are_left_out_are_told_of(bowl, run):
    status, _, err = run("solve", "bowl.ply", "--no-image", "--rays", 16)
    assert status == 0, err
    assert "left out because it is read as points" in err
    assert "surflux solve --mesh" in err


def test_a_scene_file_says_itself_what_it_takes(here, run):
    (here / "room.toml").write_text('[[object]]\nshape = "room"\n')
    status, _, err = run("solve", "room.toml", "--mesh")
    assert status == 2
    assert "--mesh: is for a PLY file; a scene file says by its key kind what it takes" in err


def test_a_mesh_is_written_lit_for_viewers(here, run):
    """glTF has y up, by its specification: as input, and as output of what has z up."""
    trimesh = pytest.importorskip("trimesh")
    table = trimesh.creation.box([2, 0.2, 1])
    table.export(here / "table.glb")
    status, out, err = run("solve", "table.glb", "-o", "lit.glb", "--no-image", "--rays", 16)
    assert status == 0, err
    assert "lit surfaces: lit.glb" in out
    assert "y is up, as glTF has it (--up 0,0,1 for z)" in err
    lit = trimesh.load(here / "lit.glb", force="mesh", skip_materials=True)
    assert lit.bounds == pytest.approx(table.bounds, abs=1e-6)
    top = lit.visual.vertex_colors[np.asarray(lit.vertex_normals)[:, 1] > 0.9]
    assert top[:, 0].min() > 100
    table.export(here / "table.stl")
    status, _, err = run("solve", "table.stl", "-o", "lit.gltf", "--no-image", "--rays", 16)
    assert status == 0, err
    assert trimesh.load(here / "lit.gltf", force="mesh").bounds[1] == pytest.approx([1.0, 0.5, 0.1], abs=1e-6)
    status, _, err = run("solar", "table.glb", "--place", "47,8", "--year", 2025)
    assert (status, "table.glb: glTF has y up, and the sun stands over z" in err) == (2, True)
