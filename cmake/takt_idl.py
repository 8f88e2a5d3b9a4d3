#!/usr/bin/env python3
"""Generates the C++ classes and the C structs of port types from IDL files.

  takt_idl.py --check a.idl b.idl          only checks the files
  takt_idl.py --out DIR a.idl b.idl        writes DIR/a.hpp, a_types.cpp, a_c.h and a_c.cpp, and the same files for b.idl

A port type is a final struct without keys. Its strings and sequences are bounded, so that Takt can allocate its memory
before the cell runs. One run reports all problems, one per line: `file:line: error: what; what to do`. The exit status is
then 1. fastddsgen and Cyclone DDS's idlc also accept every file that this script accepts.
"""
import argparse
import sys

sys.dont_write_bytecode = True

from idl.code import write_sources  # noqa: E402
from idl.library import Library  # noqa: E402


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    group = parser.add_mutually_exclusive_group(required=True)
    group.add_argument("--check", action="store_true", help="only check the files")
    group.add_argument("--out", metavar="DIR", help="write the sources to DIR")
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
        for file in library.named:
            write_sources(arguments.out, file)
    return 0


if __name__ == "__main__":
    sys.exit(main())
