#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""`terrace status`, `command`, `doctor`, `record` and `camera` beside a live daemon: what they say and their exit codes."""
import glob
import json
import pathlib
import signal
import struct
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from own_network import enter_namespace, url  # noqa: E402

URL = url()
DONE, FAILED, WRONG_USE = 0, 1, 2


class Terrace:
    def __init__(self, program):
        self.program = program

    def run(self, *arguments):
        """(exit code, what was printed, what was complained)"""
        done = subprocess.run([self.program, *arguments], capture_output=True, text=True, timeout=60)
        return done.returncode, done.stdout, done.stderr


def check_without_daemon(terrace):
    code, _, complaint = terrace.run("status", "--url", URL, "--wait", "0.5")
    assert code == FAILED and "nothing on TERRACE_STATUS" in complaint, complaint
    code, _, complaint = terrace.run("command", "pause", "--url", URL, "--wait", "0.5")
    assert code == FAILED and "no reply" in complaint, complaint
    code, _, complaint = terrace.run("command", "dance", "--url", URL)
    assert code == WRONG_USE and "reset_map" in complaint, complaint
    code, _, complaint = terrace.run("status", "--set", "lcm.deadline_ms=none")
    assert code == WRONG_USE and "deadline_ms" in complaint, complaint


def check_without_input(terrace):
    code, page, _ = terrace.run("status", "--url", URL)
    assert code == FAILED and "no_calibration" in page and "terrace calibration" in page, page
    code, _, complaint = terrace.run("command", "save_map", "map.json", "--url", URL)
    assert code == FAILED and "refused: there is no map yet" in complaint, complaint
    code, _, complaint = terrace.run("command", "explain", "1", "--url", URL)
    assert code == FAILED and "refused: the map has neither a region nor a staircase 1" in complaint, complaint
    code, reply, _ = terrace.run("command", "PAUSE", "--url", URL)
    assert code == DONE and reply.startswith("paused"), reply
    code, reply, _ = terrace.run("command", "resume", "--url", URL)
    assert code == DONE and reply.startswith("resumed"), reply


def check_doctor(terrace, log):
    code, page, complaint = terrace.run("doctor", "--url", URL, "--seconds", "1.5")
    for words in ("no images are heard", "none is heard on TERRACE_CALIBRATION", "no_calibration"):
        assert words in page, page
    assert code == FAILED and "troubles" in complaint, complaint
    player = subprocess.Popen(["lcm-logplayer", "--speed=0.25", f"--lcm-url={URL}", log], stdout=subprocess.DEVNULL)
    _, page, _ = terrace.run("doctor", "--url", URL, "--seconds", "6")
    player.wait()
    for words in ("pairs a second", "IMU samples a second", "accelerometer: 9.", "rows are off by", "mean brightness",
                  "messages as large as pairs"):
        assert words in page, page


def check_drivers(terrace, example, python_dir):
    """The examples for drivers of one's own are heard."""
    own = pathlib.Path(__file__).resolve().parent.parent.parent / "tools/example/own_camera.py"
    for driver in ([example], [sys.executable, str(own)]):
        process = subprocess.Popen(driver, env={"PYTHONPATH": python_dir})
        _, page, _ = terrace.run("doctor", "--url", URL, "--seconds", "2")
        process.kill()
        process.wait()
        assert process.returncode == -signal.SIGKILL and "pairs a second" in page, page
        assert "stamps of images increase" in page and "cannot be used" not in page, page


