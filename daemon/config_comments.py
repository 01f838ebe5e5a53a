#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""config_comments.py OUT HEADER...: collects the comments on the fields of every `struct ...Config`.

The comment on a field is its only documentation; this brings it to `terraced --print-config`. A field is a line
`type name = default;` with `///` lines above it (or one behind it). Fields without a comment are left out here, and
the configuration test then names them.
"""
import re
import sys


def fields(text):
    struct, comment = None, []
    for line in text.splitlines():
        stripped = line.strip()
        if match := re.match(r"struct (\w+Config)\b", stripped):
            struct, comment = match.group(1), []
        elif struct and line.startswith("}"):
            struct = None
        elif struct and stripped.startswith("///"):
            comment.append(stripped[3:].strip())
        elif struct and (match := re.match(r"[\w:<>]+ (\w+)(?: = [^;]*|\{[^;]*\})?;(?:\s*///< ?(.*))?$", stripped)):
            if match.group(2):
                comment.append(match.group(2))
            if comment:
                yield struct + "::" + match.group(1), "\n".join(comment)
            comment = []
        else:
            comment = []


def main():
    lines = []
    for header in sys.argv[2:]:
        with open(header) as file:
            lines += ['{"%s", R"(%s)"},' % pair for pair in fields(file.read())]
    with open(sys.argv[1], "w") as out:
        out.write("\n".join(lines) + "\n")


main()
