# SPDX-License-Identifier: BSD-3-Clause
"""LCM over UDP multicast in plain Python: enough of the protocol to talk to every LCM program on the network.

The packets are those of LCM 1.x: https://lcm-proj.github.io/lcm/content/udp-multicast-protocol.html
"""
import re
import select
import socket
import struct
import time
import urllib.parse

_SHORT, _FRAGMENT = 0x4C433032, 0x4C433033  # "LC02", "LC03"
_SHORT_MAX = 65499  # bytes of channel, its end and data in one packet
_FRAGMENT_MAX = 65487
_MAX_PENDING_BYTES = 1 << 24
_IP_MULTICAST_ALL = 49  # linux/in.h


class Bus:
    """A connection to an LCM network: subscribe, handle, publish. To be used by one thread.

    url: as LCM has it, `udpm://GROUP:PORT?ttl=N&recv_buf_size=BYTES`; ttl 0 stays on this machine.
    Raises OSError when the network cannot be used, ValueError when the url is no such one.
    """

    def __init__(self, url="udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2097152"):
        parts = urllib.parse.urlparse(url)
        if parts.scheme != "udpm":
            raise ValueError(f"{url}: only udpm://GROUP:PORT is known")
        options = {key: int(values[-1]) for key, values in urllib.parse.parse_qs(parts.query).items()}
        self._address = (parts.hostname or "239.255.76.67", parts.port or 7667)
        self._receiver = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._receiver.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        if hasattr(socket, "SO_REUSEPORT"):
            self._receiver.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
        if "recv_buf_size" in options:
            self._receiver.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, options["recv_buf_size"])
        self._receiver.bind(("", self._address[1]))
        membership = socket.inet_aton(self._address[0]) + socket.inet_aton("0.0.0.0")
        self._receiver.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, membership)
        self._receiver.setsockopt(socket.IPPROTO_IP, _IP_MULTICAST_ALL, 0)  # no other groups on this port
        self._receiver.setblocking(False)
        self._sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, options.get("ttl", 0))
        self._sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_LOOP, 1)
        self._sequence = 0
        self._handlers = []
        self._partial = {}  # (sender, sequence) -> what has come of a message in fragments
        self._partial_bytes = 0

    def close(self):
        """Leaves the network."""
        self._receiver.close()
        self._sender.close()

    def subscribe(self, channel, handler):
        """Has handler(channel, data) called inside handle() for every message whose channel matches the whole regular
        expression `channel`."""
        self._handlers.append((re.compile(channel), handler))

    def publish(self, channel, message):
        """Sends `message`: bytes, or anything with encode()."""
        data = message if isinstance(message, (bytes, bytearray)) else message.encode()
        name = channel.encode() + b"\0"
        sequence, self._sequence = self._sequence, (self._sequence + 1) & 0xFFFFFFFF
        if len(name) + len(data) <= _SHORT_MAX:
            self._sender.sendto(struct.pack(">II", _SHORT, sequence) + name + data, self._address)
            return
        pieces, offset = [], 0
        while offset < len(data):
            room = _FRAGMENT_MAX - (len(name) if not pieces else 0)
            pieces.append((offset, data[offset:offset + room]))
            offset += room
        for number, (offset, piece) in enumerate(pieces):
            head = struct.pack(">IIIIHH", _FRAGMENT, sequence, len(data), offset, number, len(pieces))
            self._sender.sendto(head + (name if number == 0 else b"") + piece, self._address)

    def handle(self, timeout_s=None):
        """Waits for at least one message, for at most `timeout_s` (None: for ever), and hands on all that are there.
        Returns the number of messages received, subscribed to or not."""
        end = None if timeout_s is None else time.monotonic() + timeout_s
        num_messages = 0
        while num_messages == 0:
            left = None if end is None else max(0.0, end - time.monotonic())
            if not select.select([self._receiver], [], [], left)[0]:
                break
            num_messages = self._receive_all()
        return num_messages

    def _receive_all(self):
        num_messages = 0
        while True:
            try:
                packet, sender = self._receiver.recvfrom(65536)
            except BlockingIOError:
                return num_messages
            whole = self._message_of(packet, sender)
            if whole is None:
                continue
            num_messages += 1
            for pattern, handler in self._handlers:
                if pattern.fullmatch(whole[0]):
                    handler(*whole)

    def _message_of(self, packet, sender):
        """(channel, data) when the packet is a message or the last fragment of one to come, else None."""
        if len(packet) >= 8 and packet[:4] == struct.pack(">I", _SHORT):
            name, end, data = packet[8:].partition(b"\0")
            return (name.decode(errors="replace"), data) if end else None
        if len(packet) < 20 or packet[:4] != struct.pack(">I", _FRAGMENT):
            return None
        _, sequence, size, offset, number, count = struct.unpack(">IIIIHH", packet[:20])
        piece, name = packet[20:], None
        if number == 0:
            name, _, piece = piece.partition(b"\0")
        if size > _MAX_PENDING_BYTES or offset + len(piece) > size or number >= count:
            return None
        return self._add_fragment((sender, sequence), size, offset, number, count, piece, name)

    def _add_fragment(self, key, size, offset, number, count, piece, name):
        if key not in self._partial:
            while self._partial and self._partial_bytes + size > _MAX_PENDING_BYTES:
                self._partial_bytes -= len(self._partial.pop(next(iter(self._partial)))["data"])
            self._partial[key] = {"data": bytearray(size), "missing": set(range(count)), "channel": None}
            self._partial_bytes += size
        partial = self._partial[key]
        if size != len(partial["data"]):
            return None
        partial["data"][offset:offset + len(piece)] = piece
        partial["missing"].discard(number)
        if name is not None:
            partial["channel"] = name.decode(errors="replace")
        if partial["missing"]:
            return None
        del self._partial[key]
        self._partial_bytes -= size
        return partial["channel"], bytes(partial["data"])
