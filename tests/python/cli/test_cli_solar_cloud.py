"""`surflux solar` of clouds: normals, classes and cleaning."""

import json
from argparse import Namespace

import numpy as np
import pytest

import surflux as sf
from solar_clouds import FEW, NOON, PLACE, plane, town
from surflux.cli.solar_cloud import scene_of_scan
from surflux.cli.solar_site import Frame


@pytest.fixture(autouse=True)
def extra():
    pytest.importorskip("pvlib")


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_normals_are_the_same_whichever_classes_receive(seed):
    """All of the town is seen from above; its roofs alone are no terrain, and each could face either way."""
    scan, roof = town(seed)
    normals = {}
    for receivers in (None, "building"):
        options = {"input": "town.npz", "casters": None, "receivers": receivers, "keep_outliers": False}
        options |= {"viewpoint": None, "normals": None, "colors": False, "albedo": 0.2}
        scene, surfel, told = scene_of_scan(Namespace(**options), scan, Frame())
        assert told.sum() == (np.count_nonzero(roof) if receivers else len(scan))
        assert len(scene.objects) == (2 if receivers else 1)
        np.testing.assert_array_equal(scene.surfels.points[surfel[roof]], scan.points[roof])
        normals[receivers] = scene.surfels.normals[surfel[roof]]
    np.testing.assert_array_equal(normals["building"], normals[None])
    assert normals[None][:, 2].min() > 0.0


def test_receivers_that_all_stand_alone_are_refused_before_any_work(here, run):
    ground = np.load(plane())["points"]
    points = np.concatenate([ground, [[0.0, 0.0, 30.0], [10.0, 0.0, 40.0]]])
    np.savez("two.npz", points=points, classification=np.repeat([2, 6], [len(ground), 2]))
    arguments = ("solar", "two.npz", *PLACE, "--time", NOON, "--receivers", "building", "-o", "a.npz", *FEW)
    status, out, err = run(*arguments)
    assert (status, out) == (2, "")
    assert "surflux: error: two.npz: none of its 2 points of --receivers has a value, for all stand alone" in err
    assert "normals" not in err  # before any work
    assert run(*arguments, "--keep-outliers")[0] == 0
    assert np.isfinite(sf.read_scan("a.npz").attributes["kwh"]).tolist() == [False] * len(ground) + [True] * 2


def test_receivers_that_all_are_repeats_are_refused(here, run):
    ground = np.load(plane())["points"]
    points = np.concatenate([ground, ground[:3]])
    np.savez("twice.npz", points=points, classification=np.repeat([2, 6], [len(ground), 3]))
    status, _, err = run("solar", "twice.npz", *PLACE, "--time", NOON, "--receivers", "building", *FEW)
    assert status == 2
    assert "none of its 3 points of --receivers has a value, for all stand alone (--keep-outliers takes them)" in err
    assert "or where one of another class does" in err


def test_points_without_a_class_count_as_never_classified(here, run):
    points = np.load(plane())["points"]
    classes = np.full(len(points), 2.0)
    classes[7], classes[9] = np.nan, 2.5
    np.savez("some.npz", points=points, classification=classes)
    arguments = ("solar", "some.npz", *PLACE, "--time", NOON, "--receivers", "unclassified", "-o", "a.npz", *FEW)
    status, out, err = run(*arguments, "--json")
    assert status == 0, err
    assert "some.npz: 2 points of 1225 without a class (at index 7: nan) count as class 0, never class" in err
    assert json.loads(out)["points"] == 2
    assert np.flatnonzero(np.isfinite(sf.read_scan("a.npz").attributes["kwh"])).tolist() == [7, 9]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("solve", "solar", "unknown"),
    [((), (), 0), ((), ("--keep-outliers",), 1), (("--thin", 2000), (), 1600)],
    ids=["left out by both", "left out by solve", "thinned"],
)
def test_what_solve_wrote_goes_under_the_sun(here, run, solve, solar, unknown):
    """What solve left out or thinned away has no radius there, and counts again."""
    points = np.concatenate([np.load(plane(count=60))["points"], [[0.0, 0.0, 30.0]]])
    sf.Scan(points, np.tile([0.0, 0.0, 1.0], (3601, 1))).save("tile.npz")
    assert run("solve", "tile.npz", "--no-image", "--rays", 16, "--no-insert", *solve)[0] == 0
    status, _, err = run("solar", "tile_solved.ply", *PLACE, "--time", NOON, *solar, "-o", "a.npz", *FEW)
    assert status == 0, err
    said = f"radius and area not known (NaN) of {unknown} of {3601 if solar else 3600} points: estimated of all"
    assert (said in err) == (unknown > 0)
    kwh = sf.read_scan("a.npz").attributes["kwh"]
    assert np.flatnonzero(np.isnan(kwh)).tolist() == ([] if solar else [3600])
    level = sf.Sky(47.4, 8.5, NOON).global_horizontal / 1000.0
    assert np.median(kwh[:3600]) == pytest.approx(level, rel=1e-3)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("-47S,8", "wanted a sign or a letter, not both, as in -47 or 47S, got '-47S,8'"),
        ("-47N,8", "wanted a sign or a letter, not both, as in -47 or 47S, got '-47N,8'"),
        ("47,-8.5W", "wanted a sign or a letter, not both, as in -8.5 or 8.5W, got '47,-8.5W'"),
    ],
)
def test_a_sign_with_a_letter_is_refused(here, run, capfd, text, message):
    with pytest.raises(SystemExit, match="2"):
        run("solar", plane(), f"--place={text}", "--time", NOON)
    assert f"--place: {message}" in capfd.readouterr().err
