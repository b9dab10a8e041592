"""The source tree keeps the rules of the house, and each rule can be broken."""

from pathlib import Path

import pytest

import house

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("rule", house.RULES, ids=lambda rule: rule.__name__)
def test_the_house_is_in_order(rule):
    assert list(rule(ROOT)) == []


def test_the_rules_see_the_house():
    assert {house.room_of(path) for path in house.sources(ROOT, "cpp/surflux")} <= set(house.FLOORS)
    assert len(list(house.sources(ROOT, "cpp/surflux"))) > 10
    assert {m.partition(".")[0] for m in house.python_modules(ROOT)} == {"", "__main__", *house.ROOMS}
    assert len(list(house.python_imports(ROOT))) > 100


# A small house in order; every breach below is one file more, or one file otherwise.
SOUND = {
    "cpp/surflux/core/vec.h": "#include <cmath>\n",
    "cpp/surflux/core/parallel.cpp": "#include <oneapi/tbb/parallel_for.h>\n",
    "cpp/surflux/image/image.h": '#include "surflux/core/vec.h"\n',
    "cpp/surflux/gl/functions.h": "#include <GL/glcorearb.h>\n",
    "cpp/surflux/gl/egl.cpp": "#include <EGL/egl.h>\n#include <dlfcn.h>\n",
    "cpp/surflux/trace/embree_api.h": "#include <embree4/rtcore.h>\n",
    "cpp/surflux/trace/tracer.h": '#include "surflux/core/vec.h"\n',
    "cpp/surflux/trace/tracer.cpp": '#include "surflux/trace/embree_api.h"\n#include "surflux/trace/tracer.h"\n',
    "cpp/surflux/area/atlas.h": '#include "surflux/gl/functions.h"\n#include <Eigen/Core>\n',
    "cpp/surflux/radiosity/solver.cpp": '#include "surflux/trace/tracer.h"\n',
    "bindings/convert.h": '#include <pybind11/numpy.h>\n#include "surflux/core/vec.h"\n',
    "bindings/area.cpp": '#include "convert.h"\n#include "surflux/area/atlas.h"\n',
    "python/surflux/__init__.py": "from surflux._base.check import number\n",
    "python/surflux/__main__.py": "from surflux.cli.commands import main\n",
    "python/surflux/_base/__init__.py": "",
    "python/surflux/_base/check.py": "import math\nfrom surflux import _core\n",
    "python/surflux/_base/passes.py": "from . import check\n",
    "python/surflux/drawing/plots.py": "from surflux._base.check import number\n",
    "python/surflux/points/surfels.py": (
        "from surflux import _core\nfrom surflux._base import check\n\n"
        "def plot(s):\n    from surflux.drawing import plots\n    return plots.plot(s)\n"
    ),
    "python/surflux/cli/commands.py": "import surflux as sf\n",
}


def complaints(folder):
    return [complaint for rule in house.RULES for complaint in rule(folder)]


def build(folder, files):
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)


def test_a_sound_house_has_no_complaints(tmp_path):
    build(tmp_path, SOUND)
    assert complaints(tmp_path) == []


