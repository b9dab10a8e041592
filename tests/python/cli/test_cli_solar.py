"""`surflux solar`: kWh/m2 of points, by weather, place and classes."""

import json

import numpy as np
import pytest

import surflux as sf
from solar_clouds import FEW, NOON, PLACE, layers, plane
from surflux.cli import solar
from weather_files import level_sun, write_epw


@pytest.fixture(autouse=True)
def extra():
    pytest.importorskip("pvlib")


@pytest.mark.slow
def test_a_year_on_a_level_plane(here, run):
    """What pvlib's clear skies bring to a level plane, every five minutes.

    Hours are taken by the sky in their middle and the sun at four moments; a sine over an hour has 1 - (pi / 24)^2 / 6
    of that in its middle, .29 % less, which bounds what that can be off by, and coefficients are right to .1 %.
    """
    import pandas
    import pvlib

    status, out, err = run("solar", plane(), *PLACE, "--year", 2025, "--altitude", 400, *FEW)
    assert status == 0, err
    kwh = sf.read_scan("plane_solar.ply").attributes["kwh"]
    times = pandas.date_range("2025-01-01T00:02:30", "2025-12-31T23:59", freq="5min", tz="Etc/GMT-1")
    site = pvlib.location.Location(47.4, 8.5, altitude=400)
    expected = site.get_clearsky(times)["ghi"].sum() / 12e3
    np.testing.assert_allclose(kwh, expected, rtol=0.004)
    assert f"mean {kwh.mean():.4g} kWh/m2" in out
    assert "1225 points, area 1" in out
    assert " m2, 8760 h: 2025 under clear skies" in out
    assert "skies are clear in all hours" in err
    assert "low sun comes in from there" in err
    assert "47.400 N, 8.500 E: z is up, north is +y, the unit is 1 m, as nothing says otherwise" in err


def test_parts_make_the_whole_for_programs(here, run):
    surface = plane(tilt=30.0)
    status, out, err = run("solar", surface, *PLACE, "--time", NOON, "--json", "-o", "a.csv", "--no-image")
    assert status == 0, err
    result = json.loads(out)
    columns = sf.read_scan("a.csv").attributes
    total = columns["kwh_beam"] + columns["kwh_diffuse"] + columns["kwh_reflected"]
    np.testing.assert_allclose(columns["kwh"], total, rtol=1e-5)
    # An open plane: its parts in closed form, of the sky of that hour.
    sky = sf.Sky(47.4, 8.5, NOON)
    b = np.radians(30.0)
    beam = sky.direct_normal * (sky.sun_direction @ [0.0, -np.sin(b), np.cos(b)])
    np.testing.assert_allclose(1000.0 * columns["kwh_beam"], beam, rtol=1e-5)
    ground = 0.2 * sky.global_horizontal * (1.0 - np.cos(b)) / 2.0
    np.testing.assert_allclose(1000.0 * columns["kwh_reflected"], ground, rtol=0.01)
    np.testing.assert_allclose(columns["sky_view"], (1.0 + np.cos(b)) / 2.0, rtol=1e-6)
    assert result["points"] == result["casters"] == 1225
    assert result["area"] == pytest.approx(1600.0, rel=0.05)  # points do not say where the square ends
    assert result["hours"] == 1.0
    assert result["place"] == [47.4, 8.5]
    assert result["mean"]["kwh"] == pytest.approx(columns["kwh"].mean(), rel=1e-3)
    assert [t["area"] > 0 for t in result["tilts"]] == [False, True, False, False]
    assert result["timings"]["all"] > result["timings"]["sun"] >= 0


def test_the_usual_output_of_another_file_is_not_replaced_without_a_word(here, run):
    surface = plane()
    for is_said in (False, True):
        status, _, err = run("solar", surface, *PLACE, "--time", NOON, "--no-image", "--no-sky-view")
        assert status == 0, err
        assert ("plane_solar.ply is there already, and is replaced (-o names another)" in err) == is_said


@pytest.mark.slow
def test_weather_of_a_file(here, run):
    """Hours of 500 W/m2 of diffuse light while the sun is up, and no beam: a level plane has their sum."""
    above = level_sun(47.4, 8.5, 1.0)
    diffuse = np.where(above > 100.0, 500.0, 0.0)
    write_epw(here / "here.epw", above, np.zeros(8760), diffuse)
    status, out, err = run("solar", plane(), "--epw", "here.epw", *FEW)
    assert status == 0, err
    np.testing.assert_allclose(sf.read_scan("plane_solar.ply").attributes["kwh"], diffuse.sum() / 1000.0, rtol=1e-3)
    assert "beam 0.0 %, diffuse 100.0 %" in out
    assert "a year's weather of here.epw" in out


