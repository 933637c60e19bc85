/* The journal of a run. See results.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "results.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct entry {
    char table[48];
    bench_row row;
} entry;

struct bench_journal {
    FILE *file;
    char path[4096];
    entry *entries;
    size_t count, resumed;
};

enum { BETWEEN = 10, HELD = BETWEEN + 2 * BENCH_BETWEEN_SETS, FIGURES = HELD + 2 * BENCH_HELD_SETS };

/* The measured figures of a row, in the order of a line. */
static void figures_of(bench_row *row, double *out[FIGURES]) {
    double *const first[] = {&row->x,     &row->core,   &row->core_spread, &row->wall, &row->wall_spread,
                             &row->bytes, &row->memory, &row->linear,      &row->srgb, &row->ssim};
    memcpy(out, first, sizeof first);
    for (int i = 0; i < 2 * BENCH_BETWEEN_SETS; i++) {
        out[BETWEEN + i] = &row->between[i / 2][i % 2];
    }
    for (int i = 0; i < 2 * BENCH_HELD_SETS; i++) {
        out[HELD + i] = &row->held[i / 2][i % 2];
    }
}

static bool keep(bench_journal *journal, const char *table, const bench_row *row) {
    entry *entries = realloc(journal->entries, (journal->count + 1) * sizeof *entries);
    if (!entries) {
        return false;
    }
    journal->entries = entries;
    entries[journal->count] = (entry){.row = *row};
    snprintf(entries[journal->count].table, sizeof entries->table, "%s", table);
    journal->count++;
    return true;
}

static void write_line(FILE *file, const char *table, const bench_row *row) {
    bench_row copy = *row;
    double *figures[FIGURES];
    figures_of(&copy, figures);
    fprintf(file, "%s,%s,%s", table, row->sweep, row->name);
    for (int i = 0; i < FIGURES; i++) {
        fprintf(file, ",%.17g", *figures[i]);
    }
    fprintf(file, ",end\n");
}

/* Copies up to the next comma; returns what follows it, or NULL. */
static const char *field(const char *from, char *to, size_t size) {
    const char *comma = from ? strchr(from, ',') : NULL;
    if (comma) {
        snprintf(to, size, "%.*s", (int)(comma - from), from);
    }
    return comma ? comma + 1 : NULL;
}

static bool read_line(const char *line, char table[48], bench_row *row) {
    char text[64];
    double *figures[FIGURES];
    *row = bench_row_named("", "", NAN);
    figures_of(row, figures);
    line = field(line, table, 48);
    line = field(line, row->sweep, sizeof row->sweep);
    line = field(line, row->name, sizeof row->name);
    for (int i = 0; i < FIGURES && line; i++) {
        line = field(line, text, sizeof text);
        *figures[i] = line ? strtod(text, NULL) : NAN;
    }
    return line && strcmp(line, "end\n") == 0;
}

/* Reads the rows if the file's identity is `identity`; false where it is another run's. */
static bool read_rows(bench_journal *journal, const char *identity) {
    char line[4096], expected[4096], table[48];
    bench_row row;
    bool room = true;
    FILE *file = fopen(journal->path, "r");
    if (!file) {
        return true;
    }
    snprintf(expected, sizeof expected, "# %s\n", identity);
    if (fgets(line, sizeof line, file) && strcmp(line, expected) == 0) {
        while (room && fgets(line, sizeof line, file)) {
            room = !read_line(line, table, &row) || keep(journal, table, &row);
        }
    }
    fclose(file);
    return room;
}

btf_result bench_journal_open(const enc_context *context, const char *directory, const char *identity,
                              bench_journal **out_journal) {
    bench_journal *journal = calloc(1, sizeof *journal);
    *out_journal = journal;
    if (!journal) {
        return enc_fail(context, BTF_ERROR_MEMORY, "bench: out of memory");
    }
    snprintf(journal->path, sizeof journal->path, "%s/journal.csv", directory);
    const bool room = read_rows(journal, identity);
    journal->resumed = journal->count;
    /* the file is written anew, without lines that were cut short and those of another run */
    char fresh[sizeof journal->path + 8];
    snprintf(fresh, sizeof fresh, "%s.new", journal->path);
    journal->file = room ? fopen(fresh, "w") : NULL;
    if (journal->file) {
        fprintf(journal->file, "# %s\n", identity);
        for (size_t i = 0; i < journal->count; i++) {
            write_line(journal->file, journal->entries[i].table, &journal->entries[i].row);
        }
    }
    if (!journal->file || fflush(journal->file) != 0 || rename(fresh, journal->path) != 0) {
        const btf_result result =
            enc_fail(context, room ? BTF_ERROR_IO : BTF_ERROR_MEMORY, "%s: %s", fresh, strerror(errno));
        bench_journal_close(out_journal);
        return result;
    }
    return BTF_OK;
}

bool bench_journal_find(const bench_journal *journal, const char *table, bench_row *row) {
    for (size_t i = 0; i < journal->count; i++) {
        const entry *e = &journal->entries[i];
        if (strcmp(e->table, table) == 0 && strcmp(e->row.sweep, row->sweep) == 0 &&
            strcmp(e->row.name, row->name) == 0) {
            *row = e->row;
            return true;
        }
    }
    return false;
}

btf_result bench_journal_add(const enc_context *context, bench_journal *journal, const char *table,
                             const bench_row *row) {
    write_line(journal->file, table, row);
    if (fflush(journal->file) != 0 || fsync(fileno(journal->file)) != 0) {
        return enc_fail(context, BTF_ERROR_IO, "%s: %s", journal->path, strerror(errno));
    }
    return keep(journal, table, row) ? BTF_OK : enc_fail(context, BTF_ERROR_MEMORY, "bench: out of memory");
}

size_t bench_journal_resumed(const bench_journal *journal) {
    return journal->resumed;
}

void bench_journal_close(bench_journal **journal) {
    if (*journal) {
        if ((*journal)->file) {
            fclose((*journal)->file);
        }
        free((*journal)->entries);
        free(*journal);
        *journal = NULL;
    }
}
