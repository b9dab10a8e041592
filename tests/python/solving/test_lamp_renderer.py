"""Frames under lamps that move: beside closed forms, path tracing of single pixels, and pictures of relit solutions."""

import copy
import pickle

import numpy as np
import pytest

import surflux as sf
from lamp_frames import LAYERS, errors
from surflux.bench.pictures import unproject

SIZE = (72, 54)
CAMERA = sf.Camera([0.5, -1.4, 0.5], [0.5, 0.5, 0.45])
POINT = sf.PointLight([0.4, 0.3, 0.75], [1.0, 0.8, 0.6])
AREA = sf.AreaLight([0.35, 0.4, 0.95], [0, 0.2, 0], [0.2, 0, 0], 5.0)
LAMPS = [POINT, AREA, sf.SpotLight([0.8, 0.2, 0.8], [-0.3, 0.3, -1], 0.5), sf.DirectionalLight([0, 1, -0.5], 0.3)]


def room_with_a_box():
    corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
    faces = [[0, 1, 2, 3], [4, 7, 6, 5], [3, 2, 6, 7], [0, 3, 7, 4], [1, 5, 6, 2]]
    room = sf.Surfels.from_mesh((corners, faces), patch_area=0.005, reflectance=[0.6, 0.5, 0.4])
    low, high = np.array([0.55, 0.5, 0.0]), np.array([0.8, 0.75, 0.35])
    box = np.where(np.array(corners) > 0.5, high, low)
    outside = [face[::-1] for face in [faces[1], faces[2], faces[3], faces[4], [0, 4, 5, 1]]]
    return [room, sf.Surfels.from_mesh((box, outside), patch_area=0.005, reflectance=[0.7, 0.7, 0.3])]


@pytest.fixture(scope="module")
def transfer():
    return sf.precompute_transfer(sf.Scene(sf.divide_patches(room_with_a_box()), camera=CAMERA), bounces=None)


@pytest.fixture(scope="module")
def renderer(transfer):
    return sf.LampRenderer(transfer, None, SIZE)


def test_a_frame_is_radiance_in_float32(renderer):
    picture = renderer.frame(POINT)
    assert (picture.shape, picture.dtype) == ((54, 72, 3), np.float32)
    assert set(renderer.frame_timings) == {"relight", "direct", "picture"}
    assert set(renderer.timings) == {"corners", "places", "field", "cells"}
    assert 0 < renderer.frame_rays < 54 * 72
    assert renderer.nbytes > 50 * 54 * 72
    assert renderer.camera == CAMERA


def test_layers_are_those_of_pictures(renderer, transfer):
    found = renderer.frame(LAMPS, layers=True)
    assert list(found) == ["radiance", "direct", "indirect", "albedo", "alpha", "normal", "depth", "index"]
    np.testing.assert_allclose(found["radiance"], found["direct"] + found["indirect"], rtol=1e-6)
    drawn = transfer.relight(LAMPS).render(size=SIZE, samples=1, layers=True)
    same = found["index"] == drawn["index"]  # but at edges, where rays and OpenGL round otherwise
    assert same.mean() > 0.98
    assert (found["index"] == -2).sum() > 5
    for name in ("albedo", "normal", "depth"):
        np.testing.assert_allclose(found[name][same], drawn[name][same], rtol=1e-4, atol=1e-4)
    lamp = found["index"] == -2
    np.testing.assert_allclose(found["radiance"][lamp], 5.0 / np.pi, rtol=1e-6)
    only = renderer.frame(LAMPS, layers=["depth", "indirect"])
    assert list(only) == ["depth", "indirect"]
    np.testing.assert_array_equal(only["indirect"], found["indirect"])


# Both have the same indirect light of surfels, one by kernels around, the other by corners.
def test_indirect_light_is_that_of_the_solution(renderer, transfer):
    found = renderer.frame(LAMPS, layers=["indirect"])["indirect"]
    drawn = transfer.relight(LAMPS).render(size=SIZE, samples=1, layers=["indirect"])["indirect"]
    assert np.sqrt(((found - drawn) ** 2).mean() / (drawn**2).mean()) < 0.03


