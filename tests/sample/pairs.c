/* Pairs of a view and a light between the samples of a grid. See pairs.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "pairs.h"

#include "decoder/toolkit/cli.h"
#include "decoder/toolkit/output.h"
#include "noise.h"

#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double PI = 3.14159265358979323846, LOWEST = 74;

/* Angles as file names hold them: azimuths of 0..360, 0 at the pole. */
static enc_direction rounded(double theta, double phi) {
    const double t = nearbyint(theta * 1e4) / 1e4;
    double p = nearbyint((phi - 360 * floor(phi / 360)) * 1e4) / 1e4;
    if (t == 0 || p >= 360) {
        p = 0;
    }
    return enc_direction_from_angles(t, p);
}

static bool same(const sample_pair *a, const sample_pair *b) {
    return a->view.theta == b->view.theta && a->view.phi == b->view.phi &&
           a->light.theta == b->light.theta && a->light.phi == b->light.phi;
}

static enc_direction random_direction(uint32_t seed, int i, int which) {
    const double z = 1 - (1 - cos(LOWEST * PI / 180)) * noise_hash(seed, i, which, 1);
    return rounded(acos(z) * 180 / PI, 360 * noise_hash(seed, i, which, 2));
}

btf_result pairs_random(const enc_context *context, int count, uint32_t seed, sample_pair **out_pairs) {
    sample_pair *pairs = malloc((size_t)count * sizeof *pairs);
    if (!pairs) {
        return enc_fail(context, BTF_ERROR_MEMORY, "out of memory for %d pairs", count);
    }
    for (int i = 0; i < count; ++i) {
        pairs[i] =
            (sample_pair){.view = random_direction(seed, i, 1), .light = random_direction(seed, i, 2)};
    }
    *out_pairs = pairs;
    return BTF_OK;
}

/* The fields of a line between blanks and commas, at most `most`; -1 for more. */
static int split(char *line, char **fields, int most) {
    static const char between[] = " \t,\r\n";
    int count = 0;
    for (char *at = strtok(line, between); at; at = strtok(NULL, between)) {
        if (count == most) {
            return -1;
        }
        fields[count++] = at;
    }
    return count;
}

/* One line that is not empty; *out_taken is false for titles. */
static btf_result take_line(const enc_context *context, const char *path, int number, char *line,
                            sample_pair *out, bool *out_taken) {
    char *fields[5];
    double angle[4];
    const int count = split(line, fields, 5);
    int numbers = 0;
    for (int i = 0; count >= 4 && i < 4; ++i) {
        numbers += cli_parse_double(fields[count - 4 + i], "", &angle[i], NULL);
    }
    *out_taken = numbers == 4;
    if (count >= 4 && numbers == 0 && number == 1) {
        return BTF_OK;
    }
    if (numbers != 4) {
        return enc_fail(context, BTF_ERROR_BAD_FILE,
                        "%s: line %d: expected theta and phi of the view, theta and phi of the light", path,
                        number);
    }
    for (int i = 0; i < 4; i += 2) {
        if (!(angle[i] >= 0 && angle[i] <= 85)) {
            return enc_fail(context, BTF_ERROR_BAD_FILE, "%s: line %d: theta %g of the %s is not in 0..85",
                            path, number, angle[i], i == 0 ? "view" : "light");
        }
    }
    *out = (sample_pair){.view = rounded(angle[0], angle[1]), .light = rounded(angle[2], angle[3])};
    return BTF_OK;
}

static btf_result append(const enc_context *context, const char *path, int number, const sample_pair *pair,
                         sample_pair **pairs, int *count) {
    for (int i = 0; i < *count; ++i) {
        if (same(&(*pairs)[i], pair)) {
            return enc_fail(context, BTF_ERROR_BAD_FILE, "%s: line %d: the pair of an earlier line again",
                            path, number);
        }
    }
    if (*count == PAIRS_MAX) {
        return enc_fail(context, BTF_ERROR_BAD_FILE, "%s: more than %d pairs", path, PAIRS_MAX);
    }
    sample_pair *more = realloc(*pairs, (size_t)(*count + 1) * sizeof *more);
    if (!more) {
        return enc_fail(context, BTF_ERROR_MEMORY, "%s: out of memory", path);
    }
    *pairs = more;
    more[(*count)++] = *pair;
    return BTF_OK;
}