@pytest.mark.slow
def test_north_turns_what_faces_the_sun(here, run):
    """A roof towards +y, where that is south: as one towards -y in a file whose +y is north."""
    run("solar", plane("south.npz", tilt=40.0), *PLACE, "--time", NOON, "-o", "south.csv", *FEW)
    south = np.load("south.npz")
    np.savez("turned.npz", **{name: south[name] * [-1.0, -1.0, 1.0] for name in ("points", "normals")})
    run("solar", "turned.npz", *PLACE, "--time", NOON, "--north", 180, "-o", "turned.csv", *FEW)
    run("solar", "turned.npz", *PLACE, "--time", NOON, "-o", "shade.csv", *FEW)
    south, turned, shade = (
        sf.read_scan(name).attributes["kwh_beam"] for name in ("south.csv", "turned.csv", "shade.csv")
    )
    np.testing.assert_allclose(turned, south, rtol=1e-6)
    assert shade.max() < 0.6 * south.min()


@pytest.mark.parametrize("seed", [0, 1, 2, 3])
def test_a_single_steep_roof_faces_the_sky(here, run, seed):
    """Too steep for terrain, and which way it faced was chance."""
    xy = np.random.default_rng(seed).uniform(-3, 3, (2000, 2))
    np.savetxt("roof.csv", np.c_[xy, 8 + 0.7 * xy[:, 1]], delimiter=",", header="x,y,z", comments="")
    _, _, messages = run("solar", "roof.csv", *PLACE, "--time", NOON, *FEW)
    assert "100 % of the points are on open surfaces, which are taken to face the sky" in messages
    assert "face the ground" not in messages


def test_ground_above_the_origin_faces_the_sky(here, run):
    """In local x and y, with its elevation: it was taken for what a depth camera sees, and had .1 instead of .6 kWh."""
    xy = np.random.default_rng(0).uniform(-30, 30, (2000, 2))
    np.savetxt("ground.csv", np.c_[xy, np.full(2000, 75.0)], delimiter=",", header="x,y,z", comments="")
    _, _, messages = run("solar", "ground.csv", *PLACE, "--time", NOON, *FEW, "-o", "ground.npz")
    kwh = sf.read_scan("ground.npz").attributes["kwh"]
    np.savetxt("level.csv", np.c_[xy, np.zeros(2000)], delimiter=",", header="x,y,z", comments="")
    run("solar", "level.csv", *PLACE, "--time", NOON, *FEW, "-o", "level.npz")
    np.testing.assert_allclose(kwh, sf.read_scan("level.npz").attributes["kwh"], rtol=1e-3)
    assert "the skies are those at the level of the sea: at 500 m a roof has 2 % more" in messages


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_walls_below_a_roof_face_outwards(here, run, seed):
    """Sparse, as airborne scanners see them, and rough by 1 cm: they were not to face the sky each point by itself."""
    random = np.random.default_rng(seed)
    roof = np.c_[random.uniform(0, 10, (4000, 2)), np.full(4000, 5.0)]
    across, up = random.uniform(0, 10, 2800), random.uniform(0, 5, 2800)
    wall, side = np.arange(2800) % 2, np.arange(2800) // 2 % 2 * 10.0
    walls = np.where(wall[:, None] == 0, np.c_[across, side, up], np.c_[side, across, up])
    points = np.vstack([roof, walls]) + random.normal(0.0, 0.01, (6800, 3))
    np.savetxt("house.csv", points, delimiter=",", header="x,y,z", comments="")
    run("solar", "house.csv", *PLACE, "--time", NOON, *FEW, "-o", "house.npz")
    kwh = sf.read_scan("house.npz").attributes["kwh"]
    south, north = (kwh[4000:][(wall == 0) & (side == y)] for y in (0.0, 10.0))
    assert np.quantile(south, 0.05) > 3.0 * np.quantile(north, 0.95)


