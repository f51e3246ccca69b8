"""The verbs of the command as functions.

Every keyword that is left out means what the command does without the flag of that name; `trunnion VERB --help` has the defaults. What all
verbs take:

    unit: unit of the model's numbers: um, mm, cm, in, ft or m; else the file's own, else guessed by size.
    repair: True or "auto": what is sure is repaired, with a warning: cracks, flipped and doubled facets, vertices on edges, small holes;
        "strict": what needs repair is refused; False or "off": open meshes are refused.
    progress: called with a :class:`Progress` as the work goes on; the work waits for it, and ends where it raises. The logger `trunnion` hears
        the same: warnings as WARNING, milestones as INFO, steps as DEBUG.
    threads: 0 to 1024; 0 and None are as many as there are processors, or what RAYON_NUM_THREADS says. Results do not depend on it.
"""

from __future__ import annotations

import json
import logging
import numbers
import os
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, Optional, Union, overload

from . import _trunnion
from .errors import InputError, TrunnionWarning
from .models import Model, ModelLike, Named, ProfileLike, named_file, named_model, named_profile
from .results import Inspection, Orientation, Packing, Plan, Prepared, Preview, Published, Rehearsal, Report, Sent, Split, Support

_log = logging.getLogger("trunnion")
# A library that nobody listens to is silent.
_log.addHandler(logging.NullHandler())

Path = Union[str, "os.PathLike[str]"]
Vector = Sequence[float]
Progressed = Callable[["Progress"], object]


@dataclass(frozen=True)
class Progress:
    """How far a verb is.

    Attributes:
        kind: ``step`` for `done` of `of` pieces of the step `text`, ``reached`` for a milestone of :func:`prepare` (read, planned, sliced),
            ``warning`` for a sentence that should be known; of :func:`send` also ``event``, and ``note`` and ``detail`` for sentences.
        text: the step, the milestone, the sentence or the event's name.
        done: pieces that are done; of a print the file's line.
        of: pieces in all; of a print the file's last line.
        event: an event of :func:`send`, as the command has it with ``--json``.
    """

    kind: str
    text: str
    done: int
    of: int
    event: Optional[dict[str, Any]] = None


def inspect(
    model: ModelLike,
    *,
    unit: Optional[str] = None,
    repair: Union[bool, str] = True,
    progress: Optional[Progressed] = None,
    threads: Optional[int] = None,
) -> Inspection:
    """Says what a model is made of: closed parts, volumes (mm3), areas (mm2), boxes (mm), interfaces, unit.

    Raises:
        InputError: a model that cannot be read: not closed, not finite, of no known format.
    """
    text, _ = _trunnion.inspect(named_model(model), _teller(progress), _given(unit=unit, repair=repair, threads=threads))
    return Inspection._read(text)


def orient(
    model: ModelLike,
    *,
    objective: Union[str, Iterable[str], None] = None,
    method: Optional[str] = None,
    parts: Optional[Iterable[int]] = None,
    whole: bool = False,
    budget: Optional[int] = None,
    seed: Optional[int] = None,
    overhang_deg: Optional[float] = None,
    layer_mm: Optional[float] = None,
    profile: Optional[ProfileLike] = None,
    up: Optional[Vector] = None,
    resolution_mm: Optional[float] = None,
    smooth_k: Optional[float] = None,
    smooth_w: Optional[float] = None,
    carrying_deg: Optional[float] = None,
    contact_area_min_mm2: Optional[float] = None,
    compare: bool = False,
    output: Optional[Path] = None,
    landscape: Optional[Path] = None,
    view: Optional[Path] = None,
    unit: Optional[str] = None,
    repair: Union[bool, str] = True,
    progress: Optional[Progressed] = None,
    threads: Optional[int] = None,
) -> Orientation:
    """Finds the best build directions of each part, with a proved lower bound where the method has one.

    Args:
        objective: one or several names, or weighted sums such as ``0.7*staircase+0.3*height``.
        method: certified, mmls, multistart, bfgs, cg, newton-cg, nelder-mead, direct, differential-evolution or grid.
        parts: only these; else each.
        whole: all parts together as one.
        budget: most evaluations for one objective, 100 at least.
        overhang_deg: surfaces up to this angle from the vertical need no support, 0 to 90.
        layer_mm: layer height for the objectives printable, staircase and alexander; else the profile's.
        profile: machine whose process settings are used for print time and filament.
        up: also rate this pose: the direction in the model's coordinates that points up, any length but 0.
        resolution_mm: width of the columns that support volumes are measured by.
        smooth_k, smooth_w, carrying_deg: smoothing of support-volume, interface-area and support-volume-convex-smooth: steepness of the steps,
            weight of the lowest points (per mm), and from which angle from the vertical on surfaces that face up carry supports.
        contact_area_min_mm2: only directions whose first layer lies on the bed with at least this much.
        compare: also the model as it lies beside each best.
        output: write the parts with the best direction up (STL, 3MF by its ending).
        landscape, view: draw the first objective over all directions, or the part as it would have it (.svg, .png, .pdf); of one part.

    Raises:
        InputError: a model that cannot be read, a setting out of its range, an unknown objective or method.

    The default objective is this project's price in minutes; the others and their sources are in ``docs/explanation/orientation.md``.
    """
    if whole and parts is not None:
        raise InputError("parts and whole cannot both be given")
    given = _given(
        objective=[objective] if isinstance(objective, str) else _list("objective", objective), method=method,
        parts=_list("parts", parts), whole=whole, budget=budget, seed=seed, overhang_deg=overhang_deg, layer_mm=layer_mm,
        profile=None if profile is None else named_profile(profile), up=up, resolution_mm=resolution_mm, smooth_k=smooth_k,
        smooth_w=smooth_w, carrying_deg=carrying_deg,
        contact_area_min_mm2=contact_area_min_mm2, compare=compare, output=_path(output), landscape=_path(landscape), view=_path(view),
        unit=unit, repair=repair, threads=threads,
    )  # fmt: skip
    text, _ = _trunnion.orient(named_model(model), _teller(progress), given)
    return Orientation._read(text)


