"""Where the light of a surfel comes from, and what a picked surfel shows of it."""

import numpy as np
import pytest
from test_view import RED, SQUARE, at, grid, is_color, lit, pair, window

import surflux as sf
from interactor import click_pixel, shot
from surflux.drawing import plots, sharing
from surflux.viewing import controls, words
from surflux.viewing.links import LinkFinder
from surflux.viewing.subject import Subject

__all__ = ["lit", "window"]  # fixtures


@pytest.fixture(scope="module")
def box():
    """A closed box of patches with one bright wall: object 0 shines, object 1 is the rest."""
    corners = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)
    shining = sf.Surfels.from_mesh((corners, [[4, 6, 7, 5]]), patch_area=0.01, reflectance=0.0, emission=1.0)
    faces = [[0, 1, 3, 2], [0, 4, 5, 1], [1, 5, 7, 3], [3, 7, 6, 2], [2, 6, 4, 0]]
    rest = sf.Surfels.from_mesh((corners, faces), patch_area=0.01, reflectance=0.5)
    return sf.solve(sf.Scene([shining, rest]), insert=False)


def nearest(solution, place):
    return int(np.argmin(np.linalg.norm(solution.surfels.points - place, axis=1)))


def test_links_add_up_to_the_light_of_other_surfels(box):
    find = LinkFinder(Subject(box))
    for place in ([0.5, 0.5, 0.0], [0.05, 0.5, 0.0], [0.0, 0.5, 0.5], [0.95, 0.95, 0.0]):
        i = nearest(box, place)
        links = find(i)
        from_surfels = box.irradiance[i] - box.direct[i]
        assert links.by_object.sum(axis=0) == pytest.approx(from_surfels, rel=0.03)
        assert links.light.sum(axis=0) == pytest.approx(links.by_object.sum(axis=0))
        assert links.shares.sum() == pytest.approx(1.0, abs=0.03)
        assert (np.diff(links.shares) <= 0).all()
        assert (links.escaped, links.into_backs) == (0.0, 0.0)


def test_shares_of_single_surfels_are_form_factors_times_radiosity(box):
    i = nearest(box, [0.45, 0.45, 0.0])
    factors = sf.form_factors(box._scene)[i]
    links = LinkFinder(Subject(box))(i, rays=200_000)
    wanted = factors[links.senders] * box.radiosity[links.senders, 0]
    assert len(links.senders) > 400  # surfels, for there are not more than 1000
    assert links.light[:100, 0] == pytest.approx(wanted[:100], rel=0.1)
    assert links.light[:100, 0].sum() == pytest.approx(wanted[:100].sum(), rel=0.01)
    assert links.ends[:50] == pytest.approx(box.surfels.points[links.senders[:50]], abs=0.02)


def test_links_from_a_file_and_with_groups(tmp_path):
    floor = sf.Surfels.from_mesh(SQUARE, patch_area=0.002, reflectance=0.5)
    wall = sf.Surfels.from_mesh(([[1, -1, 0], [1, 1, 0], [1, 1, 1], [1, -1, 1]], [[3, 2, 1, 0]]), 0.002, RED)
    solution = sf.solve(sf.Scene([floor, wall], [sf.PointLight([0, 0, 1.5], 10)]))
    solution.save(tmp_path / "a.ply")
    i = nearest(solution, [0.7, 0.1, 0.0])
    here, there = (LinkFinder(Subject(s))(i) for s in (solution, sf.load_solution(tmp_path / "a.ply")))
    assert np.array_equal(here.senders, there.senders)
    assert here.by_object[1] == pytest.approx((solution.irradiance - solution.direct)[i], rel=0.05)
    assert len(here.senders) < 300  # groups: the wall alone has 1000 surfels
    assert here.by_object[0] == pytest.approx(0)
    assert here.escaped > 0.3
    with pytest.raises(ValueError, match=r"^thing: wanted a Solution, for without light there are no links$"):
        LinkFinder(Subject(floor))(0)
    with pytest.raises(ValueError, match=r"^index: wanted a whole number from 0 to"):
        LinkFinder(Subject(solution))(10**6)


def test_links_are_the_same_every_time(box):
    one, two = (LinkFinder(Subject(box))(7) for _ in range(2))
    assert np.array_equal(one.light, two.light)
    assert np.array_equal(one.ends, two.ends)


