"""Textures of glTF files: where their images are, where they lie on faces, and what is told of those that are not."""

import numpy as np
import pytest

import surflux as sf
from gltf_squares import UPRIGHT, Square, data_uri, png
from surflux.meshes import gltf_textures
from surflux.meshes.reading import read_mesh

pytest.importorskip("PIL.Image")
QUARTERS = [[[255, 255, 255], [255, 0, 0]], [[0, 255, 0], [0, 0, 255]]]
GREY, OF_GREY = np.full((4, 4, 3), 128), 0.98 * 0.21586


@pytest.mark.parametrize("kind", ["<f4", "u1", "<u2"])
def test_places_of_integers_are_fractions(tmp_path, kind):
    """They were up to 65535 repeats of the texture, of which each face had the mean."""
    places = 0.4 * UPRIGHT
    if kind != "<f4":
        places = np.rint(places * np.iinfo(kind).max).astype(kind)
    mesh = read_mesh(Square(QUARTERS, places=places).save(tmp_path / "a.gltf"))
    np.testing.assert_allclose(mesh.face_reflectance(), 0.98)


@pytest.mark.parametrize("uri", ["my tex.png", "my%20tex.png", "a/..\\my%20tex.png"])
def test_images_beside_the_file(tmp_path, uri):
    (tmp_path / "a").mkdir()
    (tmp_path / "my tex.png").write_bytes(png(GREY))
    square = Square(QUARTERS)
    square.header["images"] = [{"uri": uri}]
    np.testing.assert_allclose(read_mesh(square.save(tmp_path / "a.gltf")).face_reflectance(), OF_GREY, atol=1e-5)


def test_images_in_buffers_and_extensions(tmp_path):
    square = Square(QUARTERS)
    data = np.frombuffer(png(GREY), np.uint8)
    square.header["images"] = [{"bufferView": square.view(data), "mimeType": "image/png"}]
    square.header["textures"] = [{"extensions": {"EXT_texture_webp": {"source": 0}}}]
    np.testing.assert_allclose(read_mesh(square.save(tmp_path / "a.gltf")).face_reflectance(), OF_GREY, atol=1e-5)


@pytest.mark.parametrize(
    ("image", "said"),
    [
        ({"uri": "missing.png"}, "'missing.png' of material m is not there"),
        ({"uri": data_uri(b"broken")}, "'image 0' of material m is not read (no image that Pillow knows)"),
        ({"bufferView": 99, "name": "sky"}, "'sky' of material m is not read (the index of bufferViews is 99"),
        ({"uri": "/etc/passwd"}, "'/etc/passwd' of material m is not read (wanted a file beside it"),
        (None, "of material m is not read (it has no source)"),
    ],
)
def test_what_is_no_image_is_told(tmp_path, image, said):
    """Nothing was said: the face was white."""
    square = Square(QUARTERS, emissiveFactor=[1, 1, 1], emissiveTexture={"index": 0})
    square.material["pbrMetallicRoughness"]["baseColorFactor"] = [0.3, 0.3, 0.3, 1]
    if image is None:
        square.header["textures"] = [{}]
    else:
        square.header["images"] = [image]
    with pytest.warns(UserWarning, match="texture") as told:
        mesh = read_mesh(square.save(tmp_path / "a.gltf"))
    assert len(told) == 1
    assert str(told[0].message).startswith(f"{tmp_path / 'a.gltf'}: texture {said}")
    assert str(told[0].message).endswith("; factors alone count there")
    np.testing.assert_allclose(mesh.face_reflectance(), 0.3)
    np.testing.assert_allclose(mesh.face_emission(), np.pi)


def test_faces_without_a_place_are_told(tmp_path):
    square = Square(QUARTERS, places=None)
    square.header["nodes"] = [{"mesh": 0, "children": [1]}, {"mesh": 0, "translation": [2, 0, 0]}]
    said = r"a\.gltf: 4 faces of material m have a texture and no place on it \(TEXCOORD_0\); factors alone count there"
    with pytest.warns(UserWarning, match=said):
        mesh = read_mesh(square.save(tmp_path / "a.gltf"))
    np.testing.assert_allclose(mesh.face_reflectance(), 0.98)


