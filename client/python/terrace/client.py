# SPDX-License-Identifier: BSD-3-Clause
"""The daemon's map and pose in a planner's program."""
import time

from ._messages import map_transform_v1_t, pose_v1_t, status_v1_t
from .follower import TerrainFollower


class TerrainClient:
    """Listens on a Bus inside its handle(), and asks the daemon for what is missing.

    handle() returns when something has come; while nothing comes, call it again at least ten times a second, so that what
    was lost is asked for: `while True: bus.handle(0.05); terrain.ask()`, or simply terrain.wait().
    """

    def __init__(self, bus, terrain="TERRACE_TERRAIN", repair="TERRACE_REPAIR", pose="TERRACE_POSE_STATE",
                 status="TERRACE_STATUS", map_transform="TERRACE_MAP_TRANSFORM"):
        self._bus, self._repair = bus, repair
        self._follower = TerrainFollower()
        #: The newest pose_v1_t, status_v1_t, and map_transform_v1_t (of a loaded map); None before the first.
        self.pose = None
        self.status = None
        self.map_transform = None
        #: Messages of another type, or damaged, by channel.
        self.num_bad = {terrain: 0, pose: 0, status: 0, map_transform: 0}
        bus.subscribe(terrain, self._on_terrain)
        bus.subscribe(pose, lambda channel, data: self._decode("pose", pose_v1_t, channel, data))
        bus.subscribe(map_transform,
                      lambda channel, data: self._decode("map_transform", map_transform_v1_t, channel, data))
        bus.subscribe(status, lambda channel, data: self._decode("status", status_v1_t, channel, data))

    @property
    def map(self):
        """The newest state of the map, a terrace.Terrain that never changes; None before the first."""
        return self._follower.map

    def in_step(self):
        """Whether `map` is the newest state that anybody has spoken of."""
        return self._follower.in_step()

    def ask(self):
        """Asks the daemon for what is missing, when anything is and it is time to."""
        repair = self._follower.take_repair()
        if repair is not None:
            self._bus.publish(self._repair, repair)

    def wait(self, timeout_s=10.0):
        """Receives until the map is in step; returns it, or None when it is not within `timeout_s`."""
        end = time.monotonic() + timeout_s
        while time.monotonic() < end:
            self.ask()
            self._bus.handle(0.02)
            if self.in_step():
                return self.map
        return None

    def _on_terrain(self, channel, data):
        self._follower.receive(data)
        self.num_bad[channel] = self._follower.num_bad_messages
        self.ask()

    def _decode(self, name, message_type, channel, data):
        try:
            setattr(self, name, message_type.decode(data))
        except Exception:  # the generated decoder raises whatever damaged bytes lead to
            self.num_bad[channel] += 1
