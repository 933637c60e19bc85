/* Shows that the conformance checks can fail: they must find a difference in each deliberately wrong decoder below.
 *
 * SPDX-License-Identifier: MIT
 */
#include "tests/conformance/check.h"
#include "tests/conformance/synthetic.h"
#include "tests/support/messages.h"
#include "tests/support/test.h"
#include "tamper.h"

/* The fault's name, where it must show ("" where only radiance can), and the change to the decoder's text.
 */
typedef struct sabotage {
    const char *name, *step, *from, *to;
} sabotage;

static const sabotage list[] = {
    {"one coordinate bit lost", "coordinate", "& (BTF_PERIOD - 1u)) * size", "& (BTF_PERIOD - 2u)) * size"},
    {"truncated, not floored", "coordinate", "floor(btf_mul(usable", "trunc(btf_mul(usable"},
    {"coordinates to 8192", "coordinate", "magnitude <= BTF_BITS_4096", "magnitude <= 0x46000000u"},
    {"bilinear starts a quarter texel earlier", "bilinear", "t - BTF_PERIOD / 2u", "t - BTF_PERIOD / 4u"},
    {"bilinear does not wrap left", "bilinear", "s += size << BTF_BELOW_TEXEL", "s += 0u"},
    {"bilinear does not wrap right", "bilinear", "c1 == size ? 0u : c1", "c1"},
    {"bilinear weight of 128ths", "bilinear", "(s >> (BTF_BELOW_TEXEL - 8u)) & 255u",
     "(s >> (BTF_BELOW_TEXEL - 7u)) & 255u"},
    {"wrap off by one", "wrap", "p >= int(size) ? int(size) : 0", "p > int(size) ? int(size) : 0"},
    {"wrap of negatives by %", "wrap", "uint(p + int(128u * size)) % size", "uint(abs(p)) % size"},
    {"projection rounds down", "project", "btf_mul(btf_mul(d.x, k), 8192.0), 0.5)",
     "btf_mul(btf_mul(d.x, k), 8192.0), 0.0)"},
    {"projection of the axes swapped", "project", "vec2(x, y)", "vec2(y, x)"},
    {"inner edges of triangles belong to none", "views", "min(e0, min(e1, e2)) >= 0",
     "min(e0, min(e1, e2)) > 0"},
    {"weights of two corners swapped", "views", "uvec3(w0, w1, 4096u - w0 - w1)",
     "uvec3(w1, w0, 4096u - w0 - w1)"},
    {"weights not taken down to 19 bits", "views", "uint(part >> drop) << 12u, uint(whole >> drop)",
     "uint(part) << 12u, uint(whole)"},
    {"quotient not corrected", "views", "r < 0 ? q - 1u : (r >= int(d) ? q + 1u : q)", "q + 1u"},
    {"edges accept the wrong side", "lights", "btf_cross(b - a, q - a) <= 0",
     "btf_cross(b - a, q - a) >= 0"},
    {"corner cones left out", "lights", "t >= n && btf_dot(q - b, c - b) <= 0", "t > n + 1 && t < n"},
    {"low bytes of two indices alone", "views", "uvec3(btf_table(table, record + 2u).xy, more.z)",
     "uvec3(btf_table(table, record + 2u).xy & 255u, more.z)"},
    {"low byte of the third index alone", "views", "record + 2u).xy, more.z)",
     "record + 2u).xy, more.z & 255u)"},
    {"12 bits of an index", "lights", "btf_table(table, record + 2u).xyx",
     "btf_table(table, record + 2u).xyx & 4095u"},
    {"indices of an edge swapped", "lights", "btf_table(table, record + 2u).xyx",
     "btf_table(table, record + 2u).yxy"},
    {"an edge's begin for its end", "lights", "btf_table(table, record + 2u).yyy",
     "btf_table(table, record + 2u).xxx"},
    {"indices of the next record", "views", "record + 2u", "record + 5u"},
    {"records of two texels", "views", "i < cell.y; ++i, record += 3u", "i < cell.y; ++i, record += 2u"},
    {"cells begin at records of two texels", "views", "grid * grid + 3u * cell.x",
     "grid * grid + 2u * cell.x"},
    {"the edge bit read from the shift", "lights", "(more.w & 1u) != 0u", "(more.w & 2u) != 0u"},
    {"cells of the grid transposed", "lights", "at.y * grid + at.x", "at.x * grid + at.y"},
    {"the last of equals is nearest", "views", "n.weight.y > weight", "n.weight.y >= weight"},
    {"tiles off by one column", "tile", "(tile - row * columns) * BTF_WIDTH",
     "(tile - row * columns + 1u) * BTF_WIDTH"},
    {"rows and columns of tiles swapped", "tile", "row * BTF_HEIGHT) + x", "row * BTF_HEIGHT) + x.yx"},
    {"one narrow band too few", "centre", "(BTF_HEIGHT + BTF_N_LIGHTS - 1u) / BTF_N_LIGHTS",
     "(BTF_HEIGHT - 1u) / BTF_N_LIGHTS"},
    {"bands off by one", "centre", "band = narrow + full", "band = narrow + full + 1u"},
    {"narrow bands begin at the left", "centre", "column = left + (centre", "column = (centre"},
    {"a light off by one row", "centre", "top + band * BTF_N_LIGHTS + light",
     "top + band * BTF_N_LIGHTS + light + 1u"},
    {"blocks of centres off by one", "centre", "uvec2(block * BTF_N_LIGHTS + light", "uvec2(block + light"},
    {"bytes of the index swapped", "index", "codes.y + 256u * codes.z", "codes.z + 256u * codes.y"},
    {"index of 255s", "index", "256u * codes.z", "255u * codes.z"},
    {"unsigned shift", "source", "int(b ^ 128u) - 128", "int(b)"},
    {"sign and magnitude shift", "source", "int(b ^ 128u) - 128", "(b < 128u ? int(b) : 128 - int(b))"},
    {"shift bytes swapped", "source", "btf_wrap(x.x, btf_shift_of(codes.y)",
     "btf_wrap(x.x, btf_shift_of(codes.z)"},
    {"wrap at the other side's size", "source", "btf_shift_of(codes.z), size.y",
     "btf_shift_of(codes.z), size.x"},
    {"wrap at the size of level 0", "source", "uvec2 size = btf_size(level);\n    return",
     "uvec2 size = btf_size(0);\n    return"},
    {"levels rounded up", "source", "max(BTF_WIDTH >> level, 1u)",
     "(BTF_WIDTH + (1u << level) - 1u) >> level"},
    {"levels of no texels", "", "max(BTF_WIDTH >> level, 1u), max(BTF_HEIGHT >> level, 1u)",
     "BTF_WIDTH >> level, BTF_HEIGHT >> level"},
    {"gain of level 0", "codes", "texelFetch(btf_gain, ivec3(x, view), level)",
     "texelFetch(btf_gain, ivec3(x, view), 0)"},
    {"shift of level 0", "codes", "texelFetch(btf_shift, ivec3(x, view), level)",
     "texelFetch(btf_shift, ivec3(x, view), 0)"},
    {"shadow of level 0", "shadow", "texelFetch(btf_shadow, ivec3(x, light), level)",
     "texelFetch(btf_shadow, ivec3(x, light), 0)"},
    {"parameters of level 0", "", "texelFetch(btf_sbrdf, ivec3(x, layer), level)",
     "texelFetch(btf_sbrdf, ivec3(x, layer), 0)"},
    {"residual of level 0", "", "texelFetch(btf_residual_texels, ivec3(x[i], g), level)",
     "texelFetch(btf_residual_texels, ivec3(x[i], g), 0)"},
    {"a level off by one", "", "clamp(level, 0, int(BTF_LEVELS) - 1)",
     "clamp(level + 1, 0, int(BTF_LEVELS) - 1)"},
    {"the last level not reached", "", "clamp(level, 0, int(BTF_LEVELS) - 1)",
     "clamp(level, 0, int(BTF_LEVELS) - 2)"},
    {"levels not clamped", "", "clamp(level, 0, int(BTF_LEVELS) - 1)", "level"},
    {"shift channels of the atlas swapped", "codes", "btf_tile(view, x)), 0).yzw",
     "btf_tile(view, x)), 0).ywz"},
    {"shadow read from the gain", "shadow", "btf_tile(light, x)), 0).x", "btf_tile(light, x)), 0).y"},
    {"a log2 coefficient off by one bit", "arithmetic", "0x3E92CDF0u", "0x3E92CDF1u"},
    {"an exp2 coefficient off by one bit", "arithmetic", "0x3C1D94D9u", "0x3C1D94D8u"},
    {"three Newton steps", "arithmetic", "i < 4; ++i)\n        r = btf_mul",
     "i < 2; ++i)\n        r = btf_mul"},
    {"pow cut at 2^-59", "arithmetic", "t < -60.0 ? 0.0", "t < -59.0 ? 0.0"},
    {"bilinear corners swapped", "", "x[1] = uvec2(cu.y", "x[1] = uvec2(cu.x"},
    {"image upside down", "", "size.y - 1u - (tv >> 18u)", "(tv >> 18u)"},
    {"image upside down, bilinear", "", "rows - 1u - cv.x", "cv.x"},
    {"lobe summed in another order", "",
     "btf_add(btf_add(btf_mul(c.x, p.x), btf_mul(c.y, p.y)), btf_mul(c.z, p.z))",
     "btf_add(btf_mul(c.x, p.x), btf_add(btf_mul(c.y, p.y), btf_mul(c.z, p.z)))"},
    {"exponent of the first lobe", "", "return btf_pow(b, c.w);", "return btf_pow(b, c.w + 0.0001);"},
    {"RGB weights off by one", "", "BTF_CHANNEL(5 + 3 * j)", "BTF_CHANNEL(4 + 3 * j)"},
    {"shadow of the first light alone", "", "t += lights.weight[b] * btf_shadow_code(x, lights.index[b]",
     "t += lights.weight[b] * btf_shadow_code(x, lights.index[0]"},
    {"parameters of the texel, not of its source", "", "btf_source_radiance(source[i]",
     "btf_source_radiance(x[i]"},
    {"residual of the texel, not of its source", "", "btf_residual(residual, source",
     "btf_residual(residual, x"},
    {"centres not companded", "", "#else\n    return btf_mul(y, y);", "#else\n    return y;"},
    {"residual channels off by one", "", "btf_direction_components(lights.index[b], view, 3 * g + 1)",
     "btf_direction_components(lights.index[b], view, 3 * g)"},
    {"residual of the last group whole", "", "BTF_COMPONENTS % 4, x, view", "4, x, view"},
    {"residual of views and lights swapped", "", "ivec3(int(light), int(view), layer)",
     "ivec3(int(view), int(light), layer)"},
    {"no cosine", "", "y = btf_mul(y, s.cosine);", ""},
    {"cosine not rooted", "", "s.cosine = btf_pow(l.z, 0.5);", "s.cosine = l.z;"},
    {"gain of hidden code 0 applied", "", "if (gain != 0u)\n", ""},
    {"views blended before the square", "", "y = btf_mul(y, y);\n#endif\n    return y;",
     "#endif\n    return y;"},
    {"negative radiance kept", "", "y >= uintBitsToFloat(BTF_BITS_2_TO_MINUS_30) ? min(y, 4294967296.0) : 0.0",
     "min(y, 4294967296.0)"},
    {"no upper bound", "", "min(y, 4294967296.0)", "y"},
    {"view weights of 4095ths", "", "btf_mul(float(weight), uintBitsToFloat(BTF_BITS_2_TO_MINUS_12))",
     "btf_mul(float(weight), uintBitsToFloat(0x39800801u))"},
    {"light below the horizon", "", "floatBitsToInt(d.z) >= int(BTF_BITS_2_TO_MINUS_24)",
     "floatBitsToInt(d.z) >= 0x33000000"},
    {"long vectors accepted", "", "most <= BTF_BITS_2", "most <= 0x7F000000u"},
};

