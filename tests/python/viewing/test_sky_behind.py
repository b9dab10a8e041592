"""The sky behind windows is that of pictures, pixel by pixel."""

import numpy as np
import pytest

import surflux as sf
from interactor import click_pixel, shot
from surflux.drawing import plots
from surflux.scenes import shapes
from surflux.solving.turning_light import TurningLight
from surflux.viewing.controls import listen
from surflux.viewing.subject import Subject
from surflux.viewing.turn_window import TurnView
from surflux.viewing.window import SceneView

SIZE = (200, 150)
FAR = (100.0, 200.0, -300.0)  # windows are drawn around an origin of their own
CAMERA = sf.Camera(np.add(FAR, [0.3, -3.0, 0.8]), np.add(FAR, [0.0, 0.0, 0.1]), fov=60)
SKY = sf.Environment(np.random.default_rng(0).uniform(0.1, 1.5, (16, 32, 3)), azimuth=20.0)


def ball(lights=()):
    unit = shapes.sphere(300)
    return sf.Scene([sf.Surfels(0.4 * unit.points + FAR, unit.normals)], lights, camera=CAMERA)


@pytest.fixture(scope="module")
def solution():
    return sf.solve(ball([SKY, sf.Environment([0.0, 0.1, 0.2])]), insert=False)


@pytest.fixture
def window():
    views = []

    def make(made):
        with plots.quiet_vtk():
            views.append(made())
            views[-1].frame(CAMERA)
        return views[-1]

    yield make
    for view in views:
        view.plotter.close()


def expect_sky(view, solution, image=None):
    """Where a picture shows nothing but sky, so does the window, at its own exposure; but where words stand."""
    image = shot(view) if image is None else image
    height, width, _ = image.shape
    layers = solution.render(
        view.camera(), (width, height), background=True, samples=1, layers=["radiance", "alpha", "index"]
    )
    exposure = np.pi * 2.0**view.stops / view.white()
    wanted = np.rint(255 * sf.tone_map(layers["radiance"], exposure=exposure, filmic=False))
    open_sky = layers["alpha"] == 0
    open_sky[: height // 3, width // 2 :] = False  # the caption
    open_sky[-height // 3 :, : width // 2] = False  # hints and sliders
    assert open_sky.mean() > 0.3
    # Disks are polygons here, whose rims may stand out of those of the picture by a pixel.
    assert (np.abs(image - wanted).max(axis=2)[open_sky] <= 1).mean() > 0.97


def is_white(image):
    return (image[len(image) // 3 :, : SIZE[0] // 8] == 255).all()


def test_the_sky_is_that_of_pictures(window, solution):
    view = window(lambda: SceneView(Subject(solution), size=SIZE, off_screen=True))
    expect_sky(view, solution)
    view.set_exposure(-1.5)
    expect_sky(view, solution)
    view.frame(sf.Camera(np.add(FAR, [1.0, 1.0, 3.0]), FAR, height=2.0))  # parallel rays see one colour
    expect_sky(view, solution)


def test_it_is_there_where_pictures_have_it(window, solution):
    view = window(lambda: SceneView(Subject(solution), size=SIZE, off_screen=True))
    view.set_light("direct")
    assert not is_white(shot(view))
    for change in (
        lambda: view.set_light("indirect"),
        lambda: view.set_color("irradiance"),
        lambda: view.set_color("reflectance"),
        lambda: view.set_color("area"),
    ):
        change()
        assert is_white(shot(view))
    view.set_light("all")
    view.set_color("radiosity")
    expect_sky(view, solution)
    dark = sf.solve(ball([sf.PointLight(np.subtract(FAR, [0, 3, 0]), 5.0)]), insert=False)
    assert is_white(shot(window(lambda: SceneView(Subject(dark), size=SIZE, off_screen=True))))


def test_it_follows_the_camera_in_blocks_while_that_moves(window, solution):
    view = window(lambda: SceneView(Subject(solution), size=SIZE, off_screen=True))
    listen(view, start=CAMERA)
    before = shot(view)
    mouse = view.plotter.iren.interactor
    mouse.SetEventInformation(20, 75, 0, 0, "\0", 0, None)
    mouse.LeftButtonPressEvent()
    mouse.SetEventInformation(60, 75, 0, 0, "\0", 0, None)
    mouse.MouseMoveEvent()
    moving = shot(view)[60:90, :20]
    assert (moving[::2] == moving[1::2]).all()
    assert (moving[:, ::2] == moving[:, 1::2]).all()
    mouse.LeftButtonReleaseEvent()
    after = shot(view)
    assert (np.abs(after - before).max(axis=2) > 10).mean() > 0.3
    expect_sky(view, solution, after)


@pytest.mark.slow
def test_a_click_moves_nothing(window, solution):
    view = window(lambda: SceneView(Subject(solution), size=SIZE, off_screen=True))
    listen(view, start=CAMERA)
    shot(view)
    click_pixel(view, 10, 75)
    expect_sky(view, solution)


def test_it_turns_with_its_light(window):
    transfer = sf.precompute_transfer(ball(), "distant")
    turning = TurningLight(transfer, SKY)
    view = window(lambda: TurnView(turning, size=SIZE, off_screen=True))
    expect_sky(view, turning.relight(0.0))
    view.turn(65.0, quick=True)
    expect_sky(view, turning.relight(65.0))
    view.turn(130.0)
    expect_sky(view, turning.relight(130.0))
