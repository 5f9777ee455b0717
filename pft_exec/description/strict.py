"""Strict TOML: a file becomes a frozen dataclass, or an error that names file, key and the nearest valid choice.

A schema is an ordinary frozen dataclass whose annotations say what each key holds. Understood are ``str``, ``bool``,
``int``, ``float`` (finite; an integer will do), ``Literal``, ``X | None``, ``tuple[X, ...]`` and ``tuple[X, Y, Z]``,
``dict[str, X]`` for tables with free keys, nested dataclasses, and unions of dataclasses told apart by a
``Literal`` field. A field with a default may be missing; a ``ValueError`` of ``__post_init__`` is reported at its key.
"""

from __future__ import annotations

import dataclasses
import math
import sys
import types
from collections.abc import Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any, Literal, NoReturn, TypeVar, Union, get_args, get_origin, get_type_hints

from pft_exec.exceptions import DescriptionError

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

Schema = TypeVar("Schema")

_SCALARS = {str: "a string", bool: "true or false", int: "an integer", float: "a finite number"}


@dataclass(frozen=True)
class Place:
    """Where in which file a value stands; `refuse` raises the error that says so."""

    file: Path
    key: str = ""

    def __truediv__(self, key: str) -> Place:
        return Place(self.file, f"{self.key}.{key}" if self.key else key)

    def item(self, index: int) -> Place:
        """The place of an item of the array that stands here."""
        return Place(self.file, f"{self.key}[{index}]")

    def refuse(self, message: str) -> NoReturn:
        """Raise a DescriptionError that names file and dotted key."""
        where = f"{self.key}: " if self.key else ""
        raise DescriptionError(f"{self.file}: {where}{message}")


def read_strictly(path: Path, schema: type[Schema]) -> Schema:
    """Read a TOML file as the dataclass `schema`.

    Parameters
    ----------
    path : Path
        The file.
    schema : type
        A frozen dataclass.

    Raises
    ------
    DescriptionError
        If the file is missing or is no TOML; if a key is unknown or missing; if a value has the wrong type, length
        or choice. The message names the file, the dotted key and, for a misspelt word, the nearest valid one.
    """
    place = Place(path)
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        place.refuse(f"cannot be read: {error.strerror}.")
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        place.refuse(f"is not TOML: {error}.")
    result: Schema = _table(table, schema, place)
    return result


def _table(value: Any, schema: type[Any], place: Place) -> Any:
    if not isinstance(value, Mapping):
        place.refuse(f"expected a table, got {_shown(value)}.")
    fields = {field.name: field for field in dataclasses.fields(schema) if field.init}
    for key in value:
        if key not in fields:
            (place / key).refuse(f"unknown key.{suggestion(key, fields)}")
    for name, field in fields.items():
        if name not in value and not _has_default(field):
            (place / name).refuse(f"missing key; expected {_expected(get_type_hints(schema)[name])}.")
    hints = get_type_hints(schema)
    arguments = {key: _convert(item, hints[key], place / key) for key, item in value.items()}
    return _built(schema, arguments, place)


def _has_default(field: dataclasses.Field[Any]) -> bool:
    return field.default is not dataclasses.MISSING or field.default_factory is not dataclasses.MISSING


def _built(schema: type[Any], arguments: dict[str, Any], place: Place) -> Any:
    try:
        return schema(**arguments)
    except DescriptionError:
        raise
    except ValueError as error:
        place.refuse(str(error))


def suggestion(name: str, choices: Mapping[str, Any] | tuple[str, ...]) -> str:
    """Words to append to a message: the nearest of `choices` to `name`, and all of them."""
    nearest = get_close_matches(name, list(choices), n=1, cutoff=0.5)
    hint = f" Did you mean {nearest[0]!r}?" if nearest else ""
    return f"{hint} Choices: {', '.join(repr(choice) for choice in choices)}."


