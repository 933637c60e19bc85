#!/usr/bin/env python3
"""Deliberately broken builds: each must make a stability test fail.

    broken.py SOURCE_ROOT [NAME...]    all of them, or those of these names
    broken.py SOURCE_ROOT --applies    only checks that each change still applies: that the text it replaces is there

Copies the sources and builds in the copy what the tests need. Then, for each change of the list below, makes the change,
builds the test that has to notice, runs it until a case fails, and restores sources and build, so that only what depends
on a change is built anew, once. A change that no longer applies, does not build, or goes unnoticed is a failure. The long
run of the tests runs all changes (table.py).

SPDX-License-Identifier: MIT
"""
import glob
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import threading

# Unoptimised, the encoder's loops take longer to run than -O2 takes to compile. Results have the same bits at every
# level.
OPTIONS = ['-Doptimization=1']
LONGEST = 1800  # seconds of a test; a change may make it run for ever

# The breaks: [(file, text, its replacement)], and the test that has to notice.
CHANGES = [
    ("the bound on n removed", "stability_fit", [
        ("encoder/lafortune/texel_fit.c", "log(fmax(ENC_FIT_MAX_N, value))", "log(fmax(1e9, value))")]),
    ("lobes may tower between samples", "stability_fit", [
        ("encoder/lafortune/texel_fit.c", "most_overshoot = 4;", "most_overshoot = 1e30;")]),
    ("lobes of one colour may leave the range of floats", "stability_fit", [
        ("encoder/lafortune/normal_equations.c", "if (!p->rgb && most * log(peak) > most_peak)", "if (most < 0)")]),
    ("parameters beyond 2^24 stored", "stability_fit", [
        ("encoder/lafortune/texel_fit.c", "copysign(fmin(magnitude, 0x1p24), value)", "copysign(magnitude, value)")]),
    ("what the file's limits do to a lobe not looked at", "stability_fit", [
        ("encoder/lafortune/texel_fit.c", "diffuse = !(best.cost < stored_cost(&p, plain));", "diffuse = false;")]),
    ("all samples may be rejected", "stability_fit", [
        ("encoder/paper/fit.c", "least_kept = 0.1;", "least_kept = 0.0;")]),
    ("the division by a model of nothing put back", "stability_fit", [
        ("encoder/paper/shadow.h", " || !(model >= ENC_SHADOW_MIN_MODEL)", "")]),
    ("the division by the largest of black samples put back", "stability_fit", [
        ("encoder/paper/fit.c", "return any;", "return true;"),
        ("encoder/lafortune/texel_fit.c", "if (largest == 0) {", "if (largest < 0) {")]),
    ("empty clusters left empty", "stability_occlusion", [
        ("encoder/math/kmeans.c", "if (counts[j] > 0) {\n            continue;\n        }", "continue;")]),
    ("the division by the members of an empty cluster put back", "stability_occlusion", [
        ("encoder/math/kmeans.c", "d < stride && counts[j] > 0; d++", "d < stride; d++")]),
    ("a scale of centres that no file holds", "stability_occlusion", [
        ("encoder/paper/cluster.c", "fminf(fmaxf(most / 255.0f, 0x1p-24f), 0x1p24f)", "most / 255.0f")]),
    ("clusters that depend on the thread", "stability_occlusion", [
        ("encoder/paper/cluster.c", "s->options.seed + (uint64_t)view", "s->options.seed + (uint64_t)omp_get_thread_num()"),
        ("encoder/paper/cluster.c", "#include <math.h>\n", "#include <math.h>\n#include <omp.h>\n")]),
    ("rounding taken for texture", "stability_occlusion", [
        ("encoder/paper/flow_prior.c", "equal_sums = 1e-5f;", "equal_sums = 0.0f;")]),
    ("the division by no visible points put back", "stability_occlusion", [
        ("encoder/paper/refine.c", "return n == 0 ? 0 : (float)(sum / (double)n);", "return (float)(sum / (double)n);")]),
    ("a shift of 128 taken for one of -128", "stability_occlusion", [
        ("encoder/model/occlusion.c", "2 * r > size || r > 127 ? r - size : r", "2 * r > size ? r - size : r")]),
    ("the diffuse fit never taken in place of what is worse", "stability_joint", [
        ("encoder/paper/paper.c", "if (result == BTF_OK && options->fallback) {", "if (result != BTF_OK && options->fallback) {")]),
    ("samples that are no numbers read", "stability_input", [
        ("encoder/input/radiance.c", "if (finite && ", "if (finite || ")]),
    ("the square root of the cosine forgotten in playback", "precision", [
        ("encoder/model/decode_samples.c", "solution->domain == BTF_DOMAIN_SQRT ? sqrtf(xyz[2]) : xyz[2]", "xyz[2]")]),
    ("the derivative by n wrong", "precision", [
        ("encoder/lafortune/normal_equations.c", "return at->held[j] ? 0 : at->shape[j][3];", "return at->held[j] ? 0 : at->shape[j][0];")]),
    ("samples rejected by a model in steps of 1/16", "precision", [
        ("encoder/paper/fit.c", "model[c] = w->model[c * n + i] * g->multiplier[i];",
         "model[c] = w->model[c * n + i] * g->multiplier[i] + 1e6f - 1e6f;")]),
    ("the flow's first estimate from images in steps of 1/4", "precision", [
        ("encoder/paper/flow_prior.c", "v > 0 ? sqrtf(v) : 0;", "v > 0 ? sqrtf(v) + 4e6f - 4e6f : 0;")]),
    ("hidden points searched by distances in steps of 1", "precision", [
        ("encoder/paper/refine.c", "s->norms.distance(query, s->modelled + source * s->stride, s->lanes);",
         "s->norms.distance(query, s->modelled + source * s->stride, s->lanes) + 1e7f - 1e7f;")]),
    ("means of clusters in steps of 1/16", "precision", [
        ("encoder/math/kmeans.c", "(float)(sums[j * stride + d] / (double)counts[j]);",
         "(float)(sums[j * stride + d] / (double)counts[j]) + 1e6f - 1e6f;")]),
    ("the diffuse term stored four times too large", "perturbation", [
        ("encoder/lafortune/texel_fit.c", "out[3] = storable(at->diffuse * factor, cut);", "out[3] = storable(4 * at->diffuse * factor, cut);"),
        ("encoder/lafortune/texel_fit.c", "if (store(&p, &best, out_parameters)) {\n            best.cost = stored_cost", "if (!store(&p, &best, out_parameters)) {\n            best.cost = stored_cost")]),
    ("a threshold that does not scale with radiance", "equivariance", [
        ("encoder/paper/shadow.h", "ENC_SHADOW_MIN_MODEL 1e-5f", "ENC_SHADOW_MIN_MODEL 0.05f")]),
    ("shifts along the wrong line, in the flow's first estimate", "equivariance", [
        ("encoder/paper/flow_prior.c", ".rows = across > 0 ? view->xyz[1] / across : 0}", ".rows = across > 0 ? -view->xyz[0] / across : 0}")]),
    ("what the first view shows read from a fold for all", "fold", [
        ("reference/btf_source.c", "s->folded->values + 4 * layer_index(material, view, column, row)",
         "s->folded->values + 4 * layer_index(material, 0, column, row)")]),
    ("rows of a fold counted from the first of a piece", "fold", [
        ("reference/btf_evaluate.c", "texel_radiance(&e, column, row, out_values);", "texel_radiance(&e, column, row - first_row, out_values);")]),
    ("a column of what was folded decoded again", "fold", [
        ("reference/btf_evaluate.c", "if (folded && folded->fold == BTF_REF_FOLD_BOTH) {", "if (folded && folded->fold == BTF_REF_FOLD_BOTH && column > 0) {")]),
    ("the lights of the first neighbour folded for all", "fold", [
        ("reference/btf_evaluate.c", "&e.lights[neighbour], column, row,", "&e.lights[0], column, row,")]),
    ("neighbours of a fold read by the number of their view", "fold", [
        ("reference/btf_evaluate.c", "        e.shown[a] = a;", "        e.shown[a] = e.views.index[a] % 3;")]),
    ("a fold of neighbours that takes the layers of all views", "fold", [
        ("decoder/fold/fold.c", "return lights * 3;", "return lights * info->n_views;")]),
    ("the CPU's neighbours kept by their order, not their place", "fold", [
        ("decoder/fold/cpu_fold.c", "s->views.place[a] != layer", "(uint32_t)a != layer")]),
    ("level 0 folded by the CPU for all", "fold", [
        ("decoder/fold/cpu_fold.c", "levels[i] = (int32_t)p->level;", "levels[i] = 0;")]),
    ("texels of a row folded by the CPU twice", "fold", [
        ("decoder/fold/cpu_fold.c", "texels.column[texels.count] = first + (uint32_t)texels.count;", "texels.column[texels.count] = (uint32_t)texels.count;")]),
    ("lights added by the CPU without their weights", "fold", [
        ("decoder/fold/cpu_fold.c", "total + value * weight[i % 4]", "total + value * weight[0]")]),
    ("a sum of lights folded where relief is decoded", "fold_sum", [
        ("decoder/fold/fold.c", "all.fold == BTF_FOLD_SUM && effects & BTF_EFFECT_RELIEF", "all.fold == BTF_FOLD_SUM && effects == 0")]),
    ("negative roots that take nothing from a product", "fold_sum", [
        ("decoder/fold/cpu_sum.c", "(low < 0 ? low : 0.0f) * 0.5f", "(low < 0 ? low : 0.0f) * 0.0f")]),
    ("a light of a sum that weighs by its red", "fold_sum", [
        ("decoder/fold/cpu_sum.c", "{weight[0], weight[1], weight[2], 0}", "{weight[0], weight[0], weight[2], 0}")]),
    ("edges of the hull that are partners where they go up alone", "fold_sum", [
        ("decoder/evaluate/partners.c", "if (a == b || place_of", "if (a >= b || place_of")]),
    ("neighbours beyond the hull that are no partners", "fold_sum", [
        ("decoder/evaluate/partners.c", "i < views->hull_count; i++", "i < views->hull_count - views->hull_count; i++")]),
    ("a sum that leaves out what two neighbours have together", "fold_sum", [
        ("reference/btf_evaluate.c", "k < 6; ++k) {", "k < 3; ++k) {")]),
    ("the second of two lights added from the values of the first", "fold_gl", [
        ("decoder/fold/gl_sum.c", "(int32_t)(second * f->sampled);", "(int32_t)(second * 0 * f->sampled);")]),
    ("an odd light of a sum that begins none", "fold_gl", [
        ("decoder/fold/gl_sum.c", "begins && i == 0", "begins && i == 1")]),
    ("the sum of lights under a moving view counted for each of them", "fold", [
        ("decoder/fold/fold.c", "options.fold == BTF_FOLD_BOTH || options.fold == BTF_FOLD_SUM ? 1 : lights", "options.fold == BTF_FOLD_BOTH ? 1 : lights")]),
    ("a sum of lights begun in the wrong texture", "fold_gl", [
        ("decoder/fold/gl_sum.c", "to = (count - 1 - i) % 2", "to = i % 2")]),
    ("gloss left out at any price", "fold", [
        ("decoder/plan/plan.c", "base[i] * (1 + lack[i]) + way->growth", "base[i] + way->growth")]),
    ("gloss never left out", "fold", [
        ("decoder/plan/plan.c", "l->effects && !(s->between && s->tolerance > 0)", "l->effects && !(s->between && s->tolerance > 1000)")]),
    ("a light folded where gloss is decoded", "fold", [
        ("decoder/fold/fold.c", "of_lights && effects & BTF_EFFECT_GLOSS", "of_lights && effects == 0")]),
    ("a light folded where there is an SBRDF", "fold", [
        ("decoder/fold/fold.c", "of_lights && info->colour != BTF_COLOUR_NONE", "of_lights && info->colour > BTF_COLOUR_NONE")]),
    ("light and view folded where relief is decoded", "fold", [
        ("decoder/fold/fold.c", "all.fold == BTF_FOLD_BOTH && effects & BTF_EFFECT_RELIEF", "all.fold == BTF_FOLD_BOTH && effects == 0")]),
    ("level 0 of a fold drawn alone", "fold_gl", [
        ("decoder/fold/gl_fold.c", "level < fold->levels; ++level) {\n        for (uint32_t i = 0; i < fold->views", "level < 1; ++level) {\n        for (uint32_t i = 0; i < fold->views")]),
    ("every light folded into the layers of the first", "fold_gl", [
        ("decoder/fold/gl_fold.c", "number * fold->views + i, level", "0 * fold->views + i, level")]),
    ("a fold drawn within the caller's scissor", "fold_gl", [
        ("decoder/fold/gl_draw.c", "    GL_SCISSOR_TEST,", "    GL_STENCIL_TEST,")]),
    ("the caller's viewport lost to a fold", "fold_gl", [
        ("decoder/fold/gl_draw.c", "set_viewport(gl, s->viewport);", "btfi_gl_viewport(gl, 3, 3);")]),
    ("the masks of all draw buffers set by a fold", "fold_gl", [
        ("decoder/fold/gl_draw.c", "if (gl->ColorMaski) {", "if (gl->ColorMaski && gl->is_es) {")]),
    ("a plan that adds what shows against interpolated data alone", "plan", [
        ("decoder/plan/growth.c", "const double between = known ? difference[i] :", "const double between = known ? growth[i] :")]),
    ("a file without differences taken at its word", "plan", [
        ("decoder/plan/growth.c", "fmax(growth[i], (growth[i] + at_samples[i]) / 2)", "growth[i]")]),
    ("differences measured against what is decoded least", "effect_errors", [
        ("encoder/report/effect_errors.c", "const size_t full = j->n_variants - KINDS;", "const size_t full = 0;")]),
    ("a sum of lights that leaves the last out", "still_lights", [
        ("decoder/tools/render/shade_fold.c", "i < request->lights; i++", "i + 1 < request->lights; i++")]),
    ("a plan that counts on a fold that its scene does not make", "fold", [
        ("decoder/fold/fold.c", "if (scene->no_fold) {", "if (scene->no_fold > 1) {")]),
    ("relief and gloss left out by one another's worth", "plan_between", [
        ("decoder/plan/growth.c", "left + (gloss ? NO_GLOSS : NO_RELIEF)", "left + (gloss ? NO_RELIEF : NO_GLOSS)")]),
    ("what nobody knows the worth of left out", "plan_between", [
        ("decoder/plan/plan.c", "if (!l->known || (l->effects", "if ((l->effects")]),
    ("a coarser level planned by what level 0 loses", "plan_between", [
        ("decoder/plan/growth.c", "(float)(left_out + BTF_BETWEEN_NEXT_LEVEL * level)", "(float)left_out")]),
    ("errors without gloss foretold as with it", "plan_between", [
        ("decoder/plan/plan.c", "mse[i] + without.mse[i] - full->mse[i]", "mse[i]")]),
    ("rows of the table of errors lost for one another", "plan", [
        ("decoder/plan/table.c", "rows->next[r] = rows->first[slot];", "rows->next[r] = 0;")]),
    ("samples of coarser levels left out of level 0", "leave_one_out", [
        ("encoder/report/leave_one_out.c", "enc_evaluator_create(j->context, j->packed, (uint32_t)level,", "enc_evaluator_create(j->context, j->packed, 0 * (uint32_t)level,")]),
    ("more rows of errors measured than a table has", "effect_errors", [
        ("encoder/report/effect_errors.c", "info->levels < most ? info->levels : most", "info->levels < most ? info->levels : info->levels")]),
    ("rows of coarser levels where readers from before refuse them", "effect_errors", [
        ("decoder/exr_write.c", "if ((row[0] >= BTF_BETWEEN_NEXT_LEVEL) == coarser) {", "if (!coarser) {")]),
    ("rows of coarser levels accepted there", "effect_errors", [
        ("decoder/checks/effect_errors.c", "where == BTFI_BETWEEN_OF_LEVEL_0 ? 1 : levels", "where == BTFI_BETWEEN_OF_LEVEL_0 ? levels : levels")]),
    ("tables of different bands joined", "effect_errors", [
        ("decoder/header.c", "if (of_levels[i] != values[i]) {", "if (i < 2 && of_levels[i] != values[i]) {")]),
    ("room for fewer sets of effects than there are", "effect_errors", [
        ("encoder/report/effect_errors.c", "32 + 3 + 1,", "32 + 3,")]),
    ("what an effect is worth told of level 0", "plan_between", [
        ("decoder/plan/plan.c", "&plan->scene, &t, plan->level, effect, growth)", "&plan->scene, &t, 0 * plan->level, effect, growth)")]),
    ("between errors of levels in files of version 1", "effect_errors", [
        ("decoder/checks/effect_errors.c", "btfi_version(info) < 2 ? 1 : info->levels", "info->levels")]),
    ("parameters beyond 2^24 read", "decoder_bits", [
        ("decoder/shape.h", "magnitude <= BTFI_PARAMETER_MAX", "magnitude <= 2 * BTFI_PARAMETER_MAX")]),
    ("NaN taken for a coordinate", "decoder_bits", [
        ("reference/btf_addressing.c", "if (magnitude > 0x45800000u || magnitude < 0x00800000u)", "if (magnitude < 0x00800000u)")]),
    ("weights that do not sum to 4096", "decoder_bits", [
        ("reference/btf_directions.c", "{w0, w1, 4096 - w0 - w1}", "{w0, w1, 4095 - w0 - w1}")]),
    ("no upper bound of y", "decoder_bits", [
        ("reference/btf_source.c", "if (value > 0x1p32f)", "if (value < 0)")]),
    ("addresses of 32 bits", "decoder_bits", [
        ("reference/btf_source.c", "return ((size_t)layer * material->height + row) * material->width + column;",
         "return (layer * material->height + row) * material->width + column;")]),
    ("directions that are no numbers looked up", "decoder_bits", [
        ("reference/btf_evaluate.c", "if (l > 0x40000000u || v > 0x40000000u)", "if (l == v && l == 1)")]),
    ("shifts of negative numbers rounded to 0", "reference_relief", [
        ("reference/btf_reference_private.h", "return value >= 0 ? value >> shift : -1 - ((-1 - value) >> shift);",
         "return value / (1 << shift);")]),
    ("slopes to the horizon itself", "decoder_relief", [
        ("reference/btf_relief.c", "direction[2] >= 0.25f ? direction[2] : 0.25f", "direction[2] >= 0x1p-24f ? direction[2] : 0x1p-24f")]),
    ("slopes of more than 15 bits", "decoder_relief", [
        ("reference/btf_relief.c", "s = s <= 32767.0f ? s : 32767.0f;", "s = s <= 32768.0f ? s : 32768.0f;")]),
    ("slopes towards the view turned round", "reference_relief", [
        ("reference/btf_relief.c", "k = k + k;", "k = -k - k;")]),
    ("moves of every level as long as those of level 0", "reference_relief", [
        ("reference/btf_relief.c", "SLOPE_BITS + material->level", "SLOPE_BITS + 0 * material->level")]),
    ("positions that do not wrap", "decoder_relief", [
        ("reference/btf_relief.c", "return wrapped < 0 ? wrapped + length : wrapped;", "return wrapped < 0 ? 0 : wrapped;")]),
    ("rows of heights counted from below", "reference_relief", [
        ("reference/btf_relief.c", "material->height - 1 - ((size_t)position[1] >> 8)", "(size_t)position[1] >> 8")]),
    ("heights without their base", "reference_relief", [
        ("reference/btf_relief.c", "return material->relief_base + ((code", "return ((code")]),
    ("steps of a march rounded down", "decoder_relief", [
        ("reference/btf_relief.c", "(z - material->relief_base + steps - 1) / steps;", "(z - material->relief_base) / steps;")]),
    ("a ray that goes into a wall stopped at its top", "reference_relief", [
        ("reference/btf_relief.c", "return surface < z + descent ? surface : z + (descent >> 1);", "return surface;")]),
    ("a ray stopped where the march is, not at the surface", "reference_relief", [
        ("reference/btf_relief.c", "return surface < z + descent ? surface : z + (descent >> 1);", "return z + (descent >> 1);")]),
    ("relief switched, not faded", "reference_between", [
        ("reference/btf_relief.c", "share += (int32_t)views->weight[a];", "share = FULL_WEIGHT;")]),
    ("the point where the view sees it, in every view", "reference_relief", [
        ("reference/btf_relief.c", "wrap_position(point[0] - shift[0], material->width)", "wrap_position(point[0], material->width)")]),
    ("what stands lower hides", "reference_relief", [
        ("reference/btf_relief.c", "(shown - seen) * share", "(seen - shown) * share")]),
    ("hidden views left out altogether", "decoder_relief", [
        ("reference/btf_relief.c", "if (o < 1229) {\n        return 1229;", "if (o < 0) {\n        return 0;")]),
    ("no upper bound of what is visible", "reference_relief", [
        ("reference/btf_relief.c", "return o > FULL_WEIGHT ? FULL_WEIGHT : o;", "return o;")]),
    ("the rest of the weights given to a view of none", "reference_relief", [
        ("reference/btf_relief.c", "visible[2] > 0 ? fraction(visible[1], total) : FULL_WEIGHT - out_weights[0];", "fraction(visible[1], total);")]),
    ("weights of what is hidden where one view is wanted", "reference_relief", [
        ("reference/btf_relief.c", "if (!occlusion || flat)", "if (flat)")]),
    ("each view's texels blended by the first view's position", "reference_between", [
        ("reference/btf_evaluate.c", "(uint32_t)positions[a][0] << 10", "(uint32_t)positions[0][0] << 10")]),
    ("relief started at a texel's corner", "reference_between", [
        ("reference/btf_evaluate.c", "(column << 18) + half", "(column << 18)")]),
    ("the steep filter taken for the bilinear one", "reference_between", [
        ("reference/btf_evaluate.c", "if (filter == BTF_REF_STEEP)", "if (filter > BTF_REF_STEEP)")]),
    ("a steep filter of another slope", "reference_relief", [
        ("reference/btf_addressing.c", "uint32_t twice = 2 * weight;", "uint32_t twice = 2 * weight + 1;")]),
    ("gloss that follows the whole half vector", "reference_gloss", [
        ("reference/btf_gloss.c", "(float)material->gloss_share * 0.25f", "(float)material->gloss_share * 0.5f")]),
    ("gloss towards the view in place of away from it", "reference_gloss", [
        ("reference/btf_gloss.c", "d[i] = sampled[i] - view[i];", "d[i] = view[i] - sampled[i];")]),
    ("half vectors however short divided by", "decoder_relief", [
        ("reference/btf_gloss.c", "within(dot(h, h), 0.5f, 4.0f)", "within(dot(h, h), 0x1p-40f, 4.0f)")]),
    ("lights mirrored into the ground looked up there", "reference_gloss", [
        ("reference/btf_gloss.c", "c[2] = c[2] >= 0.0f ? c[2] : 0.0f;", "c[2] = c[2] >= -0.4f ? c[2] : -0.4f;")]),
    ("mirrored lights not brought to unit length", "reference_gloss", [
        ("reference/btf_gloss.c", "float n = btf_ref_pow(dot(c, c), 0.5f);", "float n = 1.0f;")]),
    ("a view taken for the sampled one by denormals", "decoder_relief", [
        ("reference/btf_gloss.c", "if (d[i] >= 0x1p-24f || d[i] <= -0x1p-24f)", "if (d[i] != 0.0f)")]),
    ("the same lights for every view, with gloss", "reference_between", [
        ("reference/btf_evaluate.c", "e.lights[a] = some_lights(lights, e.linear);", "e.lights[0] = some_lights(lights, e.linear);")]),
    ("three lights with gloss in nearest mode", "reference_between", [
        ("reference/btf_evaluate.c", "e.lights[a] = some_lights(lights, e.linear);", "e.lights[a] = some_lights(lights, true);")]),
    ("shares of views that begin one number early", "decoder_stochastic", [
        ("reference/btf_stochastic.c", "if (number < end)", "if (number + 1 < end)")]),
    ("views picked by other bits", "reference_stochastic", [
        ("reference/btf_stochastic.c", "random >> (32 - WEIGHT_BITS), end = 0", "random & (FULL_WEIGHT - 1), end = 0")]),
    ("views picked by the weights before occlusion", "reference_stochastic", [
        ("reference/btf_stochastic.c", "s.views.weight[a] = weights[a];", "weights[a] = s.views.weight[a];")]),
    ("lights picked by the view's number", "decoder_stochastic", [
        ("reference/btf_stochastic.c", "pick(&around, random[1])", "pick(&around, random[0])")]),
    ("the lights of the first view for every choice", "reference_stochastic", [
        ("reference/btf_stochastic.c", "btf_ref_gloss(material, s->views.index[a],", "btf_ref_gloss(material, s->views.index[0 * a],")]),
    ("columns and rows picked by the same bits", "reference_stochastic", [
        ("reference/btf_stochastic.c", "random >> 16 & 255u", "random >> 24 & 255u")]),
    ("the texel beside the one that is picked", "reference_stochastic", [
        ("reference/btf_stochastic.c", "number[axis] < weight ? far : near", "number[axis] < weight ? near : far")]),
    ("choices of directions below the horizon", "decoder_stochastic", [
        ("reference/btf_stochastic.c", "if (!btf_ref_above_horizon(light, view)) {\n        return;\n    }\n    scene s = set_scene(material, options, picks, u, v, light, view);\n    int a",
         "scene s = set_scene(material, options, picks, u, v, light, view);\n    int a")]),
    ("levels that are no numbers taken for the last", "decoder_stochastic", [
        ("reference/btf_stochastic.c", "if (bits > 0x7F800000u || bits == 0)", "if (bits == 0)")]),
    ("shares of two levels swapped", "reference_stochastic", [
        ("reference/btf_stochastic.c", "i == 0 ? 256 - share : share", "i == 0 ? share : 256 - share")]),
    ("another constant of the random numbers", "reference_stochastic", [
        ("reference/btf_stochastic.c", "uint32_t y = counter[1] * 1664525u", "uint32_t y = counter[1] * 1664523u")]),
    ("integers read where floats belong", "stability_files", [
        ("decoder/exr_read.c", "if (entry->pixel_type != type)", "if (entry->pixel_type != type && type == EXR_PIXEL_HALF)")]),
    ("attributes of another type read", "stability_files", [
        ("decoder/header/attributes.c", "if (attribute->type != type) {", "if (attribute->type != type && r->result) {")]),
    ("indices beyond the end of a list of points", "points", [
        ("decoder/checks/values.c", "if (index >= entries)", "if (index > 15)")]),
    ("the level of a relief lost where finer ones are cut away", "relief", [
        ("decoder/restrict.c", "small->relief_level += level;", "small->relief_level += 0 * level;")]),
    ("heights of level 0 seen at every level", "relief", [
        ("decoder/toolkit/reference_view.c", "btf_material_level_texture(material, level, BTF_TEXTURE_HEIGHTS)",
         "btf_material_texture(material, BTF_TEXTURE_HEIGHTS)")]),
    ("heights beyond 32767 read", "relief", [
        ("decoder/checks/info.c", "if (top > INT16_MAX)", "if (top > 2 * INT16_MAX)")]),
    ("relief on every view, whatever the file says", "relief", [
        ("decoder/header.c", "out->relief[v] = acts[v] != 0;", "out->relief[v] = acts[v] >= 0;")]),
    ("lights left out that gloss looks up", "relief", [
        ("decoder/restrict.c", "plan->effects & material->info.effects & BTF_EFFECT_GLOSS", "plan->level > BTF_MAX_LEVELS")]),
    ("relief taken for an effect of version 1", "relief", [
        ("decoder/shape.c", " || info->effects & BTFI_VECTOR_EFFECTS", "")]),
    ("relief at every level of detail, whatever the file says", "relief_end", [
        ("reference/btf_evaluate.c", "material->level >= material->relief_end;", "material->level > 2 * material->relief_end;")]),
    ("the end of relief not moved where finer levels are cut away", "relief_end", [
        ("decoder/restrict.c", "small->relief_end -= level;", "small->relief_end -= 0 * level;")]),
    ("relief kept where the levels that have it are cut away", "relief_end", [
        ("decoder/restrict.c", "if (btfi_relief_has_ended(info, level))", "if (level > info->levels)")]),
    ("an end of relief behind the last level read", "relief_end", [
        ("decoder/checks/info.c", "info->relief_end > info->levels)", "info->relief_end > 2 * info->levels)"),
        ("decoder/header.c", "(int32_t)info->levels, &info->levels", "BTF_MAX_LEVELS, &info->levels")]),
    ("relief planned at a level that has none", "relief_end", [
        ("decoder/plan/plan.c", "(btfi_relief_has_ended(&material->info, level) ? BTF_EFFECT_RELIEF : 0u)", "(level > BTF_MAX_LEVELS ? BTF_EFFECT_RELIEF : 0u)")]),
    ("the end of relief written where it has none", "relief_end", [
        ("decoder/exr_write.c", "if (info->relief_end < info->levels)", "if (info->relief_end > 0)")]),
    ("view vectors made where nothing needs them", "levels", [
        ("decoder/material.c", "if (!(m->info.effects & BTFI_VECTOR_EFFECTS)) {", "if (!m->info.effects) {")]),
    ("textures of any size taken from a short file", "file", [
        ("decoder/exr_read.c", "if (bytes / MAX_RATIO > s->size)", "if (bytes == 1)")]),
    ("memory of a part not given back", "memory", [
        ("decoder/exr_read.c", "    free(rows);\n", "")]),
    ("an allocation of the loader not looked at", "memory", [
        ("decoder/header.c", "    if (!d->xyz) {", "    if (d->count == 1000) {")]),
    ("textures kept when GL has no memory", "memory", [
        ("decoder/gl.c", "if (result != BTF_OK) {\n        btf_gl_destroy(&gl);", "if (result != BTF_OK) {\n        gl = NULL;")]),
    ("texels read that were never written", "valgrind", [
        ("decoder/material.c", "m->texture[level][id] = calloc(1, size);", "m->texture[level][id] = malloc(size);")]),
    ("threads that share the buffer of a product", "tsan", [
        ("encoder/factor/matrix.c", "float *panel = work + enc_thread_index() * each, *split", "float *panel = work, *split")]),
    ("the material written under its final name", "stability_faults", [
        ("decoder/save.c", "const int fd = btfi_temporary_create(path, &temporary);",
         "temporary = strdup(path);\n    const int fd = open(path, O_RDWR | O_CREAT | O_TRUNC, 0666);")]),
    ("failing writes not noticed", "stability_faults", [
        ("decoder/save.c", "errno = written == 0 ? ENOSPC : errno;\n            return false;", "return true;")]),
    ("temporary files of the dead left", "stability_faults", [
        ("decoder/temporary.c", "        remove_stale(directory, name, length);\n", "        (void)remove_stale;\n")]),
    ("temporary files of the living not locked", "output", [
        ("decoder/temporary.c", "while (flock(fd, LOCK_EX) != 0 && errno == EINTR)", "while (fd < 0)")]),
    ("the output not tried before the work", "stability_faults", [
        ("encoder/job/job.c", "result = try_output(context, job->output);",
         "result = job->report ? try_output(context, job->output) : BTF_OK;"),
        ("encoder/job/job.c", "result = try_output(context, job->report);", "result = BTF_OK;")]),
    ("damage that libjpeg paints over taken for a picture", "stability_images", [
        ("decoder/toolkit/jpeg_image.c", "    c->damaged = true;\n", "")]),
    ("pictures stored turned taken as they lie", "stability_images", [
        ("decoder/toolkit/exif.c", "return (int)value;", "return 1;")]),
    ("chroma taken for channels of every pixel", "exr", [
        ("decoder/pixels/exr_pixels.c", "(j->y + y) % ys == 0 ? (size_t)(width / xs) : 0", "ys > 0 ? (size_t)(width / xs) : 0")]),
    ("files of any size taken out of an archive", "stability_archives", [
        ("encoder/input/source_archive.c", "if (declared > (int64_t)ENC_SOURCE_MAX_FILE) {", "if (declared < 0) {"),
        ("encoder/input/source_archive.c", "if (size > ENC_SOURCE_MAX_FILE) {", "if (size == 1) {")]),
    ("links in an archive taken for images", "stability_archives", [
        ("encoder/input/source_archive.c", "!archive_entry_hardlink(entry)) {", "entry) {")]),
    ("angles of any length read", "names", [
        ("encoder/input/names.c", "if (value > 0.0 && digits++ == MAX_DIGITS)", "if (value < 0.0 && digits++ == MAX_DIGITS)")]),
    ("the evaluator: sums of class 1 shifted less", "evaluator", [
        ("decoder/evaluate/kernels.c", "class_index == 1 ? half >> 4", "class_index == 1 ? half >> 3")]),
    ("the evaluator: codes of u not turned around", "evaluator", [
        ("decoder/evaluate/arrange.c", "(byte ^ 2)", "byte")]),
    ("the evaluator: evaluations of other lights taken together", "evaluator", [
        ("decoder/evaluate/many.c", "memcmp(light, light - in->light_step, 3 * sizeof *light)", "memcmp(light, light - in->light_step, 2 * sizeof *light)")]),
    ("the evaluator: steep weights below 256", "evaluator", [
        ("decoder/evaluate/many.c", "twice - 128 > 256 ? 256", "twice - 128 > 255 ? 255")]),
    ("the evaluator: gloss below the horizon", "evaluator", [
        ("decoder/evaluate/directions.c", "    c[2] = c[2] >= 0.0f ? c[2] : 0.0f;\n", "")]),
    ("the evaluator: weights of hidden views off by one", "evaluator", [
        ("decoder/evaluate/relief.c", "o < 1229 ? 1229", "o < 1228 ? 1228")]),
    ("light sampling: the Jacobian's root", "sampling", [
        ("reference/btf_sampling.c", "    density = density * k;\n    density = density * k;\n", "    density = density * k;\n")]),
    ("light sampling: one of the turns left out", "sampling", [
        ("reference/btf_sampling.c", "height < unturned ? 0 : height < once ? 1 : 2", "height < unturned ? 0 : 1")]),
    ("light sampling: parts of triangles too large", "sampling", [
        ("decoder/evaluate/sampling.c", "row[i][0] = (uint32_t)(fmin(sum, 1 - share) * 0x1p32);", "row[i][0] = (uint32_t)(fmin(1.3 * sum, 1 - share) * 0x1p32);")]),
    ("a map and the material sampled, weighed as if one were", "sampled_environment", [
        ("decoder/tools/render/sampled_environment.c", "e->by_map * from.density +", "from.density +")]),
    ("sums and products without the run-time zero where there is no `precise`", "wgsl", [
        ("shaders/exact.glsl", "#define BTF_ROUND(x) uintBitsToFloat(floatBitsToUint(x) ^ BTF_ZERO)", "#define BTF_ROUND(x) (x)")]),
    ("a zero of WGSL that the compiler knows", "wgsl", [
        ("decoder/wgsl/wgsl.c", 'btfi_print(&w->out, "@group(%u) @binding(%u) var%s ", s->group, s->binding,\n               s->type.base == BTFI_TEXTURE ? "" : "<uniform>");',
         'btfi_print(&w->out, "@group(%u) @binding(%u) var%s ", s->group, s->binding,\n               s->type.base == BTFI_TEXTURE ? "" : "<private>");')]),
    ("both sides of ?: changed over in WGSL", "wgsl_translate", [
        ("decoder/wgsl/writer.c", "btfi_write_argument(w, n->c);", "btfi_write_argument(w, n->b);")]),
    ("what an out parameter gave not put where it belongs in WGSL", "wgsl_translate", [
        ("decoder/wgsl/write_statement.c", '" = kept__%u;\\n", number', '" == kept__%u;\\n", number')]),
    ("shifts without brackets in WGSL", "wgsl_translate", [
        ("decoder/wgsl/writer.c", "if (inner >= BITS || outer >= BITS) {", "if (inner > SHIFT) {")]),
    ("conditions of any depth in WGSL", "wgsl_translate", [
        ("decoder/wgsl/preprocess.c", "if (++c->depth > DEEPEST) {", "if (++c->depth == 0) {")]),
    ("units left unused after match was found", "factor_match", [
        ("encoder/factor/match/fit.c", "if (enc_factor_plan_error(&energies, &before, 0) < enc_factor_plan_error(&energies, plan, 0)) {",
         "if (enc_factor_plan_error(&energies, &before, 0) < 0) {")]),
    ("free codes of units left empty", "factor", [
        ("encoder/factor/components.c", "#define LEAST_ENERGY 1e-20", "#define LEAST_ENERGY 1e-11"),
        ("encoder/factor/factor.c", "result = enc_factor_fill_places(m, f->components, &f->codes);", "result = BTF_OK;")]),
    ("a reflectance alone weighed without its bytes", "reflectance", [
        ("encoder/job/reflectance.c", "w->tolerance * tenths", "w->tolerance * 0")]),
    ("a reflectance alone taken for its bytes where it lacks the quality", "reflectance", [
        ("encoder/job/reflectance.c", "(w->quality > 0 ? 0 : w->tolerance * tenths)", "(w->tolerance * tenths)")]),
    ("a reflectance alone taken where the factors alone have the quality", "reflectance", [
        ("encoder/job/reflectance.c", "if (w->quality > 0 && enc_psnr_srgb(factors) >= w->quality) {",
         "if (w->quality > 1e9 && enc_psnr_srgb(factors) >= w->quality) {")]),
    ("a bright relief taken for a plane", "tools_reflectance", [
        ("encoder/job/reflectance.c", "to[j] > most_measured", "to[j] > 1e9f * most_measured")]),
    ("empty places of a unit left empty", "factor_empty_places", [
        ("encoder/factor/factor.c", "result = enc_factor_fill_places(m, f->components, &f->codes);", "result = BTF_OK;")]),
    ("places beside a component left empty", "factor_empty_places", [
        ("encoder/factor/empty_places.c", "fill_group(&f, held, whole);", "(void)whole;")]),
    ("a program that runs no test passes", "listed", [
        ("tests/support/test.h", "if (tests_begun == 0 && failed == 0) {", "if (tests_begun > 48 && failed == 0) {")]),
    ("the same noise in every image of a sample", "sample", [
        ("tests/sample/camera.c", "noise_hash(seed, value, image, 0)", "noise_hash(seed, value, 0, 0)"),
        ("tests/sample/camera.c", "noise_hash(seed, value, image, 1)", "noise_hash(seed, value, 0, 1)")]),
    ("noise below black kept", "sample", [
        ("tests/sample/camera.c", "fmax(value + camera->noise * normal(camera->seed, number, (int)i), 0)",
         "value + camera->noise * normal(camera->seed, number, (int)i)")]),
    ("a name that the translator makes taken from the text in WGSL", "wgsl_translate", [
        ("decoder/wgsl/parser.c", "if (is_reserved && name->kind == BTFI_TOKEN_NAME) {", "if (is_reserved > 1) {")]),
    ("messages about GLSL that name what follows", "wgsl_translate", [
        ("decoder/wgsl/parser.c", 'fail(p, what, "at", at);', "(void)at, btfi_parse_fail(p, what);")]),
    ("btf-shader: a folder replaced without --force", "tools_shader", [
        ("decoder/tools/shader/folder.c", "if (!empty && !replace) {", "if (stranger[0] && !replace) {")]),
    ("btf-shader: the folder of a live run taken for a dead one's", "tools_shader", [
        ("decoder/tools/shader/folder.c", "if (flock(fd, LOCK_EX | LOCK_NB) == 0 && is_at(fd, path)) {", "if (is_at(fd, path)) {")]),
    ("btf-shader: levels of KTX files in the order of DDS", "tools_shader", [
        ("decoder/tools/shader/texture_file.c", "store == TEXTURE_STORE_KTX2 ? texture->count - 1 - i : i", "i")]),
    ("btf-shader: bindings told without --first-binding", "tools_shader", [
        ("decoder/tools/shader/manifest.c", "(int64_t)m->options->first_binding + t->levels.id", "(int64_t)t->levels.id")]),
    ("btf-shader: the uniform that stays 0 not told where it is needed", "tools_shader", [
        ("decoder/tools/shader/manifest.c", "if (facts->needs_zero && m->options->math == BTF_MATH_EXACT) {",
         "if (facts->needs_zero && m->options->math != BTF_MATH_EXACT) {")]),
]

