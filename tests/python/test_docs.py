"""What the documentation shows runs: every example of every docstring, and every python block of the README
and of the guide, notebooks too."""

import doctest
import importlib
import inspect
import json
import os
import pkgutil
import re
import tomllib
from pathlib import Path

import pytest

import surflux as sf

README = Path(__file__).parents[2] / "README.md"
GUIDE = sorted((README.parent / "python" / "guide").glob("*.md"))
FRONT = README.parent / "python" / "guide" / "index.md"
REFERENCE = README.parent / "python" / "guide" / "reference.rst"
NOTEBOOKS = sorted((README.parent / "python" / "guide").glob("*.ipynb"))
MODULES = ["surflux", *(m.name for m in pkgutil.walk_packages(sf.__path__, "surflux.") if m.name != "surflux.__main__")]


def examples(module):
    return [test for test in doctest.DocTestFinder().find(importlib.import_module(module)) if test.examples]


def blocks(text):
    return re.findall(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


@pytest.fixture
def elsewhere(tmp_path, monkeypatch):
    """Examples write into a folder of their own and open no window."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("pyvista.OFF_SCREEN", True)


@pytest.mark.parametrize("example", [e for module in MODULES for e in examples(module)], ids=lambda e: e.name)
def test_docstring(example, elsewhere):
    said = []
    doctest.DocTestRunner(verbose=False, optionflags=doctest.ELLIPSIS).run(example, out=said.append)
    assert said == []


FUNCTIONS = [name for name in sf.__all__ if inspect.isfunction(getattr(sf, name))]


def test_every_room_is_read():
    assert {"surflux._core", "surflux.points.surfels", "surflux.viewing.page"} <= set(MODULES)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_public_function_shows_an_example(name):
    assert ">>> " in inspect.getdoc(getattr(sf, name))


@pytest.mark.parametrize("module", [m for m in MODULES if m not in ("surflux._core", "surflux._image")])
def test_docstrings_have_one_style(module):
    """Args:, Returns:, Raises:, not headings with a line under them."""
    for line in inspect.getsource(importlib.import_module(module)).splitlines():
        assert line.strip().strip("-") or not line.strip(), f"{module}: a heading underlined"


# Of pages that take seconds each.
SLOW = (
    "choosing-a-solver",
    "final-images",
    "inspection",
    "light-a-cloud",
    "moving-lamps",
    "roofs-and-facades",
    "tiles",
)
WITHOUT_CODE = ("commands", "index", "install", "tour")


@pytest.mark.parametrize(
    "page", [pytest.param(page, id=page.stem, marks=[pytest.mark.slow] * (page.stem in SLOW)) for page in GUIDE]
)
def test_guide(page, elsewhere):
    """The examples of one page go on from each other."""
    shared = {"__name__": "__main__"}
    found = blocks(page.read_text())
    assert bool(found) != (page.stem in WITHOUT_CODE)
    for block in found:
        exec(compile(block, page, "exec"), shared)


def cells(book, kind):
    return [cell for cell in json.loads(book.read_text())["cells"] if cell["cell_type"] == kind]


@pytest.mark.parametrize("book", NOTEBOOKS, ids=lambda book: book.stem)
@pytest.mark.slow
def test_notebook(book, elsewhere):
    """Its cells run from top to bottom, and it is kept without what they show."""
    if not os.environ.get("CI"):
        pytest.importorskip("IPython")
    shared = {"__name__": "__main__"}
    for cell in cells(book, "code"):
        assert cell["outputs"] == []
        assert cell["execution_count"] is None
        exec(compile("".join(cell["source"]), book, "exec"), shared)


@pytest.mark.parametrize("book", NOTEBOOKS, ids=lambda book: book.stem)
def test_a_page_of_the_guide_leads_to_the_notebook(book):
    assert any(f"({book.name})" in page.read_text() for page in GUIDE)
    for cell in cells(book, "markdown"):
        for link in re.findall(r"\]\((?!https?:)([^)#]+)", "".join(cell["source"])):
            assert (book.parent / link).exists(), f"{book.name} links to {link}"


@pytest.mark.parametrize("page", [README, *GUIDE], ids=lambda page: page.stem)
def test_links_lead_somewhere(page):
    for link in re.findall(r"\]\((?!https?:)([^)#]+)", page.read_text()):
        assert (page.parent / link).exists(), f"{page.name} links to {link}"


@pytest.mark.parametrize("page", [page for page in GUIDE if page != FRONT], ids=lambda page: page.stem)
def test_the_front_page_lists_every_page(page):
    assert f"(python/guide/{page.name})" in README.read_text()
    contents = re.findall(r"^```{toctree}\n(.*?)^```", FRONT.read_text(), re.MULTILINE | re.DOTALL)
    assert page.stem in "\n".join(contents).splitlines()


def test_the_reference_has_every_public_name_once():
    listed = re.findall(r"^   (\w+)$", REFERENCE.read_text(), re.MULTILINE)
    assert sorted(listed) == sf.__all__


@pytest.mark.slow
def test_every_figure_of_the_history_is_explained():
    page = (README.parent / "python" / "guide" / "choosing-a-solver.md").read_text()
    rows = re.findall(r"^\| `(\w+)` \| (.+?) \|", page, re.MULTILINE)
    scene = sf.load_scene(README.parent / "data" / "cornell.toml")
    few = {"rays": 16, "probes": 4, "shadow_rays": 4}
    found = {
        "pairs": sf.solve(scene, transport="pairs", **few),
        "rays": sf.solve(scene, transport="rays", **few),
        "meshless": sf.solve_meshless(scene, levels=2, **few),
    }
    groups = {"all": set(found), "`solve`": {"pairs", "rays"}}
    explained = {key: groups.get(by, set(by.split(", "))) for key, by in rows}
    written = {}
    for name, solution in found.items():
        for key in {key for entry in solution.history for key in entry}:
            written.setdefault(key, set()).add(name)
    assert written == explained
    assert [key for key in written if not re.search(rf"\b{key}\b", inspect.getdoc(sf.Solution))] == []
    for solution in found.values():
        assert [entry["iteration"] for entry in solution.history] == list(range(1, len(solution.history) + 1))
    assert "| `iteration` | all | number of the iteration, from 1 |" in page


@pytest.mark.parametrize("block", blocks(README.read_text()))
def test_readme(block, elsewhere):
    exec(compile(block, README, "exec"), {"__name__": "__main__"})


def test_the_readme_is_short_and_says_how_to_begin_on_its_first_screen():
    lines = README.read_text().splitlines()
    assert len(lines) <= 120
    first = "\n".join(lines[:25])
    assert "script/demo" in first
    assert "script/test" in first
    assert len(set(re.findall(r"data/thumb_\w+\.png", README.read_text()))) == 6


def test_a_package_index_shows_no_broken_link():
    """It has no pictures and no pages: nothing may be relative there. The example is that of the README."""
    project = tomllib.loads((README.parent / "pyproject.toml").read_text())["project"]
    page = (README.parent / project["readme"]).read_text()
    assert re.findall(r"\]\((?!https?:)", page) + re.findall("<img|<a ", page) == []
    assert blocks(page) == blocks(README.read_text())


def test_the_readme_has_its_example():
    lengths = [len(block.splitlines()) for block in blocks(README.read_text())]
    assert any(5 <= length <= 15 for length in lengths), lengths


def public():
    """(name, object) of all that a user reads help about: public names, and the methods and properties of classes."""
    for name in sf.__all__:
        item = getattr(sf, name)
        yield name, item
        if inspect.isclass(item) and item.__module__.startswith("surflux.") and not issubclass(item, Exception):
            for member, value in vars(item).items():
                if not member.startswith("_") and (callable(value) or isinstance(value, (property, classmethod))):
                    yield f"{name}.{member}", value


@pytest.mark.parametrize(("name", "item"), list(public()), ids=lambda value: value if isinstance(value, str) else "")
def test_every_public_name_is_documented(name, item):
    assert inspect.getdoc(item), name
