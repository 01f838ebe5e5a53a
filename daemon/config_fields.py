#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""config_fields.py OUT HEADER...: makes every field of every `struct ...Config` a key of the configuration file.

A field is one line `type name = default;` with its documentation in `///` lines above it, which is also what
`terraced --print-config` prints; fields on consecutive lines share it. Written for each struct:

    template <typename Visitor>
    void VisitFields(XConfig& config, Visitor&& visit) { visit("name", config.name, "documentation"); ... }
"""
import re
import sys

TYPES = ("bool", "int", "double", "std::string", "std::optional<int>", "std::optional<double>", "std::vector<double>")


def structs(path):
    """Yields (struct, [(field, comment)]); exits with a sentence where a field cannot be a key."""
    struct, fields, comment, was_field = None, [], [], False
    for number, line in enumerate(open(path), 1):
        text = line.strip()
        follows_field, was_field = was_field, False
        if match := re.match(r"struct (\w+Config)\b", text):
            struct, fields, comment = match.group(1), [], []
        elif struct and line.startswith("}"):
            yield struct, fields
            struct = None
        elif struct and text.startswith("///"):
            comment.append(text[3:].strip())
        elif struct and "(" not in text and (match := re.match(r"([\w:<>]+) (\w+)(?: = .*|\{.*\})?;$", text)):
            kind, name = match.groups()
            if kind not in TYPES:
                sys.exit(f"{path}:{number}: a setting has one of the types {', '.join(TYPES)}")
            if not comment and not follows_field:
                sys.exit(f"{path}:{number}: {struct}::{name} has no '///' comment above it")
            fields.append((name, "\\n".join(c.replace('"', '\\"') for c in comment)))
            comment, was_field = [], True
        else:
            comment = []


def main():
    with open(sys.argv[1], "w") as out:
        for header in sys.argv[2:]:
            for struct, fields in structs(header):
                out.write(f"template <typename Visitor>\nvoid VisitFields({struct}& config, Visitor&& visit) {{\n")
                out.writelines(f'  visit("{name}", config.{name}, "{comment}");\n' for name, comment in fields)
                out.write("}\n")


main()
