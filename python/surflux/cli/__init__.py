"""The command `surflux`."""
