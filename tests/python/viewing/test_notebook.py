"""What a Jupyter notebook shows: a real kernel runs the cells, Chromium shows what they came to."""

import base64
import html
import io
import os

import numpy as np
import pytest

import surflux as sf
from surflux.drawing import plots

CELLS = [
    """
import surflux as sf
red = sf.Surfels([[0, 0, 0]], normals=[[0, 0, 1]], radii=0.8, reflectance=[0.8, 0, 0])
camera = sf.Camera([0, 0, 4], [0, 0, 0], up=(0, 1, 0))
sf.view(red, camera=camera)
""",
    "sf.Page(red, camera=camera)",
    "red.plot(camera=camera, size=(200, 200))",
    "red.plot_areas(size=(200, 200))",
]


def run_cells(cells, folder, display=None):
    """What each cell shows, by MIME type; a display that is named need not be there."""
    for name in ("nbclient", "ipykernel"):
        if not os.environ.get("CI"):
            pytest.importorskip(name)
    import nbclient
    import nbformat

    book = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in cells])
    with pytest.MonkeyPatch.context() as patch:
        for name in ("DISPLAY", "WAYLAND_DISPLAY"):
            patch.delenv(name, raising=False)
        if display is not None:
            patch.setenv("DISPLAY", display)
        nbclient.NotebookClient(book, timeout=120, resources={"metadata": {"path": str(folder)}}).execute()
    assert os.listdir(folder) == []  # nothing was written on the way
    shown = [[o for o in cell["outputs"] if o["output_type"] == "execute_result"] for cell in book["cells"]]
    return [results[0]["data"] for results in shown]


@pytest.fixture(scope="module")
def outputs(tmp_path_factory):
    return run_cells(CELLS, tmp_path_factory.mktemp("notebook"))


@pytest.mark.slow
def test_where_there_is_a_display_a_view_is_a_page_too(tmp_path):
    (shown,) = run_cells(CELLS[:1], tmp_path, display=":99")
    assert shown["text/html"].startswith("<iframe")


def is_red(image):
    return image[..., 0] > image[..., 1:].max(axis=-1) + 60


@pytest.mark.parametrize("cell", [0, 1])
@pytest.mark.slow
def test_a_view_is_a_page_in_a_frame(outputs, browser, tmp_path, cell):
    (tmp_path / "cell.html").write_text(f"<!doctype html><body>{outputs[cell]['text/html']}</body>")
    browser.ask("Page.navigate", url=(tmp_path / "cell.html").as_uri())
    browser.wait("document.querySelector('iframe')")
    browser.wait_until(lambda: is_red(browser.picture()).sum() > 5000)
    image = browser.picture()
    assert image[240, 240].tolist() == pytest.approx([231, 0, 0], abs=2)
    assert image[100, 470].tolist() == [255, 255, 255]


@pytest.mark.slow
def test_a_plot_is_a_picture(outputs):
    from PIL import Image

    data = outputs[2]["image/png"]
    image = np.asarray(Image.open(io.BytesIO(base64.b64decode(data))).convert("RGB")).astype(int)
    assert image.shape == (200, 200, 3)
    assert image[100, 100].tolist() == pytest.approx([231, 0, 0], abs=1)


@pytest.mark.slow
def test_a_plot_of_areas_is_a_picture(outputs):
    from PIL import Image

    image = Image.open(io.BytesIO(base64.b64decode(outputs[3]["image/png"])))
    assert image.size == (200, 200)
    assert len(image.getcolors(200 * 200)) > 10


def test_elsewhere_it_is_no_notebook(tmp_path, monkeypatch):
    assert not plots.in_notebook()
    page = sf.Page(sf.Surfels([[0, 0, 0]], normals=[[0, 0, 1]], radii=1), title="<b>&")
    frame = page._repr_html_()
    assert frame.startswith("<iframe")
    inside = html.unescape(frame.split('srcdoc="')[1].rsplit('"', 1)[0])
    assert inside == page.html()
    assert "<title>&lt;b&gt;&amp;</title>" in inside
