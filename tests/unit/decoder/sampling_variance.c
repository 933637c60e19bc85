/* sampling_variance FILE...: compares the noise of two estimates of reflected radiance, by quadrature, under three
 * lights: one draws directions by the tables of a material (decoder/SAMPLING.md), one by the cosine. Prints the ratio
 * of their variances.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/toolkit/reference_view.h"

#include <openbtf/reference.h>
#include <openbtf/sampling.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

#define PI 3.14159265358979323846

enum {
    SIDE = 96,
    CELLS = SIDE * SIDE,
    VIEWS = 6,
    TEXELS = 6,
    WHITE = 0,
    SUN_AND_SKY = 1,
    AREA = 2,
    PLACES = 12,
    LIGHTS = AREA + PLACES
};

/* Cells of the plane of section 6: the direction to the light, and the solid angle of each. */
static float cell_light[CELLS][3];
static double cell_solid[CELLS];

static void make_cells(void) {
    for (int i = 0; i < CELLS; i++) {
        const double r = (i / SIDE + 0.5) / SIDE, phi = 2 * PI * (i % SIDE + 0.5) / SIDE,
                     k = 2 / (1 + r * r);
        cell_light[i][0] = (float)(k * r * cos(phi));
        cell_light[i][1] = (float)(k * r * sin(phi));
        cell_light[i][2] = (float)(k - 1);
        cell_solid[i] = k * k * r * (1.0 / SIDE) * (2 * PI / SIDE);
    }
}

static void direction(double cosine, double phi, double out[3]) {
    const double sine = sqrt(1 - cosine * cosine);
    out[0] = sine * cos(phi);
    out[1] = sine * sin(phi);
    out[2] = cosine;
}

static double angle_to(const float a[3], const double b[3]) {
    return acos(fmin((double)a[0] * b[0] + (double)a[1] * b[1] + (double)a[2] * b[2], 1)) * 180 / PI;
}

/* The radiance that arrives from a direction. */
static double shines(int light, const float from[3]) {
    double at[3];
    if (light == WHITE) {
        return 1;
    }
    if (light == SUN_AND_SKY) {
        direction(cos(50 * PI / 180), 0.7, at);
        return 0.4 + 0.6 * (1 - (double)from[2]) + (angle_to(from, at) < 4 ? 60 : 0);
    }
    direction(1 - (light - AREA + 0.5) / PLACES, 2.39996 * (light - AREA), at);
    return angle_to(from, at) < 6 ? 1 : 0;
}

/* Adds the variances of one texel in one view: by the tables, by the cosine. */
static void add_variances(float rgb[CELLS][3], const float *pdf, double sums[LIGHTS][2]) {
    for (int light = 0; light < LIGHTS; light++) {
        double mean = 0, squares[2] = {0, 0};
        for (int i = 0; i < CELLS; i++) {
            const double luminance =
                0.2126 * (double)rgb[i][0] + 0.7152 * (double)rgb[i][1] + 0.0722 * (double)rgb[i][2];
            const double value = shines(light, cell_light[i]) * luminance;
            mean += value * cell_solid[i];
            squares[0] += value * value / (double)pdf[i] * cell_solid[i];
            squares[1] += value * value * PI / (double)cell_light[i][2] * cell_solid[i];
        }
        for (int way = 0; way < 2; way++) {
            sums[light][way] += squares[way] - mean * mean;
        }
    }
}

static btf_result measure(const char *path, double sums[LIGHTS][2]) {
    btf_material *material = NULL;
    btf_evaluator *evaluator = NULL;
    btf_light_sampling *tables = NULL;
    btf_result result = btf_material_open(path, NULL, &material);
    if (!result) {
        result = btf_evaluator_create(material, NULL, &evaluator);
    }
    if (!result) {
        result = btf_light_sampling_create(material, evaluator, NULL, &tables);
    }
    for (int v = 0; v < VIEWS && !result; v++) {
        static float pdf[CELLS], uv[CELLS][2], rgb[CELLS][3];
        const btf_ref_sampling sampling = {tables->n_triangles, tables->triangles, tables->densities};
        btf_ref_material reference;
        double at[3];
        direction(cos(v * 13 * PI / 180), 2.4 * v, at);
        const float view[3] = {(float)at[0], (float)at[1], (float)at[2]};
        reference_view(material, 0, &reference);
        for (int i = 0; i < CELLS; i++) {
            pdf[i] = btf_ref_pdf_light(&reference, &sampling, 0, 0, view, cell_light[i]);
        }
        for (int t = 0; t < TEXELS && !result; t++) {
            for (int i = 0; i < CELLS; i++) {
                uv[i][0] = (float)fmod(0.5 + 0.7549 * t, 1);
                uv[i][1] = (float)fmod(0.5 + 0.5698 * t, 1);
            }
            const btf_evaluations of = {.struct_size = sizeof of,
                                        .count = CELLS,
                                        .uv = uv[0],
                                        .lights = cell_light[0],
                                        .views = view,
                                        .fixed = BTF_FIXED_VIEW,
                                        .rgb = rgb[0]};
            result = btf_evaluate_many(evaluator, NULL, &of);
            add_variances(rgb, pdf, sums);
        }
    }
    btf_light_sampling_destroy(&tables);
    btf_evaluator_destroy(&evaluator);
    btf_material_close(&material);
    return result;
}

int main(int argc, char **argv) {
    make_cells();
    printf("| | white | sun and sky | area | worst place |\n| --- | --- | --- | --- | --- |\n");
    for (int file = 1; file < argc; file++) {
        double sums[LIGHTS][2] = {{0}}, area[2] = {0, 0}, worst = 0;
        const btf_result result = measure(argv[file], sums);
        if (result) {
            fprintf(stderr, "sampling_variance: %s: %s\n", argv[file], btf_result_text(result));
            return btf_result_exit_code(result);
        }
        for (int light = AREA; light < LIGHTS; light++) {
            area[0] += sums[light][0];
            area[1] += sums[light][1];
            worst = fmax(worst, sums[light][0] / sums[light][1]);
        }
        printf("| %s | %.2f | %.2f | %.2f | %.2f |\n", argv[file], sums[WHITE][0] / sums[WHITE][1],
               sums[SUN_AND_SKY][0] / sums[SUN_AND_SKY][1], area[0] / area[1], worst);
    }
    return 0;
}