def test_degrees_are_no_metres(here, run):
    xy = np.random.default_rng(0).uniform([8.5, 47.4], [8.51, 47.41], (2000, 2))
    np.savetxt("degrees.csv", np.c_[xy, np.full(2000, 400.0)], delimiter=",", header="x,y,z", comments="")
    _, _, messages = run("solar", "degrees.csv", *PLACE, "--time", NOON, *FEW)
    assert "all of it lies within 0.01 m; longitudes and latitudes have to be projected" in messages


@pytest.mark.slow
def test_vegetation_shades_and_has_no_values(here, run):
    points, upper = layers()
    status, out, err = run("solar", "layers.npz", *PLACE, "--time", NOON, *FEW)
    assert status == 0, err
    scan = sf.read_scan("layers_solar.ply")
    np.testing.assert_array_equal(scan.points, points)  # in the order of the file
    kwh, beam = scan.attributes["kwh"], scan.attributes["kwh_beam"]
    assert np.isnan(kwh[upper]).all()
    assert np.isfinite(kwh[~upper]).all()
    sun = sf.Sky(47.4, 8.5, NOON).sun_direction
    met = points[:, :2] + 4.0 * sun[:2] / sun[2]  # where the ray to the sun crosses the upper square
    reach = np.abs(met).max(axis=1)
    assert beam[~upper & (reach < 4.5)].max() == 0.0
    assert beam[~upper & (reach > 6.0)].min() > 0.5
    assert "crowns are opaque: 144 points of vegetation" in err
    assert "1225 points, of 1369 that shade" in out
    assert run("solar", "layers.npz", *PLACE, "--time", NOON, "--receivers", "vegetation", "-o", "b.csv", *FEW)[0] == 0
    assert np.array_equal(np.isnan(sf.read_scan("b.csv").attributes["kwh"]), ~upper)


@pytest.mark.slow
def test_noise_is_left_out(here, run):
    _, upper = layers(kinds=(2, 18))
    status, _, err = run("solar", "layers.npz", *PLACE, "--time", NOON, *FEW)
    assert status == 0
    beam = sf.read_scan("layers_solar.ply").attributes["kwh_beam"]
    assert np.isnan(beam[upper]).all()
    np.testing.assert_allclose(beam[~upper], beam[~upper].max(), rtol=1e-5)  # nothing shades
    assert "144 points of classes 18 left out" in err
    run(
        "solar", "layers.npz", *PLACE, "--time", NOON, "--casters", "2,18", "--receivers", "ground", "-o", "b.csv", *FEW
    )
    assert sf.read_scan("b.csv").attributes["kwh_beam"][~upper].min() == 0.0


def test_repeated_points_have_what_the_first_has(here, run):
    once = np.load(plane())["points"]
    np.savez("twice.npz", points=np.repeat(once, 2, axis=0))
    status, out, err = run("solar", "twice.npz", *PLACE, "--time", NOON, *FEW)
    assert status == 0
    kwh = sf.read_scan("twice_solar.ply").attributes["kwh"]
    np.testing.assert_array_equal(kwh[::2], kwh[1::2])
    np.testing.assert_allclose(kwh, sf.Sky(47.4, 8.5, NOON).global_horizontal / 1000.0, rtol=1e-3)
    assert "counted once, for another one stands at their place: 1225 points" in err
    once = sf.effective_areas(sf.Surfels(once, np.tile([0.0, 0.0, 1.0], (1225, 1)))).sum()
    assert f"area {once:.6g} m2" in out


@pytest.mark.slow
def test_units_are_of_areas_alone(here, run):
    """Feet: the plane is .3048^2 of the area; what arrives per square metre is the same."""
    _, metres, _ = run("solar", plane(), *PLACE, "--time", NOON, "--json", "-o", "a.csv", *FEW)
    _, feet, _ = run("solar", plane(), *PLACE, "--time", NOON, "--unit", 0.3048, "--json", "-o", "b.csv", *FEW)
    assert json.loads(feet)["area"] == pytest.approx(json.loads(metres)["area"] * 0.3048**2, rel=1e-4)
    kwh = [sf.read_scan(name).attributes["kwh"] for name in ("a.csv", "b.csv")]
    np.testing.assert_allclose(*kwh, rtol=1e-5)


