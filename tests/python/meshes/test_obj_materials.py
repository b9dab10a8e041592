"""Materials of OBJ files."""

import os
from pathlib import Path

import numpy as np
import pytest

import surflux as sf
from surflux._base.color import srgb_to_linear
from surflux.meshes.reading import read_mesh

CORNERS = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
FACES = "f 1 2 3\nusemtl red wall\nf 1 3 4\nusemtl lamp\nf 1 2 4\nusemtl grey\nf 2 3 4\n"
LIBRARY = """# two of them
newmtl red wall
  Kd 0.6 0.2 0.1 # linear
  Ke 0 0 0
newmtl lamp
Kd .98 .98 .98
Ke 2 1 .5
newmtl grey
Kd .3
"""


def obj(tmp_path, library=LIBRARY, line="mtllib my room.mtl", text=CORNERS + FACES):
    (tmp_path / "my room.mtl").write_text(library)
    path = tmp_path / "room.obj"
    path.write_text(f"{line}\n{text}")
    return path


LINES = [
    "mtllib my room.mtl",
    'mtllib "my room.mtl" # all of them',
    'mtllib ./none.mtl \\\n "my room.mtl"',
    r"mtllib C:\my work\my room.mtl",
    "mtllib ./my room.mtl",
    "mtllib  my room.mtl  # two blanks",
    "mtllib {folder}/my room.mtl",
    "\ufeffmtllib my room.mtl",
    "mtllib my room.mtl\nmtllib my room.mtl",
]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("line", LINES)
def test_faces_have_their_materials(tmp_path, line):
    path = obj(tmp_path, line=line.format(folder=tmp_path))
    rho = [[0.5, 0.5, 0.5], [0.6, 0.2, 0.1], [0.98, 0.98, 0.98], [0.3, 0.3, 0.3]]
    exitance = np.pi * np.array([[0, 0, 0], [0, 0, 0], [2, 1, 0.5], [0, 0, 0]])
    surfels = sf.Surfels.from_mesh(path)  # was grey, and dark
    np.testing.assert_allclose(surfels.reflectance, rho, rtol=1e-6)
    np.testing.assert_allclose(surfels.emission, exitance, rtol=1e-6)
    painted = sf.Surfels.from_mesh(path, reflectance=0.1, emission=1.0)
    assert np.all(painted.reflectance == 0.1)
    assert np.all(painted.emission == 1.0)
    points = sf.Surfels.sample_mesh(path, 400)
    lamp = np.isclose(points.reflectance[:, 0], 0.98)
    np.testing.assert_allclose(points.emission[lamp], [exitance[2]] * lamp.sum(), rtol=1e-6)
    assert not points.emission[~lamp].any()


def test_several_libraries_of_one_line(tmp_path):
    (tmp_path / "a.mtl").write_text("newmtl red wall\nKd 1 0 0\n")
    (tmp_path / "b.mtl").write_text("newmtl lamp\nKd 0 1 0\nnewmtl grey\nKd 0 0 1\n")
    mesh = read_mesh(obj(tmp_path, line="mtllib a.mtl b.mtl"))
    np.testing.assert_allclose(mesh.face_reflectance()[1:], 0.98 * np.eye(3))


def test_colors_of_vertices_count_more(tmp_path):
    """Meshlab gives all faces of a coloured mesh one material."""
    colored = "".join(f"{line} 1 0 0\n" for line in CORNERS.splitlines())
    with pytest.warns(UserWarning, match="Kd of 4 faces is left out: the colours of their vertices count in its place"):
        mesh = read_mesh(obj(tmp_path, text=colored + FACES))
    np.testing.assert_allclose(mesh.face_reflectance(), [[0.98, 0, 0]] * 4)


@pytest.mark.filterwarnings("error")
def test_names_in_any_letters_and_with_signs(tmp_path):
    """Latin-1 names, of files as well, were a UnicodeDecodeError; what comes after # may be part of the name."""
    (tmp_path / os.fsdecode(b"Gr\xfcn.mtl")).write_bytes(
        b"newmtl M #1\nKd .98 0 0\nnewmtl M #2\nKd 0 .98 0\nnewmtl Gr\xfcn\t\tTuch\nKd 0 0 .98\n"
    )
    path = tmp_path / "a.obj"
    used = b"usemtl M #1\nf 1 2 3\nusemtl M #2\nf 1 2 3\nusemtl Gr\xfcn Tuch\t# green\nf 1 2 3\n"
    path.write_bytes(b"mtllib Gr\xfcn.mtl\n" + CORNERS.encode() + used)
    np.testing.assert_allclose(read_mesh(path).face_reflectance(), 0.98 * np.eye(3))
    points = tmp_path / "points.obj"
    points.write_bytes(b"mtllib Gr\xfcn.mtl\n" + 40 * CORNERS.encode())
    assert len(sf.read_scan(points)) == 160


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("first", ["newmtl M\nKd .1\nnewmtl M #2\nKd .9\n", "newmtl M #2\nKd .9\nnewmtl M\nKd .1\n"])
def test_the_exact_name_counts_first(tmp_path, first):
    faces = "usemtl M\nf 1 2 3\nusemtl M #2\nf 1 2 3\nusemtl M # a comment\nf 1 2 3\n"
    mesh = read_mesh(obj(tmp_path, first, text=CORNERS + faces))
    np.testing.assert_allclose(mesh.face_reflectance()[:, 0], [0.1, 0.9, 0.1])