TOOLS = ['encoder/btf-encode', 'encoder/btf-compare', 'decoder/tools/btf-info', 'decoder/tools/btf-decode',
         'tests/sample/btf-sample', 'tests/support/libmoment.so']


class NotBuilt(Exception):
    """A tree that does not compile."""


def folder_of(test):
    """The folder of the build with a test's program: that of its source, with two exceptions; None where there is
    none."""
    root = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    room, _, rest = test.partition('_')  # factor_match: of unit/factor/test_match.c
    sources = (glob.glob(f'{root}/*/**/test_{test}.c', recursive=True)
               or rest and glob.glob(f'{root}/*/{room}/test_{rest}.c'))
    return 'conformance' if test in ('evaluator', 'sampling') else os.path.relpath(sources[0], root).split('/')[0] if sources else None


def program(tree, test):
    """Returns (what ninja has to build, the command) of a test."""
    tests = f'{tree}/tests'
    if test in ('stability_faults', 'stability_archives'):
        return TOOLS, [f'{tests}/stability/test_{test[10:]}.sh']
    if test == 'tools_shader':
        return ['decoder/tools/shader/btf-shader', 'tests/support/libmoment.so'], ['env', 'BTF_TEST_LIGHT=1', f'{tests}/tools/test_shader.sh']
    if test == 'tools_reflectance':
        return TOOLS, ['env', 'BTF_TEST_LIGHT=1', f'{tests}/tools/test_reflectance.sh']
    if test == 'fuzz-exr':
        return [f'tests/fuzz/{test}'], [f'{tree}/build/tests/fuzz/{test}', f'{tests}/fuzz/corpus/exr']
    if test == 'valgrind':
        return ['tests/fuzz/fuzz-material'], [f'{tests}/valgrind.sh', f'{tree}/build', 'material']
    if test == 'tsan':
        return ['encoder/btf-encode'], [f'{tests}/tsan.sh']
    name = f'tests/{folder_of(test)}/test_{test}'
    return [name], [f'{tree}/build/{name}']


