#!/usr/bin/env python3
"""The types of ports: from IDL to what takt::PortType<T> and modules in C need of them.

  takt_idl.py --check a.idl b.idl          only says what is wrong
  takt_idl.py --out DIR a.idl b.idl        writes DIR/a.hpp, a_types.cpp, a_c.h, a_c.cpp and the same of b.idl

A port type is a final struct without keys whose strings and sequences are bounded, so that memory is decided before
anything runs. What no port can carry is said all at once, one problem a line, `file:line: error: what; what would be right`,
and ends with exit status 1. What is accepted here is accepted by fastddsgen and by Cyclone DDS's idlc too.
"""
import argparse
import functools
import json
import os
import re
import sys
from dataclasses import dataclass, field, replace

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

# Words of IDL, for idlc in any mix of upper and lower case.
ANY_CASE_WORDS = set("""any bitfield bitmask bitset boolean case char const default double enum false fixed float int8 int16
    int32 int64 long map module native octet sequence short string struct switch true typedef uint8 uint16 uint32 uint64 union
    unsigned wchar wstring""".split())
# More of them, for fastddsgen as they are written here.
WORDS = set("""Object ValueBase abstract annotation attribute component consumes context custom emits eventtype exception
    factory finder getraises home import in inout interface local manages multiple oneway out primarykey private provides
    public publishes raises readonly set setraises supports truncatable typeid typeprefix uses valuetype void""".split())
# Names that the generated C and C++ cannot have.
CODE_WORDS = set("""alignas alignof and and_eq asm auto bitand bitor bool break catch char8_t char16_t char32_t class compl
    concept consteval constexpr constinit const_cast continue co_await co_return co_yield decltype delete do dynamic_cast
    else explicit export extern for friend goto if inline int mutable namespace new noexcept not not_eq nullptr operator or
    or_eq protected register reinterpret_cast requires restrict return signed sizeof static static_assert static_cast
    template this thread_local throw try typeof volatile while xor xor_eq std eprosima takt linux unix NULL EOF errno
    serialize deserialize serializeKey isKeyDefined getMaxCdrSerializedSize getCdrSerializedSize
    getKeyMaxCdrSerializedSize""".split()) - {"takt"}
# Headers of the system: motion.idl makes motion.h, which is found as <motion.h>.
SYSTEM_HEADERS = set("""alloca assert complex ctype dirent dlfcn elf endian errno fcntl features fenv float inttypes iso646
    limits link locale malloc math memory poll pthread sched semaphore setjmp signal spawn stdalign stdarg stdatomic stdbool
    stddef stdint stdio stdlib stdnoreturn string strings syscall termios tgmath threads time uchar unistd utime values wait
    wchar wctype""".split())


class Problems:
    """What is wrong, by file and line; each said once."""

    def __init__(self):
        self.seen = {}

    def add(self, place, text):
        self.seen.setdefault((place, text))

    def print(self, order):
        rank = {name: i for i, name in enumerate(order)}
        for (file, line), text in sorted(self.seen, key=lambda p: (rank.get(p[0][0], len(rank)), p[0][1])):
            print(f"{file}:{line}: error: {text}", file=sys.stderr)


class Wrong(Exception):
    """The text cannot be understood from here to the end of the declaration."""

    def __init__(self, place, text):
        super().__init__(text)
        self.place = place


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


# ---- Text to tokens -------------------------------------------------------------------------------------------------

TOKEN = re.compile(r"""
    (?P<space>[ \t\r\f\v]+|\n|//[^\n]*|/\*.*?\*/)
  | (?P<directive>\#[^\n]*)
  | (?P<name>[A-Za-z_][A-Za-z_0-9]*)
  | (?P<number>(?:0[xX][0-9A-Fa-f]+|[0-9]+)(?![A-Za-z_0-9.]))
  | (?P<literal>[0-9][A-Za-z_0-9.]*|"(?:[^"\\\n]|\\.)*"|'(?:[^'\\\n]|\\.)*')
  | (?P<sign>::|<<|[{}()\[\]<>,;:=@+\-*/%|&^~])
""", re.X | re.S)


@dataclass
class Token:
    kind: str
    text: str
    line: int
    at: int


def tokens_of(text, path, problems):
    tokens, at, line, fresh = [], 0, 1, True
    while at < len(text):
        match = TOKEN.match(text, at)
        open_comment = text.startswith("/*", at) and (not match or match.lastgroup != "space")
        if open_comment or not match or (match.lastgroup == "directive" and not fresh):
            problems.add((path, line), "a comment without an end; write */" if open_comment
                         else f"{text[at]!r} means nothing here; take it out")
            at = len(text) if open_comment else at + 1
            continue
        if match.lastgroup != "space":
            tokens.append(Token(match.lastgroup, match.group(), line, at))
            fresh = match.lastgroup == "directive"
        elif "\n" in match.group():
            fresh = True
        line += match.group().count("\n")
        at = match.end()
    return tokens + [Token("end", "the end of the file", line, at)]


# ---- Tokens to declarations --------------------------------------------------------------------------------------------

