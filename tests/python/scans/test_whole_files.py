"""Files that are written at once by several threads, or to a full disk, are whole."""

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import surflux as sf

LONG = "a_survey_of_the_old_town_in_the_summer_of_that_year"
FULL = """
import resource
import numpy as np
import surflux as sf
from surflux.cli.commands import main

resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))
try:
    sf.Scan(np.random.default_rng(0).random((5000, 3))).save("lit.vtp")
except sf.FileError as error:
    assert "lit.vtp: cannot be written" in str(error), error
else:
    raise AssertionError("no error")
assert main(["solve", "floor.obj", "-o", "lit.vtp", "--no-image", "--light", "sky", "--rays", "16", "-q"]) == 2
"""


@pytest.mark.parametrize("suffix", [".ply", ".csv"])
def test_threads_do_not_write_into_files_of_names_that_begin_alike(tmp_path, suffix):
    scans = [sf.Scan(np.full((2000, 3), float(k)) + np.arange(2000)[:, None]) for k in range(8)]
    paths = [tmp_path / f"{LONG}_{k}{suffix}" for k in range(8)]
    with ThreadPoolExecutor(4) as pool:
        list(pool.map(sf.Scan.save, scans, paths))
    for scan, path in zip(scans, paths, strict=True):
        np.testing.assert_array_equal(sf.read_scan(path).points, scan.points)
    assert {path.name for path in tmp_path.iterdir()} == {path.name for path in paths}


def test_vtp_on_a_full_disk_is_an_error_and_what_was_there_stays(tmp_path, monkeypatch):
    pytest.importorskip("resource")
    pytest.importorskip("pyvista")
    monkeypatch.chdir(tmp_path)
    side = 60
    x, y = (np.ravel(k) for k in np.meshgrid(np.arange(side), np.arange(side)))
    corner = (x + side * y + 1)[(x < side - 1) & (y < side - 1)]
    lines = [f"v {a} {b} 0" for a, b in zip(x, y, strict=True)]
    lines += [f"f {k} {k + 1} {k + side + 1} {k + side}" for k in corner]
    Path("floor.obj").write_text("\n".join(lines))
    Path("lit.vtp").write_text("there already")
    Path("full.py").write_text(FULL)
    done = subprocess.run([sys.executable, "full.py"], capture_output=True, text=True, timeout=240)
    assert (done.returncode, "lit.vtp: cannot be written" in done.stderr) == (0, True), done.stderr
    assert Path("lit.vtp").read_text() == "there already"
    assert sorted(path.name for path in Path().iterdir()) == ["floor.obj", "full.py", "lit.vtp"]


def test_vtp_says_which_arrays_are_bool(tmp_path):
    pyvista = pytest.importorskip("pyvista")
    keep = np.array([True, False, True, False, False])
    path = sf.Scan(np.zeros((5, 3)), attributes={"keep": keep}).save(tmp_path / "b.vtp")
    found = pyvista.read(path).point_data["keep"]
    assert found.dtype == bool
    np.testing.assert_array_equal(found, keep)