def test_nodes_share_their_texture(tmp_path, monkeypatch):
    """Each had a copy of its own."""
    decode, times = gltf_textures.decoded_texture, []
    monkeypatch.setattr(gltf_textures, "decoded_texture", lambda *given: times.append(given) or decode(*given))
    square = Square(QUARTERS)
    square.header["nodes"] = [{"mesh": 0, "translation": [2 * k, 0, 0]} for k in range(5)]
    square.header["scenes"][0]["nodes"] = list(range(5))
    mesh = read_mesh(square.save(tmp_path / "a.gltf"))
    assert (len(times), len(mesh.textures)) == (1, 1)
    np.testing.assert_array_equal(mesh.textures[0].faces, np.arange(10))
    found = sf.Surfels.from_mesh(tmp_path / "a.gltf", patch_area=0.02)
    for k in range(5):
        some = (found.points[:, 0] > 2 * k) & (found.points[:, 0] < 2 * k + 0.45) & (found.points[:, 1] > 0.55)
        np.testing.assert_allclose(found.reflectance[some], 0.98, atol=1e-6)
        assert some.any()


def test_mirrored_faces_keep_their_places(tmp_path):
    square = Square(QUARTERS)
    square.header["nodes"] = [{"mesh": 0, "scale": [-1, 1, 1]}]
    found = sf.Surfels.from_mesh(square.save(tmp_path / "a.gltf"), patch_area=0.01)
    inside = (np.abs(found.points[:, :2] - [-0.5, 0.5]) > 0.1).all(axis=1)
    x, y = found.points[inside, :2].T
    wanted = 0.98 / 255 * np.array(QUARTERS)[(y < 0.5).astype(int), (x < -0.5).astype(int)]
    np.testing.assert_allclose(found.reflectance[inside], wanted, atol=1e-6)
    assert (found.normals[:, 2] > 0.9).all()


@pytest.mark.parametrize(("sampler", "seen"), [({"magFilter": 9728}, [0, 0.98, 0]), ({"magFilter": 9729}, None)])
def test_pictures_show_the_nearest_texel_where_a_sampler_says_so(tmp_path, sampler, seen):
    """A face that lies on green, near red, was drawn as a mixture."""
    row = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 255]]
    square = Square([row, row], places=np.full((4, 2), [0.27, 0.5], "<f4"))
    square.header["samplers"] = [sampler]
    square.header["textures"][0]["sampler"] = 0
    surfels = sf.Surfels.from_mesh(square.save(tmp_path / "a.gltf"))
    np.testing.assert_allclose(surfels.reflectance, [[0, 0.98, 0]] * len(surfels), atol=1e-6)
    camera = sf.Camera([0.5, 0.5, 5], [0.5, 0.5, 0], [0, 1, 0], height=1)
    picture = sf.solve(sf.Scene([surfels], [sf.Environment(1.0)]), rays=16).render(camera, (8, 8), layers=["albedo"])
    if seen is None:
        assert picture["albedo"][4, 4].min(initial=1.0, where=[True, True, False]) > 0.1
    else:
        np.testing.assert_allclose(picture["albedo"][1:-1, 1:-1].reshape(-1, 3), [seen] * 36, atol=1e-6)


def test_far_off_the_nearest_texel_is_no_longer_seen(tmp_path):
    square = Square(QUARTERS, places=64 * UPRIGHT)
    square.header["samplers"] = [{"magFilter": 9728}]
    square.header["textures"][0]["sampler"] = 0
    surfels = sf.Surfels.from_mesh(square.save(tmp_path / "a.gltf"))
    camera = sf.Camera([0.5, 0.5, 5], [0.5, 0.5, 0], [0, 1, 0], height=1)
    picture = sf.solve(sf.Scene([surfels], [sf.Environment(1.0)]), rays=16).render(camera, (8, 8), layers=["albedo"])
    np.testing.assert_allclose(picture["albedo"][1:-1, 1:-1].reshape(-1, 3), [[0.49] * 3] * 36, rtol=0.02)
