"""Parses tokens into declarations."""
import difflib
import re
from dataclasses import replace

from idl.cursor import ANY_CASE_WORDS, WORDS, Cursor
from idl.declarations import INTEGERS, NOT_NUMBERS, SAME, SCALARS, Alias, Const, Enum, Enumerator, Field, Scope, Shape, Struct
from idl.tokens import IdlError, Token, tokens_of


# Types that ports do not support, with the type to write instead.
INSTEAD = {
    "wstring": "string<64>, as UTF-8", "wchar": "unsigned short", "any": "a struct", "Object": "a struct", "fixed": "double",
    "map": "a sequence of structs", "union": "a struct with an enum", "bitset": "unsigned long", "bitmask": "unsigned long",
    "struct": "its name, and declare it first", "enum": "its name, and declare it first",
}
# After `unsigned`: the types of other languages, with the type to write instead.
UNSIGNED = {"int": "unsigned long", "char": "octet", "octet": "octet"}


class Parser(Cursor):
    """Parses one IDL file. The Library parses the files that this file includes."""

    def __init__(self, library, file, text):
        self.library = library
        self.problems = library.problems
        self.file = file
        self.scope = library.root
        self.tokens = tokens_of(text, file.path, self.problems)
        self.at = 0
        self.directives()

    def directives(self):
        """Handles and removes the directives: #include, and the three lines of an include guard."""
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
                self.problem(directive, 'write #include "file.idl", with a path relative to this file')
            else:
                self.problem(directive, f"{directive.text.strip()} is not allowed; use only #include, and #ifndef NAME, "
                                        "#define NAME and #endif around the whole file")
        self.tokens = [t for t in self.tokens if t.kind != "directive"]

    # -- Declarations

    def parse(self):
        while self.token.kind != "end":
            if self.is_next("}"):
                self.problem(self.next(), "a '}' without a '{' before it; remove it")
                self.take(";")
            else:
                self.guarded(self.declaration)

    def declaration(self):
        annotations = self.annotations()
        token = self.token
        if self.is_next("struct"):
            return self.struct(annotations)
        for annotation in annotations:
            self.problem(annotation, f"@{annotation.text} is only allowed on a struct; remove it")
        if self.is_next("module"):
            return self.module()
        if self.is_next("enum"):
            return self.enum()
        if self.is_next("typedef"):
            return self.typedef()
        if self.is_next("const"):
            return self.const()
        if self.take(";"):
            return self.problem(token, "a ';' without a declaration; remove it")
        meant = difflib.get_close_matches(token.text, ("module", "struct", "enum", "typedef", "const"), n=1)
        raise IdlError(self.place(), f"{token.text!r} is not allowed in a file of port types; " + (
            f"did you mean {meant[0]}?" if meant else "write modules with structs, enums, typedefs and constants"))

    def annotations(self):
        """Parses annotations and returns the tokens of their names, with their arguments. @extensibility(FINAL) becomes @final."""
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
                        raise IdlError(self.place(name), f"@{name.text}( has no end; write ')'")
                    depth += (token.text == "(") - (token.text == ")")
                    argument += token.text if depth else ""
            if name.text == "extensibility" and argument is not None:
                final = argument == "FINAL"
                name = Token("name", "final" if final else f"extensibility({argument})", name.line, name.at)
            elif argument is not None and name.text == "final":
                self.problem(name, "@final has no arguments; remove them")
            found.append(replace(name, argument=argument))
        return found

    def body(self, what, each):
        """Parses { ... }; and calls `each` for each element in it."""
        self.expect("{", what)
        opened = self.tokens[self.at - 1]
        while not self.is_next("}"):
            if self.token.kind == "end":
                raise IdlError(self.place(opened), f"{what} has no end; write '}};'")
            try:
                each()
            except IdlError as error:
                self.problems.add(error.place, str(error))
                while not self.is_next("}", "{", ";") and self.token.kind != "end":
                    self.next()
                if not self.is_next("}"):
                    raise IdlError(self.place(opened), f"{what} has no end; write '}};'") from None
        end = self.next()
        if self.take(","):
            self.problem(end, f"{what} ends with '}},'; write '}};'")
        elif not self.take(";"):
            self.problem(end, f"{what} ends without ';'; add it")

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
        reported = False
        if kind is None and self.take("string"):
            kind = "string"
        if kind is None and self.token.kind == "name":
            absolute, parts, first = self.scoped_name()
            entity = self.find(absolute, parts, first)
            kind = entity.shape.scalar if isinstance(entity, Alias) and not entity.shape.dimensions else "?"
            reported = entity is None
        token = self.new_name("a constant", self.scope.full)
        name = self.scope.full(token.text)
        if kind not in INTEGERS:
            if not reported:
                self.problem(type_token, f"{name} is not of an integer type; a constant must be an integer, such as unsigned "
                                         "long")
            while not self.is_next(";", "}") and self.token.kind != "end":
                self.next()
            self.take(";")
            self.declare(token, Const(name, "", None, self.place(token)))
            return
        self.expect("=", f"const {name}")
        value = self.expression()
        self.expect(";", f"const {name}")
        size, unsigned = INTEGERS[kind]
        low, high = (0, 2 ** (8 * size) - 1) if unsigned else (-2 ** (8 * size - 1), 2 ** (8 * size - 1) - 1)
        if value is not None and not low <= value <= high:
            self.problem(token, f"{name} is {value}, which {kind} cannot hold; use a value from {low} to {high}")
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
            sign = self.token
            if self.take(","):
                return self.problem(sign, f"{enum.name} has a ',' without an enumerator before it; remove it")
            for annotation in self.annotations():
                self.problem(annotation, f"{enum.name}: enumerators are numbered from 0 in order; remove @{annotation.text}")
            name = self.new_name("an enumerator", self.scope.full)
            if self.declare(name, Enumerator(self.scope.full(name.text), self.place(name))):
                enum.enumerators.append(name.text)
            if self.is_next("="):
                self.problem(name, f"{self.scope.full(name.text)}: enumerators are numbered from 0 in order; remove the '='")
                while not self.is_next(",", "}", ";") and self.token.kind != "end":
                    self.next()
            if not self.take(",") and not self.is_next("}"):
                wrong = f"{self.scope.full(name.text)} is followed by {self.token.text!r}; write ','"
                after = [t.text for t in self.tokens[self.at + 2:self.at + 3]]
                if self.token.kind != "name" and not (self.is_next(";") and after in ([","], ["}"], ["="], [";"])):
                    raise IdlError(self.place(name), wrong)
                self.problem(name, wrong)
                self.take(";")
            if self.tokens[self.at - 1].text == "," and self.is_next("}"):
                self.problem(self.tokens[self.at - 1], f"{enum.name} has a ',' after its last enumerator; remove it")

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
            raise IdlError(self.place(token), f"{struct.name} is a forward declaration, which is not supported; declare the "
                                              "struct before its first use")
        if self.is_next(":"):
            raise IdlError(self.place(token), f"{struct.name} uses inheritance, which ports do not support; make the base "
                                              "struct a field")
        final = False
        for annotation in annotations:
            if annotation.text == "final":
                final = True
            elif annotation.text in ("appendable", "mutable") or annotation.text.startswith("extensibility("):
                self.problem(annotation, f"{struct.name} has @{annotation.text}, but a port type is final; write @final instead")
                final = True
            else:
                self.problem(annotation, f"{struct.name} has @{annotation.text}, but a port type can only have @final; remove "
                                         f"@{annotation.text}")
        if not final:
            self.problem(token, f"{struct.name} is not final; write @final before it")
        declared = self.declare(token, struct)
        self.body(f"struct {struct.name}", lambda: self.guarded(lambda: self.fields(struct)))
        struct.complete = True
        if not struct.fields:
            self.problem(token, f"{struct.name} has no fields; a struct has at least one")
        if declared:
            self.file.declares.append(struct)

    def fields(self, struct):
        sign = self.token
        if self.take(";") or self.take(","):
            return self.problem(sign, f"{struct.name} has a {sign.text!r} without a field before it; remove it")
        annotations = self.annotations()
        full = lambda name: f"{struct.name}.{name}"
        shown = self.declared_name(full, f"a field of {struct.name}")
        unit = ""
        for annotation in annotations:
            if annotation.text == "unit":
                unit = self.unit(annotation, shown)
                continue
            text = ("is a key, but port types have no keys" if annotation.text in ("key", "Key")
                    else f"has @{annotation.text}, but the fields of a port type can only have @unit")
            self.problem(annotation, f"{shown} {text}; remove @{annotation.text}")
        shape = self.type_of(shown, self.token, [f.name for f in struct.fields])
        for token, own, whole in self.declarators(shape, "a field", full):
            if unit and whole.scalar in NOT_NUMBERS:
                self.problem(token, f"{full(token.text)} has a unit but is not a number; remove @unit")
            if token.text.lower() == struct.name.split("::")[-1].lower():
                self.problem(token, f"{struct.name}.{token.text} has the name of its struct (IDL is not case-sensitive); "
                                    "choose another name")
            twin = next((f for f in struct.fields if f.name.lower() == token.text.lower()), None)
            if twin:
                how = "is declared twice" if twin.name == token.text else f"differs only in case from {twin.name}"
                self.problem(token, f"{struct.name}.{token.text} {how}; choose another name")
            else:
                struct.fields.append(Field(token.text, whole, own, unit, self.place(token)))

    def unit(self, annotation, name):
        """Returns the unit in @unit("..."). All IDL compilers read ASCII in the same way."""
        unit = re.fullmatch(r'"([ !#-\[\]-~]{1,32})"', annotation.argument or "")
        if unit:
            return unit.group(1)
        self.problem(annotation, f"the @unit of {name} is not a text of 1 to 32 ASCII characters; write for example @unit(\"rad\")")
        return ""

    def declarators(self, shape, what, full):
        """Parses a, b[3], c[2][4]; and yields (token, dimensions, shape) for each name."""
        while True:
            token = self.new_name(what, full)
            dimensions = []
            while self.take("["):
                if self.is_next("]"):
                    self.problem(token, f"{full(token.text)} is an array without a size; write [6]")
                    size = 1
                else:
                    size = self.bound(f"{full(token.text)}", "the size of an array")
                if self.is_next(","):
                    raise IdlError(self.place(), f"the size of {full(token.text)} is followed by ','; write each dimension in its "
                                                 "own brackets, such as [2][3]")
                self.expect("]", f"the size of {full(token.text)}")
                dimensions.append(size)
            yield token, dimensions, Shape(shape.scalar, shape.bound, shape.of, dimensions + shape.dimensions, shape.sequence,
                                           shape.elements, shape.text)
            if not self.take(","):
                is_name = self.token.kind == "name" and self.token.text not in ANY_CASE_WORDS
                if is_name and self.token.line == token.line:
                    raise IdlError(self.place(), f"{full(token.text)} is followed by {self.token.text!r}; write ';' or ','")
                return self.expect(";", full(token.text))
            if not self.further_name(full(token.text)):
                return None

    def further_name(self, name):
        """Returns whether a further name follows the ',' after `name`. If not, reports the ',' as a wrong ';'."""
        comma = self.tokens[self.at - 1]
        while self.is_next(","):
            self.problem(self.next(), f"{name} is followed by two ','; remove one")
        after = self.tokens[min(self.at + 1, len(self.tokens) - 1)]
        beside = self.token.line == comma.line and self.token.text not in ANY_CASE_WORDS
        if self.token.kind == "name" and (beside or after.text in (",", ";", "[")):
            return True
        self.problem(comma, f"{name} is followed by ',' but by no further name; write ';' instead of ','")
        self.take(";")
        return False

    # -- Types

    def basic_type(self):
        """Parses a scalar type of SCALARS, or long double. Returns None if the next tokens are no such type."""
        token = self.token
        if self.take("unsigned"):
            if self.take("short"):
                return "unsigned short"
            if self.take("long"):
                return "unsigned long long" if self.take("long") else "unsigned long"
            instead = UNSIGNED.get(self.token.text, "unsigned short, unsigned long or unsigned long long")
            raise IdlError(self.place(token), f"unsigned {self.token.text} is not a type; write {instead}")
        kind = None
        if self.take("long"):
            kind = "long double" if self.take("double") else "long long" if self.take("long") else "long"
        elif token.kind == "name" and token.text in SCALARS or token.text in SAME:
            self.next()
            kind = SAME.get(token.text, token.text)
        if kind in INTEGERS and self.is_next("int"):
            raise IdlError(self.place(token), f"{kind} int is not a type; write {kind}")
        return kind

    def declared_name(self, full, otherwise):
        """Looks ahead for the name of the declaration that begins here, because error messages about its type contain this name."""
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
        """Parses the type of the declaration `name`. `name` is only used in error messages."""
        invalid = Shape("")
        if self.take("string"):
            if not self.take("<") or self.take(">"):
                self.problem(token, f"{name} is a string without a bound; write string<64>")
                return invalid
            bound = self.bound(name, "the bound of a string")
            self.expect(">", f"the bound of {name}")
            return Shape("string", bound, text=f"string<{bound}>")
        if self.take("sequence"):
            self.expect("<", f"the sequence of {name}")
            element = self.type_of(name, token, members)
            if element.scalar and element.has_sequence():
                how = ("is a sequence of sequences" if element.sequence else
                       f"is a sequence of {element.of.name}, which has a sequence itself")
                self.problem(token, f"{name} {how}, for which a port cannot allocate memory in advance; use an array of "
                                    "sequences, such as sequence<double, 8> rows[4]")
                element = invalid
            if not self.take(","):
                if not self.take(">"):
                    self.expect(",", f"the sequence of {name}")
                word = element.of.name if element.of else element.scalar or "T"
                if element.scalar == "string":
                    word = f"string<{element.bound}>"
                self.problem(token, f"{name} is a sequence without a bound; write sequence<{word}, 16>")
                return invalid
            bound = self.bound(name, "the bound of a sequence")
            self.expect(">", f"the sequence of {name}")
            if not element.scalar:
                return invalid
            return Shape(element.scalar, element.bound, element.of, [], bound, element.dimensions,
                         f"sequence<{element.text}, {bound}>")
        scalar = self.basic_type()
        if scalar in SCALARS:
            return Shape(scalar, text=scalar)
        if scalar == "long double":
            self.problem(token, f"{name} is a long double, which differs between machines; write double")
            return invalid
        for word, fix in INSTEAD.items():
            if self.is_next(word):
                article = "an" if word[0] in "aeO" else "a"
                raise IdlError(self.place(token), f"{name} is {article} {word}, which ports do not support; write {fix}")
        if self.token.kind != "name" and not self.is_next("::"):
            raise self.unexpected(self.token, "a type")
        absolute, parts, first = self.scoped_name()
        lower = parts[0].lower()
        if lower != parts[0] and (lower in SCALARS or lower in SAME or lower == "string"):
            right = "string<64>" if lower == "string" else lower
            raise IdlError(self.place(first), f"{name} is of type {parts[0]}; write {right}, in lower case")
        if parts[0] in WORDS or lower in ANY_CASE_WORDS:
            raise IdlError(self.place(first), f"{name} is of type {parts[0]!r}, which ports do not support; write a basic "
                                              "type, such as double, or a struct")
        entity = self.find(absolute, parts, first, f"{name}: ", members)
        if entity is None:
            self.skip_arguments()
        if isinstance(entity, Struct):
            if not entity.complete:
                self.problem(first, f"{name} contains {entity.name} itself, which ports do not support; write an array or a "
                                    "bounded sequence of another struct")
                return invalid
            return Shape("struct", of=entity, text=entity.name)
        if isinstance(entity, Enum):
            return Shape("enum", of=entity, text=entity.name)
        if isinstance(entity, Alias):
            return replace(entity.shape, text=entity.name)
        if entity is not None:
            self.problem(first, f"{name}: {'::'.join(parts)} is not a type; write a struct, an enum or a typedef")
        return invalid
