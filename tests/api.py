#!/usr/bin/env python3
"""Makes decoder/API.md from the public headers, and holds them to it: every public function, type, member, constant and
macro has a comment, every symbol that a library exports is in a header, and the page is that of the headers and shows
no mark of Doxygen.

    api.py SOURCE_ROOT [LIBRARY...]    prints what is wrong, a line each; exit code 1 when there is anything
    api.py SOURCE_ROOT --write         writes decoder/API.md
    api.py SOURCE_ROOT --self-test     breaks each rule in a copy, and fails where that goes unnoticed

Comments are those that Doxygen knows: /** before a declaration, /**< behind a member; @return and @p, whose name stands
on the same line. An enum without a name needs one comment for all its constants.

SPDX-License-Identifier: MIT
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile
import textwrap

PAGE = 'decoder/API.md'
FOLDER = 'decoder/include/openbtf'
FIRST = ('material', 'shader', 'gl', 'plan') # headers that the page begins with; the others follow by name
OTHERS = ['reference/include/openbtf/reference.h', 'encoder/library/include/openbtf/input.h']
COMMENT = re.compile(r'/\*.*?\*/', re.S)


def words(comment):
    """The lines of a comment without its stars."""
    text = re.sub(r'^/\*+<?|\*/$', '', comment)
    return '\n'.join(re.sub(r'^\s*\* ?', '', line).rstrip() for line in text.split('\n')).strip()


def headers_of(root):
    names = sorted(name[:-2] for name in os.listdir(os.path.join(root, FOLDER)) if name.endswith('.h'))
    names.sort(key=lambda name: FIRST.index(name) if name in FIRST else len(FIRST))
    return [f'{FOLDER}/{name}.h' for name in names] + OTHERS


class Symbol:
    """A declaration: kind (function, type, macro), name, code without comments, text, and the rows of a table of members
    or constants, each (code, text)."""

    def __init__(self, kind, name, code, text, rows=(), heads=None):
        self.kind, self.name, self.code, self.text, self.rows, self.heads = kind, name, code, text, list(rows), heads


def tidy(code):
    return re.sub(r'\s+', ' ', COMMENT.sub(' ', code)).strip()


def members(body, end):
    """(code, text) of the members of a struct or the constants of an enum: a comment counts for the declaration after it,
    or where it begins with /**< for the one before."""
    rows, before = [], ''
    for piece in re.findall(rf'/\*.*?\*/|[^{end}/]+{end}?', body, flags=re.S):
        if piece.startswith('/**<') and rows:
            rows[-1][1] = words(piece)
        elif piece.startswith('/**'):
            before = words(piece)
        elif not piece.startswith('/*') and piece.strip(f'{end} \n'):
            rows.append([tidy(piece).rstrip(end).strip(), before])
            before = ''
    return rows


def expanded(macro):
    """The constants of a macro that lists them as X(NAME, VALUE, ..., "text")."""
    rows = []
    for entry in re.findall(r'X\((\w+(?:[^()"]|"[^"]*")*)\)', macro):
        fields = re.split(r',\s*(?=(?:[^"]*"[^"]*")*[^"]*$)', entry) # commas outside of strings
        rows.append([f'{fields[0]} = {fields[1]}', ''.join(re.findall(r'"([^"]*)"', fields[-1]))])
    return rows


def aggregate(code, text, lists):
    """The symbol of a struct or an enum with a body."""
    kind, name, body = re.match(r'(?:typedef )?(struct|enum) ?(\w*) ?\{(.*)\} ?\w*;$', code, flags=re.S).groups()
    listed = re.search(r'^(\w+_LIST)\(', body, flags=re.M) or re.search(r'\b(\w+_LIST)\(', body)
    rows = lists[listed[1]] if listed else members(body, ';' if kind == 'struct' else ',')
    if not name:
        first = rows[0][0].split(' ')[0]
        shown = 'enum { ' + ', '.join(row[0] for row in rows) + ' };'
        return Symbol('constants', first, shown, text)
    heads = ('member', 'meaning') if kind == 'struct' else ('constant', 'meaning')
    return Symbol('type', name, f'typedef {kind} {name}', text, rows, heads)


