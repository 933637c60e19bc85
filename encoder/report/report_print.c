/* The tables of a report, for people. See report_print.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "report_print.h"

#include "decoder/toolkit/between.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

static void print_rings(FILE *out, const char *what, int rings, const double *theta,
                        const enc_report *report, bool lights) {
    fprintf(out, "  %-20s", what);
    for (int r = 0; r < rings; r++) {
        fprintf(out, " %11.4g", theta[r]);
    }
    fprintf(out, "\n");
    for (int i = 0; i < report->n_ladder; i++) {
        const enc_metrics *m = &report->ladder[i].metrics;
        fprintf(out, "  %-20s", report->ladder[i].name);
        for (int r = 0; r < rings; r++) {
            const enc_error_sum *sum = lights ? &m->light_ring[r] : &m->view_ring[r];
            fprintf(out, " %5.2f/%5.2f", enc_psnr_linear(sum), enc_psnr_srgb(sum));
        }
        fprintf(out, "\n");
    }
}

/* Prints the error at samples whose light was, or would have been, in the way of the camera. */
static void print_coincident(const enc_report *report, FILE *out) {
    for (int i = 0; i < report->n_ladder; i++) {
        const enc_error_sum *sum = &report->ladder[i].metrics.coincident;
        if (sum->count > 0) {
            fprintf(out, "%s%s %.2f/%.2f%s", i == 0 ? "  light at the view: " : ", ",
                    report->ladder[i].name, enc_psnr_linear(sum), enc_psnr_srgb(sum),
                    i + 1 == report->n_ladder ? "\n" : "");
        }
    }
}

static void print_levels(const enc_report *report, FILE *out) {
    if (report->n_levels < 2) {
        return;
    }
    fprintf(out, "\n"
                 "Levels of detail, PSNR in dB of each against the area-filtered original\n");
    fprintf(out, "  %-8s %12s %10s %8s %8s\n", "level", "texels", "MB", "linear", "sRGB");
    for (int i = 0; i < report->n_levels; i++) {
        const enc_report_level *level = &report->level[i];
        char size[32];
        snprintf(size, sizeof size, "%d x %d", level->width, level->height);
        fprintf(out, "  %-8d %12s %10.3f %8.2f %8.2f\n", i, size, (double)level->gpu_bytes / 1e6,
                level->psnr_linear, level->psnr_srgb);
    }
}

static void print_truncations(const enc_report *report, const btf_material_info *info, FILE *out) {
    if (report->n_truncations < 2) {
        return;
    }
    fprintf(
        out,
        "\n"
        "Only the first %s of the residual decoded, at some samples, and between samples against the data\n"
        "interpolated there (PSNR in dB, linear / sRGB)\n"
        "  %-12s %10s %16s %16s\n",
        enc_report_part_name(info), enc_report_part_name(info), "MB", "samples", "between");
    for (size_t i = 0; i < report->n_truncations; i++) {
        const enc_truncation *t = &report->truncations[i];
        fprintf(out, "  %-12u %10.3f    %5.2f / %5.2f    %5.2f / %5.2f\n", t->components,
                t->gpu_bytes / 1e6, enc_psnr_linear(&t->samples), enc_psnr_srgb(&t->samples),
                enc_psnr_linear(&t->between), enc_psnr_srgb(&t->between));
    }
}

/* Prints the textures of all levels, and how many bytes each takes for a texel of level 0. */
static void print_parts(const enc_report *report, const btf_material_info *info, FILE *out) {
    const double texels = (double)enc_data_texel_count(report->data);
    fprintf(
        out,
        "\nBytes by texture (tables of directions and scales are not part of the sum)\n  %-24s %10s %14s\n",
        "", "MB", "bytes a texel");
    for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
        double bytes = 0;
        for (uint32_t level = 0; level < info->levels; level++) {
            bytes += (double)btf_material_level_texture(report->material, level, (btf_texture_id)id).size;
        }
        if (bytes > 0) {
            fprintf(out, "  %-24s %10.3f %14.1f\n", btf_texture_name((btf_texture_id)id), bytes / 1e6,
                    bytes / texels);
        }
    }
    fprintf(out, "  %-24s %10.3f %14.1f\n", "sum", (double)info->gpu_bytes / 1e6,
            (double)info->gpu_bytes / texels);
}

