#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A live terraced answers requests over LCM: heights, octree, disparity image and a box of the map, and says why not.

Runs in a network namespace of its own. Skips (exit code 77) with the reason where that cannot be had. OctoMap's own
convert_octree reads the octree where it is installed.
"""
import math
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from own_network import enter_namespace, url  # noqa: E402

URL = url()
NUM_FRAMES = 40


def request(terrace, number, what, size_m=3.0):
    message = terrace.terrain_request_v1_t()
    message.request_id, message.what = number, what
    message.rate, message.duration_s = 10.0, 60.0
    message.around_robot = True
    message.box_min, message.box_max = [-size_m] * 3, [size_m] * 3
    message.resolution = 0.05
    return message


def listen(terrace, bus):
    """The newest answer on each channel, and the replies by request."""
    heard, replies = {}, {}
    for channel, kind in (("TERRACE_HEIGHT_MAP", terrace.height_map_v1_t), ("TERRACE_OCTREE", terrace.octree_v1_t),
                          ("TERRACE_DISPARITY", terrace.disparity_v1_t), ("TERRACE_MAP_BOX", terrace.terrain_v1_t),
                          ("TERRACE_STATUS", terrace.status_v1_t)):
        bus.subscribe(channel, lambda name, data, kind=kind: heard.__setitem__(name, kind.decode(data)))
    reply = terrace.command_reply_v1_t
    bus.subscribe("TERRACE_REPLY", lambda _, data: replies.__setitem__(reply.decode(data).request_id, reply.decode(data)))
    return heard, replies


def check(heard, folder):
    disparity = heard["TERRACE_DISPARITY"]
    assert len(disparity.values) == disparity.width * disparity.height == 160 * 120
    assert disparity.pose_known and abs(disparity.baseline_m - 0.12) < 1e-9
    # The wall is at most 2.5 m ahead, and the floor is nearer.
    known = sorted(value / 64.0 for value in disparity.values if value > 0)
    assert len(known) > 0.3 * len(disparity.values), len(known)
    nearest_m = disparity.fx * disparity.baseline_m / known[len(known) // 2]
    assert 0.1 < nearest_m < 3.0, nearest_m

    octree = heard["TERRACE_OCTREE"]
    assert octree.encoding == octree.OCTOMAP_OT and octree.data.startswith(b"# Octomap OcTree file"), octree.data[:80]
    assert len(octree.data) > 1000
    file = pathlib.Path(folder, "room.ot")
    file.write_bytes(octree.data)
    if shutil.which("convert_octree"):
        said = subprocess.run(["convert_octree", file, f"{folder}/room.bt"], capture_output=True, text=True, check=True)
        assert pathlib.Path(folder, "room.bt").read_bytes().startswith(b"# Octomap OcTree binary file"), said

    grid = heard["TERRACE_HEIGHT_MAP"]
    assert (grid.nx, grid.ny) == (120, 120) and list(grid.layer_names) == ["elevation", "variance", "label", "age"]
    assert len(grid.values) == 4 * 120 * 120
    elevation = grid.values[:120 * 120]
    known = [z for z in elevation if not math.isnan(z)]
    assert 0 < len(known) < len(elevation), "some ground is known, and never all of it"

    box = heard["TERRACE_MAP_BOX"]
    assert box.kind == box.SNAPSHOT
    assert grid.map_id == octree.map_id == box.map_id == heard["TERRACE_STATUS"].map_id


def main():
    enter_namespace(["lcm-logplayer"])
    terraced, tiny_log, python_dir = sys.argv[1:4]
    sys.path.insert(0, python_dir)
    import terrace

    folder = tempfile.mkdtemp(prefix="terrace_request_test.")
    daemon = subprocess.Popen([terraced, "--set", f"lcm.url={URL}"], stderr=subprocess.PIPE, text=True)
    try:
        log = f"{folder}/tiny.lcmlog"
        subprocess.run([tiny_log, log, str(NUM_FRAMES)], check=True)
        bus = terrace.Bus(URL)
        heard, replies = listen(terrace, bus)
        kinds = terrace.terrain_request_v1_t
        end = time.monotonic() + 60.0
        while "TERRACE_STATUS" not in heard and time.monotonic() < end:
            bus.handle(0.2)
        for number, what in enumerate((kinds.HEIGHT_MAP, kinds.OCTREE, kinds.DISPARITY, kinds.MAP), 1):
            bus.publish("TERRACE_REQUEST", request(terrace, number, what))
        bus.publish("TERRACE_REQUEST", request(terrace, 5, kinds.OCTREE, size_m=20.0))
        bus.publish("TERRACE_REQUEST", b"no message")
        wanted = {"TERRACE_HEIGHT_MAP", "TERRACE_OCTREE", "TERRACE_DISPARITY", "TERRACE_MAP_BOX"}
        player = subprocess.Popen(["lcm-logplayer", "--speed=0.5", f"--lcm-url={URL}", log],
                                  stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        while player.poll() is None and time.monotonic() < end:
            bus.handle(0.05)
        end = time.monotonic() + 3.0
        while time.monotonic() < end:  # the status of after the last frame
            bus.handle(0.2)
        assert wanted <= set(heard), (sorted(heard), {n: r.message for n, r in replies.items()})
        assert [replies[n].result for n in (1, 2, 3, 4)] == [0] * 4
        assert replies[5].result == 1 and "at most 16" in replies[5].message, replies[5].message
        check(heard, folder)
        print("every request was answered")
    finally:
        daemon.send_signal(signal.SIGTERM)
        said = daemon.communicate(timeout=60)[1]
        shutil.rmtree(folder)
    assert daemon.returncode == 0, said
    assert "messages on TERRACE_REQUEST are not taken" in said, said


main()
