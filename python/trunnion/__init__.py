"""5-axis FDM printing from Python: the jobs of the command ``trunnion``, with the same results.

>>> import trunnion
>>> done = trunnion.prepare("two-boxes.stl", "generic-ac", slicer="builtin", overhang_deg=40, output="two-boxes.gcode")
>>> done.verify.clean, done.plan.prints[1].tilt_deg
(True, 90.0)

Models are paths, bytes, pairs of NumPy arrays ``(vertices, facets)`` or :class:`Model`; machines are names, paths or :class:`Profile`.
Each verb gives a typed result whose ``to_dict()`` is the command's ``--json`` document; what goes wrong is an exception with the
command's sentence, exit code and document. Results, models, profiles and exceptions pickle.

While a verb works the interpreter is free for other threads. Ctrl-C ends it, and so does a `progress` callback that raises; nothing is
written then. A search or a replay that is under way is left to end by itself; a print is paused above the part (:func:`send`).
"""

from ._trunnion import __version__
from .errors import (
    InputError,
    NoPlanError,
    NoSupportError,
    NotPrintableError,
    PrinterError,
    RejectedError,
    SlicerError,
    TrunnionError,
    TrunnionWarning,
)
from .models import Model, ModelLike, Profile, ProfileLike
from .results import Inspection, Orientation, Packing, Plan, Prepared, Preview, Published, Rehearsal, Report, Sent, Split, Support
from .verbs import Progress, inspect, orient, pack, plan, prepare, preview, publish, send, split, support, verify

__all__ = [
    "InputError",
    "Inspection",
    "Model",
    "ModelLike",
    "NoPlanError",
    "NoSupportError",
    "NotPrintableError",
    "Orientation",
    "Packing",
    "Plan",
    "Prepared",
    "Preview",
    "PrinterError",
    "Profile",
    "ProfileLike",
    "Progress",
    "Published",
    "Rehearsal",
    "RejectedError",
    "Report",
    "Sent",
    "SlicerError",
    "Split",
    "Support",
    "TrunnionError",
    "TrunnionWarning",
    "__version__",
    "inspect",
    "orient",
    "pack",
    "plan",
    "prepare",
    "preview",
    "publish",
    "send",
    "split",
    "support",
    "verify",
]
