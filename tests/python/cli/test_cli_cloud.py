"""`surflux solve` of a cloud: what is cleaned, and what comes home to the rows of its file."""

import json
from pathlib import Path

import numpy as np
import pytest

import surflux as sf
from pixels import pixels
from surflux.cli.cloud import exposed
from surflux.scenes import shapes


@pytest.fixture
def survey(here):
    """3000 points of a ball without normals; behind them 100 of them again, and one that stands alone."""
    points = shapes.sphere(3000, 2.0).points
    rows = np.concatenate([points, points[500:600], [[0.0, 0.0, 5.0]]])
    scan = sf.Scan(rows + np.array([1000.0, 2000.0, 0.0]), attributes={"classification": np.arange(3101) % 7})
    scan.save("survey.npz")
    return scan


def test_all_rows_come_home_in_their_order(survey, run):
    files = "-o", "lit.csv", "--solution", "solution.ply"
    status, out, err = run("solve", "survey.npz", *files, "--no-image", "--insert")
    assert status == 0, err
    assert "3101 points, as read, with their light but for 1 left out: lit.csv\nsolved surfels: solution.ply\n" in out
    assert "counted once, for another one stands at their place: 100 points" in err
    assert "isolated, left out of light and picture: 1 point of 3101 (--keep-outliers keeps them)" in err
    lit = sf.read_scan("lit.csv")
    assert np.array_equal(lit.points, survey.points)
    assert np.array_equal(lit.attributes["classification"], survey.attributes["classification"])
    assert np.flatnonzero(lit.attributes["left_out"]).tolist() == [3100]
    solution = sf.load_solution("solution.ply")
    for name in ("irradiance", "direct", "radiosity"):
        found = np.stack([lit.attributes[f"{name}_{c}"] for c in "rgb"], axis=-1)
        assert np.isnan(found[3100]).all()
        assert np.array_equal(found[3000:3100], found[500:600])
        # Inserted surfels give their light to those that they stand for, by their areas.
        assert found[:3000] == pytest.approx(solution.per_surfel(name), rel=1e-6)
        power = np.sum(solution.surfels.areas[:, None] * getattr(solution, name), axis=0)
        area = np.bincount(solution.parents, solution.surfels.areas)
        assert np.sum(area[:, None] * found[:3000], axis=0) == pytest.approx(power, rel=1e-6)


def test_points_beside_a_shadow_are_in_it_or_in_the_sun(here, run):
    """Each has the light at its own place: what surfels inserted around it have would be a mean."""
    side = np.linspace(-1.0, 1.0, 40)
    x, y = (axis.ravel() for axis in np.meshgrid(side, side))
    floor, roof = np.stack([x, y, 0 * x], axis=-1), np.stack([0.25 * x, 0.25 * y, 0 * x + 0.4], axis=-1)
    sf.Scan(np.concatenate([floor, roof]), np.tile([0.0, 0.0, 1.0], (3200, 1))).save("table.npz")

    def sunlight(*more):
        status, _, err = run("solve", "table.npz", "-o", "lit.npz", "--no-image", "--light", "sun", "--rays", 32, *more)
        assert status == 0, err
        direct = sf.read_scan("lit.npz").attributes["direct"][:1600].mean(axis=1)
        return direct / np.median(direct)

    def between(light):
        return np.count_nonzero((light > 0.35) & (light < 0.8))

    light = sunlight()
    assert np.count_nonzero(light < 0.35) > 60
    assert between(light) == 0
    assert between(sunlight("--insert")) > 10


def test_what_is_left_out_can_be_kept(survey, run):
    status, out, err = run("solve", "survey.npz", "-o", "lit.npz", "--no-image", "--keep-outliers", "--json")
    assert status == 0, err
    result = json.loads(out)
    assert (result["points"], result["left_out"]) == (3101, 0)
    lit = sf.read_scan("lit.npz")
    assert "left_out" not in lit.attributes
    assert np.isfinite(lit.attributes["irradiance"]).all()


