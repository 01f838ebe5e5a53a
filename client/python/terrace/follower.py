# SPDX-License-Identifier: BSD-3-Clause
"""Keeps a copy of the daemon's map in step with its messages, whatever the network loses, doubles or reorders."""
import dataclasses
import time

from ._messages import repair_step_v1_t, terrain_repair_v1_t, terrain_v1_t
from .decode import region_of, staircase_of
from .terrain import Terrain

_MAX_PENDING = 256  # snapshots and deltas that are not whole yet
_LOST_AFTER_S = 0.01  # packets overtake one another by this much
_ASK_AGAIN_S, _ASK_INTO_SILENCE_S = 0.025, 0.1
_MAX_LISTED = 120  # parts; a question fits one packet


@dataclasses.dataclass
class _Step:
    """A snapshot or a delta, whole or still in parts."""
    parts: dict
    num_parts: int = 0  # 0: not known yet
    t_last: float = 0.0

    def whole(self):
        return self.num_parts > 0 and len(self.parts) == self.num_parts


class TerrainFollower:
    """Takes terrain_v1_t as they come and has the newest whole state of the map. Knows no bus: TerrainClient has one."""

    def __init__(self):
        #: The newest state, a Terrain; None before the first snapshot.
        self.map = None
        #: Messages that were no terrain_v1_t, or could not be meant.
        self.num_bad_messages = 0
        self._steps = {}  # (map_id, seq, base_seq, kind) -> _Step, in order of arrival
        self._retired = set()
        self._newest = (0, -1)  # map_id and seq that anybody has spoken of
        self._t_newest = 0.0
        self._t_asked = None
        self._t_heard = 0.0

    def in_step(self):
        """Whether `map` is the newest state that anybody has spoken of."""
        return self.map is not None and (self.map.map_id, self.map.seq) >= self._newest \
            and self.map.map_id == self._newest[0]

    def receive(self, data, now=None):
        """Takes the bytes of a message; True when there is another map."""
        now = time.monotonic() if now is None else now
        try:
            message = terrain_v1_t.decode(data)
        except Exception:  # the generated decoder raises whatever damaged bytes lead to
            self.num_bad_messages += 1
            return False
        self._t_heard = now
        if message.map_id in self._retired:
            return False
        if message.map_id != self._newest[0] or message.seq > self._newest[1] or message.kind == terrain_v1_t.SEEN:
            if (message.map_id, message.seq) != self._newest:
                self._newest, self._t_newest = (message.map_id, message.seq), now
        if message.kind == terrain_v1_t.SEEN:
            return self._see_again(message)
        if self.map and message.map_id == self.map.map_id and message.seq <= self.map.seq:
            return False
        self._add(message, now)
        return self._apply_all()

    def take_repair(self, now=None):
        """A terrain_repair_v1_t to send now; None when nothing is missing or was just asked for. Every 10 ms or so."""
        now = time.monotonic() if now is None else now
        if self.in_step():
            return None
        patience = _ASK_AGAIN_S if self._t_asked is not None and self._t_heard >= self._t_asked else _ASK_INTO_SILENCE_S
        if self._t_asked is not None and now - self._t_asked < patience:
            return None
        quiet = any(now - step.t_last >= _LOST_AFTER_S for step in self._steps.values())
        if self._newest[0] and not quiet and now - self._t_newest < _LOST_AFTER_S:
            return None  # what has just come goes on coming
        self._t_asked = now
        return self._repair()

    def _repair(self):
        repair = terrain_repair_v1_t()
        repair.utime = int(1e6 * time.time())
        repair.map_id = self._newest[0]
        repair.have_seq = self.map.seq if self.map and self.map.map_id == self._newest[0] else -1
        listed = 0
        for (map_id, seq, _, kind), step in self._steps.items():
            if map_id != self._newest[0]:
                continue
            lacks = repair_step_v1_t()
            lacks.kind, lacks.seq = kind, seq
            end = step.num_parts or max(step.parts) + 1
            lacks.missing = [part for part in range(end) if part not in step.parts][:_MAX_LISTED - listed]
            listed += len(lacks.missing)
            if not step.num_parts:
                lacks.missing += [end, -1]  # and all behind
            lacks.n_missing = len(lacks.missing)
            repair.steps.append(lacks)
        repair.steps = repair.steps[:40]
        repair.n_steps = len(repair.steps)
        return repair

    def _add(self, message, now):
        key = (message.map_id, message.seq, message.base_seq, message.kind)
        step = self._steps.setdefault(key, _Step({}))
        step.parts.setdefault(message.part, message)
        step.num_parts = max(step.num_parts, message.n_parts)
        step.t_last = now
        while len(self._steps) > _MAX_PENDING:
            del self._steps[next(iter(self._steps))]

    def _apply_all(self):
        changed = False
        while True:
            for key, step in self._steps.items():
                map_id, _, base_seq, kind = key
                fits = self.map and self.map.map_id == map_id and self.map.seq == base_seq
                if step.whole() and (kind == terrain_v1_t.SNAPSHOT or fits):
                    break
            else:
                return changed
            del self._steps[key]
            try:
                self.map = self._state_after([step.parts[number] for number in sorted(step.parts)])
                changed = True
            except ValueError:
                self.num_bad_messages += 1
                continue
            self._steps = {k: s for k, s in self._steps.items()
                           if k[0] not in self._retired and (k[0] != self.map.map_id or k[1] > self.map.seq)}

    def _state_after(self, parts):
        first = parts[0]
        keep = self.map is not None and first.kind == terrain_v1_t.DELTA
        regions = dict(self.map.regions) if keep else {}
        staircases = dict(self.map.staircases) if keep else {}
        pieces = {}
        for part in parts:
            for gone in part.removed_ids:
                regions.pop(gone, None)
            for gone in part.removed_staircase_ids:
                staircases.pop(gone, None)
            for piece in part.regions:
                pieces.setdefault(piece.id, {})[piece.piece] = piece
        for region_id, numbered in pieces.items():
            regions[region_id] = region_of([numbered[number] for number in sorted(numbered)])
        for part in parts:
            for message in part.staircases:
                staircases[message.id] = staircase_of(message)
        if self.map is not None and self.map.map_id != first.map_id:
            self._retired.add(self.map.map_id)
        return Terrain(first.t_capture_ns, first.map_id, first.seq, regions, staircases, tuple(first.gravity),
                       tuple(first.sensor_pos))

    def _see_again(self, message):
        if not self.map or (message.map_id, message.seq) != (self.map.map_id, self.map.seq) \
                or message.t_capture_ns < self.map.t_capture_ns:
            return False
        regions = dict(self.map.regions)
        for region_id, age_ms in zip(message.seen_ids, message.seen_age_ms):
            seen_ns = 1000 * message.utime - 1_000_000 * age_ms
            if region_id in regions and regions[region_id].last_seen_ns < seen_ns:
                regions[region_id] = dataclasses.replace(regions[region_id], last_seen_ns=seen_ns)
        self.map = dataclasses.replace(self.map, t_capture_ns=message.t_capture_ns, regions=regions,
                                       sensor_pos=tuple(message.sensor_pos))
        return True