# A line about a failed case, as table.py or cmocka print it.
FAILURE = re.compile(r'CASE \| (.*?) \|.*\| FAIL$|\[  FAILED  \] (?!tests: )(.*)$')


def build(tree, targets):
    built = subprocess.run(['ninja', '-C', f'{tree}/build', *targets], capture_output=True, text=True)
    if built.returncode != 0:
        print(built.stdout[-3000:])
        raise NotBuilt


def run_test(tree, test):
    """Runs a test until its first case fails. Returns (exit code, output, that case or None)."""
    ran = subprocess.Popen(program(tree, test)[1], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors='replace',
                           start_new_session=True,
                           env={**os.environ, 'BTF_SOURCE_ROOT': tree, 'BTF_BUILD_ROOT': f'{tree}/build'})
    lines = []
    late = threading.Timer(LONGEST, os.killpg, (ran.pid, signal.SIGKILL))
    late.start()
    try:
        return read_test(ran, lines)
    finally:
        late.cancel()


def read_test(ran, lines):
    """Reads the output of a running test until it fails or ends, and returns as run_test does."""
    for line in ran.stdout:
        lines.append(line)
        failed = FAILURE.match(line.rstrip('\n'))
        if failed:
            os.killpg(ran.pid, signal.SIGKILL)
            ran.stdout.close()
            ran.wait()
            return 1, ''.join(lines), failed[1] or failed[2]
    code = ran.wait()
    return code, ''.join(lines), 'it does not end' if code == -signal.SIGKILL else None


