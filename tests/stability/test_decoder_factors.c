/* Factors at their limits: codes, scales, factors of views, cancellation, the horizon, and views blended as roots. Each
 * expected radiance is computed here, without the reference decoder.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cases.h"

#include "decoder/toolkit/reference_view.h"
#include "tests/support/factor_material.h"
#include "tests/support/messages.h"
#include <openbtf/reference.h>

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Words of the largest and of the smallest codes: of class 0, of the others. */
static const uint32_t bounds[2][2] = {{0x7F7F7F7F, 0x81818181}, {0xFFFFFFFF, 0}};
/* The product of the largest levels of w and u, and components of a word. */
static const int products[BTF_FACTOR_CLASSES] = {127 * 127, 15 * 255, 15 * 15, 3 * 15, 3 * 3};
static const int components[BTF_FACTOR_CLASSES] = {4, 8, 8, 16, 16};

/* A material of one texel that is nothing but units of class c, the first `chroma` words of C1, with scales
 * and factors of views of 1. The horizon begins at l.z = 2^-24. */
static btf_material_desc make_desc(int c, uint32_t units, uint32_t chroma, uint32_t n_views,
                                   uint32_t n_lights) {
    static const uint32_t none[BTF_FACTOR_CLASSES][3];
    random_state r = {1};
    btf_material_desc desc = factor_material_desc(1, 1, n_views, n_lights, BTF_LAYOUT_TIGHT, 0, none);
    desc.info.colour = BTF_COLOUR_NONE;
    desc.info.lobes = 0;
    desc.info.horizon_scale = 0x1p24f;
    desc.info.factor_classes[c][0] = desc.info.components = units;
    desc.info.factor_classes[c][1] = chroma;
    factor_material_fill(&r, &desc);
    float *scales = factor_numbers(&desc, BTF_TEXTURE_FACTOR_SCALES),
          *views = factor_numbers(&desc, BTF_TEXTURE_FACTOR_VIEWS);
    for (uint32_t i = 0; i < 4 * units; i++) {
        scales[i] = 1;
    }
    for (uint32_t i = 0; i < 12 * n_views; i++) {
        views[i] = i % 4 < 3;
    }
    return desc;
}

/* Every word of a texture of words. */
static void fill_words(const btf_material_desc *desc, btf_texture_id id, uint32_t word) {
    const btf_texture t = btf_material_texture_shape(&desc->info, id);
    for (size_t i = 0; i < t.size / 4; i++) {
        factor_words(desc, id)[i] = word;
    }
}

static const float pole[3] = {0, 0, 1};

/* Decodes a material of the desc at one place; false when the desc is refused, or a value is NaN, infinite or
 * negative. */
static bool decode(const btf_material_desc *desc, int interpolation, const float light[3],
                   const float view[3], float rgb[3]) {
    btf_material *material = NULL;
    btf_ref_material m;
    if (btf_material_create(desc, NULL, &material) != BTF_OK || reference_view(material, 0, &m) != 0) {
        btf_material_close(&material);
        return false;
    }
    const btf_ref_options options = {UINT32_MAX, UINT32_MAX, interpolation, BTF_REF_TEXEL};
    btf_ref_evaluate(&m, &options, 0.5f, 0.5f, light, view, rgb);
    btf_material_close(&material);
    bool ok = true;
    for (int c = 0; c < 3; c++) {
        ok = ok && rgb[c] >= 0 && rgb[c] <= 0x1.fffffep127f;
    }
    return ok;
}

