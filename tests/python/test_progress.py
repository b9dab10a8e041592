"""Threads and progress: every long call takes both by name, tells how far it is, and stops for False alone."""

import inspect
import logging
import re
import sys
import threading

import numpy as np
import pytest

import surflux as sf
from surflux import _core
from surflux._base import passes

BALL = np.random.default_rng(0).normal(size=(400, 3))
BALL /= np.linalg.norm(BALL, axis=1, keepdims=True)
SQUARE = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]
WALL = [[0.3, 0, 0], [0.3, 1, 0], [0.3, 1, 1], [0.3, 0, 1]], [[0, 1, 2, 3]]
STAGES = ["normals", "facing", "radii"]  # of Surfels(points)
SIGNATURES = [
    sf.Surfels,
    sf.Surfels.from_mesh,
    sf.Surfels.sample_mesh,
    sf.Surfels.thinned,
    sf.Solution.irradiance_at,
    sf.Solution.render,
    sf.build_hierarchy,
    sf.divide_patches,
    sf.effective_areas,
    sf.facing,
    sf.form_factor_operator,
    sf.form_factors,
    sf.inward_patches,
    sf.load_scene,
    sf.read,
    sf.reference_irradiance,
    sf.reference_radiance,
    sf.sky_view_factor,
    sf.solar_irradiation,
    sf.solve,
    sf.solve_meshless,
]


@pytest.fixture(scope="module")
def calls(tmp_path_factory):
    """What is long in each of the calls that make surfels, as function of threads and progress -> array."""
    folder = tmp_path_factory.mktemp("long")
    columns = [(name, "float", BALL[:, k]) for k, name in enumerate("xyz")]
    _core.write_ply(folder / "ball.ply", [("vertex", len(BALL), columns)], None, [])
    (folder / "balls.toml").write_text('[[object]]\nfile = "ball.ply"\n[[object]]\nshape = "sphere"\npoints = 400\n')
    ball = sf.Surfels(BALL, BALL)
    scene = sf.Scene([ball], [sf.PointLight([0, 0, 3], 1)])
    return {
        "Surfels": lambda **o: sf.Surfels(BALL, **o).radii,
        "from_mesh": lambda **o: sf.Surfels.from_mesh(_joined(SQUARE, WALL), **o).areas,
        "sample_mesh": lambda **o: sf.Surfels.sample_mesh(SQUARE, 50, **o).points,
        "thinned": lambda **o: ball.thinned(100, **o).points,
        "read": lambda **o: sf.read(folder / "ball.ply", **o).normals,
        "load_scene": lambda **o: sf.load_scene(folder / "balls.toml", **o).surfels.radii,
        "reference": lambda **o: sf.reference_irradiance(scene, [[0, 0, 1]], [[0, 0, 1]], 16, **o)[0],
        "effective_areas": lambda **o: sf.effective_areas(ball, **o),
        "sky_view_factor": lambda **o: sf.sky_view_factor(ball, rays=16, **o),
    }


LONG = ("Surfels", "from_mesh", "sample_mesh", "thinned", "read", "load_scene", "reference", "effective_areas")
LONG += ("sky_view_factor",)


def _joined(a, b):
    return [*a[0], *b[0]], [*a[1], *(np.add(b[1], len(a[0])).tolist())]


@pytest.mark.parametrize("call", SIGNATURES, ids=lambda call: call.__qualname__)
def test_threads_and_progress_are_taken_by_name_alone(call):
    parameters = inspect.signature(call).parameters
    for name, default in (("threads", None), ("progress", False)):
        assert parameters[name].kind is inspect.Parameter.KEYWORD_ONLY
        assert parameters[name].default is default


@pytest.mark.parametrize("name", LONG)
def test_every_long_call_tells_how_far_it_is_and_stops_for_false(calls, name, monkeypatch):
    monkeypatch.setattr(passes, "_POLL", 1e-4)  # what threads do is looked at more often than a test takes
    told = []
    found = calls[name](progress=lambda *at: told.append(at))  # None goes on
    assert told or name == "load_scene"  # which may be done before it is looked at, and has a test of its own
    assert all(0 <= done <= total for done, total in told)
    np.testing.assert_array_equal(calls[name](threads=1), found)
    np.testing.assert_array_equal(calls[name](threads=3, progress=lambda *_: 0), found)
    if name == "load_scene":
        return
    asked = []
    with pytest.raises(sf.Cancelled):
        calls[name](progress=lambda *at: bool(asked.append(at)))
    assert len(asked) == 1


def test_making_patches_tells_each_of_its_steps_and_stops_at_any():
    triangles = SQUARE[0], [[0, 1, 2], [0, 2, 3]]
    told, mesh = [], _joined(triangles, WALL)
    sf.Surfels.from_mesh(mesh, progress=lambda *at: told.append(at))
    steps = [(done, 7) for done in range(8)]  # before the walls are asked, of which there may be none
    assert told[:8] == steps
    for last in range(8):
        asked = []
        with pytest.raises(sf.Cancelled):
            sf.Surfels.from_mesh(mesh, progress=lambda *at, asked=asked, last=last: asked.append(at) or at[0] < last)
        assert asked == steps[: last + 1]


