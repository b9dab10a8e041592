"""OFF files: what they have, and what is wrong with them."""

import numpy as np
import pytest

import surflux as sf
from surflux import FileError
from surflux._base.color import srgb_to_linear
from surflux.meshes.reading import read_mesh

SQUARE = ["0 0 0", "1 0 0", "1 1 0", "0 1 0"]
L_SHAPE = ["0 0 0", "2 0 0", "2 1 0", "1 1 0", "1 2 0", "0 2 0"]


def off(tmp_path, vertices, faces, header="OFF", behind=""):
    path = tmp_path / "a.off"
    rows = [f"{vertex}{behind}" for vertex in vertices] + list(faces)
    path.write_text(f"{header}\n{len(vertices)} {len(faces)} 0\n" + "\n".join(rows) + "\n")
    return path


@pytest.mark.parametrize("first", range(6))
def test_concave_polygons_are_whole(tmp_path, first):
    """From four of the six corners it had an area of 4."""
    path = off(tmp_path, L_SHAPE[first:] + L_SHAPE[:first], ["6 0 1 2 3 4 5"])
    assert sf.Surfels.from_mesh(path).areas.sum() == pytest.approx(3.0)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    ("header", "behind", "color"),
    [
        ("COFF", " 255 0 51 255", [1, 0, 0.2]),
        ("COFF", " 255 0 51", [1, 0, 0.2]),
        ("COFF", " 1. 0 .2 1", [1, 0, 0.2]),
        ("COFF", " 1 1 1 255", [1 / 255, 1 / 255, 1 / 255]),
        ("COFF", " 0 0 1 1", [0, 0, 1]),
        ("COFF", " 0 0 1", [0, 0, 1]),
        ("STCOFF", " 0 1 1 1 25 75", [0, 1, 1]),
        ("COFF", " 255.0 0 51.0 255.0", [1, 0, 0.2]),
        ("CNOFF", " 0 0 1 1.0 0.0 0.2 1.0", [1, 0, 0.2]),
        ("STCNOFF", " 0 0 1 255 0 51 255 .25 .75", [1, 0, 0.2]),
        ("STCOFF", " 255 0 51 .25 .75", [1, 0, 0.2]),
        ("NOFF", " 0 0 1", None),
        ("STOFF", " .25 .75", None),
    ],
)
def test_colors_of_vertices(tmp_path, header, behind, color):
    """They were grey."""
    mesh = read_mesh(off(tmp_path, SQUARE, ["4 0 1 2 3"], header, behind))
    wanted = [0.5] * 3 if color is None else 0.98 * srgb_to_linear(np.array(color))
    np.testing.assert_allclose(mesh.face_reflectance(), [wanted], rtol=1e-6)
    np.testing.assert_array_equal(mesh.indices, range(4))


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("red", ["255 0 0", "255 0 0 128", "1.0 0.0 0.0", "1 0. 0 .5"])
def test_colors_of_faces(tmp_path, red):
    faces = ["3 0 1 2 " + red, "4 0 1 2 3  # none"]
    found = read_mesh(off(tmp_path, SQUARE, faces)).face_reflectance()
    np.testing.assert_allclose(found, [[0.98, 0, 0], [0.5] * 3], rtol=1e-6)
    found = read_mesh(off(tmp_path, SQUARE, faces, "COFF", " 0 255 0 255")).face_reflectance()
    np.testing.assert_allclose(found, [[0.98, 0, 0], [0, 0.98, 0]], rtol=1e-6)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    ("reds", "wanted"),
    [
        (["255 0 0", ".5 0 0"], [1, 0.5]),
        (["1 0 0 255", "1. 0 0 .5"], [1 / 255, 1]),
        (["1 0 0", ".5 0 0"], [1, 0.5]),  # fractions of a program that writes no point behind 1
        (["255 0 0", "127.5 0 0"], [1, 0.5]),
        (["1 0 0 1", "0 0 0 1"], [1, 0]),
    ],
)
def test_faces_of_both_kinds(tmp_path, reds, wanted):
    """Beside whole numbers fractions were black, and those that are 0 and 1 alone, too."""
    found = read_mesh(off(tmp_path, SQUARE, [f"3 0 1 2 {red}" for red in reds])).face_reflectance()
    np.testing.assert_allclose(found[:, 0], 0.98 * srgb_to_linear(np.array(wanted)), rtol=1e-6)
    np.testing.assert_array_equal(found[:, 1:], 0.0)


