"""Textures on faces: their means over triangles, and materials of trimesh."""

import numpy as np
import pytest

import surflux as sf
from squares import SQUARE, TWO, two_triangles
from surflux._base.color import WHITE, srgb_to_linear
from surflux.meshes import texel_means
from surflux.meshes.reading import read_mesh
from surflux.meshes.texel_means import mean_texels
from surflux.meshes.textures import Texture

GREY = WHITE * srgb_to_linear(188 / 255)  # of an 8-bit 188: about half of white
JOINTS = np.full((60, 60, 3), 230, np.uint8)  # light ones
JOINTS[3:-3, 3:-3] = 60
HALVES = SQUARE[:, :2][TWO]  # of a whole texture


def texture(height, width):
    pixels = np.random.default_rng(height).integers(0, 256, (height, width, 3), dtype=np.uint8)
    return Texture(pixels, srgb_to_linear(np.arange(256) / 255.0))


def means_of_places(texture, corners, n=300):
    """(f, 3): means of n^2 places on each triangle, in an even lattice."""
    a, b = ((np.mgrid[0:n, 0:n] + 0.5) / n).reshape(2, -1)
    over = a + b > 1.0
    a, b = np.where(over, 1.0 - a, a), np.where(over, 1.0 - b, b)
    places = (1.0 - a - b)[:, None] * corners[:, :1] + a[:, None] * corners[:, 1:2] + b[:, None] * corners[:, 2:]
    height, width = texture.pixels.shape[:2]
    column = np.floor(places[:, :, 0] * width).astype(int) % width
    row = np.floor((1.0 - places[:, :, 1]) * height).astype(int) % height
    return texture.linear[texture.pixels[row, column]].mean(axis=1)


@pytest.mark.parametrize("size", [0.01, 0.1, 0.6, 3.0])
@pytest.mark.parametrize("shape", [(7, 5), (50, 64), (1, 9), (9, 1)])
def test_means_are_by_area(shape, size):
    rng = np.random.default_rng(1)
    corners = size * rng.normal(size=(8, 3, 2)) + 3.0 * rng.normal(size=(8, 1, 2))
    image = texture(*shape)
    np.testing.assert_allclose(mean_texels(image, corners), means_of_places(image, corners), atol=4e-3)


@pytest.mark.parametrize("repeats", [1, 3, [4, 0.5], 12, 24, [1, 1000], [1000, 1], 1000, 30000])
def test_the_mean_over_whole_repeats_is_that_of_the_texture(repeats):
    """A dark tile with light joints was all joints where a quad has 12 of them, and had none where it has 10."""
    tile = Texture(JOINTS, srgb_to_linear(np.arange(256) / 255.0))
    found = mean_texels(tile, HALVES * repeats).mean(axis=0)
    np.testing.assert_allclose(found, tile.linear[JOINTS].mean(axis=(0, 1)), rtol=1e-3)


def test_bands_and_rows_together_change_little(monkeypatch):
    """As of large textures, and of many triangles that have many rows each."""
    rng = np.random.default_rng(2)
    corners = rng.normal(size=(40, 3, 2))
    image = texture(70, 30)
    exact = mean_texels(image, corners)
    monkeypatch.setattr(texel_means, "_TEXELS", 300)
    monkeypatch.setattr(texel_means, "_AT_ONCE", 100)
    np.testing.assert_allclose(mean_texels(image, corners), exact, atol=1e-9)
    monkeypatch.setattr(texel_means, "_OF_ALL", 100)
    np.testing.assert_allclose(mean_texels(image, corners), exact, atol=0.02)


def test_faces_without_an_area_on_the_texture():
    """All corners at one texel, as on a palette; corners in a line; and what no file should have."""
    image = texture(8, 8)
    line = np.array([[0.0, 0.3], [0.5, 0.3], [1.0, 0.3]])
    point, broken = np.full((3, 2), 0.4), np.full((3, 2), np.nan)
    found = mean_texels(image, np.array([point, line, broken]))
    np.testing.assert_allclose(found[0], image.linear[image.pixels[4, 3]], atol=1e-9)
    tent = [1, 3, 5, 7, 7, 5, 3, 1]  # as of a triangle that is ever flatter
    np.testing.assert_allclose(found[1], np.average(image.linear[image.pixels[5]], axis=0, weights=tent), atol=0.01)
    assert np.all(np.isfinite(found[2]))
    assert mean_texels(image, np.zeros((0, 3, 2))).shape == (0, 3)