@pytest.mark.slow
def test_a_scene_file(here, run):
    """A wall that faces south and one that faces north, 10 apart, back to back, and turned by 90 degrees."""
    (here / "walls.toml").write_text("""
[[object]]
kind = "mesh"
file = "walls.obj"
patch_area = 1.0
""")
    corners = "v 0 0 0\nv 4 0 0\nv 4 0 3\nv 0 0 3\nv 0 10 0\nv 4 10 0\nv 4 10 3\nv 0 10 3\n"
    (here / "walls.obj").write_text(corners + "f 1 2 3 4\nf 8 7 6 5\n")
    status, out, err = run("solar", "walls.toml", *PLACE, "--time", NOON, "-o", "w.npz", "--size", "80x60")
    assert status == 0, err
    scan = sf.read_scan("w.npz")
    southern = scan.points[:, 1] < 5.0
    sky = sf.Sky(47.4, 8.5, NOON)
    beam = sky.direct_normal * -sky.sun_direction[1] / 1000.0
    np.testing.assert_allclose(scan.attributes["kwh_beam"], np.where(southern, beam, 0.0), rtol=1e-5)
    assert "facades, to 120" in out
    assert (here / "w.png").exists()
    run("solar", "walls.toml", *PLACE, "--time", NOON, "--north", 180, "-o", "t.npz", *FEW)
    turned = sf.read_scan("t.npz").attributes["kwh_beam"]
    np.testing.assert_allclose(turned, np.where(southern, 0.0, beam), rtol=1e-5)


def test_patches_of_a_mesh_stay_patches(here, run):
    """A file of two walls that face each other, of patches: as disks they would reach past each other's edges."""
    corners = [[0, 0, 0], [8, 0, 0], [8, 0, 4], [0, 0, 4], [0, 6, 0], [8, 6, 0], [8, 6, 4], [0, 6, 4]]
    walls = sf.Surfels.from_mesh((corners, [[3, 2, 1, 0], [4, 5, 6, 7]]), 1.0)
    walls.save("walls.ply")
    status, out, err = run("solar", "walls.ply", *PLACE, "--time", NOON, "-o", "w.csv", *FEW)
    assert status == 0, err
    expected = sf.solar_irradiation(walls, (47.4, 8.5), [NOON], sun_step=10)
    found = sf.read_scan("w.csv").attributes
    np.testing.assert_allclose(found["kwh_beam"], expected.beam, rtol=1e-5)
    assert expected.beam.max() > 0.0
    assert found["kwh"].mean() == pytest.approx(expected.total.mean(), rel=0.015)  # noise of rays
    assert f"{len(walls)} points, area 64 m2" in out
    assert "past the edge" not in err
    status, _, err = run("solar", "walls.ply", *PLACE, "--time", NOON, "--casters", "2")
    assert status == 2
    assert "--casters: is for a cloud; scenes and patches of a mesh say by themselves what they are" in err


@pytest.mark.slow
def test_colors_are_reflected_where_asked_for(here, run):
    """Two walls of white and of black points that face each other: what the black one gets of the white one."""
    at = (np.arange(20) + 0.5) / 20 * 4
    u, v = (axis.ravel() for axis in np.meshgrid(at, at))
    white = np.column_stack([u, np.zeros(400), v])
    black = np.column_stack([u, np.full(400, 2.0), v])
    points = np.concatenate([white, black])
    normals = np.repeat([[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]], 400, axis=0)
    colors = np.repeat(np.array([[255] * 3, [10] * 3], np.uint8), 400, axis=0)
    np.savez("walls.npz", points=points, normals=normals, colors=colors)
    found = {}
    for option in ((), ("--colors",)):
        status, _, err = run("solar", "walls.npz", *PLACE, "--time", "2025-06-21T17:26Z", *option, "-o", "w.csv", *FEW)
        assert status == 0, err
        found[option] = sf.read_scan("w.csv").attributes["kwh_reflected"].reshape(2, 400).mean(axis=1)
    assert found["--colors",][1] > 2.0 * found[()][1]  # of what is white instead of .2
    assert found["--colors",][0] < found[()][0]  # of what is black instead of .2


