/* Leaving out effects never costs more: of two shader variants, one of which leaves out effects of the other, the
 * smaller never uploads more bytes, nor has more SPIR-V instructions or texture fetches on its longest path.
 *
 * Loops count as often as they run: by their constant bound, else (neighbouring directions) 3 times, once
 * with nearest directions; the records of a look-up 4 times.
 *
 * SPDX-License-Identifier: MIT
 */
#include "synthetic.h"

#include <glslang/Include/glslang_c_interface.h>
#include <glslang/Public/resource_limits_c.h>
#include <openbtf/shader.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { COMPONENTS = 3, VARIANTS = 16 * COMPONENTS * 2 * 2 * 2, MOST_BLOCKS = 2048, RECORDS = 4 };
static const uint32_t components[COMPONENTS] = {0, 4, 16};

/* The choices that are static in a variant. */
typedef struct choice {
    uint32_t effects;    /* without the residual */
    uint32_t components; /* 0: none */
    bool nearest, bilinear, fixed;
} choice;

typedef struct count {
    uint64_t instructions, fetches;
    size_t bytes;
} count;

/* A SPIR-V module and a table of its ids. */
typedef struct module {
    const unsigned *words;
    unsigned trips;
    const char **name;      /* [id] of OpName */
    const unsigned **value; /* [id] of OpConstant: its first word */
    size_t *function;       /* [id]: where OpFunction stands, 0 for none */
    count *total;           /* [id] of a function, once known */
    bool *known;
} module;

enum {
    OP_NAME = 5,
    OP_CONSTANT = 43,
    OP_FUNCTION = 54,
    OP_FUNCTION_END = 56,
    OP_CALL = 57,
    OP_FETCH = 95,
    OP_U_LESS = 176,
    OP_S_LESS = 177,
    OP_LOOP_MERGE = 246,
    OP_LABEL = 248,
    OP_BRANCH = 249,
    OP_BRANCH_IF = 250,
};

typedef struct block {
    unsigned label, successor[2], merge; /* merge: of the loop that begins here, 0 for none */
    int successors;
    count own, longest;
    bool done;
} block;

typedef struct body {
    int count;
    block *block;
} body;

static count function_cost(module *m, unsigned id);

static int find_block(const body *b, unsigned label) {
    for (int i = 0; i < b->count; ++i) {
        if (b->block[i].label == label) {
            return i;
        }
    }
    fprintf(stderr, "no block %u\n", label);
    exit(4);
}

/* The longest path from a block. The branch back at the end of a loop's body counts as one to the block after the
 * loop. */
static count longest(body *b, int at) {
    block *here = &b->block[at];
    if (here->done) {
        return here->longest;
    }
    count best = {0};
    for (int s = 0; s < here->successors; ++s) {
        int to = find_block(b, here->successor[s]);
        if (to <= at) {
            to = find_block(b, b->block[to].merge);
        }
        const count c = longest(b, to);
        best.instructions = c.instructions > best.instructions ? c.instructions : best.instructions;
        best.fetches = c.fetches > best.fetches ? c.fetches : best.fetches;
    }
    here->longest = (count){.instructions = here->own.instructions + best.instructions,
                            .fetches = here->own.fetches + best.fetches};
    here->done = true;
    return here->longest;
}

/* How often each loop runs multiplies what lies between its header and its merge. */
static void multiply_loops(body *b, const unsigned *bound_of_loop) {
    for (int h = 0; h < b->count; ++h) {
        if (!b->block[h].merge) {
            continue;
        }
        const int end = find_block(b, b->block[h].merge);
        for (int i = h; i < end; ++i) {
            b->block[i].own.instructions *= bound_of_loop[h];
            b->block[i].own.fetches *= bound_of_loop[h];
        }
    }
}

