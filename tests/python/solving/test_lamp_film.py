"""Films of lamps that move: each frame against a picture of that lighting, whatever is kept between them."""

import numpy as np
import pytest

import surflux as sf
from surflux import _core
from surflux.solutions.painting import Painter

CAMERA = sf.Camera([0.5, -1.4, 0.5], [0.5, 0.5, 0.5])
SIZE = (60, 40)
POINT, OTHER = sf.PointLight([0.3, 0.3, 0.6], 1.0), sf.PointLight([0.7, 0.6, 0.4], [0.2, 1.0, 2.0])


@pytest.fixture(scope="module")
def transfer():
    """Of a room with a ball of disks in it, one object each."""
    corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
    faces = [[0, 1, 2, 3], [4, 7, 6, 5], [3, 2, 6, 7], [0, 3, 7, 4], [1, 5, 6, 2]]
    room = sf.Surfels.from_mesh((corners, faces), patch_area=0.02, reflectance=[0.6, 0.5, 0.4])
    rng = np.random.default_rng(0)
    normals = rng.normal(size=(300, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    ball = sf.Surfels([0.5, 0.5, 0.25] + 0.2 * normals, normals, reflectance=0.7)
    return sf.precompute_transfer(sf.Scene([room, ball], camera=CAMERA))


@pytest.fixture
def matrices(monkeypatch):
    """How many matrices have been made."""
    made = []

    class Counted(_core.FlatImage):
        def __init__(self, *arguments):
            super().__init__(*arguments)
            made.append(self)

    monkeypatch.setattr("surflux.solutions.painting._core.FlatImage", Counted)
    return made


def pictures(transfer, frames, folder, **options):
    written = sf.animate_lamps(transfer, frames, folder / "a%02d.exr", SIZE, **options)
    assert [path.name for path in written] == [f"a{k:02d}.exr" for k in range(1, len(frames) + 1)]
    return [sf.read_image(path) for path in written]


def expect_renders(found, transfer, frames, camera=None, **options):
    for picture, lights in zip(found, frames, strict=True):
        wanted = transfer.relight(lights).render(camera, SIZE, **options)
        np.testing.assert_allclose(picture, wanted, rtol=2e-5, atol=1e-5)


@pytest.mark.slow
def test_frames_are_what_render_draws(transfer, matrices, tmp_path):
    frames = [POINT, [POINT, OTHER], OTHER, [sf.DirectionalLight([0, 1, -1], 2.0)]]
    found = pictures(transfer, frames, tmp_path, background=[0.1, 0.2, 0.3])
    expect_renders(found, transfer, frames, background=[0.1, 0.2, 0.3])
    assert len(matrices) == 1
    assert np.abs(found[0] - found[2]).mean() > 0.01
    look = sf.Camera([0.8, -1.0, 0.7], [0.4, 0.5, 0.4])
    found = pictures(transfer, frames[:2], tmp_path, camera=look, samples=1, culling=False)
    expect_renders(found, transfer, frames[:2], look, samples=1, culling=False)


def test_area_lights_are_seen_where_they_are(transfer, matrices, tmp_path):
    def lamp(x, exitance):
        return sf.AreaLight([x, 0.4, 0.95], [0, 0.2, 0], [0.2, 0, 0], exitance)

    frames = [lamp(0.1, 5.0), lamp(0.1, 20.0), lamp(0.4, 5.0), lamp(0.6, 5.0), lamp(0.6, 2.0)]
    below = sf.Camera([0.5, -1.0, 0.1], [0.5, 0.5, 0.7])
    found = pictures(transfer, frames, tmp_path, camera=below)
    expect_renders(found, transfer, frames, below)
    assert found[1].max() == pytest.approx(20.0 / np.pi, rel=1e-5)  # the lamp itself
    assert len(matrices) == 2  # of the first two frames, and of the last, which stays as the one before


def test_reflectance_and_bounces(transfer, matrices, tmp_path):
    frames = [POINT, OTHER]
    found = pictures(transfer, frames, tmp_path, reflectance=0.3, bounces=2)
    for picture, light in zip(found, frames, strict=True):
        wanted = transfer.relight(light, reflectance=0.3, bounces=2).render(size=SIZE)
        np.testing.assert_allclose(picture, wanted, rtol=2e-5, atol=1e-5)
    assert len(matrices) == 1  # surfels of another reflectance are where they were


@pytest.mark.slow
def test_layers_of_every_frame(transfer, tmp_path):
    for layers in (["direct", "indirect", "albedo"], True):
        pictures(transfer, [POINT, OTHER], tmp_path, layers=layers)
        wanted = transfer.relight(OTHER).render(size=SIZE, layers=True)
        for name in wanted if layers is True else layers:
            if name != "radiance":
                found = sf.read_image(tmp_path / "a02.exr", name)
                np.testing.assert_allclose(found, wanted[name], rtol=2e-5, atol=1e-5)


def test_what_is_dark_in_one_frame_alone_blends_as_in_the_others(tmp_path):
    """A spot lights the left half of a floor, then the right half: no matrix anew, though other surfels are dark."""
    floor = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]), patch_area=0.01)
    transfer = sf.precompute_transfer(sf.Scene([floor], camera=sf.Camera([0.5, -1, 1], [0.5, 0.5, 0])))
    frames = [sf.SpotLight([x, 0.5, 0.5], [0, 0, -1], 1.0, cone=50) for x in (0.25, 0.75)]
    left, right = pictures(transfer, frames, tmp_path)
    np.testing.assert_allclose(left, right[:, ::-1], atol=2e-3 * left.max())


