"""GIF films, frame by frame: imageio and Pillow write none before they have them all."""


class GifWriter:
    """Writes frames to a file as they come; each has 256 colours of its own. It repeats itself for ever.

    Args:
        path: of the file.
        fps: frames in a second, 50 at most: the format counts hundredths of a second, and viewers take less than two
            for ten. Frames last one more or less so that the film keeps its time.
    """

    def __init__(self, path, fps):
        self._hundredths = max(2.0, 100.0 / fps)  # of a frame
        self._frames = 0
        self._file = open(path, "wb")  # noqa: SIM115 - open as long as the writer

    def append_data(self, frame):
        """frame: (h, w, 3) uint8, all of one size."""
        from PIL import GifImagePlugin, Image

        image = Image.fromarray(frame).quantize(256)
        if self._frames == 0:
            header, _ = GifImagePlugin.getheader(image, info={"loop": 0})
            self._file.write(b"".join(header))
        begin, end = (round(self._hundredths * k) for k in (self._frames, self._frames + 1))
        self._frames += 1
        data = GifImagePlugin.getdata(image, duration=10 * (end - begin), include_color_table=True)
        self._file.write(b"".join(data))

    def close(self):
        """Ends the file."""
        if not self._file.closed:
            self._file.write(b";")
            self._file.close()
