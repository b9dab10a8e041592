"""LZF, the compression of binary_compressed PCD files (liblzf's format)."""


def decompressed(data, size):
    """The bytes that `data` stands for, `size` of them.

    Raises ValueError, which names the byte of `data`, where these are no such bytes.
    """
    out = bytearray()
    at, end = 0, len(data)
    try:
        while at < end:
            control = data[at]
            if control < 32:  # so many bytes and one more, as they are
                out += data[at + 1 : at + control + 2]
                at += control + 2
                continue
            length = (control >> 5) + 2  # of bytes that were there before
            if length == 9:
                at += 1
                length += data[at]
            begin = len(out) - ((control & 31) << 8) - data[at + 1] - 1
            at += 2
            if begin < 0:
                raise ValueError(f"byte {at - 1} refers to what stands before the beginning")
            piece = out[begin : begin + length]
            if len(piece) < length:  # it goes on into itself
                piece = (piece * (length // len(piece) + 1))[:length]
            out += piece
            if len(out) > size:
                break
    except IndexError:
        raise ValueError(f"ends within a reference, at byte {end}") from None
    if len(out) != size or at > end:
        raise ValueError(f"gives {'more than ' if len(out) > size else ''}{min(len(out), size)} bytes, wanted {size}")
    return out
