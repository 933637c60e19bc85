/* The cost of each effect. See costs.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "costs.h"

#include "decoder/toolkit/cli.h"
#include <stdio.h>
#include <string.h>

void costs_clear(costs *c) {
    memset(c, 0, sizeof *c);
}

/* Keeps a mean in which the newest frame counts three tenths, so that one slow frame does not move the panel
 * much. */
void costs_record(costs *c, uint32_t effects, double ms) {
    double *at = &c->ms[effects & BTF_EFFECT_ALL];
    *at = *at > 0 ? 0.7 * *at + 0.3 * ms : ms;
}

const btf_material_error *costs_error(const btf_material *material, uint32_t effects) {
    btf_material_info info = {.struct_size = sizeof info};
    size_t count;
    const btf_material_error *errors = btf_material_errors(material, &count);
    btf_material_get_info(material, &info);
    for (size_t i = 0; i < count && errors; i++) {
        if ((errors[i].effects & info.effects) == (effects & info.effects)) {
            return &errors[i];
        }
    }
    return NULL;
}

void costs_text(const costs *c, const btf_material *material, uint32_t effects, char *text, size_t size) {
    btf_material_info info = {.struct_size = sizeof info};
    size_t length = 0;
    btf_material_get_info(material, &info);
    text[0] = '\0';
    for (uint32_t i = 0; i < CLI_EFFECTS_COUNT; i++) {
        const uint32_t bit = 1u << i, with = (effects & info.effects) | bit, without = with & ~bit;
        char ms[24] = "-", db[40] = "-";
        if (length >= size) {
            break;
        }
        if (!(info.effects & bit)) {
            length += (size_t)snprintf(text + length, size - length, "%u %-8s not in the file\n", i + 1,
                                       cli_effect_word((int)i));
            continue;
        }
        if (c->ms[with] > 0 && c->ms[without] > 0) {
            snprintf(ms, sizeof ms, "%+.1f ms", c->ms[with] - c->ms[without]);
        }
        const btf_material_error *a = costs_error(material, with), *b = costs_error(material, without);
        if (a && b) {
            snprintf(db, sizeof db, "%+.1f/%+.1f dB", (double)a->psnr_linear - (double)b->psnr_linear,
                     (double)a->psnr_srgb - (double)b->psnr_srgb);
        }
        length += (size_t)snprintf(text + length, size - length, "%u %-8s %-3s %9s  %s\n", i + 1,
                                   cli_effect_word((int)i), effects & bit ? "on" : "off", ms, db);
    }
}
