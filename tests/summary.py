"""Counts test cases in meson's testlog.json files: prints why tests were skipped, the ten tests of each file that took the
most core seconds (tests/cost.sh) and their sum, which failed, and as the last line "N passed, N failed, N skipped". A
cmocka program counts by its cases, any other by its result. Exits 1 on a failure.

SPDX-License-Identifier: MIT
"""
import json
import re
import sys

CASE = re.compile(r"^\[\s*(OK|FAILED|ERROR|SKIPPED)\s*\] (\S+)$", re.M)

COST = re.compile(r"^core seconds: ([0-9.]+)$", re.M)


def print_costs(path, tests):
    """Prints the ten tests that took the most core seconds, and the sum over all tests whose log has them."""
    costs = []
    for test in tests:
        told = COST.findall(test.get("stderr") or "")
        if told:
            costs.append((float(told[-1]), test["name"].split(" / ")[-1]))
    if costs:
        most = ", ".join(f"{name} {seconds:.0f}" for seconds, name in sorted(costs, reverse=True)[:10])
        print(f"{path}: {sum(seconds for seconds, _ in costs):.0f} core seconds, most by {most}")


def main():
    passed, failed, skipped = 0, [], []
    for path in sys.argv[1:]:
        with open(path, encoding="utf-8", errors="replace") as log:
            tests = [json.loads(line) for line in log]
        if not tests:
            failed.append(f"{path}: no test ran")
        print_costs(path, tests)
        for test in tests:
            out = test.get("stdout") or ""
            name, result = test["name"], test["result"]
            cases = {case: verdict for verdict, case in CASE.findall(out)} if "[ RUN " in out else {}
            if not cases:
                cases = {"": {"OK": "OK", "SKIP": "SKIPPED"}.get(result, result)}
            elif result not in ("OK", "SKIP") and not set(cases.values()) & {"FAILED", "ERROR"}:
                cases["(exit)"] = result
            for case, verdict in cases.items():
                label = f"{name}: {case}" if case else name
                if verdict == "OK":
                    passed += 1
                elif verdict == "SKIPPED":
                    skipped.append(label)
                else:
                    failed.append(f"{label} ({verdict})")
            for line in (out + (test.get("stderr") or "")).splitlines():
                if "skipped:" in line.lower() or line.startswith("SKIP"):
                    print(f"{name}: {line.strip()}")
    for label in skipped:
        print(f"skipped: {label}")
    for label in failed:
        print(f"FAILED: {label}")
    print(f"{passed} passed, {len(failed)} failed, {len(skipped)} skipped")
    return 1 if failed or passed == 0 else 0


sys.exit(main())
