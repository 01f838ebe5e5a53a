#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A calibration that came over LCM and does not fit the configuration, is of another type or changes later ends no live
terraced: it says what is wrong, and takes the one that fits. One that was configured ends it with exit code 2.

Runs in a network namespace of its own. Skips (exit code 77) with the reason where that cannot be had.
"""
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from own_network import enter_namespace, url  # noqa: E402

URL = url()
CHANNEL = "TERRACE_CALIBRATION"
# The right half of the tiny log's images, which are 160 px wide.
RIGHT_HALF = ["--set", "stereo.roi_left_px=80", "--set", "stereo.roi_width_px=80"]


def smaller(calibration, kind):
    """The same rig with half the pixels."""
    half = kind.decode(calibration.encode())
    half.width, half.height, half.name, half.content_hash = 80, 60, "half", "another"
    half.K = [[0.5 * K[0], 0, 0.5 * (K[2] - 0.5), 0, 0.5 * K[4], 0.5 * (K[5] - 0.5), 0, 0, 1] for K in half.K]
    return half


class Listener:
    def __init__(self, terrace):
        self.bus = terrace.Bus(URL)
        self.status = None
        self.bus.subscribe("TERRACE_STATUS", lambda _, data: setattr(self, "status", terrace.status_v1_t.decode(data)))

    def wait_for(self, words, send=None, map_seq=0):
        """Until a status has these words in its reason and its map has come so far; what is sent is sent again and again."""
        end = time.monotonic() + 30.0
        while time.monotonic() < end:
            if send is not None:
                self.bus.publish(CHANNEL, send)
            wait_until = time.monotonic() + 0.3
            while time.monotonic() < wait_until:
                self.bus.handle(0.1)
            if self.status is not None and words in self.status.reason and self.status.map_seq >= map_seq:
                return
        raise AssertionError(f"never said '{words}', but '{self.status and self.status.reason}'")


def check_live(terraced, terrace, log, calibration):
    listener = Listener(terrace)
    daemon = subprocess.Popen([terraced, "--set", f"lcm.url={URL}", *RIGHT_HALF], stderr=subprocess.PIPE, text=True)
    try:
        listener.wait_for("no calibration yet")
        listener.wait_for("another type than calibration_v1_t", send=terrace.command_v1_t())
        half = smaller(calibration, terrace.calibration_v1_t)
        listener.wait_for("stereo.roi_left_px = 80, stereo.roi_width_px = 80 reach out of the rectified image", send=half)
        assert listener.status.state == listener.status.NO_CALIBRATION, listener.status.state
        player = subprocess.Popen(["lcm-logplayer", "--speed=0.2", f"--lcm-url={URL}", log], stdout=subprocess.DEVNULL,
                                  stderr=subprocess.DEVNULL)
        listener.wait_for("has changed", send=half, map_seq=1)
        player.wait()
        listener.wait_for("no images", send=calibration)
    finally:
        daemon.send_signal(signal.SIGTERM)
        said = daemon.communicate(timeout=60)[1]
    assert daemon.returncode == 0, said
    assert said.count("the calibration cannot be used") == 1, said
    assert said.count("has changed") == 1, said


def check_configured(terraced, folder):
    lens = "{model: radial-tangential, fx: 55, fy: 55, cx: 39.5, cy: 29.5, distortion: [0, 0, 0, 0]}"
    rig = pathlib.Path(folder, "rig.yaml")
    rig.write_text(f"format: terrace-rig\nversion: 1\nimage_size: [80, 60]\nleft: {lens}\nright: {lens}\n"
                   "T_right_left: [1, 0, 0, -0.12, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n")
    done = subprocess.run([terraced, "--set", f"lcm.url={URL}", "--set", f"lcm.calibration={rig}", *RIGHT_HALF],
                          capture_output=True, text=True, timeout=60)
    assert done.returncode == 2 and "stereo.roi_left_px = 80" in done.stderr, (done.returncode, done.stderr)


def main():
    enter_namespace(["lcm-logplayer"])
    terraced, tiny_log, python_dir = sys.argv[1:4]
    sys.path.insert(0, python_dir)
    import terrace

    with tempfile.TemporaryDirectory(prefix="terrace_calibration_test.") as folder:
        log = f"{folder}/tiny.lcmlog"
        subprocess.run([tiny_log, log, "12"], check=True)
        calibration = next(terrace.calibration_v1_t.decode(event.data) for event in terrace.read_log(log)
                           if event.channel == CHANNEL)
        check_live(terraced, terrace, log, calibration)
        check_configured(terraced, folder)
    print("what does not fit was refused, and what fits was taken")


main()
