"""What script/wheel and script/try_wheel say when something is missing; nothing is fetched, compiled or tried here."""

import os

import pytest

from copied_script import CopiedScripts


@pytest.fixture
def run(tmp_path):
    """Runs a copy of a script as an ordinary user, where dpkg knows all packages but `missing`."""
    scripts = CopiedScripts(tmp_path)
    scripts.tool("mmdebstrap", "echo mmdebstrap was called; exit 1")

    def run(name, *arguments, missing=(), **environment):
        environment = {**os.environ, "PATH": f"{scripts.tools}:{os.environ['PATH']}", **environment}
        done = scripts.run(name, *arguments, missing=missing, environment=environment)
        return done.returncode, done.stdout, done.stderr

    return run


def test_an_unknown_option_is_named(run):
    assert run("wheel", "--tests") == (1, "", "wheel: unknown option --tests (known: --test)\n")


def test_without_root_the_apt_line_is_printed(run):
    apt = "apt-get update && apt-get install -y --no-install-recommends libopenexr-dev robin-map-dev"
    said = f"wheel: system packages are missing. As root, run:\n  {apt}\n"
    assert run("wheel", missing=("robin-map-dev", "libopenexr-dev")) == (1, "", said)


@pytest.mark.parametrize("python", ["/nowhere/python3", "true"])
def test_an_interpreter_that_cannot_be_used_is_named(run, python):
    said = f"wheel: PYTHON: {python} does not run, is no CPython from 3.11 on, or has no headers\n"
    assert run("wheel", PYTHON=python) == (1, "", said)


def test_there_is_nothing_to_try_before_a_wheel_is_built(run):
    assert run("try_wheel") == (1, "", "try: script/wheel builds the wheels first\n")


def test_an_unknown_system_is_named(run, tmp_path):
    (tmp_path / "build-wheel").mkdir()
    (tmp_path / "build-wheel" / "interpreters").write_text("3.11 /usr/bin/python3\n")
    said = "try: unknown system sid (known: bookworm, trixie, noble, resolute, venv)\n"
    assert run("try_wheel", "sid") == (1, "", said)