@pytest.mark.slow
def test_walls_turned_inwards_are_told_of(here, run):
    """Normals that face the ground have next to nothing, and nobody would see why."""
    points = np.load(plane())["points"]
    np.savez("down.npz", points=points, normals=np.tile([0.0, 0.0, -1.0], (len(points), 1)))
    status, _, err = run("solar", "down.npz", *PLACE, "--time", NOON, "--normals", "keep", *FEW)
    assert status == 0
    assert "100 % of the points face the ground; if they are the wrong way round, --viewpoint X,Y,Z or --normals" in err
    down = sf.read_scan("down_solar.ply").attributes["kwh"]
    status, _, err = run("solar", "down.npz", *PLACE, "--time", NOON, "--normals", "flip", *FEW)
    up = sf.read_scan("down_solar.ply").attributes["kwh"]
    np.testing.assert_allclose(up, sf.Sky(47.4, 8.5, NOON).global_horizontal / 1000.0, rtol=1e-3)
    assert down.max() < 0.25 * up.min()
    assert "face the ground" not in err
    status, _, err = run("solar", "down.npz", *PLACE, "--time", NOON, *FEW)
    np.testing.assert_allclose(sf.read_scan("down_solar.ply").attributes["kwh"], up, rtol=1e-6)
    assert "its normals face away and are turned over, all of them, to face upwards" in err


@pytest.mark.slow
def test_places_are_read_by_hemisphere_too(here, run):
    run("solar", plane(), "--place", "33.9S,18.4E", "--time", NOON, "--json", "-o", "a.csv", *FEW)
    _, out, _ = run("solar", plane(), "--place=-33.9,18.4", "--time", NOON, "--json", "-o", "b.csv", *FEW)
    assert json.loads(out)["place"] == [-33.9, 18.4]
    a, b = (sf.read_scan(name).attributes["kwh"] for name in ("a.csv", "b.csv"))
    np.testing.assert_array_equal(a, b)


def test_figures_by_hand():
    """Four patches of which three count: means by area, the tenth that has most, tilts."""
    values = {"kwh": np.array([1000.0, 400.0, 9e9, 600.0])}
    up, areas = np.array([1.0, 0.0, 1.0, 0.0]), np.array([2.0, 1.0, 50.0, 1.0])
    found = solar.figures(values, up, areas, np.array([True, True, False, True]))
    assert found["points"] == 3
    assert found["area"] == 4.0
    assert found["mean"]["kwh"] == 750.0
    assert found["best_tenth"] == found["most"] == 1000.0
    assert [(t["area"], t["kwh"]) for t in found["tilts"][:3:2]] == [(2.0, 1000.0), (2.0, 500.0)]


@pytest.mark.slow
@pytest.mark.scans
def test_the_typical_year_of_amsterdam(scans, here, run):
    """A level plane has what the file itself says of a level plane, measured apart from its beam and its sky.

    Both know an hour as one number; where in it the sun stands makes up to (pi / 24)^2 / 6, .29 %.
    """
    import pvlib

    file = scans / "weather" / "NLD_Amsterdam062400_IWEC.epw"
    status, _, err = run("solar", plane(), "--epw", file, *FEW)
    assert status == 0, err
    expected = pvlib.iotools.read_epw(file)[0]["ghi"].sum() / 1000.0
    np.testing.assert_allclose(sf.read_scan("plane_solar.ply").attributes["kwh"], expected, rtol=0.0029)
    assert "52.300 N, 4.770 E" in err


@pytest.mark.scans
@pytest.mark.slow
def test_a_tile_of_lidar(scans, here, run):
    """Eugene in the first hour after noon of June: what is open has what a level plane has, to 1 %; nothing has more
    than a plane that faces the sun, with all of the sky, and what the ground and trees reflect.
    """
    pytest.importorskip("pyproj")
    time = "2025-06-21T20:30Z"
    tile = scans / "scans" / "autzen_trim.laz"
    status, out, err = run(
        "solar", tile, "--time", time, "--points", "20k", "-o", "a.npz", "--size", "320x240", "--json"
    )
    assert status == 0, err
    result, columns = json.loads(out), sf.read_scan("a.npz").attributes
    assert 15_000 < result["points"] <= 20_000
    assert f"{len(columns['kwh'])} points are taken of the file, evenly, and written" in err
    assert 40_000 < result["area"] < 120_000  # 359 m by 171 m, of which the river has few points; trees have leaves
    sky = sf.Sky(*result["place"], time, altitude=130.0)
    kwh, seen = columns["kwh"], columns["sky_view"]
    level = (seen > 0.97) & (columns["kwh_beam"] > 0.0)
    assert np.median(kwh[level]) == pytest.approx(sky.global_horizontal / 1000.0, rel=0.01)
    most = (sky.direct_normal + sky.diffuse + 0.2 * sky.global_horizontal) / 1000.0
    assert np.nanmax(kwh) < 1.05 * most
    assert np.nanmin(kwh) >= 0.0
    assert (here / "a.png").exists()
    assert "nothing is classed as vegetation or building" in err