class Parser:
    """One file, with those that it includes."""

    def __init__(self, library, file, text):
        self.library = library
        self.problems = library.problems
        self.file = file
        self.scope = library.root
        self.tokens = tokens_of(text, file.path, self.problems)
        self.at = 0
        self.directives()

    def directives(self):
        """Takes them out of the tokens: #include, and the three lines that keep a file from being read twice."""
        found = [t for t in self.tokens if t.kind == "directive"]
        words = [t.text[1:].split("//")[0].split() for t in found]
        self.file.guarded = (
            len(found) >= 3 and words[0][:1] == ["ifndef"] and words[1][:1] == ["define"] and words[-1][:1] == ["endif"]
            and len(words[0]) == 2 and words[0][1:] == words[1][1:] and self.tokens[0] is found[0]
            and self.tokens[1] is found[1] and self.tokens[-2] is found[-1])
        if self.file.guarded:
            found = found[2:-1]
        for directive in found:
            name = re.fullmatch(r'#\s*include\s*"([^"]+)"\s*(//.*|/\*.*)?', directive.text)
            if name:
                self.library.include(self.file, name.group(1), self.place(directive))
            elif re.match(r"#\s*include", directive.text):
                self.problem(directive, 'write #include "file.idl", with the file named from where this one is')
            else:
                self.problem(directive, f"{directive.text.strip()} is not for the types of ports; besides #include only "
                             "#ifndef NAME, #define NAME and #endif around the whole file are")
        self.tokens = [t for t in self.tokens if t.kind != "directive"]

    # -- Where we are

    @property
    def token(self):
        return self.tokens[self.at]

    def place(self, token=None):
        return (self.file.path, (token or self.token).line)

    def problem(self, token, text):
        self.problems.add(self.place(token), text)

    def next(self):
        token = self.token
        if token.kind != "end":
            self.at += 1
        return token

    def is_next(self, *texts):
        return self.token.text in texts and self.token.kind in ("name", "sign")

    def take(self, text):
        if not self.is_next(text):
            return False
        self.next()
        return True

    def expect(self, text, after):
        if not self.take(text):
            # A missing end is missing on the line before.
            token = self.tokens[self.at - 1] if text == ";" and self.at > 0 else self.token
            raise Wrong(self.place(token), f"{after} is followed by {self.token.text!r}; write {text!r}"
                        if self.token.kind != "end" else f"{after} has no end; write {text!r}")

    def skip(self):
        """To the end of a declaration that was not understood."""
        depth = 0
        while self.token.kind != "end":
            if self.is_next("}") and depth == 0:
                return
            token = self.next()
            depth += (token.text == "{") - (token.text == "}")
            if depth == 0 and token.text == "}" and not self.is_next(";"):
                if self.token.kind != "name" or self.tokens[self.at + 1].text not in (";", ",", "["):
                    return  # else the names of what was declared follow
            if depth == 0 and token.text == ";":
                return

    def guarded(self, parse):
        start = self.at
        try:
            parse()
        except Wrong as wrong:
            self.problems.add(wrong.place, str(wrong))
            self.at = max(self.at, start)
            self.skip()
            if self.at == start:
                self.next()

    # -- Names

    def new_name(self, what, full=None):
        token = self.next()
        if token.kind != "name":
            raise Wrong(self.place(token), f"{token.text!r} stands where the name of {what} is to be")
        name = token.text
        shown = full(name) if full else name
        if name in WORDS or name.lower() in ANY_CASE_WORDS:
            how = "" if name in WORDS or name in ANY_CASE_WORDS else ", in upper and lower case"
            self.problem(token, f"{shown}: {name!r} is a word of IDL{how}; take another name")
        elif name in CODE_WORDS:
            self.problem(token, f"{shown}: {name!r} has a meaning in the C++ that is made of it; take another name")
        elif name.startswith("_"):
            self.problem(token, f"{shown}: a name begins with a letter; leave out the '_'")
        elif len(shown) > MAX_NAME:
            self.problem(token, f"{name[:60]}...: a name has at most {MAX_NAME} characters with those of its modules")
        return token

    def declare(self, token, entity):
        known = self.scope.names.get(token.text.lower())
        own = self.scope.name.split("::")[-1]
        if token.text.lower() == own.lower():
            self.problem(token, f"{self.scope.full(token.text)} has the name of its module{'' if token.text == own else ', which differs only in upper and lower case'}; "
                         "take another name")
        if known is None:
            self.scope.names[token.text.lower()] = (token.text, entity)
            return True
        file, line = known[1].place if not isinstance(known[1], Scope) else known[1].place
        full = self.scope.full(token.text)
        if known[0] == token.text:
            self.problem(token, f"{full} is declared in {file}:{line} already; take another name")
        else:
            self.problem(token, f"{full} differs only in upper and lower case from {known[0]} in {file}:{line}, and IDL does "
                         "not tell them apart; take another name")
        return False

    def scoped_name(self):
        """The tokens of a::b::c as text, whether it begins with ::, and the first token."""
        first = self.token
        absolute = self.take("::")
        parts = []
        while True:
            token = self.next()
            if token.kind != "name":
                raise Wrong(self.place(token), f"{token.text!r} stands where a name is to be")
            parts.append(token.text)
            if not self.take("::"):
                return absolute, parts, first

    def find(self, absolute, parts, token, where="", members=()):
        """The entity of a name as it is seen here, or None with a problem told of what is declared there."""
        shown = where + ("::" if absolute else "") + "::".join(parts)
        for member in members if len(parts) == 1 and not absolute else ():
            if member.lower() == parts[0].lower():
                self.problem(token, f"{where}{parts[0]} means a field here, for one before it is named {member}, and IDL does not tell upper "
                             "from lower case; name the field otherwise")
                return None
        scope, known = (self.library.root if absolute else self.scope), None
        while scope is not None:
            known = scope.names.get(parts[0].lower())
            if known is not None:
                break
            scope = None if absolute else scope.outer
        for before, part in zip(parts, parts[1:]):
            if known is not None:
                inner = isinstance(known[1], Scope) and known[0] == before
                known = known[1].names.get(part.lower()) if inner else None
        if known is None:
            self.problem(token, f"{shown} is not declared before this line; declare it, or #include the file that does")
            return None
        if isinstance(known[1], Scope):
            self.problem(token, f"{shown} is a module; write the name of something in it")
            return None
        if known[0] != parts[-1]:
            self.problem(token, f"{shown} is declared as {known[0]}; write it so")
            return None
        entity = known[1]
        real = self.library.real_of(entity.place[0])
        if real not in self.file.sees():
            self.problem(token, f"{shown} is declared in {entity.place[0]}, which is not included here; write #include "
                         f"\"{os.path.relpath(real, os.path.dirname(self.file.real))}\"")
            return None
        return entity

    # -- Declarations

    def parse(self):
        while self.token.kind != "end":
            if self.is_next("}"):
                self.problem(self.next(), "a '}' without a '{' before it; take it out")
                self.take(";")
            else:
                self.guarded(self.declaration)

    def declaration(self):
        annotations = self.annotations()
        token = self.token
        if self.is_next("struct"):
            return self.struct(annotations)
        for annotation in annotations:
            self.problem(annotation, f"@{annotation.text} is only for a struct here; leave it out")
        if self.is_next("module"):
            return self.module()
        if self.is_next("enum"):
            return self.enum()
        if self.is_next("typedef"):
            return self.typedef()
        if self.is_next("const"):
            return self.const()
        if self.take(";"):
            return self.problem(token, "a ';' that ends nothing; take it out")
        raise Wrong(self.place(), f"{token.text!r} is not for the types of ports; a file has modules, and in them structs, enums, "
                    "typedefs and constants")

    def annotations(self):
        """Returns their names' tokens; @extensibility(FINAL) is @final."""
        found = []
        while self.is_next("@"):
            self.next()
            if self.token.kind != "name" or self.is_next("struct", "enum", "module", "typedef", "const"):
                self.problem(self.token, "an '@' without a name; write @final")
                continue
            name = self.next()
            argument = None
            if self.take("("):
                depth, argument = 1, ""
                while depth > 0:
                    token = self.next()
                    if token.kind == "end":
                        raise Wrong(self.place(name), f"@{name.text}( has no end; write ')'")
                    depth += (token.text == "(") - (token.text == ")")
                    argument += token.text if depth else ""
            if name.text == "extensibility" and argument is not None:
                final = argument == "FINAL"
                name = Token("name", "final" if final else f"extensibility({argument})", name.line, name.at)
            elif argument is not None and name.text == "final":
                self.problem(name, "@final has no argument; leave it out")
            found.append(name)
        return found

    def body(self, what, each):
        """{ each each ... };"""
        self.expect("{", what)
        opened = self.tokens[self.at - 1]
        while not self.is_next("}"):
            if self.token.kind == "end":
                raise Wrong(self.place(opened), f"{what} has no end; write '}};'")
            try:
                each()
            except Wrong as wrong:
                self.problems.add(wrong.place, str(wrong))
                while not self.is_next("}", "{", ";") and self.token.kind != "end":
                    self.next()
                if not self.is_next("}"):
                    raise Wrong(self.place(opened), f"{what} has no end; write '}};'") from None
        self.next()
        if not self.take(";"):
            self.problem(self.tokens[self.at - 1], f"{what} ends without ';'; write it")

    def module(self):
        self.next()
        token = self.new_name("a module", self.scope.full)
        known = self.scope.names.get(token.text.lower())
        if known and known[0] == token.text and isinstance(known[1], Scope):
            inner = known[1]
        else:
            inner = Scope(self.scope.full(token.text), self.scope)
            inner.place = self.place(token)
            self.declare(token, inner)
        outer, self.scope = self.scope, inner
        try:
            self.body(f"module {inner.name}", lambda: self.guarded(self.declaration))
        finally:
            self.scope = outer

    def const(self):
        self.next()
        type_token = self.token
        kind = self.basic_type()
        name = None
        if kind is None and self.take("string"):
            kind = "string"
        if kind is None and self.token.kind == "name":
            absolute, parts, first = self.scoped_name()
            entity = self.find(absolute, parts, first)
            kind = entity.shape.scalar if isinstance(entity, Alias) and not entity.shape.dimensions else "?"
        token = self.new_name("a constant", self.scope.full)
        name = self.scope.full(token.text)
        if kind not in INTEGERS:
            self.problem(type_token, f"{name} is not of an integer type; constants are integers here, as unsigned long")
            raise_at = self.at
            while not self.is_next(";", "}") and self.token.kind != "end":
                self.next()
            self.at = max(self.at, raise_at)
            self.take(";")
            self.declare(token, Const(name, "", None, self.place(token)))
            return
        self.expect("=", f"const {name}")
        value = self.expression()
        self.expect(";", f"const {name}")
        size, unsigned = INTEGERS[kind]
        low, high = (0, 2 ** (8 * size) - 1) if unsigned else (-2 ** (8 * size - 1), 2 ** (8 * size - 1) - 1)
        if value is not None and not low <= value <= high:
            self.problem(token, f"{name} is {value}, which {kind} cannot hold; it is from {low} to {high}")
            value = None
        const = Const(name, kind, value, self.place(token))
        if self.declare(token, const):
            self.file.declares.append(const)

    def enum(self):
        self.next()
        token = self.new_name("an enum", self.scope.full)
        enum = Enum(self.scope.full(token.text), self.place(token))
        declared = self.declare(token, enum)

        def each():
            for annotation in self.annotations():
                self.problem(annotation, f"{enum.name}: enumerators are numbered from 0 in their order, without "
                             f"@{annotation.text}; leave it out")
            name = self.new_name("an enumerator", self.scope.full)
            if self.declare(name, Enumerator(self.scope.full(name.text), self.place(name))):
                enum.enumerators.append(name.text)
            if self.is_next("="):
                self.problem(name, f"{self.scope.full(name.text)}: enumerators are numbered from 0 in their order; leave out the "
                             "'='")
                while not self.is_next(",", "}", ";") and self.token.kind != "end":
                    self.next()
            if not self.take(",") and not self.is_next("}"):
                raise Wrong(self.place(), f"{self.scope.full(name.text)} is followed by {self.token.text!r}; write ','")
            if self.tokens[self.at - 1].text == "," and self.is_next("}"):
                self.problem(self.tokens[self.at - 1], f"{enum.name} has a ',' after its last enumerator; take it out")

        self.body(f"enum {enum.name}", each)
        if not enum.enumerators:
            self.problem(token, f"{enum.name} has no enumerators; an enum has at least one")
        if declared:
            self.file.declares.append(enum)

    def typedef(self):
        self.next()
        shape = self.type_of(self.declared_name(self.scope.full, "a typedef"), self.token)
        for token, own, whole in self.declarators(shape, "a typedef", self.scope.full):
            alias = Alias(self.scope.full(token.text), whole, own, self.place(token))
            if self.declare(token, alias):
                self.file.declares.append(alias)

    def struct(self, annotations):
        self.next()
        token = self.new_name("a struct", self.scope.full)
        struct = Struct(self.scope.full(token.text), self.place(token))
        if self.is_next(";"):
            raise Wrong(self.place(token), f"{struct.name} is announced and not declared; a struct is declared once, before those "
                        "that have it as a field")
        if self.is_next(":"):
            raise Wrong(self.place(token), f"{struct.name} inherits, which ports cannot carry; make the other struct a field")
        kinds = [a.text for a in annotations]
        for annotation in annotations:
            if annotation.text != "final":
                self.problem(annotation, f"{struct.name} has @{annotation.text}; the only annotation of a port's type is @final")
        if "final" not in kinds:
            self.problem(token, f"{struct.name} is not final; write @final before it")
        declared = self.declare(token, struct)
        self.body(f"struct {struct.name}", lambda: self.guarded(lambda: self.fields(struct)))
        struct.complete = True
        if not struct.fields:
            self.problem(token, f"{struct.name} has no fields; a struct has at least one")
        if declared:
            self.file.declares.append(struct)

    def fields(self, struct):
        annotations = self.annotations()
        full = lambda name: f"{struct.name}.{name}"
        shown = self.declared_name(full, f"a field of {struct.name}")
        for annotation in annotations:
            told = ("is a key; the types of ports have none" if annotation.text in ("key", "Key")
                    else f"has @{annotation.text}; the fields of a port's type have no annotations")
            self.problem(annotation, f"{shown} {told}")
        shape = self.type_of(shown, self.token, [f.name for f in struct.fields])
        for token, own, whole in self.declarators(shape, "a field", full):
            if token.text.lower() == struct.name.split("::")[-1].lower():
                self.problem(token, f"{struct.name}.{token.text} has the name of its struct; take another name")
            if whole.sequence and whole.scalar in ("enum", "string"):
                # Fast CDR has no function for vectors of these within other things.
                what = ("an array of sequences", "the sequence", "an array") if whole.dimensions else \
                    ("a sequence of arrays", "the array", "a sequence") if whole.elements else None
                if what:
                    self.problem(token, f"{full(token.text)} is {what[0]} of {whole.scalar}s, of which fastddsgen makes code that does not "
                                 f"compile; put {what[1]} into a struct and write {what[2]} of those")
            twin = next((f for f in struct.fields if f.name.lower() == token.text.lower()), None)
            if twin:
                how = "is there twice" if twin.name == token.text else f"differs only in upper and lower case from {twin.name}"
                self.problem(token, f"{struct.name}.{token.text} {how}; take another name")
            else:
                struct.fields.append(Field(token.text, whole, own, self.place(token)))

    def declarators(self, shape, what, full):
        """a, b[3], c[2][4]; as (token, dimensions, shape)."""
        while True:
            token = self.new_name(what, full)
            dimensions = []
            while self.take("["):
                if self.is_next("]"):
                    self.problem(token, f"{full(token.text)} is an array without a size; write [6]")
                    size = 1
                else:
                    size = self.bound(f"{full(token.text)}", "the size of an array")
                self.expect("]", f"the size of {full(token.text)}")
                dimensions.append(size)
            yield token, dimensions, Shape(shape.scalar, shape.bound, shape.of, dimensions + shape.dimensions, shape.sequence,
                                           shape.elements, shape.text)
            if self.take(","):
                continue
            return self.expect(";", full(token.text))

    # -- Types

    def basic_type(self):
        """One of SCALARS, None when the next tokens are none. Real numbers of other sizes are told."""
        token = self.token
        if self.take("unsigned"):
            if self.take("short"):
                return "unsigned short"
            if self.take("long"):
                return "unsigned long long" if self.take("long") else "unsigned long"
            raise Wrong(self.place(token), f"unsigned {self.token.text} is no type; write unsigned short, unsigned long or unsigned "
                        "long long")
        if self.take("long"):
            if self.take("double"):
                return "long double"
            return "long long" if self.take("long") else "long"
        if token.kind == "name" and token.text in SCALARS or token.text in SAME:
            self.next()
            return SAME.get(token.text, token.text)
        return None

    def declared_name(self, full, otherwise):
        """Of a declaration that begins here: it stands after the type, and the problems of the type are to name it."""
        at, depth = self.at, 0
        while self.tokens[at].kind != "end":
            text = self.tokens[at].text
            depth += (text in "<{") - (text in ">}")
            if depth < 0 or depth == 0 and text in (";", ",", "["):
                break
            at += 1
        token = self.tokens[at - 1]
        return full(token.text) if at > self.at and token.kind == "name" else otherwise

    def type_of(self, name, token, members=()):
        """A type as it is written before a name, which is for problems."""
        wrong = Shape("")
        if self.take("string"):
            if not self.take("<") or self.take(">"):
                self.problem(token, f"{name} is a string without a bound; write string<64>")
                return wrong
            bound = self.bound(name, "the bound of a string")
            self.expect(">", f"the bound of {name}")
            return Shape("string", bound, text=f"string<{bound}>")
        if self.take("sequence"):
            self.expect("<", f"the sequence of {name}")
            element = self.type_of(name, token, members)
            if element.scalar and element.has_sequence():
                how = ("is a sequence of sequences" if element.sequence else
                       f"is a sequence of {element.of.name}, which has a sequence itself")
                self.problem(token, f"{name} {how}, whose memory no port can decide beforehand; write an array of them, as in "
                             "sequence<double, 8> rows[4]")
                element = wrong
            if not self.take(","):
                if not self.take(">"):
                    self.expect(",", f"the sequence of {name}")
                word = element.of.name if element.of else element.scalar or "T"
                if element.scalar == "string":
                    word = f"string<{element.bound}>"
                self.problem(token, f"{name} is a sequence without a bound; write sequence<{word}, 16>")
                return wrong
            bound = self.bound(name, "the bound of a sequence")
            self.expect(">", f"the sequence of {name}")
            if not element.scalar:
                return wrong
            return Shape(element.scalar, element.bound, element.of, [], bound, element.dimensions,
                         f"sequence<{element.text}, {bound}>")
        scalar = self.basic_type()
        if scalar in SCALARS:
            return Shape(scalar, text=scalar)
        if scalar == "long double":
            self.problem(token, f"{name} is a long double, which is not the same on every machine; write double")
            return wrong
        for word, fix in {"wstring": "string<64>, as UTF-8", "wchar": "unsigned short", "any": "a struct", "map": "a sequence of structs",
                          "fixed": "double", "bitset": "unsigned long", "bitmask": "unsigned long", "union": "a struct with an enum",
                          "struct": "its name, and declare it before", "enum": "its name, and declare it before",
                          "Object": "a struct"}.items():
            if self.is_next(word):
                article = "an" if word[0] in "aeO" else "a"
                raise Wrong(self.place(token), f"{name} is {article} {word}, which ports cannot carry; write {fix}")
        if self.token.kind != "name" and not self.is_next("::"):
            raise Wrong(self.place(), f"{self.token.text!r} stands where a type is to be")
        absolute, parts, first = self.scoped_name()
        if parts[0] in WORDS or parts[0].lower() in ANY_CASE_WORDS:
            raise Wrong(self.place(first), f"{name} is of type {parts[0]!r}, which ports cannot carry; write a type of IDL as double "
                        "or a struct")
        entity = self.find(absolute, parts, first, f"{name}: ", members)
        if isinstance(entity, Struct):
            if not entity.complete:
                self.problem(first, f"{name} has {entity.name} within itself, which ports cannot carry; write an array or a bounded "
                             "sequence of another struct")
                return wrong
            return Shape("struct", of=entity, text=entity.name)
        if isinstance(entity, Enum):
            return Shape("enum", of=entity, text=entity.name)
        if isinstance(entity, Alias):
            return replace(entity.shape, text=entity.name)
        if entity is not None:
            self.problem(first, f"{name}: {'::'.join(parts)} is no type; write a struct, an enum or a typedef")
        return wrong

    def bound(self, name, what):
        """A size from 1; a wrong one counts as 1."""
        token = self.token
        value = self.expression(in_angles=True)
        if value is None:
            return 1
        if not 1 <= value <= MAX_SAMPLE:
            self.problem(token, f"{name}: {what} is {value}; it is from 1 to {MAX_SAMPLE}")
            return 1
        return value

    # -- Constant expressions

    LEVELS = [("|",), ("^",), ("&",), ("<<", ">>"), ("+", "-"), ("*", "/", "%")]

    def expression(self, level=0, in_angles=False):
        """An integer, None where it is wrong (and told)."""
        if level == len(self.LEVELS):
            return self.unary()
        left = self.expression(level + 1, in_angles)
        while True:
            token = self.token
            sign = token.text if token.kind == "sign" else ""
            if sign == ">" and not in_angles and self.tokens[self.at + 1].text == ">" and self.tokens[self.at + 1].at == token.at + 1:
                sign = ">>"
            if sign not in self.LEVELS[level]:
                return left
            self.next()
            if sign == ">>":
                self.next()
            right = self.expression(level + 1, in_angles)
            left = self.apply(token, sign, left, right)

    def apply(self, token, sign, left, right):
        if left is None or right is None:
            return None
        if sign in ("/", "%") and right == 0:
            self.problem(token, "a division by 0; write another number")
            return None
        if sign in ("<<", ">>") and not 0 <= right < 64:
            self.problem(token, f"a shift by {right}; it is from 0 to 63")
            return None
        quotient = abs(left) // abs(right) * (1 if (left < 0) == (right < 0) else -1) if sign in ("/", "%") else 0
        result = {"|": lambda: left | right, "^": lambda: left ^ right, "&": lambda: left & right, "<<": lambda: left << right,
                  ">>": lambda: left >> right, "+": lambda: left + right, "-": lambda: left - right, "*": lambda: left * right,
                  "/": lambda: quotient, "%": lambda: left - quotient * right}[sign]()
        # Beyond this idlc refuses it, or is wrong: -4 / 2 is 9223372036854775806.
        if sign not in ("|", "^", "&") and not all(0 <= n < 2 ** 32 for n in (left, right, result)):
            self.problem(token, f"{left} {sign} {right} is {result}, but compilers of IDL agree only on numbers from 0 to {2 ** 32 - 1}; write "
                         "the result")
        return result

    def unary(self):
        token = self.token
        if self.is_next("+", "-", "~"):
            sign = self.next().text
            value = self.primary()
            return None if value is None else {"+": value, "-": -value, "~": ~value}[sign]
        return self.primary()

    def primary(self):
        token = self.token
        if self.take("("):
            value = self.expression()
            self.expect(")", "the expression")
            return value
        if token.kind == "number":
            self.next()
            if re.fullmatch(r"0[0-7]+", token.text):
                return int(token.text, 8)
            if re.fullmatch(r"0[0-9]+", token.text):
                raise Wrong(self.place(token), f"{token.text} begins as an octal number and is none; leave out the 0")
            return int(token.text, 0)
        if token.kind == "name" and token.text.lower() not in ANY_CASE_WORDS or self.is_next("::"):
            absolute, parts, first = self.scoped_name()
            entity = self.find(absolute, parts, first)
            if entity is not None and not isinstance(entity, Const):
                self.problem(first, f"{'::'.join(parts)} is no constant; write an integer or the name of a constant")
            return entity.value if isinstance(entity, Const) else None
        raise Wrong(self.place(token), f"{token.text!r} stands where an integer is to be")


