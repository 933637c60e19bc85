/* Environment maps: median cut into directional lights.
 *
 * SPDX-License-Identifier: MIT
 */
#include "environment.h"

#include "decoder/toolkit/exr_image.h"
#include "decoder/toolkit/hdr_image.h"
#include "decoder/toolkit/file.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_PIXELS = 1 << 26 };

/* Sums from which those over rectangles of the map follow. */
typedef struct table {
    int width, height;
    double *sums; /* [height + 1][width + 1] of luminance times solid angle */
} table;

typedef struct region {
    int x0, y0, x1, y1; /* half open */
} region;

static double region_sum(const table *t, region r) {
    const size_t stride = (size_t)t->width + 1;
    const double *top = t->sums + (size_t)r.y0 * stride, *bottom = t->sums + (size_t)r.y1 * stride;
    return bottom[r.x1] - bottom[r.x0] - top[r.x1] + top[r.x0];
}

/* Solid angle of a pixel of row y. */
static double solid_angle(const table *t, int y) {
    double a = RENDER_PI * y / t->height, b = RENDER_PI * (y + 1) / t->height;
    return (cos(a) - cos(b)) * (2 * RENDER_PI / t->width);
}

static bool is_usable(float value) {
    return value >= 0 && value <= 1e30f;
}

static void channels(const table *t, const float *pixels, int x, int y, double out[3]) {
    const float *p = pixels + 3 * ((size_t)y * (size_t)t->width + (size_t)x);
    for (int c = 0; c < 3; c++) {
        out[c] = is_usable(p[c]) ? (double)p[c] : 0;
    }
}

