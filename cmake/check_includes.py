#!/usr/bin/env python3
"""Rejects wrong includes. A room may include itself and the rooms that it names under USES, but no library that another room owns.

Usage: check_includes.py SOURCE_DIRECTORY ROOMS_FILE

ROOMS_FILE has a line for each room: NAME;ROOMS IT USES;LIBRARIES IT OWNS, each list separated by commas. CMake writes this file from the calls of
takt_room(). Prints an error for each wrong include, and for each call of write() of Fast DDS, and exits with 1 if there is any.
"""
import re
import sys
from pathlib import Path

# For each library: the headers that only rooms that own the library may include.
LIBRARIES = {
    "tinyxml2": r"tinyxml2\.h",
    # Any file may include the fixed-size string: generated types contain it, and it depends on no other header of Fast DDS.
    "fastdds": r"(fastdds|fastrtps)/(?!utils/fixed_size_string\.hpp).*|takt/wire/taktPubSubTypes\.h",
    "openssl": r"openssl/.*",
    "sqlite": r"sqlite3\.h",
    "zlib": r"zlib\.h",
    "linux": r"(dlfcn|elf|fcntl|link|poll|pthread|sched|signal|spawn|syscall|ucontext|unistd)\.h|(linux|sys|net|netinet|arpa)/.*",
}
# It returns true if DDS takes the sample. In Fast DDS 3, it returns 0 then, so the same source means the opposite.
WRITE = re.compile(r"writer\w*(\.|->)write\(&")
INCLUDE = re.compile(r'^\s*#\s*include\s*(?:<([^>]+)>|"([^"]+)")')


def read_rooms(file):
    rooms = {}
    for line in Path(file).read_text().splitlines():
        name, uses, owns = line.split(";")
        rooms[name] = (uses.split(",") if uses else [], owns.split(",") if owns else [])
    return rooms


def listed(names):
    return ", ".join(names) or "no other room"


def room_of(included, source):
    """Returns the room of the header <takt/ROOM/NAME.hpp>, or of the component authors' header <takt/NAME.hpp>. None if no room has it."""
    found = re.match(r"takt/([a-z]+)/", included)
    if found:
        return found[1]
    return next((path.parts[-4] for path in source.glob(f"framework/*/include/{included}")), None) if included.startswith("takt/") else None


def complaint(source, room, included, rooms):
    """Returns why a source of `room` must not include `included`; None if it may. If `room` is None, the source is in tools/."""
    uses, owns = rooms[room] if room else (list(rooms), [])
    for library, headers in LIBRARIES.items():
        if re.fullmatch(headers, included) and library not in owns:
            owners = [name for name, (_, theirs) in rooms.items() if library in theirs]
            return f"only {' and '.join(owners)} may include <{included}>; use the interface of {owners[0]}"
    other = room_of(included, source)
    if room and other and other not in (room, *uses):
        return f"room {room} may not include <{included}> of room {other}; it uses {listed(uses)} (framework/CMakeLists.txt)"
    return None


def check(source, rooms):
    errors = []
    for file in sorted(p for top in ("framework", "tools") for p in (source / top).rglob("*") if p.suffix in (".cpp", ".hpp", ".c", ".h")):
        path = file.relative_to(source)
        room = path.parts[1] if path.parts[0] == "framework" else None
        if "templates" in path.parts:
            continue
        for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), 1):
            if WRITE.search(line):
                errors.append(f"{path}:{number}: error: call write_sample() of fast_dds.hpp, because the result of write() depends on the version")
            found = INCLUDE.match(line)
            if not found:
                continue
            if room and (file.parent / (found[2] or "")).resolve().relative_to(source.resolve()).parts[:2] != path.parts[:2]:
                errors.append(f"{path}:{number}: error: an include must not lead out of its room; include <takt/ROOM/NAME.hpp>")
                continue
            wrong = complaint(source, room, found[1], rooms) if found[1] else None
            if wrong:
                errors.append(f"{path}:{number}: error: {wrong}")
    return errors


if __name__ == "__main__":
    found = check(Path(sys.argv[1]), read_rooms(sys.argv[2]))
    print("\n".join(found), file=sys.stderr, end="\n" if found else "")
    sys.exit(1 if found else 0)
