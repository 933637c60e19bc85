/* Prints five hashes of the reference decoder's results: of every function of its header on seeded arguments, over
 * made-up materials of every kind of version 1; of materials of version 2; of packed points; of lists of points; of
 * relief and gloss. Every compiler, optimisation level and machine has to give the hashes that are written below. Exits
 * 1 when one differs, 4 when the self-test refuses the build.
 *
 * With -DBTF_TEST_FREESTANDING it needs no C library (Linux on aarch64, i386 and x86-64), so that a
 * compiler for another machine and an emulator suffice.
 *
 * SPDX-License-Identifier: MIT
 */
#include "tests/support/reference_material.h"

#define EXPECTED_HASH 0xfcda22e85c947b10u
#define EXPECTED_HASH_2 0x12326c76419da8d1u
#define EXPECTED_HASH_3 0xbe302bc6c4de5000u
#define EXPECTED_HASH_4 0x5206558db6880991u
#define EXPECTED_HASH_5 0x8ceec597c9bdb979u

enum {
    SEEDS = 3,
    ARGUMENTS = 250,
    STEPS = 20000,
    HASHES = 5,
    EXIT_DIFFERENT = 1,
    EXIT_DENORMALS = 3,
    EXIT_UNSOUND = 4
};

static uint64_t hash;

/** FNV-1a, a word at a time. */
static void add(uint32_t word) {
    hash = (hash ^ word) * 1099511628211u;
    hash ^= hash >> 29;
}

static void add_neighbours(btf_ref_neighbours n) {
    for (int i = 0; i < 3; ++i) {
        add(n.index[i]);
        add(n.weight[i]);
    }
}

static void hash_steps(const btf_ref_material *tight, const btf_ref_material *paper) {
    uint32_t state = 7;
    for (int i = 0; i < STEPS; ++i) {
        add(bits_of(btf_ref_log2(float_of(0x33800000u + random_bits(&state) % 0x1B000000u))));
        add(bits_of(btf_ref_exp2(random_float(&state, -60.0f, 100.0f))));
        float base = random_float(&state, 0.0f, 4.0f);
        add(bits_of(btf_ref_pow(base, random_parameter(&state))));
        add(bits_of(btf_ref_reciprocal(random_float(&state, 0.5f, 3.5f))));
        add(bits_of(btf_ref_half((uint16_t)(random_bits(&state) & 0xFFFFu & ~0x400u))));

        uint32_t size = 1 + random_below(&state, 16384), c0, c1, weight, x, y;
        uint32_t t = btf_ref_coordinate(float_of(random_bits(&state)), size);
        btf_ref_bilinear(t, size, &c0, &c1, &weight);
        add(t), add(c0), add(c1), add(weight);
        uint32_t position = random_below(&state, size);
        add(btf_ref_wrap(position, (int32_t)random_below(&state, 256) - 128, size));
        uint32_t tile = random_below(&state, MADE_VIEWS), texel = random_below(&state, MADE_TEXELS);
        btf_ref_tile(paper, tile, texel % MADE_WIDTH, texel / MADE_WIDTH, &x, &y);
        add(x), add(y);
        uint32_t centre = random_below(&state, MADE_CENTRES), light = random_below(&state, MADE_LIGHTS);
        btf_ref_centre(paper, centre, light, &x, &y);
        add(x), add(y);
        btf_ref_centre(tight, centre, light, &x, &y);
        add(x), add(y);

        float direction[3];
        int32_t q[2];
        random_direction(&state, direction);
        btf_ref_project(direction, q);
        add((uint32_t)q[0]), add((uint32_t)q[1]);
        btf_ref_neighbours views = btf_ref_lookup(paper->view_table, paper->view_grid, q);
        add_neighbours(views);
        add_neighbours(btf_ref_nearest(views));
        add_neighbours(btf_ref_lookup(paper->light_table, paper->light_grid, q));
    }
}

