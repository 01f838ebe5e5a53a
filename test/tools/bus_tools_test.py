#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""`terrace status`, `command`, `doctor` and `record` beside a live daemon: what they say and their exit codes."""
import glob
import json
import pathlib
import signal
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
    assert json.loads(pathlib.Path(folder, "map.json").read_text())["format"] == "terrace-map"
    # Two seconds after the last image.
    time.sleep(2.0)
    code, page, _ = terrace.run("status", "--url", URL)
    assert code == FAILED and "no_images" in page and "imu_silent" in page, page


def main():
    enter_namespace(["lcm-logplayer"])
    terraced, program, tiny_log = sys.argv[1:4]
    terrace = Terrace(program)
    check_without_daemon(terrace)
    with tempfile.TemporaryDirectory(prefix="terrace_bus_tools_test.") as folder:
        log = f"{folder}/tiny.lcmlog"
        subprocess.run([tiny_log, log, "12"], check=True)
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
