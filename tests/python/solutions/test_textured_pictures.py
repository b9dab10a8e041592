"""Pictures of textured meshes: light of the surfels, times the texture at what each subpixel sees."""

import pickle

import numpy as np
import pytest

import surflux as sf
from squares import SQUARE, TWO
from surflux._base.color import WHITE, srgb_to_linear
from surflux.meshes.reading import read_mesh
from surflux.meshes.seen_textures import SeenTextures

TEXELS = 32
CAMERA = sf.Camera([0.5, 0.5, 3.0], [0.5, 0.5, 0.0], up=[0, 1, 0], height=1.0)  # a pixel of it sees one texel
FOV = np.degrees(2.0 * np.arctan(0.5 / 3.0))  # of as much in perspective
SKY = [sf.Environment(1.0)]


def pixels():
    return np.random.default_rng(4).integers(0, 256, (TEXELS, TEXELS, 3), dtype=np.uint8)


def write_square(folder, material, corners=SQUARE, at=SQUARE, faces="f 1/1 2/2 3/3 4/4"):
    image = pytest.importorskip("PIL.Image")
    image.fromarray(pixels()).save(folder / "texture.png")
    (folder / "square.mtl").write_text(f"newmtl painted\n{material}\n")
    lines = [f"v {x:.17g} {y:.17g} {z:.17g}" for x, y, z in corners] + [f"vt {u:.17g} {v:.17g}" for u, v, *_ in at]
    (folder / "square.obj").write_text("\n".join(["mtllib square.mtl", *lines, "usemtl painted", faces, ""]))
    return folder / "square.obj"


@pytest.fixture
def square(tmp_path):
    return write_square(tmp_path, "Kd 1 1 1\nmap_Kd texture.png")


LINEAR = WHITE * srgb_to_linear(pixels() / 255.0)


@pytest.mark.parametrize("solve", [sf.solve, sf.solve_meshless])
@pytest.mark.parametrize("patch_area", [None, 0.02])
@pytest.mark.parametrize("direct", ["interpolated", "traced"])
def test_each_subpixel_has_its_texel(square, solve, patch_area, direct):
    """Under an open sky, where H = pi everywhere; patches were drawn as the mean of 5 to 32 texels each way."""
    solution = solve(sf.Scene([sf.Surfels.from_mesh(square, patch_area)], SKY))
    camera = CAMERA if solve is sf.solve else sf.Camera(CAMERA.eye, CAMERA.target, CAMERA.up, fov=FOV)
    found = solution.render(camera, (TEXELS, TEXELS), samples=1, layers=True, direct=direct)
    np.testing.assert_allclose(found["albedo"], LINEAR, atol=2e-3 if solve is sf.solve else 0.06)
    np.testing.assert_allclose(found["radiance"], found["albedo"], atol=0.01)
    np.testing.assert_array_equal(found["direct"] + found["indirect"], found["radiance"])


def test_far_off_and_at_a_slant_the_mean_is_seen(square):
    """Of a floor that repeats the texture 64 times each way, and of which a pixel sees one repeat and more."""
    at = 64.0 * SQUARE
    square = write_square(square.parent, "Kd 1 1 1\nmap_Kd texture.png", at=at)
    solution = sf.solve(sf.Scene([sf.Surfels.from_mesh(square)], SKY))
    for camera in (
        sf.Camera([0.5, 0.5, 1.0], [0.5, 0.5, 0], up=[0, 1, 0], height=0.5),
        sf.Camera([0.5, -0.5, 0.2], [0.5, 0.5, 0]),
    ):
        albedo = solution.render(camera, (32, 32), layers=["albedo", "alpha"])
        inside = albedo["alpha"] == 1.0
        assert inside.sum() > 100
        np.testing.assert_allclose(
            albedo["albedo"][inside], np.tile(LINEAR.mean(axis=(0, 1)), (inside.sum(), 1)), rtol=0.04
        )


