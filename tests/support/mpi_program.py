"""What tests/python/cluster/test_mpi.py runs in several processes: `mpirun -n N python mpi_program.py FOLDER`.

Process 0 prints, as JSON: whether all processes have the bits of one alone, and what each was told of what went wrong.
"""

import json
import sys
from pathlib import Path

import numpy as np
from mpi4py import MPI

sys.path.insert(0, str(Path(__file__).parents[1]))
import surflux as sf
from scenes import cube_inside
from surflux.cluster import mpi
from surflux.scenes import shapes

COMM = MPI.COMM_WORLD
KNOBS = {"zeta": 0.05, "rays": 64, "probes": 8, "transport": "rays", "seed": 3}


def room(patches=7, **solve_options):
    """A cube from inside, so many patches along each edge."""
    walls = cube_inside(patches, [0.7, 0.5, 0.3], 0.0)
    return sf.Scene([walls], [sf.PointLight([0.2, 0.3, 0.8], 1.0)], solve_options=solve_options)


def solved(scene, **given):
    found = sf.solve(scene, **{**KNOBS, **given})
    return found.irradiance, found.direct, found.parents, np.array(found.error)


def asked(scene, **given):
    found = sf.solve(scene, error=0.05, transport="rays", **given)
    return found.irradiance, np.array([entry["error"] for entry in found.attempts])


def operated(scene, **given):
    operator = sf.form_factor_operator(scene, rays=64, **given)
    return operator @ np.arange(operator.shape[0]), operator.escape


def traced(scene, **given):
    at = np.random.default_rng(1).uniform(size=(9, 3)) * [1, 1, 0]
    return sf.reference_irradiance(scene, at, np.tile([0.0, 0, 1], (9, 1)), 64, **given)


def meshless(scene, **given):
    found = sf.solve_meshless(scene, levels=3, rays=64, probes=8, shadow_rays=16, **given)
    at = scene.surfels.points[::20], scene.surfels.normals[::20]
    return found.irradiance, np.array(found.error), found.irradiance_at(*at)


def cloud(_, **given):
    """From inside, with a lamp at its wall: of points, the levels of a basis repeat."""
    ball = shapes.sphere(800)
    scene = sf.Scene([sf.Surfels(ball.points, -ball.normals, reflectance=0.5)], [sf.PointLight([0, 0, -0.95], 1.0)])
    return *meshless(scene, **given), *local(scene, **given)


def local(scene, **given):
    transfer = sf.precompute_transfer(scene, levels=3, rays=64, senders=300, **given)
    return transfer.indirect(scene.lights), np.array([transfer.nbytes, transfer.left_out])


def distant(scene, **given):
    opened = sf.Scene([scene.surfels[scene.surfels.normals[:, 2] > -0.5]])  # without its ceiling
    transfer = sf.precompute_transfer(opened, "distant", levels=3, rays=64, senders=300, **given)
    return (transfer.relight(sf.Environment(np.linspace(0, 1, 32 * 16 * 3).reshape(16, 32, 3))).irradiance,)


def sky(scene, **given):
    opened = sf.Scene([scene.surfels[scene.surfels.normals[:, 2] > -0.5]])
    transfer = sf.precompute_transfer(opened, "sky", levels=3, rays=64, senders=300, **given)
    return (transfer.relight(np.linspace(0.0, 1.0, 146)).irradiance,)


def same(found, wanted):
    return all(np.array_equal(a, b) for a, b in zip(found, wanted, strict=True))


def bits(folder):
    """{what: whether all have the bits of one alone}."""
    scene, found = room(), {}
    for work in (solved, asked, operated, traced, meshless, cloud, local, distant, sky):
        alone = work(scene)
        mpi.CHUNK = 1 << 30
        found[work.__name__] = same(work(scene, cluster=COMM), alone)
        if work not in (solved, traced):
            continue
        mpi.CHUNK = 1000  # some hundred calls of MPI for one exchange
        found[f"{work.__name__}, in chunks"] = same(work(scene, cluster=COMM), alone)
    alone = solved(scene)
    for what in ("kept", "known"):
        found[what] = same(solved(scene, cluster=COMM, checkpoint=folder), alone)
    alone = meshless(scene), local(scene)
    for what in ("meshless and transfer kept", "meshless and transfer known"):
        again = [work(scene, cluster=COMM, checkpoint=f"{folder}-{work.__name__}") for work in (meshless, local)]
        found[what] = all(map(same, again, alone))
    return {name: all(COMM.allgather(value)) for name, value in found.items()}


def told(work):
    """What each process is told; all of them go on."""
    try:
        work()
    except Exception as fault:
        text = f"{type(fault).__name__}: {fault}"
    else:
        text = "nothing"
    return COMM.allgather(text)


def faults(folder):
    rank, scene = COMM.Get_rank(), room()

    def cancelled():
        rounds = []

        def goes_on(done, total):
            rounds.append(done)
            return rank != 1 or len(rounds) < 5

        sf.solve(scene, **KNOBS, cluster=COMM, progress=goes_on)

    def elsewhere():
        if rank == 0:
            sf.solve(scene, **KNOBS, cluster=COMM)
        else:
            traced(scene, cluster=COMM)

    def one_less():
        if rank == 0:
            with mpi.Members(COMM):
                pass
        else:
            solved(scene, cluster=COMM)

    def damaged():
        file = f"{folder}/call-0/00002.exchange"
        if rank == 0:
            with open(file, "r+b") as out:
                out.seek(100)
                out.write(b"!")
        solved(scene, cluster=COMM, checkpoint=folder)

    def without_memory():
        empty = np.empty

        def lacks(*shape, **kind):
            raise MemoryError("there is no room")

        with mpi.Members(COMM) as members:
            try:
                if rank == 1:
                    np.empty = lacks
                members.exchange("rows", b"a" * 1000)
            finally:
                np.empty = empty

    def other_version():
        told = mpi.machine_facts
        if rank == 1:
            mpi.machine_facts = lambda: {**told(), "version of surflux": "0.0.1"}
        try:
            solved(scene, cluster=COMM)
        finally:
            mpi.machine_facts = told

    return {
        "option": told(lambda: sf.solve(scene, **{**KNOBS, "zeta": 0.05 + 0.01 * rank}, cluster=COMM)),
        "scene": told(lambda: solved(room(7 if rank == 0 else 6), cluster=COMM)),
        "argument": told(lambda: sf.solve(scene, **{**KNOBS, "zeta": 1.0 - 2.0 * rank}, cluster=COMM)),
        "no scene": told(lambda: sf.solve(scene if rank == 0 else None, cluster=COMM)),
        "seconds": told(lambda: sf.solve(scene, seconds=1.0, cluster=COMM)),
        "seconds of a scene": told(lambda: sf.solve(room(seconds=1.0), cluster=COMM)),
        "cancelled": told(cancelled),
        "elsewhere": told(elsewhere),
        "one call less": told(one_less),
        "damaged": told(damaged),
        "version": told(other_version),
        "memory": told(without_memory),
        "after all that": told(lambda: sf.solve(scene, **KNOBS, cluster=COMM)),
    }


if __name__ == "__main__":
    answer = {"bits": bits(sys.argv[1])}
    if COMM.Get_size() == 2:
        answer["faults"] = faults(sys.argv[1])
    if COMM.Get_rank() == 0:
        print(json.dumps(answer))
