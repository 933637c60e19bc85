#!/usr/bin/env python3
"""Measured tables of the documents, from what btf-bench, btf-encode and peers.sh leave. Prints one with its marks, for
marks.py:

    tables.py codecs RUN...       of btf-bench --only codecs --preset medium, a folder a data set
    tables.py results RUN...      the same in short, for README.md
    tables.py presets FOLDER      of reports of btf-encode, DATA-EFFECTS-PRESET.json
    tables.py shaders RUN         of btf-bench --only shaders --materials bricks
    tables.py stochastic RUN...   of btf-bench --only stochastic; times are shown of data of 64 x 64 texels
    tables.py peers FILE, tables.py first FILE    of peers.sh peers, of peers.sh v1

SPDX-License-Identifier: MIT
"""
import csv
import json
import os
import re
import sys

DATA = (('BRICKS64', 'BRICKS64, path-traced bricks'), ('UBO_IMPALLA64', 'UBO IMPALLA, VQ-decoded'),
        ('bricks', '`btf-sample` bricks'), ('bumps', '`btf-sample` bumps'))
PRESETS = ('fast', 'medium', 'thorough', 'exhaustive')
SHADERS = (('paper: full', 0, 'paper, full, three views and lights'),
           ('low rank: full', 16, 'format 1: k = 16 components and every map'),
           ('low rank: residual sources', 16, 'format 1: shifted residual sources, k = 16'),
           ('low rank: residual sources', 48, 'the same, k = 48'), ('PCA, 8 bit', 98, 'PCA, 8 bit, rank 98'))


def rows_of(path):
    with open(path, encoding='utf-8') as file:
        rows = list(csv.DictReader(file))
    if not rows:
        sys.exit(f'tables.py: {path}: no rows')
    return rows


def summary_of(run):
    with open(os.path.join(run, 'summary.md'), encoding='utf-8') as file:
        return file.read()


def field(summary, key):
    """What the head of a summary has of `key`."""
    found = re.search(r'\| ' + key + r' \| (.*) \|', summary)
    if not found:
        sys.exit(f'tables.py: the summary has no "{key}"')
    return found.group(1)


def machine(run):
    summary = summary_of(run)
    return f'{field(summary, "processor")}; load {field(summary, "load before the run")} before the run'


def table(head, rows):
    def line(cells):
        return ('| ' + ' | '.join(cells) + ' |').replace('|  |', '| |').replace('|  |', '| |')
    return '\n'.join([line(head), line(['---'] * len(head))] + [line(row) for row in rows])


def pair(linear, srgb):
    return f'{float(linear):.2f} / {float(srgb):.2f}'


def best(rows, start):
    """PSNR of the rows of peers whose names start so, the best of each kind of value."""
    rows = [row for row in rows if row['kind'] == 'peer' and row['codec'].startswith(start + ',')]
    return max(float(row['linear_db']) for row in rows), max(float(row['srgb_db']) for row in rows)


def equal_bytes(runs, short):
    head = ['data, 64 x 64 texels, 81 views, 81 lights', '`--method joint`', 'best 8-bit PCA', 'half-float PCA',
            'low-bit split PCA', '`--method paper`', 'encoding, core s']
    hidden = (2, 3) if short else ()
    rows = []
    for name, label in DATA:
        found = [path for path in (f'{run}/codecs-{name}.csv' for run in runs) if os.path.exists(path)]
        if not found:
            sys.exit(f'tables.py: no run has codecs-{name}.csv')
        of = rows_of(found[0])
        ours = {row['codec']: row for row in of if row['kind'] == 'ours'}
        joint, paper = ours['joint, medium'], ours['paper: full']
        psnr = [(float(joint['linear_db']), float(joint['srgb_db'])), best(of, 'PCA 8 bit'), best(of, 'PCA half'),
                best(of, 'low-bit split PCA'), (float(paper['linear_db']), float(paper['srgb_db']))]
        first = max(range(len(psnr)), key=lambda i: sum(psnr[i]))
        rows.append([label] + [f'**{pair(*p)}**' if i == first else pair(*p) for i, p in enumerate(psnr)] +
                    [f'{float(joint["core_s"]):.0f}'])
    head, *rows = [[cell for i, cell in enumerate(row) if i not in hidden] for row in [head] + rows]
    return table(head, rows)


def codecs(*runs):
    return equal_bytes(runs, False) + f'\n\nMachine: {machine(runs[0])}.'


