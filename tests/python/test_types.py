"""Type checkers know what is public: everything is annotated, and mypy --strict takes and refuses what it should."""

import inspect
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import surflux as sf

ROOT = Path(__file__).parents[2]
PROGRAMS = ROOT / "tests" / "support" / "typed"


def public():
    """(name, function) of all that users call or read: functions, methods with those of operators, and properties."""
    for name in sf.__all__:
        item = getattr(sf, name)
        if inspect.isfunction(item):
            yield name, item
        elif inspect.ismodule(item):
            yield from ((f"{name}.{inner}", getattr(item, inner)) for inner in item.__all__)
        elif item.__module__.startswith("surflux."):
            for member, value in vars(item).items():
                value = getattr(value, "__func__", value)
                for function in (value.fget, value.fset) if isinstance(value, property) else (value,):
                    hidden = member.startswith("_") and not member.startswith("__")
                    if inspect.isfunction(function) and not hidden and written_here(function):
                        yield f"{name}.{member}", function


def written_here(function):
    """Whether it is of a file of the package: what a dataclass makes is not."""
    return Path(inspect.unwrap(function).__code__.co_filename).is_relative_to(Path(sf.__file__).parent)


FUNCTIONS = list(public())


@pytest.mark.parametrize(("name", "function"), FUNCTIONS, ids=[name for name, _ in FUNCTIONS])
def test_what_is_public_is_annotated(name, function):
    signature = inspect.signature(function)
    bare = [p.name for p in signature.parameters.values() if p.annotation is p.empty and p.name not in ("self", "cls")]
    assert bare == []
    assert signature.return_annotation is not signature.empty


def test_methods_and_properties_are_among_them():
    assert {"solve", "Surfels.__init__", "Surfels.areas", "Surfels.thinned", "Camera.eye", "Camera.fit"} <= {
        name for name, _ in FUNCTIONS
    }


@pytest.fixture(scope="module")
def complaints(tmp_path_factory):
    """{program: {line: what mypy says of it}} of both programs."""
    names = ("uses.py", "misuses.py")
    command = [sys.executable, "-m", "mypy", "--strict", "--no-error-summary", "--hide-error-context", *names]
    cache = tmp_path_factory.mktemp("mypy")
    done = subprocess.run([*command, f"--cache-dir={cache}"], cwd=PROGRAMS, capture_output=True, text=True, check=False)
    assert done.stderr == ""
    found = {name: {} for name in names}
    for name, line, said in re.findall(r"^(\w+\.py):(\d+): error: (.*)$", done.stdout, re.MULTILINE):
        found[name].setdefault(int(line), []).append(said)
    return found


@pytest.mark.slow
def test_mypy_takes_a_program_that_uses_everything(complaints):
    assert complaints["uses.py"] == {}
    text = (PROGRAMS / "uses.py").read_text()
    assert [name for name in sf.__all__ if not re.search(rf"\bsf\.{name}\b", text)] == []


@pytest.mark.slow
def test_mypy_refuses_wrong_arguments(complaints):
    lines = (PROGRAMS / "misuses.py").read_text().splitlines()
    assert sorted(complaints["misuses.py"]) == [k for k, line in enumerate(lines, 1) if line.endswith("# refused")]


@pytest.fixture
def elsewhere(tmp_path):
    """A copy of script/stub and of the stubs that it looks after."""
    (tmp_path / "script").mkdir()
    (tmp_path / "python" / "surflux").mkdir(parents=True)
    shutil.copy(ROOT / "script" / "stub", tmp_path / "script")
    for stub in ("_core.pyi", "_image.pyi"):
        shutil.copy(ROOT / "python" / "surflux" / stub, tmp_path / "python" / "surflux")
    return tmp_path


def stub(folder, *options):
    command = [sys.executable, folder / "script" / "stub", *options]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.mark.slow
def test_the_stubs_are_those_of_the_build():
    assert stub(ROOT, "--check").stderr == ""


@pytest.mark.slow
def test_a_stub_of_another_build_is_seen_and_written_anew(elsewhere):
    file = elsewhere / "python" / "surflux" / "_core.pyi"
    right = file.read_text()
    file.write_text(right.replace("def compile_scene(", "def compiled_scene("))
    done = stub(elsewhere, "--check")
    assert (done.returncode, done.stderr.partition(":")[0]) == (1, "stub")
    assert "_core.pyi is not what the installed module makes" in done.stderr
    assert stub(elsewhere).returncode == 0
    assert file.read_text() == right
