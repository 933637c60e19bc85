/* A failing allocator: the n-th allocation of each call fails, for every n. The call must either return
 * BTF_ERROR_MEMORY, or succeed without that memory and give the same output; and it must leave nothing behind. The
 * allocator of the whole process is replaced, so that OpenEXR's allocations fail as well; under a sanitizer, which
 * replaces it too, the cases are skipped.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/gl_functions.h"
#include "tests/support/factor_material.h"
#include "tests/support/refusals.h"
#include "tests/support/test.h"
#include <openbtf/gl.h>
#include <openbtf/plan.h>
#include <openbtf/shader.h>
#include <unistd.h>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(memory_sanitizer)
#define SANITIZED 1
#endif
#endif
#if !defined(SANITIZED) && !defined(__GLIBC__)
#define SANITIZED 1
#endif

#ifndef SANITIZED
static bool watching;
static long long until_failure, outstanding;

void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *pointer, size_t size);
void __libc_free(void *pointer);

static bool fails(void) {
    return watching && until_failure-- == 0;
}

static void *counted(void *pointer) {
    if (watching && pointer) {
        outstanding++;
    }
    return pointer;
}

void *malloc(size_t size) {
    return fails() ? NULL : counted(__libc_malloc(size));
}

void *calloc(size_t count, size_t size) {
    return fails() ? NULL : counted(__libc_calloc(count, size));
}

void *realloc(void *pointer, size_t size) {
    if (fails()) {
        return NULL;
    }
    void *moved = __libc_realloc(pointer, size);
    return pointer ? moved : counted(moved);
}

void free(void *pointer) {
    if (watching && pointer) {
        outstanding--;
    }
    __libc_free(pointer);
}

static void watch(long long n) {
    until_failure = n;
    outstanding = 0;
    watching = true;
}

typedef struct fixture {
    btf_material_desc desc;
    btf_material *material;
    void *data;
    size_t size;
    char path[300]; /* of a file of `data` */
    btf_plan plan;
} fixture;

static void make_path(const char *name, char path[300]) {
    const char *base = getenv("TMPDIR");
    snprintf(path, 300, "%.200s/btf-memory-%ld-%.40s.btf.exr", base && *base ? base : "/tmp",
             (long)getpid(), name);
}

/* Kinds of material. */
enum { PAPER, TIGHT, FACTORS, KINDS };
static const char *const kind_names[KINDS] = {"layout paper", "layout tight", "factors"};

static fixture make(int kind) {
    static const uint16_t preview[3 * 2 * 4] = {0x3C00, 0x3800};
    const btf_layout layout = kind == PAPER ? BTF_LAYOUT_PAPER : BTF_LAYOUT_TIGHT;
    random_state r = {41};
    fixture f = {.desc = kind == FACTORS ? factor_material_desc(3, 2, 5, 4, layout, BTF_EFFECT_VERSION_1,
                                                                factor_classes)
                                         : random_material_desc(3, 2, 5, 4, layout, BTF_EFFECT_VERSION_1)};
    f.desc.info.blend = kind == FACTORS ? BTF_BLEND_ROOTS : BTF_BLEND_RADIANCE;
    f.desc.preview = kind == FACTORS ? preview : NULL;
    f.desc.info.method = "joint";
    static const btf_material_error errors[1] = {{0, 20, 20, 100}};
    static const btf_level_error level_errors[1] = {{0, 20, 20, 100}};
    f.desc.errors = errors;
    f.desc.error_count = 1;
    f.desc.info.levels = layout == BTF_LAYOUT_TIGHT ? 2 : 1;
    f.desc.level_errors = level_errors;
    f.desc.level_error_count = 1;
    static const float between[13] = {1, 1, 0, 60, 0, 60, 3, 0.1f, 0.2f, 0.1f, 0.2f, 0.1f, 0.2f};
    f.desc.between_errors = between;
    f.desc.between_error_count = 13;
    factor_material_fill(&r, &f.desc);
    assert_int_equal(btf_material_create(&f.desc, NULL, &f.material), BTF_OK);
    assert_int_equal(btf_material_save_memory(f.material, NULL, &f.data, &f.size), BTF_OK);
    make_path("in", f.path);
    assert_int_equal(btf_material_save(f.material, f.path, NULL), BTF_OK);
    const btf_scene scene = {.light = {.fixed = 1, .direction = {0, 0, 1}}};
    assert_int_equal(btf_plan_effects(f.material, &scene, 1, &f.plan), BTF_OK);
    return f;
}