def parse(source):
    """The comment at the top of a header, and its symbols in order."""
    source = re.sub(r'#ifdef __cplusplus.*?#endif', '', source, flags=re.S)
    top = COMMENT.match(source)[0]
    found, lists, text, at = [], {}, '', len(top)
    for match in iter(lambda: re.compile(
            r'\s*(?:(?P<comment>/\*.*?\*/)|(?P<macro>#(?:[^\n]*\\\n)*[^\n]*)|(?P<code>(?:[^;{/#]|/(?!\*))+'
            r'(?:\{.*?\n?\}[^;{]*)?;))', re.S).match(source, at), None):
        at = match.end()
        if match['comment']:
            text = words(match['comment']) if match['comment'].startswith('/**') else ''
            continue
        if match['macro']:
            macro = re.match(r'#\s*define (\w+)(\([^)]*\))?(.*)', match['macro'], flags=re.S)
            if macro and not macro[1].startswith('OPENBTF_'):
                value = tidy(macro[3].replace('\\\n', ' '))
                if macro[1].endswith('_LIST'):
                    lists[macro[1]], value = expanded(value), ''
                found.append(Symbol('macro', macro[1], f'#define {macro[1]}{macro[2] or ""} {value}'.strip(), text))
        else:
            code = match['code'].strip()
            if '{' in code:
                found.append(aggregate(code, text, lists))
            else:
                code = tidy(code)
                pointer = re.match(r'typedef .*\(\*(\w+)\)', code)
                plain = re.match(r'typedef .* (\w+);', code)
                name = pointer or plain or re.match(r'.*?\b(\w+)\(', code)
                found.append(Symbol('type' if pointer or plain else 'function', name[1], code, text))
        text = ''
    rest = re.sub(r'\s', '', source[at:])
    if rest:
        sys.exit(f'api.py: cannot read: {source[at:at + 80]}')
    return words(top), found


def marked(text, names, here):
    """A comment as Markdown: names as code, links to other symbols, lists and indented code as they stand."""
    text = re.sub(r'@return', 'Returns', text)
    text = re.sub(r'(: )Returns', r'\1returns', text)
    text = re.sub(r'@p (\w+)', r'`\1`', text)
    out, code, linked = [], False, {here}
    for line in text.split('\n'):
        if line.startswith('    ') and (code or not out or not out[-1]):
            code = True
            out.append(line)
            continue
        code = code and not line

        def name(match):
            if match[0] in names and match[0] not in linked:
                linked.add(match[0])
                return f'[`{match[0]}`](#{match[0].lower()})'
            return f'`{match[0]}`'

        pieces = re.split('(`[^`]*`)', line)
        for i in range(0, len(pieces), 2): # outside of code
            piece = re.sub(r'[\\*<]', r'\\\g<0>', pieces[i])
            piece = re.sub(r'(?<!\w)\\(\*out_\w+)', r'`\1`', piece) # what the pointer points to
            pieces[i] = re.sub(r'(?<![\w`*])((?:btf|BTF)_\w+|out_\w+)(?:\(\))?(?![\w`])',
                               lambda m: name(re.match(r'\w+', m[1])), piece)
        out.append(re.sub(r'^( *)\\\*', r'\1*', ''.join(pieces)))
    return '\n'.join(out)


def row_of(cells):
    return '| ' + ' | '.join(re.sub(r'\s+', ' ', cell).replace('|', '\\|') for cell in cells) + ' |'


def page(root):
    headers = [(path, *parse(open(os.path.join(root, path), encoding='utf-8').read())) for path in headers_of(root)]
    names = {s.name for _, _, found in headers for s in found}
    out = ['# The API, by header', '',
           'Made from the headers by `tests/api.py . --write`, and held to them by the tests; change the headers, not this',
           'page. [README.md](README.md) shows how the calls are used together, [FORMAT.md](FORMAT.md) has the terms, and',
           'the sections that comments name.', '']
    for path, _, found in headers:
        short = path.split('include/')[1]
        functions = [f'[`{s.name}`](#{s.name})' for s in found if s.kind == 'function']
        out += [f'- **[{short}](#{re.sub("[^a-z_]", "", short)})**: ' + ', '.join(functions)]
    for path, top, found in headers:
        short = path.split('include/')[1]
        top = re.sub(r'\n*SPDX-License-Identifier.*', '', re.sub(r'^OpenBTF[^:]*: ', '', top))
        out += ['', f'## {short}', '', marked(top[0].upper() + top[1:], names, ''), '']
        for s in found:
            out += ['', f'### {s.name}', '']
            if not s.rows:
                out += ['```c', textwrap.fill(s.code, 100, subsequent_indent='    ', break_long_words=False), '```', '']
            out += [marked(s.text, names, s.name), '']
            if s.rows:
                out += [row_of(s.heads), '| --- | --- |']
                out += [row_of([f'`{code}`', marked(text, names, s.name)]) for code, text in s.rows]
    return re.sub(r'\n{3,}', '\n\n', '\n'.join(out)).rstrip() + '\n'


