"""Guards the AR agents' states: numbering, borders, and that each agent sees only its own."""

from dataclasses import replace

import numpy as np
import pytest

from study.ar.elements import Display
from study.ar.situation import Situation
from study.ar.state_names import ROBOT_STATES, STATION_STATES
from study.ar.states import robot_states, station_states
from study.ar.thresholds import Thresholds
from study.warehouse.layout import PRESETS, build_layout

LAYOUT = build_layout(PRESETS["study"])
DEFAULTS = Thresholds()
NOTHING = Display.nothing(12, 4)


def quiet_situation() -> Situation:
    """Twelve robots far apart from the human, each alone, doing nothing of note."""
    x, y = LAYOUT.cell_center_m(0, 0)
    rows = np.linspace(20, 33, 12).astype(int)
    return Situation(
        layout=LAYOUT,
        tick=0,
        human_x_m=x,
        human_y_m=y,
        robot_x_m=np.array([0.3 + 0.6 * 45 - 3.6 * (k % 3) for k in range(12)]),
        robot_y_m=0.9 + 0.6 * rows,
        robot_state=np.zeros(12, np.int8),
        robot_carrying=np.full(12, -1, np.int8),
        robot_station=np.full(12, -1, np.int8),
        robot_remaining=np.ones(12, np.int64),
        robot_wait_s=np.zeros(12),
    )


def alone(x_m: float, y_m: float, **changes: float) -> Situation:
    """Robot 0 at a place, all others in the far corner; `changes` set robot 0's own values."""
    calm = quiet_situation()
    x, y = np.full(12, 27.3), np.full(12, 20.7)
    x[0], y[0] = x_m, y_m
    situation = replace(calm, robot_x_m=x, robot_y_m=y)
    for name, value in changes.items():
        array = getattr(situation, name).copy()
        array[0] = value
        setattr(situation, name, array)
    return situation


def name_of(situation: Situation, previous: Display = NOTHING) -> list[str]:
    return ROBOT_STATES[robot_states(situation, previous, DEFAULTS)[0]].split("/")


def test_every_state_has_its_own_name() -> None:
    """144 and 18 states, none twice, first variable counting most."""
    assert (len(set(ROBOT_STATES)), len(set(STATION_STATES))) == (144, 18)
    assert ROBOT_STATES[0] == "close/picking/few/short/few/few"
    assert ROBOT_STATES[143] == "far/dropping/many/long/many/many"
    assert ROBOT_STATES[48] == "moderate/picking/few/short/few/few"


@pytest.mark.parametrize(
    ("cells", "expected"),
    [(0, "close"), (8, "close"), (9, "moderate"), (24, "moderate"), (25, "far"), (40, "far")],
)
def test_human_state_counts_lattice_path(cells: int, expected: str) -> None:
    """Along the free bottom row: 8 cells are 4.8 m, 9 are 5.4 m, 25 are 15 m."""
    x, y = LAYOUT.cell_center_m(cells, 0)
    assert name_of(alone(x, y))[0] == expected


def test_human_state_walks_round_shelves() -> None:
    """Across a shelf the straight line is short and the path long: the path counts."""
    i, j = 5, 4  # inside the shelf whose cells are 4..6, row 4
    assert not LAYOUT.free[j, i]
    below, above = LAYOUT.cell_center_m(5, 3), LAYOUT.cell_center_m(5, 5)
    situation = replace(alone(*above), human_x_m=below[0], human_y_m=below[1])
    assert np.hypot(above[0] - below[0], above[1] - below[1]) == pytest.approx(1.2)
    far = Thresholds(close_m=3.5, far_m=15.0)
    code = robot_states(situation, NOTHING, far)[0]
    assert ROBOT_STATES[code].startswith("moderate"), "six cells round the shelf are 3.6 m"