def test_points_that_are_thinned_away_have_the_light_around_them(survey, run):
    """Of a ball in an even sky of radiance 1 each point has pi, however many of them were solved."""
    status, _, err = run("solve", "survey.npz", "-o", "lit.npz", "--no-image", "--thin", 1000, "--light", "sky")
    assert status == 0, err
    irradiance = sf.read_scan("lit.npz").attributes["irradiance"]
    assert np.isnan(irradiance).any(axis=1).nonzero()[0].tolist() == [3100]
    assert irradiance[:3100] == pytest.approx(np.pi, rel=0.02)


@pytest.mark.slow
def test_the_file_is_also_a_solution(survey, run):
    assert run("solve", "survey.npz", "--size", "80x60", "--thin", 2000)[0] == 0
    solution = sf.load_solution("survey_solved.ply")
    assert len(solution.surfels) == 2000
    assert solution.camera is not None
    assert run("render", "survey_solved.ply", "--image", "again.png", "--size", "80x60")[0] == 0
    first, again = pixels("survey_solved.png").astype(float), pixels("again.png").astype(float)
    ball = first.max(axis=2) > 100
    assert ball.mean() > 0.2
    # Without inserted surfels and on another background, the ball is the same to an eye.
    assert np.abs(first - again)[ball].mean() < 5
    status, _, err = run("solve", "survey_solved.ply")
    assert status == 2
    assert "is solved already" in err


@pytest.mark.slow
def test_its_colours_are_those_of_its_light_or_its_own(here, run):
    red = shapes.sphere(2000, 1.0).replace(reflectance=[0.4, 0.3, 0.2])
    sf.Scan(red.points, red.normals, red.reflectance).save("red.npz")
    assert run("solve", "red.npz", "-o", "lit.npz", "--no-image", "--raw-colors")[0] == 0
    assert run("solve", "red.npz", "-o", "own.npz", "--no-image", "--raw-colors", "--albedo")[0] == 0
    lit, own = sf.read_scan("lit.npz").display_colors(), sf.read_scan("own.npz").display_colors()
    assert np.array_equal(own, sf.read_scan("red.npz").display_colors())
    assert lit[:, 0].std() > 20  # shaded from lit to shadow
    assert own[:, 0].std() == 0


@pytest.mark.slow
def test_dark_colours_of_a_scan_are_exposed(here, run):
    rng = np.random.default_rng(0)
    for bright, wanted in ((0.1, 0.3), (0.4, None), (0.9, 0.5)):
        s = shapes.sphere(500, 1.0).replace(reflectance=np.clip(bright * rng.uniform(0.5, 1.5, (500, 3)), 0, 0.97))
        mean = exposed(s).reflectance.mean()
        assert mean == pytest.approx(s.reflectance.mean() if wanted is None else wanted, rel=1e-3)
        sf.Scan(s.points, s.normals, s.reflectance).save("some.npz")
        err = run("solve", "some.npz", "-o", "lit.npz", "--no-image")[2]
        assert (f"made {wanted:.2f} (--raw-colors keeps them)" in err) if wanted else "--raw-colors" not in err


def test_what_goes_with_clouds_alone_is_refused(here, run):
    for flag in ("--albedo", "--strict", "--keep-outliers", "--raw-colors"):
        status, _, err = run("solve", "room.toml", flag)
        assert status == 2
        assert f"{flag}: is for a cloud" in err
    status, _, err = run("solve", "room.toml", "-o", "room.las")
    assert (status, "-o: wanted a name ending in .ply, .glb, .gltf, got 'room.las'" in err) == (2, True)
    Path("holes.csv").write_text("x,y,z\n0,0,0\nnan,0,0\n1,0,0\n1,1,0\n")
    status, _, err = run("solve", "holes.csv", "--strict")
    assert status == 2
    assert "point 1: is at (nan, 0, 0); wanted finite coordinates" in err
    status, _, err = run("solve", "holes.csv", "-o", "out.xyz")
    assert (status, "-o: wanted a name ending in .ply, .las" in err) == (2, True)