/* Wrong decoders of version 2, each with the subject that shows its fault. */
enum {
    MIXED = 4,
    PACKED = 5,
    BOUNDS = 6,
    POINTS = 7,
    LISTS = 8,
    RELIEF = 9,
    STEEP = 10,
    GLOSS = 11,
    PICK_ALL = 12,
    PICK_VIEWS = 13,
    ENDING = 14,
    DRAWN = 15
};
typedef struct sabotage_of {
    sabotage fault;
    int subject;
} sabotage_of;

static const sabotage_of list_2[] = {
    {{"sums of u left out of words", "", "ivec4(t + start)", "ivec4(t + 0x8000u)"}, MIXED},
    {{"sums of u left out of units", "", "(pair.x + pair.y) + start.x", "(pair.x + pair.y) + 0x8000u"},
     PACKED},
    {{"sums of u of the first word for all", "", "sum.x += sum.y;", "sum.x += 0u;"}, PACKED},
    {{"borrows of lower fields kept in words", "", "BTF_HALF_TOP_OF_16;", "0u;"}, MIXED},
    {{"borrows of lower fields kept in units", "", "BTF_HALF_TOP_OF_16;", "0u;"}, PACKED},
    {{"borrows of lower fields kept in 8 bits", "", "BTF_HALF_TOP_OF_8;", "0u;"}, PACKED},
    {{"four words of class 1 in one field", "", "if (c == 1) {\n        ivec2 pairs",
      "if (c == 9) {\n        ivec2 pairs"},
     BOUNDS},
    {{"dot products without a sign", "", "ivec4(t + start) >> (c == 0 ? 0 : (c == 4 ? 24 : 16))",
      "ivec4((t + start) >> (c == 0 ? 0u : (c == 4 ? 24u : 16u)))"},
     MIXED},
    {{"sums of words rounded to zero", "", "vec4(e[i] >> shift)", "vec4(e[i] / (1 << shift))"}, MIXED},
    {{"sums of units rounded to zero", "", "vec4(e[i] >> shift)", "vec4(e[i] / (1 << shift))"}, BOUNDS},
    {{"bytes without a sign", "", "uvec4(ivec4(w << uint(24 - 8 * s)) >> 24)",
      "(w << uint(24 - 8 * s)) >> 24u"},
     MIXED},
    {{"texels of u swapped", "", "s < of_texel ? texel : next", "s < of_texel ? next : texel"}, MIXED},
    {{"the second texel of u not fetched", "", "layer + 1), level)", "layer), level)"}, MIXED},
    {{"one layer of u a unit", "", "ivec2(1, c == 1 || c == 3 ? 2 : 1)", "ivec2(1, 1)"}, PACKED},
    {{"u of level 0", "", "ivec3(ivec2(x), layer), level)", "ivec3(ivec2(x), layer), 0)"}, PACKED},
    {{"a mixed unit taken for a whole one", "", "(BTF_FACTOR_C1_2 + BTF_FACTOR_C2_2 + 3) / 4",
      "(BTF_FACTOR_C1_2 + BTF_FACTOR_C2_2) / 4"},
     PACKED},
    {{"C1 and C2 swapped", "", "word < c1 ? vec3(0.0, y[k], 0.0)", "word >= c1 ? vec3(0.0, y[k], 0.0)"},
     MIXED},
    {{"a word of Y taken for colour", "", "word >= c2", "word > c2"}, MIXED},
    {{"the scale of the first word for all", "", "ivec2(first.x, 0), 0), power)",
      "ivec2(first.x, 0), 0).xxxx, power)"},
     MIXED},
    {{"factors of another tier", "", "ivec2(tier, int(at.views[a]))",
      "ivec2(1 - (tier & 1), int(at.views[a]))"},
     MIXED},
    {{"C2 once in green", "", "-btf_add(c2, c2)", "-c2"}, MIXED},
    {{"colours summed in another order", "", "btf_add(btf_add(y, c1), c2)", "btf_add(y, btf_add(c1, c2))"},
     MIXED},
    {{"w of views and lights swapped", "", "ivec3(int(lights.index[b]), int(view), unit)",
      "ivec3(int(view), int(lights.index[b]), unit)"},
     MIXED},
    {{"sums of views not turned", "", "            btf_factor_turn(p, at.n_views);", ""}, MIXED},
    {{"u of the first texel for all", "", "at.x[i], first.y", "at.x[0], first.y"}, PACKED},
    {{"codes of 2 bits read as of 4", "", "int bits = c < 3 ? 4 : 2;", "int bits = 4;"}, PACKED},
    {{"factors of the texel, not of its source", "", "btf_factor_scene(source, ", "btf_factor_scene(x, "},
     BOUNDS},
    {{"factors do not fade out", "", "residual = btf_mul(residual, s.horizon);", ""}, MIXED},
    {{"the horizon not rooted", "", "s.horizon = btf_pow(q, 0.5);", "s.horizon = q;"}, BOUNDS},
    {{"factors under the cosine", "", "residual = btf_mul(residual, s.horizon);",
      "residual = btf_mul(residual, s.cosine);"},
     MIXED},
    {{"roots clamped in each view", "", "return clamp(y, vec3(-4294967296.0),",
      "return clamp(y, vec3(0.0),"},
     BOUNDS},
    {{"centres squared among roots", "", "#if BTF_BLEND_ROOTS\n    return y;", "#if 0\n    return y;"},
     BOUNDS},
    {{"a sum of roots not clamped", "", "#if BTF_BLEND_ROOTS\n        sum[i] = btf_radiance(sum[i]);",
      "#if BTF_BLEND_ROOTS\n        sum[i] = btf_mul(sum[i], sum[i]);"},
     BOUNDS},
    {{"bytes of a point swapped", "codes", "bytes.x + 256u * bytes.y", "bytes.y + 256u * bytes.x"}, POINTS},
    {{"columns and rows of a point swapped", "codes", "point & 63u, (point >> 6u) & 63u",
      "(point >> 6u) & 63u, point & 63u"},
     POINTS},
    {{"rows of a point of 5 bits", "codes", "(point >> 6u) & 63u", "(point >> 6u) & 31u"}, POINTS},
    {{"gains of a point of 3 bits", "codes", "point >> 12u", "(point >> 12u) & 7u"}, POINTS},
    {{"points of another view", "codes", "btf_points, ivec3(x, view)", "btf_points, ivec3(x, view ^ 1u)"},
     POINTS},
    {{"points of level 0", "codes", "btf_points, ivec3(x, view), level)", "btf_points, ivec3(x, view), 0)"},
     POINTS},
    {{"shifts of points from -31", "source", "int(code) - 32", "int(code) - 31"}, POINTS},
    {{"shifts of points in two's complement", "source", "int(code) - 32", "int(code ^ 32u) - 32"}, POINTS},
    {{"gains without the base", "", "btf_add(BTF_GAIN_BASE, btf_mul(float(gain), BTF_GAIN_STEP))",
      "btf_mul(float(gain), BTF_GAIN_STEP)"},
     POINTS},
    {{"base and step of the gains swapped", "",
      "btf_add(BTF_GAIN_BASE, btf_mul(float(gain), BTF_GAIN_STEP))",
      "btf_add(BTF_GAIN_STEP, btf_mul(float(gain), BTF_GAIN_BASE))"},
     POINTS},
    {{"gains multiplied apart", "",
      "btf_mul(y, btf_add(BTF_GAIN_BASE, btf_mul(float(gain), BTF_GAIN_STEP)))",
      "btf_add(btf_mul(y, BTF_GAIN_BASE), btf_mul(y, btf_mul(float(gain), BTF_GAIN_STEP)))"},
     POINTS},
    {{"no gain of code 0", "",
      "#if BTF_POINTS\n    y =", "#if BTF_POINTS\n    if (gain > 0u)\n        y ="},
     POINTS},
    {{"indices of a view each", "codes", "ivec3(x, view >> 1u)", "ivec3(x, view)"}, LISTS},
    {{"indices of neighbouring views swapped", "codes", "((view & 1u) << 2u)", "((~view & 1u) << 2u)"},
     LISTS},
    {{"indices of 3 bits", "codes", "<< 2u)) & 15u", "<< 2u)) & 7u"}, LISTS},
    {{"indices of level 0", "codes", "view >> 1u), level)", "view >> 1u), 0)"}, LISTS},
    {{"entries of level 0", "codes", "ivec3(x, entry), level)", "ivec3(x, entry), 0)"}, LISTS},
};
#include "sabotage_between.h"
#include "sabotage_stochastic.h"
#include "sabotage_sampling.h"
enum {
    SABOTAGES = sizeof list / sizeof *list,
    SABOTAGES_2 = sizeof list_2 / sizeof *list_2,
    SABOTAGES_3 = sizeof list_3 / sizeof *list_3,
    SABOTAGES_4 = sizeof list_4 / sizeof *list_4,
    SABOTAGES_5 = sizeof list_5 / sizeof *list_5
};

