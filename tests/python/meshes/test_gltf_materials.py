"""Materials of glTF 2.0: colours are factor times texture times COLOR_0, light factor times texture times strength."""

import io

import numpy as np
import pytest

import surflux as sf
from gltf_samples import glb, glb_parts
from surflux.meshes.reading import read_mesh

trimesh = pytest.importorskip("trimesh")
PIL = pytest.importorskip("PIL.Image")
CORNERS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], "<f4")


def written(path, material=None, colors=None, texture=None, **light):
    """A square; material: its pbrMetallicRoughness, or None, and `light`, what else it has. colors: of all corners, or
    of each, of any type. texture: (h, w, 3) bytes."""
    arrays = {"POSITION": CORNERS, "indices": np.array([0, 1, 2, 0, 2, 3], "<u2")[:, None]}
    arrays["TEXCOORD_0"] = np.array([[0.05, 0.05], [0.45, 0.05], [0.45, 0.45], [0.05, 0.45]], "<f4")
    if colors is not None:
        arrays["COLOR_0"] = colors if np.ndim(colors) == 2 else np.tile(colors, (4, 1))
    kinds = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
    components = {"f4": 5126, "u1": 5121, "u2": 5123}
    data, views, accessors, at = b"", [], [], {}
    for name, array in arrays.items():
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": array.nbytes})
        data += array.tobytes() + b"\0" * (-array.nbytes % 4)
        accessor = {"bufferView": len(accessors), "count": len(array), "type": kinds[array.shape[1]]}
        accessor["componentType"] = components[array.dtype.str[1:]]
        if name == "COLOR_0" and array.dtype.kind == "u":
            accessor["normalized"] = True
        if name == "POSITION":
            accessor |= {"min": [0, 0, 0], "max": [1, 1, 0]}
        at[name] = len(accessors)
        accessors.append(accessor)
    indices = at.pop("indices")
    primitive = {"attributes": at, "indices": indices}
    header = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}]}
    header |= {"meshes": [{"primitives": [primitive]}], "accessors": accessors, "bufferViews": views}
    if material is not None:
        primitive["material"] = 0
        header["materials"] = [{"pbrMetallicRoughness": material, **light}]
    if texture is not None:
        png = io.BytesIO()
        PIL.fromarray(texture).save(png, "PNG")
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(png.getvalue())})
        data += png.getvalue()
        header |= {"textures": [{"source": 0}], "images": [{"bufferView": len(views) - 1, "mimeType": "image/png"}]}
    header["buffers"] = [{"byteLength": len(data)}]
    path.write_bytes(glb(header, data))
    return path


def reflectance(path):
    of_file = sf.Surfels.from_mesh(path).reflectance[0]
    of_trimesh = sf.Surfels.from_mesh(trimesh.load(path)).reflectance[0]
    np.testing.assert_allclose(of_trimesh, of_file, atol=0.51 / 255)  # which has 8 bits of factors
    return of_file / 0.98


FLOATS = np.array([0.5, 0.2, 0.1], "<f4")
FACTOR = {"baseColorFactor": [0.8, 0.4, 0.2, 1]}


@pytest.mark.parametrize(
    ("material", "colors", "wanted"),
    [
        (None, FLOATS, [0.5, 0.2, 0.1]),
        (None, np.rint(255 * FLOATS).astype("u1"), [0.5, 0.2, 0.1]),
        ({}, None, [1, 1, 1]),
        ({}, FLOATS, [0.5, 0.2, 0.1]),
        ({}, np.rint(65535 * FLOATS).astype("<u2"), [0.5, 0.2, 0.1]),
        (FACTOR, None, np.array([0.8, 0.4, 0.2]) / 0.98),  # reflectance as it is, as Kd of OBJ
        (FACTOR, np.array([0.5, 0.5, 0.5], "<f4"), [0.4, 0.2, 0.1]),
    ],
)
def test_colours_are_linear_and_multiply(tmp_path, material, colors, wanted):
    """COLOR_0 was decoded as sRGB, or dropped beside a material; a white material said nothing (.5)."""
    found = reflectance(written(tmp_path / "square.glb", material, colors))
    np.testing.assert_allclose(found, wanted, atol=0.002)  # of 8 bits


@pytest.mark.parametrize("dark", [0.05, 0.002, 0.001])
def test_dark_colours_keep_their_digits(tmp_path, dark):
    """In 8 bits .002 becomes .0039, and .001 none."""
    path = written(tmp_path / "dark.glb", {"baseColorFactor": [dark, 2 * dark, 0.5, 1]})
    np.testing.assert_allclose(0.98 * reflectance(path), [dark, 2 * dark, 0.5], rtol=1e-12)


