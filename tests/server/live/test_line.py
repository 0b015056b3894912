"""Guards the direct line: however the bytes arrive, the same frames are heard, in order."""

import asyncio
import random
import struct

import pytest

from .line import HELLO, READY, Serving, pack
from .test_slow_client import mask_frame, open_raw, read_frame, started_room


def mask(opcode: int, payload: bytes, key: bytes, first: int = 0x80) -> bytes:
    masked = bytes(b ^ key[n % 4] for n, b in enumerate(payload))
    size = len(payload)
    length = bytes((0x80 | size,)) if size < 126 else b"\xfe" + struct.pack("!H", size)
    return bytes((first | opcode,)) + length + key + masked


@pytest.mark.parametrize("seed", range(3))
async def test_frames_cut_anywhere_are_heard_in_order(serving: Serving, seed: int) -> None:
    """Input, pings, a long text and a fragmented one, cut at random places of the stream."""
    draws = random.Random(seed)
    reader, writer = await open_raw(serving.port, "wide")
    room = await started_room(serving, "wide", writer)
    stream = b""
    for seq in range(1, 31):
        stream += mask(2, pack(seq, (1, 100 * seq)), draws.randbytes(4))
        if seq % 10 == 0:
            stream += mask(9, b"well?", draws.randbytes(4))
    text = b'{"type":"ping","sent_ms":7' + b" " * 150 + b"}"
    stream += mask(1, text, draws.randbytes(4))
    for seq in range(31, 41):
        stream += mask(2, pack(seq, (1, 100 * seq)), draws.randbytes(4))
    stream += mask(1, b'{"type":"ping",', draws.randbytes(4), first=0)
    stream += mask(0, b'"sent_ms":8}', draws.randbytes(4))
    while stream:
        cut = draws.randint(1, 60)
        writer.write(stream[:cut])
        stream = stream[cut:]
        await asyncio.sleep(0)
    heard: list[bytes] = []
    async with asyncio.timeout(10):
        while heard[-1:] != [b'{"type":"pong","sent_ms":8.0}']:
            opcode, payload = await read_frame(reader)
            if opcode == 10 or b'"pong"' in payload:
                heard.append(payload)
        while room.world.human_yaw != 4000:  # noqa: ASYNC110 - a room has no event
            await asyncio.sleep(0.01)
    writer.close()
    assert heard == [b"well?"] * 3 + [
        b'{"type":"pong","sent_ms":7.0}',
        b'{"type":"pong","sent_ms":8.0}',
    ]


async def test_nothing_is_heard_after_a_close(serving: Serving) -> None:
    """Frames behind the client's close frame, in the same packet, move nobody."""
    _, writer = await open_raw(serving.port, "wide")
    room = await started_room(serving, "wide", writer)
    writer.write(mask_frame(8, struct.pack("!H", 1000)) + mask_frame(2, pack(1, (0, 4000))))
    async with asyncio.timeout(10):
        while room.is_joined:  # noqa: ASYNC110
            await asyncio.sleep(0.01)
    writer.close()
    assert room.world.human_yaw == 0


async def test_an_unmasked_frame_is_refused(serving: Serving) -> None:
    reader, writer = await open_raw(serving.port, "t-1")
    writer.write(mask_frame(1, HELLO.encode()) + bytes((0x81, len(READY))) + READY.encode())
    async with asyncio.timeout(10):
        while True:
            opcode, payload = await read_frame(reader)
            if opcode == 8:
                break
    writer.close()
    assert payload[:2] == struct.pack("!H", 1002)
