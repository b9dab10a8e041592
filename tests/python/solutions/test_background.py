"""What is seen behind: colours, and Environments in the directions in which a camera looks."""

import copy
from dataclasses import replace

import numpy as np
import pytest

import surflux as sf
from surflux.geometry.rotation import rotation_about
from surflux.solutions.painting import Painter
from surflux.solving.turning_light import TurningLight

# Seven rows and twelve columns of other colours each: no symmetry that a picture could be mistaken by.
IMAGE = np.random.default_rng(5).uniform(0.1, 2.0, (7, 12, 3)).astype(np.float32)
SKIES = [
    sf.Environment(IMAGE),
    sf.Environment(IMAGE, azimuth=77.0),
    sf.Environment(IMAGE, up=[0.0, 1.0, 0.0]),
    sf.Environment(IMAGE, up=[0.3, -0.5, -0.8], azimuth=200.0),
    sf.Environment(IMAGE, up=[0.0, 0.0, -1.0]),
]
# Of who looks level, up, down and aslant, with another thing up each.
LOOKS = [([1, 0.2, 0], [0, 0, 1]), ([0, 0, 1], [0, 1, 0]), ([0.1, 0.1, -1], [1, 1, 1]), ([-1, 2, 0.7], [0.2, 0.1, -1])]


def beneath(*lights):
    """The solution of a disk that faces down, and is not seen from the origin."""
    disk = sf.Surfels([[0, 0, -1]], normals=[[0, 0, -1]], radii=0.1, reflectance=0.5)
    return sf.solve(sf.Scene([disk], lights=list(lights)))


def rays(camera, width, height):
    """(h, w, 3) unit vectors through the middles of pixels, from the eye: by Camera.project, turned round."""
    right = np.cross(camera.target - camera.eye, camera.up)
    forward = (camera.target - camera.eye) / np.linalg.norm(camera.target - camera.eye)
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    tan = np.tan(np.radians(camera.fov) / 2)
    x, y = np.meshgrid(
        (np.arange(width) + 0.5) * 2 / height - width / height, 1 - (np.arange(height) + 0.5) * 2 / height
    )
    out = forward + tan * (x[..., None] * right + y[..., None] * up)
    return out / np.linalg.norm(out, axis=2, keepdims=True)


def looked_up(sky, directions):
    """Radiance by what the docstring of Environment says, and how far each is from another pixel of the image."""
    up = np.array(sky.up)
    axis = np.cross([0, 0, 1], up)
    if np.linalg.norm(axis) > 0:
        turn = rotation_about(axis, np.arccos(np.clip(up[2], -1, 1)))
    else:
        turn = np.eye(3) if up[2] > 0 else np.diag([1.0, -1.0, -1.0])
    local = directions @ turn  # the inverse of the rotation
    height, width = sky.image.shape[:2]
    row = np.arccos(np.clip(local[..., 2], -1, 1)) / np.pi * height
    column = (np.pi + np.radians(sky.azimuth) - np.arctan2(local[..., 1], local[..., 0])) / (2 * np.pi) % 1 * width
    far = np.minimum(np.abs(row - np.rint(row)), np.abs(column - np.rint(column)))
    return sky.image[np.minimum(row.astype(int), height - 1), np.minimum(column.astype(int), width - 1)], far


@pytest.mark.parametrize("sky", SKIES, ids=str)
def test_each_pixel_of_the_sky_is_the_radiance_in_its_direction(sky):
    solution = beneath(sky)
    for forward, up in LOOKS:
        camera = sf.Camera([0, 0, 0], forward, up, fov=100)
        picture = solution.render(camera, (41, 30), background=True, samples=1)
        wanted, far = looked_up(sky, rays(camera, 41, 30))
        assert (far < 1e-6).mean() < 0.05
        np.testing.assert_array_equal(picture[far >= 1e-6], wanted[far >= 1e-6])


def test_parallel_rays_see_one_place_of_the_sky():
    camera = sf.Camera([0, 0, 0], [1, 0.3, 0.2], height=4.0)
    picture = beneath(SKIES[3]).render(camera, (8, 6), background=True)
    wanted, _ = looked_up(SKIES[3], np.array([1, 0.3, 0.2]) / np.linalg.norm([1, 0.3, 0.2]))
    np.testing.assert_allclose(picture, np.broadcast_to(wanted, (6, 8, 3)), rtol=1e-6)


@pytest.mark.parametrize("sky", [SKIES[0], SKIES[3]], ids=str)
def test_pictures_all_around_bring_the_light_that_the_solver_finds(sky):
    """Six pictures make a cube: radiance times cosine, over their solid angles, is what a disk in the open has.

    Of 120 x 120 pixels a side, the middles of which stand for them: borders of the image are off by a pixel's share.
    """
    normal, side = np.array([0.3, 0.5, -0.6]) / np.linalg.norm([0.3, 0.5, -0.6]), 120
    solution = sf.solve(sf.Scene([sf.Surfels([-normal], normals=[normal], radii=1e-4)], lights=[sky]), rays=4096)
    found = np.zeros(3)
    for forward in np.concatenate([np.eye(3), -np.eye(3)]):
        camera = sf.Camera([0, 0, 0], forward, np.roll(np.abs(forward), 1), fov=90)
        picture = solution.render(camera, (side, side), background=True, samples=1).astype(float)
        towards = rays(camera, side, side)
        solid_angle = (2 / side) ** 2 * (towards @ forward) ** 3
        found += np.einsum("hw,hwc->c", solid_angle * np.maximum(towards @ normal, 0), picture)
    np.testing.assert_allclose(found, solution.direct[0], rtol=5e-3)


