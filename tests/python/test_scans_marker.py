"""What conftest.py promises about the marker `scans`, tried on made-up test files."""

from pathlib import Path

import pytest

TESTS = """
import pytest

@pytest.mark.scans
def test_reads(scans):
    assert (scans / "bunny.ply").read_text() == "ply"

@pytest.mark.scans
def test_gives_up(scans):
    if not (scans / "dragon.ply").exists():
        pytest.skip("no dragon")

def test_needs_no_scans():
    pass
"""


@pytest.fixture
def run(pytester, monkeypatch):
    pytester.makeini("[pytest]\nmarkers = scans: needs scans")
    pytester.makeconftest(Path(__file__).with_name("conftest.py").read_text())
    pytester.makepyfile(TESTS)

    def run(folder):
        if folder is None:
            monkeypatch.delenv("SURFLUX_DATA", raising=False)
        else:
            monkeypatch.setenv("SURFLUX_DATA", str(folder))
        return pytester.runpytest_inprocess("-rs")

    return run


def test_without_the_folder_they_are_skipped_with_a_reason(run):
    result = run(None)
    result.assert_outcomes(passed=1, skipped=2)
    result.stdout.fnmatch_lines(["scans: 0 run (SURFLUX_DATA is not set)", "*SKIPPED*SURFLUX_DATA is not set*"])


def test_with_the_folder_they_run_and_are_counted(run, tmp_path):
    for name in ("bunny.ply", "dragon.ply"):
        (tmp_path / name).write_text("ply")
    result = run(tmp_path)
    result.assert_outcomes(passed=3)
    result.stdout.fnmatch_lines(["scans: 2 run"])


def test_with_the_folder_a_skip_is_a_failure(run, tmp_path):
    (tmp_path / "bunny.ply").write_text("ply")
    result = run(tmp_path)
    result.assert_outcomes(passed=2, failed=1)
    result.stdout.fnmatch_lines(["*skipped although SURFLUX_DATA is set*no dragon*", "scans: 1 run*"])


def test_with_the_folder_a_missing_file_is_a_failure(run, tmp_path):
    result = run(tmp_path)
    result.assert_outcomes(passed=1, failed=2)


def test_a_folder_that_is_not_there_stops_the_run(run, tmp_path):
    result = run(tmp_path / "nowhere")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines([f"*SURFLUX_DATA names {tmp_path}/nowhere, which is not a folder*"])
