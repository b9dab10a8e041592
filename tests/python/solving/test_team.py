"""Processes that share out a pass give what one alone gives, to the last bit: threads stand for them here."""

import threading

import numpy as np
import pytest

from quick import quick
from scenes import cube_inside, room_with_a_window, surfels_of
from surflux import Environment, PointLight, Scene, Surfels, _core
from surflux.scenes import shapes

OPTIONS = {
    "zeta": 0.02,
    "insert": True,
    "max_surfels": 0,
    "tolerance": 1e-4,
    "rays": 64,
    "probes": 8,
    "shadow_rays": 32,
    "epsilon": 0.8,
    "max_memory": 0.0,
}
SOLVED = ("parents", "levels", "radiosity", "irradiance", "direct")


class Meeting:
    """Where `size` threads exchange what each gives; keeps a log of all that was exchanged."""

    def __init__(self, size):
        self.given, self.log, self.barrier = [None] * size, [], threading.Barrier(size, self._note, timeout=60)
        self.passes = set()

    def _note(self):
        self.log.append(list(self.given))

    def results(self, work):
        """[work(team) of each]; the first fault, where there are any."""
        size = len(self.given)
        results, faults = [None] * size, []

        def run(rank):
            try:
                results[rank] = work(Member(self, rank))
            except threading.BrokenBarrierError:
                pass  # another has failed
            except Exception as fault:
                faults.append(fault)
                self.barrier.abort()

        threads = [threading.Thread(target=run, args=(rank,)) for rank in range(size)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        if faults:
            raise faults[0]
        return results


class Member:
    def __init__(self, meeting, rank):
        self.meeting, self.rank, self.size, self.rounds = meeting, rank, len(meeting.given), 0

    def exchange(self, name, mine):
        self.meeting.passes.add(name)
        self.meeting.given[self.rank] = mine()
        self.meeting.barrier.wait()
        self.rounds += 1
        return self.meeting.log[self.rounds - 1]


class Replayed:
    """One of a team that goes on after a log of exchanges, alone."""

    rank, size = 0, 1

    def __init__(self, log):
        self.log, self.rounds, self.made = log, 0, 0

    def exchange(self, name, mine):
        self.rounds += 1
        if self.rounds <= len(self.log):
            return self.log[self.rounds - 1]
        self.made += 1
        return [mine()]


@pytest.fixture(scope="module")
def scene():
    """A ball in a coloured room, under a lamp, an image of the sky and a small square that glows."""
    room = cube_inside(7, [0.7, 0.5, 0.3], 0.0)
    unit = shapes.sphere(300)
    ball = surfels_of(0.2 * unit.points + np.array([0.5, 0.5, 0.4]), unit.normals, 0.6)
    sky = Environment(np.random.default_rng(0).uniform(size=(8, 16, 3)))
    square = [[0.4, 0.4, 0.9], [0.4, 0.6, 0.9], [0.6, 0.6, 0.9], [0.6, 0.4, 0.9]]
    glowing = Surfels.from_mesh((square, [[0, 1, 2, 3]]), patch_area=0.01, emission=3.0)
    return Scene([room, ball, glowing], [PointLight([0.2, 0.3, 0.8], 1.0), sky])._to_core()


def solved(scene, team=None, transport="rays", seed=5, **options):
    found = _core.solve(scene, transport=transport, seed=seed, team=team, **(OPTIONS | options))
    history = [{name: value for name, value in entry.items() if name != "seconds"} for entry in found["history"]]
    return *(found[name] for name in SOLVED), np.array(found["error"]), np.array(repr(history))


def meshless(scene, team=None):
    options = {"levels": 2, "epsilon_e": 0.04, "epsilon_omega": 0.05, "rays": 64, "bounces": -1, "tolerance": 1e-4}
    more = {"radius": 0.0, "indirect_only": True, "probes": 8, "shadow_rays": 32, "seed": 5}
    found = _core.solve_meshless(scene, **options, **more, team=team)
    return found["radiosity"], found["irradiance"], found["direct"]


def traced(scene, team=None, seed=3):
    at = np.random.default_rng(1).uniform(size=(20, 3)) * [1, 1, 0]
    return _core.reference_irradiance(scene, at, np.tile([0.0, 0, 1], (20, 1)), 256, seed, team=team)[:2]


def operated(scene, team=None, seed=3):
    found = _core.form_factor_operator(scene, 64, seed, team=team)
    return found.begin, found.met, found.scale, found.escape, found.absorbed


def by_pairs(scene, team=None):
    return solved(scene, team, transport="pairs")


def same(found, wanted):
    return all(np.array_equal(a, b) for a, b in zip(found, wanted, strict=True))


@pytest.mark.parametrize("work", quick(solved, traced, operated, of=[solved, by_pairs, traced, operated]))
def test_every_member_of_any_team_has_the_bits_of_one_alone(scene, work):
    alone = work(scene)
    for size in (1, 2, 3, 4):
        meeting = Meeting(size)
        results = meeting.results(lambda team: work(scene, team))
        assert all(same(found, alone) for found in results), size
        assert meeting.log, "nothing was shared"


@pytest.mark.slow
def test_what_many_rays_gather_is_shared_too():
    room = Scene([cube_inside(20, 0.6, 0.0)], [PointLight([0.2, 0.3, 0.8], 1.0)])._to_core()
    many = {"rays": 1024, "zeta": 1e-4, "insert": False}
    alone, meeting, few = solved(room, **many), Meeting(2), Meeting(2)
    assert all(same(found, alone) for found in meeting.results(lambda team: solved(room, team, **many)))
    assert "gathering of light" in meeting.passes
    few.results(lambda team: solved(room, team, insert=False))
    assert "gathering of light" not in few.passes  # done sooner than exchanged


@pytest.mark.parametrize("work", [solved, meshless])
def test_light_behind_a_window_is_shared_too(work):
    room = Scene([room_with_a_window(0.5, 0.6)[0]], [Environment(np.ones((8, 16, 3)))])._to_core()
    alone, meeting = work(room), Meeting(3)
    assert all(same(found, alone) for found in meeting.results(lambda team: work(room, team)))


def test_a_team_does_not_make_what_seeds_do_not(scene):
    assert not same(solved(scene, seed=5), solved(scene, seed=6))


@pytest.mark.parametrize("share", [0.0, 0.3, 0.7, 1.0])
def test_what_is_in_the_log_is_not_made_again_and_the_rest_has_the_same_bits(scene, share):
    meeting = Meeting(3)
    wanted = meeting.results(lambda team: solved(scene, team))[0]
    known = round(share * len(meeting.log))
    team = Replayed(meeting.log[:known])
    assert same(solved(scene, team), wanted)
    assert team.made == len(meeting.log) - known


@pytest.mark.parametrize("work", [solved, traced, operated])
def test_members_with_another_seed_are_refused(scene, work):
    with pytest.raises(_core.DeviceError, match="has come to other results; all must have the same scene"):
        Meeting(2).results(lambda team: work(scene, team, seed=5 + team.rank))


def test_what_an_exchange_raises_ends_the_solve(scene):
    class Failing:
        rank, size = 0, 2

        def exchange(self, name, mine):
            raise ConnectionError(f"rank 1 is gone at {name}")

    with pytest.raises(ConnectionError, match="rank 1 is gone at direct light"):
        solved(scene, Failing())


def test_what_is_raised_while_a_part_is_made_ends_the_solve(scene):
    def stop(label, done, total):
        return label != "gathering"

    with pytest.raises(_core.Cancelled):
        _core.solve(scene, transport="rays", seed=5, team=Replayed([]), progress=stop, **OPTIONS)


def test_a_rank_beyond_the_team_is_refused(scene):
    class Beyond(Replayed):
        rank = 1

    with pytest.raises(ValueError, match="team: wanted a rank below its size 1, got 1"):
        solved(scene, Beyond([]))