def plan(
    model: ModelLike,
    profile: ProfileLike,
    *,
    output: Optional[Path] = None,
    sheet: Optional[Path] = None,
    top: Optional[int] = None,
    supports: Literal["never", "auto"] = "never",
    unit: Optional[str] = None,
    repair: Union[bool, str] = True,
    progress: Optional[Progressed] = None,
    threads: Optional[int] = None,
    **options: Any,
) -> Plan:
    """Finds orientations and a sequence of time slots with the least objective, or says why there is none.

    Args:
        output: the plan file; its paths to model and machine are then as seen from there.
        sheet: the plan as one picture (.svg, .png, .pdf), a frame for each pose; where there is no plan, what stands in the way.
        top: compare the best so many distinct plans, 1 to 100.
        supports: print solids upright on supports where there is no plan for them as they are.
        options: see :func:`options_of_plans`.

    Raises:
        NoPlanError: no plan; with reasons and checked remedies.
        InputError: a model, a machine or a setting that cannot be.
    """
    given = _given(
        output=_path(output), sheet=_path(sheet), top=top, supports=supports, unit=unit, repair=repair, threads=threads,
        **options_of_plans(**options),
    )  # fmt: skip
    text, made = _trunnion.plan(named_model(model), named_profile(profile), _teller(progress), given)
    files = dict(made)
    return Plan._read(text, plan=files["plan"], parts_3mf=files.get("parts"))


def split(
    model: ModelLike,
    profile: ProfileLike,
    *,
    part: Optional[int] = None,
    output: Optional[Path] = None,
    up: Union[Vector, Literal["auto"], None] = None,
    overhang_deg: Optional[float] = None,
    finish: Literal["practised", "fine"] = "practised",
    bridge_mm: Optional[float] = None,
    tolerate_mm2: Optional[float] = None,
    margin_mm: Optional[float] = None,
    max_cuts: Optional[int] = None,
    allow_mm2: Optional[float] = None,
    strict: bool = False,
    cuts: Optional[Iterable[str]] = None,
    no_cut: Optional[Iterable[Sequence[Vector]]] = None,
    pedestal_mm: Optional[float] = None,
    budget: Optional[int] = None,
    unit: Optional[str] = None,
    repair: Union[bool, str] = True,
    progress: Optional[Progressed] = None,
    threads: Optional[int] = None,
) -> Split:
    """Cuts one solid by planes into parts that print without supports, each along its own direction.

    Args:
        part: the part of a model with several that is cut.
        output: the parts as 3MF, in the order of printing.
        up: direction in the model's coordinates that points up, or ``auto``: as :func:`orient` recommends.
        overhang_deg: slopes up to this angle from the vertical need no support; else from the profile's line width and layer height.
        finish: ``practised``: what is printed everywhere may droop a little; ``fine``: nothing may.
        bridge_mm: what a line may span between two ends on material.
        tolerate_mm2: what a connected patch may have that nothing carries.
        margin_mm: room the head keeps from parts it does not print on.
        max_cuts: maximum number of cuts.
        allow_mm2: what may still need support in the end.
        strict: cut off everything beyond each plane, so that the head never has to pass the remaining part.
        cuts: cuts that are made first, in this order: ``X,Y,Z,OFFSET``, then ``@X,Y,Z`` for each piece to take, as ``pin`` of
            a document's ``planes`` has them; the file's frame, mm.
        no_cut: boxes that no cut may cross, each two corners, the file's frame, mm.
        pedestal_mm: height of a part below the model, printed first.
        budget: maximum number of cuts to try; then the search ends with the best so far.

    Raises:
        NotPrintableError: the parts still need support.
        InputError: a model that is not one closed solid, a machine or a setting that cannot be.
    """
    boxes = _list("no_cut", no_cut)
    pinned = _list("cuts", cuts)
    if up is not None and (boxes or pinned):
        raise InputError("no_cut and cuts are in the file's frame, and up turns the model; give one of them")
    given = _given(
        part=part, output=_path(output), up=up, overhang_deg=overhang_deg, finish=finish, bridge_mm=bridge_mm, tolerate_mm2=tolerate_mm2,
        margin_mm=margin_mm, max_cuts=max_cuts, allow_mm2=allow_mm2, strict=strict, cuts=pinned, no_cut=boxes, pedestal_mm=pedestal_mm, budget=budget, unit=unit, repair=repair,
        threads=threads,
    )  # fmt: skip
    text, made = _trunnion.split(named_model(model), named_profile(profile), _teller(progress), given)
    return Split._read(text, parts_3mf=dict(made)["parts"])