@pytest.mark.parametrize("text", ["OFF4 1 0", "OFF 4 1", "# of a tool\n\n\t OFF # text\n 4 1 0 # and counts"])
def test_ways_of_heads(tmp_path, text):
    path = tmp_path / "a.off"
    path.write_bytes(f"{text}\n\n{chr(10).join(SQUARE)}\n\n4 0 1 2 3".replace("\n", "\r\n").encode())
    np.testing.assert_array_equal(read_mesh(path).indices, range(4))


def test_numbers_that_are_no_colors_are_told(tmp_path):
    with pytest.warns(UserWarning, match="1 face with numbers behind its corners that are no colour .*: they are left"):
        mesh = read_mesh(off(tmp_path, SQUARE, ["4 0 1 2 3 7"]))  # of a map of colours
    assert mesh.of_faces is None
    with pytest.warns(UserWarning, match="vertices have 3 numbers more than OFF has, which are left out"):
        mesh = read_mesh(off(tmp_path, SQUARE, ["4 0 1 2 3"], behind=" 1 0 0"))
    assert mesh.reflectance is None


HEAD = "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n"


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (HEAD + "3 0 1 2\n", ": is cut off: it has 1 of its 2 faces"),
        (HEAD[:22], ": is cut off: it has 2 of its 4 vertices"),
        ("OFF\n99999999999 1 0\n0 0 0\n", ": is cut off: it has 1 of its 99999999999 vertices"),
        (
            HEAD + "3 0 1 2\n3 0 2 3\n3 0 1 3\n",
            " (line 9): goes on after its 2 faces: a number in its header is wrong",
        ),
        (HEAD.replace("1 1 0", "nan 1 0") + "3 0 1 2\n" * 2, " (line 5): a coordinate is not finite: 'nan 1 0'"),
        (HEAD.replace("1 1 0", "1 1") + "3 0 1 2\n" * 2, " (line 5): a vertex of 2 numbers; wanted 3 (OFF)"),
        (HEAD.replace("1 1 0", "1 1 x") + "3 0 1 2\n" * 2, " (line 5): 'x' is no number"),
        (
            HEAD + "3 0 1 2\n3 0 1 4\n",
            " (line 8): a face has the corner 4; the file has 4 vertices, numbered from 0",
        ),
        (
            HEAD + "3 0 1 -1\n3 0 1 2\n",
            " (line 7): a face has the corner -1; the file has 4 vertices, numbered from 0",
        ),
        (HEAD + "3 0 1 2\n3 0 1\n", " (line 8): a face of 3 corners has 2 of them"),
        (HEAD + "3 0 1 2\n2 0 1\n", " (line 8): a face of 2 corners; wanted 3 or more"),
        (HEAD + "3 0 1 2.5\n3 0 1 2\n", " (line 7): '2.5' is no whole number"),
        (HEAD + f"3 0 1 2\n3 0 1 {10**19}\n", f" (line 8): '{10**19}' is no whole number"),
        (HEAD + f"3 0 1 2\n{10**19} 0 1 2\n", f" (line 8): '{10**19}' is no whole number"),
        (HEAD + "3 0 1 2 red 0 0\n3 0 1 2\n", " (line 7): 'red' is no number"),
        ("OFF\nfour 2 0\n", " (line 2): wanted the numbers of its vertices and faces, got 'four 2 0'"),
        ("OFF\n", ": wanted the numbers of its vertices and faces, got nothing"),
        ("OFF BINARY\n\0\0\0\4", ": is a binary OFF file, which is not read; wanted one of text"),
        ("4OFF\n1 1 0\n", ": has coordinates of other dimensions (4OFF); wanted 3"),
        ("ply\n", ": is no OFF file, by what it begins with"),
        ("", ": the file is empty"),
    ],
)
def test_faults_name_the_line(tmp_path, text, reason):
    path = tmp_path / "a.off"
    path.write_text(text)
    with pytest.raises(FileError) as caught:
        read_mesh(path)
    assert str(caught.value) == f"{path}{reason}"
