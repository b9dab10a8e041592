"""Every solver against every case of tests/cases, and the path tracer against those that it knows the geometry of."""

from dataclasses import replace

import numpy as np
import pytest

import surflux as sf
from cases import CASES, chance, closed_forms
from cases.case import converge, problem_of
from cases.solvers import SOLVERS, Solver, at_surfels

BY_NAME = {case.name: case for case in CASES}
SAMPLES = 1024


# Of cases that take seconds by any solver.
SLOW = (
    "equal disks, patches",
    "concentric spheres, points",
    "elements under a disk, points",
    "sphere inside, rough materials",
    "behind a slit",
    "two long rooms",
    "canyon",
    "cylinder, points, an end glows",
    "sphere inside, points",
    "unequal disks, points",
    "half sky on a slope, points",
    "disks with one between, patches",
    "squares with one between, patches",
    "squares with one between, points",
    "unequal disks, patches",
    "plates, patches",
    "half sky over a ledge, patches",
    "cylinder, points, the side glows",
    "one bounce, patches",
    "cylinder, patches, the side glows",
    "plates, points",
    "cylinder, patches, an end glows",
    "half sky, points",
    "equal disks, points",
    "half sky on a slope, patches",
    "half sky, patches",
)


def runs():
    """All entries of the table; quick ones are each case by one of the solvers, which take turns."""
    for k, case in enumerate(CASES):
        problem = problem_of(case, case.densities[0])
        taking = [name for name, solver in SOLVERS.items() if solver.takes(problem)]
        for name in taking:
            slow = case.name in SLOW or name != taking[k % len(taking)]
            yield pytest.param(case, SOLVERS[name], id=f"{case.name}-{name}", marks=[pytest.mark.slow] * slow)


def complaint(case, solver, found):
    """What is wrong with a convergence, in words; none where nothing is."""
    tolerance, order = case.judged(solver)
    # Solvers that interpolate need a few surfels to do it between.
    judged = found.errors if order is None and not solver.own_error else found.errors[-1:]
    if not max(judged) <= tolerance:
        return f"errors {found.errors}, wanted at most {tolerance}. {case.derivation}"
    # Below the error that a solver makes by itself, or far below the tolerance from the first, nothing is left to fall.
    falls = min(found.errors) > solver.error_of(case) and max(found.errors) > 0.1 * tolerance
    if order is not None and falls and not found.order >= order:
        return f"order {found.order:.2f} of errors {found.errors}, wanted at least {order}. {case.derivation}"
    return None


@pytest.mark.parametrize(("case", "solver"), list(runs()))
def test_case(case, solver):
    assert complaint(case, solver, converge(case, solver)) is None


@pytest.mark.parametrize("case", [pytest.param(c, id=c.name) for c in CASES if c.off is not None])
def test_the_path_tracer(case):
    problem = problem_of(case, case.densities[-1])
    points, normals, expected = problem.reference_points(24)
    value, error = sf.reference_irradiance(problem.scene, points, normals, samples=SAMPLES)
    for c in range(3):
        # Where there is no spread, the value itself, which an opening far away may be off by as well.
        sure = error[:, c] < 1e-9 * expected.max()
        np.testing.assert_allclose(value[sure, c], expected[sure, c], rtol=1e-6 + case.off, atol=1e-9)
        if c > 0 and np.array_equal(value[:, c], value[:, 0]) and np.array_equal(expected[:, c], expected[:, 0]):
            continue  # grey
        if sure.all():
            continue
        z = chance.scores(value[~sure, c], expected[~sure, c], error[~sure, c], SAMPLES, case.off)
        largest, probability, lean = chance.agreement(z)
        assert largest < chance.LARGEST_SCORE
        assert probability > chance.LEAST_PROBABILITY
        assert abs(lean) < 4


@pytest.mark.slow
def test_a_wrong_solver_is_found():
    """Each kind of judgement can fail: too far off, no order, and an expected value that is another."""
    exact, plates = BY_NAME["sun, points"], BY_NAME["plates, patches"]

    def with_share_lost(scene, **quality):
        return 0.99 * SOLVERS["solve"](scene, **quality)

    for case in (exact, plates):
        for own_error, wrong in ((0.0, True), (0.05, False)):
            solver = Solver(with_share_lost, own_error=own_error)
            assert (complaint(case, solver, converge(case, solver)) is not None) == wrong, (case.name, own_error)

    def never_better(scene, **quality):
        return np.full((len(scene.surfels), 3), 2.0 * (1 + 5e-5))

    sphere = BY_NAME["sphere inside, points"]
    found = converge(sphere, Solver(never_better))
    assert found.errors[-1] < sphere.tolerance
    assert "order" in complaint(sphere, Solver(never_better), found)
    assert complaint(sphere, Solver(never_better, own_error=1e-4), found) is None
    assert complaint(sphere, SOLVERS["solve"], replace(found, errors=[9e-6] * 3)) is None

    # Of the same errors, those of form factors are judged by a bound of their own.
    found = replace(found, errors=[2 * plates.factors] * 3)
    assert plates.factors < plates.tolerance / 2
    assert complaint(plates, SOLVERS["solve"], found) is None
    assert "wanted at most" in complaint(plates, SOLVERS["form_factors"], found)

    problem = problem_of(plates, plates.densities[-1])
    points, normals, expected = problem.reference_points(24)
    value, error = (a[:, 0] for a in sf.reference_irradiance(problem.scene, points, normals, samples=SAMPLES))
    keep = error > 0
    z = chance.scores(value[keep], 1.05 * expected[keep, 0], error[keep], SAMPLES)
    assert chance.agreement(z)[1] < 1e-6
    assert chance.agreement(chance.scores(value[keep], 1.05 * expected[keep, 0], error[keep], SAMPLES, 0.05))[1] > 1e-3