def support(
    model: ModelLike,
    *,
    output: Optional[Path] = None,
    view: Optional[Path] = None,
    up: Optional[Vector] = None,
    keep_z: bool = False,
    step_mm: Optional[float] = None,
    space_mm: Optional[Vector] = None,
    overhang_deg: Optional[float] = None,
    capacity: Optional[int] = None,
    node_capacity: Optional[int] = None,
    method: Optional[str] = None,
    structure: Optional[str] = None,
    wall_mm: Optional[float] = None,
    gap_mm: Optional[float] = None,
    touch_every: Optional[int] = None,
    roof_mm: Optional[float] = None,
    roof_pitch_mm: Optional[float] = None,
    brace_mm: Optional[float] = None,
    seed: Optional[int] = None,
    unit: Optional[str] = None,
    repair: Union[bool, str] = True,
    progress: Optional[Progressed] = None,
    threads: Optional[int] = None,
) -> Support:
    """Plans supports for a model in one pose, with a proved lower bound of their cost, and builds them as meshes.

    Args:
        output: the supports alone (``.stl``), or the model as it stands with them (``.3mf``); not written where nothing overhangs.
        view: a picture of the model with its supports (.svg, .png, .pdf).
        up: direction in the file's coordinates that points up.
        keep_z: the file's own z = 0 is the ground; else the model is placed on it.
        step_mm: distance between columns, and height of a level.
        space_mm: space from the origin for the model and its supports, three lengths; else the model's box and some steps around it.
        overhang_deg: overhangs up to this angle from the vertical need no support, 1 to 89.
        capacity: most columns that may merge into one, 1 to 1000.
        node_capacity: most columns through one node, 1 to 1000; else as many as its arcs carry.
        method: auto (least material), min-cost (straightest, exact), push-relabel (fastest) or shortest-paths.
        structure: of the columns: x (two crossed sheets), prism or tree.
        wall_mm: thickness of a sheet; the thinnest rod is twice as thick.
        gap_mm: between the supports and the model, 0 to 5.
        touch_every: crossed sheets touch their neighbours once in so many levels, so that powder can be removed; 1 everywhere.
        roof_mm: height of a roof of bars on top of the supports, at most `step_mm`.
        roof_pitch_mm: from bar to bar of the roof.
        brace_mm: columns with an unbraced length above this are braced; 0 none.
        seed: of the random methods.

    Raises:
        NoSupportError: something overhangs, and none of it can be supported from the ground.
        InputError: a model or a setting that cannot be.
    """
    given = _given(
        output=_path(output), view=_path(view), up=up, keep_z=keep_z, step_mm=step_mm, space_mm=space_mm, overhang_deg=overhang_deg,
        capacity=capacity, node_capacity=node_capacity, method=method, structure=structure, wall_mm=wall_mm, gap_mm=gap_mm,
        touch_every=touch_every, roof_mm=roof_mm, roof_pitch_mm=roof_pitch_mm, brace_mm=brace_mm, seed=seed, unit=unit, repair=repair, threads=threads,
    )  # fmt: skip
    text, made = _trunnion.support(named_model(model), _teller(progress), given)
    files = dict(made)
    return Support._read(text, supports_stl=files.get("supports"), model_3mf=files.get("model"))


