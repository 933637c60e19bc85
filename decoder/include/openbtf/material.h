/* OpenBTF: an encoded material in memory: open, save, look inside.
 *
 * The library reads and writes the format of FORMAT.md and nothing else: it makes no GL context, window or
 * thread, and does not decode. Everything here is plain data; textures come in the layout a GPU takes, in
 * the byte order of the host. Directions are unit vectors of the tangent frame (x along +u, y along +v, z
 * the normal), to the viewer and to the light. Colours are linear Rec. 709.
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

/** The newest version of the format that this library reads; a file says the oldest that its contents need.
 */
#define BTF_FORMAT_VERSION 2

/** Upper bounds of the format (FORMAT.md). */
#define BTF_MAX_SIZE 16384
#define BTF_MAX_DIRECTIONS 4096 /* views, and lights */
/** The most views, or lights, where a texture has a layer for each (shadow: lights; shift, gain, points,
 * point_indices: views),
 * and of every material of version 1. */
#define BTF_MAX_DIRECTION_LAYERS 256
#define BTF_MAX_LOBES 4
#define BTF_MAX_POINT_ENTRIES 16
#define BTF_MAX_RELIEF_STEPS 64
#define BTF_MAX_COMPONENTS 256 /**< components of the residual; units, where its store is factors */
#define BTF_FACTOR_CLASSES 5
#define BTF_MAX_CENTRES 65536
#define BTF_MAX_LEVELS 15
#define BTF_MAX_BANDS 16
/** A white gain of the codes 1..255: 128 is 1. */
#define BTF_GAIN_SCALE 0.0078125f /* 2^-7 */
#define BTF_GAIN_ONE 128

typedef enum btf_layout {
    BTF_LAYOUT_PAPER = 0, /**< one RGBA8UI atlas, as in section 3.1 of the paper */
    BTF_LAYOUT_TIGHT = 1, /**< a texture an effect, no padding */
} btf_layout;

typedef enum btf_domain {
    BTF_DOMAIN_LINEAR = 0, /**< the model gives radiance */
    BTF_DOMAIN_SQRT = 1,   /**< the model gives its square root; the decoder squares */
} btf_domain;

typedef enum btf_colour {
    BTF_COLOUR_MONO = 0, /**< one colour a texel, scaled by diffuse term and lobes */
    BTF_COLOUR_RGB = 1,  /**< an RGB diffuse term and an RGB weight a lobe */
    BTF_COLOUR_NONE = 2, /**< no SBRDF parameters: the residual alone */
} btf_colour;

/** Effects, a bit mask; the names and bits of FORMAT.md section 3. */
typedef enum btf_effect {
    BTF_EFFECT_SHADOW = 1,
    BTF_EFFECT_SHIFT = 2,
    BTF_EFFECT_HIDDEN = 4,
    BTF_EFFECT_GAIN = 8,
    BTF_EFFECT_RESIDUAL = 16,
    BTF_EFFECT_RELIEF = 32, /**< version 2 */
    BTF_EFFECT_GLOSS = 64,  /**< version 2 */
    BTF_EFFECT_ALL = 127,
    BTF_EFFECT_VERSION_1 = 31, /**< those of version 1, which either layout holds */
} btf_effect;

/** How a file stores the effect `residual`. */
typedef enum btf_store {
    BTF_STORE_COMPONENTS = 0, /**< version 1: 8-bit components that R, G and B share */
    BTF_STORE_FACTORS = 1,    /**< version 2: factors of 8, 4 or 2 bits, apart for Y, C1 and C2 */
} btf_store;

/** Which values the three neighbouring views are blended in. */
typedef enum btf_blend {
    BTF_BLEND_RADIANCE = 0, /**< each view's radiance, clamped at 0 */
    BTF_BLEND_ROOTS = 1,    /**< square roots; the sum is clamped at 0 and squared. Domain sqrt only */
} btf_blend;

