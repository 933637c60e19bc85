#!/usr/bin/env python3
"""Makes a library of Metal's text that a C++ compiler takes, so that run_shader can run it on the CPU.

    metal.py FOLDER OUT.cc     of the folder that `btf-shader --language msl` wrote

No Metal compiler runs on Linux. Metal's language is C++ with vectors, address spaces and textures; metal/metal_stdlib
implements as much of these as the decoder uses. A run shows that the text computes what the decoder does. It does not
show what a Metal compiler makes of it.

SPDX-License-Identifier: MIT
"""
import re
import sys

GLUE = '''
extern "C" void run_metal(const metal::texture_data *const *textures, uint32_t *records, size_t count) {
    for (size_t i = 0; i < count; i++)
        %s(*reinterpret_cast<%s *>(records), %s, metal::uint3((uint)i, 0u, 0u));
}
'''


def main(folder, out):
    with open(folder + '/decode.metal') as file:
        text = file.read()
    # The header has this array, and no address spaces to tell its operators apart.
    text, found = re.subn(r'^template<typename T, size_t Num>\nstruct spvUnsafeArray\n\{.*?^\};\n', '', text, flags=re.M | re.S)
    assert found <= 1
    # Literals are floats in Metal's language, doubles in C++.
    text = re.sub(r'(?<![\w.])(\d+\.\d*(?:[eE][-+]?\d+)?)(?![\w.])', r'\1f', text)
    head = re.search(r'^kernel void (\w+)\(device (\w+)& \w+ \[\[buffer\(0\)\]\], (.*), uint3 \w+ \[\[thread_position_in_grid\]\]\)',
                     text, re.M)
    assert head, 'decode.metal has no kernel as SPIRV-Cross writes it'
    arguments = []
    for argument in head[3].split(', '):
        kind, index = re.fullmatch(r'(texture2d(?:_array)?<\w+>) \w+ \[\[texture\((\d+)\)\]\]', argument).groups()
        arguments.append('metal::%s{textures[%s]}' % (kind, index))
    guard = re.search(r'^#ifdef (\w+_ENTRY)$', text, re.M)[1]
    with open(out, 'w') as file:
        file.write('#define %s\n' % guard + text + GLUE % (head[1], head[2], ', '.join(arguments)))


main(*sys.argv[1:])
