"""The files that become one library of types, and what is wrong with them together."""
import os
import re

from idl.code import c_name, outputs_of
from idl.declarations import (MAX_DESCRIPTION, MAX_FIELDS, MAX_NESTING, MAX_SAMPLE, Enum, File, Scope, Struct, description,
                              max_size)
from idl.parser import Parser
from idl.tokens import Problems


# Headers of the system: motion.idl makes motion.h, which is found as <motion.h>.
SYSTEM_HEADERS = set("""alloca assert complex ctype dirent dlfcn elf endian errno fcntl features fenv float inttypes iso646
    limits link locale malloc math memory poll pthread sched semaphore setjmp signal spawn stdalign stdarg stdatomic stdbool
    stddef stdint stdio stdlib stdnoreturn string strings syscall termios tgmath threads time uchar unistd utime values wait
    wchar wctype""".split())


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
            self.problems.add((path, 0), f"the file cannot be read: {reason}")
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
                        self.problems.add(where, f"{os.path.basename(other.path)} comes twice in this file; write #ifndef "
                                                 f"{guard}, "
                                          f"#define {guard} and #endif around what is in it")
                    elif other.real not in seen:
                        seen[other.real] = True
                        visit(other, where)

            visit(file, None)
            if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", file.stem):
                self.problems.add((file.path, 1), f"{file.stem!r} becomes a part of names in C; name the file with "
                                                  "letters, digits and '_'")
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
                    self.problems.add(place, f"{os.path.basename(included.path)} is not in the same library; name it in "
                                             "takt_add_idl too")

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
                        self.problems.add(declared.place, f"{declared.name} and {names[flat].name} are both {flat} in C; "
                                                          "take another name")
                if not isinstance(declared, Struct) or not declared.sound:
                    continue
                if declared.count > MAX_FIELDS:
                    self.problems.add(declared.place, f"{declared.name} has {declared.count} fields with those of its "
                                                      "structs; a type "
                                      f"has at most {MAX_FIELDS}")
                elif declared.nesting > MAX_NESTING:
                    self.problems.add(declared.place, f"{declared.name} has structs within one another {declared.nesting} "
                                                      "deep; a type "
                                      f"has at most {MAX_NESTING}")
                elif len(description(declared)) > MAX_DESCRIPTION:
                    self.problems.add(declared.place, f"{declared.name} takes {len(description(declared))} bytes to "
                                                      "describe; a type takes "
                                      f"at most {MAX_DESCRIPTION}: fewer fields, fewer enumerators, shorter names")
                elif max_size(declared) > MAX_SAMPLE:
                    self.problems.add(declared.place, f"a sample of {declared.name} has up to {max_size(declared)} bytes; "
                                                      "it has at most "
                                      f"{MAX_SAMPLE}")
