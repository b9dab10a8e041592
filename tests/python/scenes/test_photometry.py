"""Photometry of luminaires: its files, its symmetries, and the light that it gives, in closed form and beside spots."""

from functools import partial

import numpy as np
import pytest

import surflux as sf
from cases.builders import cube_inside
from scenes import patch, same_bits
from surflux.scenes.scene_arrays import scene_arrays, scene_of_arrays
from surflux.viewing.lamps import lamps_text

X, Y = np.eye(3)[:2]
GAMMA = np.arange(0.0, 91.0)
FLAT = sf.Photometry([0.0], GAMMA, [100.0 * np.cos(np.radians(GAMMA))])

IES = """IESNA:LM-63-2002
[TEST] none
[LUMINAIRE] of a test
TILT=NONE
1 1000 2 3 4 1 2 .1 .2 .05
.5 1 36
0 45 90
0, 30, 60, 90
100 80 10   100 70 10
100 60 10   100
50 0
"""
# The same: 2 * .5 times what stands there is cd, of 500 lm cd per 1000 lm and a conversion of 2.
LDT = "\n".join(
    ["maker", "1", "4", "12", "30", "3", "45", "report", "a luminaire", "n", "f", "date", "100", "100", "50"]
    + ["100", "100", "0", "0", "0", "0", "100", "100", "2,0", "0", "1"]
    + ["1", "LED", "500", "830", "80", "36"]
    + ["0.5"] * 10
    + [str(30 * k) for k in range(12)]
    + ["0", "45", "90"]
    + ["100", "80", "10", "100", "70", "10", "100", "60", "10", "100", "50", "0"]
)


@pytest.fixture
def files(tmp_path):
    """Writes a file of that name and gives its path."""

    def write(name, text):
        path = tmp_path / name
        path.write_text(text, encoding="latin-1")
        return path

    return write


def test_both_files_tell_the_same(files):
    wanted = sf.Photometry([0, 30, 60, 90], [0, 45, 90], [[100, 80, 10], [100, 70, 10], [100, 60, 10], [100, 50, 0]])
    of_ies, of_eulumdat = (sf.read_photometry(files(*one)) for one in (("a.ies", IES), ("b.LDT", LDT)))
    assert of_ies == wanted
    assert of_eulumdat == wanted
    assert repr(of_ies) == "Photometry(4 x 3 intensities up to 100 cd, of a.ies)"
    assert sf.PhotometricLight([0, 0, 1], of_ies.source).photometry == wanted


def test_tilts_and_factors_of_old_files(files):
    text = IES.replace("TILT=NONE", "TILT=INCLUDE\n1\n2\n0 90\n1 .8").replace(".5 1 36", ".5 .5 36")
    assert sf.read_photometry(files("a.ies", text)).candela[0, 0] == 50.0


@pytest.mark.parametrize(
    ("change", "told"),
    {
        "type": (("4 1 2 .1", "4 2 2 .1"), "photometry of type B: wanted type C"),
        "no tilt": (("TILT=NONE", ""), "no IES file: it has no line TILT="),
        "cut off": (("50 0\n", ""), "ends before its candela values"),
        "letters": (("100 60 10", "100 60 ten"), r"\(line 10\): candela values: wanted a number, got 'ten'"),
        "count": (("2 3 4 1", "2 3 4.5 1"), r"\(line 5\): number of horizontal angles: wanted a whole number"),
        "order": (("0 45 90", "0 90 45"), "angles: wanted two or more in ascending order"),
        "negative": (("50 0\n", "50 -1\n"), "candela: wanted"),
        "planes": (("0, 30, 60, 90", "10 30 60 90"), "planes: wanted them from 0 on, or from 90 to 270"),
    }.values(),
    ids=lambda one: one if isinstance(one, str) else one[1][:6],
)
def test_damaged_ies_files(files, change, told):
    assert change[0] in IES
    with pytest.raises(sf.FileError, match=told):
        sf.read_photometry(files("a.ies", IES.replace(*change)))


@pytest.mark.parametrize("kept", range(0, LDT.count("\n"), 3))
def test_eulumdat_files_that_end_too_soon(files, kept):
    with pytest.raises(sf.FileError, match=r"a\.ldt"):
        sf.read_photometry(files("a.ldt", "\n".join(LDT.split("\n")[:kept])))


