#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Holds the arrows between the folders: a file includes headers of its own folder and of those it may know.

Also asks every source file for its licence line. Prints every break; exit code 1 when there is one.
"""
import pathlib
import re
import sys

ALLOWED = {
    "core": [],
    "stereo": ["core"],
    "odometry": ["core", "stereo"],
    "mapping": ["core", "stereo", "odometry"],
    "polygonization": ["core", "stereo", "odometry", "mapping"],
    "labeling": ["core", "stereo", "odometry", "mapping", "polygonization"],
    "terrain": ["core", "stereo", "odometry", "mapping", "polygonization", "labeling"],
    "lcmtypes": ["core"],
    "client": ["core", "lcmtypes"],
    "datasets": ["core", "stereo", "lcmtypes"],
    "results": ["core"],
    "evaluation": ["core", "datasets", "results"],
}
ROOT = pathlib.Path(__file__).resolve().parent.parent
EVERYTHING = [*ALLOWED, "daemon", "tools"]
ALLOWED["daemon"] = [f for f in EVERYTHING if f != "tools"]
ALLOWED["tools"] = EVERYTHING
LICENCE = "SPDX-License-Identifier: BSD-3-Clause"

problems = []
for folder in [*EVERYTHING, "test", "bench"]:
    for path in sorted((ROOT / folder).rglob("*")):
        if path.suffix not in (".h", ".cpp", ".py", ".lcm", ".sh") and path.name != "CMakeLists.txt":
            continue
        text = path.read_text()
        name = path.relative_to(ROOT)
        if LICENCE not in "\n".join(text.splitlines()[:3]):
            problems.append(f"{name}: has no line '{LICENCE}'")
        if folder in ("test", "bench"):
            continue
        for number, line in enumerate(text.splitlines(), 1):
            match = re.match(r'\s*#include "(?:terrace/)?(\w+)/', line)
            target = match and match.group(1)
            if target in EVERYTHING and target != folder and target not in ALLOWED[folder]:
                problems.append(f"{name}:{number}: {folder} must not know {target}")

print("\n".join(problems) if problems else "the arrows hold")
sys.exit(1 if problems else 0)
