"""PNG files with a palette of at most 256 colours: pictures of the scene at a third of the size."""

from __future__ import annotations

import struct
import zlib

import numpy as np
import numpy.typing as npt

Pixels = npt.NDArray[np.uint8]
BINS = 32


def cut_palette(pixels: Pixels, colours: int) -> npt.NDArray[np.float64]:
    """Return float64[k, 3]: mean colours of boxes cut at the median along their longest side."""
    keys = pixels.reshape(-1, 3) // (256 // BINS)
    index = (keys[:, 0].astype(np.int64) * BINS + keys[:, 1]) * BINS + keys[:, 2]
    counts = np.bincount(index, minlength=BINS**3).astype(np.float64)
    used = counts.nonzero()[0]
    sums = [np.bincount(index, pixels.reshape(-1, 3)[:, c], BINS**3)[used] for c in range(3)]
    means = np.stack(sums, axis=1) / counts[used, None]
    weights = np.sqrt(counts[used])
    boxes = [np.arange(len(used))]
    while len(boxes) < colours:
        spread = [np.ptp(means[b], axis=0).max() * weights[b].sum() ** 0.5 for b in boxes]
        worst = int(np.argmax(spread))
        box = boxes.pop(worst)
        if len(box) < 2:
            boxes.append(box)
            break
        axis = int(np.ptp(means[box], axis=0).argmax())
        box = box[means[box][:, axis].argsort()]
        half = np.searchsorted(weights[box].cumsum(), weights[box].sum() / 2)
        cut = int(np.clip(half, 1, len(box) - 1))
        boxes += [box[:cut], box[cut:]]
    totals = counts[used]
    return np.array([np.average(means[b], axis=0, weights=totals[b]) for b in boxes])


def match_colours(pixels: Pixels, palette: npt.NDArray[np.float64]) -> Pixels:
    """Return uint8[h, w]: for each pixel the nearest colour of the palette."""
    flat = pixels.reshape(-1, 3)
    distinct, inverse = np.unique(flat, axis=0, return_inverse=True)
    nearest = np.empty(len(distinct), dtype=np.uint8)
    for first in range(0, len(distinct), 4096):
        part = distinct[first : first + 4096].astype(np.float64)
        gaps = ((part[:, None, :] - palette[None]) ** 2).sum(axis=2)
        nearest[first : first + 4096] = gaps.argmin(axis=1)
    matched: Pixels = nearest[inverse.ravel()].reshape(pixels.shape[:2])
    return matched


def chunk(kind: bytes, data: bytes) -> bytes:
    """Return one chunk of a PNG file."""
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def encode(pixels: Pixels, colours: int) -> bytes:
    """Return the file for uint8[h, w, 3] pixels."""
    palette = cut_palette(pixels, colours)
    matched = match_colours(pixels, palette)
    height, width = matched.shape
    rows = np.concatenate([np.zeros((height, 1), dtype=np.uint8), matched], axis=1)
    head = struct.pack(">IIBBBBB", width, height, 8, 3, 0, 0, 0)
    table = np.clip(palette.round(), 0, 255).astype(np.uint8).tobytes()
    body = zlib.compress(rows.tobytes(), 9)
    parts = (chunk(b"IHDR", head), chunk(b"PLTE", table), chunk(b"IDAT", body), chunk(b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)