/* Prints how much of a budget was left, and why. */
static void print_unspent(const enc_unspent *u, FILE *out) {
    if (u->budget == 0) {
        return;
    }
    fprintf(out,
            "\n"
            "Budget: %.3f of %.3f MB is used. ",
            (double)u->bytes / 1e6, (double)u->budget / 1e6);
    if (u->gain > 0) {
        fprintf(out,
                "At samples left out of the fit, a tenth more bytes gains less than %g dB,\n"
                "the whole budget %.2f dB. ",
                u->tolerance, u->gain);
    } else {
        fprintf(out, "No further unit of factors fits and gains.\n");
    }
    fprintf(out, "Components found to be signal, not noise:");
    for (int c = 0; c < 3; c++) {
        fprintf(out, "%s %" PRIu64 "%s", c > 0 ? "," : "", u->signal[c], u->ends[c] ? "" : " or more");
    }
    fprintf(out, " of Y, C1 and C2\n");
}

/* Prints the traffic between ranks, as rank 0 counted it. */
static void print_volumes(const enc_report *report, FILE *out) {
    enc_ranks_volume all = {0};
    if (report->n_volumes == 0) {
        return;
    }
    fprintf(out,
            "\n"
            "%d ranks; traffic of rank 0 (MB = 10^6 bytes; seconds)\n",
            report->ranks);
    fprintf(out, "  %-20s %10s %10s %9s %9s %9s\n", "", "received", "sent", "meetings", "waited", "moved");
    for (size_t i = 0; i <= report->n_volumes; i++) {
        const enc_ranks_volume *v = i < report->n_volumes ? &report->volumes[i] : &all;
        fprintf(out, "  %-20s %10.2f %10.2f %9llu %9.2f %9.2f\n",
                i < report->n_volumes ? v->stage : "total", (double)v->received / 1e6,
                (double)v->sent / 1e6, (unsigned long long)v->meetings, v->waited, v->moved);
        all.received += v->received;
        all.sent += v->sent;
        all.meetings += v->meetings;
        all.waited += v->waited;
        all.moved += v->moved;
    }
}

/* Prints an effect that changes nothing at the samples, and what it is worth between them where that is
 * estimated. */
static void print_between_effect(const enc_report_step *without, const enc_report *report, FILE *out) {
    const enc_left_out_errors *e = &report->between.error[ENC_LEFT_VIEW];
    fprintf(out, "  %-28s acts between the samples only", without->name);
    if (strcmp(without->name, "relief") == 0 && e->no_relief.count > 0) {
        fprintf(out, ": removes %.2f/%.2f dB where views are left out",
                enc_psnr_linear(&e->material) - enc_psnr_linear(&e->no_relief),
                enc_psnr_srgb(&e->material) - enc_psnr_srgb(&e->no_relief));
    }
    fprintf(out, "\n");
}

