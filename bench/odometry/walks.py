#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Renders walks through the scenes of a list, one for each seed, and runs the odometry alone over each:

    bench/odometry/walks.py --seeds 20 --frames 60 --rate 10 --keep out/walks

Prints a line a walk and at the end, for each scene and for all together, how many walks there were, frames lost and
bridged, the largest error between two frames [mm], mean relative error [%] and NEES (6: the covariance is right).
With `--camera "{width: 1280, height: 720, fx: 750}"`, a `camera` section of a scene, through another one than the scene's.
Seeds are the outer loop, so that --minutes cuts all scenes alike. Walks that lie in --keep already are not rendered
again. The exit code is 1 when a frame was lost or a step between two frames is more than 20 mm wrong.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
FIGURES = re.compile(
    r"tracked (?P<tracked>\d+)/(?P<frames>\d+) bridging (?P<bridging>\d+) lost (?P<lost>\d+) \| ATE (?P<ate>\S+) mm "
    r"end \S+ jump (?P<jump>\S+) \|.* mean (?P<relative>\S+)% \| NEES (?P<nees>\S+) ")
MAX_JUMP_MM = 20.0


def scenes_of(path):
    """Names of the scenes in a list for `terrace evaluate --all`, without those of single frames."""
    scenes = []
    with open(path) as lines:
        for line in lines:
            match = re.match(r"[^#\s]+\s+scene:([a-z_]+)", line)
            if match and match.group(1) != "sheets":
                scenes.append(match.group(1))
    return scenes


def with_camera(scene, camera, folder):
    """Writes the scene with that camera into the folder; returns the file."""
    with open(os.path.join(ROOT, "datasets/scenes", scene + ".yaml")) as file:
        text = file.read()
    if re.search(r"^camera:", text, re.MULTILINE):
        sys.exit(f"scene {scene} has a camera of its own")
    path = os.path.join(folder, scene + ".yaml")
    with open(path, "w") as file:
        file.write(f"{text}\ncamera: {camera}\n")
    return path


def render(options, scene, motion, seed, folder):
    command = [os.path.join(options.build, "tools/terrace"), "synthesize", scene, folder, "--seed", str(seed),
               "--frames", str(options.frames), "--rate", str(options.rate), "--truth-every", "0",
               "--threads", str(options.threads), "--overwrite"]
    if motion != "walk":
        command += ["--motion", motion]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def run(options, folder):
    """Figures of one walk, as numbers by name."""
    command = [os.path.join(options.build, "bench/odometry/terrace_odometry_run"), folder]
    if not options.imu:
        command += ["--no-imu", "--no-priors"]
    text = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    match = FIGURES.search(text)
    if not match:
        sys.exit("cannot read: " + text)
    return {name: float(value) for name, value in match.groupdict().items()}


def summary(title, walks):
    def total(name):
        return int(sum(walk[name] for walk in walks))

    def mean(name):
        return sum(walk[name] for walk in walks) / len(walks)

    print(f"{title:24} walks {len(walks):3} frames {total('frames'):5} lost {total('lost')} bridging "
          f"{total('bridging')} | jump {max(walk['jump'] for walk in walks):.1f} mm | relative mean "
          f"{mean('relative'):.3f} % max {max(walk['relative'] for walk in walks):.3f} % | ATE max "
          f"{max(walk['ate'] for walk in walks):.2f} mm | NEES mean {mean('nees'):.1f} max "
          f"{max(walk['nees'] for walk in walks):.1f}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--list", default=os.path.join(ROOT, "evaluation/baseline/full.list"))
    parser.add_argument("--build", default=os.path.join(ROOT, "build/release"))
    parser.add_argument("--seeds", type=int, default=20, help="how many")
    parser.add_argument("--first-seed", type=int, default=1)
    parser.add_argument("--frames", type=int, default=60)
    parser.add_argument("--rate", type=float, default=10.0, help="stereo frames a second")
    parser.add_argument("--camera", help="instead of the scene's: its section, as YAML in one line")
    parser.add_argument("--motions", default="walk", help="by commas: each seed takes the next one")
    parser.add_argument("--threads", type=int, default=1, help="that render")
    parser.add_argument("--minutes", type=float, default=1e9, help="no new walk is rendered after this")
    parser.add_argument("--imu", action="store_true", help="with IMU and priors, not stereo only")
    parser.add_argument("--keep", help="folder that keeps what was rendered")
    options = parser.parse_args()

    begin = time.monotonic()
    motions = options.motions.split(",")
    walks = {}
    with tempfile.TemporaryDirectory() as temporary:
        for seed in range(options.first_seed, options.first_seed + options.seeds):
            motion = motions[(seed - 1) % len(motions)]
            for scene in scenes_of(options.list):
                name = f"{scene}_{motion}_{seed}_{options.frames}_{options.rate:g}"
                if options.camera:
                    name += "_" + re.sub(r"[^a-z0-9.]+", "_", options.camera).strip("_")
                folder = os.path.join(options.keep or temporary, name)
                if not os.path.exists(os.path.join(folder, "ground_truth.json")):
                    if time.monotonic() - begin > 60.0 * options.minutes:
                        continue
                    place = with_camera(scene, options.camera, temporary) if options.camera else scene
                    render(options, place, motion, seed, folder)
                figures = run(options, folder)
                walks.setdefault(scene, []).append(figures)
                summary(name, [figures])
                if not options.keep:
                    shutil.rmtree(folder)
    if not walks:
        sys.exit("no walk was rendered")
    print()
    for scene, figures in walks.items():
        summary(scene, figures)
    everything = [figures for of_scene in walks.values() for figures in of_scene]
    summary("all", everything)
    bad = any(figures["lost"] > 0 or figures["jump"] > MAX_JUMP_MM for figures in everything)
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