@pytest.mark.parametrize("line", [2, 3, 5, 23, 25, 28, 45, 60])
@pytest.mark.parametrize("text", ["nan", "inf", "many", "-1"])
def test_eulumdat_files_with_wrong_numbers(files, line, text):
    lines = LDT.split("\n")
    lines[line] = text
    if (line, text) == (23, "-1") or (line, text) == (28, "-1"):
        lines[line] = "-2"  # makes all intensities less than 0
    with pytest.raises(sf.FileError, match=r"a\.ldt"):
        sf.read_photometry(files("a.ldt", "\n".join(lines)))


def test_other_files(files, tmp_path):
    with pytest.raises(sf.FileError, match=r"wanted a name ending in \.ies or \.ldt"):
        sf.read_photometry(files("a.txt", IES))
    with pytest.raises(sf.FileError, match=r"none\.ies"):
        sf.read_photometry(tmp_path / "none.ies")
    with pytest.raises(ValueError, match="photometry: wanted a Photometry or a path, got float"):
        sf.PhotometricLight([0, 0, 1], 3.0)


def test_what_symmetry_leaves_out():
    """C = 0 has 0 cd, 90 has 9, and what lies between is by sine."""
    full = np.arange(0.0, 361.0, 15.0)
    values = np.abs(np.sin(np.radians(full)))[:, None] * [9.0, 9.0]
    for low, high in ((0, 90), (0, 180), (90, 270), (0, 345), (0, 360)):
        some = (full >= low) & (full <= high)
        planes, candela = sf.Photometry(full[some], [0, 90], values[some]).all_around()
        np.testing.assert_allclose(planes, full)
        np.testing.assert_allclose(candela, values, atol=1e-12)
    lopsided = sf.Photometry([90, 150, 210, 270], [0, 90], [[1, 1], [2, 2], [4, 4], [8, 8]]).all_around()
    np.testing.assert_allclose(lopsided[0], [0, 30, 90, 150, 210, 270, 330, 360])
    np.testing.assert_allclose(lopsided[1][:, 0], [3, 2, 1, 2, 4, 8, 4, 3])


def test_lumens_in_closed_form():
    assert sf.Photometry([0], [0, 180], [[1, 1]]).lumens == pytest.approx(4 * np.pi)
    assert FLAT.lumens == pytest.approx(100 * np.pi, rel=1e-3)
    half = sf.Photometry([0, 179.999, 180.001, 359.999], [0, 180], [[1, 1], [1, 1], [0, 0], [0, 0]])
    assert half.lumens == pytest.approx(2 * np.pi, rel=1e-4)


@pytest.mark.parametrize("kind", ["patches", "disks", "one patch"])
def test_a_flat_lamp_over_a_floor(kind):
    """E = I / h^2 cos^4; of one patch the mean by midpoints."""
    if kind == "disks":
        at = np.stack(np.meshgrid(*2 * [np.linspace(-1, 1, 21)]), -1).reshape(-1, 2)
        floor = sf.Surfels(np.c_[at, np.zeros(len(at))], [[0, 0, 1]] * len(at), reflectance=0.0)
    else:
        floor = patch([-1, -1, 0], 2 * X, 2 * Y, 0.0, 0.0, 4.0 if kind == "one patch" else 0.01)
    solution = sf.solve(sf.Scene([floor], [sf.PhotometricLight([0, 0, 1.5], FLAT, intensity=[1, 2, 0.5])]))
    at = solution.surfels.points[:, :2]
    if kind == "one patch":
        at = np.stack(np.meshgrid(*2 * [np.linspace(-1, 1, 801)[:-1] + 1 / 800]), -1).reshape(-1, 2)
    wanted = 100.0 / 1.5**2 * (1.5**2 / (1.5**2 + (at**2).sum(axis=1))) ** 2
    if kind == "one patch":
        wanted = wanted.mean(keepdims=True)
    np.testing.assert_allclose(solution.direct, wanted[:, None] * [1, 2, 0.5], rtol=2e-3)


@pytest.mark.parametrize("place", [[0.5, 0.5, 0.5], [0.2, 0.7, 0.9]])
def test_a_closed_room_has_all_lumens(place):
    """Of a table with edges, on walls of one patch each: pieces are as small as it needs."""
    table = np.random.default_rng(1).uniform(0, 100, (8, 19))
    table[:, 0], table[:, -1] = 50.0, 20.0
    lamp = sf.Photometry(np.arange(0, 360, 45.0), np.arange(0, 181, 10.0), table)
    room = cube_inside(1, 0.0)
    direct = sf.solve(sf.Scene([room], [sf.PhotometricLight(place, lamp, [1, 2, -0.5], 33.0)])).direct
    assert direct[:, 0] @ room.areas == pytest.approx(lamp.lumens, rel=2e-3)


