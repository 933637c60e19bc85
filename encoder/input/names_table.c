/* The directions of images from a table. See names_table.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "names_table.h"

#include "csv.h"

#include <ctype.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

enum { COLUMNS = 5 };

struct enc_names_table {
    enc_angles *angles; /* [count of the source] */
    size_t *lines;      /* of the table that gave them; 0: none did */
    size_t n_found;
};

typedef struct named_path {
    const char *base; /* the name after the folders */
    size_t index;
} named_path;

typedef struct table_reader {
    enc_csv csv;
    const enc_source *source;
    enc_names_table *table;
    named_path *by_name; /* the source's images, sorted by their names without folders */
    /* The path of the source, without the ending of an archive: with links resolved, and as given. */
    char location[PATH_MAX], given[PATH_MAX];
    bool has_columns;
    size_t column[COLUMNS]; /* where file, theta_v, phi_v, theta_l, phi_l stand */
    size_t n_found, n_absent, first_absent;
    char absent[200];
} table_reader;

static const char *const column_names[COLUMNS] = {"file", "theta_v", "phi_v", "theta_l", "phi_l"};

/* Reduces a heading to what tells it from others: "Theta_V [deg]" to "thetav". */
static void simplify(const char *heading, char out[24]) {
    size_t length = 0;
    for (; *heading && length < 23; heading++) {
        if (isalnum((unsigned char)*heading)) {
            out[length++] = (char)tolower((unsigned char)*heading);
        }
    }
    out[length] = '\0';
    if (length > 3 && strcmp(out + length - 3, "deg") == 0) {
        out[length - 3] = '\0';
    } else if (length > 7 && strcmp(out + length - 7, "degrees") == 0) {
        out[length - 7] = '\0';
    }
}

/* The column that a heading names, or COLUMNS. */
static int column_of(const char *heading) {
    static const char *const words[COLUMNS][8] = {
        {"file", "filename", "image", "imagename", "name", "path"},
        {"thetav", "tv", "thetaview", "viewtheta", "thetacamera", "thetao", "thetaout", "thetar"},
        {"phiv", "pv", "phiview", "viewphi", "phicamera", "phio", "phiout", "phir"},
        {"thetal", "tl", "thetalight", "lighttheta", "thetai", "thetain", "thetasource"},
        {"phil", "pl", "philight", "lightphi", "phii", "phiin", "phisource"},
    };
    char simple[24];
    simplify(heading, simple);
    for (int column = 0; column < COLUMNS; column++) {
        for (int i = 0; i < 8 && words[column][i]; i++) {
            if (strcmp(simple, words[column][i]) == 0) {
                return column;
            }
        }
    }
    return COLUMNS;
}

/* Takes the line as headings if it has all five, each once. Returns the first that is missing, NULL for
 * none. *out_named: how many of them the line names. */
static const char *take_headings(table_reader *r, int *out_named) {
    size_t seen[COLUMNS] = {0}, column[COLUMNS] = {0};
    for (size_t i = 0; i < r->csv.count; i++) {
        const int c = column_of(r->csv.fields[i]);
        if (c < COLUMNS && seen[c]++ == 0) {
            column[c] = i;
        }
    }
    *out_named = 0;
    for (int c = 0; c < COLUMNS; c++) {
        *out_named += seen[c] > 0;
    }
    for (int c = 0; c < COLUMNS; c++) {
        if (seen[c] != 1) {
            return column_names[c];
        }
    }
    memcpy(r->column, column, sizeof column);
    r->has_columns = true;
    return NULL;
}

/* Whether no field but the first is a number. */
static bool is_heading(const enc_csv *csv) {
    double number;
    for (size_t i = 1; i < csv->count; i++) {
        if (enc_names_number(csv->fields[i], true, &number)) {
            return false;
        }
    }
    return csv->count > 1;
}

/* Where blanks separate fields, a name may hold blanks: all before the last four fields is the file. */
static void join_name(enc_csv *csv) {
    if (csv->delimiter != ' ' || csv->count <= COLUMNS) {
        return;
    }
    const size_t extra = csv->count - COLUMNS;
    char *last = csv->fields[extra];
    for (char *p = csv->fields[0]; p < last; p++) {
        if (!*p) {
            *p = ' ';
        }
    }
    memmove(csv->fields + 1, csv->fields + 1 + extra, 4 * sizeof *csv->fields);
    csv->count = COLUMNS;
}

static btf_result read_angles(const table_reader *r, enc_angles *out) {
    double *const values[COLUMNS] = {NULL, &out->theta_view, &out->phi_view, &out->theta_light,
                                     &out->phi_light};
    for (int c = 1; c < COLUMNS; c++) {
        const char *field = r->csv.fields[r->column[c]];
        if (!enc_names_number(field, enc_csv_has_decimal_commas(&r->csv), values[c])) {
            return enc_csv_fail(&r->csv, "%s: '%.60s' is not a number of degrees", column_names[c], field);
        }
        if (c % 2 == 1 && !(*values[c] >= 0.0 && *values[c] < 90.0)) {
            return enc_csv_fail(
                &r->csv,
                "%s: %s is not at least 0 and below 90: it is the angle to the surface normal, not "
                "the elevation",
                column_names[c], field);
        }
    }
    return BTF_OK;
}

