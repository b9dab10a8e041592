"""Processes on one machine or many that share out a pass: MPI, Dask, and what of it is kept on disk."""
