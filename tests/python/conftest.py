"""The marker `scans`: tests that read real scans from the folder that SURFLUX_DATA names.

Without SURFLUX_DATA they are skipped; with it nothing excuses a skip, so that a missing file cannot pass unseen.

The option `--seconds=N`: no test begins later than that; how many were left over is said at the end.
"""

import os
import signal
import time
from pathlib import Path

import pytest

SCANS_RUN = []  # by this process, or by all its workers


BEGAN = []  # when each test did
NO_TIME_LEFT = "no time left (--seconds)"


def pytest_addoption(parser):
    parser.addoption("--seconds", type=float, help="begin no test later than so many seconds after the first")


def pytest_configure(config):
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # a shell's job in the background; tests press Ctrl-C
        signal.signal(signal.SIGINT, signal.default_int_handler)
    folder = os.environ.get("SURFLUX_DATA")
    if folder and not Path(folder).is_dir():
        raise pytest.UsageError(f"SURFLUX_DATA names {folder}, which is not a folder")


def pytest_collection_modifyitems(items):
    if not os.environ.get("SURFLUX_DATA"):
        for item in items:
            if item.get_closest_marker("scans"):
                item.add_marker(pytest.mark.skip(reason="SURFLUX_DATA is not set"))


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item):
    limit = item.config.getoption("seconds")
    BEGAN.append(time.monotonic())
    if limit is not None and BEGAN[-1] - BEGAN[0] > limit:
        pytest.skip(NO_TIME_LEFT)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    report = yield
    if item.config.getoption("seconds") is None and item.get_closest_marker("scans") and os.environ.get("SURFLUX_DATA"):
        if report.skipped and not hasattr(report, "wasxfail"):
            report.outcome = "failed"
            report.longrepr = f"{item.nodeid}: skipped although SURFLUX_DATA is set ({call.excinfo.value})"
        elif report.when == "call":
            report.user_properties.append(("scans", "run"))
    return report


def pytest_runtest_logreport(report):
    if ("scans", "run") in [tuple(p) for p in report.user_properties] and report.when == "call":
        SCANS_RUN.append(report.nodeid)


def pytest_terminal_summary(terminalreporter):
    note = "" if os.environ.get("SURFLUX_DATA") else " (SURFLUX_DATA is not set)"
    terminalreporter.write_line(f"scans: {len(SCANS_RUN)} run{note}")
    left = sum(NO_TIME_LEFT in str(report.longrepr) for report in terminalreporter.stats.get("skipped", ()))
    if left:
        terminalreporter.write_line(f"left over for want of time: {left} tests, which script/test --all runs")


@pytest.fixture(scope="session")
def scans():
    """The folder that SURFLUX_DATA names; only for tests marked `scans`."""
    return Path(os.environ["SURFLUX_DATA"])


@pytest.fixture(scope="session")
def browser(tmp_path_factory):
    """A page in headless Chromium. Where CI is set, one that is missing is a failure."""
    from browser import Browser, chromium

    if chromium() is None:
        reason = "there is no chromium (Debian: apt-get install chromium)"
        pytest.fail(reason) if os.environ.get("CI") else pytest.skip(reason)
    with Browser(tmp_path_factory.mktemp("browser", numbered=True)) as page:
        yield page
