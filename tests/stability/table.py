#!/usr/bin/env python3
"""The table of stability cases, tests/stability/README.md, made from what the tests print.

A stability test is any program, C or script, that prints to its standard output, among whatever else,

    TITLE | what the program is about, one sentence                              (once)
    CASE | input | expected | seen | pass                                        (one line a case)

with the last field `pass`, `FAIL` or `skip`, and exits with 0, 1, or 77 when all of it is skipped. `input` is
unique within the program; `input` and `expected` are the same in every run, so no measured digits there; `seen`
may differ from run to run. No field holds a `|`. C programs call cases.h.

    table.py run NAME COMMAND...   runs COMMAND, shows its output, keeps the lines in $BTF_BUILD_ROOT/stability/NAME,
                                   and fails when a case fails or when the section NAME of README.md does not list
                                   exactly the cases that the program printed. This is how meson runs every program.
                                   NAME may be GROUP/PART: several programs share the section GROUP, each with the
                                   cases whose input begins with "PART: ".
    table.py write FOLDER          rewrites README.md from the files kept in FOLDER ($BTF_BUILD_ROOT/stability);
                                   sections of programs that have no file there stay as they are.

After adding or renaming a case: run the test (it fails: the table lacks the case), `table.py write`, run it again.

SPDX-License-Identifier: MIT
"""
import os
import subprocess
import sys

README = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'README.md')
HEAD = """# Results of the stability tests

Every hard case and bad input that the tests try, as they printed it: the input, what is expected, what was seen on the
machine that wrote this page. Made by `tests/stability/table.py write`; each test fails when its section here does
not list exactly its cases (under the sanitizers, which run fewer, when it prints one that is not listed).
`stability_files_long` tries every value of the bytes that `stability_files` tries some of, and has no section of its own.
"""
COLUMNS = '| input | expected | seen |\n| --- | --- | --- |\n'


def parse(text):
    """Returns (title, [(input, expected, seen, verdict)]) of a program's output."""
    title, cases = '', []
    for line in text.splitlines():
        fields = [field.strip() for field in line.split(' | ')]
        if fields[0] == 'TITLE' and len(fields) == 2:
            title = fields[1]
        elif fields[0] == 'CASE':
            if len(fields) != 5 or fields[4] not in ('pass', 'FAIL', 'skip') or '|' in ''.join(fields):
                sys.exit(f'table.py: not a case line: {line}')
            cases.append(tuple(fields[1:]))
    names = [case[0] for case in cases]
    for name in names:
        if names.count(name) > 1:
            sys.exit(f'table.py: the case "{name}" comes twice')
    return title, cases


def sections():
    """Returns {program: text of its section} of README.md."""
    found = {}
    if os.path.exists(README):
        with open(README, encoding='utf-8') as file:
            for part in file.read().split('\n## ')[1:]:
                name, text = part.split('\n', 1)
                found[name.strip()] = text.strip('\n')
    return found


def listed(section):
    """{(input, expected)} of a section."""
    rows = set()
    for line in section.splitlines():
        if line.startswith('| ') and not line.startswith(('| input |', '| --- |')):
            fields = [field.strip() for field in line.strip('|\n').split(' | ')]
            rows.add((fields[0], fields[1]))
    return rows


def of_part(rows, part):
    """The rows that are of a part of a section: all when there are no parts."""
    return [row for row in rows if not part or row[0].startswith(part + ': ')]


def run(name, command):
    section, _, part = name.partition('/')
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, errors='replace')
    lines = []
    for line in process.stdout:
        sys.stdout.write(line)
        sys.stdout.flush()
        lines.append(line)
    code = process.wait()
    title, cases = parse(''.join(lines))
    if code == 77:
        return 77
    if code < 0:
        print(f'table.py: ended by signal {-code}')
    if code != 0:
        return 1
    if not cases:
        print('table.py: no cases')
        return 1
    folder = os.path.join(os.environ['BTF_BUILD_ROOT'], 'stability')
    os.makedirs(folder, exist_ok=True)
    with open(os.path.join(folder, name.replace('/', ' ')), 'w', encoding='utf-8') as file:
        file.write(''.join(line for line in lines if line.startswith(('TITLE | ', 'CASE | '))))
    failed = [case for case in cases if case[3] == 'FAIL']
    want, have = set(of_part(listed(sections().get(section, '')), part)), {case[:2] for case in cases}
    missing = set() if os.environ.get('BTF_TEST_LIGHT') else want - have  # light: some of the cases
    for case in failed:
        print(f'table.py: failed: {case[0]}')
    for row in sorted(have - want):
        print(f'table.py: not in README.md, section {section}: {row[0]} (expected: {row[1]})')
    for row in sorted(missing):
        print(f'table.py: in README.md, section {section}, but not tested: {row[0]} (expected: {row[1]})')
    return 1 if failed or missing or have - want else 0


def write(folder):
    found = sections()
    for name in sorted(os.listdir(folder)):
        with open(os.path.join(folder, name), encoding='utf-8') as file:
            title, cases = parse(file.read())
        if any(case[3] == 'FAIL' for case in cases):
            sys.exit(f'table.py: {name} has failing cases')
        section, _, part = name.partition(' ')
        rows = [f'| {case[0]} | {case[1]} | {case[2]} |' for case in cases]
        if part:  # cases of other parts stay
            rows += [line for line in found.get(section, '').splitlines() if line.startswith('| ')
                     and not line.startswith((f'| {part}: ', '| input |', '| --- |'))]
            rows.sort()
        found[section] = f'\n{title}\n\n{COLUMNS}' + '\n'.join(rows)
    with open(README + '.part', 'w', encoding='utf-8') as file:
        file.write(HEAD)
        for name in sorted(found):
            file.write(f'\n## {name}\n\n' + found[name].strip('\n') + '\n')
    os.replace(README + '.part', README)


def main():
    if len(sys.argv) >= 4 and sys.argv[1] == 'run':
        sys.exit(run(sys.argv[2], sys.argv[3:]))
    if len(sys.argv) == 3 and sys.argv[1] == 'write':
        write(sys.argv[2])
        return
    sys.exit(__doc__)


main()