static count function_cost(module *m, unsigned id) {
    if (m->known[id]) {
        return m->total[id];
    }
    body b = {.block = calloc(MOST_BLOCKS, sizeof *b.block)};
    unsigned *bound = calloc(MOST_BLOCKS, sizeof *bound);
    if (!b.block || !bound) {
        exit(4);
    }
    const bool look_up = m->name[id] && strncmp(m->name[id], "btf_lookup", 10) == 0;
    int loop = -1; /* the loop whose bound was not read yet */
    for (size_t i = m->function[id]; (m->words[i] & 0xFFFF) != OP_FUNCTION_END; i += m->words[i] >> 16) {
        const unsigned op = m->words[i] & 0xFFFF, *w = m->words + i;
        block *now = b.count ? &b.block[b.count - 1] : NULL;
        if (op == OP_LABEL) {
            if (b.count == MOST_BLOCKS) {
                exit(4);
            }
            b.block[b.count++].label = w[1];
            continue;
        }
        if (!now) {
            continue;
        }
        now->own.instructions++;
        if (op == OP_FETCH) {
            now->own.fetches++;
        }
        if (op == OP_CALL) {
            const count c = function_cost(m, w[3]);
            now->own.instructions += c.instructions;
            now->own.fetches += c.fetches;
        }
        if (op == OP_LOOP_MERGE) {
            now->merge = w[1];
            loop = b.count - 1;
            bound[loop] = look_up ? RECORDS : m->trips;
        }
        if ((op == OP_U_LESS || op == OP_S_LESS) && loop >= 0) {
            if (m->value[w[4]]) {
                bound[loop] = *m->value[w[4]];
            }
            loop = -1;
        }
        if (op == OP_BRANCH || op == OP_BRANCH_IF) {
            now->successors = op == OP_BRANCH ? 1 : 2;
            now->successor[0] = w[op == OP_BRANCH ? 1 : 2];
            now->successor[1] = op == OP_BRANCH ? 0 : w[3];
        }
    }
    multiply_loops(&b, bound);
    m->total[id] = longest(&b, 0);
    m->known[id] = true;
    free(bound);
    free(b.block);
    return m->total[id];
}

static count module_cost(const unsigned *words, size_t length, unsigned trips) {
    const unsigned bound = words[3];
    unsigned entry = 0;
    module m = {.words = words,
                .trips = trips,
                .name = calloc(bound, sizeof *m.name),
                .value = calloc(bound, sizeof *m.value),
                .function = calloc(bound, sizeof *m.function),
                .total = calloc(bound, sizeof *m.total),
                .known = calloc(bound, sizeof *m.known)};
    if (!m.name || !m.value || !m.function || !m.total || !m.known) {
        exit(4);
    }
    for (size_t i = 5; i < length && words[i] >> 16; i += words[i] >> 16) {
        const unsigned op = words[i] & 0xFFFF;
        if (op == OP_NAME) {
            m.name[words[i + 1]] = (const char *)(words + i + 2);
        }
        if (op == OP_CONSTANT) {
            m.value[words[i + 2]] = words + i + 3;
        }
        if (op == OP_FUNCTION) {
            m.function[words[i + 2]] = i;
            entry = entry ? entry : words[i + 2]; /* glslang puts main first */
        }
    }
    const count c = function_cost(&m, entry);
    free(m.name);
    free(m.value);
    free(m.function);
    free(m.total);
    free(m.known);
    return c;
}

static count compile(const char *text, unsigned trips) {
    static const char main_text[] = "layout(location = 0) in vec2 uv;\nlayout(location = 1) in vec3 "
                                    "l;\nlayout(location = 2) in vec3 v;\n"
                                    "layout(location = 0) out vec4 colour;\n"
                                    "void main() {\n    colour = vec4(btf_evaluate(uv, l, v), 1.0);\n}\n";
    const size_t size = strlen(text) + sizeof main_text + 32;
    char *whole = malloc(size);
    if (!whole) {
        exit(4);
    }
    snprintf(whole, size, "#version 450 core\n%s\n%s", text, main_text);
    glslang_input_t input = {.language = GLSLANG_SOURCE_GLSL,
                             .stage = GLSLANG_STAGE_FRAGMENT,
                             .client = GLSLANG_CLIENT_VULKAN,
                             .client_version = GLSLANG_TARGET_VULKAN_1_0,
                             .target_language = GLSLANG_TARGET_SPV,
                             .target_language_version = GLSLANG_TARGET_SPV_1_0,
                             .code = whole,
                             .default_version = 100,
                             .default_profile = GLSLANG_NO_PROFILE,
                             .messages = GLSLANG_MSG_SPV_RULES_BIT | GLSLANG_MSG_VULKAN_RULES_BIT,
                             .resource = glslang_default_resource()};
    glslang_shader_t *shader = glslang_shader_create(&input);
    glslang_program_t *program = glslang_program_create();
    if (!glslang_shader_preprocess(shader, &input) || !glslang_shader_parse(shader, &input)) {
        fprintf(stderr, "%s\n", glslang_shader_get_info_log(shader));
        exit(4);
    }
    glslang_program_add_shader(program, shader);
    if (!glslang_program_link(program, (int)input.messages)) {
        exit(4);
    }
    glslang_program_SPIRV_generate(program, GLSLANG_STAGE_FRAGMENT);
    const count c =
        module_cost(glslang_program_SPIRV_get_ptr(program), glslang_program_SPIRV_get_size(program), trips);
    glslang_program_delete(program);
    glslang_shader_delete(shader);
    free(whole);
    return c;
}

static choice variant(int i) {
    choice c = {.effects = (uint32_t)i % 16};
    i /= 16;
    c.components = components[i % COMPONENTS];
    i /= COMPONENTS;
    c.nearest = i & 1;
    c.bilinear = i >> 1 & 1;
    c.fixed = i >> 2 & 1;
    return c;
}

