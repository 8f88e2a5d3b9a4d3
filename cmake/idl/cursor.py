"""The position of a parser in its tokens, the lookup of names, and constant expressions."""
import os
import re

from idl.declarations import MAX_NAME, MAX_SAMPLE, Const, Scope
from idl.tokens import IdlError


# Keywords of IDL that idlc reserves in upper and lower case.
ANY_CASE_WORDS = set("""any bitfield bitmask bitset boolean case char const default double enum false fixed float int8 int16
    int32 int64 long map module native octet sequence short string struct switch true typedef uint8 uint16 uint32 uint64 union
    unsigned wchar wstring""".split())
# Further keywords of IDL, which fastddsgen reserves only in this spelling.
WORDS = set("""Object ValueBase abstract annotation attribute component consumes context custom emits eventtype exception
    factory finder getraises home import in inout interface local manages multiple oneway out primarykey private provides
    public publishes raises readonly set setraises supports truncatable typeid typeprefix uses valuetype void""".split())
# Names that the generated C and C++ cannot use.
CODE_WORDS = set("""alignas alignof and and_eq asm auto bitand bitor bool break catch char8_t char16_t char32_t class compl
    concept consteval constexpr constinit const_cast continue co_await co_return co_yield decltype delete do dynamic_cast
    else explicit export extern for friend goto if inline int mutable namespace new noexcept not not_eq nullptr operator or
    or_eq protected register reinterpret_cast requires restrict return signed sizeof static static_assert static_cast
    template this thread_local throw try typeof volatile while xor xor_eq std linux unix NULL EOF errno""".split())

# The types of C, C++, Python, ROS and others, with the type of IDL to write instead.
OTHER_TYPES = {
    "bool": "boolean", "byte": "octet", "uchar": "octet", "uint8_t": "octet", "int8_t": "int8", "signed": "long",
    "int": "long", "int16_t": "short", "int32_t": "long", "int64_t": "long long", "ssize_t": "long long",
    "uint": "unsigned long", "ushort": "unsigned short", "ulong": "unsigned long", "uint16_t": "unsigned short",
    "uint32_t": "unsigned long", "uint64_t": "unsigned long long", "size_t": "unsigned long long",
    "float32": "float", "float32_t": "float", "real": "double", "float64": "double", "float64_t": "double",
    "str": "string<64>", "text": "string<64>", "std::string": "string<64>", "string_view": "string<64>",
    "std::string_view": "string<64>", "vector": "sequence<T, 16>", "std::vector": "sequence<T, 16>",
    "list": "sequence<T, 16>", "array": "an array, such as double position[6]",
    "std::array": "an array, such as double position[6]",
}
OTHER_TYPES |= {f"std::{name}": idl for name, idl in OTHER_TYPES.items() if name.endswith("_t")}