static void clear(fixture *f) {
    unlink(f->path);
    btf_material_close(&f->material);
    btf_free(f->data);
    random_material_free(&f->desc);
}

/* The output of the last call, in 64 bits (FNV-1a). */
static uint64_t given;

static void note(const void *data, size_t size) {
    given = 14695981039346656037u;
    for (size_t i = 0; i < size; i++) {
        given = (given ^ ((const unsigned char *)data)[i]) * 1099511628211u;
    }
}

/* The end of a call that makes a material: closes it. */
static btf_result made(btf_result result, btf_material **m) {
    assert_true((result == BTF_OK) == (*m != NULL));
    if (result == BTF_OK) {
        void *data;
        size_t size;
        const bool was = watching;
        watching = false;
        assert_int_equal(btf_material_save_memory(*m, NULL, &data, &size), BTF_OK);
        note(data, size);
        btf_free(data);
        watching = was;
    }
    btf_material_close(m);
    return result;
}

static btf_result do_create(const fixture *f) {
    btf_material *m;
    return made(btf_material_create(&f->desc, &log_keep, &m), &m);
}

static btf_result do_open(const fixture *f) {
    btf_material *m;
    return made(btf_material_open_memory(f->data, f->size, &log_keep, &m), &m);
}

static btf_result do_open_file(const fixture *f) {
    btf_material *m;
    return made(btf_material_open(f->path, &log_keep, &m), &m);
}

static btf_result do_tight(const fixture *f) {
    btf_material *m;
    return made(btf_material_to_tight(f->material, &log_keep, &m), &m);
}

static btf_result do_restrict(const fixture *f) {
    btf_material *m;
    return made(btf_material_restrict(f->material, &f->plan, &log_keep, &m), &m);
}

/* btf_plan_effects takes no log. */
static btf_result do_plan(const fixture *f) {
    btf_plan plan;
    btf_result result = btf_plan_effects(f->material, &f->plan.scene, 1, &plan);
    message_count += result != BTF_OK;
    note(&plan.psnr_linear, sizeof plan.psnr_linear);
    return result;
}

static btf_result do_save(const fixture *f) {
    void *data;
    size_t size;
    btf_result result = btf_material_save_memory(f->material, &log_keep, &data, &size);
    if (result == BTF_OK) {
        note(data, size);
    }
    btf_free(data);
    return result;
}

/* Saves to a path: after a failure no temporary file may be left. */
static btf_result do_save_file(const fixture *f) {
    char path[300];
    make_path("out", path);
    btf_result result = btf_material_save(f->material, path, &log_keep);
    if (result == BTF_OK) {
        static char data[1 << 20];
        const bool was = watching;
        watching = false;
        FILE *file = fopen(path, "rb");
        assert_non_null(file);
        note(data, fread(data, 1, sizeof data, file));
        fclose(file);
        watching = was;
    }
    unlink(path);
    return result;
}

static btf_result do_shader(const fixture *f) {
    char *text;
    btf_result result = btf_shader_source(f->material, NULL, &log_keep, &text);
    if (result == BTF_OK) {
        note(text, strlen(text));
    }
    btf_free(text);
    return result;
}

/* A GL of version 4.5 that does nothing but count textures, whose memory runs out at the n-th image. */
static int textures, images_left;
static uint32_t gl_error;

static void gl_nothing(void) {}
static void gl_get_integers(uint32_t name, int32_t *values) {
    *values = name == GL_MAJOR_VERSION              ? 4
              : name == GL_MINOR_VERSION            ? 5
              : name == GL_MAX_TEXTURE_SIZE         ? 16384
              : name == GL_MAX_ARRAY_TEXTURE_LAYERS ? 2048
                                                    : 0;
}
static const unsigned char *gl_get_string(uint32_t name) {
    (void)name;
    return (const unsigned char *)"4.5";
}
static uint32_t gl_get_error(void) {
    uint32_t error = gl_error;
    gl_error = GL_NO_ERROR;
    return error;
}
static void gl_gen_textures(int32_t count, uint32_t *names) {
    for (int32_t i = 0; i < count; i++) {
        names[i] = (uint32_t)(++textures);
    }
}
static void gl_delete_textures(int32_t count, const uint32_t *names) {
    (void)names;
    textures -= count;
}
static void gl_image(void) {
    if (images_left-- == 0) {
        gl_error = GL_OUT_OF_MEMORY;
    }
}

