"""The IDL files of one type library, with the checks that need more than one declaration."""
import os
import re

from idl.code import c_name, outputs_of
from idl.declarations import (MAX_DESCRIPTION, MAX_FIELDS, MAX_NESTING, MAX_SAMPLE, Enum, File, Scope, Struct, description,
                              max_size)
from idl.parser import Parser
from idl.tokens import Problems


class Library:
    """The IDL files of one type library."""

    def __init__(self):
        self.problems = Problems()
        self.root = Scope("", None)
        self.files = {}             # each File by its real path, in the order in which they were read
        self.named = []             # the files on the command line

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
            self.problems.add((path, 0), f"the file cannot be read: {reason}")
            file.complete = True
            return file
        Parser(self, file, text).parse()
        file.complete = True
        return file

    def include(self, by, name, place):
        path = os.path.join(os.path.dirname(by.path), name)
        if not os.path.isfile(path):
            self.problems.add(place, f"{name} not found; the path is relative to the folder of this file")
            return
        file = self.read(path)
        if not file.complete:
            self.problems.add(place, f"{name} includes this file; a file cannot include itself")
            return
        by.includes.append((file, place))

    def check_files(self):
        """Reports problems that concern whole files."""
        for file in self.files.values():
            # Each #include of a file without an include guard inserts the file again, as in the C preprocessor.
            seen = {}

            def visit(by, place):
                for other, at in by.includes:
                    where = place or at
                    if other.real in seen and not other.guarded:
                        guard = other.stem.upper() + "_IDL"
                        self.problems.add(where, f"{os.path.basename(other.path)} is included twice in this file; write "
                                                 f"#ifndef {guard}, #define {guard} and #endif around its content")
                    elif other.real not in seen:
                        seen[other.real] = True
                        visit(other, where)

            visit(file, None)
            if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", file.stem):
                self.problems.add((file.path, 1), f"{file.stem!r} is used in C names; use only letters, digits and "
                                                  "'_' in the file name")
        outputs = {}
        for file in self.named:
            for output in outputs_of(file.stem):
                other = outputs.setdefault(output, file)
                if other is not file:
                    self.problems.add((file.path, 1), f"{other.path} also generates {output}; rename one of the files")
                    break
            for included, place in file.includes:
                if included not in self.named:
                    self.problems.add(place, f"{os.path.basename(included.path)} is not in the same library; add it to "
                                             "takt_add_idl")

    def check_types(self):
        names = {}
        for file in self.files.values():
            for declared in file.declares:
                if isinstance(declared, (Struct, Enum)):
                    flat = c_name(declared.name)
                    if names.setdefault(flat, declared) is not declared:
                        self.problems.add(declared.place, f"{declared.name} and {names[flat].name} are both {flat} in C; "
                                                          "choose another name")
                if not isinstance(declared, Struct) or not declared.valid:
                    continue
                if declared.count > MAX_FIELDS:
                    self.problems.add(declared.place, f"{declared.name} has {declared.count} fields, including those of nested "
                                                      f"structs; the limit is {MAX_FIELDS}")
                elif declared.nesting > MAX_NESTING:
                    self.problems.add(declared.place, f"{declared.name} nests structs {declared.nesting} levels deep; the limit "
                                                      f"is {MAX_NESTING}")
                elif len(description(declared)) > MAX_DESCRIPTION:
                    self.problems.add(declared.place, f"the description of {declared.name} has {len(description(declared))} "
                                                      f"bytes; the limit is {MAX_DESCRIPTION}: use fewer fields, fewer "
                                                      "enumerators or shorter names")
                elif max_size(declared) > MAX_SAMPLE:
                    self.problems.add(declared.place, f"a sample of {declared.name} can have {max_size(declared)} bytes; the "
                                                      f"limit is {MAX_SAMPLE}")