/* Materials that together use every line of the decoder. The first shows most of the faults, so that few shaders of the
 * others have to be compiled. */
static const struct {
    synthetic_spec spec;
    btf_shader_options shader;
/* clang-format off */
} subjects[] = {
    {{.seed = 14, .width = 11, .height = 5, .n_views = 7, .n_lights = 9, .layout = BTF_LAYOUT_TIGHT,
     .domain = BTF_DOMAIN_SQRT, .colour = BTF_COLOUR_MONO, .lobes = 1, .effects = BTF_EFFECT_VERSION_1,
     .components = 4, .centres = 40, .directions = SYNTHETIC_RANDOM, .levels = 4}, {0}},
    {{.seed = 11, .width = 31, .height = 29, .n_views = 81, .n_lights = 13, .layout = BTF_LAYOUT_PAPER,
     .colour = BTF_COLOUR_MONO, .lobes = 3,
     .effects = BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN, .centres = 6000,
     .directions = SYNTHETIC_RANDOM}, {0}},
    {{.seed = 12, .width = 131, .height = 9, .n_views = 19, .n_lights = 37, .layout = BTF_LAYOUT_TIGHT,
     .domain = BTF_DOMAIN_SQRT, .colour = BTF_COLOUR_RGB, .lobes = 2, .effects = BTF_EFFECT_VERSION_1,
     .components = 6, .centres = 5000, .directions = SYNTHETIC_RINGS, .values = SYNTHETIC_EXTREME},
     {.filter = BTF_FILTER_BILINEAR, .components = 5}},
    {{.seed = 13, .width = 5, .height = 3, .n_views = 2, .n_lights = 81, .layout = BTF_LAYOUT_TIGHT,
     .domain = BTF_DOMAIN_SQRT, .colour = BTF_COLOUR_MONO, .lobes = 1,
     .effects = BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN | BTF_EFFECT_GAIN, .centres = 5000,
     .directions = SYNTHETIC_COLLINEAR}, {.interpolation = BTF_INTERPOLATION_NEAREST,
     .leave_out = BTF_EFFECT_HIDDEN}},
    [MIXED] = {{.seed = 15, .width = 11, .height = 5, .n_views = 7, .n_lights = 9,
     .layout = BTF_LAYOUT_TIGHT, .colour = BTF_COLOUR_NONE, .effects = BTF_EFFECT_RESIDUAL, .components = 3,
     .directions = SYNTHETIC_RANDOM, .classes = {{1, 1, 2}, {2, 2, 3}}, .horizon_scale = 3}, {0}},
    [PACKED] = {{.seed = 16, .width = 11, .height = 6, .n_views = 7, .n_lights = 9,
     .layout = BTF_LAYOUT_TIGHT, .domain = BTF_DOMAIN_SQRT, .colour = BTF_COLOUR_NONE,
     .effects = BTF_EFFECT_RESIDUAL, .components = 6, .directions = SYNTHETIC_RANDOM, .levels = 3,
     .classes = {{0, 0, 0}, {0, 0, 0}, {2, 1, 0}, {2, 0, 1}, {2, 1, 0}}}, {.filter = BTF_FILTER_BILINEAR}},
    [BOUNDS] = {{.seed = 17, .width = 11, .height = 5, .n_views = 7, .n_lights = 9,
     .layout = BTF_LAYOUT_TIGHT, .domain = BTF_DOMAIN_SQRT, .colour = BTF_COLOUR_MONO, .lobes = 1,
     .effects = BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN | BTF_EFFECT_RESIDUAL, .components = 2, .centres = 9,
     .directions = SYNTHETIC_RANDOM, .classes = {{0, 0, 0}, {2, 0, 0}}, .codes = SYNTHETIC_BOUNDS,
     .blend = BTF_BLEND_ROOTS, .horizon_scale = 4}, {0}},
    [POINTS] = {{.seed = 18, .width = 70, .height = 67, .n_views = 7, .n_lights = 9,
     .layout = BTF_LAYOUT_TIGHT, .domain = BTF_DOMAIN_SQRT, .colour = BTF_COLOUR_NONE,
     .effects = BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL, .components = 2,
     .directions = SYNTHETIC_RANDOM, .levels = 3, .classes = {{0, 0, 0}, {0, 0, 0}, {2, 1, 0}},
     .horizon_scale = 4, .packed = 1}, {0}},
    [LISTS] = {{.seed = 19, .width = 11, .height = 7, .n_views = 9, .n_lights = 5,
     .layout = BTF_LAYOUT_TIGHT, .colour = BTF_COLOUR_MONO, .lobes = 1,
     .effects = BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN, .directions = SYNTHETIC_RANDOM, .levels = 3,
     .packed = 1, .entries = 13}, {0}},
    [RELIEF] = {{.seed = 20, .width = 11, .height = 7, .n_views = 19, .n_lights = 5,
     .layout = BTF_LAYOUT_TIGHT, .colour = BTF_COLOUR_MONO, .lobes = 1, .effects = BTF_EFFECT_RELIEF,
     .directions = SYNTHETIC_RANDOM, .levels = 3, .relief = SYNTHETIC_GENTLE, .relief_mixed = 1}, {0}},
    [STEEP] = {{.seed = 21, .width = 16, .height = 8, .n_views = 7, .n_lights = 9,
     .layout = BTF_LAYOUT_TIGHT, .domain = BTF_DOMAIN_SQRT, .colour = BTF_COLOUR_NONE,
     .effects = BTF_EFFECT_RESIDUAL | BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS, .components = 1,
     .directions = SYNTHETIC_RANDOM, .classes = {{0, 0, 0}, {0, 0, 0}, {1, 1, 0}}, .blend = BTF_BLEND_ROOTS,
     .horizon_scale = 4, .relief = SYNTHETIC_GENTLE, .gloss_share = 1}, {.filter = BTF_FILTER_STEEP}},
    [GLOSS] = {{.seed = 22, .width = 5, .height = 3, .n_views = 19, .n_lights = 37,
     .layout = BTF_LAYOUT_TIGHT, .colour = BTF_COLOUR_MONO, .lobes = 1,
     .effects = BTF_EFFECT_SHADOW | BTF_EFFECT_GLOSS, .directions = SYNTHETIC_RANDOM, .gloss_share = 2},
     {0}},
    [PICK_ALL] = {{.seed = 24, .width = 16, .height = 11, .n_views = 7, .n_lights = 9,
     .layout = BTF_LAYOUT_TIGHT, .domain = BTF_DOMAIN_SQRT, .colour = BTF_COLOUR_NONE,
     .effects = BTF_EFFECT_RESIDUAL | BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS, .components = 1,
     .directions = SYNTHETIC_RANDOM, .levels = 3, .classes = {{0, 0, 0}, {0, 0, 0}, {1, 1, 0}},
     .blend = BTF_BLEND_ROOTS, .horizon_scale = 4, .relief = SYNTHETIC_GENTLE, .gloss_share = 2},
     {.filter = BTF_FILTER_BILINEAR, .picks = BTF_PICK_ALL}},
    [PICK_VIEWS] = {{.seed = 25, .width = 5, .height = 3, .n_views = 9, .n_lights = 11,
     .layout = BTF_LAYOUT_TIGHT, .domain = BTF_DOMAIN_SQRT, .colour = BTF_COLOUR_MONO, .lobes = 1,
     .effects = BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN, .centres = 9,
     .directions = SYNTHETIC_RANDOM}, {.filter = BTF_FILTER_BILINEAR, .picks = BTF_PICK_VIEW}},
    [ENDING] = {{.seed = 23, .width = 13, .height = 9, .n_views = 7, .n_lights = 9,
     .layout = BTF_LAYOUT_TIGHT, .domain = BTF_DOMAIN_SQRT, .colour = BTF_COLOUR_NONE,
     .effects = BTF_EFFECT_RESIDUAL | BTF_EFFECT_RELIEF, .components = 1, .directions = SYNTHETIC_RANDOM,
     .levels = 3, .classes = {{0, 0, 0}, {0, 0, 0}, {1, 1, 0}}, .blend = BTF_BLEND_ROOTS,
     .horizon_scale = 4, .relief = SYNTHETIC_GENTLE, .relief_end = 2}, {.filter = BTF_FILTER_BILINEAR}},
    [DRAWN] = {{.seed = 4, .width = 8, .height = 8, .n_views = 37, .n_lights = 81,
     .layout = BTF_LAYOUT_TIGHT, .colour = BTF_COLOUR_RGB, .lobes = 2}, {0}},
};
/* clang-format on */
enum { SUBJECTS = sizeof subjects / sizeof *subjects, COUNT = 6000 };

