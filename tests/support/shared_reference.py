"""Processor seconds of reference_irradiance, shared out: `python tests/support/shared_reference.py`."""

import surflux as sf
from surflux.bench.processes import SIZES, in_workers


def main():
    scene = sf.examples.statues()
    surfels = scene.surfels[::20]

    def traced(client):
        return sf.reference_irradiance(scene, surfels.points, surfels.normals, samples=4096, cluster=client)

    for size in SIZES:
        _, used, _ = in_workers(size, traced)
        print(f"{size} processes: {max(used):.2f} s in the busiest, {sum(used):.2f} s in all")


if __name__ == "__main__":
    main()