def test_colours_of_materials_and_what_shines(square):
    """Kd times its map, and pi Ke times its own, where no light is."""
    square = write_square(square.parent, "Kd .5 1 .25\nmap_Kd texture.png\nKe 2 2 2\nmap_Ke texture.png")
    solution = sf.solve(sf.Scene([sf.Surfels.from_mesh(square)]))
    found = solution.render(CAMERA, (TEXELS, TEXELS), samples=1, layers=True)
    np.testing.assert_allclose(found["albedo"], LINEAR * [0.5, 1.0, 0.25], atol=2e-3)
    np.testing.assert_allclose(found["radiance"], 2.0 * srgb_to_linear(pixels() / 255.0), atol=5e-3)


def test_textures_go_where_the_mesh_goes(square):
    """Turned over, moved, cut, as a pair of triangles, and from behind."""
    pair = write_square(square.parent, "Kd 1 1 1\nmap_Kd texture.png", faces="f 1/1 2/2 3/3\nf 1/1 3/3 4/4")
    turn = np.array([[0, -2, 0, 7], [2, 0, 0, 5], [0, 0, 2, 1], [0, 0, 0, 1]], float)
    surfels = sf.Surfels.from_mesh(pair, 0.03)
    moved = surfels.transformed(turn)[np.arange(len(surfels))[::-1]]
    camera = sf.Camera([6, 6, 9], [6, 6, 1], up=[-1, 0, 0], height=2)
    for one, through in ((surfels, CAMERA), (moved, camera), (surfels.flipped(), CAMERA)):
        solution = sf.solve(sf.Scene([one], SKY))
        found = solution.render(through, (TEXELS, TEXELS), samples=1, layers=["albedo"], culling=False)["albedo"]
        np.testing.assert_allclose(found, LINEAR, atol=2e-3)


def test_other_colours_take_the_place_of_textures(square, caplog):
    """Given to from_mesh, to replace, or to a transfer that is relit; files and pickles have the means of patches."""
    means = sf.solve(sf.Scene([sf.Surfels.from_mesh(square)], SKY))
    plain = sf.Surfels.from_mesh(square, reflectance=0.4)
    replaced = sf.Surfels.from_mesh(square).replace(reflectance=0.4)
    pickled = pickle.loads(pickle.dumps(sf.Surfels.from_mesh(square)))
    for surfels in (plain, replaced, pickled):
        solution = sf.solve(sf.Scene([surfels], SKY))
        albedo = solution.render(CAMERA, (TEXELS, TEXELS), layers=["albedo"])["albedo"]
        np.testing.assert_allclose(albedo, np.broadcast_to(surfels.reflectance[0], albedo.shape), atol=1e-5)
    with caplog.at_level("INFO", logger="surflux"):
        path = means.save(square.parent / "means.ply")
    assert "means.ply: textures are left out" in caplog.text
    albedo = sf.load_solution(path).render(CAMERA, (TEXELS, TEXELS), layers=["albedo"])["albedo"]
    np.testing.assert_allclose(albedo, np.broadcast_to(LINEAR.mean(axis=(0, 1)), albedo.shape), atol=1e-4)


@pytest.mark.parametrize("others", [[], ["square"], ["plain", "shining"]])
def test_what_a_picture_was_made_of_is_pickled(square, others):
    """The filtered textures that pictures keep have no pickle."""
    of_name = {"square": {}, "shining": {"emission": 1.0}, "plain": {"reflectance": 0.4}}
    plane = sf.Surfels.from_mesh(square)
    objects = [plane, *(plane.replace(**of_name[name]).transformed(np.diag([1, -1, 1, 1])) for name in others)]
    solution = sf.solve(sf.Scene(objects, SKY))
    solution.render(CAMERA, (4, 4), samples=1)
    for surfels in (*objects, solution.surfels):
        again = pickle.loads(pickle.dumps(surfels))
        np.testing.assert_array_equal(again.reflectance, surfels.reflectance)
    again = pickle.loads(pickle.dumps(solution))
    np.testing.assert_array_equal(again.radiosity, solution.radiosity)
    assert objects[0]._faces.filtered  # as before: the next picture takes it


