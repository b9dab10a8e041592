"""Gaussians drawn as viewers draw them, beside the surfels that they stand for."""

import numpy as np
import pytest

import surflux as sf
from splat_drawing import drawn
from surflux.scenes import shapes

SIZE = (160, 120)
CAMERA = sf.Camera([0, -4, 1], [0, 0, 0], fov=40)


def disk_of(mask):
    """The centre (column, row) of what is covered, and the radius of a disk of that area; coverage (h, w), 0 to 1."""
    rows, columns = np.indices(mask.shape) + 0.5
    area = mask.sum()
    return np.array([(columns * mask).sum() / area, (rows * mask).sum() / area]), np.sqrt(area / np.pi)


def inside(covered, rim):
    """The pixels whose surroundings, `rim` pixels each way, are covered too."""
    found = covered.copy()
    for axis in (0, 1):
        for step in range(-rim, rim + 1):
            found &= np.roll(covered, step, axis)
    return found


@pytest.mark.slow
def test_a_ball_has_its_place_its_size_and_its_colours():
    """Within a hundredth of black to white inside. Outside by the width of its Gaussians, which fall to one half within
    a standard deviation, and by the third of a pixel^2 that renderers add."""
    ball = shapes.sphere(2000).replace(reflectance=[0.8, 0.5, 0.3])
    light = np.zeros((4, 3))
    light[0], light[1:] = 4.0, [[0.5, -0.4, 0.2], [0.9, 0.8, 0.7], [-0.6, 0.1, 0.3]]
    solution = sf.solve(sf.Scene([ball], [sf.Environment.from_harmonics(light, 32)]))
    gaussians = sf.Gaussians.of(solution, exposure=0.9)
    found, through = drawn(gaussians, CAMERA, SIZE)
    layers = solution.render(CAMERA, SIZE, layers=["radiance", "albedo"])
    true = sf.tone_map(layers["radiance"], exposure=0.9, filmic=False)
    mask = (layers["albedo"] / [0.8, 0.5, 0.3]).mean(axis=2)
    center, radius = disk_of(1.0 - through)
    true_center, true_radius = disk_of(mask)
    np.testing.assert_allclose(center, true_center, atol=0.05)
    pixels = 0.5 * SIZE[1] / np.tan(np.radians(20)) / np.sqrt(17)  # of a unit of length at the ball
    assert 0.0 < radius - true_radius < pixels * gaussians.scales[:, 0].max() + np.sqrt(0.3)
    inner = inside(mask > 0.999, 4)
    assert inner.mean() > 0.15
    assert np.sqrt(((found - true)[inner] ** 2).mean()) < 0.01
    assert through[inner].max() < 1e-3  # two surfaces, of one percent each


@pytest.mark.parametrize("elevation", [90, 60, 30])
def test_the_far_side_of_a_sheet_shows_by_a_twentieth(elevation):
    """White in front, black behind; half of what is seen would be of the far side, were both at one place."""
    square = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]
    sheet = sf.Surfels.from_mesh((square, [[0, 1, 2, 3]]), patch_area=0.01, two_sided=True, emission=1.0)
    front = sheet.normals[:, 2] > 0
    dark = np.zeros((len(sheet), 3))
    sent = np.where(front[:, None], np.pi, dark)
    solution = sf.Solution(sheet, parents=range(800), objects=dark[:, 0], radiosity=sent, irradiance=dark, direct=dark)
    gaussians = sf.Gaussians.of(solution, exposure=1.0)
    angle = np.radians(elevation)
    camera = sf.Camera([0, -3 * np.cos(angle) - 1e-3, 3 * np.sin(angle)], [0, 0, 0], fov=40)
    alone, through = drawn(gaussians, camera, (120, 90), front)
    seen, _ = drawn(gaussians, camera, (120, 90))
    inner = inside(through < 0.03, 2)
    assert inner.mean() > 0.1
    assert (alone - seen)[inner].mean() < 0.05
    together = sf.Gaussians(
        sheet.points, *(getattr(gaussians, n) for n in ("scales", "rotations", "opacities")), gaussians.harmonics
    )
    mixed, _ = drawn(together, camera, (120, 90))
    assert (alone - mixed)[inner].mean() > 0.3


@pytest.mark.slow
def test_glossy_gaussians_look_as_from_the_eye():
    """Radiance towards the eye, coded, at the middle of Gaussians that are seen at the middle of a pixel."""
    light = np.zeros((4, 3))
    light[0], light[1:] = 4.0, [[0.5, -0.4, 0.2], [0.9, 0.8, 0.7], [-0.6, 0.1, 0.3]]
    ball = shapes.sphere(642).replace(reflectance=0.1, specular=0.7, exponent=5.0)
    solution = sf.precompute_transfer(sf.Scene([ball]), "distant").relight(light)
    gaussians = sf.Gaussians.of(solution, exposure=0.5)
    found, _ = drawn(gaussians, CAMERA, SIZE)
    towards = CAMERA.eye - ball.points
    exact = sf.tone_map(solution.radiance_towards(towards)[None], exposure=0.5, filmic=False)[0]
    column, row, _ = CAMERA.project(ball.points, SIZE).T
    facing = (towards * ball.normals).sum(axis=1) > 0.5 * np.linalg.norm(towards, axis=1)
    seen = found[row.astype(int), column.astype(int)]
    assert np.sqrt(((seen - exact)[facing] ** 2).mean()) < 0.03  # neighbours, a pixel, harmonics of degree 3
    dull = sf.tone_map(solution.radiosity[None] / np.pi, exposure=0.5, filmic=False)[0]
    assert np.sqrt(((seen - dull)[facing] ** 2).mean()) > 0.3
