"""Areas drawn by OpenGL against those of the CPU, which share no quadrature."""

import os
import subprocess
import sys
import threading

import numpy as np
import pytest
import pyvista

import surflux as sf
from surflux import _core
from surflux.geometry.areas import BACKENDS
from surflux.scenes import shapes


def apart(s, **options):
    """Relative differences between the areas of the two backends."""
    cpu, gl = (sf.effective_areas(s, backend=backend, **options) for backend in ("cpu", "gl"))
    assert gl.dtype == np.float64
    assert gl.shape == (len(s),)
    return np.abs(gl / cpu - 1.0)


@pytest.mark.parametrize("api", ["egl", "osmesa"])
def test_both_backends_agree(api, monkeypatch):
    monkeypatch.setenv("SURFLUX_GL", api)
    sphere = shapes.sphere(1000, 0.8)
    assert apart(sphere).max() < 1e-5
    assert (apart(sphere, method="paper") < 1e-4).mean() >= 0.999
    assert apart(sphere, kappa=2.0, resolution=9, epsilon=0.5).max() < 1e-5


@pytest.mark.scans
@pytest.mark.parametrize("method", ["paper", "curved"])
@pytest.mark.slow
def test_both_backends_agree_on_a_scan(method, scans):
    s = sf.read(scans / "statues" / "bunny_34834.ply")
    assert (apart(s, method=method) < 1e-4).mean() >= 0.999


def test_auto_takes_the_cpu_for_small_clouds_and_makes_no_context(monkeypatch):
    monkeypatch.setenv("SURFLUX_GL", "neither")  # asking for a context would raise
    s = shapes.sphere(300, 0.8)
    np.testing.assert_array_equal(sf.effective_areas(s), sf.effective_areas(s, backend="cpu"))
    with pytest.raises(ValueError, match=r"^SURFLUX_GL: wanted egl, osmesa or any, got 'neither'$"):
        sf.effective_areas(s, backend="gl")


def test_without_opengl_the_error_tells_what_to_install():
    code = (
        "import surflux as sf; from surflux.scenes import shapes\n"
        "try:\n    sf.effective_areas(shapes.sphere(100, 1.0), backend='gl')\n"
        "except sf.DeviceError as e:\n    print(e)"
    )
    environment = {"SURFLUX_GL": "egl", "__EGL_VENDOR_LIBRARY_FILENAMES": "/nonexistent.json"}
    result = subprocess.run(
        [sys.executable, "-c", code], env={**os.environ, **environment}, capture_output=True, text=True, timeout=60
    )
    assert "no OpenGL >= 4.3 core context could be made" in result.stdout, result.stderr
    assert "sudo apt-get install libegl1" in result.stdout


def test_progress_is_told_on_the_callers_thread_and_can_stop():
    s, seen = shapes.sphere(300, 0.8), []

    def callback(done, total):
        seen.append((done, total, threading.current_thread()))
        return True

    whole = sf.effective_areas(s, backend="gl", resolution=100, progress=callback)
    assert seen[-1][:2] == (300, 300)
    assert {thread for _, _, thread in seen} == {threading.current_thread()}
    with pytest.raises(sf.Cancelled):
        sf.effective_areas(s, backend="gl", progress=lambda done, total: False)
    np.testing.assert_array_equal(sf.effective_areas(s, backend="gl", resolution=100), whole)


def test_beside_vtk_both_draw_as_before():
    s = shapes.sphere(300, 0.8)
    alone = sf.effective_areas(s, backend="gl")
    plotter = pyvista.Plotter(off_screen=True, window_size=(120, 90))
    plotter.add_mesh(pyvista.Sphere(), color="red")
    before = np.asarray(plotter.screenshot(return_img=True))
    np.testing.assert_array_equal(sf.effective_areas(s, backend="gl"), alone)
    plotter.render()
    after = np.asarray(plotter.screenshot(return_img=True))
    plotter.close()
    assert before.std() > 10
    np.testing.assert_array_equal(after, before)


def test_the_core_names_the_backends_as_python_does():
    assert sorted(_core.AreaBackend.__members__) == sorted(BACKENDS)
