"""Processor seconds of reference_irradiance, shared out: `python tests/support/shared_reference.py`."""

import numpy as np

import surflux as sf
from surflux.bench.processes import SIZES, _usage


def main():
    from distributed import Client, LocalCluster

    scene = sf.examples.statues()
    surfels = scene.surfels[::20]
    for size in SIZES:
        options = {"n_workers": size, "threads_per_worker": 1, "dashboard_address": None, "memory_limit": None}
        with LocalCluster(**options) as cluster, Client(cluster) as client:
            client.run(_usage)  # imports surflux
            before = client.run(_usage)
            sf.reference_irradiance(scene, surfels.points, surfels.normals, samples=4096, cluster=client)
            used = [seconds - before[worker][0] for worker, (seconds, _) in client.run(_usage).items()]
        print(f"{size} processes: {max(used):.2f} s in the busiest, {np.sum(used):.2f} s in all")


if __name__ == "__main__":
    main()
