#!/bin/bash
# btf-encode --predict, and the percent of the whole job.
#
# SPDX-License-Identifier: MIT
. "$BTF_SOURCE_ROOT/tests/tools/common.sh" || exit 99
small_data
btf-sample -o flat --relief flat --size 16 --directions 0:1,40:6 --quiet || exit 99

for method in joint paper; do
    expect "$method: prediction by the machine" 0 btf-encode data --method $method --predict self
    expect_text "$method: says time" 'total +[0-9.]+ core s; on [0-9]+ idle cores at least [0-9.]+ s' out
    expect_text "$method: says memory" 'memory: needs --memory 0\.[0-9]+G at least; with [0-9.]+G it is expected to use 0\.[0-9]+ GB, and 0\.000 GB in scratch files' out
    expect "$method: an encode" 0 btf-encode data -o $method.btf.exr --method $method --report $method.json --threads 1
    expect_that "$method: the percent of the job only grows, to 100" python3 - <<'P'
import re
shown = [int(m) for m in re.findall(r"(\d+)%", open("err").read())]
assert len(shown) > 4 and shown == sorted(shown) and shown[-1] == 100, shown
P
    expect "$method: prediction by that report" 0 btf-encode data --method $method --predict $method.json
    expect_that "$method: it comes to what was measured there" python3 - $method.json <<'P'
import json, re, sys
measured = json.load(open(sys.argv[1]))["core_seconds"]["total"]
predicted = float(re.search(r"total +([0-9.]+) core s", open("out").read()).group(1))
assert abs(predicted - measured) < 0.3 * measured + 0.2, (predicted, measured)
P
    expect_that "$method: every stage was foreseen" python3 - $method.json <<'P'
import json, sys
r = json.load(open(sys.argv[1]))
assert set(r["core_seconds"]) - {"total"} <= set(r["predicted_core_seconds"]), r["core_seconds"]
assert set(r["core_seconds"]) == set(r["seconds"])
P
done
expect_that "nothing but encodes wrote a file" test "$(ls *.btf.exr | wc -l)" = 2

btf-sample -o more --size 48 --directions 0:1,40:6 --quiet || exit 99
expect "less memory than it takes" 0 btf-encode more --predict self --memory 100K
expect_text "scratch files are foreseen" 'and 0\.00[0-9]*[1-9] GB in scratch files' out
expect "a flat material" 0 btf-encode flat -o flat.btf.exr --method paper --report flat.json -q
expect "prediction by a job that ended early" 0 btf-encode flat --method paper --predict flat.json
expect_text "what was not needed there is not counted" ' (flow|hidden|cluster) +0\.0 core s' out

expect "no such report" 2 btf-encode data --predict nowhere.json
expect_text "it is named" 'nowhere.json: No such file' err
python3 -c 'import json; print(json.dumps(dict(reversed(json.load(open("joint.json")).items()))))' >other.json
expect "a report that another program wrote anew" 0 btf-encode data --predict joint.json
mv out first
expect "it says the same" 0 btf-encode data --predict other.json
expect_that "to the digit" cmp first out
echo '{"method": "joint", "core_seconds": {"total": "x"}}' >odd.json
expect "a time that is text" 3 btf-encode data --predict odd.json
expect_text "file and member are named" 'odd.json: is not a report of btf-encode: member core_seconds.total is not a number' err
head -20 joint.json >half.json
expect "half a report" 3 btf-encode data --predict half.json
expect_text "file and line are named" 'half.json: line 2[01]: is not JSON' err
expect "another method's report" 1 btf-encode data --predict paper.json
expect_text "both methods are named" 'paper.json: is the report of an encode by --method paper, but the prediction is for --method joint' err
echo data >list.txt
expect "no prediction of lists" 1 btf-encode list.txt --predict self
expect "no such input" 2 btf-encode nowhere --predict self
expect "a crop by its size" 0 btf-encode data --predict self --crop 5x4
expect_text "it is taken" 'data: 5 x 4 texels' out
expect "no such crop" 1 btf-encode data --predict self --crop 5x4x2
finish
