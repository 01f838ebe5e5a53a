# SPDX-License-Identifier: BSD-3-Clause
"""Reads the map that `terraced replay` left."""
import json
import pathlib

from .terrain import Edge, Region, Staircase, Terrain, axes_of


def _region(value):
    rings = tuple(tuple(tuple(map(float, p)) for p in ring) for ring in [value["outline"], *value["holes"]])
    normal = tuple(map(float, value["normal"]))
    told = value.get("edges") or [[{"kind": "limit"}] * len(ring) for ring in rings]
    edges = tuple(Edge(e["kind"], e.get("step_m"), e.get("sigma_m")) for ring in told for e in ring)
    middle = [sum(p[i] for p in rings[0]) / len(rings[0]) for i in range(3)]
    off = sum(n * m for n, m in zip(normal, middle)) - value["offset_m"]
    return Region(
        id=value["id"], revision=value["revision"], label=value["label"], confidence=value["confidence"], normal=normal,
        origin=tuple(m - off * n for m, n in zip(middle, normal)), rings=rings, edges=edges, area_m2=value["area_m2"], rms_m=value["rms_m"],
        source="predicted" if value["predicted"] else "seen", axes=axes_of(normal), why=value.get("why", ""),
        first_seen_ns=value["first_seen_ns"], last_seen_ns=value["last_seen_ns"], staircase_id=value["staircase"],
        step_index=value["step_index"])


def _staircase(value):
    return Staircase(
        id=value["id"], num_risers=value["num_steps"], num_treads=value["num_treads"], riser_m=value["riser_m"],
        tread_m=value["tread_m"], width_m=value["width_m"], base=tuple(value["base_world"]),
        direction_up=tuple(value["direction_world"]), confidence=value["confidence"])


def load_result(folder):
    """The Terrain of a result: a folder with terrain_map.json, or such a file. The file holds no plane covariance, so sigmas
    of heights are not known (NaN). Raises OSError or ValueError when it cannot be read."""
    path = pathlib.Path(folder)
    path = path / "terrain_map.json" if path.is_dir() else path
    value = json.loads(path.read_text())
    if value.get("format") != "terrace-map" or value.get("version") != 1:
        raise ValueError(f"{path}: is no terrace-map of version 1")
    try:
        regions = {r["id"]: _region(r) for r in value["regions"]}
        staircases = {s["id"]: _staircase(s) for s in value["staircases"]}
    except KeyError as missing:
        raise ValueError(f"{path}: has no {missing}") from None
    return Terrain(value["t_capture_ns"], 1, 1, regions, staircases)
