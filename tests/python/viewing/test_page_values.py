"""What pages tell of numbers, and of surfels and lamps that are clicked, as Chromium shows it."""

import numpy as np
import pytest

import surflux as sf

# Looking down from 4: 90 pixels make one unit at z = 0.
ABOVE = sf.Camera([0, 0, 4], [0, 0, 0], up=(0, 1, 0), fov=2 * np.degrees(np.arctan(0.5)))
SQUARE = ([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [[0, 1, 2, 3]])


def shown(browser, tmp_path, thing, hash="#panel=0", **options):
    browser.open(sf.Page(thing, **({"camera": ABOVE} | options)).save(tmp_path / "a.html"), hash)


@pytest.mark.slow
def test_a_click_tells_positions_to_a_thousandth_of_the_radius(browser, tmp_path):
    """Northings of a survey had six digits: they were rounded to 10 m."""
    place = np.array([512345.67812, 5412345.67834, 312.51256])
    s = sf.Surfels(np.add(place, [[0, 0, 0], [1.0, 0.37, 0]]), [[0, 0, 1]] * 2, radii=0.2)
    camera = sf.Camera(np.add(place, [0, 0, 4]), place, up=(0, 1, 0), fov=ABOVE.fov)
    shown(browser, tmp_path, s, camera=camera)
    for k, at_pixel in enumerate([(240, 180), (240 + 90, 180 - 33)]):
        browser.settled(lambda at_pixel=at_pixel: browser.click(*at_pixel))
        words = browser.run("document.getElementById('values').textContent").split("\n")
        (said,) = (line.split()[1:] for line in words if line.startswith("position"))
        np.testing.assert_allclose([float(v) for v in said], s.points[k], rtol=0, atol=2e-4)


def told(browser):
    """What the page tells of the surfel that was clicked, by name."""
    words = browser.run("document.getElementById('values').textContent").split("\n")
    return {line.split()[0]: line.split()[1:] for line in words}


@pytest.mark.slow
def test_a_lamp_tells_what_it_sends_alone(browser, tmp_path):
    """It was said to receive what it sends, and to have 1 of the arrays of others."""
    floor = sf.Surfels.from_mesh(SQUARE, patch_area=0.1)
    lamp = sf.AreaLight([-0.25, -0.25, 0.5], [0.5, 0, 0], [0, 0.5, 0], [20, 10, 5])  # shines up
    solution = sf.solve(sf.Scene([floor], [lamp]), insert=False)
    values = {"mine": np.full((len(floor), 3), 1.0), "number": np.arange(len(floor))}
    colors = ["radiosity", "irradiance", "direct", "indirect", "mine", "number"]
    shown(browser, tmp_path, solution, colors=colors, values=values)
    browser.settled(lambda: browser.click(240, 180))
    said = told(browser)
    assert [*said] == ["lamp", "position", "radius", "radiosity"]
    assert [float(v) for v in said["radiosity"]] == pytest.approx([20, 10, 5], rel=4e-3)
    assert said["position"] == ["0.0000", "0.0000", "0.5000"]
    browser.settled(lambda: browser.click(240 + 80, 180))
    assert [*told(browser)][3:] == colors


@pytest.mark.slow
def test_numbers_have_a_scale_and_are_told(browser, tmp_path):
    floor = sf.Surfels.from_mesh(SQUARE, patch_area=0.01)
    kelvins, seconds = np.linspace(293.15, 293.45, len(floor)), 1.7e9 + np.arange(len(floor))
    seconds[-1] = np.nan
    values = {"kelvins": kelvins, "few": np.where(kelvins > 293.3, 2.0, 1.0), "seconds": seconds}
    values["numbers"] = 1_289_100 + 7 * np.arange(len(floor))
    shown(browser, tmp_path, floor, "#color=kelvins", values=values, colors=[*values, "normal"])

    def note():
        return browser.run("document.getElementById('note').textContent")

    low, high = np.percentile(kelvins, [1, 99])
    assert note() == f"kelvins; purple is {low:.6g}, yellow is {high:.6g} (1st to 99th percentile)"
    browser.run("location.hash = '#color=few'")
    browser.wait("document.getElementById('note').textContent.startsWith('few')")
    assert note() == "few; purple is 1, yellow is 2"
    browser.settled(lambda: browser.run("location.hash = '#panel=0&color=seconds'"))
    for column, row in ((240, 180), (200, 120)):
        browser.settled(lambda column=column, row=row: browser.click(column, row))
        said = told(browser)
        k = int(said["surfel"][0])
        assert float(said["kelvins"][0]) == pytest.approx(kelvins[k], abs=1e-4)
        assert float(said["few"][0]) == values["few"][k]
        assert float(said["seconds"][0]) == seconds[k]
        assert said["numbers"] == [str(values["numbers"][k])]
    corner = floor.points[-1]
    browser.settled(lambda: browser.click(240 + 90 * corner[0], 180 - 90 * corner[1]))
    assert told(browser)["seconds"] == ["NaN"]
    browser.settled(lambda: browser.run("location.hash = '#color=normal'"))
    assert "purple" not in note()
