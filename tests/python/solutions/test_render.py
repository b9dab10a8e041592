import os
import subprocess
import sys

import numpy as np
import pytest
import pyvista

from surflux import _core

CAMERA = (np.array([0.0, -4, 0]), np.zeros(3), np.array([0.0, 0, 1]), 60.0, 0.0)


def disk(radius=1.0):
    none = np.zeros((0, 3, 3)), np.zeros(0, np.uint32)
    return _core.Surfels([[0, 0, 0]], [[0, -1, 0]], [radius], None, [[0.5] * 3], [[0.0] * 3], *none)


def render(surfels, radiance, emitters=(), width=40, height=30, samples=1):
    layers = [(radiance, True)]
    out = _core.render_splats(surfels, layers, list(emitters), CAMERA, width, height, 1.5, samples)
    (out["radiance"],) = out.pop("layers")
    return out


def test_shapes_and_types():
    out = render(disk(), [[1.0, 2.0, 3.0]])
    assert {k: (v.shape, v.dtype) for k, v in out.items()} == {
        "coverage": ((30, 40), np.float32),
        "depth": ((30, 40), np.float32),
        "normal": ((30, 40, 3), np.float32),
        "index": ((30, 40), np.int32),
        "radiance": ((30, 40, 3), np.float32),
    }
    np.testing.assert_allclose(out["radiance"][15, 20], [1, 2, 3], rtol=1e-6)
    np.testing.assert_array_equal(out["radiance"][0, 0], [0, 0, 0])
    assert out["depth"][15, 20] == pytest.approx(4.0, rel=1e-6)
    assert out["depth"][0, 0] == np.inf
    np.testing.assert_array_equal(out["normal"][15, 20], [0, -1, 0])
    assert out["index"][15, 20] == 0
    assert out["index"][0, 0] == -1


def test_emitters_are_seen():
    # A lamp of 1 x 1 before the disk, facing the camera (u x v = -y), has index -2.
    lamp = ((-0.5, -1, -0.5), (1, 0, 0), (0, 0, 1), (7, 8, 9))
    out = render(disk(), [[1.0, 1.0, 1.0]], [lamp])
    np.testing.assert_array_equal(out["radiance"][15, 20], [7, 8, 9])
    assert out["index"][15, 20] == -2


def test_refusals_are_value_errors_by_name():
    with pytest.raises(ValueError, match=r"^values: wanted one RGB value for each of 1 surfels"):
        render(disk(), np.zeros((0, 3)))
    with pytest.raises(ValueError, match=r"^samples: "):
        render(disk(), [[1.0] * 3], samples=0)


def test_an_environment_image_wants_what_is_covered():
    with pytest.raises(ValueError, match=r"^coverage: wanted shape \(h, w\)"):
        _core.environment_image([], CAMERA, np.zeros(4), 1)


def test_the_device_is_described():
    info = _core.gl_info()
    assert set(info) == {"api", "vendor", "renderer", "version"}
    assert all(info.values())


def run_python(code, **environment):
    return subprocess.run(
        [sys.executable, "-c", code], env={**os.environ, **environment}, capture_output=True, text=True, timeout=60
    )


def test_without_a_device_the_error_tells_what_was_tried_and_what_to_install():
    # EGL's dispatch library finds no driver: neither a device nor the surfaceless platform.
    result = run_python(
        "from surflux import _core\ntry:\n    _core.gl_info()\nexcept _core.DeviceError as e:\n    print(e)",
        SURFLUX_GL="egl",
        __EGL_VENDOR_LIBRARY_FILENAMES="/nonexistent.json",
    )
    assert "no OpenGL >= 4.3 core context could be made" in result.stdout, result.stderr
    assert "EGL surfaceless: egl" in result.stdout
    assert "sudo apt-get install libegl1" in result.stdout


def test_osmesa_takes_over_where_egl_has_no_driver():
    result = run_python(
        "from surflux import _core\nprint(_core.gl_info()['api'])",
        SURFLUX_GL="",
        __EGL_VENDOR_LIBRARY_FILENAMES="/nonexistent.json",
    )
    assert result.stdout.strip() == "OSMesa", result.stderr


@pytest.mark.parametrize("api", ["egl", "osmesa"])
def test_beside_vtk_both_draw_as_before(api, monkeypatch):
    monkeypatch.setenv("SURFLUX_GL", api)
    alone = render(disk(), [[1.0, 2.0, 3.0]])["radiance"]
    plotter = pyvista.Plotter(off_screen=True, window_size=(120, 90))
    plotter.add_mesh(pyvista.Sphere(), color="red")
    before = np.asarray(plotter.screenshot(return_img=True))
    np.testing.assert_array_equal(render(disk(), [[1.0, 2.0, 3.0]])["radiance"], alone)
    plotter.render()
    after = np.asarray(plotter.screenshot(return_img=True))
    plotter.close()
    assert before.std() > 10
    np.testing.assert_array_equal(before, after)