def test_colours_are_skies_and_skies_add_up():
    solution, camera = beneath(sf.Environment([1.0, 2.0, 3.0]), sf.Environment(0.5)), sf.Camera([0, 0, 0], [1, 0, 0])

    def corner(**given):
        return solution.render(camera, (4, 3), **given)[0, 0].tolist()

    assert corner() == corner(background=False) == [0, 0, 0]
    assert corner(background=True) == [1.5, 2.5, 3.5]
    assert corner(background=[4, 5, 6]) == corner(background=sf.Environment([4, 5, 6])) == [4, 5, 6]
    assert (
        sf.solve(sf.Scene([solution.surfels], lights=[sf.DirectionalLight([0, 0, 1], 1)]))
        .render(camera, (4, 3), background=True)
        .tolist()
        == np.zeros((3, 4, 3)).tolist()
    )


def ball(sky):
    rng = np.random.default_rng(1)
    normals = rng.normal(size=(400, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    table = sf.Surfels.from_mesh(([[-2, -2, -1], [2, -2, -1], [2, 2, -1], [-2, 2, -1]], [[0, 1, 2, 3]]), patch_area=0.3)
    lamp = sf.AreaLight([0.8, -1, 0.5], [0.4, 0, 0], [0, 0.4, 0.2], 3.0)
    return sf.Scene([sf.Surfels(normals, normals=normals, reflectance=0.5), table], lights=[lamp, sky])


CAMERA, SIZE = sf.Camera([1, -5, 1.2], [0, 0, 0], fov=40), (60, 44)
BLENDED = ["radiance", "direct", "indirect", "alpha"]


def expect_the_sky_behind(before, with_sky, sky, samples):
    """Light that comes straight from the sky is direct; what else there is in a pixel covers it by alpha."""
    alpha = before["alpha"]
    assert (alpha == 0).any()
    assert (alpha == 1).any()
    np.testing.assert_array_equal(alpha * samples**2 % 1, 0)
    assert samples == 1 or ((alpha > 0) & (alpha < 1)).sum() > 20
    width, height = SIZE
    whole = looked_up(sky, rays(CAMERA, samples * width, samples * height))[0].astype(float)
    whole = whole.reshape(height, samples, width, samples, 3).mean(axis=(1, 3))
    for name in ("radiance", "direct"):
        behind = (1 - alpha[..., None]) * whole
        away = np.abs(with_sky[name] - before[name] - behind).max(axis=2)
        assert (away < 1e-6).mean() > 0.98  # all but those on a border of the image
    np.testing.assert_array_equal(with_sky["indirect"], before["indirect"])
    np.testing.assert_array_equal(with_sky["alpha"], alpha)


@pytest.fixture(scope="module")
def solved():
    return sf.solve(ball(SKIES[1]))


@pytest.mark.parametrize("samples", [1, 2, 3])
def test_what_covers_a_pixel_in_part_blends_with_the_sky(solved, samples):
    before, with_sky = (
        solved.render(CAMERA, SIZE, background=behind, samples=samples, layers=BLENDED) for behind in (0.0, True)
    )
    expect_the_sky_behind(before, with_sky, SKIES[1], samples)


def test_alpha_says_where_anything_is(solved):
    found = solved.render(CAMERA, SIZE, samples=1, layers=["alpha", "index"])
    np.testing.assert_array_equal(found["alpha"], found["index"] != -1)
    assert (found["index"] == -2).any()  # the lamp


def test_what_is_drawn_from_a_basis_has_the_same_sky():
    before, with_sky = (
        sf.solve_meshless(ball(SKIES[1]), levels=1, rays=32).render(CAMERA, SIZE, background=behind, layers=BLENDED)
        for behind in (0.0, True)
    )
    expect_the_sky_behind(before, with_sky, SKIES[1], 2)


def test_a_picture_as_a_matrix_has_the_same_sky(solved):
    found = Painter().layers(solved, CAMERA, SIZE, layers=BLENDED, background=True)
    for name, wanted in solved.render(CAMERA, SIZE, background=True, layers=BLENDED).items():
        np.testing.assert_allclose(found[name], wanted, atol=2e-5)


def test_moving_lamps_before_a_sky():
    transfer = sf.precompute_transfer(ball(SKIES[1]))
    renderer = sf.LampRenderer(transfer, CAMERA, SIZE, samples=2)
    lamp = sf.PointLight([1, -2, 2], 5.0)
    before, with_sky = (renderer.frame(lamp, background=behind, layers=BLENDED) for behind in (0.0, SKIES[1]))
    expect_the_sky_behind(before, with_sky, SKIES[1], 2)
    np.testing.assert_array_equal(renderer.frame(lamp, background=True), before["radiance"])


def test_a_sun_in_a_pixel_is_as_bright_as_it_is():
    image = np.ones((64, 128, 3))
    image[20, 58] = 1e6
    picture = beneath(sf.Environment(image)).render(
        sf.Camera([0, 0, 0], [1, 0.25, 0.6], fov=40), (64, 48), background=True
    )
    assert set(np.unique(picture)) >= {1.0, 1e6}


def test_files_keep_the_sky(solved, tmp_path):
    for skies in ([sf.Environment([1, 2, 3], up=[0, 1, 0])], [SKIES[3], sf.Environment(0.1), SKIES[1]], []):
        twin = copy.copy(solved)
        twin._environments = skies
        again = sf.load_solution(twin.save(tmp_path / "a.ply"))
        assert again._environments == skies
        assert len(sf.read(tmp_path / "a.ply")) == len(solved.surfels)  # for all else the file is one of points
    again = sf.load_solution(solved.save(tmp_path / "a.ply"))
    sky = again.render(CAMERA, SIZE, background=True) != again.render(CAMERA, SIZE)
    assert sky.any(axis=2).mean() > 0.3


def test_a_file_that_lacks_the_pixels_of_its_sky_is_damaged(solved, tmp_path):
    path = solved.save(tmp_path / "a.ply")
    data = path.read_bytes()
    path.write_bytes(data.replace(b"element environment", b"element environmant"))
    with pytest.raises(sf.FileError, match=r"wanted an image of 12 x 7 pixels in its element 'environment'"):
        sf.load_solution(path)


def test_a_sky_of_sun_and_clouds_is_behind():
    sky = sf.Sky.from_sun(30.0, 180.0, direct_normal=700.0, diffuse=100.0)
    picture = beneath(sky).render(sf.Camera([0, 0, 0], [0, -1, 0]), (40, 30), background=True)
    assert picture[:14].min() > picture[16:].max() * 0.5
    np.testing.assert_allclose(picture[16:], sky.environment().image[-1, 0, 0], rtol=1e-6)  # the ground


@pytest.mark.parametrize("background", [None, "sky", [1, 2], -1.0, float("nan"), [True, False, True]])
def test_what_is_no_background_is_refused(solved, background):
    with pytest.raises(ValueError, match=r"^background: "):
        solved.render(background=background)


@pytest.fixture(scope="module")
def distant():
    disk = sf.Surfels([[0, 0, -1]], normals=[[0, 0, -1]], radii=0.1, reflectance=0.5)
    return sf.precompute_transfer(sf.Scene([disk]), "distant")


@pytest.mark.parametrize("sky", SKIES, ids=str)
def test_a_sky_that_turns_is_behind_what_it_lights(distant, sky):
    """With its light a camera turns, and sees the same; the other way round, about its up, so does its image."""
    turn = rotation_about(np.array([0.2, 1.0, 0.4]), 1.1)
    forward, up = np.array([1.0, 0.2, -0.5]), np.array([0.1, 0.2, 1.0])

    def seen(solution, by):
        return solution.render(sf.Camera([0, 0, 0], by @ forward, by @ up, fov=100), (60, 40), background=True)

    wanted = seen(distant.relight(sky), np.eye(3))
    found = seen(distant.relight(sky, rotation=turn), turn)
    assert (np.abs(found - wanted).max(axis=2) < 1e-6).mean() > 0.98  # all but those on a border of the image
    wanted = seen(distant.relight(replace(sky, azimuth=sky.azimuth + 25.0)), np.eye(3))
    light = TurningLight(distant, sky)
    for found in (light.relight(25.0), light.diffuse(25.0)):
        assert (np.abs(seen(found, np.eye(3)) - wanted).max(axis=2) < 1e-6).mean() > 0.98


def test_harmonics_and_skies_of_transfer_are_behind_what_they_light(distant):
    light, camera = (
        np.random.default_rng(1).normal(size=9) + np.eye(9)[0] * 9,
        sf.Camera([0, 0, 0], [1, 1, 0.3], fov=90),
    )
    picture = distant.relight(light).render(camera, (40, 30), background=True, samples=1)
    wanted = sf.spherical_harmonics(rays(camera, 40, 30).reshape(-1, 3), 3) @ light
    # Half of a pixel's diagonal, pi/256, times the slope: bands up to 2 turn their sign in no less than pi/4.
    np.testing.assert_allclose(picture[..., 0].ravel(), wanted, atol=np.pi / 256 * 1.5 * np.abs(light).sum())
    transfer = sf.precompute_transfer(distant.scene, "sky")
    for sky in (SKIES[1], sf.Sky.from_sun(30.0, 180.0, direct_normal=700.0, diffuse=100.0)):
        found = transfer.relight(sky).render(camera, (8, 6), background=True)
        wanted = beneath(sky).render(camera, (8, 6), background=True)
        np.testing.assert_array_equal(found, wanted)
