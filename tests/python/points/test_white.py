"""What is white of the colours of files: 1, 255 or 65535."""

import warnings

import numpy as np
import pytest

import surflux as sf

N = 1000


@pytest.fixture
def ball():
    normals = np.random.default_rng(0).normal(size=(N, 3))
    return normals / np.linalg.norm(normals, axis=1)[:, None]


def written(path, normals, colors):
    """A file of points with normals and colours, by its suffix."""
    if path.suffix == ".npz":
        np.savez(path, points=normals, normals=normals, colors=colors)
        return path
    names = ["x", "y", "z", "nx", "ny", "nz", "red", "green", "blue"]
    lines = "".join(f"property float {name}\n" for name in names)
    head = f"ply\nformat ascii 1.0\nelement vertex {len(normals)}\n{lines}end_header\n"
    with open(path, "w") as file:
        file.write(head if path.suffix == ".ply" else " ".join(names) + "\n")
        np.savetxt(file, np.hstack([normals, normals, colors]), fmt="%.6f")
    return path


@pytest.mark.parametrize("suffix", ["ply", "xyz", "npz"])
def test_a_fraction_above_1_is_white(tmp_path, ball, suffix):
    """As interpolation leaves it: all other colours were 255 times darker."""
    colors = np.random.default_rng(1).uniform(0.5, 0.9, (N, 3))
    wanted = sf.read(written(tmp_path / f"inside.{suffix}", ball, colors)).reflectance
    colors[7] = [1.02, 0.5, 0.5]
    with pytest.warns(UserWarning, match=f"beyond.{suffix}: 1 of 1000 colours are brighter than white, which is 1:"):
        found = sf.read(written(tmp_path / f"beyond.{suffix}", ball, colors)).reflectance
    np.testing.assert_allclose(np.delete(found, 7, axis=0), np.delete(wanted, 7, axis=0), rtol=1e-6)
    assert found[7, 0] == pytest.approx(0.98)


@pytest.mark.parametrize(("scale", "white"), [(1.1, 1.0), (200.0, 255.0), (3.0, 255.0), (60000.0, 65535.0)])
def test_what_is_white_goes_by_most(tmp_path, ball, scale, white):
    """A few that are brighter do not change it, nor do those that are black for want of a colour."""
    colors = scale * np.random.default_rng(1).uniform(0.5, 0.8, (N, 3))
    if scale > 2:
        colors = np.rint(colors)
    colors[: N // 2] = 0
    with pytest.warns(UserWarning, match=r"ball.npz: 500 of 1000 colours are black \(0, 0, 0\)"):
        found = sf.read(written(tmp_path / "ball.npz", ball, colors)).reflectance
    encoded = colors[-1] / white
    np.testing.assert_allclose(
        found[-1], 0.98 * np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4), rtol=1e-5
    )


@pytest.mark.parametrize("suffix", ["ply", "xyz", "npz"])
def test_many_black_colours_are_warned_of(tmp_path, ball, suffix):
    """Files write black where a scan has no colour; a few shadows are black indeed."""
    colors = np.full((N, 3), 100.0)
    colors[:10] = 0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sf.read(written(tmp_path / f"few.{suffix}", ball, colors))
        sf.read_scan(written(tmp_path / f"few.{suffix}", ball, colors))
    colors[:30] = 0
    for read in (sf.read, sf.read_scan):
        with pytest.warns(UserWarning, match=rf"many.{suffix}: 30 of 1000 colours are black \(0, 0, 0\), as where"):
            read(written(tmp_path / f"many.{suffix}", ball, colors))


def test_colours_that_show_light_may_be_black(tmp_path, ball):
    """Reflectance stands beside them in what solutions are saved as."""
    scene = sf.Scene([sf.Surfels(ball, ball, reflectance=0.5)], [sf.DirectionalLight([0, 0, -1], 1.0)])
    path = tmp_path / "lit.ply"
    sf.solve(scene).save(path)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for read in (sf.load_solution, sf.read, sf.read_scan):
            read(path)


def test_one_of_few_does_not_say_what_white_is(tmp_path, ball):
    colors = np.full((50, 3), 0.8)
    colors[7] = 5.0
    with pytest.warns(UserWarning, match="1 of 50 colours are brighter than white, which is 1:"):
        found = sf.read(written(tmp_path / "few.npz", ball[:50], colors)).reflectance
    assert np.median(found) == pytest.approx(0.59, abs=0.01)


def test_whole_numbers_are_no_fractions(tmp_path, ball):
    """Floats of a dark file of 255, most of them 1."""
    colors = np.tile([1.0, 0.0, 1.0], (N, 1))
    colors[:5] = 255.0
    found = sf.read(written(tmp_path / "dark.npz", ball, colors)).reflectance
    assert found[-1, 0] == pytest.approx(0.98 / 255 / 12.92, rel=1e-5)


def test_eight_bits_in_sixteen(tmp_path):
    laspy = pytest.importorskip("laspy")
    header = laspy.LasHeader(point_format=2, version="1.2")
    header.scales = [0.001] * 3
    las = laspy.LasData(header)
    las.x, las.y, las.z = np.random.default_rng(0).uniform(0, [[40], [40], [0.1]], (3, N))
    las.red, las.green, las.blue = np.full((3, N), 120, dtype=np.uint16)
    las.red[3] = 300
    las.write(tmp_path / "floor.las")
    with pytest.warns(UserWarning, match="1 of 1000 colours are brighter than white, which is 255"):
        found = sf.read(tmp_path / "floor.las").reflectance
    assert np.median(found) == pytest.approx(0.183, abs=0.002)
