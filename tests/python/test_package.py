"""What an installation loads, and what it says of itself: no picture library before the first picture."""

import ast
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import surflux as sf
from surflux import _core, _image

ROOT = Path(__file__).parents[2]
MAX_LIBRARIES = 12

# What a fresh process has loaded: "modules" of Python and "libraries" of the system.
LOADED = """
import sys
libraries = {line.split()[-1] for line in open("/proc/self/maps") if ".so" in line}
def loaded(name):
    return sorted(m for m in [*sys.modules, *libraries] if name in m)
"""


def said_by(code):
    done = subprocess.run([sys.executable, "-c", LOADED + code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


@pytest.mark.parametrize("name", ["OpenImageIO", "_image", "pyvista", "vtk", "tqdm", "trimesh", "libEGL", "OSMesa"])
def test_importing_brings_nothing_that_is_not_used_yet(name):
    assert said_by(f"import surflux; print(*loaded({name!r}))") == []


def test_all_public_names_come_without_pyvista_and_pictures():
    code = "import surflux as sf; [getattr(sf, n) for n in sf.__all__]; print(*loaded('pyvista'), *loaded('_image'))"
    assert said_by(code) == []


def test_the_first_picture_loads_what_reads_pictures(tmp_path):
    code = f"""
import surflux as sf
sf.write_image({str(tmp_path / "a.png")!r}, [[[0.5, 0.5, 0.5]]])
print("surflux._image" in sys.modules, sf.read_image({str(tmp_path / "a.png")!r}).shape)
"""
    assert said_by(code) == ["True", "(1,", "1,", "3)"]


def test_the_core_stands_on_few_libraries():
    listed = subprocess.run(["ldd", _core.__file__], capture_output=True, text=True, check=True).stdout.splitlines()
    names = [line.split()[0] for line in listed]
    assert "libc.so.6" in names
    assert len(names) <= MAX_LIBRARIES, names
    assert not [name for name in names if re.search("OpenImageIO|GL|OSMesa|python", name)]


def test_both_modules_have_the_same_errors(tmp_path):
    with pytest.raises(sf.FileError, match="no such file"):
        _image.read_image(str(tmp_path / "none.png"))
    with pytest.raises(ValueError, match="wanted shape"):
        _image.write_image(str(tmp_path / "a.png"), ["R", "G"], [[[1.0]]])


def test_the_version_stands_in_one_place():
    version = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
    assert _core.version() == sf.__version__ == version
    files = [
        ROOT / "CMakeLists.txt",
        ROOT / "CITATION.cff",
        *(ROOT / "python/surflux").rglob("*.py"),
        *(ROOT / "python/surflux").glob("*.pyi"),
    ]
    assert [file.name for file in files if version in file.read_text()] == []


def test_the_extra_for_all_has_every_other_one():
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    (everything,) = extras["all"]
    assert set(re.findall(r"\w+", everything)) - {"surflux"} == set(extras) - {"all", "test", "docs", "dev"}


def test_what_is_imported_is_among_the_dependencies():
    """Under the names that packages have, or by a package that cannot do without it."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    wanted = [*project["dependencies"], *(one for extra in project["optional-dependencies"].values() for one in extra)]
    declared = {re.match(r"[\w-]+", one)[0].replace("-", "_") for one in wanted}
    packages = {"PIL": "pillow", "vtkmodules": "pyvista", "pandas": "pvlib", "drjit": "mitsuba"}
    imported = set()
    for file in (ROOT / "python/surflux").rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.Import):
                imported |= {name.name.split(".")[0] for name in node.names}
            elif isinstance(node, ast.ImportFrom):
                imported.add(node.module.split(".")[0])
    missing = {packages.get(name, name) for name in imported - sys.stdlib_module_names} - declared
    assert not missing


def test_a_wheel_with_libraries_inside_lists_them(tmp_path, monkeypatch):
    from surflux._base import installation

    assert "inside" not in sf.info() or installation.LICENCES.is_dir()
    for name in ("README", "zlib-1.2.13.txt", "Embree-4.4.0.txt", "robin-map-1.2.1.txt"):
        (tmp_path / name).write_text("")
    monkeypatch.setattr(installation, "LICENCES", tmp_path)
    assert sf.info()["inside"] == "Embree 4.4.0, robin-map 1.2.1, zlib 1.2.13"
