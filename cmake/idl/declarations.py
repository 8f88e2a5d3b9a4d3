"""What an IDL file declares, with sizes and the description that programs carry."""
import functools
import json
import os
from dataclasses import dataclass, field


# The bounds of model/type.hpp: bytes of a sample, fields of a type with those of its structs, structs within one another,
# characters of a name, bytes of a description.
MAX_SAMPLE = 64 * 1024 * 1024
MAX_FIELDS = 4096
MAX_NESTING = 16
MAX_NAME = 255
MAX_DESCRIPTION = 1024 * 1024

# IDL's words: bytes, the type in C and C++.
SCALARS = {
    "boolean": (1, "bool"), "octet": (1, "uint8_t"), "char": (1, "char"), "int8": (1, "int8_t"),
    "short": (2, "int16_t"), "unsigned short": (2, "uint16_t"), "long": (4, "int32_t"), "unsigned long": (4, "uint32_t"),
    "long long": (8, "int64_t"), "unsigned long long": (8, "uint64_t"), "float": (4, "float"), "double": (8, "double"),
}
# Other words for the same.
SAME = {"uint8": "octet", "int16": "short", "uint16": "unsigned short", "int32": "long", "uint32": "unsigned long",
        "int64": "long long", "uint64": "unsigned long long"}
INTEGERS = {name: (size, name.startswith("unsigned") or name == "octet")
            for name, (size, _) in SCALARS.items() if name not in ("boolean", "char", "float", "double")}


@dataclass
class Shape:
    """What a field is: an array (dimensions) of sequences of arrays (elements) of a scalar, an enum or a struct."""
    scalar: str                     # of SCALARS, or "string", "enum", "struct"; "" where it is wrong
    bound: int = 0                  # of a string
    of: object = None               # the Enum or Struct
    dimensions: list = field(default_factory=list)
    sequence: int = 0
    elements: list = field(default_factory=list)
    text: str = ""                  # the type as IDL, without the dimensions behind a name; constants are numbers

    def has_sequence(self):
        return self.sequence > 0 or (self.scalar == "struct" and self.of.sequences)

    def may_not_fit(self):
        """A value in C++ may be none of the type: too long, or no enumerator."""
        return self.sequence > 0 or self.scalar == "enum" or (self.scalar == "struct" and self.of.misfits)


@dataclass
class Const:
    name: str
    type: str
    value: int
    place: tuple


@dataclass
class Alias:
    name: str
    shape: Shape
    own: list                       # dimensions behind the name
    place: tuple


@dataclass
class Enum:
    name: str
    place: tuple
    enumerators: list = field(default_factory=list)


@dataclass
class Enumerator:
    name: str
    place: tuple


@dataclass
class Field:
    name: str
    shape: Shape
    own: list                       # dimensions behind the name
    place: tuple


@dataclass
class Struct:
    name: str
    place: tuple
    fields: list = field(default_factory=list)
    complete: bool = False

    def structs(self):
        return [f.shape.of for f in self.fields if f.shape.scalar == "struct"]

    # Asked once each: a struct that has another one twice would be asked for all of them again.

    @functools.cached_property
    def sequences(self):
        return any(f.shape.has_sequence() for f in self.fields)

    @functools.cached_property
    def misfits(self):
        return any(f.shape.may_not_fit() for f in self.fields)

    @functools.cached_property
    def sound(self):
        return all(f.shape.scalar for f in self.fields) and all(s.sound for s in self.structs())

    @functools.cached_property
    def count(self):
        return len(self.fields) + sum(s.count for s in self.structs())

    @functools.cached_property
    def nesting(self):
        return 1 + max((s.nesting for s in self.structs()), default=0)

    @functools.cached_property
    def span(self):
        return functools.reduce(both, (span_of(f.shape) for f in self.fields), NOTHING)


class Scope:
    """The names of a module, by their lower case: IDL does not tell `Mode` from `mode`."""

    def __init__(self, name, outer):
        self.name = name
        self.outer = outer
        self.names = {}

    def full(self, name):
        return f"{self.name}::{name}" if self.name else name


@dataclass
class File:
    """One IDL file and what it declares, in order."""
    path: str                       # as it is printed
    real: str
    declares: list = field(default_factory=list)
    includes: list = field(default_factory=list)  # (File, place)
    guarded: bool = False
    complete: bool = False

    @property
    def stem(self):
        return os.path.splitext(os.path.basename(self.real))[0]

    def sees(self):
        seen, todo = set(), [self]
        while todo:
            file = todo.pop()
            if file.real not in seen:
                seen.add(file.real)
                todo += [other for other, _ in file.includes]
        return seen


def product(numbers):
    result = 1
    for number in numbers:
        result *= number
    return result


def padded(position, alignment):
    return (position + alignment - 1) // alignment * alignment


# A span: the bytes that the longest value appends, by the place in 8 bytes where it begins; padding depends on nothing else.
NOTHING = (0,) * 8


def both(first, second):
    return tuple(first[at] + second[(at + first[at]) % 8] for at in range(8))


def repeated(one, n):
    span = NOTHING
    while n:
        if n % 2:
            span = both(span, one)
        one, n = both(one, one), n // 2
    return span


def aligned(size, more=0):
    return tuple(padded(at, size) - at + size + more for at in range(8))


def span_of(shape):
    if shape.scalar == "struct":
        one = shape.of.span
    elif shape.scalar == "string":
        one = aligned(4, shape.bound + 1)
    else:
        one = aligned(4 if shape.scalar == "enum" else SCALARS[shape.scalar][0])
    if shape.sequence:
        one = both(aligned(4), repeated(one, shape.sequence * product(shape.elements)))
    return repeated(one, product(shape.dimensions))


def max_size(struct):
    """With the encapsulation, and in whole words, as RTPS sends it."""
    return padded(4 + struct.span[0], 4)


def description(struct):
    """What model::parse_type() reads; model/type.hpp says what the members mean."""
    def of_fields(fields):
        result = []
        for each in fields:
            shape = each.shape
            one = {"name": each.name, "type": shape.scalar}
            if shape.scalar == "string":
                one["bound"] = shape.bound
            if shape.dimensions:
                one["array"] = shape.dimensions
            if shape.sequence:
                one["sequence"] = shape.sequence
            if shape.elements:
                one["elements"] = shape.elements
            if shape.scalar == "enum":
                one["of"] = shape.of.name
                one["enumerators"] = shape.of.enumerators
            if shape.scalar == "struct":
                one["of"] = shape.of.name
                one["fields"] = of_fields(shape.of.fields)
            result.append(one)
        return result

    return json.dumps({"name": struct.name, "fields": of_fields(struct.fields)}, separators=(",", ":"))