def test_a_table_of_a_spot_lights_as_the_spot():
    outer, inner = 20.0, 15.0
    gamma = np.concatenate([[0.0], np.arange(14.0, 20.05, 0.05)])
    x = np.clip((outer - gamma) / (outer - inner), 0.0, 1.0)
    table = sf.Photometry([0.0], gamma, [x * x * (3 - 2 * x)])
    room = cube_inside(12, 0.5)
    place, towards = [0.4, 0.6, 0.7], [0.3, -0.4, -1.0]
    spot = sf.SpotLight(place, towards, 5.0, cone=2 * outer, penumbra=2 * (outer - inner))
    light = sf.PhotometricLight(place, table, towards, intensity=5.0)
    found, wanted = (sf.solve(sf.Scene([room], [one])) for one in (light, spot))
    assert np.abs(found.direct - wanted.direct).max() < 1e-3 * wanted.direct.max()
    assert np.abs(found.irradiance - wanted.irradiance).max() < 2e-3 * wanted.irradiance.max()
    transfer = sf.precompute_transfer(sf.Scene([room]))
    found, wanted = (transfer.relight(one) for one in (light, spot))
    assert np.abs(found.irradiance - wanted.irradiance).max() < 2e-2 * wanted.irradiance.max()


@pytest.mark.parametrize("cone", [1.0, 4.0, 12.0])
def test_narrow_beams_on_wide_disks(cone):
    """All of a beam arrives, though no disk's centre may be in it."""
    n = 30
    cells = np.stack(np.meshgrid(np.arange(n), np.arange(n)), -1).reshape(-1, 2)
    spread = np.random.default_rng(0).uniform(0.3, 0.7, cells.shape)
    points = np.c_[(cells + spread) * 2 / n, np.zeros(n * n)]
    floor = sf.Surfels(points, [[0, 0, 1]] * n * n, reflectance=0.0)
    gamma = np.linspace(0.0, cone / 2, 20)
    beam = sf.Photometry([0.0], gamma, [1000.0 * np.cos(np.linspace(0.0, np.pi / 2, 20))])
    for place in ([0.87, 1.02, 1.4], [1.13, 0.91, 1.4]):
        solution = sf.solve(sf.Scene([floor], [sf.PhotometricLight(place, beam)]))
        power = solution.direct[:, 0] @ solution.surfels.areas
        assert power == pytest.approx(beam.lumens, rel=0.02)


@pytest.mark.parametrize("seed", range(3))
def test_own_estimates_know_one_that_is_close(seed):
    """Its place was the origin to them."""
    floor = patch([-0.5, -0.5, 0], X, Y, 0.0, 0.0, 0.04)
    solution = sf.solve(sf.Scene([floor], [sf.PhotometricLight([0.25, 0.1, 0.01], FLAT)]), seed=seed)
    assert solution.error < 0.01
    solution.irradiance = 1.1 * solution.irradiance
    assert solution.estimate_error() == pytest.approx(0.1, rel=0.1)


def lit_side(light):
    """Where around (0, 0) the light on a floor is, from its middle, unit."""
    floor = patch([-2, -2, 0], 4 * X, 4 * Y, 0.0, 0.0, 0.01)
    direct = sf.solve(sf.Scene([floor], [light]), insert=False).direct[:, 0]
    middle = direct @ floor.points / direct.sum()
    return middle[:2] / np.linalg.norm(middle[:2])


