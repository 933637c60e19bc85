/* The command-line options that say how a data set is read. See options.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "options.h"

#include <ctype.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>

const char *enc_parse_transfer(const char *text, void *options) {
    enc_read_options *r = options;
    if (strcmp(text, "srgb") == 0) {
        r->transfer = ENC_TRANSFER_SRGB;
    } else if (strcmp(text, "linear") == 0) {
        r->transfer = ENC_TRANSFER_LINEAR;
    } else {
        double gamma;
        if (strncmp(text, "gamma:", 6) != 0 || !cli_parse_double(text + 6, "", &gamma, NULL) ||
            !(gamma >= 0.1 && gamma <= 10)) {
            return "srgb, linear or gamma:G with G from 0.1 to 10";
        }
        r->transfer = ENC_TRANSFER_GAMMA;
        r->gamma = gamma;
    }
    return NULL;
}

const char *enc_parse_colour(const char *text, void *options) {
    enc_read_options *r = options;
    if (strcmp(text, "rgb") == 0) {
        r->colour = ENC_COLOUR_RGB;
    } else if (strcmp(text, "xyz") == 0) {
        r->colour = ENC_COLOUR_XYZ;
    } else {
        return "rgb or xyz";
    }
    return NULL;
}

const char *enc_parse_cosine(const char *text, void *options) {
    enc_read_options *r = options;
    if (strcmp(text, "included") == 0) {
        r->cosine = ENC_COSINE_INCLUDED;
    } else if (strcmp(text, "missing") == 0) {
        r->cosine = ENC_COSINE_MISSING;
    } else {
        return "included or missing";
    }
    return NULL;
}

const char *enc_parse_crop(const char *text, void *options) {
    enc_read_options *r = options;
    const bool size_alone = strchr(text, 'x');
    int c[4] = {0};
    const char *at = text;
    for (int i = size_alone ? 2 : 0; i < 4; i++) {
        char *end;
        const long value = isdigit((unsigned char)*at) ? strtol(at, &end, 10) : -1;
        if (value < (i < 2 ? 0 : 1) || value > INT_MAX ||
            *end != (i == 3       ? '\0'
                     : size_alone ? 'x'
                                  : ',')) {
            return "X,Y,W,H or WxH in pixels: X and Y at least 0, W and H at least 1";
        }
        c[i] = (int)value;
        at = end + 1;
    }
    memcpy(r->crop, c, sizeof c);
    return NULL;
}