def _convert(value: Any, annotation: Any, place: Place) -> Any:
    origin = get_origin(annotation)
    if annotation in _SCALARS:
        return _scalar(value, annotation, place)
    if origin is Literal:
        return _choice(value, get_args(annotation), place)
    if origin in (Union, types.UnionType):
        return _member(value, get_args(annotation), place)
    if origin is tuple:
        return _array(value, get_args(annotation), place)
    if origin in (dict, Mapping):
        return _free_table(value, get_args(annotation)[1], place)
    if isinstance(annotation, type) and dataclasses.is_dataclass(annotation):
        return _table(value, annotation, place)
    raise TypeError(f"a schema cannot hold {annotation!r}; see the docstring of {__name__}.")


def _scalar(value: Any, kind: type[Any], place: Place) -> Any:
    allowed = (int, float) if kind is float else (kind,)
    fits = isinstance(value, allowed) and (kind is bool or not isinstance(value, bool))
    if not fits or (kind is float and not math.isfinite(value)):
        place.refuse(f"expected {_SCALARS[kind]}, got {_shown(value)}.")
    return kind(value)


def _choice(value: Any, choices: tuple[Any, ...], place: Place) -> Any:
    if value not in choices:
        place.refuse(f"{_shown(value)} is not a choice.{suggestion(str(value), choices)}")
    return value


def _array(value: Any, items: tuple[Any, ...], place: Place) -> Any:
    if not isinstance(value, list):
        place.refuse(f"expected an array, got {_shown(value)}.")
    if items[-1] is Ellipsis:
        items = (items[0],) * len(value)
    if len(value) != len(items):
        place.refuse(f"expected {len(items)} items, got {len(value)}: {_shown(value)}.")
    return tuple(
        _convert(item, kind, place.item(index)) for index, (item, kind) in enumerate(zip(value, items, strict=True))
    )


def _free_table(value: Any, kind: Any, place: Place) -> dict[str, Any]:
    if not isinstance(value, Mapping):
        place.refuse(f"expected a table, got {_shown(value)}.")
    return {key: _convert(item, kind, place / key) for key, item in value.items()}


def _member(value: Any, members: tuple[Any, ...], place: Place) -> Any:
    members = tuple(member for member in members if member is not types.NoneType)
    if len(members) == 1:
        return _convert(value, members[0], place)
    if not all(dataclasses.is_dataclass(member) for member in members):
        raise TypeError("a schema's union must be of dataclasses, or of one type and None.")
    return _tagged(value, members, place)


def _tagged(value: Any, members: tuple[Any, ...], place: Place) -> Any:
    """A union of dataclasses: the `Literal` field that all share says which one it is."""
    tag, kinds = _tags(members)
    if not isinstance(value, Mapping):
        place.refuse(f"expected a table, got {_shown(value)}.")
    if tag not in value:
        (place / tag).refuse(f"missing key.{suggestion('', kinds)}")
    if not isinstance(value[tag], str) or value[tag] not in kinds:
        (place / tag).refuse(f"{_shown(value[tag])} is not a choice.{suggestion(str(value[tag]), kinds)}")
    return _table(value, kinds[value[tag]], place)


def _tags(members: tuple[Any, ...]) -> tuple[str, dict[str, Any]]:
    for field in dataclasses.fields(members[0]):
        hints = [get_type_hints(member).get(field.name) for member in members]
        if all(get_origin(hint) is Literal for hint in hints):
            return field.name, {
                word: member for member, hint in zip(members, hints, strict=True) for word in get_args(hint)
            }
    raise TypeError(f"no Literal field tells {members!r} apart.")


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _expected(annotation: Any) -> str:
    if annotation in _SCALARS:
        return _SCALARS[annotation]
    if get_origin(annotation) is Literal:
        return " or ".join(repr(choice) for choice in get_args(annotation))
    return "an array" if get_origin(annotation) is tuple else "a table"