@pytest.mark.slow
@pytest.mark.parametrize("lamp", [POINT, AREA], ids=["point", "area"])
def test_errors_beside_path_tracing_of_pixels(renderer, transfer, lamp):
    """Indirect light is as far off as transfer is of such a room, 2 to 4 %: what it is drawn by adds nothing to that.

    Of an area light, 16 strata are off by 1 / 16 / sqrt(12) in penumbrae, which are a tenth of the picture: .6 %.
    """
    found = errors(transfer, renderer, lamp, 400, 1024)
    assert found["frame"]["direct"] < (1e-5 if lamp is POINT else 0.01)
    assert found["frame"]["indirect"] < 0.05
    assert found["frame"]["radiance"] < 0.5 * found["render"]["radiance"]


def test_shadows_are_where_they_belong(transfer):
    """The upper edges of the box throw the outline of its shadow onto the floor, as the point light projects them."""
    size = 240, 180
    layers = sf.LampRenderer(transfer, None, size).frame(POINT, layers=True)
    places = unproject(CAMERA, layers["depth"], size)
    floor = (layers["index"] >= 0) & (np.abs(places[..., 2]) < 1e-6)
    lamp = np.array(POINT.position)
    at = lamp + (places[floor] - lamp) * (lamp[2] - 0.35) / lamp[2]  # at the height of the box's top
    inside = (np.abs(at[:, :2] - [0.675, 0.625]) < 0.125 - 1e-6).all(axis=1)
    assert inside.sum() > 50
    assert (layers["direct"][floor][inside] == 0).all()
    way = lamp - places[floor]
    kernel = way[:, 2] / np.linalg.norm(way, axis=1) ** 3
    lit = layers["direct"][floor][:, 0] > 0
    wanted = 0.6 / np.pi * kernel * POINT.intensity[0]
    np.testing.assert_allclose(layers["direct"][floor][lit, 0], wanted[lit], rtol=2e-6)


def test_frames_do_not_depend_on_threads_or_on_what_was_drawn_before(transfer, renderer):
    wanted = sf.LampRenderer(transfer, None, SIZE, threads=1).frame(LAMPS, threads=1)
    for k in range(100):
        renderer.frame(sf.PointLight([0.2 + 0.006 * k, 0.5, 0.7], 1.0), background=k)
    for threads in (None, 1, 2, 3):
        np.testing.assert_array_equal(renderer.frame(LAMPS, threads=threads), wanted)


def test_cells_are_a_matter_of_time(transfer, renderer):
    every = sf.LampRenderer(transfer, None, SIZE, shadow_cell=1)
    np.testing.assert_array_equal(every.frame(POINT), renderer.frame(POINT))
    assert every.frame_rays > 1.5 * renderer.frame_rays


def test_a_camera_that_moves_makes_its_own_part_anew(transfer):
    renderer = sf.LampRenderer(transfer, None, SIZE)
    first = renderer.frame(POINT)
    look = sf.Camera([0.3, -1.2, 0.7], [0.5, 0.5, 0.3])
    renderer.camera = look
    moved = renderer.frame(POINT)
    np.testing.assert_array_equal(moved, sf.LampRenderer(transfer, look, SIZE).frame(POINT))
    assert np.abs(moved - first).max() > 0.1
    renderer.camera = CAMERA
    np.testing.assert_array_equal(renderer.frame(POINT), first)
    plan = sf.LampRenderer(transfer, sf.Camera([0.5, 0.5, 3], [0.5, 0.5, 0], up=[0, 1, 0], height=1.2), (48, 48))
    found = plan.frame(POINT, layers=["index", "normal"])
    assert (found["index"] >= 0).mean() == pytest.approx((1 / 1.2) ** 2, abs=0.04)  # through the ceiling
    assert (found["normal"][found["index"] >= 0][:, 2] == 1).mean() > 0.95


