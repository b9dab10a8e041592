"""`surflux bench --quick`: the truth that solvers are judged by, the errors, and the rows, tables and plots of them."""

import functools
import json
import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import surflux as sf
from scenes import cube_inside, patch
from surflux.bench import mitsuba_renderer, plot, scenes, solvers
from surflux.bench.truth import Truth, area_sample, errors_against, even_squares, local_errors_against, places_on
from surflux.cli import commands

SMALL = replace(solvers.QUICK, surfels=12, rounds=4, samples=(1, 4))


def test_the_truth_of_a_patch_is_its_mean():
    """Over a square of side 2 the mean of I cos / r^2 from 1 over its centre is I solid angle / 4, 2 pi / 3 of it."""
    floor = patch([-1, -1, 0], [2, 0, 0], [0, 2, 0], 0.5)
    scene = sf.Scene([floor], [sf.PointLight([0, 0, 1], 3.0)])
    truth = Truth(scene, floor, 2)
    expected = 3.0 * (2 * np.pi / 3) / 4
    assert np.all(np.abs(truth.total - expected) < 5 * truth.total_error)
    assert np.all(truth.total_error < 0.05 * expected)
    assert np.all(truth.indirect == 0.0)


def test_the_truth_of_a_disk_is_its_centre():
    disk = sf.Surfels([[0, 0, 0]], [[0, 0, 1]], radii=1.0, areas=3.0)
    truth = Truth(sf.Scene([disk], [sf.PointLight([0, 0, 1], 3.0)]), disk, 2)
    np.testing.assert_allclose(truth.total, 3.0, rtol=1e-6)


def test_direct_and_indirect_light_of_a_furnace():
    """B = E / (1 - rho) = 2 sends H = 2 to all; a light inside adds what the same rays find in the dark scene."""
    cube = cube_inside(2, 0.5, 1.0)
    truth = Truth(sf.Scene([cube]), cube, 8)
    assert np.all(np.abs(truth.total - 2.0) < 5 * truth.total_error)
    np.testing.assert_array_equal(truth.indirect, truth.total)
    lit = Truth(sf.Scene([cube], [sf.PointLight([0.5, 0.5, 0.5], 1.0)]), cube, 8)
    direct = lit.total - lit.indirect
    dark = sf.Scene([cube_inside(2, 0.0)], [sf.PointLight([0.5, 0.5, 0.5], 1.0)])
    np.testing.assert_allclose(direct, Truth(dark, cube, 8).total, rtol=1e-9)
    before = np.sum(lit.total_error**2)
    for _ in range(12):
        lit.refine()
    assert np.sum(lit.total_error**2) < 0.75 * before  # a quarter in the mean
    assert lit.paths == 8 * 16 * 1024


def test_surfels_are_drawn_by_area_and_places_evenly():
    areas = np.array([1.0, 0.0, 3.0, 6.0])
    assert np.bincount(area_sample(areas, 1000), minlength=4).tolist() == [100, 0, 300, 600]
    # A triangle and a quadrilateral: places lie on their surfel, and their mean is its centroid.
    triangle = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]))
    both = sf.Scene([triangle, patch([0, 0, 2], [3, 0, 0], [0, 1, 0])]).surfels
    rows = np.repeat([0, 1], 400)
    places, normals = places_on(both, rows, even_squares([0, 1], 0, 400))
    for k in (0, 1):
        np.testing.assert_allclose(places[rows == k].mean(axis=0), both.points[k], atol=0.02)
    assert np.all(places[:400].sum(axis=1) <= 1.0)
    assert places[400:, 0].max() > 2.9
    np.testing.assert_array_equal(normals, np.tile([0.0, 0.0, 1.0], (800, 1)))