def test_halves_of_one_mean_are_one_patch():
    image = pytest.importorskip("PIL.Image").fromarray(JOINTS)
    from trimesh.visual.material import SimpleMaterial

    assert len(sf.Surfels.from_mesh(two_triangles(uv=7.0 * SQUARE[:, :2], material=SimpleMaterial(image=image)))) == 1


def test_textures_of_trimesh():
    """Each half of the square has its half of the picture; v goes up, so row 0 is at v = 1."""
    image_module = pytest.importorskip("PIL.Image")
    from trimesh.visual.material import PBRMaterial, SimpleMaterial

    pixels = np.zeros((2, 2, 3), np.uint8)
    pixels[0] = [255, 0, 0]  # v above a half
    pixels[1] = [0, 0, 188]
    image = image_module.fromarray(pixels)
    halves = np.array([[0, 0, 0], [1, 0, 0], [1, 0.5, 0], [0, 0.5, 0], [1, 1, 0], [0, 1, 0]], float)
    faces = [[0, 1, 2], [0, 2, 3], [3, 2, 4], [3, 4, 5]]
    lower, upper = [0, 0, GREY], [WHITE, 0, 0]

    def reflectance(material, uv=halves[:, :2]):
        trimesh = pytest.importorskip("trimesh")
        mesh = trimesh.Trimesh(halves, faces, process=False)
        mesh.visual = trimesh.visual.TextureVisuals(uv=uv, material=material)
        return read_mesh(mesh).face_reflectance()

    np.testing.assert_allclose(reflectance(SimpleMaterial(image=image)), [lower, lower, upper, upper])
    # It repeats itself, in u and v.
    again = reflectance(SimpleMaterial(image=image), halves[:, :2] + [3, -2])
    np.testing.assert_allclose(again, [lower, lower, upper, upper])
    # The colour of glTF's material is linear, and multiplies.
    tinted = reflectance(PBRMaterial(baseColorTexture=image, baseColorFactor=[51, 255, 255, 255]))
    np.testing.assert_allclose(tinted, [lower, lower, [0.2 * WHITE, 0, 0], [0.2 * WHITE, 0, 0]])
    np.testing.assert_allclose(reflectance(PBRMaterial(baseColorFactor=[51, 255, 0, 255])), [[0.2, WHITE, 0]] * 4)
    np.testing.assert_allclose(reflectance(SimpleMaterial(diffuse=[255, 51, 0])), [[WHITE, 0.2, 0]] * 4)  # Kd: linear
    np.testing.assert_array_equal(reflectance(SimpleMaterial()), [[0.5] * 3] * 4)  # nobody has said anything


