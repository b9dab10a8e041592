"""Pages quote what stands in data/figures, and `surflux bench --site` writes what they quote."""

import json
import re
from dataclasses import replace

import pytest

import quoted_figures
from surflux.bench import areas, cases, scale, scenes, site, solvers
from surflux.cli import commands


def pictures():
    return set().union(*(what.pictures for what in (site.TABLES | site.PLOTS).values()))


# Measured, but not by `--site`: README.md has the size of what script/setup installs, and what the text of a row says
# of pyviewfactor; install.md sizes of downloads and of the file that script/wheel makes.
ELSEWHERE = {
    "README.md": {"2.5 GB", "7e-10"},
    "install.md": {"0.5 GB", "0.2 GB", "2.5 GB", "0.35 GB", "18 MB"},
}
# Not measured: what is asked for, what a format or a formula makes, and what a test asserts.
GIVEN = {
    "choosing-a-solver.md": {"1 %", "20 s"},  # error=0.01, seconds=20
    "tour.md": {"1 %", "20 s"},  # the same
    "light-a-cloud.md": {"1 %"},  # error=0.01
    "roofs-and-facades.md": {"1 %"},  # of normals, above which a warning comes
    "limits.md": {"1 %", "4e-7"},  # of light on backs, above which a warning comes; some units of single precision
    "daylight.md": {"8 %", "1 %"},  # test_light_at_points.py
    "tiles.md": {"3 %"},  # of a tile's side
    "final-images.md": {
        "12 bytes",  # three floats
        "1 %",  # what Gaussians let through by their opacity, .99; and test_gaussian_pictures.py
        "35 dB",  # test_final_images.py
    },
    "many-machines.md": {"5 s", "20 s"},  # how long a lost worker of Dask is waited for, and any at all
    "inspection.md": {"4 bytes", "42 MB"},  # 4/3 (400 000 (24 + 7 x 4) + 270 000 x 40) bytes
    "why-is-it-black.md": {"4e-7"},  # some units of single precision
    "view-factors.md": {
        "95 %",  # two standard errors
        "3.2 GB",  # 20 000^2 floats of 8 bytes
        "1e-9",  # test_form_factor_operator.py
    },
}


@pytest.mark.parametrize("page", quoted_figures.PAGES, ids=lambda page: page.name)
def test_tables_and_figures_are_those_measured(page):
    text = page.read_text()
    assert quoted_figures.with_tables(text) == text, "python tests/support/quoted_figures.py writes it anew"
    assert quoted_figures.wrong_quotes(text) == []


@pytest.mark.parametrize("page", quoted_figures.PAGES, ids=lambda page: page.name)
def test_pages_quote_no_other_number(page):
    known = ELSEWHERE.get(page.name, set()) | GIVEN.get(page.name, set())
    assert quoted_figures.untied(page.read_text()) == known


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("it takes 4 s, .5 ms or 12 us", {"4 s", ".5 ms", "12 us"}),
        ("off by 1.5 %, 2e-4 of it", {"1.5 %", "2e-4"}),
        ("26 MB, 2.7 times, 1.6 spacings, 982 kWh/m²", {"26 MB", "2.7 times", "1.6 spacings", "982 kWh/m²"}),
        ("rooms of 4 m, 3 seeds, W/m2, 25 000 surfels", set()),
        ("1.2 s<!-- = cases / room / seconds -->, `zeta=5 %`", set()),
        ("```\n5 %\n```\n<!-- figures: cases -->\n6 %\n<!-- end of figures -->", set()),
    ],
)
def test_numbers_that_are_measured_are_seen(text, found):
    assert quoted_figures.untied(text) == found


def test_every_table_and_plot_is_on_a_page():
    pages = [page.read_text() for page in quoted_figures.PAGES]
    quoted = {name for page in pages for _, name, _ in quoted_figures.BLOCK.findall(page)}
    assert quoted == {*site.TABLES, *site.PLOTS} == {path.stem for path in quoted_figures.FIGURES.glob("*.json")}
    for name in pictures():
        assert any(f"/data/figures/{name}.png)" in page for page in pages)
    assert {path.stem for path in quoted_figures.FIGURES.glob("*.png")} == pictures()


@pytest.fixture
def measured(monkeypatch, tmp_path):
    """data/figures with one row that a test knows."""
    row = cases.Row("room", 25_400, 1.249, 0.0172, "own", {"solve": 0.5})
    found = {"command": "surflux bench", "date": "2026-01-02", "commit": "abc", "machine": {"threads": 2}}
    (tmp_path / "cases.json").write_text(json.dumps(found | {"rows": [vars(row)]}))
    monkeypatch.setattr(quoted_figures, "FIGURES", tmp_path)