def test_errors_are_relative_by_area_and_without_the_noise_of_the_reference():
    exact = np.tile([3.0, 0.0, 4.0], (50, 1))
    surfels = sf.Surfels(np.random.default_rng(0).random((50, 3)), np.tile([0, 0, 1.0], (50, 1)), radii=1, areas=1)
    truth = Truth(sf.Scene([surfels]), surfels, 200, exact=exact)
    value = np.array(truth.total)
    value[:, 1] += 0.1
    value[7, 1] += 4.9  # one of 200 is off by 100 %: beyond the 99th percentile
    found = errors_against(truth, value, truth.indirect)
    assert found["error"] == pytest.approx(np.sqrt((199 * 0.01 + 25.0) / (200 * 25.0)))
    assert found["percentile_99"] == pytest.approx(0.02)
    assert (found["indirect"], found["reference"], found["percentile_99_indirect"]) == (0.0, 0.0, 0.0)
    found = errors_against(truth, truth.total, value)
    assert found["percentile_99"] == 0.0
    assert found["percentile_99_indirect"] > 0.01

    noisy = SimpleNamespace(total=value, indirect=value, total_error=np.full((200, 3), 0.5), indirect_error=0 * value)
    noise = np.random.default_rng(1).normal(scale=0.5, size=value.shape)
    noisy.total = truth.total + noise
    found = errors_against(noisy, truth.total, None)
    assert found["error"] < 0.05 < found["reference"]
    assert found["indirect"] is None


def test_leaves_of_a_solution_are_taken_together():
    leaves = SimpleNamespace(surfels=SimpleNamespace(areas=np.array([1.0, 3.0, 2.0])), parents=np.array([0, 0, 1]))
    values = np.array([[1.0, 0, 0], [5.0, 0, 4], [7.0, 7, 7]])
    np.testing.assert_allclose(solvers.by_scene_surfel(leaves, values, 2), [[4, 0, 3], [7, 7, 7]])


@pytest.mark.parametrize(("name", "surfels"), [("three spheres", 4326), ("Cornell box", 2568)])
def test_scenes_at_full_density_are_those_of_the_files(name, surfels):
    built = scenes.build(name)
    assert len(built.scene.surfels) == surfels
    coarse = scenes.build(name, 0.5)
    assert surfels / 4.2 < len(coarse.scene.surfels) < surfels / 3.8
    polygons = coarse.polygons()
    assert not polygons.lights
    assert len(np.unique(polygons.surfels.triangle_surfel)) == len(polygons.surfels)
    lamps = polygons.surfels[polygons.surfels.emission[:, 0] > 0]
    power = sum(
        np.linalg.norm(np.cross(light.edge_u, light.edge_v)) * light.exitance[0] for light in built.scene.lights
    )
    assert np.sum(lamps.areas * lamps.emission[:, 0]) == pytest.approx(power)
    targets = scenes.targets_on(polygons, coarse.scene)
    assert len(targets) == len(coarse.scene.surfels)
    assert np.sum(targets.areas) == pytest.approx(np.sum(polygons.surfels.areas) - np.sum(lamps.areas))


def test_what_has_no_polygons_is_not_rendered_as_others_would():
    assert scenes.build("statues", 0.5).polygons is None  # a boulder and a knot of points, and a spot light
    assert scenes.build("door ajar", 0.25).polygons is not None


@pytest.mark.scans
@pytest.mark.slow
def test_two_bunnies_as_polygons(scans):
    built = scenes.build("two bunnies", 0.1)
    assert len(built.polygons().surfels) > 137_000  # the bunnies' own faces
    assert len(built.scene.surfels) == 6 * 4 + 2 * 348  # of 34 834 each


def test_scenes_with_other_lights_have_no_polygons():
    scene = sf.Scene([cube_inside(1)], [sf.PointLight([0.5, 0.5, 0.5], 1.0)])
    with pytest.raises(ValueError, match="scene: wanted area lights alone, got a PointLight"):
        scenes.with_solid_lamps(scene)


