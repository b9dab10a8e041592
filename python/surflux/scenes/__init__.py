"""Scenes: objects, lights, options of a solve, shapes, and the files that say all this."""
