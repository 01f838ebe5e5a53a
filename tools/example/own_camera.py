#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A camera driver of your own, without any package: replace grab() by your camera. PYTHONPATH must hold the folder of the
generated package `terrace` (build/release/lcmtypes/python, or share/terrace/python where it is installed)."""
import socket
import struct
import time

from terrace import image_t, images_t

GROUP, PORT, WIDTH, HEIGHT, RATE_HZ = "239.255.76.67", 7667, 640, 480, 30


def grab(right, frame):
    """(8-bit grey pixels, row after row; middle of the exposure in us since the epoch)"""
    row = bytes(((u + (16 if right else 0)) // 8 * 37 + frame) & 0xFF for u in range(WIDTH))
    return row * HEIGHT, time.time_ns() // 1000


def publish(sock, number, channel, data):
    """As LCM cuts a message into packets: magic, number, size, offset, fragment of so many; the channel in the first."""
    parts = [data[at:at + 60000] for at in range(0, len(data), 60000)]
    for i, part in enumerate(parts):
        header = struct.pack(">IIIIHH", 0x4C433033, number, len(data), 60000 * i, i, len(parts))
        sock.sendto(header + (channel.encode() + b"\0" if i == 0 else b"") + part, (GROUP, PORT))


sock = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
sock.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
frame = 0
while True:
    pair = images_t()
    for image_type in (images_t.LEFT, images_t.RIGHT):
        image = image_t()
        image.data, image.utime = grab(image_type == images_t.RIGHT, frame)
        image.width, image.height, image.row_stride, image.size = WIDTH, HEIGHT, WIDTH, len(image.data)
        image.pixelformat = image_t.GRAY
        pair.images.append(image)
        pair.image_types.append(image_type)
    pair.n_images, pair.utime = 2, pair.images[0].utime
    publish(sock, frame, "TERRACE_IMAGES", pair.encode())
    frame += 1
    time.sleep(1.0 / RATE_HZ)