void enc_report_print(const enc_report *report, FILE *out) {
    const enc_data *data = report->data;
    const enc_metrics *first = &report->ladder[0].metrics;
    const enc_report_step *full = &report->ladder[report->n_ladder - 1];
    const double all = enc_report_data_bytes(data);
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(report->material, &info);
    fprintf(out, "\n%s: %d x %d texels, %d views, %d lights; method %s\n", report->input, data->width,
            data->height, data->n_views, data->n_lights, report->method);
    if (report->has_hidden) {
        fprintf(out, "\nTable 1. Hidden surface points (paper, table 1)\n");
        fprintf(out, "  %-24s %12s %12s\n", "", "not hidden", "hidden");
        fprintf(out, "  %-24s %12zu %12zu\n", "before refinement",
                report->hidden_total - report->hidden_before, report->hidden_before);
        fprintf(out, "  %-24s %12zu %12zu\n", "after refinement",
                report->hidden_total - report->hidden_after, report->hidden_after);
    }
    fprintf(out, "\nTable 2. Storage on the GPU (paper, table 2; MB = 10^6 bytes)\n");
    fprintf(out, "  %-24s %10s %12s\n", "", "MB", "ratio");
    fprintf(out, "  %-24s %10.3f %11.2f%%\n", "BTF", all / 1e6, 0.0);
    for (int i = 0; i < report->n_ladder; i++) {
        const double bytes = (double)report->ladder[i].gpu_bytes;
        fprintf(out, "  %-24s %10.3f %11.2f%%\n", report->ladder[i].name, bytes / 1e6,
                100 * (1 - bytes / all));
    }
    if (report->n_levels > 1) {
        const double further = (double)enc_report_further_bytes(report), bytes = (double)full->gpu_bytes + further;
        fprintf(out, "  %-24s %10.3f\n", "levels 1 and up", further / 1e6);
        fprintf(out, "  %-24s %10.3f %11.2f%%\n", "full, all levels", bytes / 1e6, 100 * (1 - bytes / all));
    }
    fprintf(out, "  %-24s %10.3f %11.2f%%\n", "material file", (double)report->file_bytes / 1e6,
            100 * (1 - (double)report->file_bytes / all));
    print_parts(report, &info, out);
    print_unspent(&report->unspent, out);
    fprintf(out, "\nAccuracy over all samples, clipped to [0, 1] (PSNR in dB, linear and sRGB-coded)\n");
    fprintf(out, "  %-20s %8s %8s %8s\n", "", "linear", "sRGB", "SSIM");
    for (int i = 0; i < report->n_ladder; i++) {
        const enc_metrics *m = &report->ladder[i].metrics;
        fprintf(out, "  %-20s %8.2f %8.2f %8.4f\n", report->ladder[i].name, enc_psnr_linear(&m->total),
                enc_psnr_srgb(&m->total), m->ssim);
    }
    for (int i = 0; i < report->n_without; i++) {
        const enc_metrics *m = &report->without[i].metrics;
        if ((report->without[i].effects ^ full->effects) & BETWEEN_EFFECTS) {
            print_between_effect(&report->without[i], report, out);
            continue;
        }
        fprintf(out, "  without %-12s %8.2f %8.2f   (%s removes %.2f/%.2f dB)\n", report->without[i].name,
                enc_psnr_linear(&m->total), enc_psnr_srgb(&m->total), report->without[i].name,
                enc_psnr_linear(&full->metrics.total) - enc_psnr_linear(&m->total),
                enc_psnr_srgb(&full->metrics.total) - enc_psnr_srgb(&m->total));
    }
    fprintf(out, "\n");
    print_rings(out, "by view theta", first->n_view_rings, first->view_ring_theta, report, false);
    fprintf(out, "\n");
    print_rings(out, "by light theta", first->n_light_rings, first->light_ring_theta, report, true);
    print_coincident(report, out);
    print_truncations(report, &info, out);
    fprintf(out, "\n");
    enc_leave_one_out_print(&report->between, out);
    if (report->fit) {
        enc_fit_print(report->fit, enc_report_at_samples(report), out);
    }
    if (report->relief) {
        enc_relief_print(report->relief, out);
    }
    print_levels(report, out);
    print_volumes(report, out);
    fprintf(out, "\nSeconds:");
    size_t count = 0;
    const progress_stage *stages = progress_stages(report->progress, &count);
    for (size_t i = 0; i < count; i++) {
        fprintf(out, " %s %.1f,", stages[i].name, stages[i].seconds);
    }
    fprintf(out, " total %.1f. Peak memory %.0f MB.\n\n", report->seconds_total,
            (double)report->peak_rss / 1e6);
}