def test_both_sides(transfer):
    outside = sf.Camera([0.5, 0.5, 3], [0.5, 0.5, 0], up=[0, 1, 0])
    culled = sf.LampRenderer(transfer, outside, SIZE).frame(POINT, layers=["depth"])["depth"]
    whole = sf.LampRenderer(transfer, outside, SIZE, culling=False)
    found = whole.frame(POINT, layers=["depth", "normal", "direct"])
    middle = 27, 36
    assert culled[middle] > 2.5
    assert found["depth"][middle] == pytest.approx(2.0, abs=1e-5)  # the ceiling, from behind
    assert found["normal"][middle][2] == 1.0
    assert found["direct"][middle].min() > 0.0  # in the light of its front


def test_reflectance_and_bounces(transfer, renderer):
    own = np.concatenate([s.reflectance for s in transfer.scene.objects])
    np.testing.assert_array_equal(renderer.frame(POINT, reflectance=own), renderer.frame(POINT))
    none = renderer.frame(POINT, bounces=0, layers=LAYERS)
    np.testing.assert_array_equal(none["indirect"], 0.0)
    np.testing.assert_array_equal(none["direct"], renderer.frame(POINT, layers=LAYERS)["direct"])
    black = renderer.frame(POINT, reflectance=0.0, layers=[*LAYERS, "albedo"])
    assert not any(black[name].any() for name in black)
    grey = renderer.frame(POINT, reflectance=0.3, layers=["albedo"])["albedo"]
    assert np.unique(grey.round(6)).tolist() == [0.0, np.float32(0.3).round(6)]


def test_emission_and_background():
    glowing = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]), 0.1, emission=np.pi)
    shown = sf.LampRenderer(sf.precompute_transfer(sf.Scene([glowing])), sf.Camera([0.5, -2, 1], [0.5, 0.5, 0]), SIZE)
    found = shown.frame([], background=[1, 2, 3], layers=["radiance", "index"])
    np.testing.assert_allclose(found["radiance"][found["index"] >= 0], 1.0, rtol=1e-6)
    np.testing.assert_allclose(found["radiance"][found["index"] < 0], [[1, 2, 3]] * (found["index"] < 0).sum())