def results(*runs):
    return equal_bytes(runs, True)


def presets(folder):
    rows = []
    for name, label in DATA[:3]:
        for effects, words in (('all', 'every effect'), ('residual', '`--effects residual`')):
            row = [f'{label}, {words}']
            for preset in PRESETS:
                path = f'{folder}/{name}-{effects}-{preset}.json'
                if not os.path.exists(path):
                    if len(row) > 1:
                        sys.exit(f'tables.py: {path} is missing')
                    break
                with open(path, encoding='utf-8') as file:
                    report = json.load(file)
                full = report['psnr']['full']
                row.append(f'{pair(full["linear"], full["srgb"])}, {report["core_seconds"]["total"]:.0f} s')
            else:
                rows.append(row)
    if not rows:
        sys.exit(f'tables.py: {folder}: no reports')
    return table(['data, 64 x 64 texels'] + [f'`{preset}`' for preset in PRESETS], rows)


def shaders(run):
    path = f'{run}/shaders-bricks.csv'
    by = {(row['shader'], int(row['components'])): row for row in rows_of(path)}
    rows = [[label] + [f'{float(by[name, k][key]):.0f}' if float(by[name, k][key]) > 0 else ''
                       for key in ('ns', 'floor_ns', 'fast_ns')] for name, k, label in SHADERS]
    return (f'Machine: {machine(run)}.\n\n' +
            table(['shader', 'exact', 'floor', 'native `pow`, any order'], rows))


def stochastic(*runs):
    text, blends = [f'Machine: {machine(runs[0])}.'], []
    for run in runs:
        for section in re.split(r'^## stochastic: ', summary_of(run), flags=re.M)[1:]:
            name = section.split('\n', 1)[0]
            data = re.search(r'; data: (.*)\.\n', section).group(1)
            if '64x64 texels' in data:
                rows = rows_of(f'{run}/stochastic-{name}.csv')
                full = float(rows[0]['ns'])
                shown = [[row['decoded'], f'{float(row["ns"]):.0f}', f'{full / float(row["ns"]):.2f}'] +
                         [f'{float(row[key]):.4f}' if row[key] else '' for key in ('rms_1', 'rms_4', 'rms_16', 'rms_64')] +
                         [f'{float(row["rms_1"]) * (float(row["ns"]) / full) ** 0.5:.4f}' if row['rms_4'] else '']
                         for row in rows]
                mean, = re.findall(r'its mean is ([\d.]+)', section)
                off, = re.findall(r'off by ([-+\d.]+ %)', section)
                text.append(f'{data}; mean radiance {mean}. The mean over all pixels of geometric means of two picks is off '
                            f'by {off} at 64 samples:')
                text.append(table(['decoded', 'ns', 'times faster', '1', '4', '16', '64', 'in the time of one full decode'],
                                  shown))
            full_truth = re.search(r'^\| full decode \| equal \| equal \| (.*) ?\|$', section, flags=re.M).group(1).strip()
            for kind in ('blend of views', 'of views and lights'):
                between, truth = re.search(rf'^\| {kind} \| equal \| (.*?) \| (.*?) ?\|$', section, flags=re.M).groups()
                blends.append([data.split(', 81')[0], kind.replace('blend of', 'of'), between, full_truth or 'not known', truth])
    text.append('The blends that picks converge to, of whole texels; PSNR in dB, linear / sRGB-coded. At the samples they '
                'equal the full decode, bit for bit:')
    text.append(table(['data', 'blend', 'against the full decode, between the samples', 'full decode against truth',
                       'blend against truth'], blends))
    return '\n\n'.join(text)


def as_printed(path):
    with open(path, encoding='utf-8') as file:
        text = file.read().strip()
    if text.count('\n') < 2:
        sys.exit(f'tables.py: {path}: no rows')
    return text


MADE = {'codecs': codecs, 'results': results, 'presets': presets, 'shaders': shaders, 'stochastic': stochastic,
        'peers': as_printed, 'first': as_printed}


def main():
    if len(sys.argv) < 3 or sys.argv[1] not in MADE:
        sys.exit(__doc__.split('\n\n')[1])
    name = sys.argv[1]
    print(f'<!-- {name}: written by tests/bench/regenerate.sh -->\n{MADE[name](*sys.argv[2:])}\n<!-- /{name} -->')


if __name__ == '__main__':
    main()