class Library:
    """The files that become one library of types."""

    def __init__(self):
        self.problems = Problems()
        self.root = Scope("", None)
        self.files = {}             # by real path, in the order in which they were read
        self.named = []             # on the command line

    def real_of(self, path):
        return next((f.real for f in self.files.values() if f.path == path), path)

    def read(self, path):
        real = os.path.realpath(path)
        if real in self.files:
            return self.files[real]
        file = self.files[real] = File(path, real)
        try:
            with open(path, encoding="utf-8") as stream:
                text = stream.read()
        except (OSError, UnicodeDecodeError) as error:
            reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8"
            self.problems.add((path, 1), f"the file cannot be read: {reason}")
            file.complete = True
            return file
        Parser(self, file, text).parse()
        file.complete = True
        return file

    def include(self, by, name, place):
        path = os.path.join(os.path.dirname(by.path), name)
        if not os.path.isfile(path):
            self.problems.add(place, f"{name} is not there; it is looked for from the folder of this file")
            return
        file = self.read(path)
        if not file.complete:
            self.problems.add(place, f"{name} includes this file; a file cannot include itself")
            return
        by.includes.append((file, place))

    def check_files(self):
        """What is wrong with files as a whole."""
        for file in self.files.values():
            # As the preprocessor sees it: a file without a guard is there as often as it is included.
            seen = {}

            def visit(by, place):
                for other, at in by.includes:
                    where = place or at
                    if other.real in seen and not other.guarded:
                        guard = other.stem.upper() + "_IDL"
                        self.problems.add(where, f"{os.path.basename(other.path)} comes twice in this file; write #ifndef {guard}, "
                                          f"#define {guard} and #endif around what is in it")
                    elif other.real not in seen:
                        seen[other.real] = True
                        visit(other, where)

            visit(file, None)
            if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", file.stem):
                self.problems.add((file.path, 1), f"{file.stem!r} becomes a part of names in C; name the file with letters, digits and '_'")
            if file.stem.lower() in SYSTEM_HEADERS:
                self.problems.add((file.path, 1), f"<{file.stem}.h> is a header of the system; name the file otherwise")
        outputs = {}
        for file in self.named:
            for output in outputs_of(file.stem):
                other = outputs.setdefault(output, file)
                if other is not file:
                    self.problems.add((file.path, 1), f"{other.path} becomes {output} too; name one of the files otherwise")
                    break
            for included, place in file.includes:
                if included not in self.named:
                    self.problems.add(place, f"{os.path.basename(included.path)} is not in the same library; name it in takt_add_idl too")

    def check_hidden(self, scope):
        """fastddsgen does not know ::a::b, so a::b has to mean the same everywhere."""
        for name, entity in scope.names.values():
            outer = self.root.names.get(name.lower())
            own = scope.name.split("::")[-1].lower() == name.lower()  # told already
            if scope is not self.root and outer and isinstance(outer[1], Scope) and not own:
                self.problems.add(entity.place, f"{scope.full(name)} hides module {outer[0]}; take another name")
            if isinstance(entity, Scope):
                self.check_hidden(entity)

    def check_types(self):
        self.check_hidden(self.root)
        names = {}
        for file in self.files.values():
            for declared in file.declares:
                if isinstance(declared, (Struct, Enum)):
                    flat = c_name(declared.name)
                    if names.setdefault(flat, declared) is not declared:
                        self.problems.add(declared.place, f"{declared.name} and {names[flat].name} are both {flat} in C; take another name")
                if not isinstance(declared, Struct) or not declared.sound:
                    continue
                if declared.count > MAX_FIELDS:
                    self.problems.add(declared.place, f"{declared.name} has {declared.count} fields with those of its structs; a type "
                                      f"has at most {MAX_FIELDS}")
                elif declared.nesting > MAX_NESTING:
                    self.problems.add(declared.place, f"{declared.name} has structs within one another {declared.nesting} deep; a type "
                                      f"has at most {MAX_NESTING}")
                elif len(description(declared)) > MAX_DESCRIPTION:
                    self.problems.add(declared.place, f"{declared.name} takes {len(description(declared))} bytes to describe; a type takes "
                                      f"at most {MAX_DESCRIPTION}: fewer fields, fewer enumerators, shorter names")
                elif max_size(declared) > MAX_SAMPLE:
                    self.problems.add(declared.place, f"a sample of {declared.name} has up to {max_size(declared)} bytes; it has at most "
                                      f"{MAX_SAMPLE}")


