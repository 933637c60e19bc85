/* Reading Wavefront OBJ (Appendix B1 of the Advanced Visualizer manual, 1995; the polygonal part).
 *
 * SPDX-License-Identifier: MIT
 */
#include "obj.h"

#include "decoder/toolkit/file.h"
#include "decoder/toolkit/text.h"
#include "polygon.h"
#include "tangents.h"
#include "vec.h"
#include <ctype.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_CORNERS = 1 << 24 };

/* A growing array of 3 floats each, or of 3 ints. */
typedef struct list {
    void *items;
    size_t count, room, size;
} list;

/* Indices of one corner: position, texture coordinate, normal; -1: none. */
typedef struct corner {
    int32_t at[3];
} corner;

typedef struct parser {
    const char *name, *p, *end;
    int line;
    const btf_log *log;
    list lists[3];   /* positions, texture coordinates, normals: float[3] */
    list corners;    /* of triangles, three by three */
    list face;       /* corners of the face that is being read */
    bool has_curves; /* a free-form curve or surface was met */
    btf_result result;
} parser;

static btf_result fail(parser *o, btf_result result, const char *format, ...) {
    char text[300];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    file_say(o->log, "%s:%d: %s", o->name, o->line, text);
    return o->result = result;
}

static bool push(parser *o, list *l, const void *item) {
    if (l->count == l->room) {
        size_t room = l->room ? 2 * l->room : 1024;
        void *grown = realloc(l->items, room * l->size);
        if (!grown) {
            fail(o, BTF_ERROR_MEMORY, "out of memory for %zu elements", room);
            return false;
        }
        l->items = grown;
        l->room = room;
    }
    memcpy((char *)l->items + l->count++ * l->size, item, l->size);
    return true;
}

static bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\v' || c == '\f';
}

static bool at_end_of_line(const parser *o) {
    return o->p == o->end || *o->p == '\n' || *o->p == '\r' || *o->p == '#';
}

/* Whether a backslash stands here that ends its line. */
static bool at_continuation(const parser *o) {
    return o->end - o->p > 1 && o->p[0] == '\\' && (o->p[1] == '\n' || o->p[1] == '\r');
}

/* Skips blanks, and line ends behind a backslash. */
static void skip_blanks(parser *o) {
    for (;;) {
        if (o->p < o->end && is_blank(*o->p)) {
            o->p++;
        } else if (at_continuation(o)) {
            o->p += o->p[1] == '\r' && o->p + 2 < o->end && o->p[2] == '\n' ? 3 : 2;
            o->line++;
        } else {
            return;
        }
    }
}

static void skip_line(parser *o) {
    while (o->p < o->end && *o->p != '\n' && *o->p != '\r') {
        o->p++;
    }
    if (o->p < o->end) {
        o->p += o->end - o->p > 1 && o->p[0] == '\r' && o->p[1] == '\n' ? 2 : 1;
    }
    o->line++;
}

/* Reads the next word, cut to fit; it is empty at the end of the line. */
static void read_word(parser *o, char *word, size_t size) {
    size_t length = 0;
    skip_blanks(o);
    while (!at_end_of_line(o) && !is_blank(*o->p) && !at_continuation(o)) {
        if (length + 1 < size) {
            word[length++] = *o->p;
        }
        o->p++;
    }
    word[length] = '\0';
}

/* Reads a vector of at least `least` numbers into the list, which keeps 3: missing ones are 0, further ones are
 * skipped. */
static void read_vector(parser *o, list *l, int least, const char *what) {
    float values[3] = {0, 0, 0};
    char word[64], *end;
    for (int i = 0; i < 3; i++) {
        read_word(o, word, sizeof word);
        if (!word[0]) {
            if (i < least) {
                fail(o, BTF_ERROR_BAD_FILE, "%s: %d numbers, expected %d", what, i, least);
                return;
            }
            break;
        }
        if (strlen(word) + 1 == sizeof word) {
            fail(o, BTF_ERROR_BAD_FILE, "%s: the number '%s...' is longer than %zu characters", what, word,
                 sizeof word - 2);
            return;
        }
        double value = strtod(word, &end);
        if (*end || !(fabs(value) <= 1e18)) {
            fail(o, BTF_ERROR_BAD_FILE, "%s: '%s' is not a number within -1e18 to 1e18", what, word);
            return;
        }
        values[i] = (float)value;
    }
    push(o, l, values);
}

