#!/usr/bin/env python3
"""Holds the house: the rooms of the source tree in order, each including only what stands behind it.

    house.py SOURCE_ROOT               prints what breaks a rule below, a line each; exit code 1 when there is any
    house.py SOURCE_ROOT --self-test   breaks each rule in a copy of the sources, and fails where that goes unnoticed

The rules:
  - A file includes its own room and the rooms behind it, never one in front of it or beside it.
  - Includes of another room are written from the root, those of the same folder by bare name.
  - The files of a room do not include one another in a circle; a header and the source of its name count as one.
  - What a header declares is defined in the source of its name.
  - Every C file and header is in a room, and no folder has more than 40 files.
  - A file of tests (TEST of tests/support/test.h) runs them: each file has a list of its own.

SPDX-License-Identifier: MIT
"""
import os
import re
import shutil
import sys
import tempfile

# The storeys from front to back. A storey is one or more wings, which know nothing of one another; a wing is rooms
# from front to back; rooms in one string stand side by side. A file belongs to the longest name that leads to it.
HOUSE = [
    [['tests/unit tests/fuzz tests/stability tests/tools tests/keep_modules.c',
      'tests/bench',
      'tests/conformance tests/sample',
      'tests/support']],
    [['encoder/btf-encode.c encoder/btf-compare.c decoder/tools/btf-info.c decoder/tools/btf-decode.c '
      'decoder/tools/render/btf-render.c decoder/tools/view/btf-view.c decoder/tools/shader/btf-shader.c decoder/examples decoder/web/wasm',
      'decoder/tools/original']],
    [['encoder/job',
      'encoder/report',
      'encoder/between',
      'encoder/paper encoder/factor',
      'encoder/relief',
      'encoder/lafortune encoder/nodes encoder/allocation',
      'encoder/library',
      'encoder/input encoder/model',
      'encoder/data',
      'encoder/base encoder/math'],
     ['decoder/tools/view',
      'decoder/tools/render',
      'decoder/tools/context decoder/tools/info decoder/tools/mesh decoder/tools/shader']],
    [['decoder/toolkit',
      'decoder/pixels',
      'decoder',
      'reference']],
]
MOST_FILES = 40

# Installed headers are included as their users do.
PUBLIC_FOLDERS = {'openbtf/reference.h': 'reference/include/openbtf/reference.h',
                  'openbtf/input.h': 'encoder/library/include/openbtf/input.h', 'openbtf/': 'decoder/include/openbtf/'}

# Headers whose functions are defined in several files or one of another name, and why.
HEADERS_OF_SEVERAL = {
    'decoder/include/openbtf/': 'the face of the library: what users call, not how its files are divided',
    'encoder/library/include/': 'likewise, of the library of readers',
    'reference/include/': 'the reference decoder is read and copied as a whole, with one header to the outside',
    'reference/btf_reference': 'and one within',
    'tests/bench/bench.h': 'what the sections of the one program btf-bench share',
    'tests/bench/results.h': 'what the sections of the one program btf-bench share',
    'tests/bench/codecs/pca.h': 'one peer: its analysis and its codec',
    'tests/conformance/check': 'the checks of one run, a file each',
    'tests/fuzz/fuzz.h': 'each target defines the function that libFuzzer calls',
    'tests/stability/precision': 'the parts of one program, and its second build in double',
}
# Folders of inputs, a file a case.
FOLDERS_OF_DATA = ('tests/fuzz/corpus/',)

CODE = ('.c', '.cc', '.h')


def rooms():
    """{room: (storey, wing, place in the wing)}"""
    return {room: (s, w, p) for s, storey in enumerate(HOUSE) for w, wing in enumerate(storey)
            for p, beside in enumerate(wing) for room in beside.split()}


ROOMS = rooms()


def room_of(path):
    return max((r for r in ROOMS if path == r or path.startswith(r + '/')), key=len, default=None)


def sources(root):
    """All files below the root that belong to the house, by their path from there."""
    found = []
    for folder, folders, files in os.walk(root):
        here = os.path.relpath(folder, root)
        folders[:] = sorted(f for f in folders if not f.startswith(('.', '__')) and
                            not (here == '.' and (f.startswith('build') or f == 'shared')))
        found += [os.path.normpath(os.path.join(here, f)) for f in sorted(files) if not f.startswith('.')]
    return found


def includes(text):
    """(line number, name, whether in quotes) of each include."""
    for number, line in enumerate(text.split('\n'), 1):
        match = re.match(r'\s*#\s*include\s*([<"])([^>"]+)[>"]', line)
        if match:
            yield number, match[2], match[1] == '"'


def public(name):
    for prefix, folder in PUBLIC_FOLDERS.items():
        if name.startswith(prefix):
            return folder + name[len(prefix):]
    return None


def target_of(path, name, quoted, files):
    """The file that an include names; None for one of the system; False for one that is not written as the rules
    allow."""
    if public(name) in files:
        return public(name)
    if not quoted:
        return None
    if '/' not in name and os.path.join(os.path.dirname(path), name) in files:
        return os.path.join(os.path.dirname(path), name)
    return name if '/' in name and os.path.dirname(name) != os.path.dirname(path) and name in files else False


