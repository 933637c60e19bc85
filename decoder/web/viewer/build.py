#!/usr/bin/env python3
"""Puts the viewer into one HTML file: build.py OUT --built FOLDER --materials FOLDER [--gallery] [--version TEXT]

OUT opens from anywhere, also from file://, and asks for nothing else. Needs esbuild, which bundles the scripts.

    --built FOLDER      has openbtf.wasm and NOTICES.txt, which ../wasm/build.sh wrote
    --materials FOLDER  has materials.json, a list of {"name": short, "title":, "about":, "file": NAME.btf.exr, "still":
                        NAME.png, "view": what its link shows}; files are beside it. samples.sh writes such a folder
    --gallery           all materials go in, with cards to choose one; else the first alone
    --depfile FILE      gets what was read, for ninja

Prints the size of OUT and of its gzip. Exits 2 with a message where something is missing.

SPDX-License-Identifier: MIT
"""
import argparse
import base64
import gzip
import hashlib
import html
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))


def fail(message):
    print(f'build.py: {message}', file=sys.stderr)
    sys.exit(2)


def read(path, mode='rb'):
    try:
        with open(path, mode, **({} if 'b' in mode else {'encoding': 'utf-8'})) as file:
            return file.read()
    except OSError as error:
        return fail(f'{path}: {error.strerror}')


def base64_text(data):
    return base64.b64encode(data).decode('ascii')


def bundle():
    """All scripts as one, without what only people read."""
    if not shutil.which('esbuild'):
        fail('esbuild is missing: apt-get install esbuild')
    made = subprocess.run(['esbuild', os.path.join(HERE, 'main.js'), '--bundle', '--minify', '--format=esm', '--target=es2022',
                           '--charset=utf8', '--legal-comments=none', '--log-level=warning'], capture_output=True, text=True, check=False)
    if made.returncode or made.stderr:
        fail(made.stderr.strip() or 'esbuild failed')
    text = made.stdout.strip()
    if '</script' in text.lower() or '<!--' in text:
        fail('the script would end its element')
    return text


def minified(style):
    """A style sheet without comments and line breaks."""
    return re.sub(r'\s*\n\s*', '\n', re.sub(r'/\*.*?\*/', '', style, flags=re.S)).strip()


def policy(script, style):
    """The Content-Security-Policy, by which the page may run its own script and style, compile the module, show and save pictures, and reach nothing."""
    def digest(text):
        return "'sha256-" + base64_text(hashlib.sha256(text.encode()).digest()) + "'"
    return (f"default-src 'none'; script-src {digest(script)} 'wasm-unsafe-eval'; style-src {digest(style)}; "
            "img-src data: blob:; base-uri 'none'; form-action 'none'")


def material_element(folder, material):
    names = {'data-material': material['name'], 'data-title': material['title'], 'data-about': material['about']}
    attributes = ' '.join(f'{key}="{html.escape(value)}"' for key, value in names.items())
    return f'<script type="application/octet-stream" {attributes}>{base64_text(read(os.path.join(folder, material["file"])))}</script>'


def gallery(folder, materials):
    """The cards, which are links to the same page."""
    cards = []
    for material in materials:
        still = f'data:image/png;base64,{base64_text(read(os.path.join(folder, material["still"])))}'
        link = html.escape(f'#material={material["name"]}&{material.get("view", "")}'.rstrip('&'))
        cards.append(f'<li><a href="{link}"><img src="{still}" alt="" width="400" height="300">'
                     f'<h3>{html.escape(material["title"])}</h3><p>{html.escape(material["about"])}</p></a></li>')
    return ('<section id="gallery" aria-labelledby="gallery-title" hidden><div><h2 id="gallery-title">Materials in OpenBTF</h2>'
            '<p>Each is a surface under every view and every light, encoded into one file and decoded in your browser. '
            'Pick one to turn it, to light it and to take it apart.</p>'
            f'<ul>{"".join(cards)}</ul></div><button type="button" id="gallery-close">Close</button></section>')


def arguments():
    parser = argparse.ArgumentParser(usage=__doc__, add_help=True)
    parser.add_argument('out')
    parser.add_argument('--built', required=True)
    parser.add_argument('--materials', required=True)
    parser.add_argument('--gallery', action='store_true')
    parser.add_argument('--version', default='')
    parser.add_argument('--depfile')
    return parser.parse_args()


def write(path, data):
    """Beside the file first, so that it is whole or as it was."""
    with tempfile.NamedTemporaryFile(dir=os.path.dirname(os.path.abspath(path)), delete=False) as file:
        file.write(data)
    os.chmod(file.name, 0o644)
    os.replace(file.name, path)


def main():
    options = arguments()
    script, style = bundle(), minified(read(os.path.join(HERE, 'style.css'), 'r'))
    materials = json.loads(read(os.path.join(options.materials, 'materials.json'), 'r'))
    if not options.gallery:
        materials = materials[:1]
    parts = {
        'policy': policy(script, style), 'style': style, 'script': script, 'version': html.escape(options.version),
        'title': 'OpenBTF gallery' if options.gallery else 'OpenBTF viewer',
        'module': base64_text(gzip.compress(read(os.path.join(options.built, 'openbtf.wasm')), 9, mtime=0)),
        'notices': html.escape(read(os.path.join(options.built, 'NOTICES.txt'), 'r')),
        'materials': '\n'.join(material_element(options.materials, material) for material in materials),
        'gallery': gallery(options.materials, materials) if options.gallery else '',
        'gallery-button': '<button type="button" id="gallery-open">Gallery</button>' if options.gallery else '',
    }
    template = read(os.path.join(HERE, 'index.html'), 'r')
    page = re.sub(r'\{\{([\w-]+)\}\}', lambda name: parts[name.group(1)], template).encode()
    write(options.out, page)
    if options.depfile:
        read_files = [os.path.join(folder, name) for folder in (HERE, os.path.join(HERE, '../openbtf')) for name in os.listdir(folder)
                      if name.endswith(('.js', '.css', '.html', '.py'))]
        with open(options.depfile, 'w', encoding='utf-8') as file:
            file.write(f'{options.out}: {" ".join(sorted(os.path.realpath(name) for name in read_files))}\n')
    print(f'{os.path.basename(options.out)}: {len(page)} bytes, {len(gzip.compress(page, 9))} as gzip')


if __name__ == '__main__':
    main()