class Tree:
    """A copy of the sources, with a build. Changed files are restored from a second copy."""

    def __init__(self, source, folder, targets):
        self.path, self.kept = os.path.join(folder, 'openbtf'), os.path.join(folder, 'kept')
        shutil.copytree(source, self.path, ignore=shutil.ignore_patterns('build*', '.git', '__pycache__'))
        subprocess.run(['meson', 'setup', f'{self.path}/build', self.path, *OPTIONS], check=True, capture_output=True)
        build(self.path, targets)

    def keep(self):
        shutil.copytree(self.path, self.kept, symlinks=True)

    def put_back(self):
        """Restores changed files with their times, so that ninja finds nothing to do."""
        for folder, folders, files in os.walk(self.path):
            kept = os.path.join(self.kept, os.path.relpath(folder, self.path))
            for name in files:
                now, was = os.path.join(folder, name), os.path.join(kept, name)
                if not os.path.lexists(was):
                    os.remove(now)
                elif changed(now, was):
                    shutil.copy2(was, now, follow_symlinks=False)
            for name in [name for name in folders if not os.path.isdir(os.path.join(kept, name))]:
                shutil.rmtree(os.path.join(folder, name))
                folders.remove(name)


def changed(now, was):
    a, b = os.lstat(now), os.lstat(was)
    return (a.st_mtime_ns, a.st_size) != (b.st_mtime_ns, b.st_size)


