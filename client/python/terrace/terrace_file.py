# SPDX-License-Identifier: BSD-3-Clause
"""Reads `.terrace` files, the exact form of a map (client/terrace_file.h says how they are laid out)."""
import math
import pathlib
import struct

from .terrain import EDGE_KINDS, LABELS, SOURCES, Edge, Region, Staircase, Terrain, axes_of

_MAGIC, _WITHOUT_VIEWS, _WITH_VIEWS = b"TERRACE\0", 1, 2
_HEADER_BYTES, _CHECKSUM_AT = 32, 24


def _checksum(data):
    """FNV-1a over words of eight bytes, the checksum's own place left out."""
    total = 0xcbf29ce484222325
    for at, word in enumerate(struct.unpack(f"<{len(data) // 8}Q", data)):
        if 8 * at != _CHECKSUM_AT:
            total = ((total ^ word) * 0x100000001b3) & 0xffffffffffffffff
    return total


class _Reader:
    """Takes numbers out of bytes; the first step beyond their end is a ValueError with the place."""

    def __init__(self, data, name):
        self.data, self.name, self.at = data, name, 0

    def fail(self, why):
        raise ValueError(f"{self.name}: byte {self.at}: {why}")

    def take(self, form):
        size = struct.calcsize("<" + form)
        if self.at + size > len(self.data):
            self.fail("the file ends too early")
        values = struct.unpack_from("<" + form, self.data, self.at)
        self.at += size
        return values if len(values) > 1 else values[0]

    def count(self, min_bytes):
        count = self.take("I")
        if count * min_bytes > len(self.data) - self.at:
            self.fail(f"says {count} items, more than the file holds")
        return count

    def named(self, names):
        number = self.take("b")
        if not 0 <= number < len(names):
            self.fail(f"must lie between 0 and {len(names) - 1}")
        return names[number]

    def text(self):
        size = self.count(1)
        text = self.data[self.at:self.at + size]
        self.at += size
        return text.decode(errors="replace")

    def ring(self):
        size = self.count(24)
        if size < 3:
            self.fail("a ring must have three vertices or more")
        values = self.take(f"{3 * size}d")
        if not all(map(math.isfinite, values)):
            self.fail("vertices must be finite")
        return tuple(zip(values[0::3], values[1::3], values[2::3]))


def _head(reader, size):
    if size < _HEADER_BYTES:
        reader.fail("too short for a .terrace file")
    if reader.data[:8] != _MAGIC:
        reader.fail("this is no .terrace file")
    reader.at = 8
    version, zero, told_size, checksum = reader.take("IIQQ")
    if version not in (_WITHOUT_VIEWS, _WITH_VIEWS) or zero != 0:
        reader.fail(f"is of version {version}, only 1 and 2 are known")
    if told_size != size or size % 8 != 0:
        reader.fail(f"the file has {size} bytes, must have {told_size}")
    if checksum != _checksum(reader.data):
        reader.fail("the checksum differs: the file is damaged")
    return version


def _staircase(reader):
    number, num_risers, num_treads = reader.take("qii")
    riser, _, tread, _, width, turn, _, confidence = reader.take("8d")
    edges = reader.take("12d")
    direction = reader.take("3d")
    reader.take("q")  # when it was seen last
    for _ in range(reader.count(8)):
        reader.take("q")  # its regions carry its id
    base = tuple(0.5 * (edges[i] + edges[i + 3]) for i in range(3))
    return Staircase(number, num_risers, num_treads, riser, tread, width, base, direction, confidence, turn)


def _edges(reader, num_vertices):
    count = reader.count(17)
    if count not in (0, num_vertices):
        reader.fail("must have no edges or one for each vertex")
    if count == 0:
        return (Edge("limit"),) * num_vertices
    known = [(reader.named(EDGE_KINDS), *reader.take("dd")) for _ in range(count)]
    return tuple(Edge(kind, *(None if math.isnan(v) else v for v in values)) for kind, *values in known)


def _region(reader):
    number, revision = reader.take("qi")
    label, source = reader.named(LABELS), reader.named(SOURCES)
    confidence, why = reader.take("d"), reader.text()
    normal, offset = reader.take("3d"), reader.take("d")
    cov = reader.take("9d")
    centroid = reader.take("3d")
    rms, area, _ = reader.take("3d")
    reader.take("i")  # number of observations
    first_seen, last_seen = reader.take("qq")
    on_staircase, staircase_id = reader.take("bq")
    is_step, step_index = reader.take("bi")
    rings = [reader.ring()]
    rings += [reader.ring() for _ in range(reader.count(24))]
    off = sum(n * c for n, c in zip(normal, centroid)) - offset
    known = any(cov) and all(map(math.isfinite, cov))
    return Region(
        id=number, revision=revision, label=label, confidence=confidence, normal=normal,
        origin=tuple(c - off * n for c, n in zip(centroid, normal)), rings=tuple(rings),
        edges=_edges(reader, sum(map(len, rings))), area_m2=area, rms_m=rms, source=source,
        plane_cov=(cov[0:3], cov[3:6], cov[6:9]) if known else None, axes=axes_of(normal), why=why,
        first_seen_ns=first_seen, last_seen_ns=last_seen, staircase_id=staircase_id if on_staircase else None,
        step_index=step_index if is_step else None)


def load_terrace(path):
    """The Terrain in a `.terrace` file, as SAVE_MAP and `terrace export` write them. Raises OSError when it cannot be read,
    ValueError with the place and the reason when it is damaged or no such file."""
    data = pathlib.Path(path).read_bytes()
    reader = _Reader(data, str(path))
    version = _head(reader, len(data))
    t_capture, seq, map_id, _epoch = reader.take("qqqi")
    T_world_left = reader.take("16d")  # column after column
    reader.take("36d")  # its covariance
    reader.take("16d")  # T_body_left
    reader.take("b")
    gravity = reader.take("3d")
    reader.take("db")  # sigma and source
    staircases = {s.id: s for s in (_staircase(reader) for _ in range(reader.count(200)))}
    regions = {r.id: r for r in (_region(reader) for _ in range(reader.count(200)))}
    if version == _WITH_VIEWS:  # by which the daemon recognises places
        for _ in range(reader.count(140)):
            reader.take("q16d")
            num_corners = reader.count(56)
            reader.at += 56 * num_corners
    if len(data) - reader.at >= 8:
        reader.fail("there is more behind the last item")
    return Terrain(t_capture, map_id, seq, regions, staircases, gravity, T_world_left[12:15])
