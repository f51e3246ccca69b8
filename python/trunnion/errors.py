"""What goes wrong, as exceptions with their facts.

Every exception has the sentence, the exit code that the command would give, and the command's own document for it, so that a script
that reads documents and a program that catches exceptions see the same.
"""

from __future__ import annotations

import json
from typing import Any

__all__ = [
    "TrunnionError", "InputError", "NoPlanError", "RejectedError", "NotPrintableError", "NoSupportError", "SlicerError",
    "PrinterError", "TrunnionWarning",
]  # fmt: skip


class TrunnionWarning(UserWarning):
    """Something that should be known: the same sentence that the command prints after ``warning:``."""


class TrunnionError(Exception):
    """A call that was not done.

    Attributes:
        text: one sentence with value, unit, allowed range and remedy.
        exit: the command's exit code: 1 the answer is no, 2 bad input, 3 the slicer failed, 4 printer or wire.
        document: what the command prints with ``--json``.
    """

    def __init__(self, text: str, exit: int = 2, document: dict[str, Any] | None = None) -> None:
        # All arguments are kept, so that the exception survives pickling.
        super().__init__(text, exit, document)
        self.text = text
        self.exit = exit
        own = {"error": text, "exit": exit, "code": "command/usage", "place": None, "help": None}
        self.document: dict[str, Any] = own if document is None else document

    def __str__(self) -> str:
        return self.text

    @property
    def code(self) -> str | None:
        """What stands for it for good, such as ``mesh/open``; ``trunnion explain CODE`` says what it means. ``None`` where the answer is no."""
        return self.document.get("code")

    def to_dict(self) -> dict[str, Any]:
        """The command's ``--json`` document for this failure."""
        return self.document


class InputError(TrunnionError, ValueError):
    """What was given cannot be: a file, a mesh, a profile, an array, a setting (exit 2)."""


class NoPlanError(TrunnionError):
    """There is no plan for the model on this machine (exit 1)."""

    @property
    def reasons(self) -> list[dict[str, Any]]:
        """What stands in the way: ``part``, ``orientation``, ``blocked_by``, ``depth_mm``, ``text``."""
        return list(self.document.get("reasons", []))

    @property
    def remedies(self) -> list[dict[str, Any]]:
        """What would help, each checked by planning again."""
        return list(self.document.get("remedies", []))


class RejectedError(TrunnionError):
    """Verification found something, so that the program was not written or sent; or its printer cannot execute it (exit 1)."""

    @property
    def findings(self) -> list[dict[str, Any]]:
        """The findings: ``rule``, ``line``, ``slot``, ``part``, ``measured``, ``allowed``, ``text``."""
        return list(self.document.get("verify", {}).get("findings", []))


class NotPrintableError(TrunnionError):
    """The solid was cut as far as it can be, and the parts still do not print (exit 1); ``document`` is that of ``split``."""


class NoSupportError(TrunnionError):
    """What overhangs cannot be supported from the ground (exit 1); ``document`` is that of ``support``."""


class SlicerError(TrunnionError):
    """The slicer failed (exit 3)."""


class PrinterError(TrunnionError):
    """Printer, wire or server ended it, or could not be had (exit 4); `text` says what can be done, such as resuming."""


def from_document(text: str, exit: int, document: str) -> TrunnionError:
    """The exception for a failure of the native half: `document` is JSON."""
    facts = json.loads(document)
    return _kind(exit, facts)(text, exit, facts)


def _kind(exit: int, facts: dict[str, Any]) -> type[TrunnionError]:
    if "verify" in facts or (exit == 1 and str(facts.get("code")).startswith("printer/")):
        return RejectedError
    if "planes" in facts:
        return NotPrintableError
    if "unreachable_patches" in facts:
        return NoSupportError
    if facts.get("feasible") is False or exit == 1:
        return NoPlanError
    return {2: InputError, 3: SlicerError, 4: PrinterError}.get(exit, TrunnionError)
