"""What script/setup and the build say when something is missing; nothing is installed or compiled here."""

import shutil
import subprocess
import sys

import pytest

from copied_script import ROOT, CopiedScripts


@pytest.fixture
def setup(tmp_path):
    """Runs a copy of script/setup as an ordinary user without sudo, where dpkg knows all packages but `missing`."""
    scripts = CopiedScripts(tmp_path)
    for name in ("dirname", "grep"):
        (scripts.tools / name).symlink_to(shutil.which(name))

    def run(*arguments, missing=(), python="true", **environment):
        scripts.tool("python3", python)
        environment["PATH"] = str(scripts.tools)
        return scripts.run("setup", *arguments, missing=missing, environment=environment)

    return run


def test_without_root_and_sudo_it_prints_the_apt_line_and_stops(setup):
    result = setup(missing=("libflann-dev", "ninja-build"))
    assert result.returncode == 1
    assert result.stdout == ""
    assert result.stderr == (
        "setup: system packages are missing, and there is neither root nor sudo here. As root, run:\n"
        "  apt-get update && apt-get install -y --no-install-recommends ninja-build libflann-dev\n"
    )


def test_debians_python_gets_debians_headers(setup):
    headers = ("python3-venv", "python3-dev")
    assert setup(missing=headers, python="echo /usr").stderr.endswith(" python3-venv python3-dev\n")
    result = setup(missing=headers, python='[[ "$2" = *base_prefix* ]] && echo /opt/python || echo has no soul')
    assert result.stderr == "setup: python3 has no soul; PYTHON=... names another interpreter\n"


def with_first(line):
    """A Python that runs `line` before the code handed to it, in a stub for python3."""
    return f"exec '{sys.executable}' -c 'import sys; {line}; exec(sys.argv[1])' \"$2\""


def test_an_old_python_is_refused_by_its_version(setup):
    result = setup(python=with_first("sys.version_info = (3, 10, 2)"))
    assert result.returncode == 1
    message = "setup: python3 is version 3.10, wanted 3.11 or newer; PYTHON=... names another interpreter\n"
    assert result.stderr == message


def test_a_python_without_headers_or_venv_is_refused(setup):
    no_headers = "import sysconfig; sysconfig.get_paths = lambda: dict(include=sys.prefix)"
    assert "python3 has no headers (Debian: python3-dev);" in setup(python=with_first(no_headers)).stderr
    no_venv = "import importlib.util; importlib.util.find_spec = lambda name: None; import os; os.path.exists = bool"
    assert "python3 has no venv (Debian: python3-venv);" in setup(python=with_first(no_venv)).stderr


def test_a_python_that_is_not_there_is_named(setup):
    result = setup(PYTHON="/nowhere/python3")
    assert result.returncode == 1
    assert result.stderr == "setup: PYTHON names /nowhere/python3, which is not there\n"


def test_an_unknown_option_is_named(setup):
    result = setup("--tests")
    assert result.returncode == 1
    assert result.stderr == "setup: unknown option --tests (known: --test, --docs, --dev)\n"


def configure(build, *settings):
    command = ["cmake", "-G", "Ninja", "-S", ROOT, "-B", build, "-DSURFLUX_BUILD_PYTHON=OFF", *settings]
    return subprocess.run(command, capture_output=True, text=True)


def test_the_build_names_a_missing_library_and_its_package(tmp_path):
    result = configure(tmp_path, "-DCMAKE_DISABLE_FIND_PACKAGE_embree=ON")
    assert result.returncode != 0
    assert "surflux needs what was not found here: Embree 4 or 3." in result.stderr
    assert "sudo apt-get install libembree-dev\n" in result.stderr
    assert result.stderr.count("CMake Error") == 1


def test_the_build_names_all_missing_libraries_at_once(tmp_path):
    missing = [f"-DCMAKE_DISABLE_FIND_PACKAGE_{name}=ON" for name in ("TBB", "Eigen3", "flann", "GTest")]
    missing += ["-DSURFLUX_OIIOTOOL=", "-DSURFLUX_EGL_HEADERS=", "-DSURFLUX_GL_HEADERS=", "-DSURFLUX_BUILD_TESTS=ON"]
    result = configure(tmp_path, *missing)
    assert (
        "sudo apt-get install libtbb-dev libeigen3-dev libembree-dev libflann-dev libopenimageio-dev "
        "openimageio-tools libegl-dev libgl-dev libgtest-dev\n"
    ) in result.stderr
    assert result.stderr.count("CMake Error") == 1
