# SPDX-License-Identifier: BSD-3-Clause
"""Asks a daemon for what it does not send by itself."""
import random
import time

from ._messages import command_reply_v1_t, disparity_v1_t, height_map_v1_t, octree_v1_t, terrain_request_v1_t
from .follower import TerrainFollower


class RequestRefused(Exception):
    """The daemon will not answer; the text names the rule that is broken."""


class Requests:
    """Requests over a Bus, to one daemon:

        requests = terrace.Requests(bus)
        grid = requests.heights((-1, -1, -1), (1, 1, 1), resolution_m=0.05)  # height_map_v1_t
        tree = requests.octree((-2, -2, -2), (2, 2, 2))                       # octree_v1_t; tree.data is OctoMap's file
        image = requests.disparity()                                          # disparity_v1_t
        terrain = requests.box((-1, -1, -1), (1, 1, 1))                       # Terrain: the regions that reach into the box

    Boxes are in metres along the world's axes, counted from the left camera, or from the world's origin with
    around_robot=False. Each raises RequestRefused, or TimeoutError when no answer comes within timeout_s. For answers at a
    rate, publish a terrain_request_v1_t yourself (lcmtypes/README.md).
    """

    def __init__(self, bus, request="TERRACE_REQUEST", reply="TERRACE_REPLY", height_map="TERRACE_HEIGHT_MAP",
                 octree="TERRACE_OCTREE", disparity="TERRACE_DISPARITY", map_box="TERRACE_MAP_BOX"):
        self._bus, self._request = bus, request
        self._refusals, self._answers = {}, {}
        self._box = None
        bus.subscribe(reply, self._on_reply)
        for channel, kind, message in ((height_map, terrain_request_v1_t.HEIGHT_MAP, height_map_v1_t),
                                       (octree, terrain_request_v1_t.OCTREE, octree_v1_t),
                                       (disparity, terrain_request_v1_t.DISPARITY, disparity_v1_t)):
            bus.subscribe(channel, lambda _, data, kind=kind, message=message: self._on_answer(kind, message, data))
        bus.subscribe(map_box, self._on_part)

    def heights(self, box_min, box_max, resolution_m, around_robot=True, timeout_s=5.0):
        """Heights on a grid: height_map_v1_t."""
        return self._once(terrain_request_v1_t.HEIGHT_MAP, box_min, box_max, around_robot, resolution_m, timeout_s)

    def octree(self, box_min, box_max, around_robot=True, timeout_s=5.0):
        """The occupied leaves in a box: octree_v1_t."""
        return self._once(terrain_request_v1_t.OCTREE, box_min, box_max, around_robot, 0.0, timeout_s)

    def disparity(self, timeout_s=5.0):
        """The disparity image of the newest frame: disparity_v1_t."""
        return self._once(terrain_request_v1_t.DISPARITY, (0, 0, 0), (0, 0, 0), False, 0.0, timeout_s)

    def box(self, box_min, box_max, around_robot=True, timeout_s=5.0):
        """The regions that reach into a box: Terrain."""
        self._box = TerrainFollower()
        return self._once(terrain_request_v1_t.MAP, box_min, box_max, around_robot, 0.0, timeout_s)

    def _once(self, what, box_min, box_max, around_robot, resolution_m, timeout_s):
        message = terrain_request_v1_t()
        message.utime = int(1e6 * time.time())
        message.request_id, message.what, message.around_robot = random.getrandbits(62), what, around_robot
        message.box_min, message.box_max, message.resolution = list(box_min), list(box_max), resolution_m
        self._answers.pop(what, None)
        self._bus.publish(self._request, message)
        end = time.monotonic() + timeout_s
        while time.monotonic() < end:
            self._bus.handle(0.05)
            if message.request_id in self._refusals:
                raise RequestRefused(self._refusals.pop(message.request_id))
            if what in self._answers:
                return self._answers.pop(what)
        raise TimeoutError(f"no answer within {timeout_s} s: does a daemon run, and do images come?")

    def _on_reply(self, _, data):
        reply = command_reply_v1_t.decode(data)
        if reply.result != reply.OK:
            self._refusals[reply.request_id] = reply.message

    def _on_answer(self, what, message_type, data):
        self._answers[what] = message_type.decode(data)

    def _on_part(self, _, data):
        if self._box is not None and self._box.receive(data):
            self._answers[terrain_request_v1_t.MAP] = self._box.map
