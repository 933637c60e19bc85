/* Fits a cost model by non-negative least squares. See cost_fit.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cost_fit.h"

#include "decoder/toolkit/json.h"
#include "decoder/toolkit/output.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { TURNS = 200000 };

#define ONE(price, name, count) +1
enum { PRICES = BTF_COST_LIST(ONE) };
#undef ONE

static void counts_of(const btf_decode_counts *n, double out[PRICES]) {
    int i = 0;
#define READ(price, name, count) out[i++] = n->count;
    BTF_COST_LIST(READ)
#undef READ
}

/* Coordinate descent (V. Franc et al., 2005): sets one price after another to the value of least error, or 0, on
 * columns scaled to length 1. The problem is convex, so that this ends at the best prices. */
static void solve(double gram[PRICES][PRICES], const double right[PRICES], double x[PRICES]) {
    for (int turn = 0; turn < TURNS; turn++) {
        double moved = 0;
        for (int i = 0; i < PRICES; i++) {
            double rest = right[i];
            for (int k = 0; k < PRICES; k++) {
                rest -= gram[i][k] * x[k];
            }
            const double next = gram[i][i] > 0 ? fmax(x[i] + rest / gram[i][i], 0) : 0;
            moved = fmax(moved, fabs(next - x[i]));
            x[i] = next;
        }
        if (moved < 1e-14) {
            return;
        }
    }
}

cost_deviation cost_fit(const cost_sample *samples, int count, btf_cost_model *out_model) {
    double gram[PRICES][PRICES] = {{0}}, right[PRICES] = {0}, length[PRICES], x[PRICES] = {0}, n[PRICES];
    for (int s = 0; s < count; s++) {
        counts_of(&samples[s].counts, n);
        for (int i = 0; i < PRICES; i++) {
            right[i] += n[i] / samples[s].ns;
            for (int k = 0; k < PRICES; k++) {
                gram[i][k] += n[i] * n[k] / (samples[s].ns * samples[s].ns);
            }
        }
    }
    for (int i = 0; i < PRICES; i++) {
        length[i] = gram[i][i] > 0 ? sqrt(gram[i][i]) : 1;
    }
    for (int i = 0; i < PRICES; i++) {
        right[i] /= length[i];
        for (int k = 0; k < PRICES; k++) {
            gram[i][k] /= length[i] * length[k];
        }
    }
    solve(gram, right, x);
    *out_model = (btf_cost_model){.struct_size = sizeof *out_model};
    int i = 0;
#define WRITE(price, name, count) out_model->price = x[i] / length[i], i++;
    BTF_COST_LIST(WRITE)
#undef WRITE
    cost_deviation d = {.count = count};
    for (int s = 0; s < count; s++) {
        const double off = fabs(btf_cost_of(&samples[s].counts, out_model) / samples[s].ns - 1);
        d.mean += off / count;
        d.worst = fmax(d.worst, off);
    }
    return d;
}

btf_result cost_write(const enc_context *context, const char *path, const btf_cost_model *model,
                      const cost_deviation *deviation) {
    json j = {0};
    json_object(&j, NULL);
    json_integer(&j, "openbtf_costs", 1);
    json_string(&j, "device", model->device);
    json_integer(&j, "variants", deviation->count);
    json_float(&j, "deviation", (float)deviation->mean);
#define PUT(price, name, count) json_float(&j, name, (float)model->price);
    BTF_COST_LIST(PUT)
#undef PUT
    json_end(&j);
    const char *text = json_text(&j);
    output *file = NULL;
    btf_result result = text ? output_open(path, context->log, &file)
                             : enc_fail(context, BTF_ERROR_MEMORY, "%s: out of memory", path);
    if (result == BTF_OK) {
        fputs(text, output_stream(file));
        result = output_commit(&file);
    }
    json_free(&j);
    return result;
}