def test_a_picked_surfel_its_neighbours_and_its_links_are_drawn(window, lit):
    view = window(lit, color="normal")
    before = shot(view)
    i = int(np.argmin(np.linalg.norm(lit.surfels.points - [-0.2, 0.05, 0], axis=1)))
    x, y, _ = lit.surfels.points[i]
    view.pick_at(round(299.5 + 150 * x), 599 - round(299.5 - 150 * y))
    assert view.picked == i
    image = shot(view)
    assert at(image, x - 0.03, y - 0.03) == list(sharing.PICKED)
    # From above the wall stands on edge: links go there, to the right, and nowhere else.
    changed = (np.abs(image - before).max(axis=2) > 30)[120:480, 0:460]
    columns = np.argwhere(changed)[:, 1]
    assert (columns > 299.5 + 150 * (x + 0.2)).sum() > 200
    strongest = view.links.ends[0]
    assert strongest[0] == pytest.approx(1.0)
    middle = (lit.surfels.points[i] + strongest) / 2
    scale = 4 / (4 - middle[2])  # perspective
    assert np.abs(np.array(at(image, *(scale * middle[:2]))) - at(before, *(scale * middle[:2]))).max() > 60
    view.pick(None)
    assert np.abs(shot(view) - before).max() <= 1


def test_neighbours_have_rims(window):
    s = grid(5, 0.4)
    view = window(s, color="normal")
    view.pick(12)
    image = shot(view)
    picked = sharing.pick(s, 12, "curved")
    assert at(image, 0, 0) == list(sharing.PICKED)
    for member, color in zip(picked.members[1:], picked.colors[1:], strict=True):
        x, y, _ = s.points[member]
        box = image[round(299.5 - 150 * (y + 0.5)) : round(299.5 - 150 * (y - 0.5))]
        box = box[:, max(0, round(299.5 + 150 * (x - 0.5))) : round(299.5 + 150 * (x + 0.5))]
        assert is_color(box, color, 12).sum() > 10
    assert at(shot(window(pair())), -1, 0) != list(sharing.PICKED)


def test_the_words(lit):
    i = int(np.argmin(np.linalg.norm(lit.surfels.points - [0.7, 0.05, 0], axis=1)))
    subject = Subject(lit, {"mistake": np.arange(len(lit.surfels)) / 4})
    links = LinkFinder(subject)(i)
    lines = words.values_of(subject, sharing.pick(lit.surfels, i, "curved"), links)
    said = {line.split()[0]: line.split()[1:] for line in lines if line.split()}
    assert lines[0] == f"surfel {i} of object 0"
    for name in ("direct", "irradiance", "radiosity"):
        assert [float(v) for v in said[name][:3]] == pytest.approx(getattr(lit, name)[i], rel=1e-3)
    assert [float(v) for v in said["position"]] == pytest.approx(lit.surfels.points[i], abs=1e-3 * lit.surfels.radii[i])
    assert said["mistake"] == [f"{i / 4:.4g}"]
    assert said["cut"][1].rstrip(",") == str(lit.cut[i])
    percent = [float(line.split()[-1].rstrip("%")) for line in lines if line.startswith("  ")]
    assert sum(percent) == pytest.approx(100, abs=3)
    assert any(line.startswith("  object 1") for line in lines)
    dark = sf.solve(sf.Scene([sf.Surfels.from_mesh(SQUARE), pair()], [sf.PointLight([0, 0, -1], 1)]))
    subject = Subject(dark)
    assert "no light comes here" in words.values_of(
        subject, sharing.pick(dark.surfels, 0, "curved"), LinkFinder(subject)(0)
    )


@pytest.mark.parametrize("radius", [0.02, 3e-5, 400.0])
def test_positions_are_told_to_a_thousandth_of_the_radius(radius):
    """Northings of a survey had six digits: they were rounded to 10 m."""
    place = np.array([512345.67812, 5412345.67834, 312.51256])
    s = sf.Surfels([place, place + radius], [[0, 0, 1]] * 2, radii=radius)
    lines = words.values_of(Subject(s), sharing.pick(s, 0, "curved"), None)
    (said,) = (line.split()[1:] for line in lines if line.startswith("position"))
    np.testing.assert_allclose([float(v) for v in said], place, rtol=0, atol=1e-3 * radius)
    assert max(len(v) for v in said) <= 16


def test_a_click_picks_and_a_drag_turns(window, lit):
    view = window(lit)
    with plots.quiet_vtk():
        controls.listen(view)
    shot(view)  # until it is drawn it takes no events
    before = view.camera().eye
    click_pixel(view, 300, 310)
    assert np.linalg.norm(lit.surfels.points[view.picked, :2] - [0.0, 0.07]) < 0.15
    assert view.camera().eye == pytest.approx(before)
    picked = view.picked
    click_pixel(view, 300, 310, drag=80)
    assert view.picked == picked
    assert np.linalg.norm(view.camera().eye - before) > 0.3
    click_pixel(view, 5, 300)  # beside everything
    assert view.picked is None