def test_a_face_has_the_linear_mean_of_its_texture():
    """The left half of the picture is white, where a quarter of the lower triangle lies and three of the upper one.

    Of light, not of sRGB.
    """
    image_module = pytest.importorskip("PIL.Image")
    from trimesh.visual.material import SimpleMaterial

    pixels = np.zeros((4, 4), np.uint8)
    pixels[:, :2] = 255
    mesh = two_triangles(uv=SQUARE[:, :2], material=SimpleMaterial(image=image_module.fromarray(pixels)))
    found = read_mesh(mesh).face_reflectance()
    np.testing.assert_allclose(found, [[WHITE / 4] * 3, [WHITE * 3 / 4] * 3])
    deep = image_module.fromarray((pixels.astype(np.uint16) // 255) * 65535)
    sixteen = two_triangles(uv=SQUARE[:, :2], material=SimpleMaterial(image=deep))
    np.testing.assert_allclose(read_mesh(sixteen).face_reflectance(), found)


def on_disk(folder, library, faces="f 1/1 2/2 3/3 4/4\n"):
    """The path of an OBJ file of a square with a picture, half of it white."""
    image = pytest.importorskip("PIL.Image")
    pixels = np.zeros((4, 4, 3), np.uint8)
    pixels[:, :2] = 255
    image.fromarray(pixels).save(folder / "a.png")
    (folder / "a.mtl").write_text(library)
    places = "".join(f"v {x:g} {y:g} 0\nvt {x:g} {y:g}\n" for x, y in SQUARE[:, :2])
    (folder / "a.obj").write_text(f"mtllib a.mtl\n{places}usemtl one\n{faces}")
    return folder / "a.obj"


@pytest.mark.parametrize(
    "library",
    [
        "Kd .3 .6 .1",
        "Kd .4 .4 .4",  # which is what trimesh takes where a file says nothing
        "Kd .001 0 0",  # less than an 8-bit step
        "Kd 0 0 0",
        "Ns 3",
        "Kd .3 .6 .1\nmap_Kd a.png",
        "Kd .4 .4 .4\nmap_Kd a.png",
        "Kd 0 0 0\nmap_Kd a.png",
        "map_Kd a.png",
    ],
)
def test_materials_of_obj_files_are_the_same_through_trimesh(tmp_path, library):
    """Kd .3 .6 .1 was .071 .312 .010, as if it were sRGB, and was left out where there is a picture."""
    trimesh = pytest.importorskip("trimesh")
    path = on_disk(tmp_path, f"newmtl one\n{library}\n")
    found = sf.Surfels.from_mesh(trimesh.load(path, process=False))
    wanted = sf.Surfels.from_mesh(path).reflectance
    np.testing.assert_allclose(np.average(found.reflectance, axis=0, weights=found.areas), wanted[0], atol=1e-7)


def test_what_was_changed_since_it_was_read_counts(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    mesh = trimesh.load(on_disk(tmp_path, "newmtl one\nKd .3 .6 .1\n"), process=False)
    mesh.visual.material.diffuse = np.array([51, 102, 0, 255], np.uint8)
    np.testing.assert_allclose(sf.Surfels.from_mesh(mesh).reflectance, [[0.2, 0.4, 0.0]], rtol=1e-6)


def test_several_materials_of_one_file_through_trimesh(tmp_path):
    """A scene, of which trimesh makes one picture that has its colours as sRGB."""
    trimesh = pytest.importorskip("trimesh")
    library = "newmtl one\nKd .3 .6 .1\nnewmtl two\nKd .5 .1 .2\nmap_Kd a.png\n"
    path = on_disk(tmp_path, library, "f 1/1 2/2 3/3\nusemtl two\nf 1/1 3/3 4/4\n")
    scene = trimesh.load(path, process=False)
    assert len(scene.geometry) == 2
    found, wanted = sf.Surfels.from_mesh(scene), sf.Surfels.from_mesh(path)
    order = np.argsort(found.reflectance[:, 0])
    np.testing.assert_allclose(found.reflectance[order], wanted.reflectance[np.argsort(wanted.reflectance[:, 0])])


def test_repeats_and_factors_of_parts_of_gltf(tmp_path):
    """A textured square beside another part was black: trimesh had made one picture of both, without repeats."""
    trimesh = pytest.importorskip("trimesh")
    from trimesh.visual.material import PBRMaterial

    image = pytest.importorskip("PIL.Image")
    pixels = np.zeros((4, 4, 3), np.uint8)
    pixels[1:3, 1:3] = 255
    tiled = PBRMaterial(baseColorTexture=image.fromarray(pixels), baseColorFactor=[51, 255, 255, 255])
    plain = PBRMaterial(baseColorFactor=[255, 51, 0, 255])
    parts = [two_triangles(uv=k * SQUARE[:, :2], material=one) for k, one in ((4, tiled), (1, plain))]
    parts[1].apply_translation([0, 0, 1])
    scene = trimesh.Scene(parts)
    scene.export(tmp_path / "a.glb")
    for mesh in (scene, tmp_path / "a.glb"):
        found = sf.Surfels.from_mesh(mesh)
        assert len(found) == 2
        lower = found.reflectance[np.argsort(found.points[:, 2])]
        wanted = [[0.05 * WHITE, 0.25 * WHITE, 0.25 * WHITE], [WHITE, 0.2, 0.0]]
        np.testing.assert_allclose(lower, wanted, rtol=1e-6)


PICTURE = np.random.default_rng(7).integers(0, 256, (64, 64, 3), dtype=np.uint8)
LINEAR = WHITE * srgb_to_linear(PICTURE / 255.0)
PLACES = 4000
AS_ARE, CROSSED = "f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n", "f 1/1 2/2 3/3\nf 1/3 3/2 4/1\n"


def with_picture(folder, library, faces):
    path = on_disk(folder, library, faces)
    pytest.importorskip("PIL.Image").fromarray(PICTURE).save(folder / "a.png")
    return path


def through_trimesh(path):
    return pytest.importorskip("trimesh").load(path, process=False)


def at_places(s, on_picture=lambda x, y: (x, y)):
    """(n, 3): the mean of the picture over the patches of Surfels on the unit square, from many places on each."""
    rng, total = np.random.default_rng(0), np.zeros((len(s), 3))
    corners, of = s.triangles, s.triangle_surfel
    share = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    share /= s.areas[of]
    for _ in range(PLACES):
        a, b = rng.random((2, len(corners), 1))
        a, b = np.where(a + b > 1, 1 - a, a), np.where(a + b > 1, 1 - b, b)
        x, y, _ = ((1 - a - b) * corners[:, 0] + a * corners[:, 1] + b * corners[:, 2]).T
        u, v = on_picture(x, y)
        texels = LINEAR[((1 - v) * 64).astype(int) % 64, (u * 64).astype(int) % 64]
        total += np.stack([np.bincount(of, share * channel, len(s)) for channel in texels.T], axis=1)
    return total / PLACES


@pytest.mark.parametrize("faces", ["f 1/1 2/2 3/3 4/4\n", AS_ARE])
@pytest.mark.parametrize("through", [lambda path: path, through_trimesh])
def test_parts_of_a_face_have_what_of_its_texture_is_there(tmp_path, faces, through):
    """All patches of a face had its mean: a floor of two triangles had two colours, however finely it was cut."""
    mesh = through(with_picture(tmp_path, "newmtl one\nmap_Kd a.png\n", faces))
    s = sf.Surfels.from_mesh(mesh, patch_area=1 / 50)
    assert len(s) >= 50
    assert s.reflectance.std(axis=0).min() > 0.02
    np.testing.assert_allclose(s.reflectance, at_places(s), atol=0.025)
    np.testing.assert_allclose(np.average(s.reflectance, axis=0, weights=s.areas), LINEAR.mean(axis=(0, 1)), rtol=1e-6)
    # Given reflectance counts, also that of faces.
    assert np.all(sf.Surfels.from_mesh(mesh, patch_area=1 / 50, reflectance=0.3).reflectance == 0.3)


def test_parts_shine_as_their_texture_does(tmp_path):
    path = with_picture(tmp_path, "newmtl one\nKd .2 .2 .2\nKe 2 4 8\nmap_Ke a.png\n", "f 1/1 2/2 3/3 4/4\n")
    s = sf.Surfels.from_mesh(path, patch_area=1 / 64)
    wanted = np.pi * np.array([2, 4, 8]) / WHITE * LINEAR.reshape(8, 8, 8, 8, 3).mean(axis=(1, 3))
    column, row = (s.points[:, :2].T * 8).astype(int)
    np.testing.assert_allclose(s.emission, wanted[7 - row, column], rtol=1e-6)
    assert np.all(s.reflectance == 0.2)
    assert np.all(sf.Surfels.from_mesh(path, patch_area=1 / 64, emission=1.0).emission == 1.0)


def test_points_on_a_face_have_what_of_its_texture_is_there(tmp_path):
    """Each had the mean of its face. Of a picture finer than their spacing each has some texels."""
    path = with_picture(tmp_path, "newmtl one\nmap_Kd a.png\n", AS_ARE)
    coarse = np.repeat(np.repeat(PICTURE[:8, :8], 8, axis=0), 8, axis=1)
    pytest.importorskip("PIL.Image").fromarray(coarse).save(tmp_path / "a.png")
    s = sf.Surfels.sample_mesh(path, 4000)
    column, row = (s.points[:, :2].T * 8).astype(int)
    wanted = WHITE * srgb_to_linear(PICTURE[7 - row, column] / 255.0)
    assert np.mean(np.abs(s.reflectance - wanted).max(axis=1) < 1e-6) > 0.7  # the others are beside a border
    few = sf.Surfels.sample_mesh(with_picture(tmp_path, "newmtl one\nmap_Kd a.png\n", AS_ARE), 40)
    assert few.reflectance.std() < 0.6 * LINEAR.std()
    np.testing.assert_allclose(few.reflectance.mean(axis=0), LINEAR.mean(axis=(0, 1)), atol=0.06)


def test_triangles_with_another_part_of_the_picture_stay_apart(tmp_path):
    """Both have the same half of the picture and so the same mean: as one quadrilateral the first would go on."""
    library = "newmtl one\nmap_Kd a.png\n"
    assert len(sf.Surfels.from_mesh(with_picture(tmp_path, library, CROSSED))) == 2
    s = sf.Surfels.from_mesh(tmp_path / "a.obj", patch_area=1 / 50)
    lower = s.points[:, 1] < s.points[:, 0]
    np.testing.assert_allclose(s.reflectance[lower], at_places(s)[lower], atol=0.025)
    upper = at_places(s, lambda x, y: (1.0 + x - y, 1.0 - y))
    np.testing.assert_allclose(s.reflectance[~lower], upper[~lower], atol=0.025)


def test_faces_that_are_turned_over_keep_their_texture(tmp_path):
    """As `orient` in a scene file, and the command, turn over what is wound against the others."""
    faces = "f 1/1 2/2 3/3\nf 1/1 4/4 3/3\n"
    path = with_picture(tmp_path, "newmtl one\nmap_Kd a.png\n", faces)
    scene = tmp_path / "scene.toml"
    scene.write_text('[[object]]\nfile = "a.obj"\nkind = "mesh"\norient = true\npatch_area = 0.02\n')
    s = sf.load_scene(scene).surfels
    assert np.ptp(s.normals[:, 2]) == 0.0
    np.testing.assert_allclose(s.reflectance, at_places(s), atol=0.025)
    assert path.exists()


def test_half_of_a_picture_is_no_whole_repeat(tmp_path):
    """Places that jump by 1 where -s .5 makes half a picture of it: the second triangle had the other half."""
    jump = "vt 1 0\nvt 2 1\nvt 1 1\nf 1/1 2/2 3/3\nf 1/5 3/6 4/7\n"
    path = with_picture(tmp_path, "newmtl one\nmap_Kd -s .5 1 1 a.png\n", jump)
    s = sf.Surfels.from_mesh(path, patch_area=1 / 50)
    lower = s.points[:, 1] < s.points[:, 0]
    for part, shift in ((lower, 0.0), (~lower, 0.5)):
        wanted = at_places(s, lambda x, y, shift=shift: (0.5 * x + shift, y))
        np.testing.assert_allclose(s.reflectance[part], wanted[part], atol=0.025)


def test_a_picture_of_many_materials_is_read_once(tmp_path, monkeypatch):
    from surflux.meshes import obj_textures

    library = "".join(f"newmtl m{k}\nKd .{k + 1} .5 .5\nmap_Kd a.png\n" for k in range(4))
    faces = "".join(f"usemtl m{k}\nf 1/1 2/2 3/3 4/4\n" for k in range(4))
    path = with_picture(tmp_path, library, faces)
    read, times = obj_textures.read_texture, []
    monkeypatch.setattr(obj_textures, "read_texture", lambda file: times.append(file) or read(file))
    sf.Surfels.from_mesh(path, patch_area=1 / 10)
    assert len(times) == 2  # once for faces, once for their parts