def check(tree, test, edits):
    """Returns (whether the test noticed, None where this machine cannot run it; what was seen)."""
    for path, old, new in edits:
        full = os.path.join(tree, path)
        with open(full, encoding='utf-8') as file:
            text = file.read()
        if text.count(old) != 1:
            return False, f'{path} has the text to change {text.count(old)} times'
        with open(full, 'w', encoding='utf-8') as file:
            file.write(text.replace(old, new))
    try:
        build(tree, program(tree, test)[0])
    except NotBuilt:
        return False, 'it does not build'
    code, output, case = run_test(tree, test)
    if code == 77:
        return None, output.strip()
    if code == 0:
        return False, f'{test} noticed nothing'
    how = f'it ends by signal {-code}' if code < 0 else f'it ends with code {code}'
    return True, f'{test}: {case or how}'


def applies(source):
    """Prints the changes whose text does not occur exactly once in the sources, or whose test does not exist; returns
    their number."""
    missing = 0
    for name, test, edits in CHANGES:
        if '/None/' in program('', test)[0][0]:
            print(f'{name}: there is no test {test}')
            missing += 1
        for path, old, _ in edits:
            with open(os.path.join(source, path), encoding='utf-8') as file:
                count = file.read().count(old)
            if count != 1:
                print(f'{name}: {path} has the text to change {count} times: {old}')
                missing += 1
    print(f'{len(CHANGES)} changes, {missing} that do not apply')
    return missing


