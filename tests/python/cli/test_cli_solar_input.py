"""`surflux solar`: files that say where they lie, and input that is refused."""

import json
import sys

import numpy as np
import pytest

import surflux as sf
from located_files import las_in
from solar_clouds import FEW, NOON, PLACE, layers, plane
from weather_files import level_sun, write_epw


@pytest.fixture(autouse=True)
def extra():
    pytest.importorskip("pvlib")


@pytest.fixture
def tile(here):
    """Level ground in Oregon, 40 by 40 feet, as LAS in feet of which grid north is 1.8 degrees off."""
    pytest.importorskip("laspy")
    pyproj = pytest.importorskip("pyproj")
    middle = pyproj.Transformer.from_crs("EPSG:4326", "EPSG:2994", always_xy=True).transform(-123.07, 44.05)
    points = np.load(plane())["points"] + [*middle, 400.0]
    return las_in(here / "tile.las", "EPSG:2994", points)


def test_a_file_that_says_where_it_lies(tile, run):
    status, out, err = run("solar", "tile.las", "--time", "2025-06-21T20:13Z", "--json", "-o", "out.laz", *FEW)
    assert status == 0, err
    result = json.loads(out)
    assert result["place"] == pytest.approx([44.05, -123.07], abs=1e-4)
    assert result["north"] == pytest.approx(-(-123.07 + 120.5) * np.sin(np.radians(44.25)), abs=0.01)
    assert result["area"] == pytest.approx(1600.0 * 0.3048**2, rel=0.05)
    assert "44.050 N, 123.070 W: z is up, north is 1.79 degrees clockwise from +y, the unit is 0.3048 m (of z" in err
    scan = sf.read_scan("out.laz")
    np.testing.assert_allclose(scan.points, sf.read_scan("tile.las").points, rtol=0, atol=1e-9 * 1e6)
    sky = sf.Sky(44.05, -123.07, "2025-06-21T20:13Z", altitude=400.0 * 0.3048)
    np.testing.assert_allclose(scan.attributes["kwh"], sky.global_horizontal / 1000.0, rtol=1e-3)


@pytest.mark.parametrize("colors", [False, True])
def test_a_mesh_has_light_on_its_patches(here, run, colors):
    """Level ground under an open sky: its global irradiation, whatever it reflects."""
    (here / "ground.obj").write_text("v 0 0 2\nv 40 0 2\nv 40 40 2\nv 0 40 2\nf 1 2 3 4\n")
    arguments = [*PLACE, "--time", NOON, "--json", *FEW, *(["--colors"] if colors else [])]
    status, out, err = run("solar", "ground.obj", *arguments)
    assert status == 0, err
    result = json.loads(out)
    assert result["points"] >= 20_000
    assert result["area"] == pytest.approx(1600.0)
    scan = sf.read_scan("ground_solar.ply")
    expected = sf.Sky(47.4, 8.5, NOON).global_horizontal / 1000.0
    np.testing.assert_allclose(scan.attributes["kwh"], expected, rtol=1e-3)
    np.testing.assert_allclose(scan.reflectance, 0.5 if colors else 0.2, atol=0.005)  # bytes
    assert "what lies past the edge of the mesh is open" in err
    # From below, where the ground around reflects into it, with an albedo of .2
    status, out, err = run("solar", "ground.obj", *arguments, "--normals", "flip", "-o", "flipped.csv")
    assert status == 0, err
    flipped = sf.read_scan("flipped.csv").attributes
    np.testing.assert_allclose(flipped["kwh"], 0.2 * expected, rtol=0.02)
    status, _, err = run("solar", "ground.obj", *PLACE, "--time", NOON, "--receivers", 2)
    assert (status, "--receivers: is for a cloud\n" in err) == (2, True)


@pytest.mark.slow
def test_weather_of_another_place_is_told_of(tile, run, here):
    write_epw(here / "here.epw", level_sun(47.4, 8.5, 1.0), np.zeros(8760), np.full(8760, 10.0))
    status, _, err = run("solar", "tile.las", "--epw", "here.epw", *FEW)
    assert status == 0
    assert "warning: the weather is of 47.400 N, 8.500 E, 8" in err
    assert "km from the points, and so is the sun" in err