# ---- Sizes and descriptions --------------------------------------------------------------------------------------------

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


# ---- Code ------------------------------------------------------------------------------------------------------------

def c_name(name):
    return name.replace("::", "_")


def outputs_of(stem):
    return [f"{stem}.h", f"{stem}.hpp", f"{stem}_types.cpp", f"{stem}_c.h", f"{stem}_c.cpp"]


def literal(text):
    """A string of C, in lines."""
    pieces = [text[i:i + 90] for i in range(0, len(text), 90)] or [""]
    return "\n      ".join(json.dumps(piece) for piece in pieces)


class Code:
    """Lines of C++ that put or get the fields of a struct. In C++ they are behind functions and sequences are vectors."""

    def __init__(self, language):
        self.language = language
        self.lines = []
        self.indent = "  "
        self.variables = 0

    def line(self, text):
        self.lines.append(self.indent + text)

    def block(self, head, body):
        self.line(head + " {")
        self.indent += "  "
        body()
        self.indent = self.indent[:-2]
        self.line("}")

    def loop(self, what, over, constant, body):
        variable = f"e{self.variables}"
        self.variables += 1
        kind = "const auto&" if constant else "auto&"
        self.block(f"for ({kind} {variable} : {over})", lambda: body(variable))

    def nest(self, depth, expression, constant, body):
        if depth == 0:
            return body(expression)
        self.loop(None, expression, constant, lambda inner: self.nest(depth - 1, inner, constant, body))

    def access(self, each):
        return f"value.{each.name}()" if self.language == "c++" else f"value.{each.name}"

    # -- Putting

    def put(self, each):
        shape = each.shape
        at = self.access(each)
        if shape.sequence:
            self.nest(len(shape.dimensions), at, True, lambda e: self.put_sequence(shape, e))
        else:
            self.put_array(shape, shape.dimensions, at)

    def put_sequence(self, shape, at):
        n = f"{at}.size()" if self.language == "c++" else f"{at}.length"
        self.line(f"to.put_length({n}, {shape.sequence});")
        if self.language == "c++":
            if shape.scalar in SCALARS and shape.scalar != "boolean":
                size = product(shape.elements)
                count = n if size == 1 else f"{n} * {size}"
                pointer = f"{at}.data()" if not shape.elements else self.scalars(shape, f"{at}.data()", const=True)
                self.line(f"to.put_array({pointer}, {count});")
            elif shape.scalar == "boolean" and not shape.elements:
                self.line(f"if ({n} <= {shape.sequence}) for (const bool e : {at}) to.put(e);")
            else:
                self.block(f"if ({n} <= {shape.sequence})",
                           lambda: self.loop(None, at, True, lambda e: self.put_array(shape, shape.elements, e)))
            return
        if shape.scalar in SCALARS:
            size = product(shape.elements)
            count = n if size == 1 else f"{n} * std::size_t{{{size}}}"
            self.line(f"if ({n} <= {shape.sequence}) to.put_array({self.scalars(shape, f'{at}.items', const=True)}, {count});")
        else:
            index = f"i{self.variables}"
            self.variables += 1
            self.block(f"for (std::uint32_t {index} = 0; {index} < {n} && {index} < {shape.sequence}; ++{index})",
                       lambda: self.put_array(shape, shape.elements, f"{at}.items[{index}]"))

    def scalars(self, shape, pointer, const):
        kind = SCALARS[shape.scalar][1]
        return f"reinterpret_cast<{'const ' if const else ''}{kind}*>({pointer})"

    def put_array(self, shape, dimensions, at):
        if dimensions and shape.scalar in SCALARS:
            self.line(f"to.put_array({self.scalars(shape, f'&{at}', const=True)}, {product(dimensions)});")
        else:
            self.nest(len(dimensions), at, True, lambda e: self.put_one(shape, e))

    def put_one(self, shape, at):
        if shape.scalar == "string":
            limit = f"{at}.c_str(), {at}.size()" if self.language == "c++" else f"{at}, {shape.bound + 1}"
            self.line(f"to.put_text({limit}, {shape.bound});")
        elif shape.scalar == "enum":
            self.line(f"to.put_enumerator(static_cast<std::uint32_t>({at}), {len(shape.of.enumerators)});")
        elif shape.scalar == "struct":
            self.line(f"{self.function(shape, 'put')}(to, {at});")
        else:
            self.line(f"to.put({at});")

    def function(self, shape, what):
        return f"PortType<::{shape.of.name}>::{what}" if self.language == "c++" else f"{what}_{c_name(shape.of.name)}"

    # -- Getting

    def get(self, each):
        shape = each.shape
        at = self.access(each)
        if shape.sequence:
            self.nest(len(shape.dimensions), at, False, lambda e: self.get_sequence(shape, e))
        else:
            self.get_array(shape, shape.dimensions, at)

    def get_sequence(self, shape, at):
        if self.language == "c++":
            self.line(f"{at}.resize(from.get_length({shape.sequence}));")
            n = f"{at}.size()"
            if shape.scalar in SCALARS and shape.scalar != "boolean":
                size = product(shape.elements)
                count = n if size == 1 else f"{n} * {size}"
                pointer = f"{at}.data()" if not shape.elements else self.scalars(shape, f"{at}.data()", const=False)
                self.line(f"from.get_array({pointer}, {count});")
            elif shape.scalar == "boolean" and not shape.elements:
                self.line(f"for (auto e : {at}) e = from.get_boolean();")
            else:
                self.loop(None, at, False, lambda e: self.get_array(shape, shape.elements, e))
            return
        self.line(f"{at}.length = static_cast<std::uint32_t>(from.get_length({shape.sequence}));")
        n = f"{at}.length"
        if shape.scalar in SCALARS and shape.scalar != "boolean":
            size = product(shape.elements)
            count = n if size == 1 else f"{n} * std::size_t{{{size}}}"
            self.line(f"from.get_array({self.scalars(shape, f'{at}.items', const=False)}, {count});")
        else:
            index = f"i{self.variables}"
            self.variables += 1
            self.block(f"for (std::uint32_t {index} = 0; {index} < {n}; ++{index})",
                       lambda: self.get_array(shape, shape.elements, f"{at}.items[{index}]"))

    def get_array(self, shape, dimensions, at):
        if dimensions and shape.scalar in SCALARS and shape.scalar != "boolean":
            self.line(f"from.get_array({self.scalars(shape, f'&{at}', const=False)}, {product(dimensions)});")
        else:
            self.nest(len(dimensions), at, False, lambda e: self.get_one(shape, e))

    def get_one(self, shape, at):
        if shape.scalar == "string":
            self.line(f"{at} = from.get_text({shape.bound}).data();" if self.language == "c++"
                      else f"from.get_text({at}, {shape.bound});")
        elif shape.scalar == "enum":
            name = f"::{shape.of.name}" if self.language == "c++" else c_name(shape.of.name)
            self.line(f"{at} = static_cast<{name}>(from.get_enumerator({len(shape.of.enumerators)}));")
        elif shape.scalar == "struct":
            self.line(f"{self.function(shape, 'get')}(from, {at});")
        elif shape.scalar == "boolean":
            self.line(f"{at} = from.get_boolean();")
        else:
            self.line(f"{at} = from.get<{SCALARS[shape.scalar][1]}>();")

    # -- Whether put() takes it; in C++

    def fits(self, each):
        shape = each.shape
        if shape.may_not_fit():
            self.nest(len(shape.dimensions), self.access(each), True,
                      lambda e: self.sequence_fits(shape, e) if shape.sequence else self.one_fits(shape, e))

    def sequence_fits(self, shape, at):
        self.line(f"if ({at}.size() > {shape.sequence}) return false;")
        if shape.scalar == "enum" or (shape.scalar == "struct" and shape.of.misfits):
            self.nest(1 + len(shape.elements), at, True, lambda e: self.one_fits(shape, e))

    def one_fits(self, shape, at):
        self.line(f"if (static_cast<std::uint32_t>({at}) >= {len(shape.of.enumerators)}) return false;" if shape.scalar == "enum"
                  else f"if (!{self.function(shape, 'fits')}({at})) return false;")

    # -- Room for sequences

    def reserve(self, each):
        shape = each.shape
        at = self.access(each)
        if shape.sequence:
            self.nest(len(shape.dimensions), at, False, lambda e: self.line(f"{e}.reserve({shape.sequence});"))
        elif shape.has_sequence():
            self.nest(len(shape.dimensions), at, False, lambda e: self.line(f"PortType<::{shape.of.name}>::reserve({e});"))


