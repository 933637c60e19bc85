/* OpenBTF: an encoded material in memory: open, save, look inside.
 *
 * This header reads and writes the format of FORMAT.md and nothing else: it makes no GL context, window or thread, and
 * does not decode (evaluate.h does, shader.h lets a GPU do it). Everything here is plain data; textures come in the
 * layout a GPU takes, in the byte order of the host. Directions are unit vectors of the tangent frame (x along +u, y
 * along +v, z the normal), to the viewer and to the light. Colours are linear Rec. 709.
 *
 * A log may be NULL everywhere; other pointers only where that is said. Where a call fails, the pointer that
 * it was to set is NULL.
 *
 * Thread rule: a btf_material is immutable once made; any number of threads may read it. Opening, saving
 * and closing different materials on different threads is safe.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_MATERIAL_H
#define OPENBTF_MATERIAL_H

#include <openbtf/result.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** The newest version of the format that this library reads. A file says the oldest that its contents need. */
#define BTF_FORMAT_VERSION 2

/* Upper bounds of the format (FORMAT.md). */

/** The most texels of a side of a material, and of its atlas. */
#define BTF_MAX_SIZE 16384
/** The most sampled views, and the most sampled lights. */
#define BTF_MAX_DIRECTIONS 4096
/** The most views, or lights, of every material of version 1, and of one whose textures have a layer for each of
 * them (shadow for lights; shift, gain, points and point_indices for views). */
#define BTF_MAX_DIRECTION_LAYERS 256
/** The most lobes of the SBRDF, J. */
#define BTF_MAX_LOBES 4
/** The most entries of a texel's list of points. */
#define BTF_MAX_POINT_ENTRIES 16
/** The most steps of a march along the relief. */
#define BTF_MAX_RELIEF_STEPS 64
/** The most components of the residual, and the most units where its store is factors. */
#define BTF_MAX_COMPONENTS 256
/** The classes of factors, each a width of codes (FORMAT.md section 3). */
#define BTF_FACTOR_CLASSES 5
/** The most centres of hidden points, K. */
#define BTF_MAX_CENTRES 65536
/** The most levels of detail. */
#define BTF_MAX_LEVELS 15
/** The most bands of view or light elevation in a table of errors. */
#define BTF_MAX_BANDS 16
/** The first number of a row of btf_between_errors grows by this from a level of detail to the next coarser one. */
#define BTF_BETWEEN_NEXT_LEVEL 16

/** The gainScale that the encoder writes: a gain code g of 1..255 means the gain g * 2^-7. */
#define BTF_GAIN_SCALE 0.0078125f
/** The gain code that means 1 by BTF_GAIN_SCALE. */
#define BTF_GAIN_ONE 128

/** How the maps (shadow, shift, hidden, gain) are stored. */
typedef enum btf_layout {
    BTF_LAYOUT_PAPER = 0, /**< one RGBA8UI atlas, as in section 3.1 of the paper */
    BTF_LAYOUT_TIGHT = 1, /**< a texture an effect, no padding */
} btf_layout;

/** The quantity that SBRDF and residual add up to. */
typedef enum btf_domain {
    BTF_DOMAIN_LINEAR = 0, /**< radiance */
    BTF_DOMAIN_SQRT = 1,   /**< the square root of radiance; the decoder squares it */
} btf_domain;

/** The colour of the SBRDF. */
typedef enum btf_colour {
    BTF_COLOUR_MONO = 0, /**< one colour a texel, scaled by diffuse term and lobes */
    BTF_COLOUR_RGB = 1,  /**< an RGB diffuse term and an RGB weight a lobe */
    BTF_COLOUR_NONE = 2, /**< no SBRDF parameters: the residual alone */
} btf_colour;

/** Effects: parts of the model that a file may hold and a decoder may leave out. A bit mask; the names and bits
 * of FORMAT.md section 3. */
typedef enum btf_effect {
    BTF_EFFECT_SHADOW = 1,     /**< shadow maps: a factor for each (texel, light) */
    BTF_EFFECT_SHIFT = 2,      /**< occlusion shifts: the source of each (texel, view) */
    BTF_EFFECT_HIDDEN = 4,     /**< hidden points, which take their values from cluster centres */
    BTF_EFFECT_GAIN = 8,       /**< a factor for each (texel, view) */
    BTF_EFFECT_RESIDUAL = 16,  /**< low-rank terms of the source, as components or factors */
    BTF_EFFECT_RELIEF = 32,    /**< version 2: a height map that moves texels between the sampled views */
    BTF_EFFECT_GLOSS = 64,     /**< version 2: lights looked up nearer to the half vector of each view */
    BTF_EFFECT_ALL = 127,      /**< all of them */
    BTF_EFFECT_VERSION_1 = 31, /**< those of version 1, which either layout holds */
} btf_effect;