def test_which_way_planes_and_azimuth_turn():
    """A table with light about C = 60 alone."""
    one_way = sf.Photometry(np.arange(0, 360, 30.0), [0, 40, 60], [[0, 10.0 * (k == 2), 0] for k in range(12)])

    def towards(degrees):
        return [np.cos(np.radians(degrees)), np.sin(np.radians(degrees))]

    np.testing.assert_allclose(lit_side(sf.PhotometricLight([0, 0, 1], one_way)), towards(60), atol=0.02)
    turned = sf.PhotometricLight([0, 0, 1], one_way, azimuth=75.0)
    np.testing.assert_allclose(lit_side(turned), towards(135), atol=0.02)
    # Turned up by 90 degrees about x: down goes to +y, C = 90 from +y to +z, and C = 0 stays at +x.
    flood = sf.PhotometricLight([0, 0, 0], one_way, [0, 1, 0])
    c, gamma = np.radians(60.0), np.radians(40.0)
    way = [np.sin(gamma) * np.cos(c), np.cos(gamma), np.sin(gamma) * np.sin(c)]
    np.testing.assert_allclose(flood._shares([way, [0, 0, -1], [0, 1, 0]]), [10.0, 0.0, 0.0], atol=1e-9)
    # Up by 180 degrees about x: C = 0 stays at +x, C = 90 goes to -y.
    uplight = sf.PhotometricLight([0, 0, 0], one_way, [0, 0, 1])
    way = [np.sin(gamma) * np.cos(c), -np.sin(gamma) * np.sin(c), np.cos(gamma)]
    np.testing.assert_allclose(uplight._shares([way]), [10.0], atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_solvers_agree_with_path_tracing(seed):
    table = np.random.default_rng(seed).uniform(10, 100, (5, 10))
    table[:, 0], table[:, -1] = 50.0, 30.0
    lamp = sf.Photometry(np.arange(0, 181, 45.0), np.arange(0, 181, 20.0), table)
    room, place = cube_inside(10, [0.6, 0.4, 0.2]), np.array([0.3, 0.4, 0.6])
    light = sf.PhotometricLight(place, lamp, [0.3, 0, -1], azimuth=20.0)
    scene = sf.Scene([room], [light])
    index = np.arange(0, len(room), 7)
    points, normals = room.points[index], room.normals[index]
    wanted, noise = sf.reference_irradiance(scene, points, normals, samples=4096, seed=seed)
    # Of direct light a patch has its mean, paths are those of its middle.
    way = points - place
    distance = np.linalg.norm(way, axis=1)
    wanted -= (light._shares(way) * -np.einsum("ij,ij->i", way, normals) / distance**3)[:, None]
    for solver in (partial(sf.solve, insert=False), sf.solve_meshless):
        solution = solver(scene, seed=seed)
        found = (solution.irradiance - solution.direct)[index]
        rms = np.sqrt(((found - wanted) ** 2).sum() / (wanted**2).sum())
        assert rms < 0.02 + np.sqrt((noise**2).sum() / (wanted**2).sum())


def test_scene_files_name_it(files, tmp_path):
    files("lamp.ies", IES)
    path = files(
        "room.toml",
        """
[[object]]
shape = "room"
patches = 4
reflectance = 0.5
[[light]]
type = "photometric"
position = [0.5, 0.5, 0.9]
photometry = "lamp.ies"
azimuth = 90
""",
    )
    scene = sf.load_scene(path)
    assert scene.lights[0] == sf.PhotometricLight([0.5, 0.5, 0.9], tmp_path / "lamp.ies", azimuth=90.0)
    files("room.toml", path.read_text().replace("lamp.ies", "other.ies"))
    with pytest.raises(sf.FileError, match=r"other\.ies"):
        sf.load_scene(path)


def test_lamps_that_move_may_have_it(files, tmp_path):
    files("lamp.ies", IES)
    path = files(
        "lamps.toml",
        """
frames = 3
[[light]]
type = "photometric"
photometry = "lamp.ies"
position = [[0, 0, 1], [2, 0, 1]]
azimuth = [0, 90]
""",
    )
    middle = sf.load_lamps(path)[1]
    assert middle == [sf.PhotometricLight([1, 0, 1], tmp_path / "lamp.ies", azimuth=45.0)]
    again = files("again.toml", lamps_text(middle))
    assert sf.load_lamps(again) == [middle]
    with pytest.raises(ValueError, match="the photometry of one is of no file"):
        lamps_text([sf.PhotometricLight([0, 0, 1], FLAT)])


def test_checkpoints_keep_it(tmp_path):
    scene = sf.Scene([cube_inside(4, 0.5)], [sf.PhotometricLight([0.5, 0.5, 0.6], FLAT)])
    solution = sf.solve(scene, checkpoint=tmp_path / "kept")
    same_bits(sf.solve(scene, checkpoint=tmp_path / "kept"), solution)
    again = scene_of_arrays(*scene_arrays(scene))
    assert again.lights == scene.lights
    same_bits(sf.solve(again), sf.solve(scene))
    dimmed = sf.Scene(scene.objects, [sf.PhotometricLight([0.5, 0.5, 0.6], FLAT, intensity=0.5)])
    with pytest.raises(sf.FileError, match="is of another call"):
        sf.solve(dimmed, checkpoint=tmp_path / "kept")


def test_a_lamp_that_is_off_is_told():
    dark = sf.Photometry([0], [0, 90], [[0, 0]])
    with pytest.warns(UserWarning, match="lights have no power"):
        sf.solve(sf.Scene([cube_inside(4, 0.5)], [sf.PhotometricLight([0.5, 0.5, 0.5], dark)]))