@pytest.mark.parametrize(
    ("name", "text", "complaint"),
    [
        ("core/a.cpp", '#include "surflux/trace/tracer.h"', "a.cpp:1: core includes surflux/trace/tracer.h, which sta"),
        ("lights/a.h", '\n#include "surflux/area/atlas.h"', "a.h:2: lights includes surflux/area/atlas.h, which stand"),
        ("radiosity/a.h", '#include "surflux/area/atlas.h"', "a.h:1: radiosity and area do not see each other"),
        (
            "render/a.cpp",
            '#include "surflux/image/image.h"',
            "render includes surflux/image/image.h: image is no",
        ),
        ("attic/a.cpp", "", "cpp/surflux/attic/a.cpp: not in one of the rooms render, "),
        ("a.cpp", "", "cpp/surflux/a.cpp: not in one of the rooms render, "),
        ("trace/a.cpp", '#include "tracer.h"', 'a.cpp:1: "tracer.h" is no header of the house'),
        ("trace/a.cpp", '#include "surflux/core/none.h"', 'a.cpp:1: "surflux/core/none.h" is no header of the house'),
        ("trace/a.cpp", "#include <surflux/core/vec.h>", "a.cpp:1: <surflux/core/vec.h> is ours"),
        ("../../bindings/a.cpp", '#include "../cpp/surflux/core/vec.h"', 'a.cpp:1: "../cpp/surflux/core/vec.h" is no'),
        ("area/a.cpp", "#include <embree3/rtcore.h>", "<embree3/rtcore.h> belongs in cpp/surflux/trace/ alone"),
        ("area/a.cpp", "#include <flann/flann.hpp>", "<flann/flann.hpp> belongs in cpp/surflux/neighbors/ alone"),
        ("area/a.cpp", "#include <OpenImageIO/imageio.h>", "belongs in cpp/surflux/image/ alone"),
        ("area/a.cpp", "#  include  <GL/glcorearb.h>", "<GL/glcorearb.h> belongs in cpp/surflux/gl/ alone"),
        ("core/a.cpp", "#include <tbb/task_arena.h>", "belongs in cpp/surflux/core/parallel.cpp alone"),
        ("core/a.cpp", "#include <pybind11/numpy.h>", "<pybind11/numpy.h> belongs in bindings/ alone"),
        ("core/a.cpp", "#include <boost/any.hpp>", "<boost/any.hpp> belongs to a library without a room"),
        ("trace/tracer.h", '#include "surflux/trace/embree_api.h"', "radiosity/solver.cpp: sees <embree4/rtcore.h>"),
        ("gl/functions.h", "#include <EGL/egl.h>", "bindings/area.cpp: sees <EGL/egl.h> through cpp/surflux/gl/func"),
        ("core/long.cpp", "\n" * 401, "cpp/surflux/core/long.cpp: 401 lines, perhaps two ideas (at most 400)"),
        ("core/a.cpp", f"\n// {house.OPEN_WORDS[0]}: later", "cpp/surflux/core/a.cpp:2: left open: "),
        ("core/a.cpp", f"int a;  // {house.OPEN_WORDS[1]}", "cpp/surflux/core/a.cpp:1: left open: "),
    ],
)
def test_a_breach_in_the_core_is_seen(tmp_path, name, text, complaint):
    build(tmp_path, {**SOUND, f"cpp/surflux/{name}": text})
    assert any(complaint in found for found in complaints(tmp_path)), complaints(tmp_path)


@pytest.mark.parametrize(
    ("name", "text", "complaint"),
    [
        ("_base/check", "from surflux.points.surfels import S", "check.py:1: _base imports points.surfels, which stan"),
        (
            "_base/check",
            "def f():\n    from surflux.points import surfels",
            "check.py:2: _base imports points.surfels, w",
        ),
        (
            "_base/check",
            "from ..points.surfels import Surfels",
            "check.py:1: _base imports points.surfels, which stands",
        ),
        ("_base/check", "from .. import Surfels", "check.py:1: imports the face, which stands above everything but"),
        ("_base/check", "def f():\n    import surflux", "check.py:2: imports the face, which stands above everything"),
        (
            "_base/check",
            "from surflux._base import passes",
            "in a circle, or what is in one: _base.check, _base.passes",
        ),
        ("_base/check", "try:\n    from .passes import stop\nexcept ImportError:\n    pass", "in a circle, or what is"),
        (
            "points/surfels",
            "from surflux.cli.commands import main",
            "surfels.py:1: points imports cli.commands, which st",
        ),
        ("attic/box", "", "python/surflux/attic/box.py: not in one of the rooms cli, "),
        ("box", "", "python/surflux/box.py: not in one of the rooms cli, "),
        ("points/deep/box", "", "python/surflux/points/deep/box.py: not in one of the rooms cli, "),
    ],
)
def test_a_breach_in_python_is_seen(tmp_path, name, text, complaint):
    build(tmp_path, {**SOUND, f"python/surflux/{name}.py": text})
    assert any(complaint in found for found in complaints(tmp_path)), complaints(tmp_path)
