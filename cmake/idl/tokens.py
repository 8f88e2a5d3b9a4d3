"""Splits IDL text into tokens, and collects problems."""
import re
import sys
from dataclasses import dataclass


class Problems:
    """The problems that were found, by (file, line). Line 0 means the whole file. Each problem is reported once."""

    def __init__(self):
        self.seen = {}

    def add(self, place, text):
        self.seen.setdefault((place, text))

    def print(self, order):
        rank = {name: i for i, name in enumerate(order)}
        for (file, line), text in sorted(self.seen, key=lambda p: (rank.get(p[0][0], len(rank)), p[0][1])):
            print(f"{file}:{line}: error: {text}" if line else f"{file}: error: {text}", file=sys.stderr)


class IdlError(Exception):
    """Raised when the rest of the current declaration cannot be parsed."""

    def __init__(self, place, text):
        super().__init__(text)
        self.place = place


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
    argument: str = None            # for the name of an annotation: what follows it in parentheses


def tokens_of(text, path, problems):
    tokens, at, line, fresh = [], 0, 1, True
    while at < len(text):
        match = TOKEN.match(text, at)
        open_comment = text.startswith("/*", at) and (not match or match.lastgroup != "space")
        if open_comment or not match or (match.lastgroup == "directive" and not fresh):
            problems.add((path, line), "a comment without an end; write */" if open_comment
                         else f"unexpected character {text[at]!r}; remove it")
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