/* Reads one corner of a face, "v", "v/t", "v//n" or "v/t/n"; indices count from 1, or backwards from -1. */
static bool read_corner(parser *o, const char *word, corner *out) {
    static const char *const kinds[3] = {"vertex", "texture coordinate", "normal"};
    const char *p = word;
    *out = (corner){{-1, -1, -1}};
    for (int k = 0; k < 3; k++) {
        char *end;
        if (k == 0 || (*p != '/' && *p)) { /* a position is always there */
            long index = strtol(p, &end, 10);
            const long count = (long)o->lists[k].count;
            if (end == p || (*end && *end != '/') || isspace((unsigned char)*p)) {
                fail(o, BTF_ERROR_BAD_FILE, "face: '%s' is not of the form v, v/t, v//n or v/t/n", word);
                return false;
            }
            long at = index > 0 ? index - 1 : index < 0 ? count + index : -1;
            if (at < 0 || at >= count) {
                fail(o, BTF_ERROR_BAD_FILE, "face: refers to %s %ld, but %ld are given so far", kinds[k],
                     index, count);
                return false;
            }
            out->at[k] = (int32_t)at;
            p = end;
        }
        if (!*p) {
            break;
        }
        if (k == 2) {
            fail(o, BTF_ERROR_BAD_FILE, "face: '%s' has more than three indices", word);
            return false;
        }
        p++;
    }
    if (out->at[1] < 0) {
        fail(o, BTF_ERROR_BAD_FILE, "face: '%s' has no texture coordinate, which a material needs", word);
    }
    return out->at[1] >= 0;
}

static const float *element(const parser *o, int kind, int32_t index) {
    return (const float *)o->lists[kind].items + 3 * (size_t)index;
}

/* Cuts the face into triangles and adds their corners. */
static void add_face(parser *o) {
    const corner *corners = o->face.items;
    const uint32_t count = (uint32_t)o->face.count;
    if (o->corners.count + 3 * (size_t)(count - 2) > MAX_CORNERS) {
        fail(o, BTF_ERROR_UNSUPPORTED, "more than %d corners", MAX_CORNERS);
        return;
    }
    vec3 *at = malloc(count * sizeof *at);
    uint32_t *triangles = malloc(3 * (size_t)(count - 2) * sizeof *triangles);
    for (uint32_t i = 0; at && i < count; i++) {
        at[i] = vec_from(element(o, 0, corners[i].at[0]));
    }
    if (!at || !triangles || !polygon_triangulate(at, count, triangles)) {
        fail(o, BTF_ERROR_MEMORY, "out of memory for a face of %u corners", (unsigned)count);
    } else {
        for (size_t i = 0; i < 3 * (size_t)(count - 2); i++) {
            if (!push(o, &o->corners, &corners[triangles[i]])) {
                break;
            }
        }
    }
    free(at);
    free(triangles);
}

static void read_face(parser *o) {
    corner next;
    char word[80];
    o->face.count = 0;
    for (read_word(o, word, sizeof word); word[0]; read_word(o, word, sizeof word)) {
        if (o->face.count == MAX_CORNERS) {
            fail(o, BTF_ERROR_UNSUPPORTED, "more than %d corners", MAX_CORNERS);
            return;
        }
        if (!read_corner(o, word, &next) || !push(o, &o->face, &next)) {
            return;
        }
    }
    if (o->face.count < 3) {
        fail(o, BTF_ERROR_BAD_FILE, "face: has %zu corners, expected 3 or more", o->face.count);
    } else {
        add_face(o);
    }
}

