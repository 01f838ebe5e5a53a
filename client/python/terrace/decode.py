# SPDX-License-Identifier: BSD-3-Clause
"""Turns messages into regions and staircases. Raises ValueError for values that cannot be meant."""
import math

from .terrain import EDGE_KINDS, LABELS, SOURCES, Edge, Region, Staircase


def _rotation(quat):
    """Columns of the rotation of a quaternion w, x, y, z."""
    length = math.sqrt(sum(q * q for q in quat))
    if not abs(length - 1.0) < 1e-3:
        raise ValueError("a rotation is no unit quaternion")
    w, x, y, z = (q / length for q in quat)
    return ((1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)),
            (2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)),
            (2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)))


def _known(value):
    return None if math.isnan(value) else value


def _rings_of(pieces):
    rings, edges = [], []
    for piece in pieces:
        x_axis, y_axis, _ = _rotation(piece.quat)
        if sum(piece.ring_size) != piece.n_vertices or piece.n_coords != 2 * piece.n_vertices:
            raise ValueError("the rings of a region do not add up")
        vertex = 0
        for number, size in enumerate(piece.ring_size):
            if not (number == 0 and piece.continues and rings):
                rings.append([])
            for i in range(vertex, vertex + size):
                u, v = piece.coords[2 * i], piece.coords[2 * i + 1]
                point = tuple(o + u * a + v * b for o, a, b in zip(piece.origin, x_axis, y_axis))
                if not all(map(math.isfinite, point)) or not 0 <= piece.edge_kind[i] < len(EDGE_KINDS):
                    raise ValueError("a vertex of a region cannot be meant")
                rings[-1].append(point)
                edges.append(Edge(EDGE_KINDS[piece.edge_kind[i]], _known(piece.edge_step[i]), _known(piece.edge_sigma[i])))
            vertex += size
    return tuple(map(tuple, rings)), tuple(edges)


def region_of(pieces):
    """The Region of all pieces of one revision, region_v1_t by ascending number."""
    first = pieces[0]
    numbers = [piece.piece for piece in pieces]
    if numbers != list(range(first.n_pieces)) or any(piece.revision != first.revision for piece in pieces):
        raise ValueError("a region is not whole")
    x_axis, y_axis, normal = _rotation(first.quat)
    rings, edges = _rings_of(pieces)
    if not rings or min(map(len, rings)) < 3 or not 0 <= first.source < len(SOURCES):
        raise ValueError("a region is none")
    c = first.plane_cov
    # No plane is known exactly: zeros are what a map has that came from a file without covariances.
    plane_cov = ((c[0], c[1], c[2]), (c[1], c[3], c[4]), (c[2], c[4], c[5])) if any(c) else None
    label = LABELS[first.label] if 0 <= first.label < len(LABELS) else "unknown"
    return Region(
        id=first.id, revision=first.revision, label=label, confidence=first.confidence, normal=normal,
        origin=tuple(first.origin), rings=rings, edges=edges, area_m2=first.area, rms_m=first.rms, source=SOURCES[first.source],
        plane_cov=plane_cov, axes=(x_axis, y_axis), why=first.why,
        first_seen_ns=1000 * first.first_utime, last_seen_ns=1000 * first.last_utime,
        staircase_id=first.staircase_id or None, step_index=first.step_index or None)


def staircase_of(message):
    """The Staircase of a staircase_v1_t."""
    foot = message.foot_edge
    base = tuple(0.5 * (foot[i] + foot[i + 3]) for i in range(3))
    return Staircase(
        id=message.id, num_risers=message.n_risers, num_treads=message.n_treads, riser_m=message.riser,
        tread_m=message.tread, width_m=message.width, base=base, direction_up=tuple(message.direction_up),
        confidence=message.confidence, turn_per_step_rad=message.turn_per_step)
