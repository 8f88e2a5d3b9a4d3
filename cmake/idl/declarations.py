"""The declarations of an IDL file, their sizes, and the type description that generated code contains."""
import functools
import json
import os
from dataclasses import dataclass, field


# The limits of model/type.hpp: bytes of a sample, fields of a type including those of nested structs, nesting levels of
# structs, characters of a name, bytes of a description.
MAX_SAMPLE = 64 * 1024 * 1024
MAX_FIELDS = 4096
MAX_NESTING = 16
MAX_NAME = 255
MAX_DESCRIPTION = 1024 * 1024

# For each scalar IDL type: the size in bytes, and the type in C and C++.
SCALARS = {
    "boolean": (1, "bool"), "octet": (1, "uint8_t"), "char": (1, "char"), "int8": (1, "int8_t"),
    "short": (2, "int16_t"), "unsigned short": (2, "uint16_t"), "long": (4, "int32_t"), "unsigned long": (4, "uint32_t"),
    "long long": (8, "int64_t"), "unsigned long long": (8, "uint64_t"), "float": (4, "float"), "double": (8, "double"),
}
# Alternative IDL names of the types in SCALARS.
SAME = {"uint8": "octet", "int16": "short", "uint16": "unsigned short", "int32": "long", "uint32": "unsigned long",
        "int64": "long long", "uint64": "unsigned long long"}
NOT_NUMBERS = ("boolean", "char", "string", "enum", "struct")
INTEGERS = {name: (size, name.startswith("unsigned") or name == "octet")
            for name, (size, _) in SCALARS.items() if name not in ("boolean", "char", "float", "double")}


@dataclass
class Shape:
    """The type of a field: an array (dimensions) of sequences of arrays (elements) of a scalar, a string, an enum or a struct."""
    scalar: str                     # a key of SCALARS, or "string", "enum", "struct"; "" for an invalid type
    bound: int = 0                  # for a string: its bound
    of: object = None               # for an enum or a struct: its declaration
    dimensions: list = field(default_factory=list)
    sequence: int = 0
    elements: list = field(default_factory=list)
    text: str = ""                  # the type in IDL, without the dimensions after a name, with numbers instead of constants

    def has_sequence(self):
        return self.sequence > 0 or (self.scalar == "struct" and self.of.sequences)

    def may_not_fit(self):
        """True if a C++ variable can have a value that the type does not allow: too long a sequence, or a number without an enumerator."""
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
    own: list                       # the dimensions after the name
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
    own: list                       # the dimensions after the name
    unit: str                       # "" if the file gives none
    place: tuple


@dataclass
class Struct:
    name: str
    place: tuple
    fields: list = field(default_factory=list)
    complete: bool = False

    def structs(self):
        return [f.shape.of for f in self.fields if f.shape.scalar == "struct"]

    # Each of the following properties is computed only once, because recomputing nested structs would take exponential time.

    @functools.cached_property
    def sequences(self):
        return any(f.shape.has_sequence() for f in self.fields)

    @functools.cached_property
    def misfits(self):
        return any(f.shape.may_not_fit() for f in self.fields)

    @functools.cached_property
    def valid(self):
        return all(f.shape.scalar for f in self.fields) and all(s.valid for s in self.structs())

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
    """The declared names in an IDL module, by lower-case name, because `Mode` and `mode` are the same name in IDL."""

    def __init__(self, name, outer):
        self.name = name
        self.outer = outer
        self.names = {}

    def full(self, name):
        return f"{self.name}::{name}" if self.name else name


@dataclass
class File:
    """One IDL file and its declarations, in order."""
    path: str                       # the path that messages show
    real: str                       # the real path
    declares: list = field(default_factory=list)
    includes: list = field(default_factory=list)  # (File, place)
    guarded: bool = False
    complete: bool = False

    @property
    def stem(self):
        return os.path.splitext(os.path.basename(self.real))[0]

    def sees(self):
        """The real paths of this file and of all files that it includes, directly or not."""
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


# A span says how many bytes the longest value of a type takes. The number depends on the padding, which depends on the offset at
# which the value begins. A span is therefore a list with a number for each offset modulo 8.
NOTHING = (0,) * 8


def both(first, second):
    """Returns the span of two values, one after the other, from their spans `first` and `second`."""
    return tuple(first[at] + second[(at + first[at]) % 8] for at in range(8))


def repeated(one, n):
    """Returns the span of n values that each have the span `one`, by repeated doubling."""
    span = NOTHING
    while n:
        if n % 2:
            span = both(span, one)
        one, n = both(one, one), n // 2
    return span


def aligned(size, more=0):
    """Returns the span of `size` bytes aligned to `size`, followed by `more` bytes."""
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
    """Returns the largest size of a sample on the network in bytes: with the encapsulation header, padded to 4 bytes."""
    return padded(4 + struct.span[0], 4)


def description(struct):
    """Returns the type description, which model::parse_type() parses. model/type.hpp documents its members."""
    def of_fields(fields):
        result = []
        for each in fields:
            shape = each.shape
            one = {"name": each.name, "type": shape.scalar}
            if each.unit:
                one["unit"] = each.unit
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
