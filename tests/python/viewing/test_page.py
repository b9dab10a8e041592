"""Pages, as Chromium shows them: what stands where, in which colour, and what mouse and keys do."""

import numpy as np
import pytest

import surflux as sf
from surflux.drawing.colors import member_colors
from surflux.viewing.page_data import folded, packed_light

SIZE = (480, 360)
# Looking down from 4: 90 pixels make one unit at z = 0.
ABOVE = sf.Camera([0, 0, 4], [0, 0, 0], up=(0, 1, 0), fov=2 * np.degrees(np.arctan(0.5)))
RED, GREEN, BLUE = [0.8, 0.0, 0.0], [0.0, 0.8, 0.0], [0.0, 0.0, 0.8]
SQUARE = ([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [[0, 1, 2, 3]])


def at(image, x, y):
    """The pixel where the point (x, y, 0) is seen."""
    return image[round(179.5 - 90 * y), round(239.5 + 90 * x)]


def shown(browser, tmp_path, thing, hash="#panel=0", **options):
    browser.open(sf.Page(thing, **({"camera": ABOVE} | options)).save(tmp_path / "a.html"), hash)
    return browser.picture()


def pair(**options):
    return sf.Surfels([[-1, 0, 0], [1, 0, 0]], [[0, 0, 1]] * 2, radii=[0.5, 0.8], **options)


def is_red(image):
    return image[..., 0] > image[..., 1:].max(axis=-1) + 60


@pytest.mark.slow
@pytest.mark.parametrize("style", ["disks", "splats"])
def test_disks_have_their_place_size_and_colour(browser, tmp_path, style):
    image = shown(browser, tmp_path, pair(reflectance=[RED, GREEN]), f"#panel=0&style={style}")
    assert image.shape == (360, 480, 3)
    red, green = is_red(image), is_red(image[..., [1, 0, 2]])
    assert red.sum() / 8100 == pytest.approx(np.pi * 0.25, rel=0.03)
    assert green.sum() / 8100 == pytest.approx(np.pi * 0.64, rel=0.03)
    assert np.argwhere(red).mean(axis=0) == pytest.approx([179.5, 149.5], abs=0.7)
    assert at(image, -1, 0).tolist() == pytest.approx([231, 0, 0], abs=1)  # 0.8 by the sRGB curve is 0.906
    assert at(image, 0, 1.5).tolist() == [255, 255, 255]


@pytest.mark.slow
def test_from_behind_nothing_is_drawn(browser, tmp_path):
    both = pair(reflectance=RED), sf.Surfels.from_mesh(SQUARE, reflectance=RED)
    for thing in both:
        below = sf.Camera([0, 0, -4], [0, 0, 0], up=(0, 1, 0))
        assert (shown(browser, tmp_path, thing, camera=below) == 255).all()
        assert is_red(shown(browser, tmp_path, thing)).sum() > 5000


@pytest.mark.slow
def test_patches_are_polygons(browser, tmp_path):
    for style in ("disks", "splats"):
        image = shown(browser, tmp_path, sf.Surfels.from_mesh(SQUARE, reflectance=RED), f"#panel=0&style={style}")
        assert is_red(image).sum() == pytest.approx(180 * 180, rel=0.02)
        assert at(image, 0.95, 0.95).tolist() == pytest.approx([231, 0, 0], abs=1)
        assert at(image, 1.15, 0).tolist() == [255, 255, 255]


@pytest.mark.slow
def test_of_disks_that_overlap_each_is_seen_where_it_is_nearest(browser, tmp_path):
    s = sf.Surfels([[-0.2, 0, 0], [0.2, 0, 0]], [[0, 0, 1]] * 2, radii=1.0, reflectance=[RED, BLUE])
    image = shown(browser, tmp_path, s, "#panel=0&style=disks")
    assert is_red(image[179, 170:236]).all()
    assert is_red(image[179, 244:310][:, [2, 1, 0]]).all()


@pytest.mark.slow
def test_splats_run_into_each_other_but_not_around_edges(browser, tmp_path):
    x = np.linspace(-1, 1, 11)
    floor = [[a, b, 0] for b in x for a in x]
    colors = [RED if a < 0 else BLUE for b in x for a in x]
    s = sf.Surfels(floor, [[0, 0, 1]] * 121, radii=0.2, reflectance=colors)
    middle = at(shown(browser, tmp_path, s), -0.1, 0)  # half way between the last red and the first blue
    assert middle[0] == pytest.approx(middle[2], abs=25)
    assert middle[0] > 120
    wall = sf.Surfels.from_mesh(([[1, -1, 0], [1, 1, 0], [1, 1, 1], [1, -1, 1]], [[3, 2, 1, 0]]), 0.01, GREEN)
    corner = sf.Scene([sf.Surfels.from_mesh(SQUARE, 0.01, RED), wall])
    image = shown(browser, tmp_path, corner)
    row = image[179, round(239.5 - 90 * 0.9) : round(239.5 + 90 * 0.97)]
    assert row[:, 1].max() < 10  # no green on the floor


@pytest.mark.slow
@pytest.mark.parametrize("disks", [False, True])
def test_splats_of_a_sheet_close_behind_do_not_shine_through(browser, tmp_path, disks):
    """A red board at a distance of .4 radii before a blue wall: it was (180, 0, 147)."""
    board = sf.Surfels.from_mesh((np.add(SQUARE[0], [0, 0, 0.03]), SQUARE[1]), 0.02, RED)
    wall = sf.Surfels.from_mesh(SQUARE, 0.02, BLUE)
    if disks:
        x = np.linspace(-1, 1, 21)
        rows = [[a, b, 0] for b in x for a in x]
        wall, board = (
            sf.Surfels(np.add(rows, [0, 0, z]), [[0, 0, 1]] * 441, radii=0.075, reflectance=color)
            for z, color in ((0.0, BLUE), (0.06, RED))
        )
    image = shown(browser, tmp_path, sf.Scene([wall, board]))[100:260, 160:320]
    assert image[..., 2].mean() < 25
    assert image[..., 0].mean() > 225


@pytest.mark.slow
def test_splats_run_into_each_other_on_a_ball(browser, tmp_path):
    """Neighbours stand a quarter of a radius below each other's planes there."""
    turn = np.arange(100) * np.pi * (3 - 5**0.5)  # places by the golden angle
    z = 1 - (2 * np.arange(100) + 1) / 100
    n = np.column_stack([np.sqrt(1 - z**2) * np.cos(turn), np.sqrt(1 - z**2) * np.sin(turn), z])
    ball = sf.Surfels(n, n, radii=0.26, reflectance=np.random.default_rng(0).uniform(0.2, 0.8, 100))
    hard, soft = (
        shown(browser, tmp_path, ball, f"#panel=0&style={style}")[130:230, 190:290, 0] for style in ("disks", "splats")
    )
    steps = [np.percentile(np.abs(np.diff(image, axis=0)), 99.5) for image in (hard, soft)]
    assert steps[0] > 50
    assert steps[1] < 0.25 * steps[0]


def lit():
    floor = sf.Surfels.from_mesh(SQUARE, patch_area=0.1, reflectance=0.5)
    return sf.solve(sf.Scene([floor], [sf.DirectionalLight([0, 0, -1], [4.0, 2.0, 1.0])], camera=ABOVE))


@pytest.mark.slow
def test_light_is_exposed(browser, tmp_path):
    solution = lit()
    image = shown(browser, tmp_path, solution, camera=None)
    linear = np.array([1.0, 0.5, 0.25])  # of B = 2, 1, .5
    srgb = 255 * (1.055 * linear ** (1 / 2.4) - 0.055)
    assert at(image, 0, 0).tolist() == pytest.approx(srgb, abs=2)
    browser.settled(lambda: browser.run("location.hash = '#panel=0&exposure=-2'"))
    darker = 255 * (1.055 * (linear / 4) ** (1 / 2.4) - 0.055)
    assert at(browser.picture(), 0, 0).tolist() == pytest.approx(darker, abs=2)
    browser.settled(lambda: browser.run("location.hash = '#panel=0&color=indirect'"))
    assert at(browser.picture(), 0, 0).tolist() == [0, 0, 0]
    assert browser.run("document.getElementById('note').textContent").startswith("irradiance from surfels H - D")
    browser.settled(lambda: browser.run("location.hash = '#panel=0&color=normal'"))
    assert at(browser.picture(), 0, 0).tolist() == pytest.approx([128, 128, 255], abs=1)


@pytest.mark.slow
def test_groups_have_their_colours(browser, tmp_path):
    x = np.linspace(-1, 1, 21)
    s = sf.Surfels([[a, b, 0] for b in x for a in x], [[0, 0, 1]] * 441, radii=0.1)
    image = shown(browser, tmp_path, s, "#panel=0&style=disks", colors=["group"])
    groups = sf.build_hierarchy(s).levels[0]
    colors = member_colors(groups)
    assert len(np.unique(groups)) > 10
    for i in range(0, 441, 17):
        assert at(image, *s.points[i, :2]).tolist() == pytest.approx(colors[i], abs=1)


@pytest.mark.slow
def test_a_lamp_is_seen_from_its_front(browser, tmp_path):
    floor = sf.Surfels.from_mesh(SQUARE, patch_area=0.1)
    lamp = sf.AreaLight([-0.25, -0.25, 0.5], [0, 0.5, 0], [0.5, 0, 0], 10.0)  # shines down
    solution = sf.solve(sf.Scene([floor], [lamp]))
    assert at(shown(browser, tmp_path, solution, "#panel=0&exposure=-3", camera=ABOVE), 0, 0).max() < 200
    up = sf.Camera([0, 0, -4], [0, 0, 0], up=(0, 1, 0), fov=ABOVE.fov)
    image = shown(browser, tmp_path, solution, "#panel=0&color=indirect", camera=up)  # of its own light there is none
    assert (image.max(axis=2) < 5).sum() == pytest.approx((0.5 / 4.5 * 360) ** 2, rel=0.05)


@pytest.mark.slow
def test_a_drag_turns_it(browser, tmp_path):
    colors = [RED, GREEN]
    both = sf.Surfels([[0, 0, 0.01], [0, 0, -0.01]], [[0, 0, 1], [0, 0, -1]], radii=0.8, reflectance=colors)
    side = sf.Camera([0, -3, 1.5], [0, 0, 0])
    before = shown(browser, tmp_path, both, camera=side)
    assert is_red(before).sum() > 3000
    browser.settled(lambda: browser.drag((240, 250), (240, 90)))  # 160 / 360 * 5 rad: from below now
    after = browser.picture()
    assert is_red(after).sum() == 0
    assert is_red(after[..., [1, 0, 2]]).sum() > 3000
    browser.settled(lambda: browser.key("0"))
    assert np.abs(browser.picture() - before).max() <= 1
    browser.settled(lambda: browser.drag((240, 180), (330, 180), modifiers=8))  # with shift it moves
    moved = np.argwhere(is_red(browser.picture())).mean(axis=0) - np.argwhere(is_red(before)).mean(axis=0)
    assert moved == pytest.approx([0, 90], abs=8)


@pytest.mark.slow
def test_the_wheel_comes_closer(browser, tmp_path):
    before = is_red(shown(browser, tmp_path, pair(reflectance=RED))).sum()
    browser.settled(lambda: browser.mouse("mouseWheel", 240, 180, deltaX=0, deltaY=300))
    assert is_red(browser.picture()).sum() == pytest.approx(before / 4, rel=0.05)


@pytest.mark.slow
def test_where_drawing_takes_long_all_is_there_in_the_end(browser, tmp_path):
    x = np.linspace(-1, 1, 41)
    points = [[a, b, 0] for b in x for a in x]
    s = sf.Surfels(
        points, [[0, 0, 1]] * len(points), radii=0.05, reflectance=[RED if a < 0 else BLUE for b in x for a in x]
    )
    before = shown(browser, tmp_path, s)
    # Its clock says that every picture takes a second.
    browser.run("{ let k = 0; performance.now = () => (k += 1000) }")
    for end in (300, 180, 240):
        browser.settled(lambda end=end: browser.drag((240, 180), (end, 180)))
    after = browser.picture()
    assert (np.abs(after - before).max(axis=2) > 60).mean() < 0.02  # edges are not smoothed then
    assert len(np.unique(after[180, 220:260], axis=0)) > 4  # splats again
    browser.mouse("mousePressed", 240, 180, button="left", buttons=1, clickCount=1)
    browser.mouse("mouseMoved", 241, 180, button="left", buttons=1)
    moving = browser.picture()
    browser.mouse("mouseReleased", 241, 180, button="left", buttons=0, clickCount=1)
    inside = moving[100:260, 160:320]
    assert (inside.min(axis=2) > 200).mean() < 0.05  # fewer disks, but larger: few gaps
    browser.wait("document.body.dataset.still")


@pytest.mark.slow
def test_a_click_tells_the_values_of_a_surfel(browser, tmp_path):
    shown(browser, tmp_path, lit(), camera=ABOVE)
    browser.settled(lambda: browser.click(240, 180))
    words = browser.run("document.getElementById('values').textContent").split("\n")
    assert words[0].startswith("surfel ")
    values = {line.split()[0]: line.split()[1:] for line in words}
    assert [float(v) for v in values["radiosity"]] == pytest.approx([2.0, 1.0, 0.5], rel=4e-3)
    assert [float(v) for v in values["direct"]] == pytest.approx([4.0, 2.0, 1.0], rel=4e-3)
    image = browser.picture()
    marked = (np.abs(image - [230, 0, 89]) <= 3).all(axis=-1)
    assert 100 < marked.sum() < 1500
    browser.settled(lambda: browser.click(20, 180))  # where nothing is
    assert not (np.abs(browser.picture() - [230, 0, 89]) <= 3).all(axis=-1).any()


@pytest.mark.slow
def test_keys_change_what_is_seen(browser, tmp_path):
    shown(browser, tmp_path, lit(), camera=ABOVE)
    browser.settled(lambda: browser.key("c"))
    assert browser.run("document.getElementById('color').value") == "direct"
    browser.settled(lambda: browser.key("s"))
    assert browser.run("document.getElementById('style').value") == "disks"
    browser.settled(lambda: browser.key("+"))
    assert browser.run("document.getElementById('exposure').value") == "0.5"
    browser.key("h")
    assert "drag: turn" in browser.run("document.getElementById('keys').innerText")
    assert (browser.picture()[20:60, 360:470] < 100).any()  # the words


@pytest.mark.slow
def test_survey_coordinates_look_like_any_other(browser, tmp_path):
    far = np.array([5.1e6, 4.3e5, 800.0])
    s = pair(reflectance=RED)
    moved = sf.Surfels(s.points + far, s.normals, radii=s.radii, reflectance=RED)
    here = shown(browser, tmp_path, s)
    there = shown(browser, tmp_path, moved, camera=sf.Camera(ABOVE.eye + far, far, ABOVE.up, ABOVE.fov))
    assert (np.abs(here - there).max(axis=2) > 8).mean() < 0.001


def test_it_asks_the_network_for_nothing(browser, tmp_path):
    browser.events.clear()
    shown(browser, tmp_path, lit(), camera=ABOVE)
    assert browser.requests() == [(tmp_path / "a.html").as_uri()]
    text = (tmp_path / "a.html").read_text()
    assert "http://" not in text
    assert "https://" not in text


def test_normals_fold_and_light_packs_to_what_they_were():
    n = np.random.default_rng(0).normal(size=(1000, 3))
    n = np.concatenate([n / np.linalg.norm(n, axis=1, keepdims=True), np.eye(3), -np.eye(3)])
    xy = folded(n) / 32767
    z = 1 - np.abs(xy).sum(axis=1)
    back = np.column_stack([xy, z])
    under = z < 0
    back[under, :2] = ((1 - np.abs(xy[:, ::-1])) * np.where(xy < 0, -1, 1))[under]
    assert back / np.linalg.norm(back, axis=1, keepdims=True) == pytest.approx(n, abs=1e-4)

    rgb = np.random.default_rng(1).uniform(0, 1, (1000, 3)) * 10.0 ** np.random.default_rng(2).uniform(-3, 4, (1000, 1))
    rgb = np.concatenate([rgb, np.zeros((1, 3)), np.ones((1, 3)), np.full((1, 3), 0.9999), np.full((1, 3), 1e9)])
    packed = packed_light(rgb)
    step = 2.0 ** ((packed >> 27).astype(float) - 24)
    back = np.column_stack([(packed >> shift & 511) * step for shift in (0, 9, 18)])
    clipped = np.minimum(rgb, 65408)
    assert (np.abs(back - clipped).max(axis=1) <= clipped.max(axis=1) / 512 + 1e-7).all()


WRONG = [
    ({"colors": ["light"]}, r"^colors: wanted one of 'reflectance', 'normal', 'radius', .*got 'light'$"),
    ({"colors": "normal"}, r"^colors: wanted a list of names, got 'normal'$"),
    ({"colors": []}, r"^colors: wanted a list of names, got \[\]$"),
    ({"camera": 3}, r"^camera: wanted a Camera or None, got 3$"),
    ({"title": 3}, r"^title: wanted text, got int$"),
    ({"values": {"x": [1.0]}}, r"^x: wanted shape \(2,\) or \(2, 3\) for 2 surfels, got \(1,\)$"),
    ({"values": {"x": [[1.0] * 2] * 2}}, r"^x: wanted shape \(2, 3\), got \(2, 2\)$"),
    ({"values": {"x": [[np.nan] * 3] * 2}}, r"^x: wanted finite numbers, got nan at index \(0, 0\) \(6 in all\)$"),
    ({"values": 3}, r"^values: wanted a dict of arrays, got int$"),
]


@pytest.mark.parametrize(("options", "message"), WRONG, ids=str)
def test_wrong_arguments(options, message):
    with pytest.raises(ValueError, match=message):
        sf.Page(pair(), **options)
    with pytest.raises(ValueError, match=r"^thing: wanted Surfels, a Scene or a Solution, got int$"):
        sf.Page(3)


def test_numbers_that_are_unknown_have_no_colour():
    about, data = sf.Page(pair(), colors=["x"], values={"x": [np.nan, np.inf]})._data()
    _, first, count = about["colors"][0]["data"]
    assert (np.frombuffer(data, np.uint32, count, first) == 0xFFD3D3D3).all()


def test_arrays_of_others_have_no_unit_and_lamps_no_part_in_them():
    floor = sf.Surfels.from_mesh(SQUARE, patch_area=0.1)
    lamp = sf.AreaLight([-0.25, -0.25, 0.5], [0, 0.5, 0], [0.5, 0, 0], 10.0)
    solution = sf.solve(sf.Scene([floor], [lamp]), insert=False)
    given = {"kWh": np.full((len(floor), 3), 950.0)}
    about, data = sf.Page(solution, colors=["irradiance", "kWh"], values=given)._data()
    own, others = about["colors"]
    assert (own["label"], own["unit"]) == ("irradiance H", "W/m2")
    assert (others["label"], others["unit"], others["white"]) == ("kWh", "", 950.0)
    seen = [np.frombuffer(data, np.uint32, count, first)[-1] for _, first, count in (own["data"], others["data"])]
    assert seen == [packed_light(np.full((1, 3), light))[0] for light in (10.0 / own["white"], 1.0)]


def test_a_name_that_is_no_text_can_be_its_title(tmp_path):
    path = sf.Page(pair(), title="\udcff</title><script>").save(tmp_path / "a.html")
    assert "<title>?&lt;/title&gt;&lt;script&gt;</title>" in path.read_text("utf-8")


def test_where_it_cannot_be_written(tmp_path):
    with pytest.raises(ValueError, match=r"^path: wanted a name ending in \.html, got .*a\.txt'$"):
        sf.Page(pair()).save(tmp_path / "a.txt")
    with pytest.raises(sf.FileError, match=r"none/a\.html: cannot be written: there is no folder .*none$"):
        sf.Page(pair()).save(tmp_path / "none" / "a.html")
    with pytest.raises(sf.FileError, match=r"cannot be written: File name too long$"):
        sf.Page(pair()).save(tmp_path / f"{'x' * 300}.html")
    # As long as a name may be: what is written beside it has a shorter one.
    assert sf.Page(pair()).save(tmp_path / f"{'x' * 250}.html").is_file()


def test_a_browser_that_cannot_show_it_is_told_why(browser, tmp_path):
    for source, reason in (
        ("HTMLCanvasElement.prototype.getContext = () => null", "This page needs WebGL 2, which this browser"),
        ("WebGL2RenderingContext.prototype.getExtension = () => null", "This page needs pictures of floats"),
    ):
        script = browser.ask("Page.addScriptToEvaluateOnNewDocument", source=source)["identifier"]
        try:
            browser.open(sf.Page(pair()).save(tmp_path / "a.html"))
            assert browser.run("document.getElementById('fault').innerText").startswith(reason)
            assert browser.run("getComputedStyle(document.getElementById('fault')).display") == "block"
        finally:
            browser.ask("Page.removeScriptToEvaluateOnNewDocument", identifier=script)
