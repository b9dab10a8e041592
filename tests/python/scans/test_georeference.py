"""Where LAS files lie on earth: place, north and units by their coordinate reference systems."""

import sys

import numpy as np
import pytest

import surflux as sf
from located_files import las_in
from surflux.scans.georeference import georeference

pytest.importorskip("laspy")
pyproj = pytest.importorskip("pyproj")


@pytest.mark.parametrize(
    ("system", "longitude", "latitude"),
    [
        ("EPSG:32632", 6.2, 47.4),  # UTM 32, far to the west of its middle, 9 E
        ("EPSG:28992", 5.9, 52.2),  # an oblique stereographic projection
        ("EPSG:2193", 178.0, -38.5),  # of the southern hemisphere
        ("EPSG:2994", -123.07, 44.05),  # Oregon, in feet
        ("EPSG:3413", 70.0, 80.0),  # polar: north is not upwards at all
    ],
)
def test_a_metre_to_true_north(tmp_path, system, longitude, latitude):
    """Along the meridian, by geodesics of the ellipsoid: 100 m to the north of a place lie that way on the grid."""
    to_grid = pyproj.Transformer.from_crs("EPSG:4326", system, always_xy=True)
    here = np.array(to_grid.transform(longitude, latitude))
    found = georeference(las_in(tmp_path / "a.las", system, [(*here, 0.0), (*here + 1.0, 0.0)]), here)
    assert (found.latitude, found.longitude) == pytest.approx((latitude, longitude), abs=1e-6)
    ahead = pyproj.Geod(ellps="WGS84").fwd(longitude, latitude, 0.0, 100.0)[:2]
    way = (np.array(to_grid.transform(*ahead)) - here) * found.horizontal
    assert np.degrees(np.arctan2(*way)) == pytest.approx(found.north, abs=1e-3)
    scale = pyproj.Proj(system).get_factors(longitude, latitude).meridional_scale
    assert np.linalg.norm(way) == pytest.approx(100.0 * scale, rel=1e-4)  # metres, as the projection has them


def test_utm_converges_as_the_series_says(tmp_path):
    """Meridian convergence, to first order sin(latitude) times the longitude from the middle: to 1 % at 2 degrees."""
    to_grid = pyproj.Transformer.from_crs("EPSG:4326", "EPSG:32632", always_xy=True)
    here = to_grid.transform(11.0, 47.0)
    found = georeference(las_in(tmp_path / "a.las", "EPSG:32632", [(*here, 0.0), (*here, 1.0)]), here)
    assert found.north == pytest.approx(-2.0 * np.sin(np.radians(47.0)), rel=0.01)


@pytest.mark.parametrize(
    ("system", "horizontal", "vertical"),
    [
        ("EPSG:25832", 1.0, None),
        ("EPSG:25832+5783", 1.0, 1.0),
        ("EPSG:6557", 0.3048, None),  # Oregon in international feet
        ("EPSG:2263+6360", 1200.0 / 3937.0, 1200.0 / 3937.0),  # New York in US survey feet, NAVD88 in them, too
        ("EPSG:26918+6360", 1.0, 1200.0 / 3937.0),  # metres, with heights in feet
    ],
)
def test_units_are_told_of_both_ways(tmp_path, system, horizontal, vertical):
    grid = pyproj.CRS(system)
    grid = grid.sub_crs_list[0] if grid.is_compound else grid
    low = pyproj.Transformer.from_crs("EPSG:4326", grid, always_xy=True)
    west, south, east, north = grid.area_of_use.bounds
    here = low.transform(0.5 * (west + east), 0.5 * (south + north))
    found = georeference(las_in(tmp_path / "a.las", system, [(*here, 0.0), (*here, 1.0)]), here)
    assert found.horizontal == pytest.approx(horizontal, rel=1e-9)
    assert found.vertical == (None if vertical is None else pytest.approx(vertical, rel=1e-9))


@pytest.mark.parametrize(
    ("keys", "vertical"),
    [
        ({1024: 1, 3072: 26910}, None),
        ({1024: 1, 3072: 26910, 4099: 9003}, 1200.0 / 3937.0),
        ({1024: 1, 3072: 26910, 3076: 9001, 4096: 5703}, 1.0),
        ({1024: 1, 3072: 26910, 4096: 5103}, None),  # a datum's number, where a system's should stand
    ],
)
def test_keys_of_geotiff(tmp_path, keys, vertical):
    found = georeference(las_in(tmp_path / "a.las", keys=keys), (500000.0, 4649776.0))
    assert (found.latitude, found.longitude) == pytest.approx((42.0, -123.0), abs=0.01)
    assert found.horizontal == 1.0
    assert found.vertical == vertical


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            {"keys": {1024: 1, 3072: 26910, 3076: 9002}},
            "x and y are 1 m by its coordinate reference system, 0.3048 m by",
        ),
        ({"keys": {1024: 1, 2048: 4269, 3072: 32767}}, "is not understood: it has no EPSG code and no WKT"),
        ({"keys": {1024: 1}}, "is not understood: it has no EPSG code and no WKT"),
        ({"keys": {1024: 1, 3072: 1030}}, "is not understood"),
        ({"system": "EPSG:4326"}, "its coordinates are degrees (WGS 84); wanted lengths"),
        ({"system": "EPSG:5513"}, "x and y of S-JTSK / Krovak do not go east and north"),
    ],
)
def test_refusals(tmp_path, arguments, message):
    place = (743000.0, 1043000.0) if arguments.get("system") != "EPSG:5513" else (1043000.0, 743000.0)
    with pytest.raises(sf.FileError) as caught:
        georeference(las_in(tmp_path / "a.las", **arguments), place)
    assert str(tmp_path / "a.las") in str(caught.value)
    assert message in str(caught.value)


def test_a_place_outside_of_the_projection_is_refused(tmp_path):
    with pytest.raises(sf.FileError, match="is no place on earth in ETRS89 / UTM zone 32N"):
        georeference(las_in(tmp_path / "a.las", "EPSG:25832"), (1e9, 1e9))


def test_files_that_say_nothing(tmp_path):
    assert georeference(las_in(tmp_path / "a.las"), (0.0, 0.0)) is None
    (tmp_path / "a.xyz").write_text("0 0 0\n1 1 1\n")
    assert georeference(tmp_path / "a.xyz", (0.0, 0.0)) is None


def test_without_pyproj_the_line_that_installs_it_is_told(tmp_path, monkeypatch):
    path = las_in(tmp_path / "a.las", "EPSG:25832")
    monkeypatch.setitem(sys.modules, "pyproj", None)
    with pytest.raises(ImportError, match=r"pip install 'surflux\[solar\]'"):
        georeference(path, (5e5, 5e6))
    monkeypatch.undo()


@pytest.mark.scans
def test_a_tile_of_oregon(scans):
    """Autzen stadium, Eugene: 44.06 N, 123.07 W; Lambert's grid turns by (lon + 120.5) sin(44.25) there."""
    found = georeference(scans / "scans" / "autzen_trim.laz", (636590.0, 849216.0))
    assert (found.latitude, found.longitude) == pytest.approx((44.05, -123.07), abs=0.01)
    assert found.north == pytest.approx(2.571 * np.sin(np.radians(44.25)), abs=0.005)
    assert found.horizontal == 0.3048
    assert found.vertical is None