def test_colours_multiply_textures(tmp_path):
    quarters = np.zeros((8, 8, 3), np.uint8)
    quarters[:4, :4] = [255, 0, 255]
    material = {"baseColorTexture": {"index": 0}, "baseColorFactor": [0.8, 0.8, 0.8, 1]}
    found = reflectance(written(tmp_path / "square.glb", material, FLOATS, quarters))
    np.testing.assert_allclose(found, [0.4, 0.0, 0.08], atol=0.004)


def strength(value):
    return {"extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": value}}}


def test_faces_send_what_a_material_says(tmp_path):
    """emissiveFactor is radiance: a face sends pi times as much, by its strength."""
    factor = {"emissiveFactor": [1.0, 0.5, 0.25]}
    for light, wanted in ((factor, 1.0), (factor | strength(12.5), 12.5), (strength(12.5), 0.0)):
        found = sf.Surfels.from_mesh(written(tmp_path / "lamp.glb", {}, **light))
        np.testing.assert_allclose(found.emission[0], wanted * np.pi * np.array([1.0, 0.5, 0.25]), rtol=1e-6)
        np.testing.assert_allclose(found.reflectance[0], 0.98)
    own = sf.Surfels.from_mesh(tmp_path / "lamp.glb", emission=2.0)
    np.testing.assert_allclose(own.emission, 2.0)
    # In memory there is no strength.
    np.testing.assert_allclose(
        sf.Surfels.from_mesh(trimesh.load(written(tmp_path / "lamp.glb", {}, **factor))).emission[0, 0], np.pi
    )