@pytest.mark.parametrize(
    ("place", "steps"), [((1, -1), 2), ((46, 11), 46 + 11), ((1, 34), 35)], ids=str
)
def test_bays_and_homes_lie_one_step_behind_their_mouths(
    place: tuple[int, int], steps: int
) -> None:
    """The human in cell (0, 0); below, right of and above the shared grid."""
    x, y = 0.3 + 0.6 * place[0], 0.9 + 0.6 * place[1]
    length = 0.6 * steps
    below = Thresholds(close_m=0.1, far_m=length - 0.05)
    above = Thresholds(close_m=0.1, far_m=length + 0.05)
    assert ROBOT_STATES[robot_states(alone(x, y), NOTHING, below)[0]].startswith("far")
    assert ROBOT_STATES[robot_states(alone(x, y), NOTHING, above)[0]].startswith("moderate")


@pytest.mark.parametrize(
    ("field", "value", "position", "expected"),
    [
        ("robot_carrying", -1, 1, "picking"),
        ("robot_carrying", 0, 1, "dropping"),
        ("robot_remaining", 1, 2, "few"),
        ("robot_remaining", 2, 2, "many"),
        ("robot_wait_s", 9.97, 3, "short"),
        ("robot_wait_s", 10.0, 3, "medium"),
        ("robot_wait_s", 29.97, 3, "medium"),
        ("robot_wait_s", 30.0, 3, "long"),
    ],
)
def test_own_values_at_their_borders(
    field: str, value: float, position: int, expected: str
) -> None:
    """Each border belongs to the higher class."""
    assert name_of(alone(0.3, 0.9, **{field: value}))[position] == expected


@pytest.mark.parametrize(("neighbours", "expected"), [(2, "few"), (3, "many")])
def test_nearby_robots(neighbours: int, expected: str) -> None:
    """Robots within 3.5 m count, the one at 3.6 m does not, nor does the robot itself."""
    situation = alone(0.3, 0.9)
    x, y = situation.robot_x_m, situation.robot_y_m
    x[1 : neighbours + 1], y[1 : neighbours + 1] = 0.3 + 3.5, 0.9
    x[neighbours + 1], y[neighbours + 1] = 0.3 + 3.6, 0.9
    assert name_of(situation)[4] == expected


@pytest.mark.parametrize(
    ("masks", "expected"), [((7, 0), "few"), ((7, 1), "many"), ((8, 8), "few")]
)
def test_share_of_neighbours_elements(masks: tuple[int, int], expected: str) -> None:
    """More than half of the neighbours' three elements; beads are none of the three."""
    situation = alone(0.3, 0.9)
    situation.robot_x_m[1:3], situation.robot_y_m[1:3] = 1.5, 0.9
    shown = Display(bytes([7, *masks, *[7] * 9]), bytes(4))
    assert name_of(situation, shown)[5] == expected


def test_a_robot_without_neighbours_sees_few_elements() -> None:
    """No neighbour counts as few, whatever is shown elsewhere."""
    assert name_of(alone(0.3, 0.9), Display(bytes([7] * 12), bytes(4)))[4:] == ["few", "few"]


def test_station_states() -> None:
    """Longest wait and number of waiting robots at this station only."""
    situation = quiet_situation()
    situation.robot_state[:3] = 3
    situation.robot_station[:3] = (0, 0, 2)
    situation.robot_wait_s[:3] = (5.0, 31.0, 12.0)
    situation.robot_state[3], situation.robot_station[3] = 2, 1  # bound for it, not waiting
    names = [STATION_STATES[k] for k in station_states(situation, DEFAULTS)]
    assert [name.split("/")[1:] for name in names] == [
        ["long", "many"],
        ["short", "few"],
        ["medium", "many"],
        ["short", "few"],
    ]
    assert names[0].startswith("close")
    assert names[2].startswith("far")


def test_a_human_between_cells_counts_from_the_nearest_free_one() -> None:
    """A place inside a shelf (never reached in play) still has a nearest free cell."""
    x, y = LAYOUT.cell_center_m(5, 4)
    situation = replace(alone(*LAYOUT.cell_center_m(5, 3)), human_x_m=x, human_y_m=y - 0.01)
    assert name_of(situation)[0] == "close"