def main():
    source = os.path.abspath(sys.argv[1])
    if sys.argv[2:] == ['--applies']:
        sys.exit(1 if applies(source) else 0)
    wanted = [change for change in CHANGES if len(sys.argv) == 2 or change[0] in sys.argv[2:]]
    tests = list(dict.fromkeys(test for _, test, _ in wanted))
    failures, failing = 0, []
    print('TITLE | Deliberately broken builds: the test that notices, and its first case that fails.')
    with tempfile.TemporaryDirectory(prefix='btf-broken-') as folder:
        os.environ['TMPDIR'] = folder  # holds the scratch files that an ended test leaves
        tree = Tree(source, folder, sorted({target for test in tests for target in program('', test)[0]}))
        report('the build')
        for test in tests:  # a test that fails without a change cannot show that it notices one
            if run_test(tree.path, test)[0] not in (0, 77):
                failing.append(test)
            report(test)
        failures += len(failing)
        print(f'CASE | nothing | each of the tests below passes | '
              f'{" ".join(failing) + " fail" if failing else "all of them do"} | {"FAIL" if failing else "pass"}', flush=True)
        tree.keep()
        for name, test, edits in wanted:
            noticed, seen = check(tree.path, test, edits)
            failures += noticed is False
            verdict = 'skip' if noticed is None else 'pass' if noticed else 'FAIL'
            print(f'CASE | {name} | {test} fails | {seen} | {verdict}', flush=True)
            tree.put_back()
            report(name)
    print(f'{len(wanted)} changes, {failures} unnoticed')
    sys.exit(1 if failures or not wanted else 0)


def report(name):
    """Prints to stderr the core seconds since the last report."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = used.ru_utime + used.ru_stime
    print(f'{seconds - report.before:6.1f} core s: {name}', file=sys.stderr, flush=True)
    report.before = seconds


report.before = 0

main()
