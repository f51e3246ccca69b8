"""What the verbs give back: typed values over the command's documents.

Each result has the keys of its ``--json`` document as attributes, and :meth:`Result.to_dict` is that document whole: keys that have no
attribute here are there all the same. Lengths are mm, areas mm2, volumes mm3, angles degrees, times seconds, directions lists of three in
the model file's frame, unless a name says otherwise.
"""

from __future__ import annotations

import dataclasses
import functools
import html
import json
import os
import types
import typing
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Optional

from .errors import InputError

__all__ = [
    "Apart", "Finding", "Inspection", "Interface", "Minimum", "ObjectiveResult", "Orientation", "OrientedPart", "Packed", "Packing", "Part",
    "Plan", "Planned", "Plane", "Plate", "Prepared", "Preview", "Print", "Published", "Rehearsal", "Report", "Sent", "Slicer", "Slot", "Split",
    "Support", "UploadFigures",
]  # fmt: skip

Vector = list[float]
R = typing.TypeVar("R", bound="Result")
#: Where a key of a document has the type's own name.
_Bytes = bytes


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
    def _read(cls: type[R], text: str, **more: Any) -> R:
        """The result whose document is `text`; its name is no document's key."""
        return typing.cast(R, _record(cls, json.loads(text), _text=text, **more))

    def to_json(self) -> str:
        """The command's ``--json`` document to the byte, without the line's end."""
        return self._text

    def to_dict(self) -> dict[str, Any]:
        """The command's ``--json`` document."""
        return typing.cast("dict[str, Any]", json.loads(self._text))


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
    part_seconds: list[float]
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
class Support(Result):
    """Supports of a model in one pose (``trunnion support``), planned as a flow on a grid.

    Attributes:
        grid: nodes along X, Y, Z.
        origin_mm: the first node, in the file's frame.
        red: nodes that ask for support; `unreachable` of them cannot have any.
        cost: 1 for a unit on a straight arc, 2 on an oblique one; no flow costs less than `lower_bound`.
        covered_share: of the overhanging area, 0 to 1.
        supports_stl: the supports as binary STL; ``None`` where nothing overhangs.
        model_3mf: the model as it stands with its supports; ``None`` where nothing overhangs.
    """

    grid: list[int]
    step_mm: float
    origin_mm: Vector
    nodes: int
    arcs: int
    red: int
    green: int
    unreachable: int
    unreachable_area_mm2: float
    unreachable_patches: list[dict[str, Any]]
    method: str
    cost: int
    lower_bound: int
    used_arcs: int
    used_arcs_lower_bound: int
    straight_arcs: int
    oblique_arcs: int
    length_mm: float
    over_capacity: int
    most_on_an_arc: int
    volume_mm3: float
    covered_share: float
    overhang_mm2: float
    contact_mm2: float
    plate_mm2: float
    longest_free_mm: float
    struts: int
    unbraced: int
    roof_bars: int
    seconds_plan: float
    seconds: float
    supports_stl: Optional[bytes] = field(repr=False, compare=False, default=None)
    model_3mf: Optional[bytes] = field(repr=False, compare=False, default=None)

    def write(self, path: str | os.PathLike[str]) -> None:
        """Writes the supports alone (``.stl``), or the model with them (``.3mf``); nothing where nothing overhangs.

        Raises:
            InputError: another ending.
        """
        ending = Path(path).suffix.lower()
        if ending not in (".stl", ".3mf"):
            raise InputError(f"{os.fspath(path)!r}: supports are written as .stl or .3mf")
        data = self.supports_stl if ending == ".stl" else self.model_3mf
        if data is not None:
            Path(path).write_bytes(data)


@dataclass(frozen=True)
class Packed:
    """A model or box in its place.

    Attributes:
        model: the model's file, or the box's line; `index` is its number, from 0, and `copy` that of its copies.
        origin_mm: where the file's origin comes to lie, or a box's low corner, turned by `turn_deg` about `axis`.
        box_mm: the box around it, two corners.
    """

    model: str
    index: int
    copy: int
    origin_mm: Vector
    turn_deg: float
    axis: Vector
    box_mm: list[Vector]


@dataclass(frozen=True)
class Plate:
    """One run: its pieces, what of its space they fill, and the order in which they lift out (places in `items`)."""

    file: str
    fill: float
    items: list[Packed]
    lift_order: list[int]
    locked: list[int]