/* Codes at their bounds: sums are as large as they get, and exact. */
static void codes_at_bounds(void) {
    for (int c = 0; c < BTF_FACTOR_CLASSES; c++) {
        bool ok = true;
        float seen = 0;
        /* Four words of Y and of C1: with a scale of 2^-20 a root of 4 to 576 times products times 2^-20. */
        for (int chroma = 0; chroma < 2; chroma++) {
            for (int way = 0; way < 4; way++) {
                btf_material_desc desc = make_desc(c, 1, chroma ? 4 : 0, 1, 1);
                for (int i = 0; i < 4; i++) {
                    factor_numbers(&desc, BTF_TEXTURE_FACTOR_SCALES)[i] = 0x1p-20f;
                }
                fill_words(&desc, BTF_TEXTURE_FACTOR_TEXELS, bounds[c > 0][way & 1]);
                fill_words(&desc, BTF_TEXTURE_FACTOR_DIRECTIONS, bounds[c > 0][way >> 1]);
                float rgb[3];
                ok = ok && decode(&desc, BTF_REF_LINEAR, pole, pole, rgb);
                const bool positive = (way & 1) == way >> 1;
                const double root = 4 * components[c] * products[c] * 0x1p-20;
                const float square = (float)(root * root); /* exact in double, rounded once */
                /* C1 is added to red and subtracted from blue. */
                const float want[3] = {positive ? square : 0, positive && !chroma ? square : 0,
                                       positive != (chroma > 0) ? square : 0};
                ok = ok && memcmp(want, rgb, sizeof want) == 0;
                seen = square;
                random_material_free(&desc);
            }
        }
        cases_add(told("class %d, every code its largest or smallest", c),
                  "the square of the exact sum, rounded once; 0 for a negative one", ok,
                  "Y and C1, radiance %.8g", (double)seen);
    }
}

/* Where all lights have the same codes, the sum does not depend on their weights. */
static void lights_alike(void) {
    bool ok = true;
    int places = 0;
    for (int c = 0; c < BTF_FACTOR_CLASSES; c++) {
        btf_material_desc desc = make_desc(c, 2, 0, 1, 37);
        fill_words(&desc, BTF_TEXTURE_FACTOR_TEXELS, bounds[c > 0][0]);
        fill_words(&desc, BTF_TEXTURE_FACTOR_DIRECTIONS, bounds[c > 0][0]);
        float first[3], rgb[3];
        ok = ok && decode(&desc, BTF_REF_LINEAR, pole, pole, first) && first[0] > 0;
        for (int i = 0; i < 200; i++, places++) {
            const double theta = i * 0.0078, phi = i * 0.7;
            const float light[3] = {(float)(sin(theta) * cos(phi)), (float)(sin(theta) * sin(phi)),
                                    (float)cos(theta)};
            ok = ok && decode(&desc, i % 2 ? BTF_REF_LINEAR : BTF_REF_NEAREST, light, pole, rgb) &&
                 memcmp(first, rgb, sizeof rgb) == 0;
        }
        random_material_free(&desc);
    }
    cases_add("lights that all have the codes at their bounds",
              "the same bits in every direction above the horizon", ok, "%d directions, all classes",
              places);
}

/* Scales at their limits, of both signs: values up to 2^80 and down to 0. */
static void scales_at_limits(void) {
    static const float limits[5] = {0x1p24f, -0x1p24f, 0x1p-24f, -0x1p-24f, 0};
    bool ok = true;
    int materials = 0;
    float largest = 0;
    for (int c = 0; c < BTF_FACTOR_CLASSES; c++) {
        for (int i = 0; i < 5 * 5 * 4; i++, materials++) {
            btf_material_desc desc = make_desc(c, 2, 0, 1, 1);
            desc.info.domain = i & 1 ? BTF_DOMAIN_SQRT : BTF_DOMAIN_LINEAR;
            desc.info.blend = (i & 3) == 3 ? BTF_BLEND_ROOTS : BTF_BLEND_RADIANCE;
            for (int k = 0; k < 8; k++) {
                factor_numbers(&desc, BTF_TEXTURE_FACTOR_SCALES)[k] = limits[i / 4 % 5];
            }
            for (int k = 0; k < 12; k++) {
                factor_numbers(&desc, BTF_TEXTURE_FACTOR_VIEWS)[k] = k % 4 < 3 ? limits[i / 20] : 0;
            }
            fill_words(&desc, BTF_TEXTURE_FACTOR_TEXELS, bounds[c > 0][0]);
            fill_words(&desc, BTF_TEXTURE_FACTOR_DIRECTIONS, bounds[c > 0][0]);
            float rgb[3];
            ok = ok && decode(&desc, BTF_REF_LINEAR, pole, pole, rgb);
            const double sum =
                8.0 * components[c] * products[c] * (double)limits[i / 4 % 5] * (double)limits[i / 20];
            double root = sum >= 0x1p-30 ? fmin(sum, 0x1p32) : 0;
            root = desc.info.domain == BTF_DOMAIN_SQRT ? root * root : root;
            ok = ok && fabs((double)rgb[0] - root) <= 2e-7 * root;
            largest = rgb[0] > largest ? rgb[0] : largest;
            random_material_free(&desc);
        }
    }
    cases_add("scales and factors of views of 2^24, 2^-24, their negatives and 0",
              "what was worked out; 0 below 2^-30, a root above 2^32 counts as 2^32", ok,
              "%d materials, at most %g", materials, (double)largest);
}

