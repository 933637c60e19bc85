/* OpenBTF: the cost of decoding a pixel.
 *
 * A decode is counted (btf_decode_counts: texels fetched, their bytes, operations, and the loops around them), and a
 * cost model has a price for each count. Counts depend on the material and on how it is decoded, prices on the device
 * alone: those of llvmpipe are built in, and a file holds those of any other (tests/bench/gpu.sh measures them).
 *
 *     btf_cost_model costs;
 *     if (btf_cost_model_open("costs.json", &log, &costs) == BTF_OK)
 *         scene.costs = &costs;
 *     btf_plan_effects(material, &scene, 0.5f, &plan);
 *
 * Thread rule: every function is pure, but that btf_cost_model_open reads its file.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_COST_H
#define OPENBTF_COST_H

#include <openbtf/shader.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Counts of one evaluation by the shader, as its source text does them (FORMAT.md section 9). Three neighbours have
 * weights, or one with nearest directions. */
typedef struct btf_decode_counts {
    double pixels;   /**< 1 */
    double look_ups; /**< of a direction's neighbours, whose fetches depend on the direction: no other count has them */
    double points;   /**< texels that are shown, neighbouring views times 1 or 4: each is scaled, clamped, blended */
    double moves;    /**< points found along a relief: of the pixel, and of each neighbouring view */
    double steps;    /**< fetches of heights, if every march went all the way down; most end earlier */
    double fetches;  /**< texels of all textures but the direction tables and the heights */
    double bytes;    /**< of these texels */
    double integers; /**< operations on integers; a shift, a mask, a product, a sum and a conversion are one each */
    double floats;   /**< operations on floats; a power is 35, natively 3 */
    double masked;   /**< of both, those behind the branch that passes over a view of weight 0: they count once more */
} btf_decode_counts;

/** @return the counts of a material decoded as @p options say (NULL: everything), the value of options->fold included.
 * A fixed direction counts as a sample, which has one neighbour. Hidden points are counted with what stands in their
 * place, as hardware does that carries out both branches. */
btf_decode_counts btf_count_decode(const btf_material_info *info, const btf_shader_options *options);

/** The prices: member of btf_cost_model, name in a file, the member of btf_decode_counts that it is the price of. */
#define BTF_COST_LIST(X)                                                                                   \
    X(pixel, "pixel", pixels)                                                                              \
    X(look_up, "look_up", look_ups)                                                                        \
    X(point, "point", points)                                                                              \
    X(move, "move", moves)                                                                                 \
    X(step, "step", steps)                                                                                 \
    X(fetch, "fetch", fetches)                                                                             \
    X(byte, "byte", bytes)                                                                                 \
    X(integer, "integer", integers)                                                                        \
    X(real, "float", floats)                                                                               \
    X(masked, "masked", masked)

/** Prices of the counts, in nanoseconds each: of one core, or of a GPU as a whole. Only ratios matter to a plan. */
typedef struct btf_cost_model {
    size_t struct_size; /**< sizeof(btf_cost_model) */
    char device[128];   /**< for people: the renderer that it was fitted to, ends with 0: cut where it is longer, with ?
                               for characters beyond ASCII that the file writes as escapes */
    double pixel;       /**< of a pixel, whatever it shows */
    double look_up;     /**< of a look-up of neighbouring directions, its fetches included */
    double point;       /**< of a texel that is shown */
    double move;        /**< of a point found along a relief */
    double step;        /**< of a step of a march, less as most are not taken */
    double fetch;       /**< of a texel fetched, whatever its size */
    double byte;        /**< of a byte of it */
    double integer;     /**< of an operation on integers */
    double real;        /**< of an operation on floats */
    double masked;      /**< more for either behind a branch, where a rasteriser on a CPU keeps what it masks */
} btf_cost_model;

/** @return the built-in prices, of llvmpipe; decoder/README.md says what they were fitted to and how well. */
const btf_cost_model *btf_cost_model_builtin(void);

/** @return the sum of counts times prices (@p model NULL: those built in), at least 1e-6. */
double btf_cost_of(const btf_decode_counts *counts, const btf_cost_model *model);

/** Reads prices from the text of a file, @p size bytes at @p text: one JSON object with "openbtf_costs": 1, the version
 * of this layout; each price by its name in BTF_COST_LIST, from 0 to 1e6, at least one of which is above 0; and, where
 * wanted, "device" (a string) and "deviation", "variants" (numbers of the fit, which are checked and not kept). Errors,
 * on log, with @p name, the key and its value: BTF_ERROR_BAD_FILE (not such an object; a key that is missing, unknown
 * or there twice; a number that is negative, not finite or too large; more than 64 KiB). */
btf_result btf_cost_model_read(const char *text, size_t size, const char *name, const btf_log *log,
                               btf_cost_model *out_model);

/** Reads such a file. Errors: those of btf_cost_model_read, BTF_ERROR_IO, BTF_ERROR_MEMORY. */
btf_result btf_cost_model_open(const char *path, const btf_log *log, btf_cost_model *out_model);

#ifdef __cplusplus
}
#endif
#endif