static btf_gl_function find_function(void *user, const char *name) {
    (void)user;
    static const struct {
        const char *name;
        btf_gl_function function;
    } table[] = {
        {"glGetIntegerv", (btf_gl_function)gl_get_integers},
        {"glGetString", (btf_gl_function)gl_get_string},
        {"glGetError", (btf_gl_function)gl_get_error},
        {"glGenTextures", (btf_gl_function)gl_gen_textures},
        {"glDeleteTextures", (btf_gl_function)gl_delete_textures},
        {"glTexImage2D", gl_image},
        {"glTexImage3D", gl_image},
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        if (!strcmp(table[i].name, name)) {
            return table[i].function;
        }
    }
    return gl_nothing;
}

static btf_result do_upload(const fixture *f) {
    const btf_gl_options options = {.struct_size = sizeof options, .get_proc_address = find_function};
    btf_gl *gl;
    btf_result result = btf_gl_upload(f->material, &options, &log_keep, &gl);
    assert_true((result == BTF_OK) == (gl != NULL));
    btf_gl_destroy(&gl);
    assert_int_equal(textures, 0);
    return result;
}

/* `spared`: how many blocks a failed call may leak. OpenEXR 3.1.5 leaks one when it has no memory for the name of an
 * attribute or channel that it adds. */
static void every_failure(const char *name, btf_result (*call)(const fixture *f), long long spared) {
    for (int kind = 0; kind < KINDS; kind++) {
        fixture f = make(kind);
        long long n = 0;
        assert_int_equal(call(&f), BTF_OK);
        const uint64_t wanted = given;
        for (;; n++) {
            message_count = 0;
            watch(n);
            btf_result result = call(&f);
            watching = false;
            if (outstanding < 0 || outstanding > spared) {
                print_error("%s: %lld blocks are left when allocation %lld fails\n", name, outstanding, n);
            }
            assert_in_range(outstanding, 0, spared);
            if (result == BTF_OK) { /* OpenEXR can do without some allocations */
                assert_true(given == wanted);
            } else {
                assert_int_equal(message_count, 1);
            }
            if (until_failure >= 0) { /* the call made fewer allocations: all of them have failed in turn */
                assert_int_equal(result, BTF_OK);
                break;
            }
            assert_true(n < 100000);
        }
        printf("CASE | %s, %s: each allocation fails in turn | one message and nothing left, or the same "
               "result | %lld allocations | pass\n",
               name, kind_names[kind], n);
        clear(&f);
    }
}
/* GL's own memory runs out at each image in turn. */
static void every_image(void) {
    for (int kind = 0; kind < KINDS; kind++) {
        fixture f = make(kind);
        for (int n = 0;; n++) {
            message_count = textures = 0;
            images_left = n;
            btf_result result = do_upload(&f);
            if (images_left >= 0) {
                assert_int_equal(result, BTF_OK);
                assert_in_range(n, 3, 100);
                break;
            }
            assert_int_equal(result, BTF_ERROR_MEMORY);
            assert_int_equal(message_count, 1);
        }
        clear(&f);
    }
}

TEST(test_create) {
    every_failure("create", do_create, 0);
}

TEST(test_open) {
    every_failure("open", do_open, 0);
}

TEST(test_open_file) {
    every_failure("open a path", do_open_file, 0);
}

TEST(test_restrict) {
    every_failure("plan", do_plan, 0);
    every_failure("restrict", do_restrict, 0);
    every_failure("to layout tight", do_tight, 0);
}

TEST(test_save) {
    every_failure("save", do_save, 1);
}

TEST(test_save_file) {
    every_failure("save to a path", do_save_file, 1);
}

TEST(test_shader) {
    every_failure("shader source", do_shader, 0);
}

TEST(test_upload) {
    images_left = 1 << 30;
    every_failure("upload", do_upload, 0);
    every_image();
}

int main(void) {
    printf("TITLE | A failing allocator: the n-th allocation of a call fails, for every n.\n");
    return run_listed("tests", NULL, NULL);
}
#else
int main(void) {
    printf("skipped: a sanitizer owns the allocator\n");
    return 77;
}
#endif