def test_a_name_is_not_that_of_another_comment(tmp_path):
    with pytest.warns(UserWarning, match=r"1 material \(M #3\) in no library"):
        read_mesh(obj(tmp_path, "newmtl M #2\nKd .9\n", text=CORNERS + "usemtl M #2\nf 1 2 3\nusemtl M #3\nf 1 2 3\n"))


def test_libraries_by_their_folders(tmp_path):
    for name in "ab":
        (tmp_path / f"{name}.mtl").write_text(f"newmtl {name}\nKd .{'ab'.index(name) + 1}\n")
    faces = "usemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\n"
    for line in ("mtllib ./a.mtl ./b.mtl", 'mtllib "a.mtl" "b.mtl"', "mtllib C:\\x\\a.mtl\nmtllib /nowhere/b.mtl"):
        mesh = read_mesh(obj(tmp_path, line=line, text=CORNERS + faces))
        np.testing.assert_allclose(mesh.face_reflectance()[:, 0], [0.1, 0.2])


def test_many_libraries_in_one_line(tmp_path):
    line = "mtllib " + " ".join(f"library_{k:03}.mtl" for k in range(30))  # longer than a name may be
    (tmp_path / "library_007.mtl").write_text(LIBRARY)
    mesh = read_mesh(obj(tmp_path, line=line))
    np.testing.assert_allclose(mesh.face_reflectance()[1], [0.6, 0.2, 0.1])


@pytest.mark.parametrize(
    ("library", "line", "reason"),
    [
        (
            LIBRARY,
            "mtllib a.mtl\nmtllib b.mtl",
            r"room\.obj: 3 materials \(red wall, lamp, grey\) not there: a\.mtl, b\.mtl;",
        ),
        (LIBRARY, "", r"3 materials \(.*\) without mtllib; faces that have them reflect 0\.5"),
        (
            LIBRARY.replace("newmtl lamp", "newmtl l"),
            None,
            r"1 material \(lamp\) in no library of it; faces that have it",
        ),
        ("nothing", None, r"3 materials \(red wall, lamp, grey\) in no library of it"),
        (
            LIBRARY + "map_Kd wood.png\n",
            None,
            r"room\.obj: texture 'wood\.png' is not there; Kd and Ke alone count there",
        ),
        (
            LIBRARY.replace(".3", "-.3"),
            None,
            r"room\.obj: Kd of 1 face \(grey\) is not in 0 to 0\.98, the most that counts, and is cut off$",
        ),
        (LIBRARY.replace(".3", "180"), None, r"Kd of 1 face \(grey\) is .* cut off; 8-bit .* divided by 255$"),
        (LIBRARY + "map_Ke my glow.png\n", None, r"texture 'my glow\.png' is not there"),
        (LIBRARY + "map_Kd my room.mtl\n", None, r"texture '.*my room\.mtl' is not read \(UnidentifiedImageError"),
        *(
            (
                f"newmtl lamp\nKd {colour}\n",
                None,
                rf"my room\.mtl \(line 2\): a colour is '{colour}', wanted three numbers",
            )
            for colour in ("0.1 0.2", "red", "spectral a.rfl", "nan 0 0", "", "1 0 0 1")
        ),
    ],
)
def test_what_is_missing_or_not_read_is_said(tmp_path, library, line, reason):
    with pytest.warns(UserWarning, match=reason):
        mesh = read_mesh(obj(tmp_path, library, "mtllib my room.mtl" if line is None else line))
    assert len(mesh.face_reflectance()) == 4


@pytest.mark.filterwarnings("error")
def test_what_no_face_uses_is_no_matter(tmp_path):
    read_mesh(obj(tmp_path, text=CORNERS + "usemtl none\n" + FACES.replace("f 1 2 3\n", "", 1)))
    read_mesh(
        obj(tmp_path, LIBRARY + "newmtl film\nKd spectral a.rfl\nmap_Kd a.png\n", "mtllib none.mtl\nmtllib my room.mtl")
    )


