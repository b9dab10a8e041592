"""`surflux solve --tiles`: a survey tile by tile, goes on after a stop, its map; what it does not take."""

import json

import numpy as np
import pytest

import surflux as sf

FEW = ("--halo", "20", "--rays", "16", "--zeta", "1", "--transport", "rays", "--no-insert")


@pytest.fixture
def tiles(here):
    """Two tiles of 30 m of rolling ground, side by side; their paths."""
    random = np.random.default_rng(0)
    for k in range(2):
        xy = random.uniform([30.0 * k, 0.0], [30.0 * k + 30.0, 30.0], (600, 2))
        dark = np.full((600, 3), 0.1)
        sf.Scan(np.column_stack([xy, np.sin(xy[:, 0] / 7.0)]), reflectance=dark).save(f"{k}.laz")
    return "0.laz", "1.laz"


def test_tiles_are_written_with_their_light_kept_and_drawn(tiles, run):
    arguments = ("solve", *tiles, "--tiles", "-o", "lit", "--light", "sky", *FEW)
    status, out, err = run(*arguments, "--image", "lit/map.png", "--image", "map.exr")
    assert status == 0, err
    assert "the unit of the tiles is taken for metres, as nothing says otherwise (--unit)" in err
    assert "face upwards, as of a terrain seen from above (--viewpoint: elsewhere)" in err
    assert "colours of the scan have a mean reflectance of 0.10, made" in err
    assert "(--raw-colors keeps them)" in err
    assert "2 tiles: 1200 points, as read, with their light, in lit" in out
    assert "map: lit/map.png" in out
    for k in range(2):
        assert np.isfinite(sf.read_scan(f"lit/{k}.laz").attributes["irradiance_r"]).all()
    drawn, low = sf.read_image("map.exr"), sf.read_scan("lit/0.laz")
    assert drawn.shape[1] == pytest.approx(2 * drawn.shape[0], rel=0.05)  # 60 m by 30
    left = drawn[:, : drawn.shape[1] // 2]
    seen = left[left.any(axis=-1)]  # its highest point of each pixel: all between the darkest and the brightest
    radiosity = np.stack([low.attributes[f"radiosity_{c}"] for c in "rgb"], axis=-1)
    assert seen.mean() == pytest.approx(radiosity.mean(), rel=0.05)
    status, out, err = run(*arguments, "--json")
    assert status == 0, err
    found = json.loads(out)
    assert [tile["kept"] for tile in found["tiles"]] == [True, True]
    assert [tile["points"] for tile in found["tiles"]] == [600, 600]
    assert found["input"] == list(tiles)


def test_options_reach_the_solver(tiles, run, monkeypatch):
    given = {}

    def noted(paths, folder, **options):
        given.update(options, paths=paths, folder=str(folder))
        return sf.SolvedTiles(())

    monkeypatch.setattr(sf, "solve_tiles", noted)
    words = "--halo 7 --far 2 --unit 0.3 --points 2k --seed 3 --threads 1 --viewpoint 0,0,9 --normals flip"
    words += " --albedo --keep-outliers --raw-colors --strict --error 2% --tolerance 0.01 --transport rays --no-insert"
    status, _, err = run("solve", *tiles, "--tiles", *words.split())
    assert status == 0, err
    assert "tiles have no light: they get the sun and sky of a clear day, in W/m2 (--light sky)" in err
    solve = {"error": 0.02, "tolerance": 0.01, "transport": "rays", "insert": False}
    flags = dict.fromkeys(("albedo", "keep_outliers", "raw_colors", "strict", "progress"), True)
    assert given == {
        **flags,
        "paths": list(tiles),
        "folder": "tiles_solved",
        "lights": None,
        "halo": 7.0,
        "far": 2.0,
        "unit": 0.3,
        "points": 2000,
        "seed": 3,
        "threads": 1,
        "viewpoint": (0.0, 0.0, 9.0),
        "normals": "flip",
        "solve_options": solve,
    }


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("--tiles --thin 100", "--thin: does not go with --tiles; --points thins all tiles alike"),
        ("--tiles --solution a.ply", "--solution: does not go with --tiles"),
        ("--tiles --direct traced", "--direct: does not go with --tiles; --image is a map"),
        ("--tiles --ground", "--ground: does not go with --tiles"),
        ("--tiles --mesh", "--mesh: does not go with --tiles; tiles hold points"),
        ("--tiles --background 1", "--background: does not go with --tiles"),
        ("--tiles --size 800x600", "--size: does not go with --tiles; --image is a map from above"),
        ("--tiles --eye 0,0,9", "--eye: does not go with --tiles"),
        ("--tiles --target 0,0,9", "--target: does not go with --tiles"),
        ("--tiles --up 0,1,0", "--up: does not go with --tiles"),
        ("--tiles --fov 45", "--fov: does not go with --tiles"),
        ("--tiles --solver meshless", "--solver: wanted radiosity with --tiles"),
        ("--tiles --light studio", "--light: wanted sun or sky with --tiles"),
        ("--tiles --checkpoint kept", "--checkpoint: does not go with --tiles; a run that was stopped goes on"),
        ("--tiles --halo 0", "--halo: wanted"),
        ("--tiles --far 0.5", "--far: wanted"),
        ("--tiles --unit 0", "--unit: wanted"),
        ("--tiles --points 1", "--points: wanted"),
        ("--tiles --image map.jpg", "--image: wanted a name ending in .exr, .png or .hdr"),
        ("--tiles --image none/map.png", "cannot be written: there is no folder none"),
        ("--tiles -o .", "-o: '0.laz' is a tile itself; wanted another folder"),
        ("1.laz --tiles", "tiles: '1.laz' and '1.laz' would both be written as '1.laz'"),
        ("", "SCENE|CLOUD: wanted one file, or tiles of one survey by --tiles; got 2 files"),
        ("--tiles room.ply", "unrecognized arguments: room.ply"),
    ],
)
def test_what_does_not_go_with_tiles_is_refused_before_any_work(tiles, run, here, capfd, arguments, message):
    try:
        status, out, err = run("solve", *tiles, *arguments.split())
    except SystemExit as end:  # of what argparse itself refuses
        status, (out, err) = end.code, capfd.readouterr()
    assert (status, out) == (2, "")
    assert message in err
    assert not (here / "tiles_solved").exists()


@pytest.mark.parametrize("name", ["halo", "far", "unit"])
def test_options_of_tiles_are_refused_without_them(tiles, run, name):
    status, out, err = run("solve", tiles[0], f"--{name}", "5")
    assert (status, out) == (2, "")
    assert f"--{name}: goes with --tiles" in err


def test_tiles_of_no_terrain_ask_for_the_option(here, run):
    random = np.random.default_rng(0)
    points = random.normal(size=(2000, 3))
    sf.Scan(points / np.linalg.norm(points, axis=1, keepdims=True)).save("ball.laz")
    status, _, err = run("solve", "ball.laz", "--tiles")
    assert status == 2
    assert "surflux: error: --viewpoint: wanted where the tiles were seen from" in err