def test_the_field_of_a_refined_solution_is_that_of_its_parents():
    class Refined:
        surfels = sf.Surfels(np.zeros((3, 3)), [[0, 0, 1]] * 3, radii=1.0, areas=[1.0, 3.0, 2.0])
        parents = np.array([1, 1, 0])
        irradiance = np.array([[1.0, 2.0, 3.0], [5.0, 2.0, 3.0], [7.0, 7.0, 7.0]])

    scene = sf.Scene([sf.Surfels(np.zeros((2, 3)), [[0, 0, 1]] * 2, radii=1.0)])
    np.testing.assert_allclose(at_surfels(Refined, scene), [[7, 7, 7], [4, 2, 3]])


def test_closed_forms_give_the_figures_of_tables():
    """DESIGN section 7; and the means over surfaces of what is said of their points."""
    forms = closed_forms
    assert forms.parallel_rectangles(1.0, 1.0) == pytest.approx(0.1998248957, abs=1e-10)
    assert forms.parallel_rectangles(2.0, 4.0) == pytest.approx(0.5089886690, abs=1e-10)
    assert forms.coaxial_disks(1.0, 1.0, 1.0) == pytest.approx(0.3819660113, abs=1e-10)
    assert forms.coaxial_disks(1.0, 0.5, 1.0) == pytest.approx(0.1172177815, abs=1e-10)
    assert forms.coaxial_disks(1.0, 1.0, 2.0) == pytest.approx(0.1715728753, abs=1e-10)
    assert forms.element_to_parallel_disk(np.array([0.0, 0.5]), 1.0, 1.0) == pytest.approx([0.5, 0.4379826327])
    assert forms.element_to_corner(1.0, 1.0, 1.0) == pytest.approx(0.1385316060, abs=1e-10)
    above = np.array([[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], dtype=float)
    upright = forms.element_to_polygon(np.zeros((1, 3)), np.array([[1.0, 0, 0]]), above)
    assert upright == pytest.approx(0.0557341970, abs=1e-10)

    at, weight = np.polynomial.legendre.leggauss(40)
    at, weight = 0.5 + 0.5 * at, 0.5 * weight
    x, y = (a.ravel() for a in np.meshgrid(at, at, indexing="ij"))
    mean = np.outer(weight, weight).ravel()
    points, up = np.stack([x, y, 0 * x], axis=1), np.tile([0.0, 0, 1], (len(x), 1))
    # The same three ways: by corners, by the polygon, and the mean of either by the table.
    by_corners = forms.element_to_parallel_rectangle(x, y, (0, 0), (1, 1), 1.0)
    np.testing.assert_allclose(forms.element_to_polygon(points, up, above), by_corners, rtol=1e-12)
    assert mean @ by_corners == pytest.approx(0.1998248957, abs=1e-10)
    wall = np.array([[0, 0, 0], [0, 1, 0], [0, 1, 1], [0, 0, 1]], dtype=float)
    assert mean @ forms.element_to_polygon(points, up, wall) == pytest.approx(0.2000437761, abs=1e-6)
    of_disk = forms.element_to_parallel_disk(np.sqrt(at), 1.0, 1.0)  # r^2 is even over a disk
    assert weight @ of_disk == pytest.approx(0.3819660113, abs=1e-10)


def test_crossed_strings():
    """Cells of a cross-section against each other, the canyon's figures, and what an opening leaves."""
    square = [((0, 1), (0, 0), 4, 0), ((0, 0), (1, 0), 4, 0), ((1, 0), (1, 1), 4, 0), ((1, 1), (0, 1), 4, 0)]
    cells = closed_forms.Cells(square)
    points, up = np.array([[0.5, 0.0], [0.1, 0.0]]), np.array([[0.0, 1.0]] * 2)
    factors = cells.factors(points, up, 0)
    np.testing.assert_allclose(factors.sum(axis=1), 1.0, rtol=1e-12)
    np.testing.assert_array_equal(factors[:, cells.wall == 1], 0.0)
    assert factors[0, cells.wall == 3].sum() == pytest.approx(0.447214, abs=1e-6)
    np.testing.assert_allclose(cells.radiosity(np.full(16, 0.5), np.ones(16)), 2.0, rtol=1e-12)

    def between(a, b):
        return np.hypot(*(np.array(a) - np.array(b)))

    # Through an opening from .4 to .6 at x = 1, the strings from the wall x = 0 to the wall x = 2 go around its rims.
    rooms = [((0, 1), (0, 0), 400, 0), ((2, 0), (2, 1), 400, 1)]
    cells = closed_forms.Cells(rooms, ((1, 0.4), (1, 0.6)))
    left = cells.wall == 0
    middle = 0.5 * (cells.begin + cells.end)
    found = cells.factors(middle[left], cells.normals[left], 0)[:, ~left].sum(axis=1).mean()
    crossed = 2 * between((0, 0), (2, 1))  # straight through the middle of the opening
    uncrossed = 2 * (between((0, 0), (1, 0.4)) + between((1, 0.4), (2, 0)))
    assert found == pytest.approx((crossed - uncrossed) / 2, abs=1e-5)