/* Two units that cancel out, up to the difference of their scales. */
static bool cancels(int c, float second, const float want) {
    btf_material_desc desc = make_desc(c, 2, 0, 1, 1);
    for (int k = 4; k < 8; k++) {
        factor_numbers(&desc, BTF_TEXTURE_FACTOR_SCALES)[k] = second;
    }
    fill_words(&desc, BTF_TEXTURE_FACTOR_TEXELS, bounds[c > 0][0]);
    fill_words(&desc, BTF_TEXTURE_FACTOR_DIRECTIONS, bounds[c > 0][0]);
    float rgb[3];
    const bool ok = decode(&desc, BTF_REF_LINEAR, pole, pole, rgb) && rgb[0] == want && rgb[1] == want &&
                    rgb[2] == want;
    random_material_free(&desc);
    return ok;
}

static void cancellation(void) {
    bool ok = true;
    for (int c = 0; c < BTF_FACTOR_CLASSES; c++) {
        ok = ok && cancels(c, -1, 0);
    }
    cases_add("two units of scales 1 and -1", "0, in every class", ok, "5 classes");
    /* 7200 times 1 - 2^-24 is 7200 less one step of 2^-11; of 1 + 2^-23 one step of 2^-10 or 2^-11 more. */
    cases_add("two units of scales 1 and -1 and a step",
              "the last step of the sum, 2^-11, squared; 0 where negative",
              cancels(2, -0x1.fffffep-1f, 0x1p-22f) && cancels(2, -0x1.000002p0f, 0), "%g", 0x1p-22);
}

/* A view's factor of 0 removes its whole tier. */
static void views_of_nothing(void) {
    bool ok = true;
    for (int i = 0; i < 2 * BTF_FACTOR_CLASSES; i++) {
        btf_material_desc desc = make_desc(i / 2, 3, 5, 7, 7);
        desc.info.blend = (btf_blend)(i % 2);
        memset(factor_numbers(&desc, BTF_TEXTURE_FACTOR_VIEWS), 0, 12 * 7 * sizeof(float));
        for (int v = 0; v < 20; v++) {
            const float view[3] = {0.05f * (float)v, 0, sqrtf(1 - 0.0025f * (float)(v * v))};
            float rgb[3];
            ok = ok && decode(&desc, BTF_REF_LINEAR, pole, view, rgb) && rgb[0] == 0 && rgb[1] == 0 &&
                 rgb[2] == 0;
        }
        random_material_free(&desc);
    }
    cases_add("factors of views that are all 0", "radiance 0 from everywhere", ok,
              "20 views, all classes, both blends");
}

