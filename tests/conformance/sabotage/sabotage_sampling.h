/* Deliberately wrong light sampling, for test_sabotage.c alone.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_CONFORMANCE_SABOTAGE_SAMPLING_H
#define OPENBTF_CONFORMANCE_SABOTAGE_SAMPLING_H

/* Where sampling.glsl begins in the decoder's text. */
static const char sampling_begin[] = "float btf_unit(uint random)";

static const sabotage_of list_5[] = {
    {{"another shift of the third number", "", "h >> 16u ^ h", "h >> 15u ^ h"}, DRAWN},
    {{"wholes of 25 bits", "", "drop >= 16777216u", "drop >= 33554432u"}, DRAWN},
    {{"shares up to a half", "", "uintBitsToFloat(BTF_BITS_BEFORE_1)", "0.5"}, DRAWN},
    {{"a coefficient of the sine", "", "(BTF_SINE_3)", "(BTF_SINE_3 ^ 0x900u)"}, DRAWN},
    {{"a coefficient of the cosine", "", "(BTF_COSINE_3)", "(BTF_COSINE_3 ^ 0x900u)"}, DRAWN},
    {{"quarters turned the wrong way", "", "quarter == 2 ? -sine", "quarter == 2 ? sine"}, DRAWN},
    {{"the other half of the square kept", "", "btf_add(u1, u2) > 1.0", "btf_add(u1, u2) > 1.5"}, DRAWN},
    {{"two turns swapped", "", "height < once ? l.yzx : l.zxy", "height < once ? l.zxy : l.yzx"}, DRAWN},
    {{"edges of two lights taken for triangles", "", "n.index.x != n.index.z", "n.index.x != n.index.y"},
     DRAWN},
    {{"the last weight as it is", "", "btf_add(float(n.weight.z), -1.0)", "float(n.weight.z)"}, DRAWN},
    {{"a root of the Jacobian", "", "density = btf_mul(btf_mul(density, k), k)",
      "density = btf_mul(density, k)"},
     DRAWN},
    {{"the last light's density for the share", "", "ivec2(int(BTF_N_LIGHTS), view)",
      "ivec2(int(BTF_N_LIGHTS) - 1, view)"},
     DRAWN},
    {{"the triangles' part too large", "", "if (u1 >= end)", "if (u1 > end + 65536u)"}, DRAWN},
    {{"a search that skips", "", "low = middle + 1", "low = middle + 1 + middle % 2"}, DRAWN},
    {{"the second part begins at 0", "", "low > 0 ? btf_part_end(low - 1, view)",
      "low > 1 ? btf_part_end(low - 1, view)"},
     DRAWN},
    {{"corners of the last view's row", "", "ivec2(low, size.y - 1)", "ivec2(low, size.y - 2)"}, DRAWN},
    {{"rows of the corners for columns", "", "vec3(corners >> 16u)", "vec3(corners & 65535u)"}, DRAWN},
    {{"half of x", "", "btf_mul(x, twice), btf_mul(y, twice)", "btf_mul(x, k), btf_mul(y, twice)"}, DRAWN},
    {{"a density below the horizon", "", "if (!btf_is_above(l) || !btf_is_above(v))\n        return 0.0;",
      "if (!btf_is_above(v))\n        return 0.0;"},
     DRAWN},
    {{"drawn for a view below the horizon", "", "    if (!btf_is_above(v))\n        return l;", ""}, DRAWN},
};

#endif