btf_result pairs_read(const enc_context *context, const char *path, sample_pair **out_pairs,
                      int *out_count) {
    char line[4096];
    btf_result result = BTF_OK;
    FILE *file = fopen(path, "r");
    if (!file) {
        return enc_fail(context, BTF_ERROR_IO, "%s: %s", path, strerror(errno));
    }
    *out_pairs = NULL;
    *out_count = 0;
    for (int number = 1; result == BTF_OK && fgets(line, sizeof line, file); ++number) {
        sample_pair pair;
        bool taken = false;
        if (strlen(line) + 1 == sizeof line) {
            result = enc_fail(context, BTF_ERROR_BAD_FILE, "%s: line %d is longer than %zu bytes", path,
                              number, sizeof line - 2);
        }
        line[strcspn(line, "#\r\n")] = '\0';
        if (result == BTF_OK && line[strspn(line, " \t")]) {
            result = take_line(context, path, number, line, &pair, &taken);
        }
        if (result == BTF_OK && taken) {
            result = append(context, path, number, &pair, out_pairs, out_count);
        }
    }
    if (result == BTF_OK && ferror(file)) {
        result = enc_fail(context, BTF_ERROR_IO, "%s: %s", path, strerror(errno));
    }
    if (result == BTF_OK && *out_count == 0) {
        result = enc_fail(context, BTF_ERROR_BAD_FILE, "%s: holds no pair", path);
    }
    fclose(file);
    if (result != BTF_OK) {
        free(*out_pairs);
        *out_pairs = NULL;
    }
    return result;
}

btf_result pairs_turn(const enc_context *context, pairs_orbit orbit, int frames, double theta,
                      enc_direction fixed, sample_pair **out_pairs) {
    sample_pair *pairs = malloc((size_t)frames * sizeof *pairs);
    if (!pairs) {
        return enc_fail(context, BTF_ERROR_MEMORY, "out of memory for %d frames", frames);
    }
    fixed = rounded(fixed.theta, fixed.phi);
    for (int i = 0; i < frames; ++i) {
        const enc_direction moving = rounded(theta, 360.0 * i / frames);
        pairs[i] = (sample_pair){.view = orbit == PAIRS_ORBIT_VIEW ? moving : fixed,
                                 .light = orbit == PAIRS_ORBIT_VIEW ? fixed : moving};
    }
    *out_pairs = pairs;
    return BTF_OK;
}

void pairs_name(const sample_pair *pair, int frame, char *buffer) {
    int length = frame >= 0 ? snprintf(buffer, PAIRS_NAME, "frame%05d_", frame) : 0;
    snprintf(buffer + length, PAIRS_NAME - (size_t)length, "tl%07.4f_pl%08.4f_tv%07.4f_pv%08.4f",
             pair->light.theta, pair->light.phi, pair->view.theta, pair->view.phi);
}

btf_result pairs_write_table(const enc_context *context, const char *folder, const char *extension,
                             const sample_pair *pairs, int count) {
    char path[PATH_MAX], name[PAIRS_NAME];
    output *file = NULL;
    snprintf(path, sizeof path, "%s/directions.csv", folder);
    const btf_result result = output_open(path, context->log, &file);
    if (result != BTF_OK) {
        return result;
    }
    fprintf(output_stream(file), "file,theta_v,phi_v,theta_l,phi_l\n");
    for (int i = 0; i < count; ++i) {
        pairs_name(&pairs[i], i, name);
        fprintf(output_stream(file), "%s.%s,%.4f,%.4f,%.4f,%.4f\n", name, extension, pairs[i].view.theta,
                pairs[i].view.phi, pairs[i].light.theta, pairs[i].light.phi);
    }
    return output_commit(&file); /* reports a stream in error */
}
