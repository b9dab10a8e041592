"""
Picture files. Use surflux.read_image and write_image, which check what they hand in here.
"""
from __future__ import annotations
import collections.abc
import numpy
import numpy.typing
import typing
__all__: list[str] = ['read_image', 'version', 'write_image']
def read_image(path: str) -> tuple:
    ...
def version() -> str:
    ...
def write_image(path: str, names: collections.abc.Sequence[str], pixels: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> None:
    ...
