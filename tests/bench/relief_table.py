#!/usr/bin/env python3
"""The table of relief and gloss alone and together, from what part relief of regenerate.sh leaves in a folder: reports of
btf-encode, DATA-BUDGET-RELIEF-GLOSS.json, what btf-compare says of each material by filter, and of the images themselves.

    relief_table.py FOLDER        prints what belongs between the marks `alone` of encoder/relief/RELIEF.md

SPDX-License-Identifier: MIT
"""
import json
import os
import sys

DATA = (('BRICKS64', 'BRICKS64'), ('bumps', '`btf-sample` bumps'))
BUDGETS = (('2.36MB', '2.36 MB'), ('8MB', '8 MB'))
FILTERS = ('texel', 'bilinear', 'steep')


def read(*names):
    with open(os.path.join(sys.argv[1], '-'.join(names) + '.json'), encoding='utf-8') as file:
        return json.load(file)


def pair(error):
    return f'{error["linear"]:.2f} / {error["srgb"]:.2f}'


def chosen(relief):
    """(rings with relief, what it is) of a report, or nothing."""
    if not relief or not any(ring['relief'] for ring in relief.get('rings', ())):
        return None
    kind = [c for c in relief['candidates'] if c['candidate'] == relief['chosen']][0]
    rings = [f'{ring["theta"]:.0f}' for ring in relief['rings'] if ring['relief']]
    return f'{kind["kind"]} x {kind["scale"]:g}, rings {", ".join(rings)}'


def main():
    columns = [f'{label}: {what}' for _, label in BUDGETS
               for what in ('whole texels', 'bilinear', 'steep', 'at the samples')]
    print('<!-- alone: written by tests/bench/regenerate.sh -->')
    print('| 64 x 64 texels, encoded with | ' + ' | '.join(columns) + ' |')
    print('| --- |' + ' --- |' * len(columns))
    choices = []
    for data, label in DATA:
        images = read(data, 'images')['between']
        print(f'| {label}, the images themselves, blended | | | | | {pair(images)} | | | |')
        for relief, gloss, what in (('off', 'off', 'neither'), ('auto', 'off', 'relief'), ('off', 'auto', 'gloss'),
                                    ('auto', 'auto', 'both')):
            cells, none = [], False
            for budget, _ in BUDGETS:
                name = (data, budget, relief, gloss)
                report = read(*name)
                moved = chosen(report['relief'])
                for k, by in enumerate(FILTERS):
                    # Without relief the filters read the same texels.
                    cells.append(pair(read(*name, by)['between']) if k == 0 or moved else '')
                cells.append(pair(report['psnr']['full']))
                if what == 'both' and budget == BUDGETS[0][0]:
                    quarters = (report['relief'] or {}).get('gloss', 0)
                    choices.append(f'{label}: {moved or "no relief"}; gloss {quarters}/4')
                if what == 'gloss':
                    none = none or not (report['relief'] or {}).get('gloss', 0)
            print(f'| {label}, {what}{", of which none is taken" if none else ""} | ' + ' | '.join(cells) + ' |')
    print('\nTaken with both: ' + '. '.join(choices) + '.')
    print('<!-- /alone -->')


main()
