#!/usr/bin/env python3
"""Checks texts of btf-shader without a device.

    entry.py entry FOLDER OUT       writes a compute shader of the folder's decoder, in GLSL for Vulkan or HLSL, with an
                                    entry point that decodes records of twelve words (exported.h)
    entry.py protected FILE         fails unless every sum and product of floats is protected: in SPIR-V (.spv) by
                                    NoContraction, in HLSL by `precise`, in Metal's language (.metal) by spvFAdd and spvFMul

SPDX-License-Identifier: MIT
"""
import json
import re
import struct
import sys

GLSL = '''
layout(local_size_x = 64) in;
layout(set = 1, binding = 0, std430) buffer Records { uint words[]; };
void main() {
    uint at = 12u * gl_GlobalInvocationID.x;
    vec2 uv = uintBitsToFloat(uvec2(words[at], words[at + 1u]));
    vec3 l = uintBitsToFloat(uvec3(words[at + 2u], words[at + 3u], words[at + 4u]));
    vec3 v = uintBitsToFloat(uvec3(words[at + 5u], words[at + 6u], words[at + 7u]));
    float level = uintBitsToFloat(words[at + 8u]);
    uvec3 random = uvec3(words[at + 9u], words[at + 10u], words[at + 11u]);
    uvec3 bits = floatBitsToUint(CALL);
    for (uint i = 0u; i < 3u; ++i)
        words[at + 9u + i] = bits[i];
}
'''
HLSL = '''
RWByteAddressBuffer records : register(u0, space1);
[numthreads(64, 1, 1)]
void main(uint3 id : SV_DispatchThreadID) {
    uint at = 48u * id.x;
    float2 uv = asfloat(records.Load2(at));
    float3 l = asfloat(records.Load3(at + 8u));
    float3 v = asfloat(records.Load3(at + 20u));
    float level = asfloat(records.Load(at + 32u));
    uint3 random = records.Load3(at + 36u);
    records.Store3(at + 36u, asuint(CALL));
}
'''


def entry(folder, out):
    with open(folder + '/manifest.json') as file:
        manifest = json.load(file)
    shader, options = manifest['shader'], manifest['options']
    with open(f"{folder}/{shader['file']}") as file:
        text = file.read()
    call = (f"{options['prefix']}_evaluate_level(uv, l, v, int(level))" if options['picks'] == 'none' else
            f"{options['prefix']}_evaluate_stochastic_between(uv, l, v, level, random)")
    body = HLSL if shader['language'] == 'hlsl' else GLSL
    with open(out, 'w') as file:
        file.write(shader['head'] + '\n' + text + body.replace('CALL', call))


def unprotected_spirv(path):
    """Names of functions with float arithmetic that may be contracted: {name: how many operations}."""
    with open(path, 'rb') as file:
        data = file.read()
    words = struct.unpack(f'<{len(data) // 4}I', data)
    names, decorated, found, function, seen = {}, set(), {}, None, 0
    at = 5
    while at < len(words):
        length, op = words[at] >> 16, words[at] & 0xFFFF
        if op == 5:  # OpName
            names[words[at + 1]] = struct.pack(f'<{length - 2}I', *words[at + 2:at + length]).split(b'\0')[0].decode()
        elif op == 71 and words[at + 2] == 42:  # OpDecorate NoContraction
            decorated.add(words[at + 1])
        elif op == 54:  # OpFunction
            function = names.get(words[at + 2], '?').split('(')[0]
        elif op in (129, 131, 133, 142):  # OpFAdd, OpFSub, OpFMul, OpVectorTimesScalar
            seen += 1
            if words[at + 2] not in decorated:
                found[function] = found.get(function, 0) + 1
        at += length
    assert seen > 3, f'{path}: {seen} sums and products of floats: not a decoder'
    return found


def functions(text):
    """{name: bodies} of the functions of HLSL or of Metal's language."""
    found = {}
    for head in re.finditer(r'^(?!static inline)[\w<>, ]+ (\w+)\([^;{]*\)\n\{\n(.*?)^\}', text, re.M | re.S):
        found.setdefault(head[1], []).append(head[2])
    return found


def unprotected_text(path):
    """Faults of btf_add and btf_mul, through which all float arithmetic goes (shaders/exact.glsl)."""
    with open(path) as file:
        text = file.read()
    metal, found, faults = path.endswith('.metal'), functions(text), []
    for name, sign, helper in (('_add', '+', 'spvFAdd'), ('_mul', '*', 'spvFMul')):
        # The prefix of names is the caller's (--prefix): btf_add, stone_2_add.
        bodies = [body for other, list_of in found.items() if other.endswith(name) for body in list_of]
        if not bodies:
            faults.append(f'no {name}')
        for body in bodies:
            kept = f'{helper}(' in body and f' {sign} ' not in body if metal else \
                re.search(rf'precise float\d? \w+ = [^;]* \{sign} ', body)
            if not kept:
                faults.append(f'{name}: {" ".join(body.split())}')
    if metal and 'return fma(l, r, T(-0.0));' not in text:
        faults.append('spvFMul loses the sign of zero')
    if metal and 'return fma(T(1), l, r);' not in text:
        faults.append('spvFAdd is not as it should be')
    return faults


def protected(path):
    if path.endswith('.spv'):
        # btf_level, which chooses the level of detail, is not exact.
        faults = {name: n for name, n in unprotected_spirv(path).items() if not name.endswith('_level') or 'evaluate' in name}
    else:
        faults = unprotected_text(path)
    for fault in faults:
        print(f'{path}: not protected: {fault}')
    return bool(faults)


if __name__ == '__main__':
    if sys.argv[1] == 'entry':
        entry(*sys.argv[2:])
    else:
        sys.exit(protected(sys.argv[2]))
