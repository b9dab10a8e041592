"""Meshes in glTF, whose y is up by its specification, in scenes, whose z is."""

import numpy as np
import pytest

import surflux as sf

trimesh = pytest.importorskip("trimesh")


@pytest.fixture
def load(tmp_path):
    """Surfels of a scene file that names a board, 2 wide, 3 high along y, its front at z = .5, its back at z = 0."""
    board = trimesh.creation.box(bounds=[[0, 0, 0], [2, 3, 0.5]])
    for suffix in ("glb", "gltf", "stl"):
        board.export(tmp_path / f"board.{suffix}")

    def loaded(suffix, more="", kind="mesh"):
        path = tmp_path / "scene.toml"
        path.write_text(f'[[object]]\nfile = "board.{suffix}"\nkind = "{kind}"\n{more}')
        return sf.load_scene(path).surfels

    return loaded


def bounds(s):
    corners = s.triangles.reshape(-1, 3)
    return [*corners.min(axis=0), *corners.max(axis=0)]


TURNED, AS_IT_STANDS = [0, -0.5, 0, 2, 0, 3], [0, 0, 0, 2, 3, 0.5]  # y to z by the shortest turn takes z to -y


@pytest.mark.parametrize("suffix", ["glb", "gltf"])
def test_y_of_gltf_is_turned_to_z_which_is_said(load, caplog, suffix):
    caplog.set_level("INFO", "surflux")
    s = load(suffix)
    assert bounds(s) == pytest.approx(TURNED, abs=1e-6)
    front = s.points[:, 1] < -0.49
    assert np.abs(s.normals[front] - [0, -1, 0]).max() < 1e-6
    assert front.any()
    assert f"scene.toml (object 1): y is up in board.{suffix}, as glTF has it (up = [0, 0, 1] for z)" in caplog.text


def test_points_on_gltf_stand_as_its_patches_do(load):
    points = load("glb", "points = 600\n", kind="surfels").points
    assert points[:, 2].max() == pytest.approx(3, abs=0.1)
    assert points[:, 1].min() == pytest.approx(-0.5, abs=0.1)


def test_what_a_table_says_is_up_counts(load, caplog):
    caplog.set_level("INFO", "surflux")
    assert bounds(load("glb", "up = [0, 0, 1]\n")) == pytest.approx(AS_IT_STANDS, abs=1e-6)
    assert bounds(load("glb", "up = [0, 1, 0]\n")) == pytest.approx(TURNED, abs=1e-6)
    assert "glTF" not in caplog.text


def test_other_formats_are_taken_as_they_stand(load, caplog):
    caplog.set_level("INFO", "surflux")
    assert bounds(load("stl")) == pytest.approx(AS_IT_STANDS, abs=1e-6)
    assert "is up" not in caplog.text
