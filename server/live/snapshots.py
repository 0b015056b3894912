"""The binary snapshot, encoded into a buffer that each room allocates once.

u8 2, u8 flags (bit 0: a robot stopped the human), u32 tick, u16 acknowledged sequence number mod
65536, u16 human x, u16 human y in 1/512 m, u16 human yaw, then per robot u16 x, u16 y, u8 heading
in 256ths of a turn, u8 state (bits 0-2 RobotState, bits 3-5 carried colour + 1).
"""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING

import numpy as np

from server.live.wire import SNAPSHOT

if TYPE_CHECKING:
    from study.warehouse.world import World

PER_M = 512
HEAD = struct.Struct("<BBIHHHH")
ROBOT = np.dtype([("x", "<u2"), ("y", "<u2"), ("heading", "u1"), ("state", "u1")], align=False)


class SnapshotEncoder:
    """Turns one world's present state into bytes, some microseconds for a dozen robots."""

    def __init__(self, world: World) -> None:
        robots = len(world.robot_x_m)
        self._world = world
        self._buffer = bytearray(HEAD.size + ROBOT.itemsize * robots)
        records = np.frombuffer(self._buffer, ROBOT, robots, HEAD.size)
        self._x, self._y = records["x"], records["y"]
        self._heading, self._state = records["heading"], records["state"]
        self._scratch = np.empty(robots)

    def encode(self, acknowledged_seq: int) -> bytes:
        """The snapshot of now."""
        world, scratch = self._world, self._scratch
        HEAD.pack_into(
            self._buffer,
            0,
            SNAPSHOT,
            world.human_stopped,
            world.tick,
            acknowledged_seq & 0xFFFF,
            round(world.human_x_m * PER_M),
            round(world.human_y_m * PER_M),
            world.human_yaw,
        )
        np.multiply(world.robot_x_m, PER_M, scratch)
        np.rint(scratch, scratch)
        self._x[...] = scratch
        np.multiply(world.robot_y_m, PER_M, scratch)
        np.rint(scratch, scratch)
        self._y[...] = scratch
        np.right_shift(world.robot_heading, 8, out=self._heading, casting="unsafe")
        np.left_shift(world.robot_carrying + 1, 3, out=self._state, casting="unsafe")
        self._state |= world.robot_state.view(np.uint8)
        return bytes(self._buffer)