@dataclass(frozen=True)
class Packing(Result):
    """Models or boxes in as few runs as there must be, or the most value in one (``trunnion pack``).

    Attributes:
        lower_bound: no packing has fewer runs, proved.
        ended: why the search ended: ``proved``, ``steps`` or ``time``.
        clearance_mm: the least distance between two pieces; ``None`` from twice the gap on.
        left_out: what is in no run.
        value, value_upper_bound: with the goal ``fill``: what the run holds, and what none exceeds.
        height_mm, height_lower_bound_mm: with the goal ``height``: how high the run is, and what none is lower than.
        plates_3mf: the runs as 3MF, in the order of `plates`.
    """

    plates: list[Plate]
    runs: int
    lower_bound: int
    goal: str
    ended: str
    interrupted: bool
    method: str
    space_mm: Vector
    gap_mm: float
    clearance_mm: Optional[float]
    left_out: list[dict[str, Any]]
    seconds: float
    value: Optional[float] = None
    value_upper_bound: Optional[float] = None
    inflated: Optional[dict[str, Any]] = None
    height_mm: Optional[float] = None
    height_lower_bound_mm: Optional[float] = None
    plates_3mf: list[bytes] = field(repr=False, compare=False, default_factory=list)

    def write(self, folder: str | os.PathLike[str]) -> None:
        """Writes each run into `folder`, under its plate's `file`; the folder is made where it is not there."""
        Path(folder).mkdir(exist_ok=True)
        for plate, data in zip(self.plates, self.plates_3mf):
            (Path(folder) / plate.file).write_bytes(data)


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


@dataclass(frozen=True)
class Preview(_OfFile, Result):
    """A page to look at (``trunnion preview``): in a notebook it shows itself, and nothing of it comes from elsewhere.

    Attributes:
        output: the file that was written, where one was asked for.
        shows: ``program``, ``plan``, ``reasons`` (why there is no plan) or ``two`` (side by side).
        bytes: the page's size.
        verify: what a replay of the program says; ``None`` where none is shown.
        why_not: why there is no plan.
        pages: of two, what is said of each; the other keys are then ``None``.
        page: the page itself.
    """

    _file = "page"
    output: Optional[str]
    shows: str
    bytes: int
    moves: Optional[int] = None
    layers: Optional[int] = None
    lines: Optional[int] = None
    lines_from_moves: Optional[int] = None
    text: Optional[bool] = None
    parts: Optional[int] = None
    poses: Optional[int] = None
    thinned: Optional[bool] = None
    verify: Optional[Replay] = None
    why_not: Optional[str] = None
    seconds: Optional[dict[str, float]] = None
    pages: Optional[list[dict[str, Any]]] = None
    page: _Bytes = field(repr=False, compare=False, default=b"")

    @property
    def html(self) -> str:
        """The page as text."""
        return self.page.decode()

    def _repr_html_(self) -> str:
        # A frame without rights to the notebook: its scripts run, and reach nothing outside.
        return (
            f'<iframe title="trunnion preview" sandbox="allow-scripts" srcdoc="{html.escape(self.html)}" '
            'style="width: 100%; height: 40em; border: 0"></iframe>'
        )


@dataclass(frozen=True)
class Sent(Result):
    """A print that is complete (``trunnion send``): the last event, with the lines that were sent again."""

    event: str
    line: int
    of: int
    resends: int


@dataclass(frozen=True)
class Rehearsal(Result):
    """A print on the simulated printer (``trunnion send --dry-run``).

    Attributes:
        seconds: with homing and heating; `seconds_print` without.
        clamped: targets beyond an axis of the profile.
        troubles: lines that the simulated printer did not execute as they are written.
    """

    line: int
    of: int
    seconds: float
    seconds_print: float
    clamped: int
    troubles: list[str]

    @property
    def clean(self) -> bool:
        """Whether all was executed as it is written."""
        return not self.clamped and not self.troubles


@dataclass(frozen=True)
class UploadFigures:
    """What a file takes; ``None`` for what nobody says."""

    seconds_print: Optional[float]
    filament_mm: Optional[float]
    layers: Optional[int]


@dataclass(frozen=True)
class Published(Result):
    """A file on the server of a printer (``trunnion publish``).

    Attributes:
        file: its name there; `sha256` is that of what is there.
        uploads: how often it was sent; 0 where it was there already.
        stated: what the file says of itself; `shown` is what the server says of it.
    """

    server: str
    url: str
    file: str
    bytes: int
    sha256: str
    verified: bool
    uploads: int
    started: bool
    stated: UploadFigures
    shown: UploadFigures
    seconds: float
