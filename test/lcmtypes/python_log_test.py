#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The generated Python package decodes a log of ours with a ten-line reader and no other package."""
import pathlib
import struct
import subprocess
import sys
import tempfile

python_dir, tiny_log = sys.argv[1:3]
sys.path.insert(0, python_dir)
from terrace import calibration_v1_t, images_t, imu_v1_t  # noqa: E402


def events(path):
    """Yields (utime, channel, data) of an LCM log."""
    with open(path, "rb") as log:
        while header := log.read(28):
            sync, _number, utime, channel_size, data_size = struct.unpack(">IqqII", header)
            assert sync == 0xEDA1DA01
            yield utime, log.read(channel_size).decode(), log.read(data_size)


with tempfile.TemporaryDirectory() as folder:
    log = pathlib.Path(folder, "tiny.lcmlog")
    subprocess.run([tiny_log, log, "12"], check=True)
    messages = {}
    for utime, channel, data in events(log):
        messages.setdefault(channel, []).append((utime, data))

calibration = calibration_v1_t.decode(messages["TERRACE_CALIBRATION"][0][1])
assert (calibration.width, calibration.height, calibration.model) == (160, 120, "pinhole-radtan")
assert len(messages["TERRACE_CALIBRATION"]) == 2, "once a second"
images = [images_t.decode(data) for _, data in messages["TERRACE_IMAGES"]]
assert len(images) == 12
assert list(images[0].image_types) == [images_t.LEFT, images_t.RIGHT]
assert len(images[0].images[0].data) == 160 * 120
nanoseconds = {m.key: bytes(m.value) for m in images[1].images[0].metadata}["t_capture_ns"]
assert int(nanoseconds) == 1_600_000_000_100_000_000
imu = imu_v1_t.decode(messages["TERRACE_IMU"][0][1])
assert imu.accel == (0.0, 0.0, 9.81) and imu.t_ns // 1000 == imu.utime
print(f"{len(images)} stereo pairs, {len(messages['TERRACE_IMU'])} IMU samples")