def code_of(language, struct, what):
    code = Code(language)
    for each in struct.fields:
        getattr(code, what)(each)
    return code.lines


def head(file, what):
    return [f"// {what} Made of {os.path.basename(file.path)} by takt_idl.py; changes are lost."]


def in_c(shape, name):
    """A declaration of C."""
    kind = "char" if shape.scalar == "string" else c_name(shape.of.name) if shape.of else SCALARS[shape.scalar][1]
    text = f"[{shape.bound + 1}]" if shape.scalar == "string" else ""
    if shape.sequence:
        items = f"{kind} items[{shape.sequence}]{sizes(shape.elements)}{text};"
        return f"struct {{ uint32_t length; {items} }} {name}{sizes(shape.dimensions)};"
    return f"{kind} {name}{sizes(shape.dimensions)}{text};"


def integer_in_c(value):
    if value == -2 ** 63:
        return f"({value + 1} - 1)"
    return f"({value})" if value < 0 else f"{value}ULL" if value >= 2 ** 63 else str(value)


def c_header(file):
    """X_c.h: structs for modules in C."""
    guard = f"TAKT_IDL_{file.stem.upper()}_C_H"
    lines = [f"/* The types of ports of C modules. Made of {os.path.basename(file.path)} by takt_idl.py; changes are lost. */",
             f"#ifndef {guard}", f"#define {guard}", "", "#include <stdbool.h>", "#include <stdint.h>", "", "#include <takt/component/type.h>",
             ""] + [f'#include "{stem}_c.h"' for stem in included_stems(file)]
    lines += ["", "#ifdef __cplusplus", 'extern "C" {', "#endif", ""]
    for declared in file.declares:
        name = c_name(declared.name)
        if isinstance(declared, Const):
            lines.append(f"#define {name} {integer_in_c(declared.value)}")
        elif isinstance(declared, Enum):
            scope = c_name(declared.name.rpartition("::")[0])
            names = [f"{scope}_{each}" if scope else each for each in declared.enumerators]
            lines += [f"typedef enum {name} {{ {', '.join(names)} }} {name};"]
        elif isinstance(declared, Struct):
            lines += ["", f"typedef struct {name} {{"] + [f"  {in_c(f.shape, f.name)}" for f in declared.fields] + [
                f"}} {name};", f"extern const takt_type {name}_type;",
                f"uint32_t {name}_encode(const {name}* value, unsigned char* to, uint32_t size);",
                f"int {name}_decode(const unsigned char* from, uint32_t size, {name}* value);"]
    return lines + ["", "#ifdef __cplusplus", "}", "#endif", "", "#endif"]