@pytest.mark.slow
def test_disks_blend():
    """A ball of disks is as round as its pictures are."""
    rng = np.random.default_rng(0)
    normals = rng.normal(size=(2000, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    ball = sf.Surfels([0, 0, 0.5] + 0.5 * normals, normals, reflectance=[0.8, 0.5, 0.3])
    floor = sf.Surfels.from_mesh(([[-2, -2, 0], [2, -2, 0], [2, 2, 0], [-2, 2, 0]], [[0, 1, 2, 3]]), patch_area=0.02)
    transfer = sf.precompute_transfer(sf.Scene([ball, floor], camera=sf.Camera([0.5, -3.2, 1.6], [0, 0, 0.4], fov=40)))
    lamp = sf.PointLight([1.5, -1, 2.5], 10.0)
    found = sf.LampRenderer(transfer, None, (120, 90)).frame(lamp, layers=True)
    drawn = transfer.relight(lamp).render(size=(120, 90), samples=1, layers=True)
    np.testing.assert_array_equal(found["index"], drawn["index"])
    on_ball = (found["index"] >= 0) & (found["index"] < 2000)
    for name in ("albedo", "normal", "depth"):
        np.testing.assert_allclose(found[name][on_ball], drawn[name][on_ball], rtol=1e-5, atol=1e-5)
    places = unproject(transfer.scene.camera, found["depth"], (120, 90))[on_ball]
    way = lamp.position - places
    kernel = np.maximum(0, (way * found["normal"][on_ball]).sum(axis=1)) / np.linalg.norm(way, axis=1) ** 3
    wanted = kernel[:, None] * 10.0 * found["albedo"][on_ball] / np.pi
    bright = kernel > 0.02  # beyond, disks stand in the light of others
    np.testing.assert_allclose(found["direct"][on_ball][bright], wanted[bright], rtol=1e-4)


def test_subpixels(transfer):
    fine = sf.LampRenderer(transfer, None, (2 * SIZE[0], 2 * SIZE[1])).frame(POINT)
    mean = sf.LampRenderer(transfer, None, SIZE, samples=2).frame(POINT)
    np.testing.assert_allclose(mean, fine.reshape(SIZE[1], 2, SIZE[0], 2, 3).mean(axis=(1, 3)), rtol=1e-5, atol=1e-7)


def test_transfer_that_was_saved_and_copied(transfer, renderer, tmp_path):
    wanted = renderer.frame(LAMPS)
    for other in (sf.load_transfer(transfer.save(tmp_path / "a.transfer")), pickle.loads(pickle.dumps(transfer))):
        np.testing.assert_array_equal(sf.LampRenderer(other, CAMERA, SIZE).frame(LAMPS), wanted)
    assert copy.copy(transfer) is transfer


def test_getting_ready_can_be_cancelled(transfer):
    with pytest.raises(sf.Cancelled):
        sf.LampRenderer(transfer, None, SIZE, progress=lambda done, total: False)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"transfer": 3}, "transfer: wanted a LocalTransfer, got int"),
        ({"camera": 3}, "camera: wanted a Camera, got int"),
        ({"size": 3}, r"size: wanted \(width, height\), got 3"),
        ({"size": (0, 10)}, "size: wanted"),
        ({"samples": 0}, "samples: wanted"),
        ({"samples": 9}, "samples: wanted"),
        ({"culling": 1}, "culling: wanted"),
        ({"shadow_cell": 0}, "shadow_cell: wanted"),
        ({"shadow_cell": 65}, "shadow_cell: wanted"),
        ({"threads": 0}, "threads: wanted"),
    ],
)
def test_what_is_refused(transfer, options, said):
    with pytest.raises(ValueError, match=said):
        sf.LampRenderer(**({"transfer": transfer, "size": SIZE} | options))


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"lights": 3}, "lights: wanted"),
        (
            {"lights": sf.Environment(1.0)},
            "lights: wanted point, spot, photometric, area .* got Environment",
        ),
        ({"layers": "depth"}, "layers: wanted"),
        ({"layers": ["level"]}, "layers: wanted"),
        ({"background": [1, 2]}, "background: wanted"),
        ({"reflectance": 1.0}, "reflectance: wanted"),
        ({"bounces": -1}, "bounces: wanted"),
        ({"shadow_rays": 0}, "shadow_rays: wanted"),
        ({"penumbra_rays": 0}, "penumbra_rays: wanted"),
        ({"seed": -1}, "seed: wanted"),
        ({"threads": 0}, "threads: wanted"),
    ],
)
def test_what_a_frame_refuses(renderer, options, said):
    with pytest.raises(ValueError, match=said):
        renderer.frame(**({"lights": POINT} | options))


def test_a_camera_that_is_none_is_refused(renderer):
    with pytest.raises(ValueError, match="camera: wanted a Camera, got NoneType"):
        renderer.camera = None
    renderer.frame(POINT)


def test_frames_after_areas_were_set_are_refused_as_relit_solutions_are():
    floor = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]), patch_area=0.1)
    disks = sf.Surfels(floor.points, floor.normals, radii=0.2, areas=0.05)
    transfer = sf.precompute_transfer(sf.Scene([disks], camera=CAMERA))
    renderer = sf.LampRenderer(transfer, None, (8, 6))
    disks.areas = 2.0 * disks.areas
    for light in (transfer.relight, renderer.frame):
        with pytest.raises(ValueError, match=r"^scene: areas of its surfels were set after precompute_transfer"):
            light(POINT)