static void hash_evaluation(const btf_ref_material *material, uint32_t seed) {
    /* members that came last must not change the older hashes */
    int newest = (material->effects & BTF_REF_RELIEF) != 0;
    uint32_t state = seed * 2u + 1u;
    for (int i = 0; i < ARGUMENTS; ++i) {
        btf_ref_options options = {.effects = UINT32_MAX, .components = UINT32_MAX};
        if (random_below(&state, 2) != 0) {
            options.effects = random_below(&state, 32) | (newest ? BTF_REF_RELIEF | BTF_REF_GLOSS : 0);
        }
        if (random_below(&state, 2) != 0) {
            options.components = random_below(&state, MADE_COMPONENTS);
        }
        options.interpolation = (int)random_below(&state, 2);
        options.filter = (int)random_below(&state, newest ? 3 : 2);
        float light[3], view[3], radiance[3];
        random_direction(&state, light);
        random_direction(&state, view);
        if (i % 10 == 0) { /* not even a unit vector */
            uint32_t component = random_below(&state, 3);
            light[component] = float_of(random_bits(&state));
        }
        float u = random_float(&state, -2.0f, 4.0f), v = random_float(&state, -2.0f, 4.0f);
        btf_ref_evaluate(material, &options, u, v, light, view, radiance);
        for (int c = 0; c < 3; ++c) {
            add(bits_of(radiance[c]));
        }
    }
}

/** @return the hash of everything. */
static uint64_t hash_all(void) {
    static made_storage storage[2];
    btf_ref_material material[2];
    hash = 14695981039346656037u;
    make_material(0, 0, 31, 0, &storage[0], &material[0]);
    make_material(0, 1, 31, 0, &storage[1], &material[1]);
    hash_steps(&material[1], &material[0]);
    for (uint32_t seed = 1; seed <= SEEDS; ++seed) {
        for (uint32_t kind = 0; kind < 24; ++kind) {
            uint32_t effects = seed == 1 ? 31 : (seed * 11 + kind * 5) % 32;
            for (int extreme = 0; extreme < 2; ++extreme) {
                make_material(100 * seed + kind, kind, effects, extreme, &storage[0], &material[0]);
                hash_evaluation(&material[0], seed * 1000 + kind * 2 + (uint32_t)extreme);
            }
        }
    }
    return hash;
}

/** The kinds of material that the second to fifth hash are made of. */
typedef enum subject { VERSION_2, POINTS, LISTS, RELIEF } subject;

/** @return the hash of `count` materials made from `seed`: of version 2, with packed points, with lists of points, with
 * relief and gloss. */
static uint64_t hash_subject(subject of, uint32_t seed, uint32_t count) {
    static made_storage storage;
    static made_factors factors;
    static made_relief relief;
    static uint8_t indices[MADE_VIEWS * MADE_TEXELS];
    btf_ref_material material;
    hash = 14695981039346656037u;
    for (uint32_t kind = 0; kind < count; ++kind) {
        int extreme = kind % 3 == 0;
        uint32_t effects = of == VERSION_2 && kind % 2 ? 31 : kind * 5 % 32;
        make_material(seed + kind, kind, effects, extreme, &storage, &material);
        if (of == VERSION_2 || (of != LISTS && kind % 2)) {
            make_factors(kind, extreme, &factors, &material);
        }
        if (of == POINTS || of == LISTS) {
            make_points(kind, extreme, &storage, &material);
        }
        if (of == LISTS) {
            make_lists(kind, 1 + kind % (MADE_VIEWS < 16 ? MADE_VIEWS : 16), &indices, &storage, &material);
        }
        if (of == RELIEF) {
            make_relief(kind, kind % 4 == 0, &relief, &material);
        }
        hash_evaluation(&material, 10 * seed + kind);
    }
    return hash;
}

static uint64_t hash_number(int number) {
    return number == 0   ? hash_all()
           : number == 1 ? hash_subject(VERSION_2, 700, 48)
           : number == 2 ? hash_subject(POINTS, 800, 48)
           : number == 3 ? hash_subject(LISTS, 900, 48)
                         : hash_subject(RELIEF, 600, 96);
}

/** Makes the processor treat denormal operands and results as 0, where this file knows how. */
static void flush_denormals(void) {
#if defined __SSE2__
    uint32_t control;
    __asm__ volatile("stmxcsr %0" : "=m"(control));
    control |= 0x8040u;
    __asm__ volatile("ldmxcsr %0" : : "m"(control));
#elif defined __aarch64__
    uint64_t control;
    __asm__ volatile("mrs %0, fpcr" : "=r"(control));
    control |= 1u << 24;
    __asm__ volatile("msr fpcr, %0" : : "r"(control));
#endif
}

/** Sixteen digits and a newline. */
static void format_hash(uint64_t value, char out_text[17]) {
    for (int i = 0; i < 16; ++i) {
        out_text[i] = "0123456789abcdef"[value >> (60 - 4 * i) & 15];
    }
    out_text[16] = '\n';
}

