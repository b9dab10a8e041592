"""The public names and their arguments, which scripts outside this repository rely on."""

import inspect
import pickle
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import surflux as sf

# Callable by its path in surflux -> what it must at least take, in this order, with these defaults; more may follow.
SIGNATURES = {
    "Surfels": "(points, normals=None, *, radii=None, areas=None, reflectance=None, emission=0.0, viewpoint=None)",
    "Surfels.from_mesh": "(mesh, patch_area=None, reflectance=None, emission=None)",
    "Surfels.sample_mesh": "(mesh, n, seed=0, reflectance=None, emission=None)",
    "Surfels.thinned": "(self, n, seed=0)",
    "Surfels.save": "(self, path)",
    "read": "(path, format=None, reflectance=None, emission=0.0, viewpoint=None)",
    "effective_areas": "(s, *, kappa=3.0, resolution=32, epsilon=0.8, backend='auto', threads=None)",
    "form_factors": "(scene, visibility=True)",
    "Scene": "(objects, lights=())",
    "PointLight": "(position, intensity)",
    "SpotLight": "(position, direction, intensity, cone=45.0, penumbra=5.0)",
    "AreaLight": "(corner, edge_u, edge_v, exitance)",
    "DirectionalLight": "(direction, irradiance)",
    "Environment": "(image_or_rgb=None, up=(0.0, 0.0, 1.0))",
    "load_scene": "(path)",
    "solve": "(scene, *, tolerance=0.0001, seed=0, progress=False, threads=None)",
    "solve_meshless": "(scene, *, levels=6, radius=None, epsilon_e=0.04, epsilon_omega=0.314, rays=512, bounces=None, "
    "seed=0, progress=False)",
    "Solution.render": "(self, camera, size=(800, 600))",
    "Solution.save": "(self, path)",
    "load_solution": "(path)",
    "Camera": "(eye, target, up=(0.0, 0.0, 1.0), fov=45.0)",
    "write_image": "(path, image, **layers)",
    "info": "()",
}
MEMBERS = {
    "surfels": "points normals radii areas reflectance emission plot to_pyvista",
    "scene": "surfels",
    "solution": "surfels radiosity irradiance direct parents error timings history render plot save",
}


def resolve(path):
    item = sf
    for name in path.split("."):
        item = getattr(item, name)
    return item


@pytest.mark.parametrize("path", SIGNATURES)
def test_signature(path):
    scope = {}
    exec(f"def wanted{SIGNATURES[path]}: pass", scope)
    wanted = inspect.signature(scope["wanted"]).parameters
    got = inspect.signature(resolve(path)).parameters
    positional = [p.name for p in got.values() if p.kind == p.POSITIONAL_OR_KEYWORD]
    assert positional[: len(wanted)] == [p.name for p in wanted.values() if p.kind == p.POSITIONAL_OR_KEYWORD]
    for name, parameter in wanted.items():
        assert got[name].kind == parameter.kind, name
        assert parameter.default in (parameter.empty, got[name].default), name


def test_editors_read_all_names():
    """__init__.pyi, which type checkers read in place of __init__.py, has every name from where it lives."""
    text = Path(sf.__file__).with_name("__init__.pyi").read_text()
    found = {
        name: home for home, name in re.findall(r"^from surflux\.([\w.]+) import (\w+) as \2$", text, re.MULTILINE)
    }
    assert found == sf._HOME | dict.fromkeys(("Cancelled", "DeviceError", "FileError"), "_core")


@pytest.mark.parametrize("error", [sf.FileError, sf.Cancelled, sf.DeviceError])
def test_errors_have_the_names_that_users_write(error):
    assert error.__module__ == "surflux"
    same = pickle.loads(pickle.dumps(error("why")))
    assert (type(same), same.args) == (error, ("why",))


@pytest.fixture(scope="module")
def solved():
    """A floor and a ceiling under a lamp, solved, by the names in MEMBERS."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    floor = sf.Surfels.from_mesh((corners, [[0, 1, 2, 3]]), patch_area=0.25)
    ceiling = sf.Surfels.from_mesh((corners + np.array([0, 0, 1]), [[3, 2, 1, 0]]), patch_area=0.25)
    scene = sf.Scene([floor, ceiling], lights=[sf.PointLight([0.5, 0.5, 0.9], 1.0)])
    return {"surfels": floor, "scene": scene, "solution": sf.solve(scene)}


@pytest.mark.parametrize("name", MEMBERS)
def test_members(name, solved):
    assert {*MEMBERS[name].split()} <= {*dir(solved[name])}


def test_errors_are_the_usual_ones_too():
    assert issubclass(sf.FileError, OSError)
    assert issubclass(sf.DeviceError, RuntimeError)
    assert issubclass(sf.Cancelled, Exception)


def test_all_names_are_there():
    assert {path for path in SIGNATURES if "." not in path} <= {*sf.__all__}
    assert all(hasattr(sf, name) for name in sf.__all__)
    assert {*sf.__all__} <= {*dir(sf)}
    assert "import_module" not in dir(sf)
    from surflux.pictures import images

    assert sf.tone_map is images.tone_map


@pytest.mark.parametrize("name", ["FileError", "Cancelled", "DeviceError"])
def test_exceptions_say_what_they_are(name):
    error = getattr(sf, name)
    assert len(error.__doc__) > 40
    assert error.__doc__ != error.__base__.__doc__


@pytest.mark.parametrize("name", ["PointLight", "SpotLight", "AreaLight", "DirectionalLight", "Environment", "solve"])
def test_help_tells_what_is_raised(name):
    assert "ValueError: " in inspect.getdoc(getattr(sf, name)).partition("Raises:")[2]


def test_an_unknown_name_is_refused():
    with pytest.raises(AttributeError, match=r"surflux.*no attribute 'raytrace'"):
        _ = sf.raytrace


def test_importing_surflux_is_light():
    """pyvista takes a second to import: only what draws or reads meshes pays for it."""
    heavy = "{'pyvista', 'vtkmodules', 'matplotlib', 'trimesh', 'tqdm'} & {*sys.modules}"
    code = f"import sys, surflux; surflux.Surfels, surflux.solve, surflux.load_scene; print({heavy})"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout == "set()\n"