/** How a file stores the effect `residual`. */
typedef enum btf_store {
    BTF_STORE_COMPONENTS = 0, /**< version 1: 8-bit components that R, G and B share */
    BTF_STORE_FACTORS = 1,    /**< version 2: factors of 8, 4 or 2 bits, apart for Y, C1 and C2 */
} btf_store;

/** The values in which the three neighbouring views are blended. */
typedef enum btf_blend {
    BTF_BLEND_RADIANCE = 0, /**< each view's radiance, clamped at 0 */
    BTF_BLEND_ROOTS = 1,    /**< square roots; the sum is clamped at 0 and squared. Domain sqrt only */
} btf_blend;

/** How a file stores shift and gain of points. A point is a (texel, view). */
typedef enum btf_point_store {
    BTF_POINTS_SEPARATE = 0, /**< a texture each, or the atlas of layout paper */
    /** version 2: one texture, `points`, of two bytes for both; shifts within -32..31, 16 gains */
    BTF_POINTS_PACKED = 1,
    /** version 2: textures `point_lists`, 1 to 16 packed points a texel, and `point_indices`, 4 bits a view that
     * choose one of them */
    BTF_POINTS_LISTS = 2,
} btf_point_store;

/** Formats of textures, named as in OpenGL: channels, bits of each, and UI unsigned integer, I signed integer or F
 * float. */
typedef enum btf_format {
    BTF_FORMAT_NONE = 0, /**< no texture */
    BTF_FORMAT_R8UI,     /**< 1 byte a texel */
    BTF_FORMAT_RG8UI,    /**< 2 bytes */
    BTF_FORMAT_RGBA8UI,  /**< 4 bytes */
    BTF_FORMAT_RGBA8I,   /**< 4 bytes */
    BTF_FORMAT_RGBA16UI, /**< 8 bytes */
    BTF_FORMAT_RGBA16F,  /**< 8 bytes */
    BTF_FORMAT_RGBA32F,  /**< 16 bytes */
    BTF_FORMAT_RGBA32UI, /**< 16 bytes */
} btf_format;

/** @return bytes of one texel; 0 for BTF_FORMAT_NONE. */
size_t btf_format_size(btf_format format);

/** The textures of FORMAT.md section 3, which has formats, sizes and meanings. */
typedef enum btf_texture_id {
    BTF_TEXTURE_SBRDF = 0,           /**< parameters of the SBRDF */
    BTF_TEXTURE_MAPS,                /**< the atlas of layout paper */
    BTF_TEXTURE_SHADOW,              /**< shadow codes, a layer a light */
    BTF_TEXTURE_SHIFT,               /**< shifts, or indices of centres, a layer a view */
    BTF_TEXTURE_GAIN,                /**< gain codes, a layer a view; 0 is hidden */
    BTF_TEXTURE_CENTRES,             /**< colours of the centres of hidden points */
    BTF_TEXTURE_RESIDUAL_TEXELS,     /**< components: their codes of texels, U */
    BTF_TEXTURE_RESIDUAL_DIRECTIONS, /**< components: their codes of views and lights, V */
    BTF_TEXTURE_RESIDUAL_SCALES,     /**< components: their scales */
    BTF_TEXTURE_VIEW_TABLE,          /**< look-up of views (section 6); made by the library */
    BTF_TEXTURE_LIGHT_TABLE,         /**< look-up of lights; made by the library */
    BTF_TEXTURE_FACTOR_TEXELS,       /**< factors: their codes of texels, u */
    BTF_TEXTURE_FACTOR_DIRECTIONS,   /**< factors: their codes of views and lights, w */
    BTF_TEXTURE_FACTOR_SCALES,       /**< factors: the scale of each word */
    BTF_TEXTURE_FACTOR_VIEWS,        /**< factors: a factor for each view, tier and colour channel */
    BTF_TEXTURE_POINTS,              /**< packed points, a layer a view */
    BTF_TEXTURE_POINT_LISTS,         /**< lists of packed points, a layer an entry */
    BTF_TEXTURE_POINT_INDICES,       /**< the entry of each view, a layer two views */
    BTF_TEXTURE_HEIGHTS,             /**< height codes of the relief */
    BTF_TEXTURE_VIEW_VECTORS, /**< the sampled views, and whether relief acts on each; made by the library */
    BTF_TEXTURE_COUNT         /**< the number of textures; no texture itself */
} btf_texture_id;

