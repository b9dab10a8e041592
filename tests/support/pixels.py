"""Pictures as arrays of bytes."""

import numpy as np


def pixels(path):
    from PIL import Image

    return np.asarray(Image.open(path).convert("RGB")).astype(int)