static gpu *device;
static btf_material *materials[SUBJECTS];
static int drawn; /* the fault is in light sampling */

/* Every place that holds the words is changed. */
static const char *tamper(char *text) {
    const char *begin = drawn ? strstr(text, sampling_begin) : text;
    return begin ? tamper_apply(text, (size_t)(begin - text)) : text;
}

/* Differences of a subject in a step, or in radiance. */
static uint64_t differences(int subject, const char *step) {
    btf_shader_options shader = subjects[subject].shader;
    shader.struct_size = sizeof shader;
    check_subject s = {.gpu = device,
                       .material = materials[subject],
                       .shader = &shader,
                       .tamper = tamper,
                       .log = &log_print};
    check_outcome outcome = {0};
    btf_result result = step               ? check_steps(&s, 5, COUNT, step, &outcome)
                        : subject == DRAWN ? check_sampling(&s, 8, COUNT, &outcome)
                        : shader.picks     ? check_stochastic(&s, 7, COUNT, &outcome)
                                           : check_radiance(&s, 6, COUNT, &outcome);
    assert_int_equal(result, BTF_OK);
    return outcome.different;
}

TEST(untouched_passes) {
    for (int i = 0; i < SUBJECTS; ++i) {
        assert_int_equal(differences(i, NULL), 0);
        for (int s = 0; check_step_names[s]; ++s) {
            assert_int_equal(differences(i, check_step_names[s]), 0);
        }
    }
}