def test_a_painter_of_single_pictures_is_render(transfer):
    painter, solution = Painter(), transfer.relight(POINT)
    for camera in (CAMERA, sf.Camera([0.2, -1, 0.4], [0.5, 0.5, 0.3]), CAMERA, CAMERA):
        found = painter.layers(solution, camera, SIZE, layers=["radiance"])["radiance"]
        np.testing.assert_allclose(found, solution.render(camera, SIZE), rtol=2e-5, atol=1e-5)
    # Layers that are no sum, and pictures that would make a large matrix, are drawn by OpenGL.
    assert painter._flat(solution, None, _view(solution, SIZE), ("radiance", "depth")) is None
    assert painter._flat(solution, None, _view(solution, (2048, 2048)), ("radiance",)) is None


def _view(solution, size):
    from surflux.solutions.rendering import View

    return View(solution, CAMERA, size, 0.0, 2, True, "interpolated")


def test_direct_light_at_every_pixel(transfer, matrices, tmp_path):
    frames = [POINT, [POINT, OTHER]]
    found = pictures(transfer, frames, tmp_path, direct="traced", background=0.1, culling=False, shadow_cell=2)
    renderer = sf.LampRenderer(transfer, None, SIZE, samples=2, culling=False, shadow_cell=2)
    for picture, lights in zip(found, frames, strict=True):
        np.testing.assert_array_equal(picture, renderer.frame(lights, background=0.1))
    assert matrices == []
    pictures(transfer, frames, tmp_path, direct="traced", samples=1, bounces=1, reflectance=0.3, layers=["direct"])
    wanted = sf.LampRenderer(transfer, None, SIZE).frame(frames[1], bounces=1, reflectance=0.3, layers=True)
    np.testing.assert_array_equal(sf.read_image(tmp_path / "a02.exr", "direct"), wanted["direct"])


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"direct": "sharp"}, "direct: wanted"),
        ({"direct": "traced", "shadow_cell": 0}, "shadow_cell: wanted"),
        (
            {"direct": "traced", "frames": [sf.Environment(1.0)]},
            "lights: wanted point, spot, photometric, area or",
        ),
        ({"transfer": 3}, "transfer: wanted a LocalTransfer, got int"),
        ({"frames": []}, "frames: wanted a list with the lights of at least one frame"),
        ({"frames": POINT}, "frames: wanted a list"),
        (
            {"frames": [sf.Environment(1.0)]},
            "lights: wanted point, spot, photometric, area .* got Environment",
        ),
        ({"path": "a.png"}, "path: wanted a pattern"),
        ({"size": 3}, "size: wanted"),
        ({"camera": 3}, "camera: wanted"),
        ({"fps": 0}, "fps: wanted"),
        ({"samples": 0}, "samples: wanted"),
        ({"layers": True}, "layers: a .png file has none"),
    ],
)
def test_what_is_refused(transfer, tmp_path, monkeypatch, options, said):
    monkeypatch.chdir(tmp_path)
    given = {"transfer": transfer, "frames": [POINT], "path": "a%d.png", "size": SIZE} | options
    with pytest.raises(ValueError, match=said):
        sf.animate_lamps(**given)


def test_a_film_can_be_cancelled(transfer, tmp_path):
    with pytest.raises(sf.Cancelled):
        sf.animate_lamps(transfer, [POINT] * 3, tmp_path / "a.gif", SIZE, progress=lambda done, total: done < 2)
    assert not list(tmp_path.iterdir())