/** @return the texture's name in FORMAT.md, e.g. "residual_texels"; static. */
const char *btf_texture_name(btf_texture_id id);

/** One texture, ready to upload; format NONE and data NULL when the material does not have it. */
typedef struct btf_texture {
    btf_format format;              /**< of a texel */
    int is_array;                   /**< 1: a 2D array texture, also with one layer; 0: a 2D texture */
    uint32_t width, height, layers; /**< in texels; layers is 1 where is_array is 0 */
    const void *data; /**< [layer][row][column][channel], tightly packed, row 0 the top of the image */
    size_t size;      /**< bytes of data */
} btf_texture;

/** The properties of a material. */
typedef struct btf_material_info {
    size_t struct_size;                 /**< sizeof(btf_material_info), set by the caller */
    uint32_t width, height;             /**< texels, of level 0 */
    uint32_t n_views, n_lights;         /**< sampled directions */
    btf_layout layout;                  /**< how maps are stored */
    btf_domain domain;                  /**< the quantity that SBRDF and residual add up to */
    btf_colour colour;                  /**< of the SBRDF */
    int half_float;                     /**< 1: SBRDF parameters are halves; 0: floats */
    uint32_t lobes;                     /**< of the SBRDF, J */
    uint32_t effects;                   /**< btf_effect bits present */
    uint32_t centres;                   /**< of hidden points, K; 0 without BTF_EFFECT_HIDDEN */
    uint32_t components;                /**< of the residual, k; units, where the store is factors */
    uint32_t atlas_width, atlas_height; /**< in texels, with layout paper; else 0 */
    /** Factors of FORMAT.md section 9, each within 2^-24..2^24. */
    float radiance_scale, shadow_scale, gain_scale, centre_scale;
    size_t gpu_bytes;    /**< of all textures of all levels but those that table_bytes counts */
    size_t table_bytes;  /**< of direction tables, view_vectors, and scales of the residual */
    const char *method;  /**< provenance: the encoder's method; "" when not given */
    const char *options; /**< provenance: the encoder's options and thresholds; "" when not given */
    const char *source;  /**< provenance: the data set; "" when not given */
    uint32_t levels;     /**< levels of detail, 1..BTF_MAX_LEVELS; as an input 0 means 1 */
    btf_store store;     /**< of the effect residual */
    /** With BTF_STORE_FACTORS, for each class (FORMAT.md section 3): units, words of C1, words of C2; else 0. */
    uint32_t factor_classes[BTF_FACTOR_CLASSES][3];
    btf_blend blend; /**< the values in which neighbouring views are blended */
    /** With BTF_STORE_FACTORS: 1 / (l.z of the outermost light), at least 1; else 1. As an input 0 means 1. */
    float horizon_scale;
    uint32_t version; /**< the oldest of the format that holds the material; not read as an input */
    /** How shift and gain are stored. Other stores than BTF_POINTS_SEPARATE need layout tight, both these effects,
     * and no BTF_EFFECT_HIDDEN. */
    btf_point_store point_store;
    /** With packed points and lists of them: gain = base + code * step; each 0 or of magnitude 2^-24..2^24. Else
     * 0. */
    float gain_base, gain_step;
    /** With BTF_POINTS_LISTS: entries of a texel's list, 1..BTF_MAX_POINT_ENTRIES; else 0. */
    uint32_t point_entries;
    /** With BTF_EFFECT_RELIEF: the height of code c is relief_base + ((c * relief_step) >> 8), in 1/256 of the
     * width of a texel of level 0 (of level -relief_level, if there were one), within -32768..32767. relief_step
     * is 0..32767; 0 means one height everywhere and no texture `heights`. Else both are 0. */
    int32_t relief_base, relief_step;
    /** With BTF_EFFECT_RELIEF: steps of a march, 1..BTF_MAX_RELIEF_STEPS, 1 where relief_step is 0; else 0. */
    uint32_t relief_steps;
    /** With BTF_EFFECT_RELIEF: which level of detail of the material that the heights were made for is level 0
     * here. 0, but in restrictions that begin at a coarser level. With levels at most BTF_MAX_LEVELS in all. */
    uint32_t relief_level;
    /** With BTF_EFFECT_GLOSS: share of the half vector in quarters, 1 or 2; else 0. */
    uint32_t gloss_share;
    /** With BTF_EFFECT_RELIEF: the first level of detail that is decoded as if relief were left out, 1..levels;
     * as an input 0 means levels. Else 0. */
    uint32_t relief_end;
} btf_material_info;

