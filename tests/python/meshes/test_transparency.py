"""Transparency of materials is told, and texels that are not there have no colour."""

import logging

import numpy as np
import pytest

import surflux as sf
from squares import SQUARE, two_triangles
from surflux._base.color import WHITE, srgb_to_linear
from surflux.meshes.texel_means import mean_texels
from surflux.meshes.textures import texture_of

PIL = pytest.importorskip("PIL.Image")
material = pytest.importorskip("trimesh.visual.material")
GREEN = np.array([60, 180, 40])
LINEAR = WHITE * srgb_to_linear(GREEN / 255.0)


def leaf():
    """(64, 64, 4): a disk on transparent black, as exporters leave it."""
    y, x = np.mgrid[:64, :64]
    pixels = np.zeros((64, 64, 4), np.uint8)
    pixels[(x - 32) ** 2 + (y - 32) ** 2 < 18**2] = [*GREEN, 255]
    return pixels


def card(pixels=None, **told):
    image = None if pixels is None else PIL.fromarray(pixels)
    made = material.PBRMaterial("leaf", baseColorTexture=image, **told)
    return two_triangles(uv=SQUARE[:, :2], material=made)


def written(path, mesh):
    mesh.export(path)
    return path


@pytest.mark.parametrize("mode", ["MASK", "BLEND"])
def test_cut_out_leaves_keep_their_colour(tmp_path, mode):
    path = written(tmp_path / "leaf.glb", card(leaf(), alphaMode=mode))
    with pytest.warns(
        UserWarning, match=r"leaf\.glb: transparency \(alphaMode\) of 2 faces \(leaf\) is left out: these"
    ):
        whole = sf.Surfels.from_mesh(path)
    np.testing.assert_allclose(whole.reflectance, [LINEAR], atol=1e-5)
    with pytest.warns(UserWarning, match=r"^mesh: transparency \(alphaMode\) of 2 faces"):
        cut = sf.Surfels.from_mesh(card(leaf(), alphaMode=mode), patch_area=1 / 64)
    np.testing.assert_allclose(cut.reflectance, np.tile(LINEAR, (len(cut), 1)), atol=1e-5)  # also where nothing is


def test_masks_are_cut_off_and_blends_weigh():
    pixels = np.zeros((64, 64, 4), np.uint8)
    pixels[:, ::2], pixels[:, 1::2] = [255, 255, 255, 204], [0, 0, 0, 51]
    for told, white in (
        ({"alphaMode": "BLEND"}, 0.8),
        ({"alphaMode": "MASK"}, 1.0),
        ({"alphaMode": "MASK", "alphaCutoff": 0.9}, 0.5),  # nothing is there
        ({"alphaMode": "MASK", "baseColorFactor": [255, 255, 255, 150]}, 0.5),
    ):
        with pytest.warns(UserWarning, match="transparency"):
            found = sf.Surfels.from_mesh(card(pixels, **told))
        np.testing.assert_allclose(np.average(found.reflectance, axis=0), WHITE * white, atol=0.01)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    ("alpha", "told"),
    [
        (0, {}),
        (0, {"alphaMode": "OPAQUE"}),
        (255, {"alphaMode": "BLEND"}),
        (200, {"alphaMode": "MASK"}),
        (40, {"alphaMode": "MASK", "alphaCutoff": 0.1}),
    ],
)
def test_alpha_that_does_not_count_changes_nothing(alpha, told):
    pixels = leaf()
    pixels[:, :, 3] = alpha
    plain = sf.Surfels.from_mesh(card(pixels[:, :, :3].copy())).reflectance
    np.testing.assert_array_equal(sf.Surfels.from_mesh(card(pixels, **told)).reflectance, plain)


def test_glass_of_gltf_without_a_texture_is_told(tmp_path):
    pane = card(alphaMode="BLEND", baseColorFactor=[255, 255, 255, 20])
    both = pytest.importorskip("trimesh").Scene([pane, card(), two_triangles()])
    both.export(tmp_path / "room.glb")
    with pytest.warns(UserWarning, match="of 2 faces") as told:
        sf.Surfels.from_mesh(tmp_path / "room.glb")
    assert len(told) == 1