def test_terrain_lies_in_the_sun(here, run):
    """800 sin 40 + 100 W/m2 on level ground, wherever the camera stands.

    A lamp lights what is no terrain, and a ground is no row of the file.
    """
    rng = np.random.default_rng(2)
    points = np.column_stack([rng.uniform(0, 50, (4000, 2)), np.zeros(4000)])
    sf.Scan(points).save("field.npz")
    status, _, err = run("solve", "field.npz", "-o", "lit.npz", "--size", "80x60", "--image", "field.png")
    assert status == 0
    assert "terrain has no light: it gets the sun and sky of a clear day" in err
    lit = sf.read_scan("lit.npz")
    assert np.median(lit.attributes["irradiance"]) == pytest.approx(800 * np.sin(np.radians(40)) + 100, rel=0.01)
    assert "Sky(sun 40.0 up at 150.0" in err
    assert "Sky(sun 40.0 up at 150.0" in run("solve", "field.npz", "-o", "lit.npz", "--no-image", "--eye", "9,0,50")[2]
    corner = pixels("field.png")[0, 0].astype(int)
    assert corner.max() - corner.min() <= 1  # what lies behind is that of the day, whose radiance has no colour
    status, _, err = run("solve", "field.npz", "-o", "ground.npz", "--no-image", "--light", "studio", "--ground")
    assert status == 0
    assert "sun" not in err
    assert len(sf.read_scan("ground.npz")) == 4000
    status, _, err = run("solve", "field.npz", "-o", "lit.npz", "--no-image", "--up", "0,0,-1")
    assert (status, "a cloud has no light: it gets a lamp" in err) == (0, True)  # z is not up, and it is no terrain


def test_colours_of_few_points_do_not_turn_white(here):
    """Nine tenths are black: the others are exposed by their own mean, and keep their hue."""
    rho = np.zeros((1000, 3))
    rho[:100] = [0.3, 0.1, 0.05]
    found = exposed(shapes.sphere(1000, 1.0).replace(reflectance=rho)).reflectance
    assert not found[100:].any()
    assert found[:100].mean() == pytest.approx(0.3)
    assert found[0] / found[0, 0] == pytest.approx([1, 1 / 3, 1 / 6])


@pytest.mark.slow
@pytest.mark.parametrize(("suffix", "channel"), [("csv", "_r"), ("npz", "")])
def test_what_is_lit_can_be_lit_again(survey, run, suffix, channel):
    """Its colours are light, and its reflectance stands beside them, in NPZ as one array."""
    assert run("solve", "survey.npz", "-o", f"once.{suffix}", "--no-image", "--light", "sky")[0] == 0
    assert run("solve", f"once.{suffix}", "-o", f"twice.{suffix}", "--no-image", "--light", "sky")[0] == 0
    once, twice = (sf.read_scan(f"{name}.{suffix}").attributes for name in ("once", "twice"))
    assert np.array_equal(twice[f"reflectance{channel}"], once[f"reflectance{channel}"], equal_nan=True)
    first, again = (found[f"irradiance{channel}"][:3100] for found in (once, twice))
    assert again == pytest.approx(first, rel=0.02)
    assert np.array_equal(twice["left_out"], once["left_out"])


def test_columns_of_the_cloud_are_none_of_the_solution(here, run):
    ball = shapes.sphere(500, 1.0)
    sf.Scan(ball.points, attributes={"level": np.full(500, np.nan), "cut": np.full(500, -3)}).save("ball.npz")
    assert run("solve", "ball.npz", "--no-image")[0] == 0
    assert len(sf.load_solution("ball_solved.ply").surfels) == 500


def test_patches_are_no_cloud(here, run):
    sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]), 0.1).save("floor.ply")
    status, _, err = run("solve", "floor.ply", "-o", "out.las")
    assert (status, "-o: wanted a name ending in .ply, .glb, .gltf, got 'out.las'" in err) == (2, True)
    status, _, err = run("solve", "floor.ply", "--albedo")
    assert (status, "--albedo: is for a cloud" in err) == (2, True)
    assert run("solve", "floor.ply", "--no-image", "--light", "sky")[0] == 0