def pack(
    models: Union[ModelLike, Iterable[Union[ModelLike, tuple[ModelLike, int]]], None] = None,
    *,
    boxes: Union[Path, bytes, Iterable[Sequence[Union[float, str]]], None] = None,
    space_mm: Optional[Vector] = None,
    profile: Optional[ProfileLike] = None,
    output: Optional[Path] = None,
    view: Optional[Path] = None,
    gap_mm: Optional[float] = None,
    turn: Optional[str] = None,
    goal: Optional[str] = None,
    fill: Union[str, Sequence[float], None] = None,
    method: Optional[str] = None,
    used_distance: Optional[int] = None,
    direction_distance: Optional[int] = None,
    time_s: Optional[float] = None,
    inflate_mm: Optional[float] = None,
    no_interlock: bool = False,
    seed: Optional[int] = None,
    unit: Optional[str] = None,
    repair: Union[bool, str] = True,
    progress: Optional[Progressed] = None,
    threads: Optional[int] = None,
) -> Packing:
    """Packs models or boxes into as few runs of a space as there must be, or stands them side by side on a machine's table.

    Args:
        models: one model, or a list of models and of pairs ``(model, copies)``.
        boxes: instead of models: a file with a line ``width depth height [count [value]] [up]`` each, its bytes, or rows such as
            ``(20, 30, 15.5, 4)``, in mm.
        space_mm: space of each run, three lengths; two with the goal ``height``.
        profile: the machine on whose table models stand side by side; instead of a space.
        output: a folder for the runs, one 3MF each.
        view: a picture of all runs (.svg, .png, .pdf).
        gap_mm: least distance between two pieces; else 1 for models, 0 for boxes, on a table as far as the head reaches sideways.
        turn: none, z90 (quarter turns about Z), z (any angle about Z) or any.
        goal: runs (all pieces in the fewest), fill (the most value in one run) or height (all in one run, as low as possible).
        fill: values for the goal fill: volume, file (those of the boxes), or a value above 0 for each model or line.
        method: auto, blocks, ip, ip-local-search or tabu; for models also coverings and anneal.
        used_distance, direction_distance: neighbourhood of ip-local-search, both or none.
        time_s: time limit, reading and the exact test included; else a step limit, the same on every machine.
        inflate_mm: pack coarser meshes around the models, their vertices raised by at most this much.
        no_interlock: models must lift straight out, one after the other.
        seed: of the random methods.

    Raises:
        InputError: pieces that do not fit, a model, a machine or a setting that cannot be.
    """
    if (models is None) == (boxes is None):
        raise InputError("models or boxes are packed; give one of them")
    if (space_mm is None) == (profile is None):
        raise InputError("pieces are packed into space_mm or on the table of profile; give one of them")
    if (used_distance is None) != (direction_distance is None):
        raise InputError("used_distance and direction_distance go together; give both or none")
    given = _given(
        models=None if models is None else _counted(models), boxes=None if boxes is None else _boxes(boxes), space_mm=space_mm,
        profile=None if profile is None else named_profile(profile), output=_path(output), view=_path(view), gap_mm=gap_mm, turn=turn,
        goal=goal, fill=_values(fill), method=method, used_distance=used_distance, direction_distance=direction_distance, time_s=time_s,
        inflate_mm=inflate_mm, no_interlock=no_interlock, seed=seed, unit=unit, repair=repair, threads=threads,
    )  # fmt: skip
    text, made = _trunnion.pack(_teller(progress), given)
    return Packing._read(text, plates_3mf=[data for name, data in made if name == "plate"])


def prepare(
    model: ModelLike,
    profile: ProfileLike,
    *,
    output: Optional[Path] = None,
    plan_out: Optional[Path] = None,
    sheet: Optional[Path] = None,
    slicer: Optional[str] = None,
    slicer_config: Iterable[Path] = (),
    slicer_timeout_s: Optional[float] = None,
    bed: Optional[str] = None,
    way: Literal["auto", "as-drawn", "turned", "supports", "turned-supports", "cut"] = "auto",
    split: Literal["auto", "never"] = "auto",
    cuts: Optional[Iterable[str]] = None,
    supports: Literal["auto", "never"] = "auto",
    unit: Optional[str] = None,
    repair: Union[bool, str] = True,
    progress: Optional[Progressed] = None,
    threads: Optional[int] = None,
    **options: Any,
) -> Prepared:
    """Does everything: from a model to a program for the machine that a replay has found nothing wrong with.

    Args:
        output: the file for the machine; an earlier one becomes ``.stale`` where none can be made. Without it the program is
            :attr:`Prepared.gcode` alone.
        plan_out: keep the plan.
        sheet: the plan as one picture (.svg, .png, .pdf).
        slicer: auto, builtin, prusa-slicer, slic3r, cura or the path of one.
        slicer_config: the slicer's own configurations, in rising order of precedence.
        slicer_timeout_s: give the slicer up after this long for one print.
        bed: the slicer's bed, mm: ``250x210``, or from where to where, ``-125..125x-105..105``.
        way: the only way that is wanted; ``auto``: the cheapest that works, by the profile's ``[price]``.
        split: cut solids by planes where there is no plan for them as they are.
        cuts: cuts that are made first, as `split` takes them; of several parts the number and a colon before each. The model is printed in parts then.
        supports: print solids upright on supports where there is no plan for them as they are, and no cheaper cut.
        options: see :func:`options_of_plans`.

    Raises:
        NoPlanError: no plan.
        RejectedError: verification found something; nothing is written.
        SlicerError: the slicer failed.
        InputError: a model, a machine, a file or a setting that cannot be.
    """
    given = _given(
        output=_path(output), plan_out=_path(plan_out), sheet=_path(sheet), slicer=slicer,
        slicer_config=[_path(one) for one in _list("slicer_config", slicer_config) or []],
        slicer_timeout_s=slicer_timeout_s, bed=bed, way=way, split=split, cuts=_list("cuts", cuts), supports=supports, unit=unit, repair=repair, threads=threads,
        **options_of_plans(**options),
    )  # fmt: skip
    text, made = _trunnion.prepare(named_model(model), named_profile(profile), _teller(progress), given)
    files = dict(made)
    # As it was given: a document has only text.
    return Prepared._read(text, output=given.get("output"), gcode=files["gcode"], plan_file=files["plan"], parts_3mf=files.get("parts"))


