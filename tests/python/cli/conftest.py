"""What tests of commands work with: a folder with a room and a ball, and a way to run `surflux`."""

from pathlib import Path

import pytest

from surflux.cli import commands
from surflux.scenes import shapes

ROOM = """
[[object]]
shape = "room"
patches = 6
reflectance = 0.5
[[light]]
type = "point"
position = [0.5, 0.5, 0.6]
intensity = 1.0
[camera]
eye = [0.5, -1.4, 0.5]
target = [0.5, 0.5, 0.5]
"""


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A folder to work in, without a display."""
    monkeypatch.chdir(tmp_path)
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    Path("room.toml").write_text(ROOM)
    return tmp_path


@pytest.fixture
def ball(here):
    """A cloud: 162 points on a sphere of radius 2."""
    s = shapes.sphere(162, 2.0)
    s.save("ball.ply")
    return s


@pytest.fixture
def run(capfd):
    def call(*arguments):
        status = commands.main([str(a) for a in arguments])
        return status, *capfd.readouterr()

    return call
