"""Colours at vertices of OBJ files, beside materials and where some have none."""

import warnings

import numpy as np
import pytest
from PIL import Image

from surflux._base.color import srgb_to_linear
from surflux.meshes.reading import read_mesh

SQUARE = "v 0 0 0{c}\nv 1 0 0{c}\nv 1 1 0{c}\nv 0 1 0{c}\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
RED = [0.98 * srgb_to_linear(128 / 255), 0, 0]


def reflectance(tmp_path, text, library=""):
    (tmp_path / "a.mtl").write_text(library)
    (tmp_path / "a.obj").write_text("mtllib a.mtl\n" + text)
    return read_mesh(tmp_path / "a.obj").face_reflectance()


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("color", ["", " 1 1 1", " 0 1 0"])
def test_a_texture_counts_more(tmp_path, color):
    """It was dropped without a word, and a warning spoke of Kd."""
    Image.fromarray(np.full((4, 4, 3), [128, 0, 0], np.uint8)).save(tmp_path / "red.png")
    library, text = "newmtl a\nKd 1 1 1\nmap_Kd red.png\n", SQUARE.format(c=color) + "usemtl a\nf 1/1 2/2 3/3 4/4\n"
    np.testing.assert_allclose(reflectance(tmp_path, text, library), [RED], rtol=1e-6)
    trimesh = pytest.importorskip("trimesh")
    loaded = read_mesh(trimesh.load(tmp_path / "a.obj"))
    np.testing.assert_allclose(loaded.face_reflectance(), [RED, RED], rtol=1e-6)


def test_colors_count_where_no_texture_does(tmp_path):
    Image.fromarray(np.full((4, 4, 3), [128, 0, 0], np.uint8)).save(tmp_path / "red.png")
    library = "newmtl a\nKd 1 1 1\nmap_Kd red.png\nnewmtl b\nKd 2 2 2\n"
    text = SQUARE.format(c=" 0 1 0") + "usemtl a\nf 1/1 2/2 3/3\nusemtl b\nf 1 3 4\n"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = reflectance(tmp_path, text, library)
    np.testing.assert_allclose(found, [RED, [0, 0.98, 0]], rtol=1e-6)
    with pytest.warns(UserWarning, match="1 face has a texture and no place on it .*; colours of vertices, Kd and"):
        found = reflectance(tmp_path, text.replace("1/1", "1"), library)
    np.testing.assert_allclose(found, [[0, 0.98, 0]] * 2, rtol=1e-6)


@pytest.mark.filterwarnings("error")
def test_one_kd_beside_colors_is_no_fault(tmp_path):
    """Meshlab writes one of 1 1 1, which a warning said to be cut off."""
    text = SQUARE.format(c=" 0 1 0") + "usemtl a\nf 1/1 2/2 3/3 4/4\n"
    np.testing.assert_allclose(reflectance(tmp_path, text, "newmtl a\nKd 1 1 1\n"), [[0, 0.98, 0]], rtol=1e-6)
    trimesh = pytest.importorskip("trimesh")
    loaded = read_mesh(trimesh.load(tmp_path / "a.obj"))
    np.testing.assert_allclose(loaded.face_reflectance(), [[0, 0.98, 0]] * 2, rtol=1e-6)


def test_that_kd_is_left_out_is_told_where_it_differs(tmp_path):
    text = SQUARE.format(c=" 0 1 0") + "usemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\n"
    with pytest.warns(UserWarning, match="Kd of 2 faces is left out: the colours of their vertices count"):
        found = reflectance(tmp_path, text, "newmtl a\nKd .1 .1 .1\nnewmtl b\nKd .2 .2 .2\n")
    np.testing.assert_allclose(found, [[0, 0.98, 0]] * 2, rtol=1e-6)


def test_some_vertices_have_colors(tmp_path):
    """All faces were grey, without a word."""
    text = SQUARE.format(c=" 1 0 0") + "v 3 0 0\nv 4 0 0\nv 4 1 0\nf 1 2 3 4\nf 5 6 7\nf 1 3 5\nusemtl a\nf 5 6 7\n"
    with pytest.warns(UserWarning, match="3 faces have corners without a colour: Kd counts there, else 0.5"):
        found = reflectance(tmp_path, text, "newmtl a\nKd .1 .2 .3\n")
    np.testing.assert_allclose(found, [[0.98, 0, 0], [0.5] * 3, [0.5] * 3, [0.1, 0.2, 0.3]], rtol=1e-6)
