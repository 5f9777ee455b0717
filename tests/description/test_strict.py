"""The strict reader: what it accepts, and that each refusal names file, dotted key and the nearest valid choice."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import pytest

from pft_exec.description.strict import read_strictly, suggestion
from pft_exec.exceptions import DescriptionError


@dataclass(frozen=True)
class Disc:
    kind: Literal["disc"]
    radius: float

    def __post_init__(self) -> None:
        if self.radius <= 0.0:
            raise ValueError(f"a radius must be above 0 m, got {self.radius}.")


@dataclass(frozen=True)
class Slab:
    kind: Literal["slab"]
    size: tuple[float, float, float]


@dataclass(frozen=True)
class Part:
    shape: Disc | Slab
    color: Literal["red", "green"] = "red"


@dataclass(frozen=True)
class Machine:
    name: str
    count: int
    is_fixed: bool = False
    mass: float | None = None
    offsets: tuple[float, ...] = ()
    parts: tuple[Part, ...] = ()
    limits: dict[str, tuple[float, float]] = field(default_factory=dict)


SOUND = """
name = "press"
count = 2
is_fixed = true
mass = 3
offsets = [1, 2.5]
limits = { x = [-1.0, 1.0] }
[[parts]]
shape = { kind = "disc", radius = 0.1 }
[[parts]]
shape = { kind = "slab", size = [1, 2, 3] }
color = "green"
"""


def read(folder: Path, text: str) -> Machine:
    file = folder / "machine.toml"
    file.write_text(text, encoding="utf-8")
    return read_strictly(file, Machine)


def test_every_kind_of_value_is_read(tmp_path: Path) -> None:
    machine = read(tmp_path, SOUND)
    assert machine == Machine(
        name="press",
        count=2,
        is_fixed=True,
        mass=3.0,
        offsets=(1.0, 2.5),
        parts=(Part(Disc("disc", 0.1)), Part(Slab("slab", (1.0, 2.0, 3.0)), "green")),
        limits={"x": (-1.0, 1.0)},
    )
    assert isinstance(machine.mass, float)


def test_keys_with_defaults_may_be_missing(tmp_path: Path) -> None:
    assert read(tmp_path, 'name = "press"\ncount = 1') == Machine("press", 1)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('name = "a"\ncuont = 1', ("cuont: unknown key", "Did you mean 'count'?", "'is_fixed'")),
        ('name = "a"', ("count: missing key", "an integer")),
        ("name = 1\ncount = 1", ("name: expected a string, got 1",)),
        ('name = "a"\ncount = true', ("count: expected an integer, got True",)),
        ('name = "a"\ncount = 1.5', ("count: expected an integer, got 1.5",)),
        ('name = "a"\ncount = 1\nmass = "3"', ("mass: expected a finite number, got '3'",)),
        ('name = "a"\ncount = 1\nmass = nan', ("mass: expected a finite number, got nan",)),
        ('name = "a"\ncount = 1\nmass = true', ("mass: expected a finite number, got True",)),
        ('name = "a"\ncount = 1\nis_fixed = 1', ("is_fixed: expected true or false, got 1",)),
        ('name = "a"\ncount = 1\noffsets = 1', ("offsets: expected an array, got 1",)),
        ('name = "a"\ncount = 1\noffsets = [1, "b"]', ("offsets[1]: expected a finite number, got 'b'",)),
        ('name = "a"\ncount = 1\nlimits = { x = [1.0] }', ("limits.x: expected 2 items, got 1",)),
        ('name = "a"\ncount = 1\nlimits = 3', ("limits: expected a table, got 3",)),
        ('name = "a"\ncount = 1\nparts = [3]', ("parts[0]: expected a table, got 3",)),
        ('name = "a"\ncount = 1\n[[parts]]\ncolor = "red"', ("parts[0].shape: missing key",)),
        (
            'name = "a"\ncount = 1\n[[parts]]\nshape = { kind = "dics", radius = 1 }',
            ("parts[0].shape.kind: 'dics' is not a choice", "Did you mean 'disc'?"),
        ),
        (
            'name = "a"\ncount = 1\n[[parts]]\nshape = { radius = 1 }',
            ("parts[0].shape.kind: missing key", "'disc', 'slab'"),
        ),
        (
            'name = "a"\ncount = 1\n[[parts]]\nshape = "disc"',
            ("parts[0].shape: expected a table, got 'disc'",),
        ),
        (
            'name = "a"\ncount = 1\n[[parts]]\nshape = { kind = "disc", radius = 1 }\ncolor = "geren"',
            ("parts[0].color: 'geren' is not a choice", "Did you mean 'green'?"),
        ),
        (
            'name = "a"\ncount = 1\n[[parts]]\nshape = { kind = "disc", radius = -1 }',
            ("parts[0].shape: a radius must be above 0 m, got -1.0",),
        ),
        ("name = ", ("is not TOML",)),
    ],
)
def test_refusals_name_file_key_and_choice(tmp_path: Path, text: str, words: tuple[str, ...]) -> None:
    with pytest.raises(DescriptionError) as caught:
        read(tmp_path, text)
    assert "machine.toml" in str(caught.value)
    for word in words:
        assert word in str(caught.value)


def test_a_missing_file_is_refused_by_name(tmp_path: Path) -> None:
    with pytest.raises(DescriptionError, match=r"nowhere\.toml: cannot be read: No such file"):
        read_strictly(tmp_path / "nowhere.toml", Machine)


def test_an_error_can_be_caught_as_a_value_error(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="unknown key"):
        read(tmp_path, "nmae = 1")


def test_a_suggestion_lists_all_choices() -> None:
    assert suggestion("rihgt", ("left", "right")) == " Did you mean 'right'? Choices: 'left', 'right'."
    assert suggestion("zzz", ("left", "right")) == " Choices: 'left', 'right'."


@dataclass(frozen=True)
class Odd:
    value: complex


@dataclass(frozen=True)
class Mixed:
    value: int | str


@dataclass(frozen=True)
class Untold:
    value: Part | Machine


@dataclass(frozen=True)
class Stern:
    color: Literal["red", "green"]
    sizes: tuple[int, ...]
    part: Part | None = None

    def __post_init__(self) -> None:
        raise DescriptionError("no sternness is stern enough.")


@pytest.mark.parametrize(
    ("schema", "words"),
    [
        (Odd, "a schema cannot hold"),
        (Mixed, "a schema's union must be of dataclasses"),
        (Untold, "no Literal field tells"),
    ],
)
def test_a_schema_that_cannot_be_read_is_the_programmers_mistake(
    tmp_path: Path, schema: type[object], words: str
) -> None:
    file = tmp_path / "odd.toml"
    file.write_text("value = {}", encoding="utf-8")
    with pytest.raises(TypeError, match=words):
        read_strictly(file, schema)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "color: missing key; expected 'red' or 'green'"),
        ('color = "red"', "sizes: missing key; expected an array"),
        ('color = "red"\nsizes = []', "^no sternness is stern enough"),
        ('color = "red"\nsizes = []\npart = {}', "part.shape: missing key; expected a table"),
        ('color = "red"\nsizes = []\npart = { shape = { kind = [1] } }', r"part.shape.kind: \[1\] is not a choice"),
    ],
)
def test_a_missing_key_says_what_was_expected(tmp_path: Path, text: str, words: str) -> None:
    file = tmp_path / "stern.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(DescriptionError, match=words):
        read_strictly(file, Stern)


def test_a_long_value_is_shortened_in_the_message(tmp_path: Path) -> None:
    with pytest.raises(DescriptionError, match=r"count: expected an integer, got 'a{56}\.\.\.\."):
        read(tmp_path, f'name = "a"\ncount = "{"a" * 100}"')
