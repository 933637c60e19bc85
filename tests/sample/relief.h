/* Periodic reliefs: the surfaces that btf-sample ray-casts.
 *
 * A relief is a height field over the unit tile, periodic in x and y, in the tangent frame of FORMAT.md (x
 * along +u, y along +v, z the normal). All lengths are in tiles. z = 0 is the plane of the highest points,
 * so heights are in [-depth, 0]. The surface is, by definition, the bilinear interpolation of the grid of
 * heights held here: visibility, normals, shadows and truth all mean that surface. Materials are functions
 * of (x, y).
 *
 * The same kind and seed give the same relief on every machine whose libm agrees in sqrt, sin, cos and pow.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_SAMPLE_RELIEF_H
#define OPENBTF_SAMPLE_RELIEF_H

#include <openbtf/result.h>
#include <stdint.h>

/* The reliefs that can be rendered:
 *   bricks   running bond of 4 courses of 2 bricks, recessed mortar, depth 0.10, 5 % ambient light
 *   bumps    a bed of rounded pebbles, smooth, no ambient light: unlit samples are exactly 0
 *   weave    a plain weave of 8 warp and 8 weft threads
 *   flat     a control without relief: coloured Lambertian and a lobe in the same colour, spatially varying, exactly
 *            representable by the SBRDF model of FORMAT.md (one lobe)
 *   white    a control without relief: albedo 1, no lobe; every sample is l.z
 *   axes     an asymmetric relief that fixes axes, see RELIEF_AXES_DEPTH below */
#define RELIEF_LIST(X)                                                                                     \
    X(RELIEF_BRICKS, "bricks", "running-bond bricks with recessed mortar, 5% ambient light")               \
    X(RELIEF_BUMPS, "bumps", "a bed of rounded pebbles, no ambient light")                                 \
    X(RELIEF_WEAVE, "weave", "cloth: a plain weave of two colours of thread")                              \
    X(RELIEF_FLAT, "flat", "no relief: varying colour with a glossy lobe (a control)")                     \
    X(RELIEF_WHITE, "white", "no relief, white Lambertian: every sample is l.z (a control)")               \
    X(RELIEF_AXES, "axes", "a post, a ridge on the +u side, a wedge rising to +v: fixes axes")

typedef enum relief_kind {
#define RELIEF_ENUM(id, name, text) id,
    RELIEF_LIST(RELIEF_ENUM)
#undef RELIEF_ENUM
        RELIEF_COUNT
} relief_kind;

/* The relief `axes`. Lengths are in tiles, in 64ths, so that no ray of a 64-texel image meets a wall from above. The ground
 * is at z = -RELIEF_AXES_DEPTH, grey (albedo 0.5), Lambertian, without ambient light. On it stand:
 *   post    29/64 <= x, y <= 35/64; its top is at z = 0, albedo 0.9
 *   ridge   51/64 <= x <= 54/64, 10/64 <= y <= 32/64; its top is at half the depth; on the +u side
 *   wedge   10/64 <= x <= 22/64, 42/64 <= y <= 54/64; rises linearly from the ground at its low y to half the depth at
 *           its high y, so that it faces -y and is brighter lit from azimuth 270 than from 90
 *   bands   no heights: albedo red where x > 60/64 (right-hand columns of the image), green where y > 60/64 (its top rows)
 * Walls are slopes one cell of the grid wide, outside the limits given here. Tests can expect, for directions at theta 45:
 *   - a light from azimuth 0 (from +x) casts shadows towards -x, smaller columns: at y = 1/2 the ground is dark for
 *     29/64 - depth < x < 29/64 and lit at x = 37/64;
 *   - a light from azimuth 90 (from +y) casts them towards -y, larger rows: dark for 29/64 - depth < y < 29/64;
 *   - seen from azimuth 0 the ground's point (x, y) appears at (x + depth, y): the true shift there is
 *     -depth * width columns (-8 of 64); seen from azimuth 90 it appears at (x, y + depth): a shift of
 *     +depth * height rows. The top of the post stays where it is. */
#define RELIEF_AXES_DEPTH 0.125

/* How a point reflects; linear Rec. 709. Radiance over (irradiance / pi), for the normal n and r, the mirrored l:
 *   lit * max(n.l, 0) * (albedo + gloss * max(r.v, 0)^exponent) + ambient * albedo * l.z
 * The lobe is that of Phong 1975 in the form of Lafortune et al. 1997: on the flat tile r.v = -lx vx - ly vy + lz vz. */
typedef struct relief_material {
    double albedo[3];
    double gloss[3]; /* peak of the lobe; its albedo is at most 2 / (exponent + 2) of it */
    int exponent;    /* >= 1 */
} relief_material;

/* Immutable after relief_create: any number of threads may read it. */
typedef struct relief {
    relief_kind kind;
    uint32_t seed;
    int grid;                 /* cells along each side, a power of two */
    double depth;             /* lowest height is -depth; 0 for the controls */
    double ambient;           /* fraction of the albedo that is seen however the point is lit */
    float *height;            /* [grid row along y][grid column along x], at (column / grid, row / grid) */
    float *height_transposed; /* [column][row]: the same, for sweeps along x */
    float *cell_max;          /* [row][column]: highest corner of the cell whose low corner is that node */
} relief;

/* Name -> kind; returns RELIEF_COUNT when there is none of that name. */
relief_kind relief_kind_from_name(const char *name);
const char *relief_kind_name(relief_kind kind);

/* Tabulates a relief. grid: a power of two, 64..4096. Uses up to `threads` threads; the result does not
 * depend on it. Errors: BTF_ERROR_USAGE (kind, grid), BTF_ERROR_MEMORY. */
btf_result relief_create(relief_kind kind, uint32_t seed, int grid, int threads, relief **out_relief);
void relief_destroy(relief **r);

/* The material at (x, y), any real numbers (wrapped). */
void relief_material_at(const relief *r, double x, double y, relief_material *out_material);

#endif
