"""What a notebook shows of surfels, scenes and solutions: tables of the same figures as repr()."""

import math
import re
from html.parser import HTMLParser

import numpy as np
import pytest

import surflux as sf

SQUARE = [[0, 0, 0], [2, 0, 0], [2, 3, 0], [0, 3, 0]], [[0, 1, 2, 3]]


class Cells(HTMLParser):
    """The texts of a table's cells, unescaped, row by row; every tag is closed in its turn."""

    def __init__(self, text):
        super().__init__()
        self.rows, self._open = [], []
        self.feed(text)
        self.close()
        assert self._open == []

    def handle_starttag(self, tag, attrs):
        assert tag in ("table", "tr", "th", "td")
        self._open.append(tag)
        if tag == "tr":
            self.rows.append([])
        if tag in ("th", "td"):
            assert dict(attrs)["style"] == "text-align: left"
            self.rows[-1].append("")

    def handle_endtag(self, tag):
        assert self._open.pop() == tag

    def handle_data(self, data):
        if self._open and self._open[-1] in ("th", "td"):
            self.rows[-1][-1] += data


def table_of(thing):
    """(title, {name: text}) of what a notebook shows."""
    (title,), *rows = Cells(thing._repr_html_()).rows
    return title, {name: text for name, text in rows}


@pytest.fixture(scope="module")
def solution():
    floor = sf.Surfels.from_mesh(SQUARE, patch_area=0.5)
    lamp = sf.Surfels([[1, 1, 2]], [[0, 0, -1]], radii=0.1, areas=0.03, emission=[5, 4, 3])
    return sf.solve(sf.Scene([floor, lamp], [sf.PointLight([1, 1, 1], 2)], name="<b>room</b> & co"))


def test_the_table_of_surfels():
    s = sf.Surfels.from_mesh(SQUARE, patch_area=0.5, reflectance=[0.2, 0.4, 0.6])
    title, rows = table_of(s)
    assert title == "Surfels"
    assert rows["surfels"] == f"{len(s)}, {len(s)} of them patches"
    assert repr(s) == f"Surfels({len(s)} surfels, {len(s)} of them patches, area 6)"
    assert rows["area"] == "6"
    assert rows["bounds"] == "x 0 to 2, y 0 to 3, z 0 to 0"
    assert rows["reflectance"] == "0.2 to 0.6"
    assert "emission" not in rows
    disks = sf.Surfels([[0, 0, 0], [1, 0, 0]], [[0, 0, 1]] * 2, radii=[0.5, 1], emission=[0, 3])
    rows = table_of(disks)[1]
    assert (rows["surfels"], rows["area"], rows["radii"]) == ("2", "open", "0.5 to 1")
    assert rows["emission"] == "0 to 3, of 1 surfel"


def test_the_table_of_a_scene_and_no_name_is_markup(solution):
    scene = solution._scene
    text = scene._repr_html_()
    assert "<b>" not in text
    title, rows = table_of(scene)
    assert title == "Scene <b>room</b> & co"
    assert rows["objects"] == "2"
    assert rows["surfels"] == f"{len(scene.surfels)}, 1 of them emissive"
    assert f"2 objects, {len(scene.surfels)} surfels, 1 light)" in repr(scene)
    assert rows["lights"] == "1 PointLight"
    assert rows["bounds"] == "x 0 to 2, y 0 to 3, z 0 to 2"
    assert rows["area"] == "6.03"
    assert table_of(sf.Scene([sf.Surfels([[0, 0, 0]], [[0, 0, 1]], radii=1)]))[1]["area"] == "open"


def test_the_account_of_a_solution_adds_up(solution):
    title, rows = table_of(solution)
    assert title == "Solution"
    assert rows["error, estimated"] == f"{solution.error:.2%}"
    assert f"error {solution.error:.2g}" in repr(solution)
    assert rows["surfels"].startswith(str(len(solution.surfels)))
    power = {name: float(rows[name].split()[0]) for name in ("power in", "absorbed", "escaped", "into backs", "lost")}
    # What enters is what the lamp and the light give: sum A E, and the part of 4 pi I that falls on the square.
    assert power["power in"] == pytest.approx(solution.history[-1]["power_in"], rel=1e-4)
    rest = power["absorbed"] + power["escaped"] + power["into backs"] + power["lost"]
    assert rest == pytest.approx(power["power in"], rel=4 * 1e-4)  # each to five digits
    share = float(re.search(r"\((.*)%\)", rows["absorbed"])[1])
    assert share == pytest.approx(100 * power["absorbed"] / power["power in"], abs=0.01)
    assert " ± " in rows["lost"]


def test_a_solution_from_a_file_shows_what_there_is(solution, tmp_path):
    again = sf.load_solution(solution.save(tmp_path / "a.ply"))
    assert table_of(again) == table_of(solution)
    again.history, again.error = [{"power_in": "<i>"}], math.nan
    rows = table_of(again)[1]
    assert rows["error, estimated"] == "unknown"
    assert "power in" not in rows


def test_large_and_survey_coordinates_are_told_apart():
    s = sf.Surfels(np.array([[5.1e6, 4.3e5, 800], [5.1e6 + 20, 4.3e5, 800]]), [[0, 0, 1]] * 2, radii=1.0)
    assert table_of(s)[1]["bounds"] == "x 5100000 to 5100020, y 430000 to 430000, z 800 to 800"


def test_a_printed_solution_tells_where_the_power_went(solution):
    said, power = str(solution).splitlines()
    assert said == repr(solution)
    names = ("absorbed", "escaped", "into backs", "lost")
    places = ", ".join(f"{name} (.+)%" for name in names)
    found = re.fullmatch(rf"power in (.+?) \(on surfaces, all channels\): {places}", power)
    assert float(found[1]) == pytest.approx(solution.history[-1]["power_in"], rel=1e-4)
    # All that enters ends somewhere; each of the four is rounded to .01 %.
    assert sum(float(share) for share in found.groups()[1:]) == pytest.approx(100.0, abs=0.02 + 1e-9)


def test_a_printed_solution_without_power_or_figures():
    dark = sf.Surfels([[0, 0, 0]], [[0, 0, 1]], radii=0.1, areas=0.03)
    with pytest.warns(UserWarning, match="light"):
        black = sf.solve(sf.Scene([dark]))
    assert str(black).endswith("\npower in 0 (on surfaces, all channels): absorbed 0, escaped 0, into backs 0, lost 0")
    arrays = {name: getattr(black, name) for name in ("parents", "objects", "radiosity", "irradiance", "direct")}
    bare = sf.Solution(black.surfels, **arrays)
    assert str(bare) == repr(bare)
