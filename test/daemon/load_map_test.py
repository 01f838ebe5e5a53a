#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A live terraced takes a saved map at the start and by command, says where it lies or that it does not know, and refuses a
damaged one.

Runs in a network namespace of its own. Skips (exit code 77) with the reason where that cannot be had.
"""
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


class Commander:
    """Sends LOAD_MAP and returns the reply."""

    def __init__(self, terrace, bus):
        self._terrace, self._bus, self._replies = terrace, bus, {}
        reply = terrace.command_reply_v1_t
        bus.subscribe("TERRACE_REPLY", lambda _, data: self._replies.__setitem__(reply.decode(data).request_id,
                                                                                  reply.decode(data)))

    def load(self, argument):
        command = self._terrace.command_v1_t()
        command.command, command.argument = command.LOAD_MAP, argument
        command.request_id = 1 + len(self._replies)
        self._bus.publish("TERRACE_COMMAND", command)
        end = time.monotonic() + 20.0
        while command.request_id not in self._replies and time.monotonic() < end:
            self._bus.handle(0.05)
        return self._replies[command.request_id]


def wait_for(bus, clients, condition, seconds=40.0):
    end = time.monotonic() + seconds
    while not condition() and time.monotonic() < end:
        bus.handle(0.05)
        for client in clients:
            client.ask()
    return condition()


def check(terrace, folder, play):
    bus = terrace.Bus(URL)
    alone = terrace.TerrainClient(bus, terrain="TERRACE_LOADED_MAP")
    joint = terrace.TerrainClient(bus)
    commander = Commander(terrace, bus)
    player = play()
    try:
        saved = terrace.load_terrace(folder / "map.terrace")
        assert wait_for(bus, [alone], alone.in_step), "the loaded map does not stand by itself"
        assert sorted(alone.map.regions) == sorted(saved.regions)
        assert wait_for(bus, [], lambda: alone.map_transform is not None)
        assert alone.map_transform.placing == alone.map_transform.NOT_FOUND and alone.map_transform.reason

        cut = folder / "cut.terrace"
        cut.write_bytes((folder / "map.terrace").read_bytes()[:999])
        refused = commander.load("cut.terrace")
        assert refused.result == refused.REFUSED and "byte" in refused.message, refused.message

        placed = commander.load("map.terrace 0 0 0 0")
        assert placed.result == placed.OK, placed.message
        assert wait_for(bus, [], lambda: alone.map_transform.placing != alone.map_transform.NOT_FOUND), \
            alone.map_transform.reason
        # A place can be given before the first frame has begun a map.
        assert wait_for(bus, [joint], lambda: joint.in_step() and joint.map.map_id == alone.map_transform.map_id)
        kept = [number for number in joint.map.regions if number in saved.regions]
        assert len(kept) > len(saved.regions) // 2, (len(kept), len(saved.regions))
        assert all(number in saved.regions or number > max(saved.regions) for number in joint.map.regions)
    finally:
        player.kill()
        player.wait()


def main():
    enter_namespace(["lcm-logplayer"])
    terraced, tiny_log, example_log, python_dir = sys.argv[1:5]
    sys.path.insert(0, python_dir)
    import terrace

    folder = pathlib.Path(tempfile.mkdtemp(prefix="terrace_load_map_test."))
    subprocess.run([example_log, folder / "map"], check=True, stdout=subprocess.DEVNULL)
    subprocess.run([tiny_log, folder / "tiny.lcmlog", "120"], check=True)
    daemon = subprocess.Popen([terraced, "--load-map", folder / "map.terrace", "--set", f"lcm.url={URL}", "--set",
                               f"lcm.save_folder={folder}"], stderr=subprocess.PIPE, text=True)
    try:
        check(terrace, folder, lambda: subprocess.Popen(
            ["lcm-logplayer", "--speed=0.3", f"--lcm-url={URL}", folder / "tiny.lcmlog"],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))
        print("the map was loaded, put into the world, and refused when it was damaged")
    finally:
        daemon.send_signal(signal.SIGTERM)
        said = daemon.communicate(timeout=60)[1]
        shutil.rmtree(folder)
    assert daemon.returncode == 0, said


main()
