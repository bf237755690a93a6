"""The codes of status, region and certificate: number, name, meaning and colour, in one table that all others read."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum


class Status(IntEnum):
    """How the integration of a cell ended."""

    NOT_COMPUTED = 0
    TIME_OVER = 1
    ENDED_SINK = 2
    ENDED_CYCLE = 3
    DIVERGED = 4
    LEFT_DOMAIN = 5
    FRAME_DEGENERATE = 6
    FAILED = 7


class Region(IntEnum):
    """What the orbit of a cell does in the end."""

    NONE = 0
    SINK = 1
    PERIODIC = 2
    QUASI_PERIODIC = 3
    CHAOS = 4
    UNBOUNDED = 5
    SADDLE = 6
    UNDECIDED = 7


class Certificate(IntEnum):
    """What has been proved, or seen, of the end of a cell's orbit."""

    NONE = 0
    SINK = 1
    CYCLE = 2
    REST = 3


class CycleSymmetry(IntEnum):
    """How a cycle lies to the symmetries of its model."""

    NONE = 0
    SYMMETRIC = 1
    MIRRORED = 2


@dataclass(frozen=True)
class Code:
    """One value of a coded variable: its meaning for readers, its colour in figures."""

    number: int
    name: str
    meaning: str
    colour: str = "#ffffff"


def _table(enum: type[IntEnum], rows: dict[IntEnum, tuple[str, ...]]) -> tuple[Code, ...]:
    return tuple(Code(int(member), member.name.lower(), *rows[member]) for member in enum)


STATUS = _table(
    Status,
    {
        Status.NOT_COMPUTED: ("not computed yet",),
        Status.TIME_OVER: ("integrated to the end of the duration",),
        Status.ENDED_SINK: ("ended by a sink's certificate",),
        Status.ENDED_CYCLE: ("ended by a cycle's certificate",),
        Status.DIVERGED: ("left the bound of the model or overflowed",),
        Status.LEFT_DOMAIN: ("left the domain of the equations",),
        Status.FRAME_DEGENERATE: ("the tangent frame lost rank",),
        Status.FAILED: ("its tile raised an error",),
    },
)

# Blue, yellow and red are the paper's (Figure 5), in the shades of Okabe and Ito's palette, which
# colour-blind readers tell apart; a test holds the distance of all colours for them.
REGION = _table(
    Region,
    {
        Region.NONE: ("not computed", "#ffffff"),
        Region.SINK: ("sink", "#0072b2"),
        Region.PERIODIC: ("periodic", "#f0e442"),
        Region.QUASI_PERIODIC: ("quasi-periodic", "#8c466f"),
        Region.CHAOS: ("chaos", "#b5202e"),
        Region.UNBOUNDED: ("unbounded", "#000000"),
        Region.SADDLE: ("saddle", "#56b4e9"),
        Region.UNDECIDED: ("undecided", "#a6a6a6"),
    },
)

CERTIFICATE = _table(
    Certificate,
    {
        Certificate.NONE: ("nothing is proved",),
        Certificate.SINK: ("the state is in a proved neighbourhood of attraction of an equilibrium",),
        Certificate.CYCLE: ("the state is in a proved neighbourhood of attraction of a cycle",),
        Certificate.REST: ("the state sits on an equilibrium that is not proved to attract it",),
    },
)

CYCLE_SYMMETRY = _table(
    CycleSymmetry,
    {
        CycleSymmetry.NONE: ("no cycle, or a model without symmetries",),
        CycleSymmetry.SYMMETRIC: ("a symmetry maps the cycle to itself",),
        CycleSymmetry.MIRRORED: ("a symmetry maps the cycle to another one",),
    },
)
