/* Deliberately wrong stochastic decoders, for test_sabotage.c alone.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_CONFORMANCE_SABOTAGE_STOCHASTIC_H
#define OPENBTF_CONFORMANCE_SABOTAGE_STOCHASTIC_H

/* PICK_ALL decodes factors with relief and gloss between levels, PICK_VIEWS an SBRDF with hidden points. */
static const sabotage_of list_4[] = {
    {{"another shift of the random numbers", "", "r ^= r >> 16u;", "r ^= r >> 15u;"}, PICK_ALL},
    {{"random numbers mixed once", "", "    r.z += r.x * r.y;\n    return r;", "    return r;"}, PICK_ALL},
    {{"views picked by low bits", "", "random.x >> 20u", "random.x & 4095u"}, PICK_ALL},
    {{"lights picked by the view's number", "", "random.y >> 20u", "random.x >> 20u"}, PICK_ALL},
    {{"columns picked by the row's bits", "", "(random.z >> 24u) < btf_share",
      "((random.z >> 16u) & 255u) < btf_share"},
     PICK_ALL},
    {{"rows picked by the column's bits", "", "((random.z >> 16u) & 255u) < btf_share",
      "(random.z >> 24u) < btf_share"},
     PICK_ALL},
    {{"levels picked by the lowest bits", "", "(random.z >> 8u) & 255u", "random.z & 255u"}, PICK_ALL},
    {{"neighbours of no weight picked", "", "number < weight.x ? 0", "number <= weight.x ? 0"}, PICK_ALL},
    {{"the second neighbour's share from 0 on", "", "number < weight.x + weight.y ? 1",
      "number < weight.y ? 1"},
     PICK_ALL},
    {{"views picked before occlusion", "", "btf_relief(s.shown, s.views, s.n_views,",
      "btf_neighbours before = s.views;\n    btf_relief(s.shown, before, s.n_views,"},
     PICK_ALL},
    {{"each view shown where the first is", "", "uvec2(BTF_ELEMENT(s.shown, a)) << 10u",
      "uvec2(s.shown[0]) << 10u"},
     PICK_ALL},
    {{"gloss of the first view for all", "", "btf_set_lights(s, l, v, a);",
      "btf_set_lights(s, l, v, 0);"},
     PICK_ALL},
    {{"a picked light with its own weight", "", "(s.lights.index, b)), uvec3(4096u, 0u, 0u))",
      "(s.lights.index, b)), s.lights.weight)"},
     PICK_ALL},
    {{"the first light for all", "", "                    one.lights = s.lights;\n", ""}, PICK_ALL},
    {{"roots of one view not clamped", "", "    value = btf_radiance(value);\n",
      "    value = btf_mul(value, value);\n"},
     PICK_ALL},
    {{"lights blended in equal parts", "", "btf_view_weight(weight))", "btf_view_weight(1365u))"},
     PICK_ALL},
    {{"views blended in equal parts", "", "btf_view_weight(share))", "btf_view_weight(1365u))"}, PICK_ALL},
    {{"corners of the blend swapped", "", "right ? cu.y : cu.x, upper", "right ? cu.x : cu.y, upper"},
     PICK_ALL},
    {{"a level's share rounded to nearest", "", "floor(btf_mul(level, 256.0))",
      "floor(btf_add(btf_mul(level, 256.0), 0.5))"},
     PICK_ALL},
    {{"the last level not reached", "", "? last << 8 :", "? (last - 1) << 8 :"}, PICK_ALL},
    {{"shares of two levels swapped", "", "i > 0 ? share : 256 - share", "i > 0 ? 256 - share : share"},
     PICK_ALL},
    {{"texels filtered before the scale", "", "        value[i] = btf_scaled(value[i]);",
      "        value[i] = value[i];"},
     PICK_VIEWS},
    {{"another view shown than picked", "", "btf_component(s.views.index, a), s)", "s.views.index.x, s)"},
     PICK_VIEWS},
    {{"the light's cosine left out", "", "    btf_set_factors(s, l, v);\n#if BTF_RELIEF",
      "    btf_set_factors(s, l, v);\n    s.cosine = 1.0;\n#if BTF_RELIEF"},
     PICK_VIEWS},
};

#endif