def verify(
    program: Union[Path, bytes, Prepared],
    plan: Union[Path, bytes, Plan, Prepared, None] = None,
    *,
    model: Union[Path, bytes, ModelLike, None] = None,
    profile: Optional[ProfileLike] = None,
    progress: Optional[Progressed] = None,
    threads: Optional[int] = None,
) -> Report:
    """Replays a finished program on the machine's model and reports what is wrong with it; findings are no exception.

    Args:
        program: the file, its bytes, or what :func:`prepare` gave.
        plan: the plan file, its bytes, or what :func:`plan` or :func:`prepare` gave; a prepared program brings its own.
        model: where the plan's model is, if it is not where the plan says.
        profile: where the plan's machine is, if it is not where the plan says.

    Raises:
        InputError: a program or plan that cannot be read, or a plan that is not of this model and machine.
    """
    if isinstance(program, Prepared) and plan is None:
        plan = program
    if plan is None:
        raise InputError("a program is verified against its plan; give it as plan")
    own = program if isinstance(program, Prepared) else plan
    given = _given(model=_model_of(own, model), profile=None if profile is None else named_profile(profile), threads=threads)
    text, _ = _trunnion.verify(_program(program), _plan(plan), _teller(progress), given)
    return Report._read(text)


Planful = Union[Path, bytes, Plan, Prepared]
Shown = Union[Planful, tuple[Union[Path, bytes, Prepared], Planful]]


def preview(
    shown: Union[ModelLike, Plan, Prepared, None] = None,
    plan: Union[Planful, None] = None,
    *,
    profile: Optional[ProfileLike] = None,
    model: Union[Path, bytes, ModelLike, None] = None,
    compare: Optional[Sequence[Shown]] = None,
    output: Optional[Path] = None,
    supports: Literal["never", "auto"] = "never",
    unit: Optional[str] = None,
    repair: Union[bool, str] = True,
    progress: Optional[Progressed] = None,
    threads: Optional[int] = None,
    **options: Any,
) -> Preview:
    """Makes a page that shows a finished program move by move, a plan pose by pose, or why a model has no plan.

    In a notebook the result shows itself. A program is verified, and shown with what was found; neither findings nor the lack of a plan raise.

    Args:
        shown: a program with its `plan`, what :func:`prepare` or :func:`plan` gave, or a model that is planned first, for `profile`.
        plan: the plan file, its bytes, or what :func:`plan` gave; alone it is shown itself.
        profile: the machine, for a model; or where the plan's machine is, if it is not where the plan says.
        model: where the plan's model is, if it is not where the plan says.
        compare: two to show side by side: plans, what :func:`prepare` gave, or pairs of program and plan.
        output: the page (.html).
        supports: for a model: print solids upright on supports where there is no plan for them as they are.
        options: for a model: see :func:`options_of_plans`.

    Raises:
        InputError: what cannot be read or shown, or a program that was made by another plan.
    """
    given = _given(
        profile=None if profile is None else named_profile(profile), output=_path(output), supports=supports, unit=unit, repair=repair,
        threads=threads, **options_of_plans(**options),
    )  # fmt: skip
    if compare is not None:
        both = _list("compare", compare) or []
        if shown is not None or plan is not None or len(both) != 2:
            raise InputError("two are compared, and nothing else is shown; give compare=[one, other] alone")
        pairs = [one if isinstance(one, tuple) and len(one) == 2 else (None, one) for one in both]
        given["finished"] = [_finished(program, its, model) for program, its in pairs]
    elif isinstance(shown, (Plan, Prepared)) or plan is not None:
        given["finished"] = [_finished(shown, plan, model)]
    elif shown is not None and profile is not None:
        given["planned"] = named_model(shown)
    else:
        raise InputError("a program is shown with its plan, a model with its machine; give plan or profile")
    if options and "planned" not in given:
        raise InputError(f"{next(iter(options))} is for a model that is planned first; leave it out")
    text, made = _trunnion.preview(_teller(progress), given)
    return Preview._read(text, output=given.get("output"), page=dict(made)["page"])


@overload
def send(
    program: Union[Path, bytes, Prepared],
    plan: Union[Planful, None] = None,
    *,
    dry_run: Literal[True],
    model: Union[Path, bytes, ModelLike, None] = None,
    profile: Optional[ProfileLike] = None,
    unverified: bool = False,
    baud: Optional[int] = None,
    progress: Optional[Progressed] = None,
    threads: Optional[int] = None,
) -> Rehearsal: ...


