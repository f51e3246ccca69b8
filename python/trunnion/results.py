"""What the verbs give back: typed values over the command's documents.

Each result has the keys of its ``--json`` document as attributes, and :meth:`Result.to_dict` is that document whole: keys that have no
attribute here are there all the same. Lengths are mm, areas mm2, volumes mm3, angles degrees, times seconds, directions lists of three in
the model file's frame, unless a name says otherwise.
"""

from __future__ import annotations

import dataclasses
import functools
import json
import os
import types
import typing
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Optional

__all__ = [
    "Apart", "Finding", "Inspection", "Interface", "Minimum", "ObjectiveResult", "Orientation", "OrientedPart", "Part", "Plan", "Planned",
    "Plane", "Prepared", "Print", "Report", "Slicer", "Slot", "Split",
]  # fmt: skip

Vector = list[float]


@functools.cache
def _hints(kind: type) -> dict[str, Any]:
    return typing.get_type_hints(kind)


def _value(hint: Any, value: Any) -> Any:
    """`value` of a document as the type of `hint`; lists of records and optional ones too."""
    if value is None:
        return None
    origin, inner = typing.get_origin(hint), typing.get_args(hint)
    if origin is list:
        return [_value(inner[0], one) for one in value]
    if origin in (typing.Union, types.UnionType):
        return _value(next(one for one in inner if one is not type(None)), value)
    if dataclasses.is_dataclass(hint):
        return _record(typing.cast(type, hint), value)
    return value


def _record(kind: type, document: dict[str, Any], **more: Any) -> Any:
    wanted = [one for one in dataclasses.fields(kind) if one.name in document and one.name not in more]
    hints = _hints(kind)
    return kind(**{one.name: _value(hints[one.name], document[one.name]) for one in wanted}, **more)


@dataclass(frozen=True)
class Result:
    """A result with the document that it was read from."""

    _text: str = field(repr=False, compare=False, kw_only=True, default="{}")

    @classmethod
    def of(cls, text: str, **more: Any) -> Any:
        """The result whose document is `text`."""
        return _record(cls, json.loads(text), _text=text, **more)

    def to_json(self) -> str:
        """The command's ``--json`` document to the byte, without the line's end."""
        return self._text

    def to_dict(self) -> dict[str, Any]:
        """The command's ``--json`` document."""
        return json.loads(self._text)


@dataclass(frozen=True)
class Part:
    """A closed part: its number, facets, volume, area and box (two corners)."""

    id: int
    name: str
    facets: int
    closed: bool
    volume_mm3: float
    area_mm2: float
    box_mm: list[Vector]


@dataclass(frozen=True)
class Interface:
    """The surface that parts `a` and `b` share; its normal looks from `a` to `b`."""

    a: int
    b: int
    area_mm2: float
    normal: Vector


@dataclass(frozen=True)
class Apart:
    """A part that hangs together with nothing that stands, the part nearest to it and how far that is."""

    part: int
    nearest: int
    mm: float


@dataclass(frozen=True)
class Inspection(Result):
    """What a model is made of (``trunnion inspect``)."""

    unit: str
    parts: list[Part]
    interfaces: list[Interface]
    on_table: list[int]
    captive: list[int]
    floating: list[int]
    apart: list[Apart]
    warnings: list[str]


@dataclass(frozen=True)
class Minimum:
    """A minimum of an objective: `up` is the direction that points up; ``kind`` is ``global`` where a lower bound proves it, ``stopped`` where the budget ended the search before it came to rest."""

    value: float
    up: Vector
    kind: str
    alpha_deg: float
    beta_deg: float


@dataclass(frozen=True)
class ObjectiveResult:
    """One objective's minima for one part, best first; `lower_bound` is proved, or ``None``.

    For ``printable`` also what is recommended, in minutes and grams, and why.
    """

    objective: str
    method: str
    minima: list[Minimum]
    lower_bound: Optional[float]
    stop: str
    evaluations: int
    seconds: float
    unproved: Optional[str] = None
    best_finer: Optional[float] = None
    recommended: Optional[dict[str, Any]] = None
    reasons: Optional[list[str]] = None
    as_it_lies: Optional[dict[str, Any]] = None

    @property
    def best(self) -> Minimum:
        """The best minimum."""
        return self.minima[0]


@dataclass(frozen=True)
class OrientedPart:
    """One part's results, one for each objective."""

    id: int
    facets: int
    results: list[ObjectiveResult]
    compare: Optional[list[dict[str, Any]]] = None

    @property
    def best(self) -> Minimum:
        """The first objective's best minimum."""
        return self.results[0].best


@dataclass(frozen=True)
class Orientation(Result):
    """Orientations of a model's parts (``trunnion orient``)."""

    model: str
    parts: list[OrientedPart]


