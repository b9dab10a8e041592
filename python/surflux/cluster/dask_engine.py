"""Workers of a Dask cluster as the processes that share a pass out."""

from pathlib import Path

from surflux._base.check import counted
from surflux._base.passes import LOG
from surflux.cluster.agreement import call_facts
from surflux.cluster.checkpoint import Checkpoint
from surflux.cluster.dask_job import Job, MemoryLog, living_workers, require_same_facts
from surflux.scenes.scene_arrays import scene_arrays


class DaskEngine:
    """Every worker that there is when a call begins is one process; this one sends the scene and hands exchanges on.

    client: distributed.Client, of no event loop of the caller's. folder: of a checkpoint, or None.
    """

    is_alone = False

    def __init__(self, client, folder=None):
        if client.asynchronous:
            raise ValueError("cluster: wanted a Dask client with asynchronous=False")
        self._client, self._folder, self._calls = client, folder, 0

    def call(self, program, scene, arguments, progress):
        """program(compiled scene, arguments, team, progress), a function of a module, in each worker.

        Raises:
            ValueError: a worker has another surflux, or another kind of processor than the first.
            DeviceError: no worker is left, a process was lost again and again, or has failed.
            FileError: the checkpoint is damaged, of another call, or cannot be written.
        """
        facts = None
        while facts is None:
            workers = living_workers(self._client)
            facts = require_same_facts(self._client, workers)
        log = MemoryLog()
        if self._folder is not None:
            # Of the workers, on which the bits depend.
            log = Checkpoint(
                Path(self._folder) / f"call-{self._calls}", {**call_facts(program, scene, arguments), **facts}
            )
        self._calls += 1
        LOG.info("%s, in workers of %s", counted(len(workers), "process", "processes"), self._client.scheduler.address)
        return Job(self._client, log, progress).run(program, scene_arrays(scene), arguments, workers)