static const uint64_t expected[HASHES] = {EXPECTED_HASH, EXPECTED_HASH_2, EXPECTED_HASH_3, EXPECTED_HASH_4,
                                          EXPECTED_HASH_5};

static int run(char out_text[HASHES * 17]) {
    int as_expected = 1, without_denormals = 1;
    uint64_t result[HASHES];
    for (int i = 0; i < HASHES; ++i) {
        result[i] = hash_number(i);
        as_expected = as_expected && result[i] == expected[i];
        format_hash(result[i], out_text + 17 * i);
        if (i + 1 < HASHES) {
            out_text[17 * i + 16] = ' ';
        }
    }
    if (!btf_ref_self_test()) {
        return EXIT_UNSOUND;
    }
    if (!as_expected) {
        return EXIT_DIFFERENT;
    }
    flush_denormals();
    for (int i = 0; i < HASHES; ++i) {
        without_denormals = without_denormals && hash_number(i) == result[i];
    }
    return without_denormals ? 0 : EXIT_DENORMALS;
}

#ifdef BTF_TEST_FREESTANDING

/* Functions to which compilers may add calls of their own. */
void *memcpy(void *restrict target, const void *restrict source, size_t count);
void *memset(void *target, int value, size_t count);

void *memcpy(void *restrict target, const void *restrict source, size_t count) {
    unsigned char *to = target;
    const unsigned char *from = source;
    for (size_t i = 0; i < count; ++i) {
        *(volatile unsigned char *)(to + i) = from[i];
    }
    return target;
}

void *memset(void *target, int value, size_t count) {
    unsigned char *to = target;
    for (size_t i = 0; i < count; ++i) {
        *(volatile unsigned char *)(to + i) = (unsigned char)value;
    }
    return target;
}

/** Linux system calls, by number and up to three arguments. */
static long system_call(long number, long a, long b, long c) {
#if defined __aarch64__
    register long x8 __asm__("x8") = number;
    register long x0 __asm__("x0") = a;
    register long x1 __asm__("x1") = b;
    register long x2 __asm__("x2") = c;
    __asm__ volatile("svc 0" : "+r"(x0) : "r"(x8), "r"(x1), "r"(x2) : "memory");
    return x0;
#elif defined __x86_64__
    long result;
    __asm__ volatile("syscall"
                     : "=a"(result)
                     : "a"(number), "D"(a), "S"(b), "d"(c)
                     : "rcx", "r11", "memory");
    return result;
#elif defined __i386__
    long result;
    __asm__ volatile("int $0x80" : "=a"(result) : "a"(number), "b"(a), "c"(b), "d"(c) : "memory");
    return result;
#else
#error "no system calls are known for this machine"
#endif
}

#if defined __aarch64__
enum { CALL_WRITE = 64, CALL_EXIT = 93 };
__asm__(".globl _start\n_start:\n    mov x29, #0\n    bl start\n");
#elif defined __x86_64__
enum { CALL_WRITE = 1, CALL_EXIT = 60 };
__asm__(".globl _start\n_start:\n    xor %ebp, %ebp\n    call start\n");
#else
enum { CALL_WRITE = 4, CALL_EXIT = 1 };
__asm__(".globl _start\n_start:\n    xor %ebp, %ebp\n    and $-16, %esp\n    call start\n");
#endif

void start(void);
void start(void) {
    char text[HASHES * 17];
    int status = run(text);
    system_call(CALL_WRITE, 1, (long)text, (long)sizeof text);
    system_call(CALL_EXIT, status, 0, 0);
    for (;;) {
    }
}

#else

#include <stdio.h>

int main(void) {
    char text[HASHES * 17];
    int status = run(text);
    fwrite(text, 1, sizeof text, stdout);
    if (status == EXIT_UNSOUND) {
        fprintf(stderr, "the self-test of the reference decoder refuses this build\n");
    }
    if (status == EXIT_DENORMALS) {
        fprintf(stderr, "another hash with denormals flushed to zero\n");
    }
    if (status == EXIT_DIFFERENT) {
        fprintf(stderr, "expected");
        for (int i = 0; i < HASHES; ++i) {
            fprintf(stderr, " %016llx", (unsigned long long)expected[i]);
        }
        fprintf(stderr, "\n");
    }
    return status;
}

#endif
