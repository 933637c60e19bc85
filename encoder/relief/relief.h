/* The effects that act between the sampled directions, chosen for a data set: a surface along which views
 * are shifted before they are blended, and the share of the half vector that their lights keep.
 *
 * Heights are found by a plane sweep and a descent on the decoder's error at views left out. Whether they
 * pay is judged ring by ring of views in true values, by views left out: neighbours there lie twice as far
 * away as in use, which flatters relief, so that a ring must gain ENC_RELIEF_MARGIN beside another that
 * does, and the outermost one, which has no neighbours beyond, follows the one before. Where one height
 * does as well, there is no map. Of further levels of detail, which are judged likewise, relief ends at the
 * first that gains too little (end.h). RELIEF.md has what was measured.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_RELIEF_RELIEF_H
#define OPENBTF_ENCODER_RELIEF_RELIEF_H

#include "end.h"
#include "gloss.h"

enum {
    ENC_RELIEF_RINGS = 16,
    ENC_RELIEF_CANDIDATES = 9, /* no relief; four scales of the heights; three single heights; the best scale,
                                  drawn in */
};

/* dB that a ring must gain by views left out, mean of linear and sRGB-coded. */
#define ENC_RELIEF_MARGIN 0.7
#define ENC_RELIEF_DRAWN_IN 0.08 /* share of the texels at each end, see enc_relief_candidate.drawn_in */
#define ENC_RELIEF_SHARE 0.65 /* of a flat surface's squared error: a map must leave less (measured: RELIEF.md) */

typedef struct enc_relief_options {
    bool relief;
    int gloss;  /* 0, 1, 2: quarters; -1: chosen */
    int levels; /* of detail that the file will have; 0 means 1 */
} enc_relief_options;

/* A surface that was judged. */
typedef struct enc_relief_candidate {
    double scale; /* of the heights; of the median height where it is constant */
    bool constant, judged;
    bool drawn_in; /* the lowest and the highest ENC_RELIEF_DRAWN_IN of the texels lie no further than the next */
    double gain; /* dB over all views left out, with relief on the rings where it pays */
    int rings;   /* how many these are */
} enc_relief_candidate;

typedef struct enc_relief_ring {
    double theta;                  /* degrees, the mean of its views */
    int views;                     /* left out */
    enc_judged_error plain, moved; /* by the surface chosen, or the best one where none is */
    double gain;                   /* dB */
    bool on;
} enc_relief_ring;

typedef struct enc_relief_choice {
    bool tried;         /* relief was asked for and could be judged */
    const char *reason; /* why there is no relief; NULL: there is */
    double share;       /* of a flat surface's squared error that the descent left */
    enc_relief_candidate candidate[ENC_RELIEF_CANDIDATES];
    int chosen; /* 0: none */
    int n_rings;
    enc_relief_ring ring[ENC_RELIEF_RINGS];
    double least, most; /* height in texels of the surface chosen */
    enc_relief_end end; /* of several levels of detail: where it ends */
    enc_gloss_choice gloss;
} enc_relief_choice;

/* Chooses for `data`, whose samples must lie in memory for relief to be tried. The surface chosen goes to
 * *out_store, which is empty where none is. Stage "relief". Every rank does all of it; the same bits for
 * any number of threads. Memory beside the samples: enc_relief_memory. Errors, on the log: those of the
 * data, BTF_ERROR_MEMORY, BTF_ERROR_INTERRUPTED. */
btf_result enc_relief_choose(const enc_context *context, const enc_data *data,
                             const enc_relief_options *options, enc_relief_choice *out_choice,
                             enc_relief_store *out_store);

/* The amount of work of enc_relief_choose, for predictions. */
typedef struct enc_relief_work {
    /* Texels of the images that heights are found on; heights of the plane sweep; sweeps of the descent;
     * texels that surfaces are judged at. */
    double texels, heights, sweeps, judged;
} enc_relief_work;

enc_relief_work enc_relief_work_of(int width, int height);

/* Bytes that enc_relief_choose takes beside the samples. */
uint64_t enc_relief_memory(int width, int height, int n_views, int n_lights);

#endif
