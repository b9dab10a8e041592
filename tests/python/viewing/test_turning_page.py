"""Pages whose environment turns in the browser, against relightings: numbers, what Chromium draws, the slider."""

import numpy as np
import pytest

import surflux as sf
from quick import quick
from surflux._base.color import white_of
from surflux.geometry.rotation import rotation_about
from surflux.scenes import shapes
from surflux.solving.turning_light import TurningLight, waves_at
from surflux.viewing.page_data import packed_waves

UP = [0.2, -0.3, 0.9]
# Of a small lamp and a dim sky: its five bands are below 0 on the far side.
IMAGE = np.full((16, 32, 3), 0.1)
IMAGE[5, 6] = [300.0, 200.0, 100.0]
CAMERA = sf.Camera([0.5, -3.0, 1.6], [0.0, 0.0, -0.1], fov=40)


@pytest.fixture(scope="module")
def sky():
    return sf.Environment(IMAGE, up=UP)


@pytest.fixture(scope="module")
def transfer():
    """Of a ball of disks over a plate of patches that glows a little, one object each."""
    ball = shapes.sphere(1500, 0.5)
    square = ([[-1, -1, -0.6], [1, -1, -0.6], [1, 1, -0.6], [-1, 1, -0.6]], [[0, 1, 2, 3]])
    plate = sf.Surfels.from_mesh(square, patch_area=0.01, reflectance=[0.3, 0.5, 0.7], emission=[0.02, 0.01, 0.0])
    return sf.precompute_transfer(sf.Scene([ball, plate], camera=CAMERA), "distant")


@pytest.fixture
def page(transfer, sky, tmp_path):
    return sf.Page(transfer, environment=sky).save(tmp_path / "turning.html")


def relit(transfer, sky, degrees):
    return transfer.relight(sky, rotation=rotation_about(UP, np.radians(degrees)))


def go(browser, address):
    browser.settled(lambda: browser.run(f"location.hash = '{address}'"))


def element(browser, name, what):
    return browser.run(f"document.getElementById('{name}').{what}")


def place_of(browser, name):
    box = f"document.getElementById('{name}').getBoundingClientRect()"
    return [browser.run(f"{box}.{side}") for side in ("left", "top", "width", "height")]


def test_waves_are_packed_to_a_ten_thousandth_of_the_largest(transfer, sky):
    """Nine roundings by half a scale each: 1 + 4 sqrt(2) halves at most, of 1 / 32767 of the largest coefficient."""
    waves = TurningLight(transfer, sky).waves.irradiance
    whole, scales = packed_waves(waves)
    assert (whole.dtype, whole.shape, scales.shape) == (np.int16, (len(scales), 9, 3), (len(transfer.scene.surfels),))
    largest = np.abs(waves).max(axis=(0, 2))
    bound = (1 + 4 * np.sqrt(2)) / 2 / 32767
    assert bound < 1.02e-4
    worst = 0.0
    for degrees in range(0, 360, 7):
        at = waves_at(np.radians(degrees))
        found = np.einsum("w,nwc->nc", at, whole) * scales[:, None]
        worst = max(worst, (np.abs(found - np.tensordot(at, waves, 1)).max(axis=1) / largest).max())
    assert bound / 4 < worst < bound * 1.01
    whole, scales = packed_waves(np.zeros((9, 2, 3), np.float32))
    assert not whole.any()
    assert not scales.any()


@pytest.mark.slow
def test_the_browser_has_the_light_of_relight(browser, page, transfer, sky):
    """Waves to 1.02e-4 of the largest, reflectance to 1/65534, emission to 1/1024 of the brightest, in float32."""
    browser.open(page, "#panel=0")
    browser.run("globalThis.held = readScene(), globalThis.turning = makeTurning(held), 0")
    order = np.array(browser.run("Array.from(held.indices)"))
    largest = np.abs(TurningLight(transfer, sky).waves.irradiance).max(axis=(0, 2))[:, None]
    for degrees in (0.0, 111.5, 290.0):
        wanted = relit(transfer, sky, degrees)
        assert (wanted.direct == 0).any()
        values = {"radiosity": wanted.radiosity, "irradiance": wanted.irradiance, "direct": wanted.direct}
        values["indirect"] = np.maximum(wanted.irradiance - wanted.direct, 0.0)
        for name, value in values.items():
            browser.run(f"turning.fill('{name}', {degrees}, 2, globalThis.out = new Float32Array(3 * held.count))")
            found = 2.0 * np.reshape(browser.run("Array.from(out)"), (-1, 3))
            off = np.abs(found - value[order])
            room = 2.1e-4 * largest[order] + (0.02 / 1024 if name == "radiosity" else 0.0)
            assert (off <= room).all(), (name, degrees, (off / room).max())
        k = 17
        point = browser.run(f"turning.at('radiosity', {k}, {degrees})")
        np.testing.assert_allclose(point, wanted.radiosity[order[k]], atol=1e-3 * largest.max())