static count measure(const btf_material *material, const btf_material_info *info, choice c) {
    btf_shader_options o = {
        .struct_size = sizeof o,
        .leave_out = info->effects & ~(c.effects | (c.components ? BTF_EFFECT_RESIDUAL : 0u)),
        .components = c.components,
        .interpolation = c.nearest ? BTF_INTERPOLATION_NEAREST : BTF_INTERPOLATION_LINEAR,
        .filter = c.bilinear ? BTF_FILTER_BILINEAR : BTF_FILTER_TEXEL,
        .bindings = BTF_BINDINGS_VULKAN,
        .fixed = c.fixed ? BTF_FIXED_VIEW | BTF_FIXED_LIGHT : 0u,
        .fixed_view = {0.36f, 0, 0.93295228f},
        .fixed_light = {0, 0.48f, 0.87726848f}};
    char *text = NULL;
    if (btf_shader_source(material, &o, NULL, &text) != BTF_OK) {
        exit(4);
    }
    count made = compile(text, c.nearest ? 1 : 3);
    btf_free(text);
    const uint32_t textures = btf_shader_textures(info, &o);
    for (int id = 0; id < BTF_TEXTURE_COUNT; ++id) {
        const btf_texture t = btf_material_texture(material, (btf_texture_id)id);
        if (!(textures >> id & 1)) {
            continue;
        }
        const bool residual = id == BTF_TEXTURE_RESIDUAL_TEXELS || id == BTF_TEXTURE_RESIDUAL_DIRECTIONS;
        made.bytes += residual ? t.size / info->components * c.components : t.size;
    }
    return made;
}

/* a leaves out what b has. */
static bool is_less(const choice *a, const choice *b) {
    return (a->effects & ~b->effects) == 0 && a->components <= b->components && a->nearest >= b->nearest &&
           a->bilinear <= b->bilinear && a->fixed >= b->fixed;
}

/* Measures all variants of one material and compares all pairs; returns the number of wrong ones, of which it prints
 * five. */
static int check_layout(btf_layout layout) {
    const synthetic_spec spec = {.seed = 1,
                                 .width = 16,
                                 .height = 16,
                                 .n_views = 81,
                                 .n_lights = 81,
                                 .layout = layout,
                                 .domain = BTF_DOMAIN_SQRT,
                                 .lobes = 2,
                                 .effects = BTF_EFFECT_VERSION_1,
                                 .components = 16,
                                 .centres = 100};
    static count counts[VARIANTS];
    btf_material *material = NULL;
    btf_material_info info = {.struct_size = sizeof info};
    if (synthetic_create(&spec, NULL, &material) != BTF_OK) {
        exit(4);
    }
    btf_material_get_info(material, &info);
    for (int i = 0; i < VARIANTS; ++i) {
        counts[i] = measure(material, &info, variant(i));
    }
    btf_material_close(&material);
    int pairs = 0, wrong = 0;
    for (int i = 0; i < VARIANTS; ++i) {
        for (int k = 0; k < VARIANTS; ++k) {
            const choice a = variant(i), b = variant(k);
            if (i == k || !is_less(&a, &b)) {
                continue;
            }
            ++pairs;
            if (counts[i].bytes <= counts[k].bytes && counts[i].fetches <= counts[k].fetches &&
                counts[i].instructions <= counts[k].instructions) {
                continue;
            }
            if (wrong++ < 5) {
                fprintf(
                    stderr,
                    "effects %u k %u %d%d%d: %zu bytes, %llu fetches, %llu instructions; effects %u k %u "
                    "%d%d%d: %zu, %llu, %llu\n",
                    a.effects, a.components, a.nearest, a.bilinear, a.fixed, counts[i].bytes,
                    (unsigned long long)counts[i].fetches, (unsigned long long)counts[i].instructions,
                    b.effects, b.components, b.nearest, b.bilinear, b.fixed, counts[k].bytes,
                    (unsigned long long)counts[k].fetches, (unsigned long long)counts[k].instructions);
            }
        }
    }
    const count *most = &counts[16 * COMPONENTS - 1], *least = &counts[0];
    printf("layout %s: %d variants, %d pairs, %d wrong; full %llu fetches, %llu instructions, SBRDF alone "
           "%llu, %llu\n",
           layout == BTF_LAYOUT_TIGHT ? "tight" : "paper", VARIANTS, pairs, wrong,
           (unsigned long long)most->fetches, (unsigned long long)most->instructions,
           (unsigned long long)least->fetches, (unsigned long long)least->instructions);
    return wrong;
}

int main(void) {
    glslang_initialize_process();
    const int wrong = check_layout(BTF_LAYOUT_PAPER) + check_layout(BTF_LAYOUT_TIGHT);
    glslang_finalize_process();
    return wrong > 0;
}
