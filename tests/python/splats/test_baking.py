"""Gaussians of a solution: their colours from everywhere, and the surface that they cover."""

import copy
import pickle

import numpy as np
import pytest
from scipy.special import spence

import splat_drawing
import surflux as sf
from quick import quick
from surflux.scenes import shapes

LIGHT = np.zeros((25, 3))
LIGHT[0] = 4.0
LIGHT[1:4] = [[0.5, -0.4, 0.2], [0.9, 0.8, 0.7], [-0.6, 0.1, 0.3]]
LIGHT[4:9] = 0.25
SQUARE = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]


def coded(linear):
    """sRGB of IEC 61966-2-1."""
    linear = np.clip(linear, 0.0, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def directions(n, seed=0):
    found = np.random.default_rng(seed).normal(size=(n, 3))
    return found / np.linalg.norm(found, axis=1, keepdims=True)


def ball(n=162, **material):
    unit = shapes.sphere(n)
    return sf.Surfels(unit.points, unit.normals, radii=unit.radii, **material)


def made(surfels, radiosity, **more):
    """A Solution of surfels that send what they are told to."""
    n, dark = len(surfels), np.zeros((len(surfels), 3))
    radiosity = np.broadcast_to(radiosity, (n, 3))
    return sf.Solution(surfels, parents=range(n), objects=[0] * n, radiosity=radiosity, irradiance=dark, direct=dark)


@pytest.fixture(scope="module")
def diffuse():
    surfels = ball()
    surfels.areas = sf.effective_areas(surfels)
    return made(surfels, np.random.default_rng(1).uniform(0, 4, (162, 3)))


@pytest.fixture(scope="module")
def transfer():
    return sf.precompute_transfer(sf.Scene([ball(reflectance=0.2, specular=0.7)]), "distant")


@pytest.mark.parametrize("degree", [None, 0, 3])
def test_diffuse_surfels_have_their_display_colour_from_everywhere(diffuse, degree):
    gaussians = sf.Gaussians.of(diffuse, degree=degree, exposure=0.7, stops=0.5)
    assert gaussians.degree == (degree or 0)
    expected = coded(0.7 * 2**0.5 * diffuse.radiosity / np.pi)
    for seed in range(5):
        towards = directions(162, seed)
        np.testing.assert_allclose(splat_drawing.colors(gaussians.harmonics, -towards), expected, atol=1e-6)
        np.testing.assert_allclose(gaussians.colors_towards(3.0 * towards), expected, atol=1e-6)


def test_the_brightest_percent_is_white_unless_told(diffuse):
    shown = sf.Gaussians.of(diffuse).colors_towards([0, 0, 1]).max(axis=1)
    assert np.count_nonzero(shown >= 1.0 - 1e-9) == 2  # 1 % of 162, rounded up
    white = np.percentile(diffuse.radiosity.max(axis=1), 99)
    np.testing.assert_allclose(shown, coded(diffuse.radiosity.max(axis=1) / white), atol=1e-6)


def test_linear_colours_are_light_itself(diffuse):
    gaussians = sf.Gaussians.of(diffuse, exposure=0.5, color_space="linear")
    assert gaussians.color_space == "linear"
    expected = np.clip(0.5 * diffuse.radiosity / np.pi, 0.0, 1.0)
    np.testing.assert_allclose(gaussians.colors_towards([1, 0, 0]), expected, atol=1e-12)


def best_fit(values, towards):
    """What degree 3 can do at most: the RMS of what is left of values (m, 3), least squares at the same directions."""
    basis = np.stack(
        [splat_drawing.colors(np.eye(16)[None, k, :, None].repeat(3, 2), -towards[i : i + 1])[0, 0]
         for i in range(len(towards)) for k in range(16)]
    )  # fmt: skip
    basis = basis.reshape(len(towards), 16) - 0.5
    left = values - basis @ np.linalg.lstsq(basis, values, rcond=None)[0]
    return np.sqrt((left**2).mean())


@pytest.mark.slow
@pytest.mark.parametrize("exponent", quick(5.0, of=[1.0, 5.0, 20.0, 60.0]))
def test_glossy_surfels_agree_with_radiance_towards_the_eye(transfer, exponent):
    """Within .01 of black to white as closely as harmonics of degree 3 can."""
    solution = transfer.relight(LIGHT, specular=[0.7, 0.5, 0.3], exponent=exponent)
    gaussians = sf.Gaussians.of(solution, exposure=0.5)
    assert gaussians.degree == 3
    normals = solution.surfels.normals
    # By the cosine, as pixels are covered: normals plus points of the unit sphere (Lambert's law).
    towards = [n / np.linalg.norm(n, axis=1, keepdims=True) for n in (normals + directions(162, k) for k in range(200))]
    true = np.stack([coded(0.5 * solution.radiance_towards(t)) for t in towards], 1)
    found = np.stack([splat_drawing.colors(gaussians.harmonics, -t) for t in towards], 1)
    towards = np.stack(towards, 1)
    for i in range(0, 162, 20):
        least = best_fit(true[i], towards[i])
        assert np.sqrt(((found[i] - true[i]) ** 2).mean()) < least + 0.01
    assert np.ptp(true, axis=1).max() > 0.2  # of black to white: colours do depend on the direction
    assert np.sqrt(((found - true) ** 2).mean()) < 0.02  # and what they leave is small, too


def test_from_behind_glossy_surfels_show_nothing_that_their_front_does_not(transfer):
    """To .1 of black to white; a fit to the front alone is off by .7 there."""
    solution = transfer.relight(LIGHT)
    gaussians = sf.Gaussians.of(solution, exposure=0.5)
    sides = [solution.surfels.normals + directions(162, k) for k in range(100)]
    front = np.stack([coded(0.5 * solution.radiance_towards(t)) for t in sides])
    behind = np.stack([gaussians.colors_towards(-t) for t in sides])
    assert (behind > front.min(axis=0) - 0.1).all()
    assert (behind < front.max(axis=0) + 0.1).all()


@pytest.mark.slow
def test_exposure_counts_what_lobes_send(transfer):
    """The mean in front is the exitance over pi: white is what 99 % of the surfels send less than."""
    solution = transfer.relight(LIGHT, reflectance=0.0, specular=0.7, exponent=1.0)
    assert solution.radiosity.max() == 0.0
    mean = np.mean([solution.radiance_towards(solution.surfels.normals + directions(162, k)) for k in range(300)], 0)
    automatic = sf.Gaussians.of(solution)
    told = sf.Gaussians.of(solution, exposure=1.0 / np.percentile(mean.max(axis=1), 99))
    seen = [g.colors_towards(solution.surfels.normals) for g in (automatic, told)]
    np.testing.assert_allclose(*seen, atol=0.02)


def test_diffuse_solutions_of_a_transfer_are_of_degree_0(transfer):
    assert sf.Gaussians.of(transfer.relight(LIGHT, specular=0.0)).degree == 0


# --- shapes ----------------------------------------------------------------------------------------------------------

LI2 = spence(1.0 - 0.99)  # the dilogarithm of .99


def test_disks_are_round_flat_and_face_their_normal(diffuse):
    gaussians, surfels = sf.Gaussians.of(diffuse), diffuse.surfels
    np.testing.assert_array_equal(gaussians.positions, surfels.points)
    s = np.sqrt(surfels.areas * np.log(100.0) / (2 * np.pi * LI2))
    np.testing.assert_allclose(gaussians.scales, np.stack([s, s, 0.01 * s], 1), rtol=1e-9)
    np.testing.assert_allclose(splat_drawing.axes(gaussians.rotations)[:, :, 2], surfels.normals, atol=1e-12)
    np.testing.assert_array_equal(gaussians.opacities, 0.99)


def test_patches_have_the_axes_of_their_second_moments():
    """The covariance of a rectangle is that of its edges, a^2/12 and b^2/12; that of a triangle with corners v_i around
    its centroid c is sum (v_i - c)(v_i - c)^T / 12."""
    corners = [[0, 0, 0], [3, 0, 0], [3, 1, 0], [0, 1, 0], [5, 5, 5], [5, 7, 6], [5, 6, 9]]
    surfels = sf.Surfels.from_mesh((corners, [[0, 1, 2, 3], [4, 5, 6]]))
    gaussians = sf.Gaussians.of(made(surfels, 1.0))
    turned = splat_drawing.axes(gaussians.rotations) * gaussians.scales[:, None, :]
    covariance = turned @ turned.transpose(0, 2, 1)
    triangle = np.subtract(corners[4:], np.mean(corners[4:], axis=0))
    moments = np.diag([9, 1, 0]) / 12, triangle.T @ triangle / 12
    for found, moment, area in zip(covariance, moments, surfels.areas, strict=True):
        two = np.linalg.eigvalsh(moment)[1:]
        widened = area * np.log(100.0) / (2 * np.pi * LI2) / np.sqrt(two.prod()) * moment
        np.testing.assert_allclose(found, widened, atol=2e-4 * np.trace(widened))  # thin, but not flat


def test_a_plane_lets_one_percent_through():
    """In the mean of the logarithm, exactly, whatever the pattern."""
    floor = sf.Surfels.from_mesh((np.multiply(SQUARE, [9, 9, 1]), [[0, 1, 2, 3]]), patch_area=1.0)
    assert len(floor) == 81
    gaussians = sf.Gaussians.of(made(floor, 1.0))
    x, y = (v.ravel() for v in np.meshgrid(*2 * [4.0 + (np.arange(40) + 0.5) / 40]))  # the patch in the middle
    way = (np.stack([x, y], 1)[:, None] - gaussians.positions[:, :2]) / gaussians.scales[:, :2]
    alpha = gaussians.opacities * np.exp(-0.5 * (way**2).sum(axis=2))
    through = np.log1p(-alpha).sum(axis=1)
    np.testing.assert_allclose(through.mean(), np.log(0.01), rtol=1e-6)
    assert np.exp(through).max() < 0.03


def test_surfels_without_a_share_of_the_surface_are_transparent():
    surfels = sf.Surfels([[0, 0, 0], [1, 0, 0]], [[0, 0, 1]] * 2, radii=0.5, areas=[0.7, 0.0])
    gaussians = sf.Gaussians.of(made(surfels, 1.0))
    assert gaussians.opacities.tolist() == [0.99, 0.0]
    assert gaussians.scales.min() > 0.0


def test_two_sides_at_one_place_are_moved_apart():
    sheet = sf.Surfels.from_mesh((SQUARE, [[0, 1, 2, 3]]), patch_area=0.01, two_sided=True)
    gaussians = sf.Gaussians.of(made(sheet, 1.0))
    moved = ((gaussians.positions - sheet.points) * sheet.normals).sum(axis=1)
    s = gaussians.scales[0, 0]
    np.testing.assert_allclose(moved, 0.5 * s, rtol=1e-9)
    # Thin walls too, up to a standard deviation apart in all; what faces another surface stays, floor and ceiling.
    for thick, expected in ((0.05, 0.5 * (s - 0.05)), (0.1, 0.0), (-0.05, 0.0)):
        below = np.eye(4)
        below[2, 3] = -thick
        wall = sf.concatenate([sheet[:100], sheet[100:].transformed(below)])
        found = sf.Gaussians.of(made(wall, 1.0)).positions - wall.points
        np.testing.assert_allclose((found * wall.normals).sum(axis=1), expected, atol=1e-12)


def test_any_solver_will_do(transfer):
    scene = sf.Scene([ball(reflectance=0.5)], [sf.Environment(1.0)])
    for solution in (sf.solve(scene), sf.solve_meshless(scene)):
        gaussians = sf.Gaussians.of(solution, exposure=1.0)
        assert len(gaussians) == len(solution.surfels)
        np.testing.assert_allclose(gaussians.colors_towards([1, 0, 0]), coded(0.5), atol=0.01)  # a convex body


# --- what they may be ------------------------------------------------------------------------------------------------


def test_arrays_cannot_be_written_to(diffuse):
    gaussians = sf.Gaussians.of(diffuse)
    for name in ("positions", "scales", "rotations", "opacities", "harmonics"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(gaussians, name)[0] = 0.0


@pytest.mark.parametrize("twin", [lambda g: pickle.loads(pickle.dumps(g)), copy.copy, copy.deepcopy])
def test_copies_and_pickles_are_alike(diffuse, twin):
    gaussians = sf.Gaussians.of(diffuse, color_space="linear")
    other = twin(gaussians)
    for name in ("positions", "scales", "rotations", "opacities", "harmonics"):
        np.testing.assert_array_equal(getattr(other, name), getattr(gaussians, name))
    assert repr(other) == repr(gaussians) == "Gaussians(162 Gaussians, degree 0, linear)"


def test_quaternions_are_brought_to_unit_length():
    given = [[2.0, 0, 0, 0], [0, 3.0, 4.0, 0], [1.0 + 1e-7, 0, 0, 0]]
    found = sf.Gaussians(np.zeros((3, 3)), np.ones((3, 3)), given, np.ones(3), np.zeros((3, 1, 3)))
    assert found.rotations.tolist() == [[1.0, 0, 0, 0], [0, 0.6, 0.8, 0], [1.0 + 1e-7, 0, 0, 0]]


GOOD = {
    "positions": np.zeros((2, 3)),
    "scales": np.ones((2, 3)),
    "rotations": [[1.0, 0, 0, 0]] * 2,
    "opacities": np.ones(2),
    "harmonics": np.zeros((2, 4, 3)),
}


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("positions", [[0, 0]]),
        ("positions", np.zeros((0, 3))),
        ("positions", [[0, 0, np.nan]] * 2),
        ("scales", np.ones((3, 3))),
        ("scales", -np.ones((2, 3))),
        ("rotations", np.zeros((2, 4))),
        ("rotations", np.zeros((2, 3))),
        ("opacities", [0.5, 1.5]),
        ("opacities", [0.5, -0.1]),
        ("harmonics", np.zeros((2, 3))),
        ("harmonics", np.zeros((2, 5, 3))),
        ("harmonics", np.zeros((1, 4, 3))),
        ("harmonics", np.full((2, 4, 3), np.inf)),
        ("color_space", "lin_rec709_display"),
    ],
)
def test_arrays_that_are_no_gaussians(name, value):
    with pytest.raises(ValueError, match=rf"^{name}: wanted"):
        sf.Gaussians(**GOOD | {name: value})


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"degree": 4}, "degree: wanted a whole number from 0 to 3, got 4"),
        ({"degree": 1.0}, "degree: wanted a whole number"),
        ({"exposure": 0.0}, "exposure: wanted values above 0"),
        ({"exposure": "bright"}, "exposure: wanted"),
        ({"stops": np.inf}, "stops: wanted a finite number"),
        ({"color_space": "sRGB"}, "color_space: wanted one of 'srgb', 'linear', got 'sRGB'"),
        ({"threads": 0}, "threads: wanted"),
        ({"progress": 1}, "progress: wanted"),
    ],
)
def test_arguments_out_of_range_are_refused(diffuse, arguments, message):
    with pytest.raises(ValueError, match=rf"^{message}"):
        sf.Gaussians.of(diffuse, **arguments)


def test_what_is_no_solution_is_refused(diffuse):
    with pytest.raises(ValueError, match=r"^solution: wanted a Solution, got Surfels$"):
        sf.Gaussians.of(diffuse.surfels)
    with pytest.raises(ValueError, match=r"^directions: wanted"):
        sf.Gaussians.of(diffuse).colors_towards([0, 0, 0])


def test_a_fit_tells_how_far_it_is_and_can_be_cancelled(transfer):
    told = []
    solution = transfer.relight(LIGHT)
    sf.Gaussians.of(solution, progress=lambda *step: told.append(step))
    assert told == [(k, 64) for k in range(65)]
    with pytest.raises(sf.Cancelled):
        sf.Gaussians.of(solution, progress=lambda done, total: done < 3)
