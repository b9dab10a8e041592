"""Textures of PLY files."""

import numpy as np
import pytest
from PIL import Image

import surflux as sf
from surflux._base.color import srgb_to_linear
from surflux.meshes.reading import read_mesh

SQUARE = ["0 0 0", "1 0 0", "1 1 0", "0 1 0"]
LEFT, RIGHT = [0.98 * srgb_to_linear(128 / 255), 0, 0], [0, 0, 0.98]


@pytest.fixture
def two_colors(tmp_path):
    pixels = np.zeros((2, 8, 3), np.uint8)
    pixels[:, :4, 0], pixels[:, 4:, 2] = 128, 255
    Image.fromarray(pixels).save(tmp_path / "two colors.png")
    return tmp_path


def ply(folder, vertices, faces, of_vertices="", of_faces="", comments=("TextureFile two colors.png",)):
    lines = ["ply", "format ascii 1.0", *(f"comment {comment}" for comment in comments), "element vertex 4"]
    lines += [f"property float {name}" for name in ("x", "y", "z", *of_vertices.split())]
    lines += [f"element face {len(faces)}", "property list uchar int vertex_indices"]
    lines += [f"property {kind}" for kind in filter(None, of_faces.split(", "))] + ["end_header", *vertices, *faces]
    path = folder / "a.ply"
    path.write_text("\n".join(lines) + "\n")
    return path


TEXCOORD = "list uchar float texcoord"
FACES = ["3 0 1 2 6 .1 .1 .4 .1 .4 .9", "3 0 2 3 6 .6 .1 .9 .1 .9 .9"]


@pytest.mark.filterwarnings("error")
def test_places_at_faces(two_colors):
    """They were grey, without a word."""
    path = ply(two_colors, SQUARE, FACES, of_faces=TEXCOORD)
    np.testing.assert_allclose(read_mesh(path).face_reflectance(), [LEFT, RIGHT], rtol=1e-6, atol=1e-12)
    whole = ply(two_colors, SQUARE, ["4 0 1 2 3 8 0 0 1 0 1 1 0 1"], of_faces=TEXCOORD)
    np.testing.assert_allclose(read_mesh(whole).face_reflectance(), [(np.array(LEFT) + RIGHT) / 2], rtol=1e-6)
    patches = sf.Surfels.from_mesh(whole, patch_area=0.07)
    side = patches.points[:, 0] > 0.5
    np.testing.assert_allclose(patches.reflectance, np.where(side[:, None], RIGHT, LEFT), rtol=1e-5, atol=1e-7)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("names", ["s t", "u v", "texture_u texture_v"])
def test_places_at_vertices(two_colors, names):
    """A texture counts before colours."""
    vertices = [f"{at} {place} 0 1 0" for at, place in zip(SQUARE, (".6 0", ".9 0", ".9 1", ".6 1"), strict=True)]
    path = ply(two_colors, vertices, ["4 0 1 2 3"], f"{names} red green blue")
    np.testing.assert_allclose(read_mesh(path).face_reflectance(), [RIGHT], rtol=1e-6, atol=1e-12)


def test_faces_say_which_texture_is_theirs(two_colors):
    Image.new("RGB", (2, 2), (0, 255, 0)).save(two_colors / "green.png")
    faces = [f"{face} {number}" for face, number in zip((*FACES, FACES[0], FACES[0]), (1, 0, -1, 2), strict=True)]
    comments = ("TextureFile two colors.png", "texturefile green.png", "TextureFile gone.png")
    path = ply(two_colors, SQUARE, faces, of_faces=TEXCOORD + ", int texnumber", comments=comments)
    with pytest.warns(UserWarning, match=r"'gone\.png' is not there; colours of faces or vertices count there"):
        found = read_mesh(path).face_reflectance()
    np.testing.assert_allclose(found, [[0, 0.98, 0], RIGHT, [0.5] * 3, [0.5] * 3], rtol=1e-6, atol=1e-12)


def test_numbers_of_textures_that_are_not_named_are_told(two_colors):
    """Such faces were grey, without a word."""
    faces = [f"{face} {number}" for face, number in zip((*FACES, FACES[0]), (7, 0, -1), strict=True)]
    path = ply(two_colors, SQUARE, faces, of_faces=TEXCOORD + ", int texnumber")
    said = "1 face has texnumber 7 of 1 texture, numbered from 0; colours of faces or vertices count there"
    with pytest.warns(UserWarning, match=said) as told:
        found = read_mesh(path).face_reflectance()
    assert len(told) == 1
    np.testing.assert_allclose(found, [[0.5] * 3, RIGHT, [0.5] * 3], rtol=1e-6, atol=1e-12)


@pytest.mark.parametrize("face", ["4 0 1 2 3 6 0 0 1 0 1 1", "4 0 1 2 3 0", "4 0 1 2 3 8 0 0 1 0 1 1 0 nan"])
def test_faces_without_places_are_told(two_colors, face):
    path = ply(two_colors, SQUARE, [face, FACES[1]], of_faces=TEXCOORD)
    with pytest.warns(UserWarning, match=r"1 face has a texture and no place on it \(texcoord\); colours of faces or"):
        found = read_mesh(path).face_reflectance()
    np.testing.assert_allclose(found, [[0.5] * 3, RIGHT], rtol=1e-6, atol=1e-12)
    with pytest.warns(UserWarning, match="1 face has a texture and no place on it"):
        assert read_mesh(ply(two_colors, SQUARE, ["4 0 1 2 3"])).of_faces is None


@pytest.mark.filterwarnings("error")
def test_reflectance_counts_more(two_colors):
    faces = [f"{face} .25 .5 .75" for face in FACES]
    path = ply(two_colors, SQUARE, faces, of_faces=TEXCOORD + "".join(f", float reflectance_{c}" for c in "rgb"))
    np.testing.assert_allclose(read_mesh(path).face_reflectance(), [[0.25, 0.5, 0.75]] * 2)
