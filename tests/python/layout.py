#!/usr/bin/env python3
"""Writes a C program that fails to compile where the ctypes structures of the openbtf package differ from those of the
headers in size, members, or a member's offset and size.

    layout.py OUT.c

SPDX-License-Identifier: MIT
"""
import ctypes
import sys

from openbtf import _library as c
from openbtf import data

PAIRS = {
    "btf_log": c.Log, "btf_texture": c.Texture, "btf_material_info": c.Info, "btf_material_error": c.MaterialError,
    "btf_directions": c.Directions, "btf_shader_options": c.ShaderOptions, "btf_evaluate_options": c.EvaluateOptions,
    "btf_evaluations": c.Evaluations, "btf_range": c.Range, "btf_scene": c.Scene, "btf_cost_model": c.CostModel, "btf_plan": c.Plan,
    "btf_light_sampling": c.LightSampling, "btf_ref_sampling": c.RefSampling, "btf_ref_options": c.RefOptions,
    "btf_ref_material": c.RefMaterial, "btf_input_options": data.InputOptions, "btf_input_info": data.InputInfo,
}


def main():
    lines = ["#include <openbtf/evaluate.h>", "#include <openbtf/input.h>", "#include <openbtf/plan.h>",
             "#include <openbtf/reference.h>", "#include <openbtf/sampling.h>"]
    for name, structure in PAIRS.items():
        lines.append('_Static_assert(sizeof(%s) == %d, "%s");' % (name, ctypes.sizeof(structure), name))
        for member, *_ in structure._fields_:
            field = getattr(structure, member)
            lines.append('_Static_assert(offsetof(%s, %s) == %d && sizeof(((%s *)0)->%s) == %d, "%s.%s");' % (
                name, member, field.offset, name, member, field.size, name, member))
    with open(sys.argv[1], "w", encoding="ascii") as out:
        out.write("\n".join(lines) + "\n")


main()