def test_without_pyproj_a_place_is_asked_for(tile, run, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyproj", None)
    status, _, err = run("solar", "tile.las", "--time", NOON)
    assert status == 2
    assert "tile.las: its place on earth needs pyproj: pip install 'surflux[solar]'" in err
    assert "or say --place LAT,LON, --north DEGREES and --unit METRES" in err
    status, out, err = run("solar", "tile.las", "--time", NOON, *PLACE, "--unit", 0.3048, "--json", "-o", "a.csv", *FEW)
    assert status == 0
    assert "warning: tile.las: its place on earth needs pyproj" in err
    assert json.loads(out)["north"] == 0.0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((), "--epw: wanted one of --epw FILE, --year YEAR and --time ISO, got none"),
        (
            ("--year", 2025, "--time", NOON),
            "--epw: wanted one of --epw FILE, --year YEAR and --time ISO, got --year and",
        ),
        (("--year", 2025), "--place: wanted LAT,LON in degrees, for plane.npz has no coordinate reference system"),
        (("--year", 2025, "--place", "95,8"), "--place: latitude: wanted"),
        (("--year", 2025, "--place", "5,188"), "--place: longitude: wanted"),
        (("--year", 1800, *PLACE), "--year: wanted"),
        (("--time", "2025-06-21T12:00", *PLACE), "--time: wanted a time with its time zone"),
        (("--time", "noon", *PLACE), "--time: wanted text such as 2025-06-21T12:00+02:00, got 'noon'"),
        (("--epw", "none.epw"), "none.epw: No such file or directory"),
        (("--epw", "none.epw", *PLACE), "--place: goes with --year or --time"),
        (("--year", 2025, *PLACE, "--casters", "2"), "--casters: plane.npz has no classes"),
        (("--year", 2025, *PLACE, "--albedo", 1), "--albedo: wanted"),
        (("--year", 2025, *PLACE, "--unit", 0), "--unit: wanted"),
        (("--year", 2025, *PLACE, "--north", 720), "--north: wanted"),
        (("--year", 2025, *PLACE, "--sun-step", 90), "--sun-step: wanted"),
        (("--year", 2025, *PLACE, "-o", "a.tif"), "-o: wanted a name ending in .ply"),
        (("--year", 2025, *PLACE, "-o", "no/a.ply"), "no/a.ply: cannot be written: there is no folder no"),
        (("--year", 2025, *PLACE, "--image", "a.exr"), "--image: wanted a name ending in .png or .jpg"),
        (("--year", 2025, *PLACE, "--no-image", "--image", "a.png"), "--no-image: does not go with --image"),
    ],
)
def test_refusals(here, run, arguments, message):
    plane()
    status, out, err = run("solar", "plane.npz", *arguments)
    assert status == 2
    assert out == ""
    assert f"surflux: error: {message}" in err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--casters", "2", "--receivers", "5"), "--receivers: class 5 is not among --casters"),
        (("--casters", "6"), "--casters: no points are of these classes; layers.npz has 2, 5"),
        (("--receivers", "9"), "--receivers: no points are of these classes; layers.npz has 2, 5"),
        (("--casters", "trees"), "--casters: wanted numbers from 0 to 255 or of unclassified, ground"),
        (("--casters", "2,300"), "--casters: wanted numbers from 0 to 255"),
    ],
)
def test_refusals_of_classes(here, run, arguments, message):
    layers()
    status, _, err = run("solar", "layers.npz", *PLACE, "--time", NOON, *arguments)
    assert status == 2
    assert f"surflux: error: {message}" in err


def test_without_pvlib_the_line_that_installs_it_is_told(here, run, monkeypatch):
    monkeypatch.setitem(sys.modules, "pvlib", None)
    status, _, err = run("solar", plane(), *PLACE, "--year", 2025)
    assert status == 2
    assert "pip install 'surflux[solar]'" in err
    assert "reading" not in err  # before any work
