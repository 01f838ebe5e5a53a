# SPDX-License-Identifier: BSD-3-Clause
"""Reads LCM logs."""
import collections
import struct

LogEvent = collections.namedtuple("LogEvent", "utime channel data")
LogEvent.__doc__ = "One message of a log: when it was received [us since the Unix epoch], its channel and its bytes."

_SYNC = 0xEDA1DA01


def read_log(path):
    """Yields the LogEvents of an LCM log in order. A log that ends within an event, as an interrupted recording does, ends
    with the last whole one. Raises ValueError with the place when the bytes are no log."""
    with open(path, "rb") as log:
        while True:
            place = log.tell()
            header = log.read(28)
            if len(header) < 28:
                return
            sync, _number, utime, channel_size, data_size = struct.unpack(">IqqII", header)
            if sync != _SYNC:
                raise ValueError(f"{path}: byte {place}: no event of an LCM log begins here")
            body = log.read(channel_size + data_size)
            if len(body) < channel_size + data_size:
                return
            yield LogEvent(utime, body[:channel_size].decode(errors="replace"), body[channel_size:])