def test_inward_patches_can_be_stopped_before_any_ray():
    # Rays report 2 witnesses each, a front and a back: totals that neither neighbours nor the spanning tree have.
    told = []
    ball = sf.Surfels(BALL, BALL)
    sf.inward_patches(ball, progress=lambda *at: told.append(at))
    totals = list(dict.fromkeys(total for _, total in told))
    assert totals[0] == len(BALL)  # their neighbours
    assert totals[-1] == 2 * min(len(BALL), 2000)
    assert totals[1] > 6 * len(BALL)  # edges of the neighbour graph: the spanning tree
    rays = sf.inward_patches(ball, rooms=True, progress=lambda *at: told.append(at))  # which asks no ray
    assert not rays.any()
    with pytest.raises(sf.Cancelled):
        sf.inward_patches(ball, rooms=True, progress=lambda *_: False)


@pytest.mark.parametrize("name", LONG)
def test_threads_and_progress_are_checked_by_every_long_call(calls, name):
    with pytest.raises(ValueError, match=r"^threads: wanted a whole number"):
        calls[name](threads=1.5)
    with pytest.raises(ValueError, match=r"^progress: wanted True or False"):
        calls[name](progress=1)


@pytest.mark.parametrize("answer", [None, 0, 0.0, "", [], True, np.True_, np.zeros(2)], ids=repr)
def test_all_but_false_goes_on_in_the_core_and_in_python(answer):
    passes.report(lambda *_: answer, 0, 1)
    _core.estimate_normals(BALL, 8, None, progress=lambda *_: answer)


@pytest.mark.parametrize("answer", [False, np.False_], ids=repr)
def test_false_cancels_in_the_core_and_in_python(answer):
    with pytest.raises(sf.Cancelled):
        passes.report(lambda *_: answer, 0, 1)
    with pytest.raises(sf.Cancelled):
        _core.estimate_normals(BALL, 8, None, progress=lambda *_: answer)


def test_jobs_in_threads_report_on_the_thread_that_called_and_all_stop(monkeypatch):
    monkeypatch.setattr(passes, "_POLL", 1e-3)
    ended, both_ended, at_work, asked = [], threading.Semaphore(0), threading.Barrier(2), []

    def job():
        at_work.wait(60)
        try:
            for k in range(10**9):
                passes.report(passes.stage("steps"), k, 10**9)
        finally:
            ended.append(threading.get_ident())
            both_ended.release()

    def stop(done, total):
        asked.append((threading.get_ident(), total))
        return len(asked) < 3

    with pytest.raises(sf.Cancelled), passes.watched(None, stop):
        passes.in_threads([job, job, job], ["one", "two", "three"])
    assert asked == [(threading.get_ident(), 10**9)] * 3
    assert both_ended.acquire(timeout=60)
    assert both_ended.acquire(timeout=60)
    assert len(ended) == 2  # the third one was never begun
    assert threading.get_ident() not in ended


def test_who_cancels_jobs_in_threads_does_not_wait_for_them(monkeypatch):
    """Some steps, such as building an index of all points, take seconds and cannot be asked."""
    monkeypatch.setattr(passes, "_POLL", 1e-3)
    go_on = threading.Event()

    def job():
        passes.report(passes.stage("steps"), 0, 1)
        assert go_on.wait(60)

    try:
        with pytest.raises(sf.Cancelled), passes.watched(None, lambda *_: False):
            passes.in_threads([job, job], ["one", "two"])
        assert not go_on.is_set()
    finally:
        go_on.set()


def test_a_job_that_fails_is_told_before_others_have_ended():
    go_on = threading.Event()

    def fails():
        raise sf.FileError("one: is not there")

    try:
        with pytest.raises(sf.FileError, match="is not there"):
            passes.in_threads([fails, lambda: go_on.wait(60)], ["one", "two"])
        assert not go_on.is_set()
    finally:
        go_on.set()


@pytest.mark.parametrize("threads", [1, 2, 3, 8])
def test_jobs_in_threads_keep_to_the_limit_of_all(threads, monkeypatch):
    limits, at_once, most = [], set(), []

    class Limit:
        def __init__(self, count):
            limits.append(count)

    def job():
        at_once.add(threading.get_ident())
        most.append(len(at_once))
        at_once.discard(threading.get_ident())

    monkeypatch.setattr(_core, "ThreadLimit", Limit)
    passes.in_threads([job] * 4, "abcd", threads=threads)
    assert len(limits) == 4
    assert max(most) * max(limits) <= threads