/** One row of the errors that the encoder measured. */
typedef struct btf_material_error {
    uint32_t effects;  /**< btf_effect bits decoded */
    float psnr_linear; /**< dB over all samples clipped to [0, 1] */
    float psnr_srgb;   /**< dB, likewise after sRGB coding */
    float gpu_bytes;   /**< of the textures that decoding these effects reads, without tables */
} btf_material_error;

/** How well a level of detail shows the original, area-filtered to the level's size. */
typedef struct btf_level_error {
    uint32_t level;    /**< 0 .. levels - 1 */
    float psnr_linear; /**< dB over all samples clipped to [0, 1] */
    float psnr_srgb;   /**< dB, likewise after sRGB coding */
    float gpu_bytes;   /**< btf_level_bytes() */
} btf_level_error;

/** Errors of the ways to decode, as the encoder measured them, by bands of view and light elevation (FORMAT.md
 * section 7, openbtf.effectErrors). All 0 and NULL when the material has none.
 *
 * A row has 5 + 2 * view_bands * light_bands numbers. The first five say how was decoded:
 *
 *  - btf_effect bits;
 *  - components (or units) of the residual;
 *  - directions: 0 interpolated, 1 nearest, 2 either where view and light are samples, 3 interpolated where the view
 *    is a sample, 4 where the light is;
 *  - level of detail;
 *  - gpu bytes that are read of level 0.
 *
 * Then, [view band][light band], two mean squared errors of values clipped to [0, 1]: linear, and sRGB-coded. */
typedef struct btf_effect_errors {
    uint32_t view_bands, light_bands;        /**< 1 .. BTF_MAX_BANDS */
    const float *view_limits, *light_limits; /**< [bands + 1] theta in degrees, ascending */
    uint32_t row_count;                      /**< at most 4096 */
    uint32_t row_stride;                     /**< floats of a row */
    const float *rows;                       /**< [row_count][row_stride] */
} btf_effect_errors;

/** The encoder's estimate of the error between the samples (FORMAT.md section 7, openbtf.betweenErrors, and of coarser
 * levels openbtf.levelBetweenErrors; here the rows of both stand in one table): samples are left out and predicted from
 * their neighbours by the decoder. Neighbours are then twice as far away as for a direction between samples, so that
 * the estimate overstates the error. All 0 and NULL when the material has none.
 *
 * A row has 5 + 2 * view_bands * light_bands numbers:
 *
 *  - what is left out: 1 the view, 2 the light, 3 both; 5 and 7 are 1 and 3 decoded without BTF_EFFECT_RELIEF, 9 and 11
 *    without BTF_EFFECT_GLOSS, in a material that has it; of level of detail n in a material of version 2,
 *    n * BTF_BETWEEN_NEXT_LEVEL more;
 *  - two mean squared errors of the material: linear, and sRGB-coded;
 *  - the same two of the data themselves, interpolated by the same weights;
 *  - then, [view band][light band], the same two of the material, -1 where nothing can be left out.
 *
 * Values are clipped to [0, 1]. */
typedef struct btf_between_errors {
    uint32_t view_bands, light_bands;        /**< 1 .. BTF_MAX_BANDS */
    const float *view_limits, *light_limits; /**< [bands + 1] theta in degrees, ascending */
    uint32_t row_count;                      /**< at most 7 a level */
    uint32_t row_stride;                     /**< floats of a row */
    const float *rows;                       /**< [row_count][row_stride] */
} btf_between_errors;

/** A material in memory. Immutable once made: any number of threads may read it. */
typedef struct btf_material btf_material;

/** A list of directions, triangulated and gridded as FORMAT.md section 6 says. The arrays belong to the
 * material. */
typedef struct btf_directions {
    uint32_t count;            /**< of directions */
    const float *xyz;          /**< [count][3], unit, in paper order: theta ascending, then phi */
    const uint16_t *vertices;  /**< [count][2], projected, 0 .. 16384 */
    uint32_t triangle_count;   /**< 0 for one direction, and for several in a line */
    const uint16_t *triangles; /**< [triangle_count][3], indices of directions, counter-clockwise */
    uint32_t hull_count;       /**< vertices of the hull */
    const uint16_t *hull;      /**< [hull_count], indices of directions */
    uint32_t grid;             /**< cells of a side, G */
    const uint16_t *cells;     /**< for each of G * G cells, row by row: count, then record numbers */
    size_t cells_length;       /**< entries of cells */
} btf_directions;