def exported(library):
    text = subprocess.run(['nm', '-D', '--defined-only', library], check=True, capture_output=True, text=True).stdout
    return {line.split()[-1].split('@')[0] for line in text.split('\n') if line}


def complaints(root, libraries=()):
    found, functions = [], set()
    for path in headers_of(root):
        with open(os.path.join(root, path), encoding='utf-8') as file:
            symbols = parse(file.read())[1]
        for s in symbols:
            functions |= {s.name} if s.kind == 'function' else set()
            if not s.text:
                found.append(f'{path}: {s.name}: no comment')
            found += [f'{path}: {s.name}: {code}: no comment' for code, text in s.rows if not text]
    for library in libraries:
        found += [f'{library}: {name}: in no public header' for name in sorted(exported(library) - functions)]
    try:
        with open(os.path.join(root, PAGE), encoding='utf-8') as file:
            shown = file.read()
    except FileNotFoundError:
        shown = ''
    made = page(root)
    found += [f'{PAGE}:{number}: shows {mark}: a mark that is unknown, or whose name is on the next line of the header'
              for number, line in enumerate(made.split('\n'), 1) for mark in re.findall(r'@\w+', re.sub('`[^`]*`', '', line))]
    if shown != made:
        found.append(f'{PAGE}: is not that of the headers: run tests/api.py . --write')
    return found


def self_test(root):
    """(what is broken, file, text, its replacement)"""
    material, reference = headers_of(root)[0], OTHERS[0]
    breaks = [('a function without a comment', material, 'void btf_free(', 'void btf_other(void);\nvoid btf_free('),
              ('a type without a comment', material, '/** A material in memory.', '/* A material in memory.'),
              ('a member without a comment', material, '/**< of the SBRDF, J */', '/* of the SBRDF, J */'),
              ('a constant without a comment', material, '/**< no texture */', ''),
              ('a macro without a comment', material, '/** The most levels of detail. */', ''),
              ('constants without a comment', reference, '/** Stores of the residual. */', ''),
              ('a function of the reference without a comment', reference, 'float btf_ref_half(',
               'int btf_ref_other(void);\nfloat btf_ref_half('),
              ('another text', material, '/** The most levels of detail. */', '/** The most levels. */'),
              ('a name on the line after its mark', reference, '@p light: ', '@p\n * light: '),
              ('a mark that is unknown', reference, '@p light: ', '@a light: '),
              ('another page', PAGE, '# The API', '# An API')]
    unnoticed = 0
    for what, path, old, new in breaks:
        with tempfile.TemporaryDirectory() as folder:
            for copied in (*headers_of(root), PAGE):
                os.makedirs(os.path.join(folder, os.path.dirname(copied)), exist_ok=True)
                shutil.copy(os.path.join(root, copied), os.path.join(folder, copied))
            with open(os.path.join(folder, path), encoding='utf-8') as file:
                text = file.read()
            with open(os.path.join(folder, path), 'w', encoding='utf-8') as file:
                file.write(text.replace(old, new, 1))
            if path != PAGE and what != 'another text': # a missing comment must be reported even when the page agrees
                with open(os.path.join(folder, PAGE), 'w', encoding='utf-8') as file:
                    file.write(page(folder))
            if text.count(old) == 0 or not complaints(folder):
                print(f'api.py: not noticed: {what}')
                unnoticed += 1
    return unnoticed


def main():
    root, others = sys.argv[1], sys.argv[2:]
    if '--write' in others:
        with open(os.path.join(root, PAGE), 'w', encoding='utf-8') as file:
            file.write(page(root))
        return
    found = complaints(root, [name for name in others if not name.startswith('--')])
    for complaint in found:
        print(complaint)
    unnoticed = self_test(root) if '--self-test' in others else 0
    print(f'{len(found)} complaints, {unnoticed} breaks not noticed')
    sys.exit(1 if found or unnoticed else 0)


if __name__ == '__main__':
    main()
