"""How a simulated participant of a rehearsal walks: to robots that it has noticed, else round.

It notices waiting robots nearby, and those that the display says something of, goes to the nearest
and otherwise from station to station. Where it gets nowhere it looks for a way round the robots.
It is there to try the server out, not to resemble people: those of `study/people` do.
"""

from __future__ import annotations

import math
import random

from server.rehearsal.sight import WAITING, Cell, Hall, Robot, Sight, next_cell

FRAMES = 8
NOTICE_M = 7.0
SERVE_M = 0.75
STUCK_M = 0.12
STUCK_LOOKS = 3
AROUND_LOOKS = 8
ROBOT_M = 0.62
WALK = 1
FULL_TURN = 65536

Frame = tuple[int, int]


class Walker:
    """One trial's walker; `look` answers each snapshot with the coming input frames."""

    def __init__(self, hall: Hall, draws: random.Random) -> None:
        self._hall = hall
        self._draws = draws
        self._station = draws.randrange(len(hall.stations))
        self._last = (math.inf, math.inf)
        self._still = 0
        self._around = 0
        self._detour: dict[Cell, int] = {}
        self.shown_robots = b""
        self.shown_stations = b""

    def look(self, sight: Sight) -> list[Frame]:
        """Keys and yaw for the next quarter of a second."""
        here = (sight.x, sight.y)
        cell = self._hall.cell_at(*here)
        robot = self._nearest_waiting(sight, cell)
        if robot is not None and math.dist(here, robot[:2]) <= SERVE_M:
            return [(0, 0)] * FRAMES
        goal = self._round(cell) if robot is None else self._hall.cell_at(robot.x, robot.y)
        field = self._hall.field_to(goal)
        self._note_progress(sight, goal)
        if self._around > 0:
            self._around -= 1
            field = self._detour
        aim = self._hall.center(next_cell(field, cell))
        return self._walk(here, aim)

    def _walk(self, here: tuple[float, float], aim: tuple[float, float]) -> list[Frame]:
        dx, dy = aim[0] - here[0], aim[1] - here[1]
        yaw = round(math.atan2(dy, dx) / math.tau * FULL_TURN) % FULL_TURN
        steps = min(FRAMES, round(math.hypot(dx, dy) / (self._hall.speed_mps / 30)))
        return [(WALK, yaw)] * steps + [(0, yaw)] * (FRAMES - steps)

    def _nearest_waiting(self, sight: Sight, cell: Cell) -> Robot | None:
        best, best_steps = None, math.inf
        for number, robot in enumerate(sight.robots):
            if robot.state != WAITING or not self._notices(number, robot, sight):
                continue
            goal = self._hall.cell_at(robot.x, robot.y)
            steps = self._hall.field_to(goal).get(cell, math.inf)
            if steps < best_steps:
                best, best_steps = robot, steps
        return best

    def _notices(self, number: int, robot: Robot, sight: Sight) -> bool:
        if math.dist((robot.x, robot.y), (sight.x, sight.y)) <= NOTICE_M:
            return True
        if number < len(self.shown_robots) and self.shown_robots[number]:
            return True
        stations = self._hall.stations
        nearest = min(range(len(stations)), key=lambda s: math.dist(stations[s], robot[:2]))
        return nearest < len(self.shown_stations) and bool(self.shown_stations[nearest])

    def _round(self, cell: Cell) -> Cell:
        """The next station on the round."""
        goal = self._hall.cell_at(*self._hall.stations[self._station])
        if self._hall.field_to(goal).get(cell, 0) <= 2:
            self._station = (self._station + 1) % len(self._hall.stations)
            goal = self._hall.cell_at(*self._hall.stations[self._station])
        return goal

    def _note_progress(self, sight: Sight, goal: Cell) -> None:
        """After some looks at the same place, plan a way round the robots; else another way."""
        here = (sight.x, sight.y)
        self._still = self._still + 1 if math.dist(here, self._last) < STUCK_M else 0
        self._last = here
        if self._still < STUCK_LOOKS:
            return
        self._still = 0
        hall, cell = self._hall, self._hall.cell_at(*here)
        blocked = {
            free
            for free in hall.free
            if any(math.dist(hall.center(free), robot[:2]) < ROBOT_M for robot in sight.robots)
        }
        detour = hall.spread(goal, hall.free - blocked | {cell})
        if cell not in detour:
            goal = self._draws.choice(sorted(hall.free - blocked))
            detour = hall.spread(goal, hall.free - blocked | {cell})
        self._detour, self._around = detour, AROUND_LOOKS
