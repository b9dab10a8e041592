"""STL files: what they have, and what is wrong with them."""

import numpy as np
import pytest

from surflux import FileError
from surflux._base.color import srgb_to_linear
from surflux.meshes.reading import read_mesh

TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
CORNERS = [[[0, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 0, 0], [0, 1, 0], [0, 0, 1]]]


def stl(path, header=b"", attributes=(0, 0, 0), corners=CORNERS):
    triangles = np.zeros(len(corners), TRIANGLE)
    triangles["corners"], triangles["attribute"] = corners, attributes
    path.write_bytes(header.ljust(80) + np.uint32(len(corners)).tobytes() + triangles.tobytes())
    return path


def test_stl_files_that_are_not_whole_are_told(tmp_path):
    """A binary one has 84 bytes before its triangles, of 50 each."""
    import trimesh

    path = tmp_path / "box.stl"
    trimesh.creation.box().export(path)
    whole = path.read_bytes()
    assert len(whole) == 84 + 12 * 50
    trimesh.creation.box().export(path, file_type="stl_ascii")
    text = path.read_bytes()
    cases = {
        whole[:-1]: "is cut off: it has 11 of its 12 triangles",
        whole[:300]: "is cut off: it has 4 of its 12 triangles",
        whole[:60]: "is cut off: it has 60 of the 84 bytes before its triangles",
        whole + b"abc": "is damaged: it has 687 bytes, and its 12 triangles take 684",
        b"solid" + whole[5:-1]: "is cut off: it has 11 of its 12 triangles",
        text[:900]: "is cut off: its text ends without endsolid",
        b"version https://git-lfs.github.com/spec/v1\n": "is no STL file, by what it begins with",
        b"": "the file is empty",
    }
    for data, reason in cases.items():
        path.write_bytes(data)
        with pytest.raises(FileError) as caught:
            read_mesh(path)
        assert str(caught.value) == f"{path}: {reason}"
    for data in (whole, b"solid" + whole[5:], text, b"\xef\xbb\xbf\n " + text):
        path.write_bytes(data)
        assert len(read_mesh(path).offsets) == 13


def test_corners_at_one_place_are_one_vertex(tmp_path):
    mesh = read_mesh(stl(tmp_path / "a.stl"))
    np.testing.assert_array_equal(mesh.indices, [0, 1, 2, 0, 2, 3, 0, 3, 4])
    np.testing.assert_array_equal(mesh.vertices[mesh.indices], np.reshape(CORNERS, (9, 3)))
    assert mesh.of_faces is None


def test_colors_of_viscam(tmp_path):
    """They were .5, without a word."""
    attributes = [0x8000 | 31 << 10 | 16, 31 << 10, 0x8000 | 31 << 5]  # red with some blue; not valid; green
    found = read_mesh(stl(tmp_path / "a.stl", attributes=attributes)).face_reflectance()
    half = srgb_to_linear(16 / 31)
    np.testing.assert_allclose(found, [[0.98, 0, 0.98 * half], [0.5] * 3, [0, 0.98, 0]], rtol=1e-6)


def test_colors_of_magics(tmp_path):
    header = b"Materialise COLOR=" + bytes([255, 0, 128, 255])
    whole = [0.98, 0, 0.98 * srgb_to_linear(128 / 255)]
    found = read_mesh(stl(tmp_path / "a.stl", header, [31, 31 << 10, 0x8000])).face_reflectance()
    np.testing.assert_allclose(found, [[0.98, 0, 0], [0, 0, 0.98], whole], rtol=1e-6)
    found = read_mesh(stl(tmp_path / "a.stl", header)).face_reflectance()
    np.testing.assert_allclose(found, [whole] * 3, rtol=1e-6)


def test_corners_that_are_not_finite_are_told(tmp_path):
    """Such triangles were left out, and rows of the others moved."""
    path = stl(tmp_path / "a.stl", corners=[CORNERS[0], [[0, 0, 0], [1, np.nan, 0], [0, 1, 0]]], attributes=[0, 0])
    with pytest.raises(FileError, match=r"a\.stl \(triangle 1\): a corner is \(1, nan, 0\); wanted finite numbers"):
        read_mesh(path)


FACET = "facet normal 0 0 1\n outer loop\n  vertex 0 0 {z}\n  vertex 1 0 0\n  {last}\n endloop\nendfacet\n"


@pytest.mark.parametrize(
    ("z", "last", "reason"),
    [
        ("nan", "vertex 1 1 0", r"\(triangle 1\): a corner is \(0, 0, nan\); wanted finite numbers"),
        ("x", "vertex 1 1 0", "a coordinate is no number"),
        ("0", "", "has 2 facets with 5 corners; wanted 3 of each"),
    ],
)
def test_faults_of_text(tmp_path, z, last, reason):
    path = tmp_path / "a.stl"
    whole = FACET.format(z=0, last="vertex 1 1 0")
    path.write_text(f"solid a vertex and a facet\n{whole}{FACET.format(z=z, last=last)}endsolid a vertex and a facet\n")
    with pytest.raises(FileError, match=rf"a\.stl.*{reason}"):
        read_mesh(path)


@pytest.mark.parametrize("newline", ["\n", "\r\n", "\r"])
def test_solids_of_a_text_are_one_mesh(tmp_path, newline):
    path = tmp_path / "a.stl"
    facet = FACET.format(z=0, last="vertex 1 1 0")
    text = "".join(f"solid {name}\n{part}endsolid {name}\n" for name, part in (("a", facet), ("b", facet.upper())))
    path.write_bytes(text.replace("\n", newline).encode())
    mesh = read_mesh(path)
    np.testing.assert_array_equal(mesh.indices, [0, 1, 2, 0, 1, 2])


@pytest.mark.parametrize("name", ["", "x", "a solid facet normal of a vertex 1 2 3"])
@pytest.mark.parametrize("newline", [" ", "\n"])
def test_text_may_be_one_line(tmp_path, name, newline):
    """The whole line was taken for a name."""
    path = tmp_path / "a.stl"
    solid = f"solid {name}\n{FACET.format(z=0, last='vertex 1 1 0')}endsolid {name}\n"
    path.write_text((2 * solid).replace("\n", newline))
    np.testing.assert_array_equal(read_mesh(path).indices, [0, 1, 2, 0, 1, 2])
