/* The meaning that an image file gives its pixels, and the notes that a reader hands to its user, one of each kind.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_PIXELS_IMAGE_INFO_H
#define OPENBTF_PIXELS_IMAGE_INFO_H

#include "primaries.h"

#include <openbtf/result.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* How a file codes its samples. */
typedef enum image_transfer {
    IMAGE_TRANSFER_UNSAID = 0,
    IMAGE_TRANSFER_SRGB,
    IMAGE_TRANSFER_LINEAR,
    IMAGE_TRANSFER_GAMMA, /* value^gamma is linear */
    IMAGE_TRANSFER_BT709, /* the camera's curve of ITU-R BT.709 */
    IMAGE_TRANSFER_OTHER, /* named, and not understood here */
} image_transfer;

typedef enum image_note_kind {
    /* obeyed: told as information */
    IMAGE_NOTE_PRIMARIES, /* converted to Rec. 709 */
    IMAGE_NOTE_TRANSFER,  /* the file's own transfer function */
    IMAGE_NOTE_LAYER,     /* which of the channels are read */
    IMAGE_NOTE_SPECTRUM,  /* integrated */
    IMAGE_NOTE_EXPOSURE,  /* divided by it */
    /* not obeyed: warnings */
    IMAGE_NOTE_PROFILE, /* a colour profile */
    IMAGE_NOTE_SPACE,   /* a named colour space, or values that cannot be used */
    IMAGE_NOTE_PARTS,   /* other pictures in the file */
    IMAGE_NOTE_WINDOW,  /* data window and display window differ */
    IMAGE_NOTE_ASPECT,  /* pixels that are not square */
    IMAGE_NOTE_SCALE,   /* absolute values */
    IMAGE_NOTE_GAMMA,   /* a GAMMA of a Radiance file */
    IMAGE_NOTE_ALPHA,   /* transparency */
    IMAGE_NOTE_RANGE,   /* significant bits */
    IMAGE_NOTE_ENVMAP,  /* a map of directions */
    IMAGE_NOTE_TURNED,  /* an orientation that few readers follow */
    IMAGE_NOTE_HEADER,  /* headers that break a rule, and are read nevertheless */
    IMAGE_NOTE_KINDS,
} image_note_kind;

enum { IMAGE_NOTE_SIZE = 240 };

/* texts[kind] is empty where there is nothing to say. */
typedef struct image_notes {
    char texts[IMAGE_NOTE_KINDS][IMAGE_NOTE_SIZE];
} image_notes;

typedef struct image_info {
    image_transfer transfer;
    double gamma;           /* of IMAGE_TRANSFER_GAMMA */
    char transfer_name[80]; /* as in "gAMA 1"; set where the file says anything */
    bool converts;          /* samples, made linear, are to be multiplied by to_rec709 */
    float to_rec709[9];
    char primaries_name[200]; /* the primaries that pixels are converted from */
    image_notes notes;
} image_info;

/* Sets a note, the first of its kind alone. */
void image_note(image_info *info, image_note_kind kind, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Takes primaries that a file names as `source` ("EXR chromaticities"): Rec. 709's need nothing, others set
 * `converts`, those that span no space leave a note. */
void image_info_primaries(image_info *info, const char *source, const primaries *p);

/* Takes the colour profile (ICC) that a file of `format` ("PNG") embeds. One whose description names sRGB, and not
 * linear, and whose curves and primaries are not other ones, sets that transfer function; any other leaves a note that
 * names it. data[size]: the profile, which may be damaged. name: the file's name of it, for a profile without a
 * description; may be NULL. */
void image_info_profile(image_info *info, const char *format, const unsigned char *data, size_t size,
                        const char *name);

/* Whether a kind is a warning. */
bool image_note_warns(image_note_kind kind);

/* Tells the notes of a single file. */
void image_notes_log(const image_notes *notes, const char *path, const btf_log *log);

#endif
