"""Spherical harmonics, against scipy's, closed forms, quadrature and the published numbers of a probe."""

import numpy as np
import pytest
from scipy import integrate, special
from scipy.spatial.transform import Rotation

import surflux as sf


def directions(n, seed=0):
    d = np.random.default_rng(seed).normal(size=(n, 3))
    return d / np.linalg.norm(d, axis=1, keepdims=True)


def quadrature(degree):
    """Directions and weights that integrate polynomials of that degree exactly."""
    z, weights = np.polynomial.legendre.leggauss(degree // 2 + 1)
    phi = 2 * np.pi * np.arange(degree + 1) / (degree + 1)
    z, p = (a.ravel() for a in np.meshgrid(z, phi, indexing="ij"))
    r = np.sqrt(1 - z * z)
    return np.c_[r * np.cos(p), r * np.sin(p), z], np.repeat(weights * 2 * np.pi / (degree + 1), degree + 1)


def white_above(height=2):
    """Radiance 1 in the upper half, 0 in the lower one."""
    image = np.zeros((height, 1, 3))
    image[: height // 2] = 1.0
    return sf.Environment(image)


@pytest.mark.parametrize("order", [1, 2, 5, 10, 32])
def test_agree_with_those_of_scipy(order):
    """Of which they are real and imaginary parts, without the Condon-Shortley phase (-1)^m; at the poles, too."""
    d = np.r_[directions(200), np.eye(3), -np.eye(3)]
    theta, phi = np.arccos(np.clip(d[:, 2], -1, 1)), np.arctan2(d[:, 1], d[:, 0])
    expected = np.empty((len(d), order**2))
    for band in range(order):
        for m in range(-band, band + 1):
            complex_one = (-1) ** m * special.sph_harm_y(band, abs(m), theta, phi)
            part = complex_one.imag if m < 0 else complex_one.real
            expected[:, band * (band + 1) + m] = part * (1 if m == 0 else np.sqrt(2))
    # arccos loses half of the digits beside the poles, where band 31 changes fastest: 1e-16 * 32^2 * max |Y| there.
    np.testing.assert_allclose(sf.spherical_harmonics(d, order), expected, atol=1e-11)


def test_are_orthonormal():
    d, weights = quadrature(2 * 31)
    basis = sf.spherical_harmonics(d, 32)
    np.testing.assert_allclose(basis.T @ (weights[:, None] * basis), np.eye(32**2), atol=1e-12)


def test_band_1_is_the_direction():
    d = directions(20)
    band = np.sqrt(3 / (4 * np.pi)) * d[:, [1, 2, 0]]
    np.testing.assert_allclose(sf.spherical_harmonics(3 * d, 2)[:, 1:], band, atol=1e-15)


@pytest.mark.parametrize("order", [2, 5, 10, 32])
def test_a_rotated_function_is_the_function_of_the_direction_turned_back(order):
    rng = np.random.default_rng(order)
    axes = [Rotation.random(rng=rng).as_matrix() for _ in range(4)]
    quarter = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    half_turns = [np.diag([1, -1, -1]), np.diag([-1, 1, -1])]
    coefficients, d = rng.normal(size=(order**2, 3)), directions(50)
    for rotation in [*axes, quarter, *half_turns, np.eye(3)]:
        turned = sf.rotate_harmonics(coefficients, rotation)
        expected = sf.spherical_harmonics(d @ rotation, order) @ coefficients  # rotation.T @ each d
        np.testing.assert_allclose(sf.spherical_harmonics(d, order) @ turned, expected, atol=1e-10)
        np.testing.assert_allclose(turned[:, 1], sf.rotate_harmonics(coefficients[:, 1], rotation), atol=1e-14)


def test_rotations_follow_each_other():
    first, second = Rotation.random(2, rng=np.random.default_rng(1)).as_matrix()
    c = np.random.default_rng(2).normal(size=100)
    both = sf.rotate_harmonics(sf.rotate_harmonics(c, first), second)
    np.testing.assert_allclose(sf.rotate_harmonics(c, second @ first), both, atol=1e-12)


def test_a_rotation_in_single_precision_is_taken_for_the_nearest():
    rotation = Rotation.random(rng=np.random.default_rng(3)).as_matrix().astype(np.float32)
    c = np.random.default_rng(4).normal(size=25)
    assert np.linalg.norm(sf.rotate_harmonics(c, rotation)) == pytest.approx(np.linalg.norm(c), rel=1e-13)


@pytest.mark.parametrize(
    ("rotation", "said"),
    [
        (np.diag([1, 1, -1.0]), r"^rotation: wanted a rotation matrix, got one that mirrors"),
        (np.diag([1, 1, 1.001]), r"^rotation: wanted a rotation matrix, got rows that are not of unit length .*0\.002"),
    ],
)
def test_what_is_no_rotation_is_refused(rotation, said):
    with pytest.raises(ValueError, match=said):
        sf.rotate_harmonics(np.ones(25), rotation)


@pytest.mark.parametrize("count", [2, 24, 33**2])
def test_a_count_that_is_no_square_is_refused(count):
    with pytest.raises(ValueError, match=rf"^coefficients: wanted 1, 4, 9, .* at most 1024, got {count}$"):
        sf.rotate_harmonics(np.ones(count), np.eye(3))


def test_products_are_products_of_the_values():
    rng = np.random.default_rng(5)
    a, b, d = rng.normal(size=(25, 3)), rng.normal(size=(9, 3)), directions(40)
    values = (sf.spherical_harmonics(d, 5) @ a) * (sf.spherical_harmonics(d, 3) @ b)
    product = sf.multiply_harmonics(a, b, order=7)  # bands 4 + 2: all that there are
    np.testing.assert_allclose(sf.spherical_harmonics(d, 7) @ product, values, atol=1e-12)
    np.testing.assert_allclose(sf.multiply_harmonics(a, b), product[:25], atol=1e-13)
    np.testing.assert_allclose(sf.multiply_harmonics(b, a[:, 0], order=7)[:, 0], product[:, 0], atol=1e-13)
    assert sf.multiply_harmonics(a[:, 0], b[:, 0]).shape == (25,)
    with pytest.raises(ValueError, match=r"^b: wanted 3 channels, as a has, or one, got 2$"):
        sf.multiply_harmonics(a, b[:, :2])


def test_tripling_coefficients_by_wigner_s_rule():
    """The integral of Y_20^3 is sqrt(5 / pi) / 7 by Gaunt's formula: z^2 - 1/3 cubed."""
    y20 = np.eye(9)[6]
    assert sf.multiply_harmonics(y20, y20)[6] == pytest.approx(np.sqrt(5 / np.pi) / 7, abs=1e-14)


def test_irradiance_is_the_clamped_cosine_s():
    """DESIGN section 7: pi, 2 pi/3, pi/4, 0, -pi/24."""
    bands = sf.convolve_harmonics(np.ones(25))[[0, 2, 6, 12, 20]]
    np.testing.assert_allclose(bands, [np.pi, 2 * np.pi / 3, np.pi / 4, 0, -np.pi / 24], atol=1e-15)


@pytest.mark.parametrize("exponent", [0.0, 0.5, 1.0, 4.0, 20.0, 1000.0])
def test_lobes_are_integrals_of_legendre_polynomials(exponent):
    """Of which the factors of the bands are 2 pi times the integral of z^exponent P_l over [0, 1]."""
    factors = sf.convolve_harmonics(np.ones(100), exponent)[[band * (band + 1) for band in range(10)]]
    for band in range(10):

        def part(t, band=band):  # with z = t^2, which makes a root into a polynomial
            return 2 * t * t ** (2 * exponent) * special.eval_legendre(band, t**2)

        integral, _ = integrate.quad(part, 0, 1, epsabs=1e-13, limit=200)
        assert factors[band] == pytest.approx(2 * np.pi * integral, abs=1e-12)


def test_a_narrow_lobe_gives_the_function_itself():
    c = np.random.default_rng(6).normal(size=25)
    mean = 1e9 / (2 * np.pi) * sf.convolve_harmonics(c, 1e9)
    np.testing.assert_allclose(mean, c, atol=1e-7)


def test_the_half_sphere_in_closed_form():
    """Band l, m = 0: sqrt((2 l + 1) pi) times the integral of P_l over [0, 1]; none of m != 0; whatever the rows."""
    expected = np.zeros(36)
    for band, integral in enumerate([1, 1 / 2, 0, -1 / 8, 0, 1 / 16]):
        expected[band * (band + 1)] = np.sqrt((2 * band + 1) * np.pi) * integral
    for height in (2, 20, 400):
        np.testing.assert_allclose(white_above(height).harmonics(6)[:, 1], expected, atol=1e-13)


@pytest.mark.parametrize("shape", [(1, 1), (1, 3), (2, 1), (7, 5), (64, 128)])
def test_pixels_are_integrated_as_the_path_tracer_has_them(shape):
    """Constant within their borders: against many directions of each, at angles of their own."""
    image = np.random.default_rng(7).random((*shape, 3))
    fine = 1600 // shape[0] + 1, 1600 // shape[1] + 1
    theta = np.pi * (np.arange(fine[0] * shape[0]) + 0.5) / (fine[0] * shape[0])
    phi = np.pi - 2 * np.pi * (np.arange(fine[1] * shape[1]) + 0.5) / (fine[1] * shape[1])
    ring = np.stack([np.cos(phi), np.sin(phi)], axis=-1)
    expected = np.zeros((16, 3))
    for k, t in enumerate(theta):
        d = np.c_[np.sin(t) * ring, np.full(len(phi), np.cos(t))]
        radiance = np.repeat(image[k // fine[0]], fine[1], axis=0)
        expected += sf.spherical_harmonics(d, 4).T @ radiance * np.sin(t)
    expected *= np.pi / len(theta) * 2 * np.pi / len(phi)
    # The midpoint rule of 1600 angles: some (pi / 1600)^2 / 24 of second derivatives up to l^2.
    np.testing.assert_allclose(sf.Environment(image).harmonics(4), expected, atol=2e-5)


def test_up_and_azimuth_turn_the_light():
    image = np.random.default_rng(8).random((16, 32, 3))
    plain = sf.Environment(image).harmonics()
    up = np.array([0.48, -0.6, 0.64])
    shortest = Rotation.from_rotvec(np.arccos(up[2]) * np.array([0.6, 0.48, 0]) / np.hypot(0.6, 0.48)).as_matrix()
    np.testing.assert_allclose(shortest @ [0, 0, 1], up, atol=1e-12)
    around = Rotation.from_rotvec(np.radians(40) * up).as_matrix()
    turned = sf.Environment(image, up=up, azimuth=40).harmonics()
    np.testing.assert_allclose(turned, sf.rotate_harmonics(plain, around @ shortest), atol=1e-12)


def test_irradiance_of_five_bands_is_that_of_the_path_tracer():
    """The clamped cosine leaves out bands 6, 8, ... of a smooth sky, which has none: exact but for the samples."""
    smooth = np.full((25, 3), 0.0)
    smooth[[0, 1, 2, 3, 6, 8]] = [[4, 3, 2], [1, 0, 1], [0.5, 1, 0], [0.3, 0, 0.3], [0.5, 0.2, 0], [0, 0.4, 0.1]]
    theta, phi = np.pi * (np.arange(128) + 0.5) / 128, np.pi - np.pi * (np.arange(256) + 0.5) / 128
    t, p = np.meshgrid(theta, phi, indexing="ij")
    d = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], axis=-1).reshape(-1, 3)
    sky = sf.Environment((sf.spherical_harmonics(d) @ smooth).reshape(128, 256, 3))
    speck = sf.Surfels([[0, 0, -1e3]], [[0, 0, 1]], radii=1e-3)
    normals = directions(8)
    expected = sf.spherical_harmonics(normals) @ sf.convolve_harmonics(smooth)
    value, error = sf.reference_irradiance(sf.Scene([speck], [sky]), np.zeros((8, 3)), normals, samples=4096)
    assert np.abs((value - expected) / error).max() < 4.5  # 24 numbers of t with 63 degrees of freedom
    assert error.max() < 0.02


# Debevec's Grace cathedral: published by Ramamoorthi and Hanrahan (2001), L00, L1-1, L10, L11, L2-2, ..., L22.
GRACE = np.array(
    [
        [0.78908, 0.43710, 0.54161],
        [0.39499, 0.34989, 0.60488],
        [-0.33974, -0.18236, -0.26940],
        [-0.29213, -0.05562, 0.00944],
        [-0.11141, -0.05090, -0.12231],
        [-0.26240, -0.22401, -0.47479],
        [-0.15570, -0.09471, -0.14733],
        [0.56014, 0.21444, 0.13915],
        [0.21205, -0.05432, -0.30374],
    ]
)


@pytest.mark.scans
def test_the_grace_probe_has_its_published_coefficients(scans):
    """The image is the probe times .1, and the published axes are a rotation of its own: (X, Y, Z) = (-y, -z, x).

    Both are mirrored: the file has its rows from below, and the publication, of a probe that shows what is ahead in its
    middle, has X to the right, Y upwards and Z ahead, which is left-handed. The cathedral set upright, image[::-1], is
    in axes that no rotation takes to those.
    """
    image = sf.read_image(scans / "probes" / "grace_latlong.exr")
    probe = sf.Environment(10.0 * image.astype(float)).harmonics(order=3)
    found = sf.rotate_harmonics(probe, [[0, -1, 0], [0, 0, -1], [1, 0, 0]])
    np.testing.assert_allclose(found, GRACE, atol=0.005)