static double luminance(const double rgb[3]) {
    return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

static void fill(table *t, const float *pixels) {
    const size_t stride = (size_t)t->width + 1;
    for (int y = 0; y < t->height; y++) {
        double row = 0;
        for (int x = 0; x < t->width; x++) {
            double rgb[3];
            channels(t, pixels, x, y, rgb);
            row += luminance(rgb) * solid_angle(t, y);
            t->sums[(size_t)(y + 1) * stride + (size_t)x + 1] =
                t->sums[(size_t)y * stride + (size_t)x + 1] + row;
        }
    }
}

/* Cuts the longer side (columns shrink towards the poles) where the halves are most alike. */
static void cut(const table *t, region r, region *out_a, region *out_b) {
    double middle = RENDER_PI * (r.y0 + r.y1) / 2 / t->height;
    bool across = (r.x1 - r.x0) * sin(middle) * 2 / t->width >= (double)(r.y1 - r.y0) / t->height;
    if (r.x1 - r.x0 < 2) {
        across = false;
    }
    if (r.y1 - r.y0 < 2) {
        across = true;
    }
    const double half = region_sum(t, r) / 2;
    *out_a = *out_b = r;
    int low = across ? r.x0 + 1 : r.y0 + 1, high = across ? r.x1 - 1 : r.y1 - 1, at = low;
    for (double best = INFINITY; low <= high; low++) {
        region a = r;
        *(across ? &a.x1 : &a.y1) = low;
        double off = fabs(region_sum(t, a) - half);
        if (off < best) {
            best = off;
            at = low;
        }
    }
    *(across ? &out_a->x1 : &out_a->y1) = at;
    *(across ? &out_b->x0 : &out_b->y0) = at;
}

/* Adds the light of a region: it has all of the energy, and comes from the centre of that. */
static bool add_light(light_list *list, const table *t, const float *pixels, region r, double rotate,
                      double gain) {
    light l = {0};
    vec3 centre = {0};
    for (int y = r.y0; y < r.y1; y++) {
        for (int x = r.x0; x < r.x1; x++) {
            double rgb[3], theta = RENDER_PI * (y + 0.5) / t->height,
                           longitude = (x + 0.5) / t->width * 2 * RENDER_PI - RENDER_PI;
            channels(t, pixels, x, y, rgb);
            longitude += rotate * (RENDER_PI / 180);
            vec3 d = vec(sin(theta) * sin(longitude), cos(theta), -sin(theta) * cos(longitude));
            double weight = solid_angle(t, y);
            centre = vec_add(centre, vec_mul(d, weight * luminance(rgb)));
            for (int c = 0; c < 3; c++) {
                l.colour[c] += rgb[c] * weight * (gain / RENDER_PI);
            }
        }
    }
    if (!(luminance(l.colour) > 0)) {
        return true;
    }
    l.at = vec_unit(centre, vec(0, 1, 0));
    return light_list_add(list, l);
}

btf_result light_list_add_environment(light_list *list, int width, int height, const float *pixels,
                                      int count, double rotate, double gain) {
    table t = {width, height, calloc(((size_t)width + 1) * ((size_t)height + 1), sizeof(double))};
    region *regions = calloc((size_t)count, sizeof *regions);
    bool ok = t.sums && regions;
    if (ok) {
        fill(&t, pixels);
        regions[0] = (region){0, 0, width, height};
        int have = 1;
        while (have < count) {
            int before = have;
            for (int i = 0; i < before && have < count; i++) {
                if (regions[i].x1 - regions[i].x0 > 1 || regions[i].y1 - regions[i].y0 > 1) {
                    region whole = regions[i];
                    cut(&t, whole, &regions[i], &regions[have++]);
                }
            }
            if (have == before) {
                break; /* every region is a single pixel */
            }
        }
        for (int i = 0; i < have && ok; i++) {
            ok = add_light(list, &t, pixels, regions[i], rotate, gain);
        }
    }
    free(regions);
    free(t.sums);
    return ok ? BTF_OK : BTF_ERROR_MEMORY;
}

/* Notes values and shapes that are not as they should be, but do not stop the reading. */
static void note_contents(int width, int height, const float *pixels, image_info *info) {
    const size_t count = (size_t)width * (size_t)height * 3;
    size_t unusable = 0, first = 0;
    for (size_t i = 0; i < count; i++) {
        if (!is_usable(pixels[i]) && unusable++ == 0) {
            first = i;
        }
    }
    if (unusable > 0) {
        image_note(info, IMAGE_NOTE_RANGE,
                   "%zu samples that are below 0, infinite or not a number are taken as 0: the first is %g "
                   "in column %zu, row %zu",
                   unusable, (double)pixels[first], first / 3 % (size_t)width, first / 3 / (size_t)width);
    }
    if (abs(width - 2 * height) > 1 + width / 50) {
        image_note(info, IMAGE_NOTE_ENVMAP,
                   "%d x %d pixels are taken as latitude and longitude of the whole sphere, which is twice "
                   "as wide "
                   "as high",
                   width, height);
    }
}

/* Makes three channels of one and frees that; NULL when out of memory. */
static float *spread_grey(float *grey, size_t count) {
    float *rgb = malloc(count * 3 * sizeof *rgb);
    for (size_t i = 0; i < 3 * count && rgb; i++) {
        rgb[i] = grey[i / 3];
    }
    free(grey);
    return rgb;
}

btf_result environment_read(const char *path, const char *layer, const btf_log *log, int *out_width,
                            int *out_height, float **out_pixels) {
    char *data = NULL, message[600] = "";
    size_t size = 0;
    float *pixels = NULL;
    int width = 0, height = 0;
    *out_pixels = NULL;
    image_info info = {0};
    btf_result result = file_read(path, (size_t)1 << 31, log, &data, &size);
    if (result) {
        return result;
    }
    if (size >= 2 && !memcmp(data, "#?", 2) && layer) {
        result = BTF_ERROR_UNSUPPORTED;
        snprintf(message, sizeof message, "option --layer: '%s', but a Radiance map has no layers", layer);
    } else if (size >= 2 && !memcmp(data, "#?", 2)) {
        bool xyz = false;
        result = hdr_image_read(data, size, MAX_PIXELS, &width, &height, &xyz, &pixels, &info, message,
                                sizeof message);
        if (!result && xyz) {
            result = BTF_ERROR_UNSUPPORTED;
            snprintf(message, sizeof message, "colours are XYZ: convert to R, G, B");
        }
    } else if (size >= 1 && (size < 4 || memcmp(data, "\x76\x2f\x31\x01", 4) != 0)) {
        result = BTF_ERROR_BAD_FILE;
        snprintf(message, sizeof message, "is neither an OpenEXR nor a Radiance HDR file");
    } else {
        exr_image image = {0};
        result = exr_image_read(data, size, MAX_PIXELS, layer, &image, &info, message, sizeof message);
        pixels = image.pixels;
        width = image.width;
        height = image.height;
        if (!result && (image.xyz || image.cube)) {
            result = BTF_ERROR_UNSUPPORTED;
            snprintf(message, sizeof message, "%s, expected R, G, B around the whole sphere",
                     image.cube ? "the faces of a cube" : "colours are XYZ");
        } else if (!result && image.channels == 1 &&
                   !(pixels = spread_grey(pixels, (size_t)width * (size_t)height))) {
            result = BTF_ERROR_MEMORY;
            snprintf(message, sizeof message, "out of memory for a map");
        }
    }
    free(data);
    if (!result && info.converts) {
        primaries_apply(info.to_rec709, (size_t)width * (size_t)height, pixels);
        image_note(&info, IMAGE_NOTE_PRIMARIES, "%s: converted to Rec. 709", info.primaries_name);
    }
    if (!result) {
        note_contents(width, height, pixels, &info);
        image_notes_log(&info.notes, path, log);
    }
    if (result) {
        file_say(log, "%s: %s", path, message);
        free(pixels);
        return result;
    }
    *out_width = width;
    *out_height = height;
    *out_pixels = pixels;
    return BTF_OK;
}

btf_result light_list_read_environment(light_list *list, const char *path, const char *layer, int count,
                                       double rotate, double gain, const btf_log *log) {
    float *pixels;
    int width, height;
    btf_result result = environment_read(path, layer, log, &width, &height, &pixels);
    if (result) {
        return result;
    }
    result = light_list_add_environment(list, width, height, pixels, count, rotate, gain);
    if (result) {
        file_say(log, "%s: out of memory for the lights of a map", path);
    }
    free(pixels);
    return result;
}
