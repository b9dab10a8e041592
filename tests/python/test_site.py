"""The site is built without a warning; its links lead somewhere, and a browser opens its pages without complaint."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

import links
import surflux as sf
from copied_script import CopiedScripts

ROOT = Path(__file__).parents[2]
BUILD = ROOT / "python" / "guide" / "_site" / "build.py"
NEEDED = ("sphinx", "furo", "myst_nb", "sphinx_design", "sphinx_gallery")


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The folder of the site. Where CI is set, Sphinx has to be there."""
    if missing := [name for name in NEEDED if importlib.util.find_spec(name) is None]:
        reason = f"{', '.join(missing)}: not there; script/setup --docs installs it"
        pytest.fail(reason) if os.environ.get("CI") else pytest.skip(reason)
    folder = tmp_path_factory.mktemp("built")
    (folder / "site").mkdir()
    (folder / "site" / "no_more.html").touch()
    environment = {name: value for name, value in os.environ.items() if name != "SURFLUX_DATA"}
    done = subprocess.run([sys.executable, BUILD, folder], env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return folder / "site"


def test_pages_of_examples_that_are_no_more_go(tmp_path):
    spec = importlib.util.spec_from_file_location("build", BUILD)
    build = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(build)
    gallery = tmp_path / "python" / "guide" / "gallery"
    (gallery / "images" / "thumb").mkdir(parents=True)
    there, gone = ("effective_areas", "areas")
    names = (
        "{}.py",
        "{}.py.md5",
        "{}.rst",
        "{}.ipynb",
        "images/sphx_glr_{}_001.png",
        "images/thumb/sphx_glr_{}_thumb.png",
    )
    for stem in (there, gone):
        for name in names:
            (gallery / name.format(stem)).touch()
    assert build.copy_of_the_guide(tmp_path) == gallery.parent
    assert {path for path in gallery.rglob("*") if path.is_file()} == {gallery / name.format(there) for name in names}


@pytest.mark.slow
def test_every_page_is_there(site):
    guide = ROOT / "python" / "guide"
    assert not (site / "no_more.html").exists()
    for source in [*guide.glob("*.md"), *guide.glob("*.rst"), *guide.glob("*.ipynb")]:
        assert (site / source.with_suffix(".html").name).is_file()
    for example in (guide / "examples").glob("*.py"):
        assert (site / "gallery" / f"{example.stem}.html").is_file()
        assert (site / "_images" / f"sphx_glr_{example.stem}_001.png").is_file()
    for name in sf.__all__:
        assert (site / "reference" / f"surflux.{name}.html").is_file()


@pytest.mark.slow
def test_links_lead_somewhere(site):
    assert list(links.faults(site)) == []


@pytest.mark.slow
def test_a_browser_opens_every_page_without_complaint(site, browser):
    browser.ask("Log.enable")
    pages = sorted(site.rglob("*.html"))
    assert len(pages) > 100
    for page in pages:
        browser.events.clear()
        browser.visit(page)
        assert browser.complaints() == [], page
        assert browser.run("document.title"), page
        broken = "[...document.images].filter(i => i.complete && !i.naturalWidth).map(i => i.src)"
        assert browser.run(broken) == [], page
        assert [address for address in browser.requests() if not address.startswith(("file:", "data:"))] == [], page


def test_broken_links_are_seen(tmp_path):
    (tmp_path / "a.html").write_text('<h1 id="top">A</h1><a href="b.html#here"></a><a href="#top"></a>')
    (tmp_path / "b.html").write_text(
        '<p id="here"></p><a href="https://example.org/"></a><img src="data:image/png;,"/>'
    )
    assert list(links.faults(tmp_path)) == []
    (tmp_path / "b.html").write_text(
        '<img src="c.png"><a href="a.html#down"></a><script src="https://example.org/x.js">'
    )
    assert sorted(links.faults(tmp_path)) == [
        "a.html: b.html#here: no such place there",
        "b.html: a.html#down: no such place there",
        "b.html: c.png: no such file",
        "b.html: loads https://example.org/x.js",
    ]


def test_an_unknown_option_is_named(tmp_path):
    result = CopiedScripts(tmp_path).run("docs", "--fast", environment={"PATH": os.environ["PATH"]})
    assert result.returncode == 1
    assert result.stderr == "docs: unknown option --fast (known: --quick)\n"