def check_camera(terrace, folder):
    """Two devices' buffers as they were saved are played, paired and sent."""
    width, height = 64, 48
    frames, log = f"{folder}/frames.lcmlog", f"{folder}/camera.lcmlog"
    with open(frames, "wb") as file:
        for i in range(40):
            for device in (0, 1):
                pixels = bytes((u * 7 + v * 13 + 3 * device) & 0xFF for v in range(height) for u in range(width))
                # The right device misses every fourth frame.
                if device == 1 and i % 4 == 0:
                    continue
                t_ns = 1_700_000_000_000_000_000 + 33_000_000 * i + 200_000 * device
                data = struct.pack(">6q", 0, 1, width, height, i, t_ns) + pixels
                channel = b"CAMERA%d" % device
                file.write(struct.pack(">IqqII", 0xEDA1DA01, i, t_ns // 1000, len(channel), len(data)) + channel + data)
    camera = pathlib.Path(folder, "camera.yaml")
    camera.write_text("{device: /dev/video0, device_right: /dev/video1, width: 64, height: 48, format: GREY}\n")
    code, _, said = terrace.run("camera", str(camera), "--play-frames", frames, "--url", URL)
    assert code == DONE and "30 pairs, 0 of them unreadable; 10 frames without a partner, 9 lost by the driver" in said, said
    code, _, said = terrace.run("camera", str(camera), "--play-frames", frames, "--record", log, "--url", URL)
    assert code == WRONG_USE and "--record needs --calibration" in said, said
    rig = pathlib.Path(folder, "rig.yaml")
    lens = "{model: radial-tangential, fx: 50, fy: 50, cx: 31.5, cy: 23.5, distortion: [0, 0, 0, 0]}"
    rig.write_text(f"format: terrace-rig\nversion: 1\nimage_size: [64, 48]\nleft: {lens}\nright: {lens}\n"
                   "T_right_left: [1, 0, 0, -0.12, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n")
    code, _, said = terrace.run("camera", str(camera), "--play-frames", frames, "--record", log, "--calibration", str(rig),
                                "--url", URL)
    assert code == DONE, said
    code, page, said = terrace.run("info", log)
    assert code == DONE and "30 frames" in page and "64x48" in page, (page, said)
    rig.write_text(rig.read_text().replace("[64, 48]", "[128, 96]"))
    code, _, said = terrace.run("camera", str(camera), "--play-frames", frames, "--calibration", str(rig), "--url", URL)
    assert code == FAILED and "each image is 64x48, the calibration is for 128x96" in said, said
    camera.write_text("{widht: 64}\n")
    code, _, said = terrace.run("camera", str(camera), "--url", URL)
    assert code == WRONG_USE and "widht" in said and "no such key" in said, said
    # One that is not there is waited for.
    camera.write_text(f"{{device: {folder}/missing}}\n")
    waiting = subprocess.Popen([terrace.program, "camera", str(camera), "--url", URL], stderr=subprocess.PIPE, text=True)
    assert "waiting for it" in waiting.stderr.readline()
    waiting.send_signal(signal.SIGINT)
    waiting.communicate(timeout=60)
    assert waiting.returncode == DONE


def check_record(terrace, terraced, log, folder):
    """What the bus carried is kept on command, and replays."""
    records = f"{folder}/records"
    recorder = subprocess.Popen([terrace.program, "record", records, "--after", "0.5", "--url", URL],
                                stderr=subprocess.PIPE, text=True)
    assert "recording" in recorder.stderr.readline()
    subprocess.run(["lcm-logplayer", "--speed=0.25", f"--lcm-url={URL}", log], check=True, stdout=subprocess.DEVNULL)
    code, reply, complaint = terrace.run("command", "keep_record", "fell/../down", "--url", URL)
    assert code == DONE and reply.endswith("_felldown.lcmlog\n"), (reply, complaint)
    for line in recorder.stderr:
        if "kept:" in line:
            break
    recorder.send_signal(signal.SIGINT)
    recorder.communicate(timeout=60)
    assert recorder.returncode == DONE
    kept = glob.glob(f"{records}/*_felldown.lcmlog")
    assert kept == [reply.strip()], (kept, reply)
    done = subprocess.run([terraced, "replay", kept[0], "--output", f"{folder}/replayed"], capture_output=True, text=True)
    assert done.returncode == DONE, done.stderr
    stats = json.loads(pathlib.Path(folder, "replayed", "stats.json").read_text())
    assert stats["frames"] == 12 and stats["tracked"] == 12, stats


def check_with_input(terrace, log, folder):
    player = subprocess.Popen(["lcm-logplayer", "--speed=0.15", f"--lcm-url={URL}", log], stdout=subprocess.DEVNULL)
    status, rates = {}, {}
    while player.poll() is None and (status.get("map_seq", 0) == 0 or rates["images"] == 0):
        code, line, complaint = terrace.run("status", "--json", "--url", URL)
        status = json.loads(line)
        assert code == (DONE if status["healthy"] else FAILED), (line, complaint)
        rates = {given["name"]: given["rate_hz"] for given in status["inputs"]}
    player.wait()
    assert status["map_seq"] > 0, status
    assert rates["images"] > 0 and rates["imu"] > 0, rates
    code, reply, complaint = terrace.run("command", "save-map", "map.json", "--url", URL)
    assert code == DONE and reply == f"{folder}/map.json\n", (reply, complaint)
    saved = json.loads(pathlib.Path(folder, "map.json").read_text())
    assert saved["format"] == "terrace-map"
    region = saved["regions"][0]
    code, reply, complaint = terrace.run("command", "explain", str(region["id"]), "--url", URL)
    assert code == DONE and reply.startswith(f"region {region['id']}: {region['label']}"), (reply, complaint)
    # Two seconds after the last image.
    time.sleep(2.0)
    code, page, _ = terrace.run("status", "--url", URL)
    assert code == FAILED and "no_images" in page and "imu_silent" in page, page


def check_other_channels(terrace, terraced, log, folder):
    """A robot's log with names of its own is read by every tool that reads logs."""
    own, result = f"{folder}/own.lcmlog", f"{folder}/own"
    content = pathlib.Path(log).read_bytes()
    pathlib.Path(own).write_bytes(content.replace(b"TERRACE_IMAGES", b"WALKERS_IMAGES"))
    names = ["--set", "channels.images=WALKERS_IMAGES"]
    subprocess.run([terraced, "replay", own, "--output", result, *names], check=True, capture_output=True)
    for command in (["draw", result, own, f"{folder}/own.png"], ["calibration", "--check", own]):
        code, _, complaint = terrace.run(*command)
        assert code != DONE and "TERRACE_IMAGES" in complaint, (command, code, complaint)
        code, said, complaint = terrace.run(*command, *names)
        assert code == DONE, (command, code, said, complaint)


def main():
    enter_namespace(["lcm-logplayer"])
    terraced, program, tiny_log, example, python_dir = sys.argv[1:6]
    terrace = Terrace(program)
    check_without_daemon(terrace)
    check_drivers(terrace, example, python_dir)
    with tempfile.TemporaryDirectory(prefix="terrace_bus_tools_test.") as folder:
        check_camera(terrace, folder)
        log = f"{folder}/tiny.lcmlog"
        subprocess.run([tiny_log, log, "12"], check=True)
        check_other_channels(terrace, terraced, log, folder)
        daemon = subprocess.Popen([terraced, "--set", f"lcm.url={URL}", "--set", f"lcm.save_folder={folder}"],
                                  stderr=subprocess.PIPE, text=True)
        try:
            while "live on" not in daemon.stderr.readline():
                assert daemon.poll() is None
            check_without_input(terrace)
            check_doctor(terrace, log)
            check_record(terrace, terraced, log, folder)
            check_with_input(terrace, log, folder)
        finally:
            daemon.send_signal(signal.SIGTERM)
            _, log_text = daemon.communicate(timeout=60)
        assert daemon.returncode == 0, log_text
    print("status and command say how the daemon is")


main()
