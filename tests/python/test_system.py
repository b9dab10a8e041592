"""What the system may do to a process: full disks, forks, little memory, Ctrl-C, several threads."""

import contextlib
import os
import resource
import signal
import subprocess
import sys
import textwrap
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import surflux as sf
from surflux import _core

SMALL_FILE = 4096  # bytes, all that the disk has room for


def run_apart(code, seconds=120, **options):
    """Runs Python code in a process of its own, which is ended where it hangs; gives its stdout."""
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(code)], capture_output=True, text=True, timeout=seconds, **options
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@contextlib.contextmanager
def full_disk():
    """No file grows beyond SMALL_FILE: writes fail as they do on a full disk, those of pytest's report as well."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    ignored = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (SMALL_FILE, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, ignored)


def write_small(path, points=1):
    if path.suffix == ".ply":
        sf.Surfels(np.arange(3.0 * points).reshape(-1, 3), [[0, 0, 1]] * points, radii=1.0).save(path)
    else:
        sf.write_image(path, np.random.default_rng(0).uniform(size=(points, 3, 3)))


@pytest.mark.parametrize("name", ["a.png", "a.exr", "a.hdr", "a.ply"])
def test_a_full_disk_is_told_and_keeps_the_old_file(name, tmp_path):
    path = tmp_path / name
    write_small(path)
    path.chmod(0o640)
    before = path.read_bytes()
    # Noise of 3 x 2000 pixels does not fit, however packed: 18000 bytes in 8 bits.
    with full_disk(), pytest.raises(sf.FileError, match=rf"a\{path.suffix}: cannot be written"):
        write_small(path, 2000)
    assert path.read_bytes() == before
    assert os.listdir(tmp_path) == [name]
    write_small(path, 2)
    assert path.stat().st_mode & 0o777 == 0o640


FORK = """
    import os, signal, sys
    import numpy as np
    import surflux as sf

    def solved(solve=sf.solve):
        walls = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]), 1 / 400)
        lid = sf.Surfels.from_mesh(([[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], [[3, 2, 1, 0]]), 1 / 400)
        return solve(sf.Scene([walls, lid], [sf.PointLight((0.5, 0.5, 0.5), 10)]))

    def pixels(solution):
        return solution.render(sf.Camera((0.5, 0.5, 0.9), (0.5, 0.5, 0), up=(0, 1, 0)), size=(32, 32))

    def in_a_fork(work):
        sys.stdout.flush()
        child = os.fork()
        if child == 0:
            signal.alarm(60)  # the end of a child that hangs
            try:
                print(work())
            except sf.DeviceError as error:
                print(error)
            finally:
                sys.stdout.flush()
                os._exit(0)
        assert os.waitpid(child, 0)[1] == 0
"""


def test_drawing_in_a_process_forked_after_drawing_is_refused():
    said = run_apart(
        FORK
        + """
    solution = solved()
    in_a_fork(lambda: pixels(solution).shape)  # nothing was drawn before: the fork may
    pixels(solution)
    in_a_fork(lambda: pixels(solution).shape)
    print(pixels(solution).shape)
    """
    ).splitlines()
    assert said[0] == said[2] == "(32, 32, 3)"
    assert "after that drew by OpenGL" in said[1]
    assert '"spawn"' in said[1]


@pytest.mark.slow
def test_solving_in_a_process_forked_after_solving_gives_the_same():
    said = run_apart(
        FORK
        + """
    for solve in sf.solve, sf.solve_meshless:
        before = solved(solve).radiosity
        in_a_fork(lambda: np.array_equal(solved(solve).radiosity, before))
    """
    )
    assert said.split() == ["True", "True"]


def test_two_threads_solve_at_once_each_by_its_own_limit():
    floor = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]), 1 / 400)
    lid = sf.Surfels.from_mesh(([[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], [[3, 2, 1, 0]]), 1 / 400)
    scene = sf.Scene([floor, lid], [sf.PointLight((0.5, 0.5, 0.5), 10)])
    alone = sf.solve(scene, transport="rays").radiosity
    limits = (1, 4, None, 2, 3)
    with ThreadPoolExecutor(max_workers=len(limits)) as pool:
        found = list(pool.map(lambda threads: sf.solve(scene, transport="rays", threads=threads), limits))
    for solution in found:
        np.testing.assert_array_equal(solution.radiosity, alone)


LIMITED = """
    import resource
    import surflux as sf
    from surflux import _core

    disk = sf.Surfels([[0, 0, 0]], [[0, 0, 1]], radii=1.0, areas=1.0)
    scene = sf.Scene([disk], [sf.PointLight((0, 0, 1), 1)])
    with open("/proc/self/statm") as file:
        used = int(file.read().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + {left} * 10**6, resource.RLIM_INFINITY))
    try:
        {work}
    except (sf.DeviceError, ValueError, MemoryError) as error:
        print(error)