static const char *base_name(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

/* Whether the folders and name that a table gives end the path of an image. */
static bool is_tail(const char *tail, const char *location, const char *inside) {
    char full[PATH_MAX + 4096];
    const int length = snprintf(full, sizeof full, "%s/%s", location, inside);
    const size_t wanted = strlen(tail);
    if (length < 0 || length >= (int)sizeof full || wanted > (size_t)length) {
        return false;
    }
    const char *at = full + (size_t)length - wanted;
    return strcmp(at, tail) == 0 && (at == full || at[-1] == '/' || *tail == '/');
}

/* Brings a path with Windows's separators or "./" to the form of paths here. */
static void tidy_name(char *name) {
    for (char *p = name; *p; p++) {
        if (*p == '\\') {
            *p = '/';
        }
    }
    while (name[0] == '.' && name[1] == '/') {
        memmove(name, name + 2, strlen(name + 2) + 1);
    }
}

/* Finds the image of a name: *out_index is the count of the source where there is none. */
static btf_result find_image(const table_reader *r, const char *name, size_t *out_index) {
    const enc_source *source = r->source;
    const char *base = base_name(name);
    size_t low = 0, high = source->count, matches = 0;
    *out_index = source->count;
    while (low < high) {
        const size_t middle = (low + high) / 2;
        if (strcmp(r->by_name[middle].base, base) < 0) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    for (; low < source->count && strcmp(r->by_name[low].base, base) == 0; low++) {
        const size_t index = r->by_name[low].index;
        if (strcmp(source->paths[index], name) == 0) {
            *out_index = index;
            return BTF_OK;
        }
        if (!is_tail(name, r->location, source->paths[index]) &&
            !is_tail(name, r->given, source->paths[index])) {
            continue;
        }
        if (matches++ > 0) {
            return enc_csv_fail(&r->csv, "'%.100s' is the name of several images: %.100s, %.100s", name,
                                source->paths[*out_index], source->paths[index]);
        }
        *out_index = index;
    }
    return BTF_OK;
}

static btf_result take_row(table_reader *r) {
    enc_angles angles;
    size_t index;
    char *name = r->csv.fields[r->column[0]];
    btf_result result = read_angles(r, &angles);
    if (result != BTF_OK) {
        return result;
    }
    if (!name[0]) {
        return enc_csv_fail(&r->csv, "the file is empty");
    }
    tidy_name(name);
    result = find_image(r, name, &index);
    if (result != BTF_OK) {
        return result;
    }
    if (index == r->source->count) {
        if (r->n_absent++ == 0) {
            r->first_absent = r->csv.text.number;
            snprintf(r->absent, sizeof r->absent, "%s", name);
        }
        return BTF_OK;
    }
    if (r->table->lines[index] > 0) {
        return enc_csv_fail(&r->csv, "'%.200s' is listed a second time (first in line %zu)", name,
                            r->table->lines[index]);
    }
    r->table->lines[index] = r->csv.text.number;
    r->table->angles[index] = angles;
    r->n_found++;
    return BTF_OK;
}

/* Takes a line of the table. A comment counts as headings where only comments came before it and it names
 * most of the columns. */
static btf_result take_line(table_reader *r, bool is_first) {
    if (r->csv.is_comment && !is_first) {
        return BTF_OK;
    }
    if (is_first && (r->csv.is_comment || is_heading(&r->csv))) {
        int named;
        const char *missing = take_headings(r, &named);
        if (!missing || (r->csv.is_comment && (named < 3 || r->csv.count < COLUMNS))) {
            return BTF_OK;
        }
        return enc_csv_fail(&r->csv,
                            "the headings name no column %s, or name it twice: expected file, theta_v, "
                            "phi_v, theta_l, phi_l, in degrees",
                            missing);
    }
    if (!r->has_columns) {
        join_name(&r->csv);
    }
    for (int c = 0; c < COLUMNS; c++) {
        if (r->column[c] >= r->csv.count || (!r->has_columns && r->csv.count != COLUMNS)) {
            return enc_csv_fail(&r->csv, "%zu fields, expected file, theta_v, phi_v, theta_l, phi_l",
                                r->csv.count);
        }
    }
    return take_row(r);
}

static btf_result read_rows(table_reader *r) {
    bool more = true, is_first = true;
    for (int c = 0; c < COLUMNS; c++) {
        r->column[c] = (size_t)c;
    }
    for (;;) {
        btf_result result = enc_csv_next(&r->csv, &more);
        if (result != BTF_OK || !more) {
            return result;
        }
        result = take_line(r, is_first);
        if (result != BTF_OK) {
            return result;
        }
        is_first = is_first && r->csv.is_comment && !r->has_columns;
    }
}

static int by_base_name(const void *a, const void *b) {
    const named_path *x = a, *y = b;
    const int order = strcmp(x->base, y->base);
    return order ? order : (x->index > y->index) - (x->index < y->index);
}

static void sort_names(table_reader *r) {
    for (size_t i = 0; i < r->source->count; i++) {
        r->by_name[i] = (named_path){base_name(r->source->paths[i]), i};
    }
    qsort(r->by_name, r->source->count, sizeof *r->by_name, by_base_name);
}

/* "folder/SET.tar.gz" to "folder/SET". */
static void drop_ending(char *path) {
    static const char *const endings[] = {".tar.gz", ".tar.xz", ".tar.bz2", ".tar.zst",
                                          ".tgz",    ".zip",    ".tar",     ".7z"};
    const size_t length = strlen(path);
    for (size_t i = 0; i < sizeof endings / sizeof *endings; i++) {
        const size_t end = strlen(endings[i]);
        if (length > end && strcasecmp(path + length - end, endings[i]) == 0) {
            path[length - end] = '\0';
            return;
        }
    }
}

static void settle_location(table_reader *r) {
    const char *given = r->source->location;
    char folder[PATH_MAX] = "";
    if (!realpath(given, r->location)) {
        snprintf(r->location, sizeof r->location, "%s", given);
    }
    if (given[0] != '/' && getcwd(folder, sizeof folder)) {
        snprintf(r->given, sizeof r->given, "%.*s/%s", (int)(sizeof r->given / 2), folder, given);
    } else {
        snprintf(r->given, sizeof r->given, "%s", given);
    }
    for (size_t n = strlen(r->given); n > 1 && r->given[n - 1] == '/';) {
        r->given[--n] = '\0';
    }
    drop_ending(r->location);
    drop_ending(r->given);
}

static btf_result judge(const table_reader *r) {
    const enc_context *context = r->csv.context;
    const enc_source *source = r->source;
    if (r->n_found == 0 && r->n_absent > 0) {
        return enc_fail(context, BTF_ERROR_BAD_FILE,
                        "%s: none of its %zu files is among the %zu images of %s: line %zu: '%s'",
                        r->csv.path, r->n_absent, source->count, source->location, r->first_absent,
                        r->absent);
    }
    if (r->n_found == 0) {
        return enc_fail(context, BTF_ERROR_BAD_FILE, "%s: the table names no file", r->csv.path);
    }
    if (r->n_absent > 0) {
        enc_log(context, BTF_LOG_WARNING,
                "%s: %zu files are not among the images of %s: first is line %zu: '%s'", r->csv.path,
                r->n_absent, source->location, r->first_absent, r->absent);
    }
    if (r->n_found < source->count) {
        size_t first = 0;
        while (r->table->lines[first] > 0) {
            first++;
        }
        enc_log(context, BTF_LOG_WARNING, "%s: %zu images are left out, %s does not name them: first is %s",
                source->location, source->count - r->n_found, r->csv.path, source->paths[first]);
    }
    return BTF_OK;
}

btf_result enc_names_table_read(const enc_context *context, const char *path, const enc_source *source,
                                bool may_miss_all, enc_names_table **out_table) {
    table_reader r = {.source = source, .table = calloc(1, sizeof *r.table)};
    *out_table = NULL;
    btf_result result = enc_csv_open(context, path, &r.csv);
    if (result == BTF_OK && r.table) {
        r.table->angles = malloc((source->count + 1) * sizeof *r.table->angles);
        r.table->lines = calloc(source->count + 1, sizeof *r.table->lines);
        r.by_name = malloc((source->count + 1) * sizeof *r.by_name);
    }
    if (result == BTF_OK && !(r.table && r.table->angles && r.table->lines && r.by_name)) {
        result = BTF_ERROR_MEMORY;
    }
    if (result == BTF_OK) {
        settle_location(&r);
        sort_names(&r);
        result = read_rows(&r);
    }
    if (result == BTF_OK && may_miss_all && r.n_found == 0 && r.n_absent > 0) {
        enc_log(context, BTF_LOG_WARNING,
                "%s: none of its %zu files is among the %zu images of %s, which are read by their names: line "
                "%zu: '%s'",
                path, r.n_absent, source->count, source->location, r.first_absent, r.absent);
    } else if (result == BTF_OK) {
        result = judge(&r);
    }
    if (result == BTF_OK) {
        r.table->n_found = r.n_found;
    }
    enc_csv_close(&r.csv);
    free(r.by_name);
    if (result != BTF_OK) {
        enc_names_table_destroy(&r.table);
    }
    *out_table = r.table;
    return result;
}

void enc_names_table_destroy(enc_names_table **table) {
    if (!table || !*table) {
        return;
    }
    free((*table)->angles);
    free((*table)->lines);
    free(*table);
    *table = NULL;
}

const enc_angles *enc_names_table_angles(const enc_names_table *table, size_t index) {
    return table->lines[index] > 0 ? &table->angles[index] : NULL;
}

size_t enc_names_table_count(const enc_names_table *table) {
    return table->n_found;
}