@overload
def send(
    program: Union[Path, bytes, Prepared],
    plan: Union[Planful, None] = None,
    *,
    port: Path,
    dry_run: Literal[False] = False,
    model: Union[Path, bytes, ModelLike, None] = None,
    profile: Optional[ProfileLike] = None,
    unverified: bool = False,
    resume: bool = False,
    from_line: Optional[int] = None,
    yes: bool = False,
    journal: Optional[Path] = None,
    baud: Optional[int] = None,
    wait_s: Optional[float] = None,
    progress: Optional[Progressed] = None,
    threads: Optional[int] = None,
) -> Sent: ...


def send(
    program: Union[Path, bytes, Prepared],
    plan: Union[Planful, None] = None,
    *,
    port: Optional[Path] = None,
    dry_run: bool = False,
    model: Union[Path, bytes, ModelLike, None] = None,
    profile: Optional[ProfileLike] = None,
    unverified: bool = False,
    resume: bool = False,
    from_line: Optional[int] = None,
    yes: bool = False,
    journal: Optional[Path] = None,
    baud: Optional[int] = None,
    wait_s: Optional[float] = None,
    progress: Optional[Progressed] = None,
    threads: Optional[int] = None,
) -> Union[Sent, Rehearsal]:
    """Prints a program: verifies it, and sends every line once, in order, to a printer on a port.

    Nobody types here: a pause ends the call, with the head above the part and the heaters on, and `resume` continues the print. Ctrl-C and
    a `progress` that raises pause it so; a second Ctrl-C is an emergency stop. Both raise when the printer stands, with what became of the
    print as their ``__cause__``. The printer waits for no callback.

    Args:
        program: the file, its bytes, or what :func:`prepare` gave, which brings its own plan.
        plan: the program is verified against it first; nothing with findings is sent.
        port: a serial device, or ``tcp:host:port``.
        dry_run: print on the simulated printer instead, without waiting and without a port.
        model: where the plan's model is, if it is not where the plan says.
        profile: where the plan's machine is, if it is not where the plan says; the machine of an unverified program.
        unverified: send a program that nothing was proved of; it has no plan, and `profile` names its machine.
        resume: continue an interrupted print from its journal.
        from_line: with `resume` after a reset: the first line to print, found by inspecting the part.
        yes: with `resume`, home and move without asking, even if the bed has cooled; else that is refused.
        journal: what was sent is written down here; else beside the program's file, with ``.journal`` behind its name.
        baud: bits a second; else the profile's.
        wait_s: how long a disconnected device is waited for; else 600.

    Raises:
        RejectedError: verification found something, or the printer cannot execute the program; nothing was sent.
        PrinterError: printer, wire or an interrupt ended the print.
        InputError: a program, plan, machine or setting that cannot be, or a program without plan that is not said to be unverified.
    """
    if port is None and not dry_run:
        raise InputError("a program is sent to a port; give port, or rehearse with dry_run=True")
    if from_line is not None and not resume:
        raise InputError("from_line is where a print continues; give resume=True with it")
    if not dry_run and journal is None and not _has_file(program):
        raise InputError("the program is in no file that its journal could be kept beside; give journal")
    given = _outgoing(program, plan, model, profile, unverified)
    given.update(
        _given(
            port=_path(port), dry_run=dry_run, resume=resume, from_line=from_line, yes=yes, journal=_path(journal), baud=baud, wait_s=wait_s,
            threads=threads,
        )
    )  # fmt: skip
    text, _ = _trunnion.send(_program(program), _teller(progress), given)
    return Rehearsal._read(text) if dry_run else Sent._read(text)


def publish(
    program: Union[Path, bytes, Prepared],
    plan: Union[Planful, None] = None,
    *,
    to: str,
    key: Optional[str] = None,
    key_file: Optional[Path] = None,
    model: Union[Path, bytes, ModelLike, None] = None,
    profile: Optional[ProfileLike] = None,
    unverified: bool = False,
    name: Optional[str] = None,
    replace: bool = False,
    start: bool = False,
    fingerprint: Optional[str] = None,
    timeout_s: Optional[float] = None,
    progress: Optional[Progressed] = None,
    threads: Optional[int] = None,
) -> Published:
    """Brings a program to the server that drives a printer, once, and compares what arrived.

    Args:
        program: the file, its bytes, or what :func:`prepare` gave, which brings its own plan.
        plan: the program is verified against it first; nothing with findings is sent.
        to: ``octoprint:URL``, ``moonraker:URL`` or ``duet:URL``.
        key: the server's key (a Duet's password); else that of `key_file`, else the environment variable TRUNNION_KEY. No message repeats it.
        key_file: a file with the key and nothing else.
        model: where the plan's model is, if it is not where the plan says.
        profile: where the plan's machine is, if it is not where the plan says.
        unverified: publish a program that nothing was proved of; it has no plan.
        name: on the server; else the file's own.
        replace: replace a different file of that name.
        start: start the print if the server's printer is idle.
        fingerprint: SHA-256 of a self-signed certificate; no other is accepted.
        timeout_s: for each answer of the server, 1 to 3600; else 30.

    Raises:
        RejectedError: verification found something; nothing was sent.
        PrinterError: the server cannot be had, or does not take the program.
        InputError: a program, plan, address, key or name that cannot be, or a program without plan that is not said to be unverified.

    Ctrl-C ends it where it is: the server is asked nothing more, and no print is started.
    """
    if not isinstance(to, str):
        raise InputError(f"to: {type(to).__name__} is not the address of a server")
    if key is not None and key_file is not None:
        raise InputError("key and key_file cannot both be given")
    given = _outgoing(program, plan, model, profile, unverified)
    given.update(
        _given(
            to=to, key=key, key_file=_path(key_file), name=name, replace=replace, start=start, fingerprint=fingerprint, timeout_s=timeout_s,
            threads=threads,
        )
    )  # fmt: skip
    text, _ = _trunnion.publish(_program(program), _teller(progress), given)
    return Published._read(text)