"""


def test_too_little_memory_is_what_the_error_says():
    said = [run_apart(LIMITED.format(left=left, work="sf.solve(scene)")) for left in (20, 40)]
    assert not any("this processor" in text for text in said)
    assert any("Embree: no device could be made for want of memory: this process has" in text for text in said)


def test_the_memory_that_a_limit_leaves_bounds_the_surfels_of_all_pairs():
    assert run_apart(LIMITED.format(left=400, work="_core.require_memory_for_pairs(8000, 0.0)")) == ""
    said = run_apart(LIMITED.format(left=400, work="_core.require_memory_for_pairs(10000, 0.0)"))
    assert "needs 0.4 GB" in said  # 4 n^2 bytes, of three quarters of what is left


def ticks_during(work):
    """How often another Python thread came to run in the middle of work(): 0 where that held the GIL throughout."""
    ticks, ended = [], threading.Event()

    def tick():
        while not ended.wait(0.001):
            ticks.append(time.perf_counter())

    other = threading.Thread(target=tick)
    other.start()
    begin = time.perf_counter()
    work()
    end = time.perf_counter()
    ended.set()
    other.join()
    margin = 0.1 * (end - begin)  # where arguments and results are converted
    return sum(begin + margin < at < end - margin for at in ticks)


@pytest.fixture(scope="module")
def many():
    rng = np.random.default_rng(0)
    n = 400_000
    return sf.Surfels(rng.uniform(size=(n, 3)), rng.normal(size=(n, 3)), radii=0.001, areas=1e-6)


@pytest.mark.parametrize("name", ["select", "two_sided", "with_areas", "Scene", "Field"])
@pytest.mark.slow
def test_other_python_threads_run_while_the_core_works(name, many):
    core, n = many._core, len(many)
    again = np.random.default_rng(1).integers(0, n, 8 * n).astype(np.uint32)  # all out of order, and many times
    larger = core.select(again)
    work = {
        "select": lambda: core.select(again),
        "two_sided": larger.two_sided,
        "with_areas": lambda: larger.with_areas(np.ones(8 * n)),
        "Scene": lambda: _core.Scene([larger], []),
        "Field": lambda: _core.Field(core, np.zeros(n, np.uint32), [], None, None),
    }[name]
    assert ticks_during(work) >= 3


def test_areas_that_are_set_are_not_those_of_what_was_made_before(many):
    s = many[:10]
    core = s._core
    s.areas = 2.0
    assert (core.areas == 1e-6).all()
    assert (s.areas == 2.0).all()


@pytest.mark.parametrize(
    ("before", "key"),
    [
        ('name = "' + "a." * 500 + '" # ' + "a." * 500, ".".join("a" * 200_000) + " = 1"),
        ('name = """\n' + "a." * 500 + '"""', "[" + " . ".join(['"a.b"'] * 5000) + "]"),
    ],
)
def test_a_toml_key_of_very_many_parts_is_refused_before_it_is_parsed(before, key, tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(f"{before}\n{key}\n")
    line = before.count("\n") + 2
    with pytest.raises(sf.FileError, match=rf"scene\.toml \(line {line}\): a key of more than 100 parts"):
        sf.load_scene(path)
    path.write_text(before + "\n" + ".".join("a" * 100) + " = 1\n")
    with pytest.raises(sf.FileError, match="object"):  # read, and found to hold none
        sf.load_scene(path)


def test_ctrl_c_reaches_the_threads_that_load_a_scene(tmp_path):
    said = run_apart(
        """
        import os, signal, threading, time
        import numpy as np
        import surflux as sf
        from surflux import _core

        rng = np.random.default_rng(0)
        points = rng.normal(size=(30_000, 3))
        points /= np.linalg.norm(points, axis=1, keepdims=True)
        columns = [(name, "float", points[:, k]) for k, name in enumerate("xyz")]
        _core.write_ply("cloud.ply", [("vertex", len(points), columns)], None, [])
        with open("scene.toml", "w") as file:
            file.write('[[object]]\\nfile = "cloud.ply"\\n' * 2)

        begin = time.perf_counter()
        sf.load_scene("scene.toml")
        whole = time.perf_counter() - begin
        begin = time.perf_counter()
        threading.Timer(0.2 * whole, os.kill, (os.getpid(), signal.SIGINT)).start()
        try:
            sf.load_scene("scene.toml")
        except KeyboardInterrupt:
            print((time.perf_counter() - begin) / whole)
        """,
        cwd=tmp_path,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    assert float(said) < 0.6  # 1 where the threads work on to the end of what they have begun