@pytest.mark.scans
def test_the_cornell_box():
    """By its materials: walls red and green, and a lamp of radiance 17, 12, 4."""
    box = sf.Surfels.from_mesh(Path(os.environ["SURFLUX_DATA"], "scenes/cornell_mcguire/CornellBox-Original.obj"))
    glows = box.emission.any(axis=1)
    np.testing.assert_allclose(box.emission[glows], np.pi * np.array([[17, 12, 4]]), rtol=1e-6)
    shades = {tuple(rho) for rho in box.reflectance.round(3)}
    assert {(0.63, 0.065, 0.05), (0.14, 0.45, 0.091), (0.725, 0.71, 0.68)} <= shades


SQUARE = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl painted\n"


def painted(tmp_path, library, faces="f 1/1 2/2 3/3 4/4\n", places=SQUARE, name="a picture.png"):
    """The Mesh of an OBJ file with a picture whose left half is white and whose right half is red."""
    image = pytest.importorskip("PIL.Image")
    pixels = np.zeros((8, 8, 3), np.uint8)
    pixels[:, :4] = 255
    pixels[:, 4:, 0] = 255
    image.fromarray(pixels).save(tmp_path / name)
    return read_mesh(obj(tmp_path, f"newmtl painted\n{library}\n", text=places + faces))


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    ("library", "wanted"),
    [
        ("map_Kd a picture.png", [0.98, 0.49, 0.49]),
        ("Kd .5 .5 1\nmap_Kd -blendu on -s 1 1 1 -o 0 0 ./a picture.png", [0.49, 0.245, 0.49]),
        ("Kd 0 0 0\nmap_Kd textures\\a picture.png", [0.98, 0.49, 0.49]),  # as some programs write it
        ("map_Kd -s .5 1 -mm 0 1 a picture.png", [0.98, 0.98, 0.98]),
        ("map_Kd -s .5 1 -o .5 0 a picture.png", [0.98, 0.0, 0.0]),
        ("map_Kd a picture.png # baked", [0.98, 0.49, 0.49]),
        ('map_Kd "a picture.png" #baked', [0.98, 0.49, 0.49]),
        ("map_Kd a picture.png\nmap_Kd", [0.98, 0.49, 0.49]),
        ("map_Kd -s 1e999 1 a picture.png", [0.98, 0.49, 0.49]),
    ],
)
def test_a_face_has_the_mean_of_its_texture(tmp_path, library, wanted):
    """It was Kd alone, and said."""
    np.testing.assert_allclose(painted(tmp_path, library).face_reflectance(), [wanted], rtol=1e-6)


@pytest.mark.filterwarnings("error")
def test_polygons_and_relative_places(tmp_path):
    """A pentagon on white, a triangle on red by places from behind, and one whose corners have one place."""
    places = "vt .1 .5\nvt .9 .5\n"
    text = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 0 1 0\n" + places + "usemtl painted\n"
    faces = "f 1/1 2/1 3/1 4/1 5/1\nf 1/-1/7 2/-1/7 3/-1/7\nf 1/2 2/2 4/2\n"
    found = painted(tmp_path, "map_Kd a picture.png", faces, text).face_reflectance()
    np.testing.assert_allclose(found, [[0.98] * 3, [0.98, 0, 0], [0.98, 0, 0]], rtol=1e-6)


@pytest.mark.filterwarnings("error")
def test_textures_that_shine(tmp_path):
    mesh = painted(tmp_path, "Kd 0\nKe 2 2 2\nmap_Ke a picture.png")
    np.testing.assert_allclose(mesh.face_emission(), [[2 * np.pi, np.pi, np.pi]], rtol=1e-6)
    np.testing.assert_array_equal(mesh.face_reflectance(), [[0, 0, 0]])


@pytest.mark.filterwarnings("error")
def test_a_small_lamp_on_a_large_face_shines(tmp_path):
    """8 x 8 texels of 64 x 64 were between the 16 places that a triangle was looked at in: no light."""
    image = pytest.importorskip("PIL.Image")
    pixels = np.zeros((64, 64, 3), np.uint8)
    pixels[28:36, 28:36] = 255
    image.fromarray(pixels).save(tmp_path / "lamp.png")
    library = "newmtl painted\nKd .1\nKe 10 10 10\nmap_Ke lamp.png\n"
    mesh = read_mesh(obj(tmp_path, library, text=SQUARE + "f 1/1 2/2 3/3 4/4\n"))
    np.testing.assert_allclose(mesh.face_emission(), [[10 * np.pi / 64] * 3], rtol=1e-6)