def test_textures_send_light_where_they_are(tmp_path):
    """Half of a square: its patches have their parts; the other part of the file has none."""
    halves = np.zeros((64, 64, 3), np.uint8)
    halves[:, :16] = 255
    light = {"emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 0}} | strength(3.0)
    lamp = written(tmp_path / "lamp.glb", {"baseColorFactor": [0.5, 0.5, 0.5, 1]}, None, halves, **light)
    cut = sf.Surfels.from_mesh(lamp, patch_area=1 / 64)
    x = cut.points[:, 0]
    np.testing.assert_allclose(cut.emission[x < 0.4], 3 * np.pi, rtol=1e-6)
    np.testing.assert_allclose(cut.emission[x > 0.6], 0.0)
    np.testing.assert_allclose(cut.reflectance, 0.5, atol=0.002)
    both = trimesh.Scene([trimesh.load(lamp), trimesh.creation.box(bounds=[[3, 0, 0], [4, 1, 1]])])
    whole = sf.Surfels.from_mesh(both)
    np.testing.assert_allclose((whole.emission * whole.areas[:, None]).sum(axis=0), np.pi * 0.5, rtol=1e-6)
    assert np.all(whole.points[whole.emission.any(axis=1), 0] < 1)


def test_strengths_alone_tell_materials_apart(tmp_path):
    lamp = written(tmp_path / "lamp.glb", {}, emissiveFactor=[1, 1, 1], name="lamp", **strength(2.0))
    header, data = glb_parts(lamp.read_bytes())
    header["materials"].append(header["materials"][0] | strength(3.0))
    header["meshes"][0]["primitives"].append(header["meshes"][0]["primitives"][0] | {"material": 1})
    lamp.write_bytes(glb(header, data))
    np.testing.assert_allclose(read_mesh(lamp).face_emission()[:, 0], np.pi * np.array([2, 2, 3, 3]))


@pytest.mark.parametrize("value", [-1.0, 1e31, "bright"])
def test_strengths_that_are_none_are_refused(tmp_path, value):
    lamp = written(tmp_path / "lamp.glb", {}, emissiveFactor=[1, 1, 1], **strength(value))
    with pytest.raises(
        sf.FileError, match=r"^\S*lamp\.glb: emissiveStrength is .*; wanted a finite number of at least 0"
    ):
        sf.Surfels.from_mesh(lamp)


def test_elements_that_are_none_count_as_missing(tmp_path):
    written(tmp_path / "a.glb", {}, emissiveTexture=None, extensions=None, emissiveFactor=None)
    assert not sf.Surfels.from_mesh(tmp_path / "a.glb").emission.any()


def test_colours_of_corners_go_on_in_parts_and_beside_materials(tmp_path):
    """Of several meshes all had those of their faces, two shades of a square."""
    shades = np.array([[0, 0, 0], [1, 1, 1], [1, 1, 1], [0, 0, 0]], "<f4")
    square = written(tmp_path / "square.glb", {}, shades)
    both = trimesh.Scene([trimesh.load(square), trimesh.creation.box(bounds=[[3, 0, 0], [4, 1, 1]])])
    for mesh in (square, both):
        cut = sf.Surfels.from_mesh(mesh, patch_area=1 / 64)
        x = cut.points[:, 0]
        np.testing.assert_allclose(cut.reflectance[x < 1, 0], 0.98 * x[x < 1], atol=1e-6)


@pytest.mark.parametrize(
    ("texture", "said"),
    [
        ({"texCoord": 1}, "texCoord is not read of textures"),
        ({"extensions": {"KHR_texture_transform": {"offset": [0.5, 0]}}}, "KHR_texture_transform is not read"),
    ],
)
def test_what_is_not_read_of_textures_is_told(tmp_path, texture, said):
    picture = np.full((8, 8, 3), 200, np.uint8)
    path = written(tmp_path / "square.glb", {"baseColorTexture": {"index": 0, **texture}}, None, picture)
    with pytest.warns(UserWarning, match=rf"square\.glb: {said}"):
        sf.Surfels.from_mesh(path)


def test_colours_of_16_bits_without_a_material(tmp_path):
    """trimesh takes the lower 8 bits: .5 becomes 0."""
    path = written(tmp_path / "square.glb", None, np.array([32768, 13107, 6554], "<u2"))
    np.testing.assert_allclose(read_mesh(path).reflectance[0], [0.49, 0.196, 0.098], atol=1e-5)


@pytest.mark.parametrize("dark", [0.5, 0.006, 0.001])
def test_dark_colours_of_vertices_keep_their_digits(tmp_path, dark):
    """In 8 bits .006 becomes .0078, and .001 none."""
    path = written(tmp_path / "dark.glb", None, np.full(3, dark, "<f4"))
    np.testing.assert_allclose(read_mesh(path).reflectance, 0.98 * dark, rtol=1e-6)


@pytest.mark.parametrize(("specular", "left"), [(0.0, 1.0), (0.2, 0.8), (0.5, 0.5), (None, 0.0)])
@pytest.mark.parametrize("textured", [False, True])
def test_specular_reflection_is_no_diffuse_one(tmp_path, specular, left, textured):
    """KHR_materials_pbrSpecularGlossiness: diffuse colours times 1 - the largest specular one, which is 1 by itself."""
    gloss = {"diffuseFactor": [0.2, 0.5, 0.7, 1]}
    if specular is not None:
        gloss["specularFactor"] = [specular, 0.5 * specular, 0]
    if textured:
        gloss["diffuseTexture"] = {"index": 0}
    white = np.full((2, 2, 3), 255, np.uint8) if textured else None
    more = {"extensions": {"KHR_materials_pbrSpecularGlossiness": gloss}}
    path = written(tmp_path / "a.glb", {"baseColorFactor": [1, 0, 0, 1]}, None, white, **more)
    wanted = (0.98 if textured else 1.0) * left * np.array([0.2, 0.5, 0.7])
    np.testing.assert_allclose(read_mesh(path).face_reflectance(), [wanted, wanted], atol=1e-9)


def test_points_of_our_own_come_back_by_trimesh(tmp_path):
    points = np.random.default_rng(0).normal(size=(300, 3))
    normals = points / np.linalg.norm(points, axis=1)[:, None]
    columns = np.c_[points, normals, np.tile([180, 100, 50], (300, 1))]
    np.savetxt(tmp_path / "ball.csv", columns, delimiter=",", header="x,y,z,nx,ny,nz,red,green,blue", comments="")
    sf.read_scan(tmp_path / "ball.csv").save(tmp_path / "ball.glb", up=[0, 0, 1])
    (cloud,) = trimesh.load(tmp_path / "ball.glb").geometry.values()
    wanted = sf.read(tmp_path / "ball.csv").reflectance[0]
    np.testing.assert_allclose(sf.Surfels(cloud.vertices, cloud.vertices).reflectance[0], 0.5)
    np.testing.assert_allclose(sf.Surfels(cloud, normals).reflectance[0], wanted, atol=0.003)


def test_the_mean_of_a_specular_texture_counts(tmp_path):
    gloss = {"specularFactor": [0.5, 0.5, 0.5], "specularGlossinessTexture": {"index": 0}}
    halves = np.zeros((2, 2, 3), np.uint8)
    halves[0, :, 1] = 255
    more = {"extensions": {"KHR_materials_pbrSpecularGlossiness": gloss}}
    path = written(tmp_path / "a.glb", {}, None, halves, **more)
    with pytest.warns(UserWarning, match=r"a\.glb: specularGlossinessTexture of material 0 counts by its mean"):
        np.testing.assert_allclose(read_mesh(path).face_reflectance(), 0.75)