def c_source(file):
    lines = head(file, "How samples of C modules become bytes.") + [f'#include "{file.stem}_c.h"', "", "#include <cstddef>", "",
                                                                    "#include <takt/core/cdr.hpp>", "", "namespace takt::in_c {", ""]
    ours = structs_of(file)
    theirs = {f.shape.of.name for s in ours for f in s.fields if f.shape.scalar == "struct"} - {s.name for s in ours}
    for name in map(c_name, sorted(theirs)):
        lines += [f"void put_{name}(CdrWriter& to, const {name}& value) noexcept;",
                  f"void get_{name}(CdrReader& from, {name}& value) noexcept;", ""]
    for struct in ours:
        name = c_name(struct.name)
        lines += [f"void put_{name}(CdrWriter& to, const {name}& value) noexcept {{"] + code_of("c", struct, "put") + ["}", ""]
        lines += [f"void get_{name}(CdrReader& from, {name}& value) noexcept {{"] + code_of("c", struct, "get") + ["}", ""]
    lines += ["}  // namespace takt::in_c", "", 'extern "C" {', ""]
    for struct in ours:
        name = c_name(struct.name)
        lines += [
            f"uint32_t {name}_encode(const {name}* value, unsigned char* to, uint32_t size) {{",
            "  takt::CdrWriter writer{reinterpret_cast<std::byte*>(to), size};", f"  takt::in_c::put_{name}(writer, *value);",
            "  return writer.size();", "}", "",
            f"int {name}_decode(const unsigned char* from, uint32_t size, {name}* value) {{",
            "  takt::CdrReader reader{reinterpret_cast<const std::byte*>(from), size};",
            f"  takt::in_c::get_{name}(reader, *value);", "  return reader.complete() ? 1 : 0;", "}", "",
            f"const takt_type {name}_type = {{", f"    {json.dumps(struct.name)},", f"    {literal(description(struct))},",
            f"    {max_size(struct)},", f"    sizeof({name}),",
            "    [](const void* value, unsigned char* to, uint32_t size) {",
            f"      return {name}_encode(static_cast<const {name}*>(value), to, size);", "    },",
            "    [](const unsigned char* from, uint32_t size, void* value) {",
            f"      return {name}_decode(from, size, static_cast<{name}*>(value));", "    }};", ""]
    return lines + ["}"]


