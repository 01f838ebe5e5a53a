#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A live terraced saves its map; another one, whose world begins elsewhere, loads it, recognises the place and says where
the map lies.

The recording corridor_stairs is played into both over LCM, the second time from where the body is further on, each pair
when the map has taken the one before. What the second one says is compared with where the first one had the body at the
same images. Runs in a network namespace of its own. Skips (exit
code 77) where that cannot be had, or without TERRACE_DATA.
"""
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
SAVED_UNTIL_S, SECOND_BEGINS_S, LOADED_AFTER_S, PATIENCE_S = 3.0, 1.7, 0.3, 30.0
OFF_M, OFF_RAD = 0.03, 0.01  # the two runs' own errors, and that of the recognition


def rotated(q, v):
    w, u = q[0], q[1:]
    t = [2 * c for c in cross(u, v)]
    return [a + w * b + c for a, b, c in zip(v, t, cross(u, t))]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def moved(transform, p):
    return [a + b for a, b in zip(rotated(transform.quat, p), transform.pos)]


class Daemon:
    """A live terraced with what it has said."""

    def __init__(self, terrace, program, events, folder):
        self.terrace, self.events = terrace, events
        self.bus = terrace.Bus(URL)
        self.poses, self.transform, self.replies, self.mapped_ns = {}, None, [], 0
        self.bus.subscribe("TERRACE_POSE_STATE", lambda _, data: self.add_pose(terrace.pose_v1_t.decode(data)))
        self.bus.subscribe("TERRACE_MAP_TRANSFORM",
                           lambda _, data: setattr(self, "transform", terrace.map_transform_v1_t.decode(data)))
        self.bus.subscribe("TERRACE_TERRAIN",
                           lambda _, data: setattr(self, "mapped_ns", terrace.terrain_v1_t.decode(data).t_capture_ns))
        self.bus.subscribe("TERRACE_REPLY",
                           lambda _, data: self.replies.append(terrace.command_reply_v1_t.decode(data)))
        self.log = open(f"{folder}/log", "w+", errors="replace")
        self.process = subprocess.Popen([program, "--set", f"lcm.url={URL}", "--set", f"lcm.save_folder={folder}"],
                                        stderr=self.log)
        self.wait_for(lambda: "live on" in self.text())

    def text(self):
        self.log.seek(0)
        return self.log.read()

    def add_pose(self, pose):
        if pose.status == pose.TRACKING:
            self.poses[pose.t_capture_ns] = pose

    def wait_for(self, condition):
        end = time.monotonic() + PATIENCE_S
        while not condition():
            assert self.process.poll() is None and time.monotonic() < end, self.text()
            self.bus.handle(0.02)

    def play(self, from_s, to_s, enough=lambda: False):
        images_utime = 0
        for event in self.events:
            media_s = 1e-6 * (event.utime - self.events[0].utime)
            if event.channel != "TERRACE_CALIBRATION" and not from_s <= media_s < to_s:
                continue
            if event.channel == "TERRACE_IMAGES":
                self.wait_for_the_map(images_utime)
                images_utime = event.utime
            if enough():
                return
            self.bus.publish(event.channel, event.data)
        self.wait_for_the_map(images_utime)

    def wait_for_the_map(self, utime):
        """The first images make none, and what changes nothing is told twice a second."""
        end = time.monotonic() + 2.0
        while self.mapped_ns // 1000 < utime and time.monotonic() < end:
            self.bus.handle(0.02)

    def command(self, name, argument):
        command = self.terrace.command_v1_t()
        command.command, command.argument, command.request_id = getattr(command, name), argument, 7
        self.bus.publish("TERRACE_COMMAND", command)
        self.wait_for(lambda: self.replies)
        reply = self.replies.pop()
        assert reply.request_id == 7 and reply.result == reply.OK, reply.message

    def end(self):
        self.process.send_signal(signal.SIGTERM)
        code = self.process.wait(60)
        self.bus.close()
        assert code == 0, self.text()


def save(first):
    first.play(0.0, SAVED_UNTIL_S)
    first.command("SAVE_MAP", "place.terrace")
    first.end()


def recognise(second):
    second.play(SECOND_BEGINS_S, SECOND_BEGINS_S + LOADED_AFTER_S)
    second.wait_for(lambda: second.poses)
    second.command("LOAD_MAP", "place.terrace")
    placed = lambda: second.transform is not None and second.transform.placing != second.transform.NOT_FOUND  # noqa: E731
    second.play(SECOND_BEGINS_S + LOADED_AFTER_S, 60.0, placed)
    assert placed(), second.transform.reason if second.transform else second.text()
    assert second.transform.placing in (second.transform.RECOGNISED, second.transform.CONFIRMED)
    assert second.transform.map_id != 0 and second.transform.file.endswith("place.terrace")
    second.end()


def judge(first, second):
    """How far apart both have the body, and its x axis, at the same images, in the saved map's frame."""
    common = sorted(set(first.poses) & set(second.poses))
    assert len(common) > 5, (len(first.poses), len(second.poses))
    worst_m = worst_rad = 0.0
    for t in common:
        a, b = first.poses[t], second.poses[t]
        ahead = rotated(second.transform.quat, rotated(b.quat, [1.0, 0.0, 0.0]))
        worst_m = max(worst_m, sum((x - y) ** 2 for x, y in zip(a.pos, moved(second.transform, b.pos))) ** 0.5)
        worst_rad = max(worst_rad, sum((x - y) ** 2 for x, y in zip(rotated(a.quat, [1.0, 0.0, 0.0]), ahead)) ** 0.5)
    apart_m = sum(x * x for x in second.transform.pos) ** 0.5
    assert apart_m > 4 * OFF_M, "the second world was to begin elsewhere"
    assert worst_m < OFF_M and worst_rad < OFF_RAD, (worst_m, worst_rad)
    print(f"worlds {apart_m:.2f} m apart; recognised to {1e3 * worst_m:.1f} mm, {1e3 * worst_rad:.1f} mrad")


def main():
    if "TERRACE_DATA" not in os.environ:
        skip("TERRACE_DATA is not set")
    enter_namespace()
    terraced, program, python_dir = sys.argv[1:4]
    sys.path.insert(0, python_dir)
    import terrace

    with tempfile.TemporaryDirectory(prefix="terrace_recognition_test.") as folder:
        walk, log = f"{folder}/walk", f"{folder}/walk.lcmlog"
        subprocess.run([program, "synthesize", f"{os.environ['TERRACE_DATA']}/corridor_stairs", walk, "--fault",
                        "columns_off:0", "--frames", "60"], check=True, capture_output=True)
        subprocess.run([program, "convert", walk, log], check=True, capture_output=True)
        events = [event for event in terrace.read_log(log) if event.channel != "TERRACE_TRUE_POSE"]
        daemons = []
        try:
            for work in (save, recognise):
                daemons.append(Daemon(terrace, terraced, events, folder))
                work(daemons[-1])
        finally:
            for daemon in daemons:
                daemon.process.kill()
                daemon.process.wait()
        judge(*daemons)


main()