@pytest.mark.slow
def test_knobs_of_a_solver_and_the_plot(monkeypatch, tmp_path, capsys):
    small = replace(SMALL, densities={"concentric spheres": (0.25, 0.5), "three spheres": (0.1,)})
    knobs_at = {"concentric spheres": 0.25, "three spheres": 0.1}
    small = replace(small, samples=(4, 16, 64), every_setting=True, knobs_at=knobs_at)
    monkeypatch.setattr(solvers, "QUICK", small)
    monkeypatch.setattr(mitsuba_renderer, "load", lambda threads: None)
    usual = solvers.SOLVERS["meshless"]

    @functools.wraps(usual.run)
    def quick(scene, **options):  # what it takes is no test
        return usual.run(scene, **({} if "error" in options else {"levels": 1}) | options)

    monkeypatch.setitem(solvers.SOLVERS, "meshless", replace(usual, run=quick))
    for name, solver in solvers.SOLVERS.items():
        asked = [{"error": error} for error in (0.2, 0.15, 0.1, 0.08)]
        monkeypatch.setitem(solvers.SOLVERS, name, replace(solver, knobs=solver.knobs | {"error": asked}))
    text, rows, plot = tmp_path / "bench.md", tmp_path / "bench.json", tmp_path / "bench.png"
    chosen = ["--scene", "concentric spheres", "--scene", "three spheres", "--repeats", "1"]
    paths = ["--markdown", str(text), "--json", str(rows), "--plot", str(plot)]
    assert commands.main(["bench", "--quick", *chosen, *paths]) == 0
    assert capsys.readouterr().out == text.read_text()
    found = json.loads(rows.read_text())["rows"]
    closed = [row for row in found if row["scene"] == "concentric spheres"]
    pairs = [row for row in closed if row["solver"] == "pairs"]
    assert [row["knob"] for row in pairs] == ["surfels", *["error"] * 4, *["rays"] * 3, *["tolerance"] * 3, "surfels"]
    meshless = [row for row in closed if row["solver"] == "meshless"]
    assert [row["knob"] for row in meshless] == [
        "surfels",
        *["error"] * 4,
        *["rays"] * 3,
        *["epsilon_e"] * 3,
        *["levels"] * 3,
        "surfels",
    ]
    rays = [row for row in closed if row["solver"] == "rays"]
    knobs = ["surfels", *["error"] * 4, *["rays"] * 3, *["zeta"] * 3, "insert"]
    assert [row["knob"] for row in rays] == [*knobs, "surfels"]
    knobs = {*knobs, "shadow rays", "tolerance", "epsilon_e", "levels", "samples"}
    assert {row["knob"] for row in found} == knobs
    coarse, fine = (row["error"] for row in pairs if row["knob"] == "surfels")
    assert 0.0 < fine < coarse < 0.05  # finer spheres are nearer to the closed form
    assert (pairs[5]["options"], rays[5]["options"]) == ({"rays": 16}, {"rays": 32})
    assert pairs[0]["error"] == pairs[5]["error"]  # no ray decides anything between these spheres
    assert rays[0]["error"] < rays[5]["error"]
    traced = [row for row in closed if row["solver"] == "path tracing"]
    assert [row["value"] for row in traced] == ["16", "64"]
    assert traced[1]["error"] < 0.85 * traced[0]["error"]  # noise: four times the paths halve it, in the mean
    for row in found:
        assert 0.0 <= row["error"] < 0.4
        assert 0.0 <= row["local"] <= row["local_90"]
        if row["solver"] != "path tracing":
            assert row["seconds"] >= 0.5 * sum(row["stages"].values()) > 0
            assert row["rays"] > row["surfels"]
    assert text.read_text().count("closed form") == len(closed)
    assert text.read_text().count("\n| three spheres |") == len(found) - len(closed)
    assert sf.read_image(plot).std() > 0.05  # something is drawn