def statements(text):
    """The statements of a file outside of all braces; a brace and what is in it are one {}."""
    text = re.sub(r'#ifdef __cplusplus\n.*?#endif', '', text, flags=re.S)
    text = re.sub(r'/\*.*?\*/|//[^\n]*|"(\\.|[^"\\\n])*"|\'(\\.|[^\'\\\n])+\'|^[ \t]*#(\\\n|[^\n])*', ' ', text,
                  flags=re.S | re.M)
    text = re.sub(r'^[A-Z][A-Z0-9_]*\([^()\n]*\)$', '', text, flags=re.M)  # a macro that makes functions
    text = re.sub(r'extern\s+\{', '', text)  # extern "C" { in a C++ file, strings removed
    flat, depth = '', 0
    for c in text:
        depth += c == '{'
        if depth == 0:
            flat += c
        depth -= c == '}'
        if c == '}' and depth == 0:
            flat += '{}'
    return [' '.join(s.split()) for s in re.split(r';|(?<=\{\})(?!\s*[\w,]*\s*[;,=])', flat)]


def names(text):
    """Returns (functions and objects that a file declares, those that it defines), without static ones."""
    declared, defined = set(), set()
    for s in statements(text):
        s = re.sub(r'^([A-Z][A-Z0-9_]*\s*\([^()]*\)\s*)+', '', s)  # macros that define something else
        is_extern = s.startswith('extern ')
        match = re.match(r'(?!typedef\b|static\b|_Static_assert\b|return\b)[\w\s*]*?\b(\w+)\s*\(', s)
        if match and '=' not in s[:match.end()]:
            (defined if s.endswith('{}') else declared).add(match[1])
        elif is_extern:
            declared.update(re.findall(r'(\w+)\s*(?:\[[^]]*\]\s*)*(?:,|$)', s))
        elif not s.startswith(('typedef', 'static')):
            defined.update(re.findall(r'(\w+)\s*(?:\[[^]]*\]\s*)*(?:,|=|$)', s))
    return declared, defined


def wrong_includes(path, found):
    """Complaints about the includes of one file. found: [(line, name as written, target)]."""
    mine = room_of(path)
    for line, name, target in found:
        if target is False:
            yield (f'{path}:{line} includes {name}: neither a file of its folder by bare name nor one of another '
                   f'folder from the root')
            continue
        other = room_of(target)
        if other is None or mine is None or other == mine:
            continue
        a, b = ROOMS[other], ROOMS[mine]
        beside = a[0] == b[0] and (a[1] != b[1] or a[2] == b[2])
        if beside or a < b:
            yield (f'{path}:{line} includes {target}: {other} stands {"beside" if beside else "in front of"} '
                   f'{mine}')


def circles(edges):
    """The sets of nodes that reach one another (R. Tarjan, 1972)."""
    order, low, stack, found = {}, {}, [], []

    def visit(node):
        order[node] = low[node] = len(order)
        stack.append(node)
        for next_node in sorted(edges.get(node, ())):
            if next_node not in order:
                visit(next_node)
            if next_node in stack:
                low[node] = min(low[node], low[next_node])
        if low[node] == order[node]:
            at = stack.index(node)
            if len(stack) - at > 1:
                found.append(sorted(stack[at:]))
            del stack[at:]

    sys.setrecursionlimit(10000)
    for node in sorted(edges):
        if node not in order:
            visit(node)
    return found


def unnamed(path, texts):
    """Complaints about a header whose functions are defined elsewhere."""
    if path.startswith(tuple(HEADERS_OF_SEVERAL)):
        return
    stem = path[:-2]
    declared, _ = names(texts[path])
    defined = set().union(*(names(texts[stem + e])[1] for e in ('.c', '.cc') if stem + e in texts))
    missing = sorted(declared - defined)
    if missing and not any(stem + e in texts for e in ('.c', '.cc')):
        yield f'{path}: declares {missing[0]}, and there is no {os.path.basename(stem)}.c'
    elif missing:
        yield f'{path}: {", ".join(missing)}: not defined in {os.path.basename(stem)}.c'


def unrun(path, text):
    """Complaints about a file whose tests are never run."""
    test = re.search(r'^(?:[A-Z]+_)?TEST(?:_WITH|_OF_NUMBERS)?\((\w+)', text, flags=re.M)
    if test and not re.search(r'^RUN_TESTS\(|\brun_listed\(', text, flags=re.M):
        yield f'{path}: has the test {test[1]}, and neither RUN_TESTS nor run_listed'