/** Opens a *.btf.exr file. Every rule of FORMAT.md is checked, so that no later call meets bad data.
 * *out_material is closed with btf_material_close. Errors: BTF_ERROR_IO (cannot be read), BTF_ERROR_BAD_FILE,
 * BTF_ERROR_UNSUPPORTED (a newer version), BTF_ERROR_MEMORY. */
btf_result btf_material_open(const char *path, const btf_log *log, btf_material **out_material);

/** Opens a material from the bytes of such a file in memory, which are not needed after the call. Errors as of
 * btf_material_open, but for BTF_ERROR_IO. */
btf_result btf_material_open_memory(const void *data, size_t size, const btf_log *log,
                                    btf_material **out_material);

/** Frees *material and sets it to NULL. NULL and a pointer to NULL are accepted. */
void btf_material_close(btf_material **material);

/** Fills *out_info up to its struct_size, which the caller sets. Strings belong to the material. Errors:
 * BTF_ERROR_USAGE (struct_size is too small to be one of a btf_material_info). */
btf_result btf_material_get_info(const btf_material *material, btf_material_info *out_info);

/** @return the texture; format NONE when absent. Data belong to the material. */
btf_texture btf_material_texture(const btf_material *material, btf_texture_id id);

/** @return the texture of a level of detail. Level 0 is btf_material_texture. A higher level has sbrdf, shadow,
 * shift, gain, points, point_lists, point_indices, residual_texels, factor_texels and heights of its own; it shares
 * the other textures with level 0, for which the format is NONE here, as for a level that the material does not
 * have. */
btf_texture btf_material_level_texture(const btf_material *material, uint32_t level, btf_texture_id id);

/** @return the sampled directions to the viewer. */
btf_directions btf_material_views(const btf_material *material);

/** @return the sampled directions to the light. */
btf_directions btf_material_lights(const btf_material *material);

/** @return the encoder's measured errors, *out_count rows, owned by the material; NULL when there are none. */
const btf_material_error *btf_material_errors(const btf_material *material, size_t *out_count);

/** @return the measured errors of the levels, *out_count rows by rising level, owned by the material; NULL
 * when there are none. */
const btf_level_error *btf_material_level_errors(const btf_material *material, size_t *out_count);

/** @return the errors of the ways to decode that the encoder measured; owned by the material. */
btf_effect_errors btf_material_effect_errors(const btf_material *material);

/** @return how far each way to decode is from decoding everything: laid out as btf_effect_errors, but that the mean
 * squared errors are differences to the same level decoded with all effects and components and interpolated directions
 * (FORMAT.md section 7, openbtf.effectDifferences). There are no rows of directions 2: where view and light are samples
 * the data are known. For coarser levels the encoder writes rows of directions 0 alone. Owned by the material. */
btf_effect_errors btf_material_effect_differences(const btf_material *material);

/** @return the encoder's estimate of the error between the samples; owned by the material. */
btf_between_errors btf_material_between_errors(const btf_material *material);

/** All that a material is made from, as an encoder hands it over. Sizes and formats of textures follow from info
 * (see btf_material_texture_shape); entries of textures that the effects do not call for must be NULL, and so must
 * those of the textures that the library makes: the two direction tables and view_vectors. */
typedef struct btf_material_desc {
    size_t struct_size;     /**< sizeof(btf_material_desc) */
    btf_material_info info; /**< all but gpu_bytes, table_bytes and version is read; strings may be NULL */
    const float *views;     /**< [n_views][3], unit, z > 0, paper order, no duplicates */
    const float *lights;    /**< [n_lights][3], likewise */
    /** [btf_texture_id], the data of level 0, as in btf_texture. */
    const void *texture[BTF_TEXTURE_COUNT];
    const btf_material_error *errors; /**< [error_count]; NULL: none */
    size_t error_count;               /**< rows of errors */
    /** [level][btf_texture_id], the data of levels 1 .. info.levels - 1, of the shapes of btf_material_level_shape;
     * those of level 0 are not read. */
    const void *level_texture[BTF_MAX_LEVELS][BTF_TEXTURE_COUNT];
    const btf_level_error *level_errors; /**< [level_error_count], by rising level; NULL: none */
    size_t level_error_count;            /**< rows of level_errors */
    const float *effect_errors; /**< as the attribute openbtf.effectErrors holds them; NULL: none */
    size_t effect_error_count;  /**< floats */
    /** Bands, limits and rows as the attribute openbtf.betweenErrors holds them, followed by the rows of coarser levels
     * (btf_between_errors), which a file keeps in openbtf.levelBetweenErrors; NULL: none. */
    const float *between_errors;
    size_t between_error_count; /**< floats */
    /** A picture for viewers of EXR files, which no decoder reads: halves, [height][width][4], linear Rec. 709 RGB
     * and a 0; NULL: none. Only in materials that need version 2. */
    const uint16_t *preview;
    /** [n_views], 1 where relief acts on the view, else 0; NULL: it acts on all. Only with BTF_EFFECT_RELIEF. */
    const uint8_t *relief_views;
    /** As the attribute openbtf.effectDifferences holds them; NULL: none. */
    const float *effect_differences;
    size_t effect_difference_count; /**< floats */
} btf_material_desc;