def test_means_by_alpha_are_by_area():
    rng = np.random.default_rng(0)
    pixels = rng.integers(0, 256, (40, 30, 4), dtype=np.uint8)
    alpha = np.arange(256) / 255.0
    corners = np.array([[[0, 0], [1, 0], [1, 1]], [[0, 0], [1, 1], [0, 1]]]) * 3.0
    found = mean_texels(texture_of(PIL.fromarray(pixels), alpha), corners).mean(axis=0)
    exact = np.average(srgb_to_linear(pixels[:, :, :3] / 255.0), axis=(0, 1), weights=np.tile(pixels[:, :, 3:], 3))
    np.testing.assert_allclose(found, exact, rtol=2e-3)
    point = mean_texels(texture_of(PIL.fromarray(pixels), alpha), np.full((1, 3, 2), 0.51))
    np.testing.assert_allclose(point[0], srgb_to_linear(pixels[19, 15, :3] / 255.0), atol=1e-5)


def test_backs_are_logged_where_nobody_asks_for_them(tmp_path, caplog):
    path = written(tmp_path / "leaf.glb", card(leaf()[:, :, :3].copy(), doubleSided=True))
    (tmp_path / "scene.toml").write_text('[[object]]\nfile = "leaf.glb"\nkind = "mesh"\n')
    with caplog.at_level(logging.INFO, "surflux"):
        for two_sided in (True, "sheets"):
            sf.Surfels.from_mesh(path, two_sided=two_sided)
        assert not caplog.records
        sf.Surfels.from_mesh(path)
        sf.load_scene(tmp_path / "scene.toml")
    told = [record.getMessage() for record in caplog.records if "doubleSided" in record.getMessage()]
    assert len(told) == 2
    assert told[0].endswith(
        "leaf.glb: doubleSided of 2 faces is left out: backs are black (two_sided=True gives them one)"
    )


OBJ = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nusemtl wall\nf 1 2 3\nusemtl pane\nf 1 3 4\n"


def room(tmp_path, lines):
    (tmp_path / "a.mtl").write_text(f"newmtl wall\nKd .6\nd 1\nnewmtl pane\nKd .1\n{lines}\nnewmtl unused\nd 0\n")
    (tmp_path / "a.obj").write_text(OBJ)
    return tmp_path / "a.obj"


@pytest.mark.parametrize("lines", ["d 0.05", "d -halo 0.05", "Tr .95", "map_d holes.png", "d 1\nmap_d holes.png"])
def test_glass_of_obj_is_told(tmp_path, lines):
    said = (
        r"a\.obj: transparency \(d, Tr or map_d\) of 1 face \(pane\) is left out: this face is opaque; leave out faces"
    )
    with pytest.warns(UserWarning, match=said) as told:
        sf.Surfels.from_mesh(room(tmp_path, lines))
    assert len(told) == 1


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("lines", ["", "d 1.0", "Tr 0", "d 1\nTr 1", "d x", "Tr"])
def test_opaque_materials_of_obj_are_not(tmp_path, lines):
    sf.Surfels.from_mesh(room(tmp_path, lines))


def test_alpha_of_textures_of_obj_files(tmp_path):
    """A leaf cut out of black: faces have the mean of what is there, and it is told that the rest casts a shadow."""
    image = pytest.importorskip("PIL.Image")
    rgba = np.zeros((8, 8, 4), np.uint8)
    rgba[:, :4] = [0, 200, 0, 255]
    image.fromarray(rgba).save(tmp_path / "leaf.png")
    (tmp_path / "leaf.mtl").write_text("newmtl leaf\nKd 1 1 1\nmap_Kd leaf.png\n")
    corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
    (tmp_path / "leaf.obj").write_text(f"mtllib leaf.mtl\n{corners}usemtl leaf\nf 1/1 2/2 3/3 4/4\n")
    with pytest.warns(UserWarning, match=r"transparency \(alpha of map_Kd\) of 1 face \(leaf\)"):
        surfels = sf.Surfels.from_mesh(tmp_path / "leaf.obj")
    np.testing.assert_allclose(surfels.reflectance, [[0, WHITE * srgb_to_linear(200 / 255), 0]], atol=1e-6)
    rgba[:, :, 3] = 255
    image.fromarray(rgba).save(tmp_path / "leaf.png")
    opaque = sf.Surfels.from_mesh(tmp_path / "leaf.obj")
    np.testing.assert_allclose(opaque.reflectance, 0.5 * surfels.reflectance, atol=1e-6)
