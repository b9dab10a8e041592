"""Pieces of patches that walls of other objects stand on have the colours that are there."""

import numpy as np
import pytest

import surflux as sf
from squares import SQUARE
from surflux._base.color import WHITE

WALL = [[0.25, -1, -1], [0.25, 2, -1], [0.25, 2, 1], [0.25, -1, 1]], [[0, 1, 2, 3]]
TURNED = np.array([[0, -2, 0, 7], [2, 0, 0, -5], [0, 0, 2, 3], [0, 0, 0, 1.0]])
FLAT = "property float reflectance_r\nproperty float reflectance_g\nproperty float reflectance_b\n"


def painted(folder, keyword):
    """A square that is white, or 2 W/m2, beyond x = .5, by a texture, and nothing before."""
    image = pytest.importorskip("PIL.Image")
    pixels = np.zeros((8, 8, 3), np.uint8)
    pixels[:, 4:] = 255
    image.fromarray(pixels).save(folder / "half.png")
    (folder / "a.mtl").write_text(f"newmtl a\nKd .5 .5 .5\n{keyword} half.png\n")
    places = "".join(f"v {x:g} {y:g} 0\nvt {x:g} {y:g}\n" for x, y in SQUARE[:, :2])
    (folder / "a.obj").write_text(f"mtllib a.mtl\n{places}usemtl a\nf 1/1 2/2 3/3 4/4\n")
    return sf.Surfels.from_mesh(folder / "a.obj")


def shaded(folder):
    """A square whose vertices have .8 x."""
    head = f"ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n{FLAT}"
    rows = "".join(f"{x} {y} 0 {f'{0.8 * x} ' * 3}\n" for x, y in SQUARE[:, :2])
    text = f"{head}element face 1\nproperty list uchar int vertex_indices\nend_header\n{rows}4 0 1 2 3\n"
    (folder / "a.ply").write_text(text)
    return sf.Surfels.from_mesh(folder / "a.ply")


def pieces(floor, matrix=None):
    """The two pieces of a floor, the first before x = .25, with a wall there, both moved by the matrix."""
    things = [floor, sf.Surfels.from_mesh(WALL)]
    floor = sf.divide_patches(things if matrix is None else [s.transformed(matrix) for s in things])[0]
    assert len(floor) == 2
    return floor[np.argsort(floor.areas)]


@pytest.mark.parametrize("matrix", [None, TURNED])
def test_pieces_have_what_of_a_texture_is_there(tmp_path, matrix):
    """Both had the mean of the whole, so that light of the white part reached the wall from the black one."""
    s = pieces(painted(tmp_path, "map_Kd"), matrix)
    np.testing.assert_allclose(s.reflectance[:, 0], [0.0, 0.5 * WHITE * 2 / 3], atol=1e-9)
    np.testing.assert_array_equal(s.emission, 0.0)


def test_pieces_shine_as_their_texture_does(tmp_path):
    s = pieces(painted(tmp_path, "Ke 2 2 2\nmap_Ke"))
    np.testing.assert_allclose(s.emission[:, 0], [0.0, 2 * np.pi * 2 / 3], atol=1e-9)
    np.testing.assert_array_equal(s.reflectance, 0.5)


@pytest.mark.parametrize("matrix", [None, TURNED])
def test_pieces_have_the_colours_of_vertices(tmp_path, matrix):
    s = pieces(shaded(tmp_path), matrix)
    np.testing.assert_allclose(s.reflectance[:, 0], [0.8 * 0.125, 0.8 * 0.625], rtol=1e-6)


def test_other_colours_stay(tmp_path):
    """Those of replace, while what was not replaced is that of the texture."""
    for floor in (painted(tmp_path, "Ke 2 2 2\nmap_Ke"), shaded(tmp_path)):
        np.testing.assert_array_equal(pieces(floor.replace(reflectance=0.3, emission=1.0)).emission, 1.0)
        np.testing.assert_array_equal(pieces(floor.replace(reflectance=0.3)).reflectance, 0.3)
    glowing = painted(tmp_path, "map_Kd").replace(emission=3.0)
    np.testing.assert_allclose(pieces(glowing).reflectance[:, 0], [0.0, 0.5 * WHITE * 2 / 3], atol=1e-9)
    np.testing.assert_array_equal(pieces(glowing).emission, 3.0)


def test_pieces_reflect_no_more_than_they_get(tmp_path):
    floor = painted(tmp_path, "Kd 1 1 1\nmap_Kd").replace(specular=0.4)
    with pytest.raises(ValueError, match=r"specular: wanted reflectance \+ specular below 1"):
        pieces(floor)
