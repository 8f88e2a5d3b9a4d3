"""Where a parser is in its tokens, the names that it has seen, and expressions of constants."""
import os
import re

from idl.declarations import MAX_NAME, MAX_SAMPLE, Const, Scope
from idl.tokens import Wrong


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


class Cursor:
    """Knows `library`, `problems`, `file`, `scope`, `tokens` and `at` of the parser that it is."""

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
            self.problem(token, f"{self.scope.full(token.text)} has the name of its "
                                f"module{'' if token.text == own else ', which differs only in upper and lower case'}; "
                         "take another name")
        if known is None:
            self.scope.names[token.text.lower()] = (token.text, entity)
            return True
        file, line = known[1].place
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
                self.problem(token, f"{where}{parts[0]} means a field here, for one before it is named {member}, and IDL "
                                    "does not tell upper "
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
            self.problem(token, f"{left} {sign} {right} is {result}, but compilers of IDL agree only on numbers from 0 to "
                                f"{2 ** 32 - 1}; write "
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
