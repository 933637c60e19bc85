#!/usr/bin/env python3
"""The table of relief and gloss alone and together, made from the files that the part `relief` of regenerate.sh leaves
in a folder: reports of btf-encode, DATA-BUDGET-RELIEF.json, and the results of btf-compare for each material, by filter
and with and without gloss, and for the images themselves.

    relief_table.py FOLDER        prints what belongs between the marks `alone` of encoder/relief/RELIEF.md

SPDX-License-Identifier: MIT
"""
import json
import os
import sys
import textwrap

DATA = (('BRICKS64', 'BRICKS64'), ('bumps', '`btf-sample` bumps'))
BUDGETS = ('2.36MB', '8MB')
FILTERS = ('texel', 'bilinear', 'steep')


def read(*names):
    with open(os.path.join(sys.argv[1], '-'.join(names) + '.json'), encoding='utf-8') as file:
        return json.load(file)


def is_there(budget):
    return all(os.path.exists(os.path.join(sys.argv[1], f'{data}-{budget}-auto-steep-gloss.json')) for data, _ in DATA)


def pair(error):
    return f'{error["linear"]:.2f} / {error["srgb"]:.2f}'


def chosen(relief):
    """Returns (rings with relief, its kind) of a report, or nothing."""
    if not relief or not any(ring['relief'] for ring in relief.get('rings', ())):
        return None
    kind = [c for c in relief['candidates'] if c['candidate'] == relief['chosen']][0]
    rings = [f'{ring["theta"]:.0f}' for ring in relief['rings'] if ring['relief']]
    return f'{kind["kind"]} x {kind["scale"]:g}, rings {", ".join(rings)}'


def main():
    budgets = [budget for budget in BUDGETS if is_there(budget)]
    columns = [f'{budget.replace("MB", " MB")}: {what}' for budget in budgets
               for what in ('whole texels', 'bilinear', 'steep', 'at the samples')]
    print('<!-- alone: written by tests/bench/regenerate.sh -->')
    print('| 64 x 64 texels, encoded with | ' + ' | '.join(columns) + ' |')
    print('| --- |' + ' --- |' * len(columns))
    choices, blended = [], []
    for data, label in DATA:
        blended.append(f'{label} {pair(read(data, "images")["between"])}')
        for relief, gloss, what in (('off', 'relief', 'neither'), ('auto', 'relief', 'relief'), ('off', 'gloss', 'gloss'),
                                    ('auto', 'gloss', 'both')):
            cells = []
            for budget in budgets:
                report = read(data, budget, relief)
                moved, quarters = chosen(report['relief']), report['relief'].get('gloss', 0)
                for by in FILTERS:
                    # Without relief the filters read the same texels.
                    cells.append(pair(read(data, budget, relief, by, gloss)['between']) if by == 'texel' or moved else '')
                cells.append(pair(report['psnr']['full']))
            print(f'| {label}, {what} | ' + ' | '.join(cells).replace('|  |', '| |').replace('|  |', '| |') + ' |')
        choices.append(f'{label}: {moved or "no relief"}; gloss {f"{quarters}/4" if quarters else "none"}')
    words = f'The images themselves, blended: {", ".join(blended)}. Taken: {". ".join(choices)}.'
    print('\n' + textwrap.fill(words, 119, break_on_hyphens=False))
    print('<!-- /alone -->')


main()