class Cursor:
    """Base of Parser, which provides `library`, `problems`, `file`, `scope`, `tokens` and `at`."""

    # -- Position

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
            # The error about a missing ';' cites the line of the previous token.
            token = self.tokens[self.at - 1] if text == ";" and self.at > 0 else self.token
            raise IdlError(self.place(token), f"{after} is followed by {self.token.text!r}; write {text!r}"
                           if self.token.kind != "end" else f"{after} has no end; write {text!r}")

    def unexpected(self, token, wanted):
        if token.kind == "end":
            return IdlError(self.place(token), f"expected {wanted}, but the file ends here")
        fix = "; remove the ','" if token.text == "," else ""
        return IdlError(self.place(token), f"expected {wanted}, found {token.text!r}{fix}")

    def skip(self):
        """Skips to the end of a declaration that could not be parsed."""
        depth = 0
        while self.token.kind != "end":
            if self.is_next("}") and depth == 0:
                return
            token = self.next()
            depth += (token.text == "{") - (token.text == "}")
            if depth == 0 and token.text == "}" and not self.is_next(";"):
                if self.token.kind != "name" or self.tokens[self.at + 1].text not in (";", ",", "["):
                    return  # otherwise the declaration goes on after the brace, as in struct {...} a, b;
            if depth == 0 and token.text == ";":
                return

    def skip_arguments(self):
        """Skips <...> after a type that is not one of IDL, such as std::vector<double>."""
        depth = 0
        while self.is_next("<") or depth > 0 and self.token.kind != "end" and not self.is_next(";"):
            token = self.next()
            depth += (token.text == "<") - (token.text == ">")

    def guarded(self, parse):
        start = self.at
        try:
            parse()
        except IdlError as error:
            self.problems.add(error.place, str(error))
            self.at = max(self.at, start)
            self.skip()
            if self.at == start:
                self.next()

    # -- Names

    def new_name(self, what, full=None):
        token = self.token
        if token.kind != "name":
            raise self.unexpected(token, f"the name of {what}")
        self.next()
        name = token.text
        shown = full(name) if full else name
        if name in WORDS or name.lower() in ANY_CASE_WORDS:
            how = "" if name in WORDS or name in ANY_CASE_WORDS else " (this keyword is not case-sensitive)"
            self.problem(token, f"{shown}: {name!r} is a keyword of IDL{how}; choose another name")
        elif name in CODE_WORDS:
            self.problem(token, f"{shown}: {name!r} is reserved in the generated C++ code; choose another name")
        elif name.startswith("_"):
            self.problem(token, f"{shown}: a name begins with a letter; remove the '_'")
        elif len(shown) > MAX_NAME:
            self.problem(token, f"{name[:60]}...: a name has at most {MAX_NAME} characters, including its modules")
        return token

    def declare(self, token, entity):
        known = self.scope.names.get(token.text.lower())
        own = self.scope.name.split("::")[-1]
        if token.text.lower() == own.lower():
            self.problem(token, f"{self.scope.full(token.text)} has the name of its "
                                f"module{'' if token.text == own else ' (IDL is not case-sensitive)'}; choose another name")
        if known is None:
            self.scope.names[token.text.lower()] = (token.text, entity)
            return True
        file, line = known[1].place
        full = self.scope.full(token.text)
        if known[0] == token.text:
            self.problem(token, f"{full} is already declared in {file}:{line}; choose another name")
        else:
            self.problem(token, f"{full} differs only in case from {known[0]} in {file}:{line}, but IDL is not "
                                "case-sensitive; choose another name")
        return False

    def scoped_name(self):
        """Parses a::b::c. Returns whether it begins with ::, its parts as text, and the first token."""
        first = self.token
        absolute = self.take("::")
        parts = []
        while True:
            token = self.next()
            if token.kind != "name":
                raise self.unexpected(token, "a name")
            parts.append(token.text)
            if not self.take("::"):
                return absolute, parts, first

    def find(self, absolute, parts, token, where="", members=()):
        """Returns the entity that a name means here. If there is none, reports a problem and returns None.

        The message begins with `where`. `members` are the fields of the struct so far; the name must not be one of them.
        """
        shown = where + ("::" if absolute else "") + "::".join(parts)
        for member in members if len(parts) == 1 and not absolute else ():
            if member.lower() == parts[0].lower():
                self.problem(token, f"{where}{parts[0]} refers to the field {member}, because IDL is not case-sensitive; "
                                    "rename the field")
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
            instead = OTHER_TYPES.get("::".join(parts))
            self.problem(token, f"{shown} is not a type of IDL; write {instead}" if instead else
                         f"{shown} is not declared before this line; declare it, or #include the file that does")
            return None
        if isinstance(known[1], Scope):
            self.problem(token, f"{shown} is a module; write the name of a declaration in it")
            return None
        if known[0] != parts[-1]:
            self.problem(token, f"{shown} is declared as {known[0]}; use the same case")
            return None
        entity = known[1]
        real = self.library.real_of(entity.place[0])
        if real not in self.file.sees():
            self.problem(token, f"{shown} is declared in {entity.place[0]}, which this file does not include; write #include "
                         f"\"{os.path.relpath(real, os.path.dirname(self.file.real))}\"")
            return None
        return entity

    def bound(self, name, what):
        """Parses a size of at least 1. If the size is not valid, reports a problem and returns 1."""
        token = self.token
        value = self.expression(in_angles=True)
        if value is None:
            return 1
        if not 1 <= value <= MAX_SAMPLE:
            self.problem(token, f"{name}: {what} is {value}; use a value from 1 to {MAX_SAMPLE}")
            return 1
        return value

    # -- Constant expressions

    LEVELS = [("|",), ("^",), ("&",), ("<<", ">>"), ("+", "-"), ("*", "/", "%")]

    def expression(self, level=0, in_angles=False):
        """Parses an expression and returns its integer value. If the expression is not valid, reports a problem and returns None."""
        if level == len(self.LEVELS):
            return self.unary()
        left = self.expression(level + 1, in_angles)
        while True:
            token = self.token
            sign = token.text if token.kind == "sign" else ""
            after = self.tokens[min(self.at + 1, len(self.tokens) - 1)]
            if sign == ">" and not in_angles and after.text == ">" and after.at == token.at + 1:
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
            self.problem(token, "division by 0; write another number")
            return None
        if sign in ("<<", ">>") and not 0 <= right < 64:
            self.problem(token, f"shift by {right}; use a value from 0 to 63")
            return None
        quotient = abs(left) // abs(right) * (1 if (left < 0) == (right < 0) else -1) if sign in ("/", "%") else 0
        result = {"|": lambda: left | right, "^": lambda: left ^ right, "&": lambda: left & right, "<<": lambda: left << right,
                  ">>": lambda: left >> right, "+": lambda: left + right, "-": lambda: left - right, "*": lambda: left * right,
                  "/": lambda: quotient, "%": lambda: left - quotient * right}[sign]()
        # Outside this range idlc rejects the expression or computes a wrong value: -4 / 2 is 9223372036854775806.
        if sign not in ("|", "^", "&") and not all(0 <= n < 2 ** 32 for n in (left, right, result)):
            self.problem(token, f"{left} {sign} {right} is {result}, but IDL compilers agree only on numbers from 0 to "
                                f"{2 ** 32 - 1}; write the result")
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
                raise IdlError(self.place(token), f"{token.text} begins with 0 like an octal number, but is not one; remove "
                                                  "the 0")
            return int(token.text, 0)
        if token.kind == "name" and token.text.lower() not in ANY_CASE_WORDS or self.is_next("::"):
            absolute, parts, first = self.scoped_name()
            entity = self.find(absolute, parts, first)
            if entity is not None and not isinstance(entity, Const):
                self.problem(first, f"{'::'.join(parts)} is not a constant; write an integer or the name of a constant")
            return entity.value if isinstance(entity, Const) else None
        raise self.unexpected(token, "an integer")