/** How a file stores shift and gain. */
typedef enum btf_point_store {
    BTF_POINTS_SEPARATE = 0, /**< a texture each, or the atlas of layout paper */
    BTF_POINTS_PACKED = 1,   /**< version 2: texture points, two bytes for both, shifts within -32..31, 16 gains */
    BTF_POINTS_LISTS = 2,    /**< version 2: textures point_lists, 1 to 16 packed points a texel, and
                                point_indices, 4 bits a view that choose one */
} btf_point_store;

typedef enum btf_format {
    BTF_FORMAT_NONE = 0,
    BTF_FORMAT_R8UI,
    BTF_FORMAT_RG8UI,
    BTF_FORMAT_RGBA8UI,
    BTF_FORMAT_RGBA8I,
    BTF_FORMAT_RGBA16UI,
    BTF_FORMAT_RGBA16F,
    BTF_FORMAT_RGBA32F,
    BTF_FORMAT_RGBA32UI,
} btf_format;

/** @return bytes of one texel; 0 for BTF_FORMAT_NONE. */
size_t btf_format_size(btf_format format);

/** The textures of FORMAT.md section 3. */
typedef enum btf_texture_id {
    BTF_TEXTURE_SBRDF = 0,
    BTF_TEXTURE_MAPS,
    BTF_TEXTURE_SHADOW,
    BTF_TEXTURE_SHIFT,
    BTF_TEXTURE_GAIN,
    BTF_TEXTURE_CENTRES,
    BTF_TEXTURE_RESIDUAL_TEXELS,
    BTF_TEXTURE_RESIDUAL_DIRECTIONS,
    BTF_TEXTURE_RESIDUAL_SCALES,
    BTF_TEXTURE_VIEW_TABLE,
    BTF_TEXTURE_LIGHT_TABLE,
    BTF_TEXTURE_FACTOR_TEXELS,
    BTF_TEXTURE_FACTOR_DIRECTIONS,
    BTF_TEXTURE_FACTOR_SCALES,
    BTF_TEXTURE_FACTOR_VIEWS,
    BTF_TEXTURE_POINTS,
    BTF_TEXTURE_POINT_LISTS,
    BTF_TEXTURE_POINT_INDICES,
    BTF_TEXTURE_HEIGHTS,
    BTF_TEXTURE_VIEW_VECTORS,
    BTF_TEXTURE_COUNT
} btf_texture_id;

/** @return the texture's name in FORMAT.md, e.g. "residual_texels"; static. */
const char *btf_texture_name(btf_texture_id id);

/** One texture, ready to upload. data is [layer][row][column][channel], tightly packed, row 0 the top of
 * the image; NULL and format NONE when the material does not have it. is_array: a 2D array texture (also
 * when it has one layer), else a 2D texture with layers = 1. */
typedef struct btf_texture {
    btf_format format;
    int is_array;
    uint32_t width, height, layers;
    const void *data;
    size_t size; /**< bytes */
} btf_texture;