static void read_statement(parser *o) {
    char word[32];
    read_word(o, word, sizeof word);
    if (!strcmp(word, "v")) {
        read_vector(o, &o->lists[0], 3, "vertex");
    } else if (!strcmp(word, "vt")) {
        read_vector(o, &o->lists[1], 1, "texture coordinate");
    } else if (!strcmp(word, "vn")) {
        read_vector(o, &o->lists[2], 3, "normal");
    } else if (!strcmp(word, "f") || !strcmp(word, "fo")) { /* the older name of a face */
        read_face(o);
    } else if ((!strcmp(word, "surf") || !strcmp(word, "curv") || !strcmp(word, "curv2")) &&
               !o->has_curves) {
        if (o->log && o->log->callback) {
            char text[300];
            snprintf(text, sizeof text, "%.200s:%d: '%s': free-form curves and surfaces are left out",
                     o->name, o->line, word);
            o->log->callback(o->log->user, BTF_LOG_WARNING, text);
        }
        o->has_curves = true;
    }
}

/* The hash of a corner (FNV-1a, but over words, G. Fowler, L. C. Noll and K.-P. Vo). Equal corners share a vertex,
 * which an open hash table finds. */
static uint32_t hash(const corner *c) {
    uint32_t h = 2166136261u;
    for (int k = 0; k < 3; k++) {
        h = (h ^ (uint32_t)c->at[k]) * 16777619u;
    }
    return h ^ (h >> 15);
}

static void set_vertex(const parser *o, const corner *c, mesh_vertex *out) {
    memcpy(out->position, element(o, 0, c->at[0]), sizeof out->position);
    memcpy(out->uv, element(o, 1, c->at[1]), sizeof out->uv);
    if (c->at[2] >= 0) {
        vec_store(vec_unit(vec_from(element(o, 2, c->at[2])), vec(0, 0, 1)), out->normal);
    }
}

static mesh *index_corners(const parser *o) {
    const corner *corners = o->corners.items;
    const uint32_t count = (uint32_t)o->corners.count;
    size_t slots = 1;
    while (slots < 2 * (size_t)count) {
        slots *= 2;
    }
    uint32_t *table = malloc(slots * sizeof *table);
    mesh *m = mesh_allocate(count, count / 3);
    if (!table || !m) {
        free(table);
        mesh_destroy(&m);
        return NULL;
    }
    memset(table, 0xff, slots * sizeof *table);
    m->vertex_count = 0;
    for (uint32_t i = 0; i < count; i++) {
        size_t slot = hash(&corners[i]) & (slots - 1);
        while (table[slot] != UINT32_MAX &&
               memcmp(&corners[m->triangles[table[slot]]], &corners[i], sizeof *corners) != 0) {
            slot = (slot + 1) & (slots - 1);
        }
        if (table[slot] == UINT32_MAX) {
            /* until all are known, triangles[] holds at a new vertex's number the corner that made it */
            table[slot] = m->vertex_count;
            m->triangles[m->vertex_count] = i;
            set_vertex(o, &corners[i], &m->vertices[m->vertex_count++]);
        }
    }
    uint32_t *first = malloc(((size_t)m->vertex_count + 1) * sizeof *first);
    if (!first) {
        free(table);
        mesh_destroy(&m);
        return NULL;
    }
    memcpy(first, m->triangles, m->vertex_count * sizeof *first);
    for (uint32_t i = 0; i < count; i++) {
        size_t slot = hash(&corners[i]) & (slots - 1);
        while (memcmp(&corners[first[table[slot]]], &corners[i], sizeof *corners) != 0) {
            slot = (slot + 1) & (slots - 1);
        }
        m->triangles[i] = table[slot];
    }
    free(first);
    free(table);
    return m;
}

/* Moves and scales the mesh into the unit sphere round the origin. */
static void fit(mesh *m) {
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY}, radius = 0;
    for (uint32_t i = 0; i < m->vertex_count; i++) {
        for (int k = 0; k < 3; k++) {
            low[k] = fmin(low[k], (double)m->vertices[i].position[k]);
            high[k] = fmax(high[k], (double)m->vertices[i].position[k]);
        }
    }
    vec3 centre = vec((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2);
    for (uint32_t i = 0; i < m->vertex_count; i++) {
        radius = fmax(radius, vec_length(vec_sub(vec_from(m->vertices[i].position), centre)));
    }
    for (uint32_t i = 0; i < m->vertex_count; i++) {
        vec3 p = vec_sub(vec_from(m->vertices[i].position), centre);
        vec_store(vec_mul(p, radius > 0 ? 1 / radius : 1), m->vertices[i].position);
    }
}