def in_idl(declared, name):
    """A declaration without typedefs, for fastddsgen leaves an array of a typedef without values. Sequences need theirs."""
    shape = declared.shape
    if shape.sequence:
        return f"{shape.text} {name}{sizes(declared.own)};"
    kind = f"string<{shape.bound}>" if shape.scalar == "string" else shape.of.name if shape.of else shape.scalar
    return f"{kind} {name}{sizes(shape.dimensions)};"


def plain_idl(file):
    """The same declarations for fastddsgen, with numbers for constants: the code that it makes of their names does not compile."""
    guard = f"{file.stem.upper()}_PLAIN_IDL"
    lines = head(file, "For fastddsgen.") + [f"#ifndef {guard}", f"#define {guard}"]
    lines += [f'#include "{stem}.idl"' for stem in included_stems(file)]
    for declared in file.declares:
        *modules, name = declared.name.split("::")
        lines += [f"module {module} {{" for module in modules]
        if isinstance(declared, Const):
            lines.append(f"const {declared.type} {name} = {declared.value};")
        elif isinstance(declared, Alias):
            lines.append(f"typedef {in_idl(declared, name)}")
        elif isinstance(declared, Enum):
            lines.append(f"enum {name} {{ {', '.join(declared.enumerators)} }};")
        else:
            lines += [f"@final struct {name} {{"]
            lines += [f"  {in_idl(each, each.name)}" for each in declared.fields] + ["};"]
        lines += ["};" for module in modules]
    return lines + ["#endif"]


