#!/usr/bin/env python3
"""Replaces what stands between two marks of a text file, <!-- NAME: whatever --> and <!-- /NAME -->, marks included, by
standard input: marks.py FILE NAME

SPDX-License-Identifier: MIT
"""
import re
import sys

path, name = sys.argv[1:]
text = sys.stdin.read().rstrip('\n')
if not text:
    sys.exit(f'marks.py: nothing to put into {path}')
with open(path, encoding='utf-8') as file:
    old = file.read()
new, count = re.subn(f'<!-- {name}: .*?<!-- /{name} -->', lambda _: text, old, flags=re.S)
if count != 1:
    sys.exit(f'{path}: expected one pair of marks <!-- {name}: ... --> and <!-- /{name} -->, found {count}')
with open(path, 'w', encoding='utf-8') as file:
    file.write(new)