def test_what_a_file_withholds_is_left_out(here, run):
    points = shapes.sphere(800, 1.0).points
    sf.Scan(points, attributes={"withheld": (np.arange(800) % 100 == 7).astype(np.uint8)}).save("ball.las")
    status, _, err = run("solve", "ball.las", "-o", "lit.las", "--no-image")
    assert status == 0
    assert "withheld by their file, left out: 8 points of 800 (--keep-outliers keeps them)" in err
    dark = np.isnan(sf.read_scan("lit.las").attributes["irradiance_r"])
    assert np.flatnonzero(dark).tolist() == list(range(7, 800, 100))


def test_up_is_up(here, run):
    """A statue that shows most along what is up, where a camera cannot have it up, is looked at from the side."""
    rng = np.random.default_rng(0)
    disk = rng.normal(size=(4000, 3)) * [1, 0.02, 1]
    sf.Scan(disk, np.tile([0.0, 1.0, 0.0], (4000, 1))).save("disk.ply")
    assert run("solve", "disk.ply", "--up", "0,1,0", "--size", "40x30")[0] == 0
    camera = sf.load_solution("disk_solved.ply").camera
    ahead = (camera.target - camera.eye) / np.linalg.norm(camera.target - camera.eye)
    assert abs(ahead[1]) < 0.8
    assert camera.up.tolist() == [0, 1, 0]


def test_vectors_may_begin_with_a_minus(ball, run):
    status, _, err = run("solve", "ball.ply", "--viewpoint", "-9,0,0.5", "--eye", "-6,0,1", "--no-image")
    assert status == 0, err
    assert sf.load_solution("ball_solved.ply").camera.eye.tolist() == [-6, 0, 1]


def test_a_scan_is_not_written_over(ball, run):
    before = Path("ball.ply").read_bytes()
    status, _, err = run("solve", "ball.ply", "-o", "./ball.ply")
    assert (status, "-o: is the input itself, 'ball.ply'; wanted another name" in err) == (2, True)
    assert Path("ball.ply").read_bytes() == before


def test_points_that_are_read_alone_are_told_of(survey, run):
    status, _, err = run("solve", "survey.npz", "-o", "some.npz", "--no-image", "--points", 1500)
    assert status == 0
    some = sf.read_scan("some.npz")
    assert f"{len(some)} points are taken of the file, evenly, and written (--points; --thin writes all)" in err
    assert np.array_equal(some.points, survey.points[some.attributes["row"]])


@pytest.mark.slow
@pytest.mark.parametrize("forward", [1, -1])
def test_the_frame_of_a_depth_camera_stands_upright(here, run, forward):
    """A ball at the height of the camera in front of a wall: y is down where z is ahead, and up where z is behind."""
    u, v = np.meshgrid(np.linspace(-0.5, 0.5, 90), np.linspace(-0.4, 0.4, 70))
    ray = np.column_stack([u.ravel(), v.ravel(), np.ones(u.size)])
    along, squared = ray @ [0.3, 0, 3], (ray**2).sum(axis=1)
    root = np.clip(along**2 - squared * (9.09 - 0.5), 0, None)
    depth = np.where(root > 0, (along - np.sqrt(root)) / squared, 5.0)
    sf.Scan(ray * depth[:, None] * [1, 1, forward]).save("frame.npz")
    status, _, err = run("solve", "frame.npz", "--size", "40x30", "-o", "lit.ply")
    assert status == 0
    assert f"the picture has {'-y' if forward > 0 else 'y'} for up, as the frame of a depth camera has (--up)" in err
    camera = sf.load_solution("lit.ply").camera
    assert camera.up.tolist() == [0, -forward, 0]
    ahead = camera.target - camera.eye
    assert forward * ahead[2] == pytest.approx(np.linalg.norm(ahead))  # as the camera did


@pytest.mark.slow
def test_up_is_y_in_gltf(ball, run):
    from surflux.meshes.gltf_container import Container

    for up, wanted in (("0,0,1", [0, 0, 1]), ("0,1,0", [0, 1, 0])):
        assert run("solve", "ball.ply", "-o", "ball.glb", "--no-image", "--up", up)[0] == 0
        matrix = np.reshape(Container("ball.glb").header["nodes"][0].get("matrix", np.eye(4)), (4, 4)).T
        assert matrix[:3, :3] @ wanted == pytest.approx([0, 1, 0])
