#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What a live daemon does over loopback LCM in a network namespace: how late poses and terrain are at 15, 30 and 60 Hz on
two cores and on one, whether a planner behind a lossy link is in step, what standing costs against walking.

    python3 bench/daemon/live_figures.py WALK.lcmlog [STAND.lcmlog] [--build build/release] [--only NAME]

Logs are what `terrace convert SEQUENCE LOG` writes (--encoding raw). The daemon has its cores to itself as far as other
programs leave them: how late the player itself was (99 %) says how far the latencies can be believed. The last line is one JSON object.
"""
import argparse
import json
import os
import pathlib
import signal
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent.parent / "test"))
from own_network import enter_namespace, url  # noqa: E402

RECORDED_HZ = 15.0


def run(arguments, log, cores, rate_hz, loss=0.0, seed=101):
    """The figures of one daemon on these cores (as taskset takes them) that is played a log at this rate."""
    build = arguments.build
    daemon = subprocess.Popen(["taskset", "-c", cores, f"{build}/daemon/terraced", "--set", f"lcm.url={url()}",
                               "--threads", str(len(cores.split(",")))], stderr=subprocess.PIPE, text=True)
    try:
        while "live on" not in daemon.stderr.readline():
            assert daemon.poll() is None, "the daemon has ended"
        player = [f"{build}/bench/daemon/terrace_live_figures", log, str(rate_hz / RECORDED_HZ), str(loss), str(seed),
                  str(daemon.pid)]
        done = subprocess.run(player, capture_output=True, text=True, check=True)
        figures = json.loads(done.stdout.splitlines()[-1])
    finally:
        daemon.send_signal(signal.SIGTERM)
        daemon.communicate()
    figures["load"] = os.getloadavg()[0]
    return figures


def say(name, figures):
    print(f"{name:12} poses {100 * figures['pose_share']:5.1f} % of {figures['frames']}, {figures['pose_p50_ms']:5.1f} and "
          f"{figures['pose_p99_ms']:5.1f} ms; terrain {figures['terrain_p50_ms']:5.1f} and {figures['terrain_p99_ms']:5.1f} ms "
          f"of {figures['terrain_frames']}; in step {100 * figures['in_step']:5.2f} %, {figures['caught_up_s']:.2f} s after; "
          f"{figures['cpu_cores']:.2f} cores; {figures['terrain_bytes_per_s_after_5_s']:.0f} B/s, "
          f"{figures['new_ids_after_5_s']} new ids after 5 s; player late by {figures['player_late_p99_ms']:.1f} ms, load {figures['load']:.1f}", flush=True)


def main():
    enter_namespace(["taskset"])
    parser = argparse.ArgumentParser()
    parser.add_argument("walk")
    parser.add_argument("stand", nargs="?")
    parser.add_argument("--build", default="build/release")
    parser.add_argument("--only", action="append", help="one of the runs, may be repeated")
    arguments = parser.parse_args()
    runs = {"30_hz": (arguments.walk, "0,1", 30.0, 0.0), "60_hz": (arguments.walk, "0,1", 60.0, 0.0),
            "30_hz_1_core": (arguments.walk, "0", 30.0, 0.0), "15_hz": (arguments.walk, "0,1", 15.0, 0.0),
            "loss_1": (arguments.walk, "0,1", 15.0, 0.01), "loss_10": (arguments.walk, "0,1", 15.0, 0.10),
            "loss_30": (arguments.walk, "0,1", 15.0, 0.30)}
    if arguments.stand:
        runs["standing"] = (arguments.stand, "0,1", 15.0, 0.0)
    figures = {}
    for name, (log, cores, rate_hz, loss) in runs.items():
        if arguments.only and name not in arguments.only:
            continue
        figures[name] = run(arguments, log, cores, rate_hz, loss)
        say(name, figures[name])
    print(json.dumps(figures))


main()