def test_pages_say_that_they_have_means(square, caplog):
    painted = sf.Surfels.from_mesh(square)
    for thing, is_said in ((painted.replace(reflectance=0.4), False), (painted, True), (sf.Scene([painted]), True)):
        caplog.clear()
        with caplog.at_level("INFO", logger="surflux"):
            sf.Page(thing)
        assert ("textures are not shown" in caplog.text) == is_said


def test_untextured_faces_of_the_mesh_have_their_own_colours(square):
    """Light blends over all of it, and nothing of the texture is on the wall beside it."""
    lines = [*square.read_text().splitlines(), "v 2 0 0", "v 2 1 0", "usemtl plain", "f 2 5 6 3", ""]
    square.write_text("\n".join(lines))
    with open(square.parent / "square.mtl", "a") as file:
        file.write("newmtl plain\nKd .1 .2 .3\n")
    solution = sf.solve(sf.Scene([sf.Surfels.from_mesh(square, 0.02)], SKY))
    camera = sf.Camera([1, 0.5, 3], [1, 0.5, 0], up=[0, 1, 0], height=1)
    albedo = solution.render(camera, (2 * TEXELS, TEXELS), samples=1, layers=["albedo"])["albedo"]
    np.testing.assert_allclose(albedo[:, :TEXELS], LINEAR, atol=2e-3)
    np.testing.assert_allclose(albedo[:, TEXELS:], np.broadcast_to([0.1, 0.2, 0.3], (TEXELS, TEXELS, 3)), atol=1e-6)


def test_patches_beside_a_texture_blend_as_without_it(square):
    """A floor under a lamp in one mesh with the textured square: each patch of it was flat."""
    lines = square.read_text().splitlines()
    floor = ["v 2 0 0", "v 4 0 0", "v 4 2 0", "v 2 2 0", "usemtl plain", "f 5 6 7 8", ""]
    with open(square.parent / "square.mtl", "a") as file:
        file.write("newmtl plain\nKd .5 .5 .5\n")
    (square.parent / "both.obj").write_text("\n".join([*lines, *floor]))
    (square.parent / "floor.obj").write_text("\n".join(["mtllib square.mtl", *lines[1:5], *floor]))
    camera, lamp = sf.Camera([3, 1, 3], [3, 1, 0], up=[0, 1, 0], height=1.8), [sf.PointLight([3, 1, 0.7], 1.0)]
    pictures = [
        sf.solve(sf.Scene([sf.Surfels.from_mesh(square.parent / name, 0.04)], lamp), insert=False).render(
            camera, (64, 64)
        )
        for name in ("both.obj", "floor.obj")
    ]
    np.testing.assert_allclose(*pictures, rtol=1e-3)


def test_emission_that_is_given_leaves_the_texture_of_reflectance(square):
    surfels = sf.Surfels.from_mesh(square).replace(emission=3.0, reflectance=sf.Surfels.from_mesh(square).reflectance)
    albedo = sf.solve(sf.Scene([surfels])).render(CAMERA, (TEXELS, TEXELS), samples=1, layers=["albedo"])["albedo"]
    np.testing.assert_allclose(albedo, LINEAR, atol=2e-3)


@pytest.mark.parametrize("two_sided", ["false", '"sheets"', "true"])
def test_scene_files_keep_textures(square, two_sided):
    """Their objects have colours put on them, of which none were other ones. With both sides they had lost them."""
    path = square.parent / "scene.toml"
    text = f'[[object]]\nfile = "square.obj"\nkind = "mesh"\ntranslate = [1, 0, 0]\ntwo_sided = {two_sided}\n'
    path.write_text(text + '[[light]]\ntype = "environment"\nradiance = 1.0\n')
    camera = sf.Camera([1.5, 0.5, 3.0], [1.5, 0.5, 0.0], up=[0, 1, 0], height=1.0)
    solution = sf.solve(sf.load_scene(path))
    albedo = solution.render(camera, (TEXELS, TEXELS), samples=1, layers=["albedo"])["albedo"]
    np.testing.assert_allclose(albedo, LINEAR, atol=2e-3)
    assert solution.per_face("irradiance").shape == (1, 3)


