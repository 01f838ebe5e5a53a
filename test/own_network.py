# SPDX-License-Identifier: BSD-3-Clause
"""A network namespace for tests that send messages, so that no other LCM program hears or disturbs them."""
import os
import pathlib
import shutil
import subprocess
import sys

SKIP = 77
GROUP, PORT = "239.255.76.67", 7667
RECV_BUF_SIZE = 2097152


def url(port=PORT):
    """The LCM address of one bus in the namespace; another port is another bus."""
    return f"udpm://{GROUP}:{port}?ttl=0&recv_buf_size={RECV_BUF_SIZE}"


def skip(reason):
    print(f"skipped: {reason}")
    sys.exit(SKIP)


def enter_namespace(programs=()):
    """Runs the calling script again inside a network namespace with multicast on its loopback. Ends it with SKIP and
    the reason where that, or one of the programs, cannot be had."""
    if os.environ.get("TERRACE_IN_NAMESPACE"):
        return
    if os.geteuid() != 0:
        skip("a network namespace needs root")
    for program in ("unshare", "ip", *programs):
        if not shutil.which(program):
            skip(f"{program} is not installed")
    if subprocess.run(["unshare", "-n", "true"], capture_output=True).returncode != 0:
        skip("this system allows no network namespace")
    limit = int(pathlib.Path("/proc/sys/net/core/rmem_max").read_text())
    if limit < RECV_BUF_SIZE:
        skip(f"net.core.rmem_max = {limit} is too small for images, see daemon/config/60-terrace-lcm.conf")
    setup = ("ip link set lo up && ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo && "
             'exec env TERRACE_IN_NAMESPACE=1 python3 "$@"')
    os.execvp("unshare", ["unshare", "-n", "sh", "-c", setup, "sh", *sys.argv])