/** The properties of a material. */
typedef struct btf_material_info {
    size_t struct_size; /**< sizeof(btf_material_info), set by the caller */
    uint32_t width, height;     /**< texels, of level 0 */
    uint32_t n_views, n_lights; /**< sampled directions */
    btf_layout layout;
    btf_domain domain;
    btf_colour colour;
    int half_float;                     /**< SBRDF parameters are halves */
    uint32_t lobes;                     /**< J */
    uint32_t effects;                   /**< btf_effect bits present */
    uint32_t centres;                   /**< K */
    uint32_t components;                /**< k of the residual; units, where the store is factors */
    uint32_t atlas_width, atlas_height; /**< layout paper, else 0 */
    float radiance_scale, shadow_scale, gain_scale, centre_scale; /**< factors of FORMAT.md section 9 */
    size_t gpu_bytes;   /**< FORMAT.md section 3: without tables */
    size_t table_bytes; /**< direction tables, scales of the residual, and view_vectors */
    const char *method; /**< provenance; "" when not given */
    const char *options;
    const char *source;
    uint32_t levels; /**< levels of detail, 1..BTF_MAX_LEVELS; as an input 0 means 1 */
    btf_store store; /**< of the effect residual */
    /** With BTF_STORE_FACTORS, of each class (FORMAT.md section 3): units, words of C1, words of C2; else
     * 0. */
    uint32_t factor_classes[BTF_FACTOR_CLASSES][3];
    btf_blend blend;
    float horizon_scale; /**< with BTF_STORE_FACTORS: 1 / (l.z of the outermost light), >= 1; else 1, as an
                            input 0 */
    uint32_t version;    /**< the oldest of the format that holds the material; no input */
    btf_point_store point_store; /**< but SEPARATE needs layout tight, shift and gain, and no hidden */
    float gain_base, gain_step;  /**< with packed points and lists: gain = base + code * step, each 0 or of magnitude
                                    2^-24..2^24; else 0 */
    uint32_t point_entries;      /**< with BTF_POINTS_LISTS: packed points of a texel's list, 1 to
                                    BTF_MAX_POINT_ENTRIES; else 0 */
    /** With BTF_EFFECT_RELIEF, else 0: the height of code c is relief_base + ((c * relief_step) >> 8), in
     * 1/256 of the width of a texel of level 0 (of level -relief_level, if there were one), within
     * -32768..32767; relief_step 0..32767, 0: one height everywhere and no texture `heights`. */
    int32_t relief_base, relief_step;
    uint32_t relief_steps; /**< with BTF_EFFECT_RELIEF: steps of a march, 1..BTF_MAX_RELIEF_STEPS, 1 where
                              relief_step is 0; else 0 */
    uint32_t relief_level; /**< with BTF_EFFECT_RELIEF: the level of detail, of the material that heights
                              were made for, that is level 0 here: 0, but in restrictions; with levels at
                              most BTF_MAX_LEVELS */
    uint32_t gloss_share;  /**< with BTF_EFFECT_GLOSS: share of the half vector in quarters, 1 or 2; else 0 */
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

/** Errors of the ways to decode as the encoder measured them, by bands of view and light elevation
 * (FORMAT.md section 7, openbtf.effectErrors). Row r has 5 + 2 * view_bands * light_bands numbers:
 * btf_effect bits decoded, components (or units) of the residual, 0 for interpolated directions, 1 for
 * nearest ones, 2 for either at the samples, 3 and 4 for interpolated ones where the view or the light is a sample, level of
 * detail, gpu bytes of level 0; then, [view band][light band], the mean squared error of values clipped to
 * [0, 1], linear and sRGB-coded. All 0 and NULL when there is none. */
typedef struct btf_effect_errors {
    uint32_t view_bands, light_bands;        /**< 1 .. BTF_MAX_BANDS */
    const float *view_limits, *light_limits; /**< [bands + 1] theta in degrees, ascending */
    uint32_t row_count;
    uint32_t row_stride; /**< floats of a row */
    const float *rows;
} btf_effect_errors;

/** How well the samples are predicted where view (row's first number 1), light (2) or both (3) are left out and
 * the decoder takes their neighbours instead: the encoder's estimate of the error between the samples (FORMAT.md
 * section 7, openbtf.betweenErrors). Neighbours are then twice as far away as for a direction between samples, so it
 * overstates the error. Row r has 5 + 2 * view_bands * light_bands numbers, mean squared errors of values clipped to
 * [0, 1]: what is left out, and 4 more (5 or 7) where the material is decoded without BTF_EFFECT_RELIEF, 8 more (9 or
 * 11) where it is without BTF_EFFECT_GLOSS, each of which it holds; of the material, linear and sRGB-coded; of the data
 * themselves, interpolated likewise; then, [view band][light band], of the material, -1 where nothing can be left out. All 0 and NULL when there is
 * none. */
typedef struct btf_between_errors {
    uint32_t view_bands, light_bands;        /**< 1 .. BTF_MAX_BANDS */
    const float *view_limits, *light_limits; /**< [bands + 1] theta in degrees, ascending */
    uint32_t row_count;                      /**< at most 7 */
    uint32_t row_stride;                     /**< floats of a row */
    const float *rows;
} btf_between_errors;

typedef struct btf_material btf_material;

/** A list of directions, triangulated and gridded as FORMAT.md section 6 says. The arrays belong to the
 * material. */
typedef struct btf_directions {
    uint32_t count;
    const float *xyz;         /**< [count][3], unit, in paper order: theta ascending, then phi */
    const uint16_t *vertices; /**< [count][2], projected, 0 .. 16384 */
    uint32_t triangle_count;
    const uint16_t *triangles; /**< [triangle_count][3], indices of directions */
    uint32_t hull_count;
    const uint16_t *hull;  /**< [hull_count], indices of directions */
    uint32_t grid;         /**< G */
    const uint16_t *cells; /**< for each of G * G cells, row by row: count, then record numbers */
    size_t cells_length;   /**< entries of cells */
} btf_directions;

/** Opens a *.btf.exr file. Every rule of FORMAT.md section 2 is checked.
 *  Errors: BTF_ERROR_IO (cannot read), BTF_ERROR_BAD_FILE, BTF_ERROR_UNSUPPORTED (newer version),
 *  BTF_ERROR_MEMORY. *out_material is closed with btf_material_close. */
btf_result btf_material_open(const char *path, const btf_log *log, btf_material **out_material);

/** The same from the bytes of such a file in memory, with the same errors; they are not needed after the
 * call. */
btf_result btf_material_open_memory(const void *data, size_t size, const btf_log *log,
                                    btf_material **out_material);

/** Frees *material and sets it to NULL. NULL and a pointer to NULL are accepted. */
void btf_material_close(btf_material **material);

/** Fills *out_info up to its struct_size, which the caller sets. Strings belong to the material. Errors:
 * BTF_ERROR_USAGE (a struct_size too small to be one). */
btf_result btf_material_get_info(const btf_material *material, btf_material_info *out_info);

/** @return the texture; format NONE when absent. Data belong to the material. */
btf_texture btf_material_texture(const btf_material *material, btf_texture_id id);

/** @return the same of a level of detail: level 0 is btf_material_texture; a higher one has sbrdf, shadow,
 *  shift, gain, points, point_lists, point_indices, residual_texels, factor_texels and heights of its own
 * and shares the rest with level 0 (format NONE here, as for a level that the material does not have). */
btf_texture btf_material_level_texture(const btf_material *material, uint32_t level, btf_texture_id id);

/** @return the sampled directions to the viewer, and to the light. */
btf_directions btf_material_views(const btf_material *material);
btf_directions btf_material_lights(const btf_material *material);

/** @return the encoder's measured errors, *out_count rows, owned by the material; NULL when there are none.
 */
const btf_material_error *btf_material_errors(const btf_material *material, size_t *out_count);

/** @return the measured errors of the levels, *out_count rows by rising level, owned by the material; NULL
 * when there are none. */
const btf_level_error *btf_material_level_errors(const btf_material *material, size_t *out_count);

/** @return what the encoder measured of the ways to decode; owned by the material. */
btf_effect_errors btf_material_effect_errors(const btf_material *material);

/** @return what the encoder estimated of the error between the samples; owned by the material. */
btf_between_errors btf_material_between_errors(const btf_material *material);

/** All that a material is made from, as an encoder hands it over. Textures as in btf_texture, of which only
 * `data` is read (sizes and formats follow from the rest; see btf_material_texture_shape); entries that the
 * effects do not call for must be NULL. residual_scales is BTF_TEXTURE_RESIDUAL_SCALES; the two tables and
 * view_vectors are made here.
 */
typedef struct btf_material_desc {
    size_t struct_size;     /**< sizeof(btf_material_desc) */
    btf_material_info info; /**< inputs: everything but gpu_bytes and table_bytes; strings may be NULL */
    const float *views;     /**< [n_views][3], unit, z > 0, paper order, no duplicates */
    const float *lights;    /**< [n_lights][3] */
    const void *texture[BTF_TEXTURE_COUNT];
    const btf_material_error *errors;
    size_t error_count;
    const void
        *level_texture[BTF_MAX_LEVELS][BTF_TEXTURE_COUNT]; /**< levels 1 .. info.levels - 1, shapes as in
                                                     btf_material_level_shape; row 0 is not read */
    const btf_level_error *level_errors;                   /**< by rising level */
    size_t level_error_count;
    const float *effect_errors; /**< as the attribute openbtf.effectErrors holds them; NULL: none */
    size_t effect_error_count;  /**< floats */
    const float *between_errors; /**< as the attribute openbtf.betweenErrors holds them; NULL: none */
    size_t between_error_count;  /**< floats */
    /** A picture for viewers of EXR files, which no decoder reads: halves, [height][width][4], linear Rec.
     * 709 RGB and a 0; NULL: none. Only in materials that need version 2. */
    const uint16_t *preview;
    const uint8_t *relief_views; /**< [n_views], 0 or 1: whether relief acts on the view; NULL: on all. With
                                    BTF_EFFECT_RELIEF alone */
} btf_material_desc;

/** @return the picture for viewers (see btf_material_desc), owned by the material; NULL when there is none.
 */
const uint16_t *btf_material_preview(const btf_material *material);

/** The shape (format, is_array, width, height, layers, size; data NULL) that a texture of a material with
 * this info has; format NONE when it has none. The two tables and view_vectors have no shape before they
 * are made. */
btf_texture btf_material_texture_shape(const btf_material_info *info, btf_texture_id id);

/** The same of a level of detail; level 0 is btf_material_texture_shape. Format NONE for what a level
 * shares with level 0, and for a level that info does not have. */
btf_texture btf_material_level_shape(const btf_material_info *info, uint32_t level, btf_texture_id id);

/** @return bytes that a level adds to gpu_bytes: those of its own textures; of level 0 all, shared ones
 * included. */
size_t btf_level_bytes(const btf_material_info *info, uint32_t level);

/** @return texels of a side of `size` texels in a level: max(1, size >> level). */
uint32_t btf_level_size(uint32_t size, uint32_t level);

/** The smallest legal atlas of layout `paper` (FORMAT.md section 5) for info's width, height, n_views,
 * n_lights, effects and, with hidden, at least so many centres: sets *out_width, *out_height and *out_room
 * (centres). BTF_ERROR_UNSUPPORTED when there is none. */
btf_result btf_material_atlas(const btf_material_info *info, uint32_t *out_width, uint32_t *out_height,
                              uint32_t *out_room);

/** Sets the atlas column (*out_x) and first row (*out_y) of centre i in an atlas of info's size. */
void btf_material_atlas_centre(const btf_material_info *info, uint32_t i, uint32_t *out_x, uint32_t *out_y);

/** Makes a material from textures, copying them; triangulates the directions; checks everything that
 * opening a file checks. Errors: BTF_ERROR_USAGE (names the value), BTF_ERROR_UNSUPPORTED,
 * BTF_ERROR_MEMORY. */
btf_result btf_material_create(const btf_material_desc *desc, const btf_log *log,
                               btf_material **out_material);

/** The same material in layout `tight`: where a GPU's textures may not be as large as the atlas of layout
 * `paper`, its tiles become layers of array textures (FORMAT.md section 5). It decodes to the same bits;
 * the shadow of a material without SBRDF, which changes nothing, is left out. Errors: BTF_ERROR_MEMORY. */
btf_result btf_material_to_tight(const btf_material *material, const btf_log *log,
                                 btf_material **out_material);

/** Writes to a temporary name beside @p path, then renames. Errors: BTF_ERROR_IO, BTF_ERROR_MEMORY. */
btf_result btf_material_save(const btf_material *material, const char *path, const btf_log *log);

/** Writes a file to memory; *out_data is to be freed with btf_free. Errors: BTF_ERROR_MEMORY. */
btf_result btf_material_save_memory(const btf_material *material, const btf_log *log, void **out_data,
                                    size_t *out_size);

/** Frees what the library handed over; NULL is accepted. */
void btf_free(void *pointer);

#ifdef __cplusplus
}
#endif
#endif
