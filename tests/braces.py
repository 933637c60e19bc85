#!/usr/bin/env python3
"""Holds one way to write the bodies of if, else, for, while and do: in braces, also where they are one statement.

    braces.py SOURCE_ROOT               prints each body without braces, a line each; exit code 1 when there is any
    braces.py SOURCE_ROOT --write       puts braces around them (clang-format then breaks lines that became too long)
    braces.py SOURCE_ROOT --self-test   takes braces away from a few bodies in memory, and fails where that goes unnoticed

clang-format 14, which Debian 12 has, cannot do this (InsertBraces came with 15). The body of a macro is not read,
and `while (x);` may stay: it has no body to mistake.

SPDX-License-Identifier: MIT
"""
import os
import re
import sys

# Folders whose files are held to it.
FOLDERS = ('decoder', 'encoder', 'reference', 'tests')
# Files of these folders that are not held to it yet.
EXCEPT = ()

TOKEN = re.compile(r'(?P<comment>/\*.*?\*/|//(?:\\\n|[^\n])*)|(?P<line>^[ \t]*#(?:\\\n|/\*.*?\*/|[^\n])*)|'
                   r'(?P<text>R"\((?:.*?)\)"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\')|'
                   r'(?P<word>[A-Za-z_]\w*)|(?P<sign>[^\s\w])|(?P<number>\d[\w.]*)', re.S | re.M)
PAIRS = {'(': ')', '[': ']', '{': '}'}


class Body:
    """A body without braces: it follows `head`, the end of its condition, and goes to `end`; both offsets."""

    def __init__(self, keyword, head, first, end, before_else):
        self.keyword, self.head, self.first, self.end, self.before_else = keyword, head, first, end, before_else


class Reader:
    """Reads a C file statement by statement, as far as finding bodies needs it."""

    def __init__(self, text):
        self.text, self.found = text, []
        self.tokens = [(m.group(), m.start(), m.end()) for m in TOKEN.finditer(text) if not m['comment']]
        self.at = 0

    def peek(self):
        return self.tokens[self.at][0] if self.at < len(self.tokens) else None

    def skip_group(self):
        """Steps over a bracket and all up to the one that closes it."""
        depth = 0
        while True:
            token = self.tokens[self.at][0]
            depth += token in PAIRS
            depth -= token in PAIRS.values()
            self.at += 1
            if depth == 0:
                return

    def body(self, keyword):
        head = self.tokens[self.at - 1][2]
        first = self.at
        bare = self.peek() not in ('{', ';')
        self.statement()
        if bare:
            end = self.tokens[self.at - 1][2]
            self.found.append(Body(self.tokens[keyword][1], head, self.tokens[first][1], end,
                                   self.tokens[self.at][1] if self.peek() == 'else' else None))

    def statement(self):
        while self.peek().lstrip().startswith('#'):
            self.at += 1
        keyword, token = self.at, self.peek()
        if token == '{':
            self.block()
        elif token in ('try', 'catch'):
            self.at += 1
            if token == 'catch':
                self.skip_group()
            self.statement()
        elif token in ('if', 'for', 'while', 'switch'):
            self.at += 1
            self.skip_group()
            self.body(keyword)
            if token == 'if' and self.peek() == 'else':
                keyword = self.at
                self.at += 1
                if self.peek() == 'if':
                    self.statement()
                else:
                    self.body(keyword)
        elif token == 'do':
            self.at += 1
            self.body(keyword)
            self.at += 1
            self.skip_group()
            self.at += 1
        elif token in ('case', 'default') or (re.match(r'\w', token) and self.tokens[self.at + 1][0] == ':' and
                                              self.tokens[self.at + 2][0] != ':'):
            while self.peek() != ':':
                self.at += 1
            self.at += 1
            if self.peek() != '}':
                self.statement()
        else:
            while self.peek() != ';':
                if self.peek() in PAIRS:
                    self.skip_group()
                elif self.tokens[self.at - 1][0] == ')' and (self.peek() or '').lstrip()[:1] in ('}', '#'):
                    return  # a macro that stands for statements
                elif self.peek() == '}' or self.peek() is None:
                    line = self.text.count('\n', 0, self.tokens[keyword][1]) + 1
                    raise SyntaxError(f'the statement at line {line} has no end')
                else:
                    self.at += 1
            self.at += 1

    def block(self):
        self.at += 1
        while self.peek() != '}':
            if self.peek().lstrip().startswith('#'):
                self.at += 1
            else:
                self.statement()
        self.at += 1

    def read(self):
        """The bodies without braces of all functions, in the order in which they end."""
        while self.at < len(self.tokens):
            token = self.peek()
            if token == '{' and self.is_function():
                self.block()
            elif token == '{' and self.is_linkage():
                self.at += 1
            elif token in PAIRS:
                self.skip_group()
            else:
                self.at += 1
        return self.found

    def is_function(self):
        return self.tokens[self.at - 1][0] in (')', 'const', 'override', 'noexcept')

    def is_linkage(self):
        before = [t[0] for t in self.tokens[max(0, self.at - 2):self.at]]
        return before[-1:] == ['"C"'] or 'namespace' in before


