/* The attributes of an OpenEXR file that say what its pixels mean. See attributes.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "attributes.h"

#include <ctype.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

/* Reads the file's chromaticities; they are Rec. 709's where the file has none, or where its channels are X, Y, Z or a
 * spectrum. Returns whether the file has any that apply. */
static bool take_chromaticities(exr_const_context_t context, const exr_choice *choice,
                                primaries *out_primaries, image_info *info) {
    exr_attr_chromaticities_t c;
    *out_primaries = primaries_rec709;
    if (exr_attr_get_chromaticities(context, choice->part, "chromaticities", &c) != EXR_ERR_SUCCESS ||
        choice->kind == EXR_KIND_XYZ || choice->kind == EXR_KIND_SPECTRUM) {
        return false;
    }
    *out_primaries = (primaries){{(double)c.red_x, (double)c.red_y},
                                 {(double)c.green_x, (double)c.green_y},
                                 {(double)c.blue_x, (double)c.blue_y},
                                 {(double)c.white_x, (double)c.white_y}};
    if (choice->kind != EXR_KIND_GREY) {
        image_info_primaries(info, "EXR chromaticities", out_primaries);
    }
    return true;
}

/* Whether an attribute of that name says in which colour space the pixels are: "colorInteropID",
 * "oiio:ColorSpace", "colorspace", "arnold/color_space". */
static bool names_space(const char *name) {
    static const char *const names[] = {"colorInteropID", "colorspace", "color_space", "colourspace"};
    const char *own = name;
    for (const char *at = name; *at; at++) {
        if (strchr(":/.", *at)) {
            own = at + 1;
        }
    }
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        if (strcasecmp(own, names[i]) == 0) {
            return true;
        }
    }
    return false;
}

/* Whether the name of a colour space means linear Rec. 709 ("lin_srgb", "Linear Rec.709", "scene_linear"), or values
 * that are to be taken as they are ("raw", "data"). */
static bool is_linear_rec709(const char *name) {
    static const char *const linear[] = {"linear",
                                         "scenelinear",
                                         "raw",
                                         "data",
                                         "linsrgb",
                                         "linearsrgb",
                                         "srgblinear",
                                         "linrec709",
                                         "linearrec709",
                                         "linsrgbscene",
                                         "linrec709scene",
                                         "linearrec709srgb",
                                         "utilitylinearsrgb",
                                         "scenelinearrec709srgb"};
    char plain[40];
    size_t used = 0;
    for (; *name && used + 1 < sizeof plain; name++) {
        if (isalnum((unsigned char)*name)) {
            plain[used++] = (char)tolower((unsigned char)*name);
        }
    }
    plain[used] = '\0';
    for (size_t i = 0; i < sizeof linear / sizeof *linear; i++) {
        if (strcmp(plain, linear[i]) == 0) {
            return true;
        }
    }
    return false;
}

/* Notes what other attributes say of the colours, of a file without chromaticities. OpenEXR has no attribute of its
 * own for the name of a colour space, and writers use several. */
static void note_space(exr_const_context_t context, int part, image_info *info) {
    int32_t count = 0;
    if (exr_get_attribute_count(context, part, &count) != EXR_ERR_SUCCESS) {
        return;
    }
    for (int32_t i = 0; i < count; i++) {
        const exr_attribute_t *a;
        if (exr_get_attribute_by_index(context, part, EXR_ATTR_LIST_FILE_ORDER, i, &a) != EXR_ERR_SUCCESS) {
            continue;
        }
        if (a->type == EXR_ATTR_STRING && names_space(a->name) && !is_linear_rec709(a->string->str)) {
            image_note(info, IMAGE_NOTE_SPACE,
                       "EXR: %.60s \"%.60s\" is not applied: taken as linear Rec. 709", a->name,
                       a->string->str);
        }
        if (a->type == EXR_ATTR_INT && strcmp(a->name, "acesImageContainerFlag") == 0 && a->i == 1) {
            image_note(
                info, IMAGE_NOTE_SPACE,
                "EXR: acesImageContainerFlag without chromaticities is not applied: taken as Rec. 709");
        }
    }
}

/* Notes that one of several views is read: in a part that holds a stereo picture, the channels of the first view have
 * names without a layer. */
static void note_views(exr_const_context_t context, const exr_choice *choice, image_info *info) {
    const exr_attribute_t *a;
    if (choice->layer[0] ||
        exr_get_attribute_by_name(context, choice->part, "multiView", &a) != EXR_ERR_SUCCESS ||
        a->type != EXR_ATTR_STRING_VECTOR || a->stringvector->n_strings < 2) {
        return;
    }
    image_note(info, IMAGE_NOTE_PARTS,
               "EXR: of %d views \"%.60s\" is read (option layer: \"%.60s\" reads another)",
               (int)a->stringvector->n_strings, a->stringvector->strings[0].str,
               a->stringvector->strings[1].str);
}

btf_result exr_attributes_heed(exr_const_context_t context, const exr_choice *choice,
                               const exr_attr_box2i_t *window, exr_attributes *out_attributes,
                               image_info *info, char *message, size_t message_size) {
    const int part = choice->part;
    exr_attr_box2i_t display;
    float number;
    int32_t orientation;
    exr_envmap_t envmap;
    if (exr_attr_get_int(context, part, "Orientation", &orientation) == EXR_ERR_SUCCESS &&
        orientation != 1) {
        snprintf(message, message_size, "EXR: Orientation %d: turn the pixels, then set it to 1",
                 (int)orientation);
        return BTF_ERROR_UNSUPPORTED;
    }
    if (exr_get_display_window(context, part, &display) == EXR_ERR_SUCCESS &&
        memcmp(&display, window, sizeof display) != 0) {
        image_note(info, IMAGE_NOTE_WINDOW,
                   "EXR: the data window (%d,%d)-(%d,%d) is read, not the display window (%d,%d)-(%d,%d)",
                   (int)window->min.x, (int)window->min.y, (int)window->max.x, (int)window->max.y,
                   (int)display.min.x, (int)display.min.y, (int)display.max.x, (int)display.max.y);
    }
    if (exr_get_pixel_aspect_ratio(context, part, &number) == EXR_ERR_SUCCESS && number != 1.0f) {
        image_note(info, IMAGE_NOTE_ASPECT,
                   "EXR: pixelAspectRatio %g is not applied: pixels are taken as square", (double)number);
    }
    if (exr_attr_get_float(context, part, "whiteLuminance", &number) == EXR_ERR_SUCCESS) {
        image_note(info, IMAGE_NOTE_SCALE,
                   "EXR: whiteLuminance %g cd/m^2 is not applied: values are relative", (double)number);
    }
    out_attributes->cube = exr_attr_get_envmap(context, part, "envmap", &envmap) == EXR_ERR_SUCCESS &&
                           envmap == EXR_ENVMAP_CUBE;
    if (!take_chromaticities(context, choice, &out_attributes->primaries, info)) {
        note_space(context, part, info);
    }
    note_views(context, choice, info);
    return BTF_OK;
}
