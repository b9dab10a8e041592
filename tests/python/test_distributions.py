"""What script/distributions says when a system cannot be made; none is made here."""

import os

import pytest

from copied_script import CopiedScripts


@pytest.fixture
def run(tmp_path):
    """Runs a copy of the script in a clean checkout; `tools` are commands that do what is given, as lines of bash."""
    scripts = CopiedScripts(tmp_path)
    scripts.tool("git", "exit 0")

    def run(*arguments, **tools):
        for name, text in tools.items():
            scripts.tool(name.replace("_", "-"), text)
        environment = {**os.environ, "PATH": f"{scripts.tools}:{os.environ['PATH']}"}
        done = scripts.run("distributions", *arguments, environment=environment)
        return done.returncode, done.stdout, done.stderr

    return run


def test_an_unknown_option_is_named(run):
    assert run("--all") == (1, "", "distributions: unknown option --all (known: --keep)\n")


def test_an_unknown_system_is_named(run):
    known = "bookworm, trixie, noble, resolute"
    assert run("--keep", "sid") == (1, "", f"distributions: unknown system sid (known: {known})\n")


def test_without_root_each_system_is_named_and_nothing_succeeds(run):
    code, out, error = run(mmdebstrap="echo mmdebstrap was called")
    suites = ("bookworm", "trixie", "noble", "resolute")
    assert out == "".join(f"distributions: {suite}: no bare system without root\n" for suite in suites)
    assert error == f"distributions: failed: {', '.join(f'{suite} (not made)' for suite in suites)}\n"
    assert code == 1


def test_an_archive_that_is_not_reached_is_named(run):
    code, out, error = run("trixie", id="echo 0", apt_get="echo file:/archive", mmdebstrap="exit 25")
    assert out == "distributions: trixie: the archive of Debian 13 is not reached, or does not give it\n"
    assert (code, error) == (1, "distributions: failed: trixie (not made)\n")


def test_the_keys_of_ubuntu_come_from_debian(run):
    archive = "[ $1 = indextargets ] && echo file:/archive"
    code, out, error = run("noble", id="echo 0", apt_get=archive, mmdebstrap="echo mmdebstrap was called")
    assert "the package lists of Debian 13 cannot be read\n" in error
    assert (code, out) == (1, "")


def test_what_is_not_committed_is_said_not_to_be_tried(run):
    assert "what is not committed is not tried\n" in run("trixie", git="echo M file")[1]
