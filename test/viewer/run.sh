#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# run.sh TEST.mjs PROGRAMS...: runs one file of tests in a network namespace of its own, where a page that asks anybody
# else for anything gets no answer, and no other LCM program disturbs. Exit code 77: skipped, with the reason.
skip() { echo "skipped: $1"; exit 77; }
here=$(dirname "$0")
command -v node >/dev/null || skip "there is no node"
[ -e "$here/../../build/viewer/index.html" ] || skip "the page is not built: scripts/viewer does that"
missing=$(node --input-type=module -e "import { whatIsMissing } from '$here/browser.mjs'; console.log(whatIsMissing())") || exit 1
[ -z "$missing" ] || skip "$missing"
[ "$(id -u)" = 0 ] && unshare -n true 2>/dev/null || skip "a network namespace needs root, and a system that allows it"
exec unshare -n sh -c 'ip link set lo up && ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo &&
  exec node "$@"' sh "$@"