def _has_file(program: Any) -> bool:
    return program.output is not None if isinstance(program, Prepared) else not isinstance(program, bytes)


def _outgoing(program: Any, plan: Any, model: Any, profile: Optional[ProfileLike], unverified: bool) -> dict[str, Any]:
    """What a program is verified against before it goes to a printer."""
    if plan is not None and unverified is not False:
        raise InputError("a program with a plan is verified; give plan or unverified")
    if isinstance(program, Prepared) and plan is None and unverified is False:
        plan = program
    machine = None if profile is None else named_profile(profile)
    if plan is None:
        return _given(profile=machine, unverified=unverified)
    return _given(plan=_plan(plan), model=_model_of(program if isinstance(program, Prepared) else plan, model), profile=machine)


def _finished(program: Any, plan: Any, model: Any) -> tuple[Optional[Named], Named, Optional[Named]]:
    """A program with its plan, or a plan alone; what was prepared is both."""
    if plan is None:
        program, plan = None, program
    if isinstance(plan, Prepared) and program is None:
        program = plan
    own = program if isinstance(program, Prepared) else plan
    return None if program is None else _program(program), _plan(plan), _model_of(own, model)


def _model_of(result: Any, model: Any) -> Optional[Named]:
    """The model that is given for a plan, or the one that the plan's own result has in hand."""
    if model is None and isinstance(result, (Plan, Prepared)) and result.parts_3mf is not None:
        model = Model("model.parts.3mf", result.parts_3mf)
    return None if model is None else named_model(model)


def options_of_plans(
    *,
    objective: Optional[str] = None,
    orient_by: Optional[str] = None,
    method: Optional[str] = None,
    orient_budget: Optional[int] = None,
    overhang_deg: Optional[float] = None,
    finish: Literal["practised", "fine"] = "practised",
    bridge_mm: Optional[float] = None,
    tolerate_mm2: Optional[float] = None,
    allow: Union[Mapping[int, Optional[float]], None] = None,
    margin_mm: Optional[float] = None,
    slots: Literal["together", "single", "only-single"] = "together",
    table_later: bool = False,
    order: Optional[str] = None,
    seed: Optional[int] = None,
    origin_mm: Optional[Vector] = None,
    turn_deg: Optional[float] = None,
    remedies: bool = True,
    budget: Optional[int] = None,
    roof_mm: Optional[float] = None,
    roof_pitch_mm: Optional[float] = None,
    brace_mm: Optional[float] = None,
    up: Union[Vector, Literal["auto"], None] = None,
    base: Optional[int] = None,
    beside: Optional[Iterable[tuple[ModelLike, int]]] = None,
    copies: Optional[int] = None,
    gap_mm: Optional[float] = None,
    snap_mm: Optional[float] = None,
    join: bool = False,
) -> dict[str, Any]:
    """The keywords that :func:`plan` and :func:`prepare` share, checked.

    Args:
        objective: what the plan minimises: bss, time, setups, slots, any objective of :func:`orient` summed over the parts, or a sum.
        orient_by: what the search for orientations minimises.
        method: that search.
        orient_budget: maximum evaluations of the orientation search, per part and objective.
        overhang_deg: slopes up to this angle from the vertical need no support (90: everything); else from the profile's line width and layer height.
        finish: ``practised``: what is printed everywhere may droop a little; ``fine``: nothing may.
        bridge_mm: what a line may span between two ends on material.
        tolerate_mm2: what a connected patch may have that nothing carries.
        allow: parts that may overhang by so many mm2 more; ``None`` for whatever something else carries.
        margin_mm: room the head keeps from parts it does not print on, 0 to 100.
        slots: parts per time slot: as many as possible, preferably one, or exactly one.
        table_later: let parts that stand on the table wait for later slots.
        order: steps of parts, such as ``0,2+3,1``: each is printed in later slots than the one before.
        seed: of the search for orientations.
        origin_mm: where the file's origin comes to lie on the table, two numbers; else the model centred.
        turn_deg: turn of the model about the table's normal, about its own middle unless `origin_mm` says where it lies.
        remedies: look for what would help where there is no plan.
        budget: most steps of the sequence search, and most cuts that are tried.
        roof_mm: height of a denser roof of supports, right below what they hold.
        roof_pitch_mm: line spacing of the support roof.
        brace_mm: support columns with an unbraced length above this are braced; 0 none.
        up: direction in the model's coordinates that points up, or ``auto``.
        base: stand the model on this part's largest face below which there is nothing.
        beside: more models for the same table, each with its copies.
        copies: of the first model.
        gap_mm: room between models.
        snap_mm: close gaps between parts up to this width, and remove overlaps; 0 disables both.
        join: make one solid of parts that touch or overlap.
    """
    if up is not None and base is not None:
        raise InputError("up and base cannot both be given")
    try:
        more = None if beside is None else [(named_model(one), count) for one, count in beside]
        held = None if allow is None else [(int(part), area) for part, area in dict(allow).items()]
    except (TypeError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"beside and allow: {error}; give beside=[(model, 2)], allow={{0: 40.0}}") from None
    return _given(
        objective=objective, orient_by=orient_by, method=method, orient_budget=orient_budget, overhang_deg=overhang_deg,
        finish=finish, bridge_mm=bridge_mm, tolerate_mm2=tolerate_mm2, allow=held, margin_mm=margin_mm, slots=slots, table_later=table_later, order=order, seed=seed,
        origin_mm=origin_mm, turn_deg=turn_deg, no_remedies=not remedies, budget=budget, roof_mm=roof_mm,
        roof_pitch_mm=roof_pitch_mm, brace_mm=brace_mm, up=up, base=base, beside=more, copies=copies,
        gap_mm=gap_mm, snap_mm=snap_mm, join=join,
    )  # fmt: skip