@pytest.mark.slow
def test_of_knobs_the_first_and_the_last_value_are_quick(monkeypatch):
    """One that has one value has it once."""
    chosen = {"rays": replace(solvers.SOLVERS["rays"], knobs={})}
    knobs = {"insert": [{"insert": False}], "zeta": [{"zeta": z} for z in (0.1, 0.04, 0.02)]}
    monkeypatch.setitem(chosen, "rays", replace(chosen["rays"], knobs=knobs))
    monkeypatch.setattr(solvers, "SOLVERS", chosen)
    built = scenes.build("concentric spheres", 0.25)
    rows = solvers.of_solvers("concentric spheres", built, SMALL, True, 1, None)
    assert [row.options for row in rows if row.solver != "path tracing"] == [
        {},
        {"insert": False},
        {"zeta": 0.1},
        {"zeta": 0.02},
    ]


def test_no_two_curves_look_alike():
    curves = [(name, knob) for name, solver in solvers.SOLVERS.items() for knob in ("surfels", *solver.knobs)]
    styles = [
        tuple(plot._style(*curve).values()) for curve in [*curves, ("path tracing", "samples"), ("Mitsuba", "samples")]
    ]
    assert len(set(styles)) == len(styles)


def test_errors_by_local_light():
    """A tenth off is a tenth, however dark it is there; below a thousandth of the RMS nothing is asked for."""
    true = np.array([1.0, 0.01, 0.01, 1e-4])[:, None] * np.ones(3)
    truth = SimpleNamespace(total=true, total_error=0.06 * true)
    off = np.array([1.1, 0.9, 1.1, 9.0])[:, None]
    found = local_errors_against(truth, off * true)
    assert found == pytest.approx({"local": 0.08, "local_90": 0.08, "reference_local": 0.06})


def test_errors_of_a_row_are_those_of_all_seeds():
    truth = Truth(sf.Scene([cube_inside(1)]), cube_inside(1), 6, exact=np.full((6, 3), 2.0))
    row = solvers.Row("a", "rays", "rays", "16", 6, 1.0, *6 * (0.0,))
    solvers._fill(row, truth, [(truth.total * (1.0 + off), truth.indirect) for off in (0.03, -0.04)])
    assert row.error == row.local == pytest.approx(np.sqrt((0.03**2 + 0.04**2) / 2))
    assert row.indirect == 0.0


def test_curves_of_knobs_go_through_the_defaults():
    def row(knob, surfels, options, seconds):
        return solvers.Row("a", "pairs", knob, "", surfels, seconds, *6 * (0.1,), options=options)

    rows = [row("surfels", 10, {}, 1), row("rays", 10, {"rays": 16}, 2), row("rays", 10, {"rays": 1024}, 3)]
    rows.append(row("surfels", 40, {}, 4))
    found = plot.curves(rows)
    assert [r.seconds for r in found["pairs", "surfels"]] == [1, 4]
    assert [r.seconds for r in found["pairs", "rays"]] == [2, 1, 3]  # 256 rays lie between
    rows += [row("error", 10, {"error": error}, 5 + error) for error in (0.04, 0.02)]
    assert [r.seconds for r in plot.curves(rows)["pairs", "error"]] == [5.02, 5.04]  # without one nothing is asked


def test_an_error_is_claimed_if_the_reference_is_four_times_as_sure():
    row = solvers.Row("a", "solve", "rays", "16", 10, 1.0, 0.04, 0.03, 0.5, 0.001, 0.01, 0.01)
    assert (row.is_claimed("error"), row.is_claimed("indirect")) == (True, False)
    assert "| 4 ± 0.1 | ~ 3 | 50 |" in solvers.table([row])


def test_mitsuba_is_left_out_aloud_where_it_is_not_installed(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "mitsuba", None)
    assert mitsuba_renderer.load() is None
    assert capsys.readouterr().err == "bench: Mitsuba left out: it is not installed (pip install 'surflux[bench]')\n"
    assert commands.main(["bench", "--reference"]) == 0
    assert "Mitsuba left out" in capsys.readouterr().err
