"""What a view shows, judged by the pixels."""

import numpy as np
import pytest

import surflux as sf
from interactor import shot
from surflux.drawing import plots
from surflux.drawing.colors import member_colors
from surflux.viewing.properties import names_of
from surflux.viewing.subject import Subject
from surflux.viewing.window import INSERTED, SceneView
from surflux.viewing.words import caption

SIZE = (600, 600)
# Looking down from 4: 150 pixels make one unit at z = 0.
ABOVE = sf.Camera([0, 0, 4], [0, 0, 0], up=(0, 1, 0), fov=2 * np.degrees(np.arctan(0.5)))
RED, GREEN, BLUE = [0.8, 0.0, 0.0], [0.0, 0.8, 0.0], [0.0, 0.0, 0.8]
SQUARE = ([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [[0, 1, 2, 3]])
DARK, BRIGHT = [68, 1, 84], [253, 231, 37]  # the two ends of viridis
STYLES = ("disks", "splats", "points")


@pytest.fixture
def window():
    """A SceneView without a window, looked at from above."""
    views = []

    def make(thing, camera=ABOVE, values=None, **options):
        with plots.quiet_vtk():
            view = SceneView(Subject(thing, values), **({"size": SIZE, "off_screen": True} | options))
            views.append(view)
            view.frame(camera)
        return view

    yield make
    for view in views:
        view.plotter.close()


def at(image, x, y):
    """The pixel where the point (x, y, 0) is seen."""
    return image[round(299.5 - 150 * y), round(299.5 + 150 * x)].tolist()


def is_color(image, rgb, tolerance=3):
    return (np.abs(image - np.array(rgb)) <= tolerance).all(axis=-1)


def pair(**options):
    return sf.Surfels([[-1, 0, 0], [1, 0, 0]], [[0, 0, 1]] * 2, radii=[0.5, 0.8], **options)


def grid(n=21, spacing=0.1, **options):
    x = spacing * (np.arange(n) - (n - 1) / 2)
    points = [[a, b, 0] for b in x for a in x]
    return sf.Surfels(points, [[0, 0, 1]] * n**2, **({"radii": 1.1 * spacing} | options))


@pytest.fixture(scope="module")
def lit():
    """A floor below a red wall and a lamp that shines down; the wall lights the floor."""
    floor = sf.Surfels.from_mesh(SQUARE, patch_area=0.03, reflectance=0.5)
    corners = [[1, -1, 0], [1, 1, 0], [1, 1, 1], [1, -1, 1]]
    wall = sf.Surfels.from_mesh((corners, [[3, 2, 1, 0]]), patch_area=0.03, reflectance=RED)
    lamp = sf.AreaLight([-0.8, -0.2, 1.5], [0, 0.4, 0], [0.4, 0, 0], [30.0, 30.0, 30.0])
    scene = sf.Scene([floor, wall], [lamp], camera=ABOVE)
    return sf.solve(scene, insert=False)


def test_each_style_has_its_look(window):
    s = pair(reflectance=[RED, GREEN])
    area = {}
    for style in STYLES:
        image = shot(window(s, style=style, color="reflectance"))
        assert at(image, -1, 0) == pytest.approx([231, 0, 0], abs=1)
        assert at(image, 1, 0) == pytest.approx([0, 231, 0], abs=1)
        area[style] = is_color(image, [0, 231, 0]).sum() / 150**2
    # A cone of 16 corners, whose rim is .4 * .8 farther away than its tip.
    assert area["disks"] == pytest.approx(3.06 * 0.64 * (4 / 4.32) ** 2, rel=0.03)
    assert area["splats"] == pytest.approx(area["disks"], rel=0.01)
    assert area["points"] < 0.01


def test_of_disks_that_overlap_each_is_seen_where_it_is_nearest(window):
    s = sf.Surfels([[-0.2, 0, 0], [0.2, 0, 0]], [[0, 0, 1]] * 2, radii=1.0, reflectance=[RED, BLUE])
    image = shot(window(s))
    assert is_color(image[300, 180:294], [231, 0, 0]).all()
    assert is_color(image[300, 306:420], [0, 0, 231]).all()


def test_splats_run_into_each_other_but_not_around_edges(window):
    s = grid(reflectance=[RED if k % 21 < 10 else BLUE for k in range(441)])
    hard, soft = (shot(window(s, style=style))[300] for style in ("disks", "splats"))
    middle = round(299.5 - 150 * 0.05)
    assert len(np.unique(hard[middle - 20 : middle + 20], axis=0)) <= 3
    assert abs(soft[middle, 0] - soft[middle, 2]) < 40
    assert soft[middle - 5, 0] > soft[middle, 0] > soft[middle + 5, 0]
    floor = sf.Surfels.from_mesh(SQUARE, 0.01, RED)
    wall = sf.Surfels.from_mesh(([[1, -1, 0], [1, 1, 0], [1, 1, 1], [1, -1, 1]], [[3, 2, 1, 0]]), 0.01, GREEN)
    image = shot(window(sf.Scene([floor, wall]), style="splats"))
    assert image[300, 170:448, 1].max() < 5  # no green on the floor


def test_splats_of_a_sheet_close_behind_do_not_shine_through(window):
    """A red board before a blue wall, a third of a radius and more away: of patches it was (169, 0, 160)."""
    patches = [
        sf.Surfels.from_mesh(([[x, y, z] for x, y, _ in SQUARE[0]], SQUARE[1]), 0.02, color)
        for z, color in ((0, BLUE), (0.04, RED))
    ]
    floor = grid(radii=0.1, reflectance=BLUE)
    disks = [floor, sf.Surfels(np.add(floor.points, [0, 0, 0.05]), floor.normals, radii=0.1, reflectance=RED)]
    for thing in (patches, disks):
        image = shot(window(sf.Scene(thing), style="splats"))[200:400, 200:400]
        assert image[..., 2].mean() < 15
        assert image[..., 0].mean() > 225


def test_patches_are_polygons(window):
    for style in ("disks", "splats"):
        image = shot(window(sf.Surfels.from_mesh(SQUARE, reflectance=RED), style=style))
        assert is_color(image, [231, 0, 0]).sum() == pytest.approx(300 * 300, rel=0.02)


def test_numbers_have_a_bar(window):
    view = window(pair(areas=[1.0, 2.0]), color="area")
    image = shot(view)
    assert at(image, -1, 0) == pytest.approx(DARK, abs=3)
    assert at(image, 1, 0) == pytest.approx(BRIGHT, abs=3)
    bar = image[180:420, 540:590]
    assert is_color(bar, DARK, 8).any()
    assert is_color(bar, BRIGHT, 8).any()
    view.set_color("reflectance")
    assert not is_color(shot(view)[180:420, 540:590], DARK, 8).any()


@pytest.mark.slow
def test_a_scale_that_leaves_outliers_out_says_so(window):
    """A plane of 311 lux ended at 296 on the scale, and nothing was said."""
    many = grid(41, 0.04)
    for values, says in ((np.arange(41.0**2), True), (np.repeat([0.0, 1.0], [841, 840]), False)):
        view = window(many, values={"lux": values}, color="lux")
        (bar,) = view.plotter.scalar_bars.values()
        assert ("percentile" in bar.GetTitle()) == says


@pytest.mark.parametrize(("low", "high"), [(293.15, 293.45), (1100.0, 1180.0), (1.7e9, 1.7e9 + 3)])
def test_labels_of_a_scale_can_be_told_apart_and_are_in_the_window(window, low, high):
    """Kelvins all were 293."""
    view = window(grid(9, 0.1), values={"x": np.linspace(low, high, 81)}, color="x")
    bar = view.plotter.scalar_bars["colours"]
    labels = [bar.GetLabelFormat() % x for x in np.linspace(low, high, 5)]
    assert len(set(labels)) == 5
    assert [float(x) for x in labels] == pytest.approx(np.linspace(low, high, 5), abs=0.02 * (high - low))
    ink = (shot(view)[170:430, 470:] < 90).all(axis=-1).any(axis=0)  # of letters; the bar itself has colours
    assert ink[60:].any()
    assert not ink[-5:].any()


def test_every_colour_that_there_is_can_be_shown(window, lit):
    assert names_of(Subject(pair())) == ["reflectance", "normal", "radius", "area", "coverage", "group"]
    view = window(lit, values={"mistake": np.arange(len(lit.surfels))})
    names = names_of(view.subject)
    assert names == [
        *("radiosity", "irradiance", "direct", "indirect", "reflectance", "normal", "radius", "area", "coverage"),
        *("object", "group", "cut", "mistake"),
    ]
    seen = {}
    for name in names:
        assert view.color == name
        seen[name] = shot(view)[5:595, 5:595]
        view.next_color()
    assert view.color == "radiosity"
    view.next_color(-1)
    assert view.color == "mistake"
    different = {image.tobytes() for image in seen.values()}
    assert len(different) == len(names)


def test_arrays_of_others_have_no_unit(window, lit):
    view = window(lit, color="kWh", values={"kWh": np.full((len(lit.surfels), 3), 950.0)})
    assert caption(view, view.shown()).startswith("kWh; white is 950\n")
    view.set_color("irradiance")
    assert caption(view, view.shown()).splitlines()[0].endswith(" W/m2")


def test_objects_groups_and_the_cut_have_a_colour_each(window, lit):
    view = window(lit, color="object")
    colors = member_colors(np.arange(1000))
    assert at(shot(view), 0, 0) == pytest.approx(colors[0], abs=1)
    view.set_level(1)
    tree = view.subject.tree()
    i = int(np.argmin(np.linalg.norm(lit.surfels.points - [0.05, 0.05, 0], axis=1)))
    x, y, _ = lit.surfels.points[i]
    assert at(shot(view), x, y) == pytest.approx(colors[tree.levels[1][i]], abs=1)
    view.set_level(99)
    assert view.level == len(tree) - 1
    view.set_color("cut")
    assert at(shot(view), x, y) == pytest.approx(colors[lit.cut[i]], abs=1)
    assert lit.cut.max() + 1 == lit.history[-1]["cut"]


def test_direct_and_indirect_light_by_themselves(window, lit):
    view = window(lit)
    i = int(np.argmin(np.linalg.norm(lit.surfels.points - [0.8, 0.05, 0], axis=1)))
    x, y, _ = lit.surfels.points[i]
    white = view.white()
    for light, h in {"all": lit.irradiance, "direct": lit.direct, "indirect": lit.irradiance - lit.direct}.items():
        view.set_light(light)
        linear = np.clip(0.5 * h[i] / white, 0, 1)
        wanted = 255 * np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
        assert at(shot(view), x, y) == pytest.approx(wanted, abs=1.5), light
    pixel = at(shot(view), x, y)
    assert pixel[0] > 3 * pixel[1]  # what comes from the wall is red


def test_exposure_goes_by_stops(window, lit):
    view = window(lit, stops=-1.0)
    i = int(np.argmin(np.linalg.norm(lit.surfels.points - [-0.5, 0.05, 0], axis=1)))
    x, y, _ = lit.surfels.points[i]
    for stops in (-1.0, -3.0):
        view.set_exposure(stops)
        linear = np.clip(lit.radiosity[i] * 2**stops / view.white(), 0, 1)
        assert at(shot(view), x, y) == pytest.approx(255 * (1.055 * linear ** (1 / 2.4) - 0.055), abs=1.5)


@pytest.mark.slow
def test_inserted_surfels_are_marked(window):
    floor = sf.Surfels.from_mesh(SQUARE, patch_area=0.01, reflectance=0.5)
    blocker = sf.Surfels.from_mesh(
        ([[-0.3, -0.3, 0.5], [0.3, -0.3, 0.5], [0.3, 0.3, 0.5], [-0.3, 0.3, 0.5]], [[0, 3, 2, 1]]), patch_area=0.01
    )
    solution = sf.solve(sf.Scene([floor, blocker], [sf.PointLight([0, 0, 1.5], 10)]))
    view = window(solution)
    orange = INSERTED
    assert not is_color(shot(view), orange).any()
    view.mark_inserted(True)
    image = shot(view)
    inserted = view.subject.inserted()
    assert 50 < inserted.sum() < len(inserted)
    seen = solution.surfels.points[:, 2] < 0.1
    for i in np.flatnonzero(inserted & seen)[:50]:
        # The dot of a small one is less than a pixel wide, and may lie in the next.
        x, y = solution.surfels.points[i, :2]
        around = [at(image, x + dx / 150, y + dy / 150) for dx in (-1, 0, 1) for dy in (-1, 0, 1)]
        assert any(r > b + 40 for r, _, b in around)
    for i in np.flatnonzero(~inserted & seen)[:50]:
        r, _, b = at(image, *solution.surfels.points[i, :2])
        assert abs(r - b) < 5
    view.mark_inserted(False)
    assert not is_color(shot(view), orange).any()
    view.set_color("parent")
    colors, image = member_colors(solution.parents), shot(view)
    for i in np.flatnonzero(~inserted & seen)[:50]:
        assert at(image, *solution.surfels.points[i, :2]) == pytest.approx(colors[i], abs=1)


def test_backs_are_drawn_when_asked(window):
    below = sf.Camera([0, 0, -4], [0, 0, 0], up=(0, 1, 0))
    view = window(pair(reflectance=RED), camera=below)
    assert not is_color(shot(view), [231, 0, 0]).any()
    view.show_backs(True)
    assert is_color(shot(view), [231, 0, 0]).any()
    view.show_backs(False)
    assert not is_color(shot(view), [231, 0, 0]).any()


def test_a_lamp_is_drawn_white_from_its_front(window, lit):
    up = sf.Camera([-0.6, 0, -4], [-0.6, 0, 1.5], up=(0, 1, 0), fov=ABOVE.fov)
    view = window(lit, camera=up)
    view.plotter.set_background("black")
    side = 0.4 / (2 * 5.5 * 0.5) * 600
    assert is_color(shot(view)[100:500], [255, 255, 255]).sum() == pytest.approx(side**2, rel=0.1)


def test_a_camera_comes_back(window):
    far = np.array([5.1e6, 4.3e5, 800.0])
    camera = sf.Camera(far + np.array([1, 2, 3]), far + np.array([0.5, 0, 0]), (0, 1, 0), 37.0)
    s = sf.Surfels(pair().points + far, pair().normals, radii=0.5)
    back = window(s, camera=camera).camera()
    assert back.eye == pytest.approx(camera.eye, abs=1e-6)
    assert back.target == pytest.approx(camera.target, abs=1e-6)
    assert back.fov == pytest.approx(37.0)


def test_survey_coordinates_look_like_any_other(window):
    s, far = grid(reflectance=RED), np.array([5.1e6, 4.3e5, 800.0])
    moved = sf.Surfels(s.points + far, s.normals, radii=s.radii, reflectance=RED)
    here = shot(window(s))
    there = shot(window(moved, camera=sf.Camera(ABOVE.eye + far, far, ABOVE.up, ABOVE.fov)))
    assert (np.abs(here - there).max(axis=2) > 8).mean() < 0.002


@pytest.mark.slow
def test_another_zeta_is_a_new_solution(window):
    floor = sf.Surfels.from_mesh(SQUARE, patch_area=0.002, reflectance=0.5)
    ball = sf.Surfels.sample_mesh(([[0.5, 0, 0.3], [-0.5, 0, 0.3], [0, 0.5, 0.3]], [[0, 1, 2]]), 60)
    scene = sf.Scene([floor, ball], [sf.PointLight([0, 0, 2], 10)], solve_options={"transport": "rays"}, camera=ABOVE)
    view = window(sf.solve(scene, **scene.solve_options), color="cut")
    before, camera = view.subject.solution, view.camera()
    view.solve_again(0.5, progress=False)
    after = view.subject.solution
    assert after.history[-1]["cut"] < before.history[-1]["cut"]
    assert view.camera().eye == pytest.approx(camera.eye)
    assert view.camera().target == pytest.approx(camera.target)
    i = int(np.argmin(np.linalg.norm(after.surfels.points - [-0.7, -0.7, 0], axis=1)))
    assert at(shot(view), *after.surfels.points[i, :2]) == pytest.approx(member_colors(after.cut[i : i + 1])[0], abs=1)
    assert not window(sf.Scene([floor])).can_solve()


@pytest.mark.slow
@pytest.mark.parametrize("color", ["mine", "level", "parent"])
def test_another_zeta_keeps_arrays_of_others_and_shows_what_there_is(window, color):
    floor = sf.Surfels.from_mesh(SQUARE, 0.02, 0.5)
    wall = sf.Surfels.from_mesh(([[0, -1, 0], [0, 1, 0], [0, 1, 1], [0, -1, 1]], [[3, 2, 1, 0]]), 0.02, 0.5)
    scene = sf.Scene([floor, wall], [sf.AreaLight([-0.8, -0.2, 1.5], [0, 0.4, 0], [0.4, 0, 0], 30.0)], camera=ABOVE)
    fine = sf.solve(scene, transport="rays", zeta=0.02, threads=1)
    scene.solve_options = {"transport": "rays", "insert": False}
    mine, cubes = fine.surfels.points[:, 0] * 1.0, fine.surfels.points**3
    view = window(fine, color=color, values={"mine": mine, "cubes": cubes})
    assert view.subject.inserted().any()
    view.solve_again(0.5, progress=False)
    after = view.subject
    assert not after.inserted().any()
    assert view.color == ("mine" if color == "mine" else "radiosity")
    assert (f"that has no {color}: radiosity is shown" in caption(view, view.shown())) == (color != "mine")
    assert "surfels" in view.plotter.actors
    # The mean of x over its parts is a patch's own.
    np.testing.assert_allclose(after.values["mine"], after.surfels.points[:, 0], atol=1e-3)
    assert after.values["cubes"].shape == (len(after), 3)
    scene.solve_options = {"transport": "rays"}
    view.solve_again(0.02, progress=False)  # parts have what was given for them at first
    assert len(view.subject) == len(fine.surfels)
    np.testing.assert_array_equal(view.subject.values["mine"], mine)


WRONG = [
    ({"color": "light"}, r"^color: wanted one of 'reflectance', 'normal', 'radius', .*, got 'light'$"),
    ({"style": "cubes"}, r"^style: wanted one of 'disks', 'splats', 'points', got 'cubes'$"),
    ({"light": "red"}, r"^light: wanted one of 'all', 'direct', 'indirect', got 'red'$"),
    ({"stops": 99}, r"^stops: wanted values in \[-20, 20\], got 99$"),
    ({"level": -1}, r"^level: wanted a whole number from 0 to 2147483647, got -1$"),
    ({"inserted": 3}, r"^inserted: wanted True or False, got 3$"),
    ({"pick": 2}, r"^pick: wanted a whole number from 0 to 1, got 2$"),
    ({"size": 3}, r"^size: wanted \(width, height\), got 3$"),
    ({"camera": 3}, r"^camera: wanted a Camera or None, got 3$"),
    ({"values": {"a": [1]}}, r"^a: wanted shape \(2,\) or \(2, 3\) for 2 surfels, got \(1,\)$"),
    ({"screenshot": "a.gif"}, r"^screenshot: wanted a name ending in \.png or \.jpg, got 'a\.gif'$"),
]


@pytest.mark.parametrize(("options", "message"), WRONG, ids=str)
def test_wrong_arguments(options, message, tmp_path):
    with pytest.raises(ValueError, match=message):
        sf.view(pair(), **({"screenshot": tmp_path / "a.png"} | options))


def test_nothing_but_surfels_scenes_and_solutions():
    with pytest.raises(ValueError, match=r"^thing: wanted Surfels, a Scene or a Solution, got list$"):
        sf.view([])


def test_flying_to_a_surfel_that_faces_what_is_up(window):
    up = np.ones(3)
    view = window(sf.Surfels([[-1, 0, 0], [1, 0, 0]], [up, up], radii=0.5))
    view.frame(sf.Camera([4, 0, 0], [0, 0, 0], up=up))
    view.pick(0)
    view.fly_to_picked()
    camera = view.camera()
    np.testing.assert_allclose(camera.eye, camera.target + 12 * 0.5 * up / np.sqrt(3))
