#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The Python package follows a log as the C++ client does, answers as TerrainQuery does, and speaks LCM's packets.

Arguments: the folder of the package, the program that writes the log and the C++ answers.
"""
import json
import math
import os
import pathlib
import random
import subprocess
import sys
import tempfile
import unittest

PACKAGE, EXAMPLE_LOG = sys.argv[1:3]
sys.path.insert(0, PACKAGE)
import numpy as np  # noqa: E402

import terrace  # noqa: E402

_folder = tempfile.TemporaryDirectory()
LOG = pathlib.Path(_folder.name, "terrain.lcmlog")
EXPECTED = json.loads(subprocess.run([EXAMPLE_LOG, LOG], check=True, capture_output=True, text=True).stdout)
OCTREE = pathlib.Path(str(LOG) + ".octree")
MESSAGES = [event.data for event in terrace.read_log(LOG) if event.channel == "TERRACE_TERRAIN"]


def followed(messages):
    follower = terrace.TerrainFollower()
    for data in messages:
        follower.receive(data)
    return follower


class FollowerTest(unittest.TestCase):
    def expect_the_final_map(self, follower):
        self.assertTrue(follower.in_step())
        self.assertEqual(follower.num_bad_messages, 0)
        self.assertEqual(follower.map.seq, EXPECTED["seq"])
        self.assertEqual(sorted(follower.map.regions), [region["id"] for region in EXPECTED["regions"]])
        for told in EXPECTED["regions"]:
            region = follower.map.regions[told["id"]]
            self.assertEqual((region.revision, region.label), (told["revision"], told["label"]))
            self.assertAlmostEqual(region.confidence, told["confidence"], 6)
            self.assertEqual(sum(map(len, region.rings)), told["vertices"])
            self.assertEqual(len(region.edges), told["vertices"])
            for mine, theirs in zip(region.rings[0][0], told["first"]):
                self.assertAlmostEqual(mine, theirs, 6)

    def test_has_the_map_of_the_cpp_client(self):
        self.assertGreater(len(MESSAGES), 20)
        follower = followed(MESSAGES)
        self.expect_the_final_map(follower)
        for told in EXPECTED["regions"]:
            self.assertEqual(follower.map.regions[told["id"]].last_seen_ns, told["last_seen_ns"])

    def test_takes_parts_in_any_order_and_twice(self):
        shuffled = MESSAGES[:-1] * 2
        random.Random(3).shuffle(shuffled)
        self.expect_the_final_map(followed(shuffled))

    def test_names_a_lost_part_and_is_whole_when_it_comes(self):
        lost = 3
        follower = terrace.TerrainFollower()
        for number, data in enumerate(MESSAGES):
            if number != lost:
                follower.receive(data, now=10.0)
        self.assertIsNone(follower.map)
        self.assertIsNone(follower.take_repair(now=10.001), "it may be under way")
        repair = follower.take_repair(now=11.0)
        self.assertEqual(repair.have_seq, -1)
        self.assertEqual([step.missing for step in repair.steps if step.kind == terrace.terrain_v1_t.SNAPSHOT], [[lost]])
        terrace.terrain_repair_v1_t.decode(repair.encode())
        self.assertIsNone(follower.take_repair(now=11.01), "has just been asked")
        follower.receive(MESSAGES[lost])
        self.expect_the_final_map(follower)

    def test_asks_for_a_snapshot_though_it_has_heard_nothing(self):
        repair = terrace.TerrainFollower().take_repair(now=5.0)
        self.assertEqual((repair.have_seq, repair.n_steps), (-1, 0))

    def test_damaged_bytes_are_counted_and_change_nothing(self):
        follower = followed(MESSAGES)
        before = follower.map
        for size in (0, 4, 8, 60, len(MESSAGES[0]) - 1):
            self.assertFalse(follower.receive(MESSAGES[0][:size]))
        self.assertEqual(follower.num_bad_messages, 5)
        self.assertIs(follower.map, before)

    def test_unchanged_regions_are_shared_between_states(self):
        follower = terrace.TerrainFollower()
        states = []
        for data in MESSAGES:
            if follower.receive(data):
                states.append(follower.map)
        self.assertEqual(len(states), 3)
        shared = [i for i in states[0].regions if states[1].regions.get(i) is states[0].regions[i]]
        self.assertEqual(len(shared), 34)


class QueryTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.terrain = followed(MESSAGES).map
        cls.query = terrace.TerrainQuery(cls.terrain)

    def test_finds_the_ground_that_the_cpp_query_finds(self):
        num_found = 0
        for told in EXPECTED["supports"]:
            found = self.query.supports_at(*told["xy"])
            self.assertEqual([s.region_id for s in found], [s["region"] for s in told["found"]])
            for mine, theirs in zip(found, told["found"]):
                num_found += 1
                np.testing.assert_allclose(mine.point, theirs["point"], atol=1e-6)
                self.assertAlmostEqual(mine.sigma_height_m, theirs["sigma"], 7)
                self.assertAlmostEqual(mine.edge_distance_m, theirs["edge_distance"], 6)
                self.assertAlmostEqual(mine.age_s, theirs["age"], 6)
        self.assertGreater(num_found, 200)

    def test_footholds_keep_clear_and_are_as_near_as_those_of_the_cpp_query(self):
        num_found = 0
        foot = terrace.FootSpec()
        for told in EXPECTED["footholds"]:
            found = self.query.nearest_foothold(told["nominal"], 0.3, 0.3)
            if told["distance"] is None:
                # The C++ query keeps up to a millimetre more.
                self.assertTrue(found is None or found.support.edge_distance_m < foot.radius_m + 0.03 + 2e-3)
                continue
            self.assertIsNotNone(found)
            num_found += 1
            self.assertLess(found.distance_m, told["distance"] + 2.5e-3)
            self.assertGreaterEqual(found.support.edge_distance_m, foot.radius_m - 1e-8)
            clear = {"drop": foot.clear_drop_m, "rise": foot.clear_rise_m}.get(found.support.edge.kind, 0.0)
            self.assertGreaterEqual(found.support.edge_distance_m, foot.radius_m + clear - 1e-8)
        self.assertGreater(num_found, 10)

    def test_heights_are_those_of_the_highest_ground_and_nan_where_nothing_is_known(self):
        grid = self.query.heights((-2.0, -1.9), 0.21, 20, 19)
        for i in range(20):
            for j in range(19):
                found = self.query.supports_at(-2.0 + 0.21 * i, -1.9 + 0.21 * j)
                self.assertEqual(math.isnan(grid.height_m[i, j]), not found)
                self.assertEqual(grid.region_id[i, j], found[0].region_id if found else 0)
                if found:
                    self.assertAlmostEqual(grid.height_m[i, j], found[0].point[2], 9)
                    self.assertAlmostEqual(grid.sigma_m[i, j], found[0].sigma_height_m, 9)

    def test_a_capsule_is_as_far_from_everything_as_the_cpp_query_says(self):
        num_near = 0
        space = terrace.OccupiedSpace(terrace.octree_v1_t.decode(OCTREE.read_bytes()), self.query)
        self.assertGreater(len(space.low), 100)
        for number, told in enumerate(EXPECTED["clearances"]):
            found = self.query.capsule_clearance(told["a"], told["b"], 0.04, space=None if number % 2 else space)
            self.assertAlmostEqual(found.distance_m, told["distance"], 6)
            self.assertEqual(found.region_id, told["region"])
            np.testing.assert_allclose(found.gradient, told["gradient"], atol=1e-4)
            self.assertEqual(found.occupancy, ("free", "occupied", "unknown")[told["occupancy"]])
            num_near += found.distance_m <= 0.0
        self.assertGreater(num_near, 10)
        self.assertEqual({told["occupancy"] for told in EXPECTED["clearances"][::2]}, {0, 1, 2})
        self.assertEqual({told["occupancy"] for told in EXPECTED["clearances"][1::2]}, {1, 2})
        self.assertTrue(any(told["region"] == 0 for told in EXPECTED["clearances"][::2]))

    def test_an_octree_that_was_cut_or_is_of_another_map_is_refused(self):
        octree = terrace.octree_v1_t.decode(OCTREE.read_bytes())
        whole = bytes(octree.data)
        for size in range(0, len(whole), 7):
            octree.data = whole[:size]
            with self.assertRaises(ValueError):
                terrace.OccupiedSpace(octree, self.query)
        octree.data, octree.map_id = whole, octree.map_id + 1
        with self.assertRaisesRegex(ValueError, "another map"):
            terrace.OccupiedSpace(octree, self.query)

    def test_the_next_map_shares_what_has_not_changed(self):
        again = terrace.TerrainQuery(self.terrain, before=self.query)
        self.assertTrue(all(again._shapes[i] is shape for i, shape in self.query._shapes.items()))


class FileTest(unittest.TestCase):
    FILE = pathlib.Path(str(LOG) + ".terrace")

    def test_a_saved_map_is_the_map_and_is_answered_from_alike(self):
        followed_map, loaded = followed(MESSAGES).map, terrace.load_terrace(self.FILE)
        self.assertEqual((loaded.seq, loaded.map_id, loaded.t_capture_ns),
                         (followed_map.seq, followed_map.map_id, followed_map.t_capture_ns))
        self.assertEqual(sorted(loaded.regions), sorted(followed_map.regions))
        for number, region in followed_map.regions.items():
            mine = loaded.regions[number]
            self.assertEqual((mine.label, mine.source, mine.revision), (region.label, region.source, region.revision))
            self.assertEqual([e.kind for e in mine.edges], [e.kind for e in region.edges])
            np.testing.assert_allclose(np.concatenate(mine.rings), np.concatenate(region.rings), atol=1e-5)
        query = terrace.TerrainQuery(loaded)
        for told in EXPECTED["supports"][:50]:
            found = query.supports_at(*told["xy"])
            self.assertEqual([s.region_id for s in found], [s["region"] for s in told["found"]])
            for mine, theirs in zip(found, told["found"]):
                self.assertAlmostEqual(mine.sigma_height_m, theirs["sigma"], 6)

    def test_a_damaged_file_is_refused_with_place_and_reason(self):
        data = self.FILE.read_bytes()
        damaged = pathlib.Path(_folder.name, "damaged.terrace")
        for at in range(0, len(data), max(1, len(data) // 40)):
            damaged.write_bytes(data[:at])
            with self.assertRaisesRegex(ValueError, "byte"):
                terrace.load_terrace(damaged)
            damaged.write_bytes(data[:at] + bytes([data[at] ^ 4]) + data[at + 1:])
            with self.assertRaisesRegex(ValueError, "damaged.terrace: byte"):
                terrace.load_terrace(damaged)


class RequestsTest(unittest.TestCase):
    """A daemon that answers at once, in place of the bus."""

    class Daemon:
        def __init__(self, answer):
            self.answer, self.handlers, self.due = answer, {}, []

        def subscribe(self, channel, handler):
            self.handlers[channel] = handler

        def publish(self, channel, message):
            self.due = self.answer(terrace.terrain_request_v1_t.decode(message.encode()))

        def handle(self, timeout_s):
            for channel, message in self.due:
                self.handlers[channel](channel, message if isinstance(message, bytes) else message.encode())
            self.due = []

    @staticmethod
    def reply(request, result, text):
        reply = terrace.command_reply_v1_t()
        reply.request_id, reply.result, reply.message = request.request_id, result, text
        return ("TERRACE_REPLY", reply)

    def test_what_was_asked_for_is_returned(self):
        def answer(request):
            grid = terrace.height_map_v1_t()
            grid.resolution = request.resolution
            return [self.reply(request, terrace.command_reply_v1_t.OK, ""), ("TERRACE_HEIGHT_MAP", grid)]
        grid = terrace.Requests(self.Daemon(answer)).heights((-1, -1, -1), (1, 1, 1), 0.25)
        self.assertEqual(grid.resolution, 0.25)

    def test_a_box_of_the_map_is_a_terrain(self):
        snapshot = [("TERRACE_MAP_BOX", data) for data in MESSAGES
                    if terrace.terrain_v1_t.decode(data).kind == terrace.terrain_v1_t.SNAPSHOT]
        terrain = terrace.Requests(self.Daemon(lambda request: snapshot)).box((-9, -9, -9), (9, 9, 9))
        self.assertEqual(len(terrain.regions), 40)

    def test_a_refusal_says_why_and_silence_ends(self):
        refuse = self.Daemon(lambda request: [self.reply(request, terrace.command_reply_v1_t.REFUSED, "too large")])
        with self.assertRaisesRegex(terrace.RequestRefused, "too large"):
            terrace.Requests(refuse).octree((-99,) * 3, (99,) * 3)
        with self.assertRaises(TimeoutError):
            terrace.Requests(self.Daemon(lambda request: [])).disparity(timeout_s=0.05)


class PacketTest(unittest.TestCase):
    """The packets by themselves; no network is needed."""

    def exchanged(self, size):
        """What a bus makes of its own packets in the wrong order."""
        bus = terrace.Bus.__new__(terrace.Bus)
        packets = []
        bus._sender = type("Sender", (), {"sendto": lambda self, packet, address: packets.append(packet)})()
        bus._address, bus._sequence, bus._partial, bus._partial_bytes = None, 5, {}, 0
        data = os.urandom(size)
        bus.publish("CHANNEL", data)
        whole = [bus._message_of(packet, "somebody") for packet in reversed(packets)]
        self.assertEqual([w for w in whole if w is not None], [("CHANNEL", data)])
        self.assertLessEqual(max(map(len, packets)), 65507)
        self.assertEqual(bus._partial_bytes, 0)
        return len(packets)

    def test_small_messages_are_one_packet_and_large_ones_fragments_in_any_order(self):
        self.assertEqual(self.exchanged(10), 1)
        self.assertEqual(self.exchanged(65499 - 8), 1)
        self.assertEqual(self.exchanged(65499 - 7), 2)
        self.assertEqual(self.exchanged(300_000), 5)

    def test_an_url_that_is_none_is_refused(self):
        with self.assertRaisesRegex(ValueError, "tcp"):
            terrace.Bus("tcp://somewhere:1")


class LogTest(unittest.TestCase):
    def test_a_log_that_ends_early_ends_with_its_last_whole_event(self):
        cut = pathlib.Path(_folder.name, "cut.lcmlog")
        cut.write_bytes(LOG.read_bytes()[:-5])
        self.assertEqual([e.data for e in terrace.read_log(cut)], MESSAGES[:-1])

    def test_what_is_no_log_is_refused_with_the_place(self):
        other = pathlib.Path(_folder.name, "other")
        other.write_bytes(b"x" * 100)
        with self.assertRaisesRegex(ValueError, "byte 0"):
            list(terrace.read_log(other))


class HelpTest(unittest.TestCase):
    def test_everything_public_says_what_it_is(self):
        for name in ("Bus", "TerrainClient", "TerrainFollower", "TerrainQuery", "Terrain", "Region", "Support", "read_log",
                     "load_result", "load_terrace", "Requests", "Clearance"):
            self.assertGreater(len(getattr(terrace, name).__doc__), 20, name)
        for method in ("support_at", "supports_at", "nearest_foothold", "heights", "capsule_clearance"):
            self.assertTrue(getattr(terrace.TerrainQuery, method).__doc__)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