def indent_of(text, at):
    line = text[text.rfind('\n', 0, at) + 1:at]
    return re.match(r'[ \t]*', line).group()


def braced(text, bodies):
    """The text with braces around the bodies."""
    edits = []  # (offset, order, length to leave out, text to put there)
    for order, body in enumerate(bodies):
        indent = indent_of(text, body.keyword)
        edits.append((body.head, 0, 0, ' {'))
        if '\n' not in text[body.head:body.first]:
            edits.append((body.first, 1, 0, '\n' + indent + '    '))
        end = body.end
        comment = re.compile(r'[ \t]*(/\*[^\n]*?\*/|//[^\n]*)(?=[ \t]*\n)').match(text, end)
        end = comment.end() if comment else end
        between = text[end:body.before_else] if body.before_else else 'no else'
        if between.strip() == '':
            edits.append((end, 2 + order, len(between), '\n' + indent + '} '))
        else:
            edits.append((end, 2 + order, 0, '\n' + indent + '}'))
    for at, _, length, new in sorted(edits, key=lambda e: (e[0], e[1]), reverse=True):
        text = text[:at] + new + text[at + length:]
    return text


def files(root):
    for folder in FOLDERS:
        for here, folders, names in os.walk(os.path.join(root, folder)):
            folders.sort()
            for name in sorted(names):
                path = os.path.relpath(os.path.join(here, name), root)
                if name.endswith(('.c', '.h', '.cc')) and path not in EXCEPT:
                    with open(os.path.join(root, path), encoding='utf-8') as file:
                        yield path, file.read()


def self_test():
    whole = 'int f(int x) {\n    if (x) {\n        return 1;\n    } else {\n        x++;\n    }\n' \
            '    for (;;) {\n        do {\n            x--;\n        } while (x);\n    }\n}\n'
    bare = 'int f(int x) {\n    if (x)\n        return 1;\n    else\n        x++;\n' \
           '    for (;;)\n        do\n            x--;\n        while (x);\n}\n'
    found = Reader(bare).read()
    good = not Reader(whole).read() and len(found) == 4 and not Reader(braced(bare, found)).read()
    print('bodies without braces are noticed' if good else 'bodies without braces are not noticed')
    return 0 if good else 1


def main():
    root = os.path.abspath(sys.argv[1])
    if sys.argv[2:] == ['--self-test']:
        sys.exit(self_test())
    count = 0
    for path, text in files(root):
        bodies = Reader(text).read()
        count += len(bodies)
        if sys.argv[2:] == ['--write'] and bodies:
            with open(os.path.join(root, path), 'w', encoding='utf-8') as file:
                file.write(braced(text, bodies))
        else:
            for body in bodies:
                line = text.count('\n', 0, body.keyword) + 1
                print(f'{path}:{line} has a body without braces')
    print(f'{count} bodies without braces')
    sys.exit(1 if count and sys.argv[2:] != ['--write'] else 0)


main()