static bool has_all_normals(const parser *o) {
    const corner *corners = o->corners.items;
    for (size_t i = 0; i < o->corners.count; i++) {
        if (corners[i].at[2] < 0) {
            return false;
        }
    }
    return true;
}

/* Sets every normal to the mean over the triangles at its position, weighted by area, so that seams of uv do not
 * show. */
static void average_normals(const parser *o, mesh *m) {
    const corner *corners = o->corners.items;
    float *sums = o->lists[2].items; /* one a position */
    for (size_t i = 0; i < o->lists[0].count; i++) {
        vec_store(vec(0, 0, 0), sums + 3 * i);
    }
    for (uint32_t f = 0; f < m->triangle_count; f++) {
        const corner *c = corners + 3 * (size_t)f;
        const uint32_t *t = m->triangles + 3 * (size_t)f;
        vec3 a = vec_from(m->vertices[t[0]].position);
        vec3 n = vec_cross(vec_sub(vec_from(m->vertices[t[1]].position), a),
                           vec_sub(vec_from(m->vertices[t[2]].position), a));
        for (int k = 0; k < 3; k++) {
            float *sum = sums + 3 * (size_t)c[k].at[0];
            vec_store(vec_add(vec_from(sum), n), sum);
        }
    }
    for (uint32_t i = 0; i < 3 * m->triangle_count; i++) {
        vec_store(vec_unit(vec_from(sums + 3 * (size_t)corners[i].at[0]), vec(0, 0, 1)),
                  m->vertices[m->triangles[i]].normal);
    }
}

static btf_result finish(parser *o, mesh **out_mesh) {
    if (o->corners.count == 0) {
        return fail(o, BTF_ERROR_BAD_FILE, "the file has no face");
    }
    mesh *m = index_corners(o);
    bool ok = m != NULL;
    if (ok) {
        fit(m);
    }
    if (ok && !has_all_normals(o)) {
        const float zero[3] = {0, 0, 0};
        while (ok && o->lists[2].count < o->lists[0].count) {
            ok = push(o, &o->lists[2], zero);
        }
        if (ok) {
            average_normals(o, m);
        }
    }
    if (!ok || mesh_compute_tangents(m)) {
        mesh_destroy(&m);
        return o->result ? o->result : fail(o, BTF_ERROR_MEMORY, "out of memory for the mesh");
    }
    *out_mesh = m;
    return BTF_OK;
}

btf_result mesh_parse_obj(const char *name, const char *text, size_t size, const btf_log *log,
                          mesh **out_mesh) {
    const list vectors = {.size = 3 * sizeof(float)};
    parser o = {.name = name,
                .p = text,
                .end = text + size,
                .line = 1,
                .log = log,
                .lists = {vectors, vectors, vectors},
                .corners = {.size = sizeof(corner)},
                .face = {.size = sizeof(corner)}};
    size_t skip;
    const char *encoding = text_encoding(text, size, &skip);
    *out_mesh = NULL;
    if (encoding) {
        return fail(&o, BTF_ERROR_UNSUPPORTED, "the text is %s: save it as UTF-8", encoding);
    }
    o.p += skip;
    while (o.p < o.end && !o.result) {
        read_statement(&o);
        if (!o.result) {
            skip_line(&o);
        }
    }
    btf_result result = o.result ? o.result : finish(&o, out_mesh);
    for (int k = 0; k < 3; k++) {
        free(o.lists[k].items);
    }
    free(o.corners.items);
    free(o.face.items);
    return result;
}

btf_result mesh_read_obj(const char *path, const btf_log *log, mesh **out_mesh) {
    char *text;
    size_t size;
    *out_mesh = NULL;
    btf_result result = file_read(path, 1000000000, log, &text, &size);
    if (result) {
        return result;
    }
    result = mesh_parse_obj(path, text, size, log, out_mesh);
    free(text);
    return result;
}
