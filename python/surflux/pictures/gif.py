"""GIF films, frame by frame: imageio and Pillow write none before they have them all."""


class GifWriter:
    """Writes frames to a file as they come; each has 256 colours of its own. It repeats itself for ever.

    Args:
        path: of the file.
        fps: frames in a second; the format counts hundredths of a second, at least one.
    """

    def __init__(self, path, fps):
        self._milliseconds = 10 * max(1, round(100.0 / fps))
        self._begun = False
        self._file = open(path, "wb")  # noqa: SIM115 - open as long as the writer

    def append_data(self, frame):
        """frame: (h, w, 3) uint8, all of one size."""
        from PIL import GifImagePlugin, Image

        image = Image.fromarray(frame).quantize(256)
        if not self._begun:
            self._begun = True
            header, _ = GifImagePlugin.getheader(image, info={"loop": 0})
            self._file.write(b"".join(header))
        data = GifImagePlugin.getdata(image, duration=self._milliseconds, include_color_table=True)
        self._file.write(b"".join(data))

    def close(self):
        """Ends the file."""
        if not self._file.closed:
            self._file.write(b";")
            self._file.close()