def test_light_on_a_texture_is_that_on_a_plain_wall(square):
    """Of a lamp close by: blended as light, not as what patches of other colours send."""
    lights = [sf.PointLight([0.3, 0.6, 0.4], 1.0)]
    textured = sf.solve(sf.Scene([sf.Surfels.from_mesh(square, 1e-3)], lights), insert=False)
    plain = sf.solve(sf.Scene([sf.Surfels.from_mesh(square, 1e-3, 0.5)], lights), insert=False)
    found = textured.render(CAMERA, (TEXELS, TEXELS), samples=1)
    wanted = plain.render(CAMERA, (TEXELS, TEXELS), samples=1) / 0.5 * LINEAR
    np.testing.assert_allclose(found, wanted, atol=0.002 * wanted.max())


def test_frames_under_lamps_have_them(square):
    transfer = sf.precompute_transfer(sf.Scene([sf.Surfels.from_mesh(square, 0.02)]), lighting="local")
    renderer = sf.LampRenderer(transfer, CAMERA, (TEXELS, TEXELS))
    albedo = renderer.frame([sf.PointLight([0.5, 0.5, 2], 1.0)], layers=["albedo"])["albedo"]
    np.testing.assert_allclose(albedo, LINEAR, atol=2e-3)


def test_what_is_not_there_of_a_texture_is_no_black():
    """Leaves are cut out of black in many files; a place between them has the mean of all of them."""
    image = pytest.importorskip("PIL.Image")
    trimesh = pytest.importorskip("trimesh")
    rgba = np.zeros((8, 8, 4), np.uint8)
    rgba[:, :4] = [0, 200, 0, 255]
    material = trimesh.visual.material.PBRMaterial(baseColorTexture=image.fromarray(rgba), alphaMode="MASK")
    mesh = trimesh.Trimesh(SQUARE, TWO, process=False)
    mesh.visual = trimesh.visual.TextureVisuals(uv=SQUARE[:, :2], material=material)
    with pytest.warns(UserWarning, match="transparency"):
        textures = SeenTextures(read_mesh(mesh), {})
    points = np.array([[0.2, 0.1, 0], [0.5, 0.2, 0], [0.75, 0.3, 0]])
    reflectance, emission = np.full((3, 3), 0.9), np.zeros((3, 3))
    textures.paint(np.zeros(3, int), points, np.tile(1e-3 * np.eye(3)[:2], (3, 1, 1)), reflectance, emission)
    green = WHITE * srgb_to_linear(200 / 255)
    np.testing.assert_allclose(reflectance, np.tile([0, green, 0], (3, 1)), atol=1e-4)
    np.testing.assert_array_equal(emission, 0.0)


def test_few_filtered_textures_are_kept(square, monkeypatch):
    """None without memory for it; and of the largest only means of texels."""
    from surflux.meshes import seen_textures

    monkeypatch.setattr(seen_textures, "_KEPT", 0)
    monkeypatch.setattr(seen_textures, "_LARGEST", TEXELS**2 // 4)
    write_square(square.parent, "Kd 1 1 1\nmap_Kd texture.png\nKe 1 1 1\nmap_Ke texture.png")
    textures = SeenTextures(read_mesh(square), {})
    reflectance, emission = np.zeros((1, 3)), np.zeros((1, 3))
    side = 2.0 / TEXELS
    textures.paint(np.zeros(1, int), np.array([[side, side, 0]]) / 2, side * np.eye(3)[None, :2], reflectance, emission)
    np.testing.assert_allclose(reflectance[0], LINEAR[-2:, :2].mean(axis=(0, 1)), atol=1e-4)
    assert len(textures._filtered) == 0