@pytest.mark.slow
@pytest.mark.parametrize("color", quick("radiosity", of=["radiosity", "direct", "indirect"]))
def test_it_is_drawn_as_a_page_of_the_turned_light_is(browser, page, transfer, sky, tmp_path, color):
    """To two levels of 255: that page keeps light by nine bits, this one by sixteen."""
    degrees = 137.0
    still = relit(transfer, sky, degrees)
    values = {"radiosity": still.radiosity, "direct": still.direct, "indirect": still.irradiance - still.direct}
    browser.open(sf.Page(still).save(tmp_path / "still.html"), f"#panel=0&color={color}")
    wanted = browser.picture()
    assert (wanted < 250).any(axis=2).mean() > 0.2
    browser.open(page, f"#panel=0&color={color}")
    before = browser.picture()
    # Its white is that of a whole turn.
    white = browser.run(f"readScene().colors.find((color) => color.name === '{color}').white")
    stops = np.log2(white / white_of(values[color]))
    go(browser, f"#panel=0&color={color}&turn={degrees}&exposure={stops}")
    found = browser.picture()
    assert np.abs(found - wanted).max() <= 2
    assert (np.abs(found - before).max(axis=2) > 20).mean() > 0.02


@pytest.mark.slow
def test_a_full_turn_is_the_same_picture(browser, page):
    browser.open(page, "#panel=0")
    first = browser.picture()
    go(browser, "#panel=0&turn=90")
    quarter = browser.picture()
    assert (np.abs(quarter - first).max(axis=2) > 8).mean() > 0.05
    for turn, wanted in ((360, first), (-270, quarter), (450, quarter)):
        go(browser, f"#panel=0&turn={turn}")
        assert np.array_equal(browser.picture(), wanted)


@pytest.mark.slow
def test_what_does_not_depend_on_it_stays(browser, page):
    for color in ("reflectance", "emission", "normal", "object"):
        browser.open(page, f"#panel=0&color={color}")
        before = browser.picture()
        go(browser, f"#panel=0&color={color}&turn=90")
        assert np.array_equal(browser.picture(), before)
    assert "turned" not in element(browser, "note", "textContent")


def test_white_is_that_of_a_whole_turn(transfer, sky):
    about, _ = sf.Page(transfer, environment=sky)._data()
    light = TurningLight(transfer, sky)
    all_round = [light.relight(40.0 * k).radiosity for k in range(9)]
    assert about["colors"][0]["white"] == pytest.approx(white_of(np.concatenate(all_round)), rel=1e-5)


@pytest.mark.slow
def test_the_slider_turns_it(browser, page):
    browser.open(page)
    before = browser.picture()
    left, top, width, height = place_of(browser, "turn")
    start, end = (left + 8, top + height / 2), (left + width / 4, top + height / 2)
    browser.settled(lambda: browser.drag(start, end))
    turned = float(element(browser, "turn", "value"))
    assert turned == pytest.approx(90, abs=15)
    assert element(browser, "note", "textContent").endswith(f"; turned by {turned:g}°")
    after = browser.picture()
    assert (np.abs(after - before).max(axis=2) > 8)[:, 270:].mean() > 0.05
    browser.settled(lambda: browser.drag(end, (left + width + 30, top + height / 2)))
    assert element(browser, "turn", "value") == "360"  # and the thumb stays where the mouse has it
    assert element(browser, "note", "textContent").endswith("; turned by 0°")