def test_faces_without_a_place_on_their_texture(tmp_path):
    faces = "f 1/1 2/2 3/3\nf 1 3 4\nf 1/1 3/3 4/9\n"
    with pytest.warns(UserWarning, match=r"room\.obj: 2 faces have a texture and no place on it \(vt\); Kd and Ke"):
        mesh = painted(tmp_path, "Kd .3\nmap_Kd a picture.png", faces)
    np.testing.assert_allclose(mesh.face_reflectance()[1:], np.full((2, 3), 0.3))
    assert mesh.face_reflectance()[0, 0] == pytest.approx(0.98 * 0.3)


def test_every_face_of_a_textured_grid(tmp_path):
    image = pytest.importorskip("PIL.Image")
    n = 8
    x, y = np.meshgrid(np.arange(n + 1), np.arange(n + 1))
    text = "".join(f"v {a} {b} 0\nvt {a / n} {b / n}\n" for a, b in np.c_[x.ravel(), y.ravel()])
    corners = [[k + c for c in (1, 2, n + 3, n + 2)] for k in (j * (n + 1) + i for j in range(n) for i in range(n))]
    text += "usemtl painted\n" + "".join("f " + " ".join(f"{k}/{k}" for k in face) + "\n" for face in corners)
    pixels = np.random.default_rng(0).integers(0, 256, (n, n, 3), dtype=np.uint8)
    image.fromarray(pixels[::-1]).save(tmp_path / "a.png")  # its first row is on top
    mesh = read_mesh(obj(tmp_path, "newmtl painted\nmap_Kd a.png\n", text=text))
    wanted = 0.98 * srgb_to_linear(pixels / 255.0).reshape(-1, 3)
    np.testing.assert_allclose(mesh.face_reflectance(), wanted, atol=1e-6)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("first", range(4))
def test_the_mean_over_a_concave_face_is_by_area(tmp_path, first):
    """A chevron, .583 of which lies on white: it was .8 where it begins at an end, with what lies beyond."""
    places = "".join(f"v {x} {y} 0\nvt {y} {x}\n" for x, y in ((0, 0), (0.5, 0.4), (1, 0), (0.5, 1)))
    face = " ".join(f"{(k + first) % 4 + 1}/{(k + first) % 4 + 1}" for k in range(4))
    found = painted(tmp_path, "map_Kd a picture.png", f"f {face}\n", places + "usemtl painted\n").face_reflectance()
    assert found[0, 0] == pytest.approx(0.98)
    assert found[0, 1] == pytest.approx(0.98 * 0.583, abs=1e-3)


@pytest.mark.filterwarnings("error")
def test_pictures_of_16_bits_and_of_one_channel(tmp_path):
    image = pytest.importorskip("PIL.Image")
    grey = 0.98 * srgb_to_linear(0.5)
    for name, pixels in (
        ("a.tif", np.full((8, 8), 32768, ">u2")),
        ("b.png", np.full((8, 8), 32768, np.uint16)),
        ("c.png", np.full((8, 8), 128, np.uint8)),
        ("d.jpg", np.full((8, 8, 3), 128, np.uint8)),
        ("e.png", np.full((8, 8, 4), [128, 128, 128, 255], np.uint8)),
    ):
        image.fromarray(pixels).save(tmp_path / name)
        mesh = read_mesh(obj(tmp_path, f"newmtl painted\nmap_Kd {name}\n", text=SQUARE + "f 1/1 2/2 3/3 4/4\n"))
        np.testing.assert_allclose(mesh.face_reflectance(), [[grey] * 3], atol=3e-3)
    for name, pixels in (("f.tif", np.full((8, 8), 0.5, np.float32)), ("i.tif", np.full((8, 8), 32768, np.int32))):
        image.fromarray(pixels).save(tmp_path / name)
        path = obj(tmp_path, f"newmtl painted\nmap_Kd {name}\n", text=SQUARE + "f 1/1 2/2 3/3 4/4\n")
        with pytest.warns(
            UserWarning, match=rf"texture '.*{name}' is not read \(ValueError: a texture of mode [FI]; wanted"
        ):
            read_mesh(path)  # was white or black


def test_colours_of_vertices_count_where_a_texture_is_missing(tmp_path):
    colored = "".join(f"v {x} {y} 0 1 0 0\n" for x, y in ((0, 0), (1, 0), (1, 1))) + "vt 0 0\nusemtl painted\n"
    with pytest.warns(UserWarning, match=r"'gone\.png' is not there; colours of vertices, Kd and Ke alone count there"):
        mesh = read_mesh(obj(tmp_path, "newmtl painted\nmap_Kd gone.png\n", text=colored + "f 1/1 2/1 3/1\n"))
    np.testing.assert_allclose(mesh.face_reflectance(), [[0.98, 0, 0]])
