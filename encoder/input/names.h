/* Reads the light's and the viewer's direction from the names of a BTF's images. INPUTS.md tells users the
 * rules.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_NAMES_H
#define OPENBTF_ENCODER_NAMES_H

#include <stdbool.h>
#include <stddef.h>

/* The angles of one image, in degrees as written. */
typedef struct enc_angles {
    double theta_light, phi_light; /* tl, pl */
    double theta_view, phi_view;   /* tv, pv */
} enc_angles;

typedef enum enc_name_verdict {
    ENC_NAME_READ,
    ENC_NAME_INCOMPLETE, /* one of the four is missing, or one part of the path gives a key two values */
    ENC_NAME_BAD, /* all four are there, and a number among them cannot be read for sure: see `bad` */
} enc_name_verdict;

enum { ENC_NAME_KEYS = 4 }; /* tl, pl, tv, pv: in the order of enc_angles */

/* What one name says by itself. Only all names of its set together tell whether a dash between key and
 * digits is a minus. */
typedef struct enc_name {
    enc_angles angles;             /* without the dash where open_sign is set */
    bool open_sign[ENC_NAME_KEYS]; /* "pv-90": this angle has just a dash between key and digits */
    bool is_plain;       /* an angle has something else than a dash behind its key: "pv90", "pv_90" */
    bool counter;        /* digits after the last angle were ignored: "pv7_5", "pv7 (1)" */
    bool like_frame;     /* the last angle alone has decimals, which look like a frame: "pv7.0105" */
    bool folders_differ; /* a folder gives a key another value than the one that counts */
    char bad[32];        /* the part of the name that could not be read: "tl22x5" */
    const char *why;     /* why not; static */
} enc_name;

/* Finds `tl`, `pl`, `tv` and `pv` in a path ('/' and '\\' separate its folders), each followed by an angle:
 * in any order and case, with spaces, underscores, dashes, equal signs or nothing between key and angle. A
 * key does not count where a letter stands before it. The file's extension is not part of the name. What
 * the file name does not say is taken from the nearest folder that does.
 *
 * An angle is digits, perhaps with decimals behind '.', ',' or 'p' ("22.5", "22,5", "22p5"), perhaps with
 * an exponent that has a sign ("3.5e-15"), perhaps with a unit right behind it ("30deg", "30" and a degree
 * sign). '+', the Unicode minus, or a dash that another separator precedes ("pl_-30") is its sign. Anything
 * else that could be part of a number ("22_5 pl0", "1.2.3", "0x1f", "0.5rad", "30b") makes it ENC_NAME_BAD.
 *
 * Examples: "00008 tl000 pl000 tv030 pv030.jpg", "tv075_pv000/tl07.5-pl60.png". */
enc_name_verdict enc_names_parse(const char *path, enc_name *out_name);

/* Gives the angles of a name of a set. `dash_is_minus`: some name of the set is_plain, so that a dash
 * behind a key is no separator of that set. */
enc_angles enc_names_angles(const enc_name *name, bool dash_is_minus);

/* "tl", "pl", "tv" or "pv". */
const char *enc_names_key(int key);

/* Reads a whole text as an angle the way names are read, decimal commas only where `comma`. */
bool enc_names_number(const char *text, bool comma, double *out);

typedef struct enc_angle_spread {
    double largest;       /* its magnitude */
    size_t whole, broken; /* how many angles are whole, and are not, without those that are 0 */
} enc_angle_spread;

/* Counts over the angles of a data set that give away units other than degrees. Begins zeroed. */
typedef struct enc_angle_range {
    enc_angle_spread theta, phi;
    size_t count;  /* images */
    size_t beyond; /* images with an azimuth beyond 360 degrees, either way */
} enc_angle_range;

typedef enum enc_radians {
    ENC_RADIANS_NONE,
    ENC_RADIANS_ALL,   /* no angle reaches 6.3, and few but 0 are whole */
    ENC_RADIANS_PHI,   /* the same of the azimuths alone */
    ENC_RADIANS_THETA, /* no theta reaches 1.58, and few but 0 are whole; azimuths do not look like radians */
} enc_radians;

void enc_angles_survey(enc_angle_range *range, const enc_angles *angles);

enc_radians enc_angles_look_like_radians(const enc_angle_range *range);

/* Whether angles may be numbers of directions: there are nine images or more, and all thetas are whole and
 * below 10. */
bool enc_angles_look_like_indices(const enc_angle_range *range);

/* Whether a path's extension is that of an image format that can be read, and nothing in it is hidden: no
 * name of a file or folder begins with a dot, nor is a folder "__MACOSX". */
bool enc_names_is_image(const char *path);

/* Whether a path's extension is that of an image format that cannot be read, such as ".tif", and nothing in
 * it is hidden. */
bool enc_names_is_foreign_image(const char *path);

#endif
