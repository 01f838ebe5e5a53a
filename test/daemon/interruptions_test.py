#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A live terraced that is interrupted: black images, a stopped process, a silent camera, a player that begins again, PAUSE.

The recording corridor_stairs is played into it over LCM. While the poses say tracking, without a reason, they are within
three of their own sigmas in 99 % of the frames and within six in all, in every world; two seconds of good images after the
interruption it tracks again. Runs in a network namespace of its own. Skips (exit code 77) where that cannot be had, or
without TERRACE_DATA.
"""
import importlib.machinery
import importlib.util
import json
import math
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from own_network import enter_namespace, skip, url  # noqa: E402

URL = url()
ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BACK_WITHIN_S = 2.0
NUM_FRAMES = 135  # nine seconds


def load_judge():
    """scripts/faults, for how it compares poses."""
    loader = importlib.machinery.SourceFileLoader("faults", str(ROOT / "scripts" / "faults"))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("faults", loader))
    loader.exec_module(module)
    return module


class Run:
    """A live daemon and the recording that is played into it."""

    def __init__(self, terrace, terraced, events, output):
        self.terrace, self.events, self.output = terrace, events, output
        self.t_begin_us = next(event.utime for event in events if event.channel == "TERRACE_IMAGES")
        self.log = open(f"{output}.log", "w+", errors="replace")
        self.process = subprocess.Popen([terraced, "--set", f"lcm.url={URL}", "--output", output], stderr=self.log)
        self.bus = terrace.Bus(URL)
        self.num_poses = 0
        self.bus.subscribe("TERRACE_POSE_STATE", lambda _, data: setattr(self, "num_poses", self.num_poses + 1))
        while "live on" not in self.text():
            assert self.process.poll() is None, self.text()
            time.sleep(0.05)

    def text(self):
        self.log.seek(0)
        return self.log.read()

    def play(self, from_s, to_s, change=lambda channel, data: data):
        """In real time; what `change` makes nothing of is left out."""
        start = time.monotonic()
        for event in self.events:
            media_s = 1e-6 * (event.utime - self.t_begin_us)
            if not from_s <= max(media_s, 0.0) < to_s:
                continue
            while (left_s := media_s - from_s - (time.monotonic() - start)) > 0:
                self.bus.handle(min(left_s, 0.05))
            data = change(event.channel, event.data)
            if data is not None:
                self.bus.publish(event.channel, data)

    def command(self, name):
        command = self.terrace.command_v1_t()
        command.command = getattr(command, name)
        self.bus.publish("TERRACE_COMMAND", command)

    def end(self):
        time.sleep(1.0)
        self.process.send_signal(signal.SIGTERM)
        code = self.process.wait(60)
        self.bus.close()
        assert code == 0, self.text()


def black(terrace, channel, data):
    if channel != "TERRACE_IMAGES":
        return data
    pair = terrace.images_t.decode(data)
    grey = 1497715271  # GREY, four characters
    for image in pair.images:
        image.width, image.height, image.row_stride, image.pixelformat = 640, 480, 640, grey
        image.data, image.size = bytes(640 * 480), 640 * 480  # the metadata hold the exact time
    return pair.encode()


def black_images(run):
    run.play(0, 3)
    run.play(3, 5, lambda channel, data: black(run.terrace, channel, data))
    run.play(5, 8)


def stopped_process(run):
    run.play(0, 2)
    run.process.send_signal(signal.SIGSTOP)
    run.play(2, 7)
    run.process.send_signal(signal.SIGCONT)
    run.play(7, 9)


def silent_camera(run):
    run.play(0, 2)
    run.play(2, 6, lambda channel, data: None if channel == "TERRACE_IMAGES" else data)
    run.play(6, 8)


def player_again(run):
    run.play(0, 4)
    run.play(0, 4)


def pause(run):
    run.play(0, 2)
    run.command("PAUSE")
    before = run.num_poses
    run.play(2, 4)
    assert run.num_poses - before > 20, "poses go on while the map is paused"
    run.command("RESUME")
    run.play(4, 6)


def judge(faults, run, truth, good_s):
    """The frames in the order in which they came; a player that begins again gives the same times again."""
    frames = [json.loads(line) for line in open(f"{run.output}/frames.jsonl")]
    lines = iter([line for line in open(f"{run.output}/trajectory.tum") if line.strip() and not line.startswith("#")])
    firsts, ratios, back_s = {}, [], None
    for frame in frames:
        t = frame["t_capture_ns"]
        if frame["status"] == "lost":
            continue
        values = [float(word) for word in next(lines).split()[1:8]]
        pose = (faults.rotation(values[3:7]), values[:3])
        first = firsts.setdefault(frame["epoch"], (pose, truth[t]))
        if frame["status"] != "tracking" or frame["reason"]:
            continue
        media_s = 1e-9 * t - 1e-6 * run.t_begin_us
        if good_s is not None and back_s is None and media_s >= good_s:
            back_s = media_s - good_s
        if first[0] is pose:
            continue
        error = faults.error_between(faults.relative(first[0], pose), faults.relative(first[1], truth[t]))
        floors = [2e-6] * 3 + [2e-5] * 3  # of what is written with so many decimals
        sigmas = [max(math.sqrt(frame["covariance"][7 * i]), floors[i]) for i in range(6)]
        ratios.append(max(abs(e) / s for e, s in zip(error, sigmas)))
    within = sum(ratio <= 3 for ratio in ratios) / len(ratios)
    worlds = 1 + max(frame["epoch"] for frame in frames)
    assert within >= 0.99 and max(ratios) <= 6, (within, max(ratios), run.text())
    assert good_s is None or (back_s is not None and back_s <= BACK_WITHIN_S), (back_s, run.text())
    return f"{len(ratios)} poses, {100 * within:.0f} % within 3 sigmas, most {max(ratios):.1f}, {worlds} worlds" + (
        "" if back_s is None else f", tracking again after {back_s:.2f} s of good images")


def main():
    if "TERRACE_DATA" not in os.environ:
        skip("TERRACE_DATA is not set")
    enter_namespace()
    terraced, program, python_dir = sys.argv[1:4]
    sys.path.insert(0, python_dir)
    import terrace

    faults = load_judge()
    with tempfile.TemporaryDirectory(prefix="terrace_interruptions_test.") as folder:
        walk, log = f"{folder}/walk", f"{folder}/walk.lcmlog"
        subprocess.run([program, "synthesize", f"{os.environ['TERRACE_DATA']}/corridor_stairs", walk, "--fault",
                        "columns_off:0", "--frames", str(NUM_FRAMES)], check=True, capture_output=True)
        subprocess.run([program, "convert", walk, log], check=True, capture_output=True)
        truth = faults.poses_of(f"{walk}/groundtruth_tum.txt")
        events = [event for event in terrace.read_log(log) if event.channel != "TERRACE_TRUE_POSE"]
        for interrupt, good_s in ((black_images, 5), (stopped_process, 7), (silent_camera, 6), (player_again, None),
                                  (pause, 4)):
            run = Run(terrace, terraced, events, f"{folder}/{interrupt.__name__}")
            try:
                interrupt(run)
                run.end()
            finally:
                run.process.kill()
                run.process.wait()
            print(f"{interrupt.__name__}: {judge(faults, run, truth, good_s)}")


main()