TEST(each_is_caught) {
    int missed = 0;
    for (int i = 0; i < SABOTAGES + SABOTAGES_2 + SABOTAGES_3 + SABOTAGES_4 + SABOTAGES_5; ++i) {
        const int later = i - SABOTAGES;
        const sabotage_of *new = later < 0                           ? NULL
                                 : later < SABOTAGES_2               ? &list_2[later]
                                 : later < SABOTAGES_2 + SABOTAGES_3 ? &list_3[later - SABOTAGES_2]
                                 : later < SABOTAGES_2 + SABOTAGES_3 + SABOTAGES_4
                                     ? &list_4[later - SABOTAGES_2 - SABOTAGES_3]
                                     : &list_5[later - SABOTAGES_2 - SABOTAGES_3 - SABOTAGES_4];
        const sabotage *fault = new ? &new->fault : &list[i];
        const int first = new ? new->subject : 0, last = new ? first : MIXED - 1;
        drawn = first == DRAWN;
        tamper_begin(fault->name, fault->from, fault->to, SIZE_MAX);
        uint64_t different = 0;
        for (int s = first; s <= last && different == 0; ++s) {
            different = differences(s, fault->step[0] ? fault->step : NULL);
        }
        missed += tamper_end(different);
    }
    assert_int_equal(missed, 0);
}

static int setup(void **state) {
    (void)state;
    device = gpu_create_or_skip(&context_devices[0]);
    for (int i = 0; i < SUBJECTS; ++i) {
        if (synthetic_create(&subjects[i].spec, &log_print, &materials[i]) != BTF_OK) {
            return -1;
        }
    }
    return 0;
}

static int teardown(void **state) {
    (void)state;
    for (int i = 0; i < SUBJECTS; ++i) {
        btf_material_close(&materials[i]);
    }
    gpu_destroy(&device);
    return 0;
}

RUN_TESTS(setup, teardown)