def _given(**given: Any) -> dict[str, Any]:
    return {name: value for name, value in given.items() if value is not None}


def _list(name: str, given: Optional[Iterable[Any]]) -> Optional[list[Any]]:
    try:
        return None if given is None else list(given)
    except TypeError:
        raise InputError(f"{name} {given!r} is no list") from None


def _counted(models: Any) -> list[tuple[Named, int]]:
    """Models with how many copies of each; a model alone is a list of one."""
    alone = isinstance(models, (str, bytes, bytearray, memoryview, os.PathLike, Model))
    each: list[Any] = [models] if alone else _list("models", models) or []
    return [(named_model(one[0]), one[1]) if _is_counted(one) else (named_model(one), 1) for one in each]


def _is_counted(one: Any) -> bool:
    """A pair of arrays is a model; a model and a whole number are a model with its copies."""
    return isinstance(one, tuple) and len(one) == 2 and isinstance(one[1], numbers.Integral)


def _boxes(boxes: Any) -> Named:
    if isinstance(boxes, bytes):
        return "boxes", boxes
    if isinstance(boxes, (str, os.PathLike)):
        return named_file(boxes, "boxes")
    rows = [_list("boxes", row) or [] for row in _list("boxes", boxes) or []]
    return "boxes", "".join(" ".join(map(str, row)) + "\n" for row in rows).encode(errors="backslashreplace")


def _values(fill: Union[str, Sequence[float], None]) -> Optional[str]:
    return fill if fill is None or isinstance(fill, str) else ",".join(map(str, _list("fill", fill) or []))


def _path(given: Optional[Path]) -> Optional[str]:
    return None if given is None else named_file(given, "a path")[0]


def _program(program: Union[Path, bytes, Prepared]) -> Named:
    if isinstance(program, Prepared):
        return program.output or "program.gcode", program.gcode
    if isinstance(program, bytes):
        return "program.gcode", program
    return named_file(program, "a program; give a path, bytes or what prepare gave")


def _plan(plan: Union[Path, bytes, Plan, Prepared]) -> Named:
    if isinstance(plan, Prepared):
        return "plan.json", plan.plan_file
    if isinstance(plan, Plan):
        return "plan.json", plan.plan
    if isinstance(plan, bytes):
        return "plan.json", plan
    return named_file(plan, "a plan; give a path, bytes or what plan gave")


def _teller(progress: Optional[Progressed]) -> Callable[[str, str, int, int], None]:
    """What the native half calls: warnings become Python's; they and everything else go to `progress` and to the logger `trunnion`."""
    if progress is not None and not callable(progress):
        raise InputError(f"progress {progress!r} cannot be called; give a function of one argument")

    def told(kind: str, text: str, done: int, of: int) -> None:
        if kind == "warning":
            # The caller of the verb, behind this function, the native half and the verb itself.
            _log.warning("%s", text)
            warnings.warn(text, TrunnionWarning, stacklevel=3)
        elif kind in ("reached", "note"):
            _log.info("%s", text)
        elif kind == "step":
            _log.debug("%s: %d of %d", text, done, of)
        else:
            _log.debug("%s", text)
        if progress is not None:
            event = json.loads(text) if kind == "event" else None
            progress(Progress(kind, event["event"] if event else text, done, of, event))

    return told