def sizes(dimensions):
    return "".join(f"[{size}]" for size in dimensions)


def included_stems(file):
    return [other.stem for other, _ in file.includes]


def header(file):
    """X.hpp: takt::PortType of each struct."""
    lines = head(file, "The types of ports of C++ modules.") + [
        "#pragma once", "", "#include <cstddef>", "#include <cstdint>", "", "#include <takt/component/port_type.hpp>", "",
        f'#include "{file.stem}.h"'] + [f'#include "{stem}.hpp"' for stem in included_stems(file)] + [
        "", "namespace takt {", "class CdrReader;", "class CdrWriter;", ""]
    for struct in structs_of(file):
        name = "::" + struct.name
        lines += [
            "template <>", f"struct PortType<{name}> {{", "  static constexpr TypeInfo info{",
            f"      {json.dumps(struct.name)},", f"      {literal(description(struct))},", f"      {max_size(struct)}}};",
            f"  static std::uint32_t encode(const {name}& value, std::byte* to, std::uint32_t size) noexcept;",
            f"  static bool fits(const {name}& value) noexcept;" if struct.misfits else
            f"  static constexpr bool fits(const {name}&) noexcept {{ return true; }}",
            f"  static bool decode(const std::byte* from, std::uint32_t size, {name}& value) noexcept;",
            f"  static void reserve({name}& value);",
            "  // As a field of another struct.",
            f"  static void put(CdrWriter& to, const {name}& value) noexcept;",
            f"  static void get(CdrReader& from, {name}& value);", "};", ""]
    return lines + ["}  // namespace takt"]


def source(file):
    lines = head(file, "How samples become bytes.") + [f'#include "{file.stem}.hpp"', "", "#include <takt/core/cdr.hpp>", "",
                                                       "namespace takt {", ""]
    for struct in structs_of(file):
        name, port = "::" + struct.name, f"PortType<::{struct.name}>"
        lines += [f"void {port}::put(CdrWriter& to, const {name}& value) noexcept {{"] + code_of("c++", struct, "put") + ["}", ""]
        lines += [f"void {port}::get(CdrReader& from, {name}& value) {{"] + code_of("c++", struct, "get") + ["}", ""]
        if struct.misfits:
            lines += [f"bool {port}::fits(const {name}& value) noexcept {{"] + code_of("c++", struct, "fits") + [
                "  return true;", "}", ""]
        lines += [f"void {port}::reserve({name}& value) {{"] + code_of("c++", struct, "reserve") + ["}", ""]
        lines += [f"std::uint32_t {port}::encode(const {name}& value, std::byte* to, std::uint32_t size) noexcept {{",
                  "  CdrWriter writer{to, size};", "  put(writer, value);", "  return writer.size();", "}", ""]
        lines += [f"bool {port}::decode(const std::byte* from, std::uint32_t size, {name}& value) noexcept {{",
                  "  CdrReader reader{from, size};"]
        # Only a value without room for its sequences throws.
        lines += (["  try {", "    get(reader, value);", "  } catch (...) {", "    return false;", "  }"] if struct.sequences
                  else ["  get(reader, value);"]) + ["  return reader.complete();", "}", ""]
    return lines + ["}  // namespace takt"]


def structs_of(file):
    return [d for d in file.declares if isinstance(d, Struct)]


def write(folder, name, lines):
    with open(os.path.join(folder, name), "w", encoding="utf-8") as stream:
        stream.write("\n".join(lines) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    group = parser.add_mutually_exclusive_group(required=True)
    group.add_argument("--check", action="store_true", help="only say what is wrong")
    group.add_argument("--out", metavar="DIR", help="where the sources go")
    parser.add_argument("files", nargs="+")
    arguments = parser.parse_args()

    library = Library()
    for path in arguments.files:
        file = library.read(path)
        if file not in library.named:
            library.named.append(file)
    if arguments.check:
        library.named = list(library.files.values())
    library.check_files()
    library.check_types()
    if library.problems.seen:
        library.problems.print([f.path for f in library.files.values()])
        return 1
    if arguments.out:
        plain = os.path.join(arguments.out, "plain")
        os.makedirs(plain, exist_ok=True)
        for file in library.named:
            write(plain, f"{file.stem}.idl", plain_idl(file))
            write(arguments.out, f"{file.stem}.hpp", header(file))
            write(arguments.out, f"{file.stem}_types.cpp", source(file))
            write(arguments.out, f"{file.stem}_c.h", c_header(file))
            write(arguments.out, f"{file.stem}_c.cpp", c_source(file))
    return 0


if __name__ == "__main__":
    sys.exit(main())