def complaints(root):
    files = sources(root)
    in_house = [f for f in files if f.endswith(CODE)]
    texts, known, found, counts = {}, set(in_house), [], {}
    for path in in_house:
        with open(os.path.join(root, path), encoding='utf-8') as file:
            texts[path] = file.read()
    for path in files:
        counts[os.path.dirname(path)] = counts.get(os.path.dirname(path), 0) + 1
    found += [f'{folder or "the root"}: {count} files, more than {MOST_FILES}' for folder, count in counts.items()
              if count > MOST_FILES and not (folder + '/').startswith(FOLDERS_OF_DATA)]
    edges, at = {}, {}
    for path in in_house:
        if room_of(path) is None:
            found.append(f'{path}: in no room')
        targets = [(line, name, target_of(path, name, quoted, known))
                   for line, name, quoted in includes(texts[path])]
        targets = [t for t in targets if t[2] is not None]
        found += wrong_includes(path, targets)
        node = os.path.splitext(path)[0]
        for line, _, target in targets:
            if target and os.path.splitext(target)[0] != node and room_of(target) == room_of(path):
                edges.setdefault(node, set()).add(os.path.splitext(target)[0])
                at[node, os.path.splitext(target)[0]] = f'{path}:{line} includes {target}'
        if path.endswith('.h'):
            found += unnamed(path, texts)
        else:
            found += unrun(path, texts[path])
    for circle in circles(edges):
        found += [f'{at[a, b]}: a circle of {", ".join(circle)}' for a in circle for b in circle if (a, b) in at]
    return found


# Deliberate breaks: (file, text to add, part of the complaint that is expected). A file that does not exist is made.
BREAKS = [
    ('reference/btf_arithmetic.c', '#include <openbtf/plan.h>\n', 'decoder stands in front of reference'),
    ('decoder/atlas.c', '#include "decoder/toolkit/cli.h"\n', 'decoder/toolkit stands in front of decoder'),
    ('decoder/toolkit/cli.c', '#include "encoder/math/area.h"\n', 'encoder/math stands in front of decoder/toolkit'),
    ('encoder/data/data.c', '#include "encoder/job/memory.h"\n#include "encoder/job/memory.h"\n',
     'encoder/job stands in front of encoder/data'),
    ('encoder/factor/rows.c', '#include "encoder/paper/fit.h"\n', 'encoder/paper stands beside encoder/factor'),
    ('decoder/tools/render/table.c', '#include "encoder/input/reader.h"\n',
     'encoder/input stands beside decoder/tools/render'),
    ('encoder/job/job.c', '#include "tests/sample/noise.h"\n', 'tests/sample stands in front of encoder/job'),
    ('decoder/tools/render/table.c', '#include "../mesh/obj.h"\n', 'neither a file of its folder'),
    ('decoder/toolkit/output.c', '#include "temporary.h"\n', 'neither a file of its folder'),
    ('decoder/result.h', '#include "decoder/checks/values.h"\n', 'decoder/checks/values'),
    ('decoder/atlas.h', 'int btfi_atlas_nowhere(void);\n', 'btfi_atlas_nowhere: not defined in atlas.c'),
    ('decoder/lonely.h', 'extern const int btfi_lonely;\n', 'there is no lonely.c'),
    ('encoder/stray.c', '', 'encoder/stray.c: in no room'),
    ('tests/unit/math/more.c', 'TEST(test_more) {\n}\n', 'has the test test_more'),
    ('tests/unit/input/more.c', 'SET_TEST(test_sets) {\n}\n', 'has the test test_sets'),
    ('tests/unit/nodes/more.c', 'TEST_WITH(test_with, NULL, NULL) {\n}\n', 'has the test test_with'),
] + [(f'encoder/math/more{i}.h', '', 'encoder/math: ' if i == MOST_FILES else None) for i in range(MOST_FILES + 1)]


def self_test(root):
    """Makes all breaks, each in a copy of the sources, and returns the number of those that go unnoticed."""
    with tempfile.TemporaryDirectory(prefix='btf-house-') as tree:
        for path in sources(root):
            if path.endswith(CODE):
                os.makedirs(os.path.join(tree, os.path.dirname(path)), exist_ok=True)
                shutil.copyfile(os.path.join(root, path), os.path.join(tree, path))
        before = complaints(tree)
        for path, text, _ in BREAKS:
            with open(os.path.join(tree, path), 'a', encoding='utf-8') as file:
                file.write(text)
        seen = [c for c in complaints(tree) if c not in before]
    unnoticed = [(path, part) for path, _, part in BREAKS
                 if part and not any(c.startswith((path, os.path.dirname(path) + ':')) and part in c for c in seen)]
    for path, part in unnoticed:
        print(f'{path} broken: nobody says "{part}"')
    print(f'{sum(part is not None for _, _, part in BREAKS)} breaks, {len(unnoticed)} unnoticed')
    return len(unnoticed)


def main():
    root = os.path.abspath(sys.argv[1])
    if sys.argv[2:] == ['--self-test']:
        sys.exit(1 if self_test(root) else 0)
    found = complaints(root)
    print(*found, sep='\n', end='\n' if found else '')
    print(f'{len(ROOMS)} rooms, {len(found)} complaints')
    sys.exit(1 if found else 0)


main()
