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
import subprocess
import sys
import tempfile
import time

SKIP = 77
URL = "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2097152"
NUM_FRAMES = 12
# Files that hold nothing of the time of day or of speed.
SAME_FILES = ("terrain_map.json", "trajectory.tum", "camera.json", "staircases.jsonl")


def skip(reason):
    print(f"skipped: {reason}")
    sys.exit(SKIP)


def enter_namespace():
    """Runs this script again inside a network namespace with multicast on its loopback."""
    if os.environ.get("TERRACE_IN_NAMESPACE"):
        return
    if os.geteuid() != 0:
        skip("a network namespace needs root")
    for program in ("unshare", "ip", "lcm-logplayer"):
        if not shutil.which(program):
            skip(f"{program} is not installed")
    if subprocess.run(["unshare", "-n", "true"], capture_output=True).returncode != 0:
        skip("this system allows no network namespace")
    limit = int(pathlib.Path("/proc/sys/net/core/rmem_max").read_text())
    if limit < 2097152:
        skip(f"net.core.rmem_max = {limit} is too small for images, see daemon/config/60-terrace-lcm.conf")
    setup = ("ip link set lo up && ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo && "
             'exec env TERRACE_IN_NAMESPACE=1 python3 "$@"')
    os.execvp("unshare", ["unshare", "-n", "sh", "-c", setup, "sh", *sys.argv])


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


def play(log, speed):
    subprocess.run(["lcm-logplayer", f"--speed={speed}", f"--lcm-url={URL}", log], check=True, capture_output=True)


def same_map(replayed, live):
    """None when nothing was dropped and the files are the same; the number of missing frames when some are."""
    stats = json.loads(pathlib.Path(live, "stats.json").read_text())
    missing = NUM_FRAMES - stats["frames"]
    if missing == 0:
        for name in SAME_FILES:
            assert pathlib.Path(replayed, name).read_bytes() == pathlib.Path(live, name).read_bytes(), name
    return missing


def main():
    enter_namespace()
    terraced, terrace, tiny_log = sys.argv[1:4]
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
            listener = subprocess.Popen([terrace, "listen", "--url", URL], stdout=subprocess.PIPE, text=True)
            others = [subprocess.Popen(["lcm-logplayer", "--speed=2", f"--lcm-url={URL}", other],
                                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) for other in foreign]
            play(log, speed)
            time.sleep(1.5)  # the last frame waits for an IMU that has gone silent; a status is due
            for other in others:
                other.terminate()
                other.wait()
            daemon.stop()
            listener.send_signal(signal.SIGINT)
            heard = listener.communicate(timeout=60)[0]
            assert listener.returncode == 0, "terrace listen must end well at Ctrl-C"
            missing = same_map(replayed, live)
            if missing == 0:
                for word in ("pose ", "status ", "map "):
                    assert word in heard, f"terrace listen never said '{word}': {heard}"
                print(f"the same map, played at speed {speed} beside {len(foreign)} logs of other robots")
                return
        skip(f"the machine is too busy: {missing} of {NUM_FRAMES} frames were dropped at a tenth of the speed")
    finally:
        shutil.rmtree(folder)


main()