/** @return the picture for viewers of EXR files (see btf_material_desc), owned by the material; NULL when there is
 * none. */
const uint16_t *btf_material_preview(const btf_material *material);

/** @return the shape (format, is_array, width, height, layers, size; data NULL) of a texture of a material with this
 * info; format NONE when such a material does not have it, and for the textures that the library makes: the two
 * direction tables and view_vectors. */
btf_texture btf_material_texture_shape(const btf_material_info *info, btf_texture_id id);

/** @return the shape of a texture of a level of detail; level 0 is btf_material_texture_shape. Format NONE for a
 * texture that the level shares with level 0, and for a level that info does not have. */
btf_texture btf_material_level_shape(const btf_material_info *info, uint32_t level, btf_texture_id id);

/** @return the bytes that a level adds to gpu_bytes: those of its own textures; for level 0 of all its textures,
 * those that it shares included. */
size_t btf_level_bytes(const btf_material_info *info, uint32_t level);

/** @return the texels of a side of `size` texels in a level: max(1, size >> level). */
uint32_t btf_level_size(uint32_t size, uint32_t level);

/** Finds the smallest legal atlas of layout `paper` (FORMAT.md section 5) for info's width, height, n_views, n_lights
 * and effects, with room for info's centres where BTF_EFFECT_HIDDEN is among them. Sets *out_width and *out_height,
 * in texels, and *out_room, the centres that it holds. Errors: BTF_ERROR_UNSUPPORTED (there is no such atlas). */
btf_result btf_material_atlas(const btf_material_info *info, uint32_t *out_width, uint32_t *out_height,
                              uint32_t *out_room);

/** Sets the atlas column (*out_x) and first row (*out_y) of centre i in an atlas of info's size. */
void btf_material_atlas_centre(const btf_material_info *info, uint32_t i, uint32_t *out_x, uint32_t *out_y);

/** Makes a material from textures, which it copies; triangulates the directions; checks all that btf_material_open
 * checks. *out_material is closed with btf_material_close. Errors: BTF_ERROR_USAGE (the message names the value),
 * BTF_ERROR_UNSUPPORTED (the textures exceed the address space), BTF_ERROR_MEMORY. */
btf_result btf_material_create(const btf_material_desc *desc, const btf_log *log,
                               btf_material **out_material);

/** Makes a copy of a material in layout `tight`, for GPUs whose textures may not be as large as the atlas of layout
 * `paper`: its tiles become layers of array textures (FORMAT.md section 5). The copy decodes to the same bits; the
 * shadow of a material without SBRDF, which changes nothing, is left out. *out_material is closed with
 * btf_material_close. Errors: BTF_ERROR_MEMORY. */
btf_result btf_material_to_tight(const btf_material *material, const btf_log *log,
                                 btf_material **out_material);

/** Writes the material to a file @p path: first to a temporary name beside it, which is renamed once it is whole.
 * Errors: BTF_ERROR_IO, BTF_ERROR_MEMORY. */
btf_result btf_material_save(const btf_material *material, const char *path, const btf_log *log);

/** Writes the file of the material to memory, *out_size bytes at *out_data, which is freed with btf_free. Errors:
 * BTF_ERROR_MEMORY. */
btf_result btf_material_save_memory(const btf_material *material, const btf_log *log, void **out_data,
                                    size_t *out_size);

/** Frees memory that the library handed over (btf_material_save_memory, btf_shader_source); NULL is accepted. */
void btf_free(void *pointer);

#ifdef __cplusplus
}
#endif
#endif