@pytest.mark.slow
def test_keys_turn_it(browser, page):
    browser.open(page)
    for key, degrees in ((",", 355), (".", 0), (".", 5)):
        browser.settled(lambda key=key: browser.key(key))
        assert element(browser, "turn", "value") == str(degrees)
    browser.key("h")
    assert ", and .: turn the environment" in element(browser, "keys", "innerText")


@pytest.mark.slow
def test_the_values_of_a_surfel_turn_too(browser, page, transfer, sky):
    browser.open(page, "#panel=0")
    browser.settled(lambda: browser.click(240, 150))
    for degrees in (0, 5):
        lines = element(browser, "values", "textContent").split("\n")
        values = {line.split()[0]: line.split()[1:] for line in lines}
        wanted, k = relit(transfer, sky, degrees), int(values["surfel"][0])
        for name, found in (("radiosity", wanted.radiosity), ("direct", wanted.direct)):
            np.testing.assert_allclose([float(v) for v in values[name]], found[k], rtol=6e-3, atol=1e-3)
        browser.settled(lambda: browser.key("."))


@pytest.mark.slow
def test_where_nothing_turns_there_is_no_slider(browser, transfer, sky, tmp_path):
    for page in (sf.Page(transfer.relight(sky)), sf.Page(transfer, environment=sky, colors=["normal", "emission"])):
        browser.open(page.save(tmp_path / "a.html"))
        assert place_of(browser, "turn")[2] == 0
        browser.key(".")
        assert "turned" not in element(browser, "note", "textContent")
        browser.key("h")
        assert "environment" not in element(browser, "keys", "innerText")


@pytest.mark.slow
def test_it_has_no_more_than_its_colours_need(transfer, sky):
    """A surfel: 58 bytes of irradiance (9 x 3 x 2 and a scale), 58 of direct light, 6 of reflectance, 4 of emission."""
    n = len(transfer.scene.surfels)
    still = len(sf.Page(transfer.relight(sky), colors=["normal"])._data()[1])
    for colors, each in (
        (["radiosity"], 58 + 6 + 4),
        (["irradiance"], 58),
        (["direct"], 58),
        (["indirect", "radiosity"], 58 + 58 + 6 + 4),
        (["normal", "irradiance"], 4 + 58),
    ):
        size = len(sf.Page(transfer, environment=sky, colors=colors)._data()[1])
        assert size - (still - 4 * n) == pytest.approx(each * n, abs=16)


def test_harmonics_turn_about_an_axis_of_choice(transfer):
    """Light along x, turned about z by a quarter, comes along y; about x it stays."""
    along_x, along_y = np.eye(4)[3], np.eye(4)[1]
    for axis, wanted in ((None, along_y), ([1.0, 0.0, 0.0], along_x)):
        page = sf.Page(transfer, environment=2 * np.eye(4)[0] + along_x, axis=axis)
        found = page._turning.shown("direct", np.pi / 2)
        exact = transfer.relight(2 * np.eye(4)[0] + wanted).direct
        np.testing.assert_allclose(found, exact, atol=1e-5 * exact.max())


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, r"^environment: wanted one, for a DistantTransfer has none of its own$"),
        ({"environment": [1.0] * 3}, r"^environment: wanted an Environment or 1, 4, 9, 16 or 25 harmonics, got 3$"),
        ({"environment": [1.0], "axis": [0, 0, 0]}, r"^axis: wanted vectors of non-zero length"),
        ({"environment": [1.0], "colors": ["light"]}, r"^colors: wanted one of 'radiosity', "),
        ({"environment": [1.0], "camera": 3}, r"^camera: wanted a Camera or None, got 3$"),
    ],
    ids=str,
)
def test_wrong_arguments(transfer, options, message):
    with pytest.raises(ValueError, match=message):
        sf.Page(transfer, **options)


def test_what_has_no_environment_takes_none(transfer, sky):
    for name, value in (("environment", sky), ("axis", [0, 0, 1])):
        with pytest.raises(ValueError, match=f"^{name}: goes with a DistantTransfer, got Solution$"):
            sf.Page(transfer.relight(sky), **{name: value})
    with pytest.raises(ValueError, match=r"^thing: wanted Surfels, a Scene or a Solution, got LocalTransfer$"):
        sf.Page(sf.precompute_transfer(transfer.scene))
