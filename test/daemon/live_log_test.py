#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A log played by the stock lcm-logplayer into a live terraced gives byte for byte the map of its replay.

Runs in a network namespace of its own, so that no other LCM program hears or disturbs it. Skips (exit code 77) with the
reason where that cannot be had, or where the machine is too busy to keep up.
"""
import glob
import json
import os
import pathlib
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from own_network import GROUP, PORT, enter_namespace, skip, url  # noqa: E402

URL = url()
NUM_FRAMES = 12
# Files that hold nothing of the time of day or of speed.
SAME_FILES = ("terrain_map.json", "trajectory.tum", "camera.json", "staircases.jsonl")


class Daemon:
    """A live terraced; stop() ends it as a service manager would."""

    def __init__(self, terraced, output):
        self.log = open(f"{output}.log", "w+")
        self.process = subprocess.Popen([terraced, "--output", output, "--set", f"lcm.url={URL}"], stderr=self.log)
        self.wait_for("live on")

    def text(self):
        self.log.seek(0)
        return self.log.read()

    def wait_for(self, words):
        for _ in range(600):
            if words in self.text():
                return
            assert self.process.poll() is None, self.text()
            time.sleep(0.1)
        raise AssertionError(f"the daemon never said '{words}': {self.text()}")

    def stop(self):
        self.process.send_signal(signal.SIGTERM)
        assert self.process.wait(60) == 0, self.text()


class Bus:
    """Commands and replies over LCM's own packets: magic, number, channel, zero, message."""

    MAGIC = 0x4C433032

    def __init__(self):
        from terrace import command_reply_v1_t, command_v1_t

        self.command_type, self.reply_type = command_v1_t, command_reply_v1_t
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
        self.socket.bind((GROUP, PORT))
        membership = socket.inet_aton(GROUP) + socket.inet_aton("127.0.0.1")
        self.socket.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, membership)
        self.socket.settimeout(10)
        self.number = 1000

    def command(self, name, argument=""):
        """(result, message) of the daemon's reply."""
        self.number += 1
        command = self.command_type()
        command.request_id, command.argument = self.number, argument
        command.command = getattr(self.command_type, name)
        packet = struct.pack(">II", self.MAGIC, self.number) + b"TERRACE_COMMAND\0" + command.encode()
        self.socket.sendto(packet, (GROUP, PORT))
        while True:
            packet = self.socket.recv(65536)
            channel, _, data = packet[8:].partition(b"\0")
            if packet[:4] == struct.pack(">I", self.MAGIC) and channel == b"TERRACE_REPLY":
                reply = self.reply_type.decode(data)
                if reply.request_id == self.number:
                    return reply.result, reply.message


def check_commands(live):
    bus = Bus()
    ok, refused = bus.reply_type.OK, bus.reply_type.REFUSED
    assert bus.command("SAVE_MAP", "saved.json") == (ok, f"{live}/saved.json")
    for name in ("../saved.json", "", ".."):
        assert bus.command("SAVE_MAP", name)[0] == refused, name
    for name in ("SEND_SNAPSHOT", "PAUSE", "RESUME", "RESET_MAP"):
        assert bus.command(name)[0] == ok, name
    result, message = bus.command("RELOAD_CONFIG")
    assert result == refused and "restart" in message, message


def play(log, speed):
    subprocess.run(["lcm-logplayer", f"--speed={speed}", f"--lcm-url={URL}", log], check=True, capture_output=True)


def same_map(replayed, live):
    """How many frames were dropped, left unmapped or did without a lesson; where none was, the files are the same."""
    stats = json.loads(pathlib.Path(live, "stats.json").read_text())
    missing = NUM_FRAMES - stats["frames"] + stats["passed_over"] + stats["lessons_skipped"]
    if missing == 0:
        for name in SAME_FILES:
            assert pathlib.Path(replayed, name).read_bytes() == pathlib.Path(live, name).read_bytes(), name
    return missing


def main():
    enter_namespace(["lcm-logplayer"])
    terraced, terrace, tiny_log, python_dir = sys.argv[1:5]
    sys.path.insert(0, python_dir)
    folder = tempfile.mkdtemp(prefix="terrace_live_log_test.")
    try:
        log = f"{folder}/tiny.lcmlog"
        subprocess.run([tiny_log, log, str(NUM_FRAMES)], check=True)
        replayed = f"{folder}/replayed"
        subprocess.run([terraced, "replay", log, "--output", replayed], check=True, capture_output=True)
        assert json.loads(pathlib.Path(replayed, "terrain_map.json").read_text())["regions"], "the map is empty"
        foreign = glob.glob(os.path.join(os.environ.get("TERRACE_DATA", "/nonexistent"), "lcm", "*.lcmlog"))
        for speed in (1.0, 0.3, 0.1):
            live = f"{folder}/live{speed}"
            daemon = Daemon(terraced, live)
            daemon.wait_for("no calibration yet")
            listener = subprocess.Popen([terrace, "listen", "--url", URL], stdout=subprocess.PIPE, text=True)
            ready = listener.stdout.readline()
            assert ready == f"bus      listening on {URL}\n", ready
            others = [subprocess.Popen(["lcm-logplayer", "--speed=2", f"--lcm-url={URL}", other],
                                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) for other in foreign]
            play(log, speed)
            time.sleep(1.5)  # the last frame waits for an IMU that has gone silent; a status is due
            for other in others:
                other.terminate()
                other.wait()
            check_commands(live)
            daemon.stop()
            assert daemon.text().count("no calibration yet") == 1, daemon.text()
            listener.send_signal(signal.SIGINT)
            heard = listener.communicate(timeout=60)[0]
            assert listener.returncode == 0, "terrace listen must end well at Ctrl-C"
            missing = same_map(replayed, live)
            if missing == 0:
                assert pathlib.Path(live, "saved.json").read_bytes() == pathlib.Path(live, SAME_FILES[0]).read_bytes()
                for word in ("pose ", "status ", "map "):
                    assert word in heard, f"terrace listen never said '{word}': {heard}"
                print(f"the same map, played at speed {speed} beside {len(foreign)} logs of other robots")
                return
        skip(f"the machine is too busy: {missing} of {NUM_FRAMES} frames were dropped at a tenth of the speed")
    finally:
        shutil.rmtree(folder)


main()