@pytest.mark.parametrize(
    ("right", "wrong", "column"),
    [
        ("1.2 s", "1.3 s", "seconds"),
        ("1.7 %", "1.6 %", "error"),
        ("1.7e-2", "1.8e-2", "error"),
        (".5 s", ".6 s", "stages.solve"),
        ("25 000", "26 000", "surfels"),
    ],
)
def test_a_quote_is_the_figure_rounded(measured, right, wrong, column):
    place = f"<!-- = cases / room / {column} -->"
    assert quoted_figures.wrong_quotes(f"in {right}{place}") == []
    assert len(quoted_figures.wrong_quotes(f"in {wrong}{place}")) == 1


def test_a_table_says_how_and_when_it_was_measured(measured):
    page = quoted_figures.with_tables("a\n<!-- figures: cases -->\nold\n<!-- end of figures -->\nb")
    assert "| room | 25400 | 1.249 | 0.017 | own | solve 0.500 |\n\n" in page
    assert "\n*`surflux bench`, 2026-01-02, commit abc, 2 threads.*\n<!-- end of figures -->\nb" in page


def test_a_figure_that_is_not_there_is_named(measured):
    with pytest.raises(ValueError, match=r"^data/figures/cases\.json: wanted one row 'hall', found 0$"):
        quoted_figures.wrong_quotes("1 s<!-- = cases / hall / seconds -->")


@pytest.mark.slow
def test_the_command_writes_each_table_in_both_forms(monkeypatch, tmp_path, capsys):
    # Others have tests of their own, in bench/test_bench_site.py and test_bench_limits.py.
    monkeypatch.setattr(site, "TABLES", {name: site.TABLES[name] for name in ("cases", "areas", "area_speeds")})
    monkeypatch.setattr(cases, "CASES", {"furnace in a cube": cases.CASES["furnace in a cube"]})
    monkeypatch.setattr(areas, "CLOUDS", {"icosphere 642": areas.CLOUDS["icosphere 642"]})
    quick = replace(solvers.QUICK, rounds=1, densities={"three spheres": (0.25,)}, samples=(16,), mitsuba_rounds=1)
    monkeypatch.setattr(solvers, "QUICK", replace(quick, knobs_at={"three spheres": None}))
    monkeypatch.setattr(scenes, "NAMES", ("three spheres",))
    monkeypatch.setattr(areas, "SPEED_CLOUD", 300)
    statues = [scale.Row(f"statues of {n}", n, n, 1e-5 * n, 1e-6 * n, 0.02, 0.03) for n in (1000, 10_000)]
    monkeypatch.setattr(scale, "measure", lambda *asked, **options: statues)
    monkeypatch.setattr("os.getloadavg", lambda: (7.25, 0.0, 0.0))
    folder = tmp_path / "figures"
    assert commands.main(["bench", "--site", str(folder), "--repeats", "1"]) == 0
    out, err = capsys.readouterr()
    assert "bench: other programs keep this machine busy (load 7.2)\n" in err
    assert {path.stem for path in folder.glob("*.png")} == pictures()
    assert min(path.stat().st_size for path in folder.glob("*.png")) > 5_000
    for name, what in (site.TABLES | site.PLOTS).items():
        found = json.loads((folder / f"{name}.json").read_text())
        assert found["command"] == what.command
        assert f"{found['date']}, commit {found['commit']}, " in out
        if name in site.PLOTS:
            continue
        assert len(found["rows"]) == 1 or name == "area_speeds"  # which has one for each method
        assert (folder / f"{name}.md").read_text().strip() in out
    # The furnace is closed: B = E / (1 - rho) on every surfel.
    assert json.loads((folder / "cases.json").read_text())["rows"][0]["error"] < 1e-3


def test_on_a_busy_machine_seconds_stay_those_of_a_quiet_one(capsys):
    first = {
        "date": "2026-01-02",
        "commit": "abc",
        "rows": [vars(cases.Row("room", 5, 1.25, 0.3, "own", {"solve": 1.0}))],
    }
    now = {"command": "surflux bench", "date": "2026-02-03", "commit": "def", "machine": {"threads": 2}}
    rows = [vars(cases.Row(name, 6, 9.75, 0.2, "own", {"solve": 9.0})) for name in ("room", "hall")]
    timed = site.TABLES["cases"].timed
    found = site.with_seconds_of(first, now | {"rows": rows}, timed)
    (row,) = found["rows"]
    assert (row["surfels"], row["error"], row["seconds"], row["stages"]) == (6, 0.2, 1.25, {"solve": 1.0})
    assert "bench: hall left out: its seconds were never measured on a quiet machine\n" in capsys.readouterr().err
    told = "*`surflux bench`, 2026-02-03, commit def, 2 threads; seconds 2026-01-02, commit abc.*"
    assert site.text("cases", found).endswith(told)
    again = site.with_seconds_of(found, now | {"rows": rows}, timed)
    assert again["seconds"] == {"date": "2026-01-02", "commit": "abc"}


def test_outside_of_a_checkout_the_version_takes_the_place_of_the_commit(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    assert re.fullmatch(r"of \d+\.\d+\.\d+", site.commit())
