#!/usr/bin/env python3
"""Writes a drawing and a table of the rooms into ARCHITECTURE.md, between two marks. Both show which room may include which.

Usage: draw_rooms.py [--check] ROOMS_FILE PAGE

CMake writes ROOMS_FILE; check_includes.py describes its format. With --check, leaves the page unchanged, and exits with 1 if its drawing
differs.
"""
import sys
from pathlib import Path

BEGIN, END = "<!-- rooms -->\n", "<!-- end of rooms -->"


def read_rooms(file):
    """Returns, for each room, the rooms that it uses and the libraries that it owns."""
    rooms = {}
    for line in Path(file).read_text().splitlines():
        name, used, owned = line.split(";")
        rooms[name] = ([room for room in used.split(",") if room], [library for library in owned.split(",") if library])
    return rooms


def reachable(uses, room):
    """Returns all rooms that `room` uses, directly or through other rooms."""
    found, pending = set(), list(uses[room])
    while pending:
        other = pending.pop()
        if other not in found:
            found.add(other)
            pending += uses.get(other, [])
    return found


def drawing(uses):
    """Returns the drawing as Mermaid text. Leaves out an arrow where a longer path leads to the same room."""
    lines = ["<!-- shown: a drawing -->", "```mermaid", "flowchart TB"]
    for room, used in uses.items():
        implied = set().union(*(reachable(uses, other) for other in used if other in uses)) if used else set()
        lines += [f"  {room} --> {other}" for other in used if other not in implied]
    return "\n".join(lines + ["```"]) + "\n"


def table(rooms):
    lines = ["| Room | May include | Owns the headers of |", "|---|---|---|"]
    return "\n".join(lines + [f"| {room} | {', '.join(used) or '-'} | {', '.join(owned)} |" for room, (used, owned) in rooms.items()]) + "\n"


def main(arguments):
    check = arguments[:1] == ["--check"]
    rooms, page = arguments[1:] if check else arguments
    text = Path(page).read_text(encoding="utf-8")
    begin, end = text.index(BEGIN) + len(BEGIN), text.index(END)
    found = read_rooms(rooms)
    drawn = drawing({room: used for room, (used, _) in found.items()}) + "\n" + table(found)
    if check:
        if text[begin:end] != drawn:
            print(f"{page}: error: its drawing differs from the build; run cmake/draw_rooms.py {rooms} {page}", file=sys.stderr)
            return 1
        return 0
    Path(page).write_text(text[:begin] + drawn + text[end:], encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
