#!/bin/bash
# Compares one process with several, in one run: bytes of the file, wall and core time, and the data sent between ranks.
#
#   mpi.sh BUILD INPUT [btf-encode options...]      RANKS=2: ranks of one thread each
#
# SPDX-License-Identifier: MIT
set -eu
build=$1 input=$2
shift 2
export OMP_WAIT_POLICY=passive OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
export OMPI_MCA_rmaps_base_oversubscribe=1 OMPI_MCA_btl_vader_single_copy_mechanism=none
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
exec python3 - "$build/encoder/btf-encode" "$input" "${RANKS:-2}" "$work" "$@" <<'END'
import filecmp, json, resource, subprocess, sys, time

encode, source, ranks, work, options = sys.argv[1], sys.argv[2], int(sys.argv[3]), sys.argv[4], sys.argv[5:]

def core():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime

def run(name, before, threads):
    out = f"{work}/{name}"
    command = before + [encode, source, "-o", out + ".btf.exr", "--report", out + ".json", "-q",
                        "--threads", str(threads)] + options
    begin, used = time.monotonic(), core()
    subprocess.run(command, check=True)
    return name, time.monotonic() - begin, core() - used, json.load(open(out + ".json"))

launch = ["mpirun", "-n", str(ranks)]
runs = [run("1 thread", [], 1), run(f"{ranks} threads", [], ranks), run(f"{ranks} ranks", launch, 1)]
print(f"{'':12} {'wall s':>8} {'core s':>8} {'of 1 thread':>12} {'peak MB':>8}")
for name, wall, used, report in runs:
    same = filecmp.cmp(f"{work}/1 thread.btf.exr", f"{work}/{name}.btf.exr", shallow=False)
    print(f"{name:12} {wall:8.1f} {used:8.1f} {wall / runs[0][1]:12.2f} {report['peak_rss'] / 1e6:8.0f}"
          + ("" if same else "  OTHER BYTES"))
    if not same:
        sys.exit(7)
report = runs[-1][3]
print(f"\n{'stage':14} {'seconds':>8} {'received MB':>12} {'sent MB':>9} {'meetings':>9} {'waited s':>9} {'moved s':>8}")
for stage, v in report["between_ranks"].items():
    print(f"{stage:14} {report['seconds'].get(stage, 0):8.1f} {v['received'] / 1e6:12.2f} {v['sent'] / 1e6:9.2f}"
          f" {v['meetings']:9} {v['waited']:9.2f} {v['moved']:8.2f}")
END
