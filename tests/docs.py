#!/usr/bin/env python3
"""Holds the documents: every relative link and picture of a Markdown file leads somewhere, every picture that the
repository has for them is shown, the README stays short, and what tests/bench/regenerate.sh writes is what they show:
every picture, every part of a page between marks, each with the commit that it was made from.

    docs.py SOURCE_ROOT               prints what is wrong, a line each; exit code 1 when there is anything
    docs.py SOURCE_ROOT --self-test   breaks each rule in a copy, and fails where that goes unnoticed

SPDX-License-Identifier: MIT
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile

PICTURES = 'tests/data/readme'
SCRIPT = 'tests/bench/regenerate.sh'
README_BYTES = 9000
LEFT_OUT = ('.git', 'subprojects')


def documents(root):
    for folder, folders, files in os.walk(root):
        folders[:] = sorted(name for name in folders if name not in LEFT_OUT and not name.startswith('build'))
        for name in sorted(files):
            if name.endswith('.md'):
                yield os.path.relpath(os.path.join(folder, name), root)


def anchor(heading):
    """The anchor that viewers of Markdown give a heading."""
    return re.sub(r'[^\w\- ]', '', heading.strip().lower()).replace(' ', '-')


def text_of(root, path):
    """The text of a document without its code, where brackets are no links."""
    with open(os.path.join(root, path), encoding='utf-8') as file:
        text = file.read()
    return re.sub(r'^```.*?^```$', '', text, flags=re.S | re.M)


def regenerated(root):
    """Complaints about names that regenerate.sh writes and no document shows, or the other way round."""
    listed = subprocess.run(['bash', os.path.join(root, SCRIPT), '--list'], check=True, capture_output=True, text=True).stdout
    written = {name for line in listed.strip().split('\n') for name in line.split()[1:]}
    there = {name for name in os.listdir(os.path.join(root, PICTURES)) if name.endswith('.png')}
    for path in documents(root):
        with open(os.path.join(root, path), encoding='utf-8') as file:
            there |= {f'{path}#{name}' for name in re.findall(r'<!-- (\w+): written by', file.read())}
    pages = {name for name in written if name.endswith('.md') and os.path.exists(os.path.join(root, name))}
    found = [f'{SCRIPT}: writes {name}, which no document has' for name in sorted(written - there - pages)]
    found += [f'{SCRIPT}: does not write {name}' for name in sorted(there - written)]
    with open(os.path.join(root, PICTURES, 'made.txt'), encoding='utf-8') as file:
        made = {line.split()[0] for line in file}
    return found + [f'{PICTURES}/made.txt: one list has {name}, the other has not' for name in sorted(made ^ written)]


def complaints(root):
    found, shown = [], set()
    for path in documents(root):
        for target in re.findall(r'\]\(([^)\s]+)\)', re.sub(r'`[^`\n]*`', '', text_of(root, path))):
            if re.match(r'[a-z]+:', target):
                continue
            name, _, part = target.partition('#')
            at = os.path.normpath(os.path.join(os.path.dirname(path), name)) if name else path
            shown.add(at)
            if not os.path.exists(os.path.join(root, at)):
                found.append(f'{path}: no such file: {target}')
            elif part and part not in map(anchor, re.findall(r'^#+ (.*)$', text_of(root, at), flags=re.M)):
                found.append(f'{path}: no such heading: {target}')
    for name in sorted(os.listdir(os.path.join(root, PICTURES))):
        if name.endswith('.png') and f'{PICTURES}/{name}' not in shown:
            found.append(f'{PICTURES}/{name}: no document shows it')
    found += regenerated(root)
    size = os.path.getsize(os.path.join(root, 'README.md'))
    if size > README_BYTES:
        found.append(f'README.md: {size} bytes, at most {README_BYTES}')
    return found


def edit(path, change):
    """Adds a text at the end, or replaces one by another."""
    text = ''
    if os.path.exists(path):
        with open(path, encoding='utf-8') as file:
            text = file.read()
    if not isinstance(change, str) and change[0] not in text:
        sys.exit(f'docs.py: {path} does not have {change[0]}')
    with open(path, 'w', encoding='utf-8') as file:
        file.write(text + change if isinstance(change, str) else text.replace(*change))


def self_test(root):
    """Makes each break in a copy: (rule that is broken, file, text to add, or (text, its replacement)). A document that
    does not exist is made."""
    breaks = [('a link', 'README.md', '\n[x](encoder/none.md)\n'),
              ('a heading', 'README.md', '\n[x](tests/bench/README.md#none)\n'),
              ('a picture', 'tests/README.md', '\n![x](none.png)\n'),
              ('a picture that nothing shows', PICTURES + '/none.png', 'x'),
              ('a part between marks that no script writes', 'tests/README.md', '\n<!-- none: written by nobody -->\n'),
              ('a picture that no script writes', SCRIPT, (' storage.png', '')),
              ('a picture that the script writes for nobody', SCRIPT, (' storage.png', ' storage.png none.png')),
              ('a part that the script writes for nobody', SCRIPT, ('README.md#plan', 'README.md#none')),
              ('a picture without its commit', PICTURES + '/made.txt', ('storage.png', 'none.png')),
              ('the length', 'README.md', 'x' * README_BYTES)]
    unnoticed = 0
    for what, path, added in breaks:
        with tempfile.TemporaryDirectory() as folder:
            copy = os.path.join(folder, 'copy')
            shutil.copytree(root, copy, ignore=shutil.ignore_patterns('build*', *LEFT_OUT), symlinks=True)
            edit(os.path.join(copy, path), added)
            if not complaints(copy):
                print(f'docs.py: not noticed: {what}')
                unnoticed += 1
    return unnoticed


def main():
    root = sys.argv[1]
    found = complaints(root)
    for complaint in found:
        print(complaint)
    if '--self-test' in sys.argv[2:]:
        unnoticed = self_test(root)
        print(f'{unnoticed} breaks not noticed')
        sys.exit(1 if found or unnoticed else 0)
    print(f'{len(found)} complaints')
    sys.exit(1 if found else 0)


if __name__ == '__main__':
    main()