@dataclass(frozen=True)
class Print:
    """A part of a slot: printed along `up` (the model file's frame) at the table's pose `tilt_deg`, `rotation_deg`."""

    part: int
    up: Vector
    tilt_deg: float
    rotation_deg: float


@dataclass(frozen=True)
class Slot:
    """A time slot: prints that are made in this order."""

    id: int
    prints: list[Print]


@dataclass(frozen=True)
class Planned:
    """A plan's own keys and what the search says of it; `lower_bound` is proved over the directions that were tried."""

    format: str
    version: int
    model: dict[str, Any]
    machine: dict[str, Any]
    placement: dict[str, Any]
    parts: list[dict[str, Any]]
    slots: list[Slot]
    objective: str
    value: float
    lower_bound: float
    clearance_mm: float
    seconds: float
    sequence_size: int
    pose_changes: int
    seconds_print_estimate: float
    droops: list[dict[str, Any]]
    standing: dict[str, Any] | None

    @property
    def prints(self) -> list[Print]:
        """All prints in their order."""
        return [one for slot in self.slots for one in slot.prints]


class _OfFile:
    """A result whose file is the attribute called by `_file`."""

    _file: typing.ClassVar[str]

    def write(self, path: str | os.PathLike[str]) -> None:
        """Writes the result's file: the plan file, the parts as 3MF, or the program."""
        Path(path).write_bytes(getattr(self, self._file))


@dataclass(frozen=True)
class Plan(_OfFile, Result, Planned):
    """A plan (``trunnion plan``).

    Attributes:
        plan: the plan file, as the command writes it.
        parts_3mf: the model as it is printed, where that is not as it was read; the plan names it.
    """

    _file = "plan"
    plan: bytes = field(repr=False, compare=False, default=b"")
    parts_3mf: Optional[bytes] = field(repr=False, compare=False, default=None)


@dataclass(frozen=True)
class Plane:
    """A cut: what lies beyond ``normal . p > offset_mm`` becomes `parts`."""

    normal: Vector
    offset_mm: float
    parts: list[int]
    seam_mm2: float
    gain_mm2: float
    reason: str


@dataclass(frozen=True)
class Split(_OfFile, Result):
    """One solid in parts that print without supports (``trunnion split``); `parts_3mf` has them in the order of printing."""

    _file = "parts_3mf"
    planes: list[Plane]
    parts: int
    order: list[dict[str, Any]]
    needs_support_mm2: dict[str, float]
    seam_mm2: float
    setups: int
    pedestal_mm: float
    printable: bool
    seconds: float
    parts_3mf: bytes = field(repr=False, compare=False, default=b"")


@dataclass(frozen=True)
class Finding:
    """One breach of a rule, in line `line` (from 1) of the program."""

    rule: str
    line: int
    slot: Optional[int]
    part: Optional[int]
    measured: float
    allowed: float
    text: str


@dataclass(frozen=True)
class Replay:
    """What a replay of the final file on the machine's model says."""

    findings: list[Finding]
    counts: dict[str, int]
    clearance_mm: float
    clearance_line: int
    standing: dict[str, Any] | None
    moves: int
    slots: int
    filament_mm: float
    seconds_print: float
    seconds: float

    @property
    def clean(self) -> bool:
        """Whether nothing was found."""
        return not self.counts


@dataclass(frozen=True)
class Report(Result, Replay):
    """A replay (``trunnion verify``)."""


@dataclass(frozen=True)
class Slicer:
    """Who sliced."""

    name: str
    version: str


@dataclass(frozen=True)
class Prepared(_OfFile, Result):
    """A verified program (``trunnion prepare``).

    Attributes:
        output: the file that was written, where one was asked for.
        plan: the plan, and what the search says of it.
        verify: the proof.
        cut: what became of a model whose solids were cut.
        supports: what became of one that is printed on supports.
        ways: the ways that were tried for the model, the one that was taken first, with what they come to.
        seconds: what each step took.
        gcode: the program for the machine, to the byte as the command writes it.
        plan_file: the plan file.
        parts_3mf: the model as it is printed, where that is not as it was read.
    """

    _file = "gcode"
    output: Optional[str]
    plan: Planned
    verify: Replay
    cut: Optional[dict[str, Any]]
    supports: Optional[dict[str, Any]]
    ways: list[dict[str, Any]]
    slicer: Slicer
    left_out: list[dict[str, Any]]
    warnings: list[str]
    seconds: dict[str, float]
    gcode: bytes = field(repr=False, compare=False, default=b"")
    plan_file: bytes = field(repr=False, compare=False, default=b"")
    parts_3mf: Optional[bytes] = field(repr=False, compare=False, default=None)