def test_where_there_is_no_terminal_stages_are_logged(caplog, monkeypatch):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: False)
    with caplog.at_level(logging.INFO, "surflux"):
        sf.Surfels(BALL, progress=True)
    told = [(record.name, record.message) for record in caplog.records]
    assert told.pop(2)[1].startswith("points: estimated normals face outwards")  # taken for granted, and no progress
    assert told == [("surflux", "normals"), ("surflux", "facing"), ("surflux", "radii")]


def test_a_stage_that_comes_again_is_logged_once(caplog, monkeypatch):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: False)
    with caplog.at_level(logging.INFO, "surflux"), passes.stage_callback(True) as show:
        for label in ("gathering", "solve", "gathering", "solve"):
            assert show(label, 1, 2)
    assert [record.message for record in caplog.records] == ["gathering", "solve"]


@pytest.fixture
def clock(monkeypatch):
    """A clock that tests set: seconds."""
    now = [100.0]
    monkeypatch.setattr(passes, "monotonic", lambda: now[0])
    return now


def lines_of(caplog, clock, steps):
    """What a stage says whose callback is asked at (second, done, total)."""
    caplog.set_level(logging.INFO, "surflux")
    lines, begun = passes.ProgressLines("gathering"), clock[0]
    for second, done, total in steps:
        clock[0] = begun + second
        assert lines(done, total)
    return [record.message for record in caplog.records]


def test_a_stage_of_a_minute_tells_how_far_it_is_and_what_is_left(caplog, clock):
    # 128 steps of half a second: a sixteenth is done each 4 s, which is too early, and too little, for another line.
    steps = [(0.5 * k, k, 128) for k in range(129)]
    assert lines_of(caplog, clock, steps) == [
        "gathering",
        "gathering: 10 %, about 58 s left",  # of 13 steps: 10.2 %
        "gathering: 20 %, about 51 s left",
        "gathering: 30 %, about 44 s left",
        "gathering: 41 %, about 38 s left",
        "gathering: 51 %, about 32 s left",
        "gathering: 61 %, about 25 s left",
        "gathering: 71 %, about 18 s left",
        "gathering: 81 %, about 12 s left",
        "gathering: 91 %, about 6 s left",
    ]


def test_a_stage_of_hours_tells_it_every_half_minute_and_what_is_left_once_that_is_known(caplog, clock):
    lines = lines_of(caplog, clock, [(k, k, 10_000) for k in range(301)])
    assert lines == [
        "gathering",
        *(f"gathering: {k / 100:.0f} %" for k in range(30, 200, 30)),
        *(f"gathering: {k / 100:.0f} %, about {(10_000 - k) / 3600:.1f} h left" for k in range(210, 301, 30)),
    ]


def test_a_stage_of_unknown_length_tells_how_much_is_done(caplog, clock):
    steps = [(k, 1000 * k, 0) for k in range(61)]
    assert lines_of(caplog, clock, steps) == ["gathering", "gathering: 30000 so far", "gathering: 60000 so far"]


def test_a_stage_of_seconds_is_its_name_alone(caplog, clock):
    assert lines_of(caplog, clock, [(0.1 * k, k, 50) for k in range(50)]) == ["gathering"]


@pytest.mark.parametrize(
    ("seconds", "text"), [(0.2, "0 s"), (99.4, "99 s"), (99.6, "2 min"), (5969, "99 min"), (7200, "2.0 h")]
)
def test_durations_are_as_fine_as_anybody_needs(seconds, text):
    assert passes.duration(seconds) == text


def test_stages_tell_their_seconds_to_who_asks_for_them(caplog, monkeypatch):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: False)
    with caplog.at_level(logging.DEBUG, "surflux"):
        sf.Surfels(BALL, progress=True)
    told = [re.sub(r"[\d.]+ s$", "N s", record.message) for record in caplog.records]
    assert told.pop(3).startswith("points: estimated normals face outwards")
    assert told == [line for label in STAGES for line in (label, f"{label}: N s")]


@pytest.mark.parametrize("terminal", [True, False])
def test_nothing_is_shown_where_no_progress_is_wanted(caplog, monkeypatch, capfd, terminal):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: terminal)
    with caplog.at_level(logging.DEBUG, "surflux"), passes.without_progress():
        sf.Surfels(BALL, progress=True)
        told = []
        sf.Surfels(BALL, progress=lambda *at: told.append(at))  # a callback is asked all the same
    assert [record for record in caplog.records if "estimated normals face" not in record.message] == []
    assert capfd.readouterr().err == ""
    assert told


def test_bars_are_those_of_tqdm_auto(monkeypatch):
    """Which are widgets in a notebook."""
    import tqdm.auto

    bars = []

    class Bar(tqdm.auto.tqdm):
        def __init__(self, *args, **kwargs):
            bars.append(kwargs["desc"])
            super().__init__(*args, **kwargs)

    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    monkeypatch.setattr(tqdm.auto, "tqdm", Bar)
    sf.Surfels(BALL, progress=True)
    assert bars == STAGES