/* Beyond the outermost light radiance falls in proportion to l.z. */
static void horizon(void) {
    for (int domain = 0; domain < 2; domain++) {
        btf_material_desc desc = make_desc(2, 1, 0, 1, 19);
        desc.info.domain = (btf_domain)domain;
        desc.info.horizon_scale = 8; /* fades below l.z = 1/8 */
        fill_words(&desc, BTF_TEXTURE_FACTOR_TEXELS, bounds[1][0]);
        fill_words(&desc, BTF_TEXTURE_FACTOR_DIRECTIONS, bounds[1][0]);
        const double full = domain ? 7200.0 * 7200 : 7200;
        double worst = 0;
        float last = 0;
        bool ok = true;
        for (int i = 0; i <= 2400; i++) { /* from 2^-24 to 1 */
            const float z = exp2f((float)i / 100 - 24);
            const float light[3] = {sqrtf(1 - z * z), 0, z};
            float rgb[3];
            ok = ok && decode(&desc, BTF_REF_LINEAR, light, pole, rgb) && rgb[0] >= last;
            worst = fmax(worst, fabs((double)rgb[0] / (full * fmin(8 * (double)z, 1)) - 1));
            last = rgb[0];
        }
        float rgb[3];
        ok = ok && worst < 1e-6 && (double)last == full;
        ok = ok && decode(&desc, BTF_REF_LINEAR, (const float[]){1, 0, 0x1.fffffep-25f}, pole, rgb) &&
             rgb[0] == 0;
        cases_add(told("a light that sinks from the pole to the horizon, domain %s",
                             domain ? "sqrt" : "linear"),
                  "the same to l.z = 1 / horizonScale, then in proportion to l.z within 1e-6; no jump, "
                  "never more",
                  ok, "2401 lights, off by at most %.2g", worst);
        random_material_free(&desc);
    }
}

/* Roots of several views: a negative root of one view is subtracted from those of the others. */
static void roots(void) {
    bool ok = true, found = false;
    for (int blend = 0; blend < 2; blend++) {
        btf_material_desc desc = make_desc(2, 1, 0, 7, 1);
        desc.info.blend = (btf_blend)blend;
        fill_words(&desc, BTF_TEXTURE_FACTOR_TEXELS, bounds[1][0]);
        fill_words(&desc, BTF_TEXTURE_FACTOR_DIRECTIONS, bounds[1][0]);
        for (int v = 1; v < 7; v++) { /* all but the pole */
            for (int k = 0; k < 3; k++) {
                factor_numbers(&desc, BTF_TEXTURE_FACTOR_VIEWS)[12 * v + 4 + k] = -1;
            }
        }
        for (int i = 0; i <= 100; i++) {
            const double theta = i * 0.013;
            const float view[3] = {(float)sin(theta), 0, (float)cos(theta)};
            btf_material *material = NULL;
            btf_ref_material m;
            int32_t q[2];
            float rgb[3];
            ok = ok && decode(&desc, BTF_REF_LINEAR, pole, view, rgb) &&
                 btf_material_create(&desc, NULL, &material) == BTF_OK &&
                 reference_view(material, 0, &m) == 0;
            btf_ref_project(view, q);
            const btf_ref_neighbours n = btf_ref_lookup(m.view_table, m.view_grid, q);
            double weight = 0; /* of the pole */
            for (int k = 0; k < 3; k++) {
                weight += n.index[k] == 0 ? n.weight[k] / 4096.0 : 0;
            }
            const double root = fmax(2 * weight - 1, 0) * 7200;
            const double want = blend ? root * root : weight * 7200 * 7200;
            ok = ok && fabs((double)rgb[0] - want) <= 1e-6 * want;
            found = found || (weight > 0.1 && weight < 0.4 && blend && rgb[0] == 0);
            btf_material_close(&material);
        }
        random_material_free(&desc);
    }
    cases_add("one view of a root and its neighbours of its negative",
              "blended as roots: 0 where these weigh more; as radiance: what the one weighs", ok && found,
              "101 views, both blends");
}

int main(void) {
    cases_title("Factors at their limits, decoded by the reference and worked out beside it.");
    codes_at_bounds();
    lights_alike();
    scales_at_limits();
    cancellation();
    views_of_nothing();
    horizon();
    roots();
    return cases_result();
}
