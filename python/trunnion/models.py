"""Models and machines as values: what may be given to a verb, and how it gets to the native half.

A model is a path, the bytes of a file, a pair of arrays, or a :class:`Model` that has any of them in hand. Values pickle, so that they
can be sent to other processes and computers.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Union

from . import _trunnion
from .errors import InputError

__all__ = ["Model", "Profile", "ModelLike", "ProfileLike"]

#: A name and, where it is in hand, what is in the file: how the native half takes files.
Named = tuple[str, Union[bytes, None]]


@dataclass(frozen=True)
class Model:
    """The bytes of a model file with a name; the name's ending tells the format where the bytes do not.

    Attributes:
        name: as messages and plans call it.
        data: STL, OBJ, 3MF or OFF.
    """

    name: str
    data: bytes

    @classmethod
    def from_arrays(cls, vertices: Any, facets: Any, name: str = "part") -> Model:
        """One mesh from arrays.

        Args:
            vertices: n x 3, any real dtype, read as float64; mm. A float64 array is read where it is.
            facets: m x 3 integers, each a row of `vertices`; counter-clockwise seen from outside. An int64 array is read where it is.
            name: of the part.

        Returns:
            A 3MF in memory; coordinates keep every bit of float64.

        Raises:
            InputError: wrong shape or dtype, no rows, a coordinate that is not finite, an index out of range.
        """
        return cls.from_meshes({name: (vertices, facets)})

    @classmethod
    def from_meshes(cls, meshes: Mapping[str, tuple[Any, Any]], name: str = "model.3mf") -> Model:
        """Several parts that keep their faces where they touch: names to pairs of arrays, as for :meth:`from_arrays`."""
        checked = [(_text(part, "the name of a part"), *_arrays(part, pair)) for part, pair in meshes.items()]
        return cls(name, _trunnion.encode(checked))

    def write(self, path: str | os.PathLike[str]) -> None:
        """Writes the file."""
        Path(path).write_bytes(self.data)


ModelLike = Union[str, "os.PathLike[str]", bytes, Model, tuple[Any, Any]]


def _arrays(name: str, pair: tuple[Any, Any]) -> tuple[Any, Any]:
    import numpy

    if not isinstance(pair, tuple) or len(pair) != 2:
        raise InputError(f"{name}: {type(pair).__name__} is no pair of arrays; give (vertices, facets)")
    vertices, facets = (_array(name, what, given) for what, given in zip(("vertices", "facets"), pair))
    if vertices.dtype.kind not in "fiu":
        raise InputError(f"{name}: vertices of dtype {vertices.dtype}; numbers are wanted, as float64")
    if facets.dtype.kind not in "iu":
        raise InputError(f"{name}: facets of dtype {facets.dtype}; whole numbers are wanted, as int64")
    if vertices.dtype.itemsize > 8:
        raise InputError(f"{name}: vertices of dtype {vertices.dtype}; at most float64 is read")
    if facets.dtype == numpy.uint64 and facets.size and facets.max() > numpy.iinfo(numpy.int64).max:
        raise InputError(f"{name}: facets name vertex {facets.max()}; there are 0..{len(vertices) - 1}")
    return vertices.astype(numpy.float64, copy=False), facets.astype(numpy.int64, copy=False)


def _array(name: str, what: str, given: Any) -> Any:
    import numpy

    try:
        array = numpy.asarray(given)
    except ValueError as error:
        raise InputError(f"{name}: {what} are no array: {error}") from None
    if array.ndim != 2:
        raise InputError(f"{name}: {what} have {array.ndim} dimensions; two are wanted, as n x 3")
    return array


def named_model(model: Any) -> Named:
    """How the native half takes a model."""
    if isinstance(model, Model):
        return _name(model.name, "the name of a model"), model.data
    if isinstance(model, (bytes, bytearray, memoryview)):
        return "model", bytes(model)
    if isinstance(model, tuple):
        if len(model) != 2:
            raise InputError(f"a tuple of {len(model)} is no model; give (vertices, facets)")
        return named_model(Model.from_arrays(*model))
    return named_file(model, "a model; give a path, bytes, (vertices, facets) or a Model")


def named_file(given: Any, what: str) -> Named:
    """How the native half takes a path."""
    try:
        path = os.fspath(given)
    except TypeError:
        raise InputError(f"{type(given).__name__} is not {what}") from None
    return _name(os.fsdecode(path), what), None


def _name(given: str, what: str) -> str:
    """A name that a file can have: bytes that are no text are in it as `os.fsdecode` has them."""
    try:
        os.fsencode(given)
    except (TypeError, UnicodeEncodeError):
        raise InputError(f"{given!r} is not {what}: no file can have this name") from None
    return given


def _text(given: Any, what: str) -> str:
    """Text that can be written into a file."""
    if not isinstance(given, str):
        raise InputError(f"{type(given).__name__} is not {what}")
    try:
        given.encode()
    except UnicodeEncodeError:
        raise InputError(f"{given!r:.60} is not {what}: it cannot be written as UTF-8") from None
    return given


class Profile:
    """A machine: a shipped name, a TOML file, or TOML text.

    Read and checked at once. It pickles with all its values, so that a file of the user's own need not be on the computer where it is
    used.

    Args:
        machine: a shipped name (see :meth:`shipped`), the name of one of the user's own, or a path that ends in ``.toml`` or has a slash.

    Attributes:
        name: as it was given.
        sha256: the hash of all its values, as plans name it.

    Raises:
        InputError: an unknown name, a file that cannot be read, a key or value that cannot be.
    """

    def __init__(self, machine: str | os.PathLike[str]) -> None:
        word, _ = named_file(machine, "a machine; give a name or a path")
        self._read(word, None)

    @classmethod
    def from_toml(cls, text: str, name: str = "machine.toml") -> Profile:
        """A profile from the text of a TOML file, called `name` in messages and plans."""
        profile = cls.__new__(cls)
        profile._read(_name(name, "the name of a machine"), _text(text, "the text of a TOML file").encode())
        return profile

    @staticmethod
    def shipped() -> list[str]:
        """The names of the profiles that come with the package."""
        return _trunnion.shipped()

    def _read(self, word: str, toml: bytes | None) -> None:
        self.name, self.sha256, self._document, self._toml = _trunnion.profile((word, toml))
        self._named: Named = (word, toml)

    def to_toml(self) -> str:
        """All values as TOML, each with where it comes from: what ``trunnion profile show`` prints."""
        return self._toml

    def to_dict(self) -> dict[str, Any]:
        """All values: the document of ``trunnion profile show --json``."""
        document: dict[str, Any] = json.loads(self._document)
        return document

    def __reduce__(self) -> tuple[Any, ...]:
        if self._named[1] is None and self.name in self.shipped():
            return Profile, (self.name,)
        return Profile.from_toml, (self._toml, self.name)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Profile) and (self.name, self.sha256) == (other.name, other.sha256)

    def __hash__(self) -> int:
        return hash((self.name, self.sha256))

    def __repr__(self) -> str:
        return f"Profile({self.name!r})"


ProfileLike = Union[str, "os.PathLike[str]", Profile]


def named_profile(profile: Any) -> Named:
    """How the native half takes a machine."""
    if isinstance(profile, Profile):
        return profile._named
    return named_file(profile, "a machine; give a name, a path or a Profile")
