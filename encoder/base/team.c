/* Ranks that encode together (see team.h).
 *
 * SPDX-License-Identifier: MIT
 */
#include "team.h"

#include "decoder/toolkit/progress.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_STAGES = 32, HELD_BYTES = 4096 };

struct enc_team {
    enc_transport transport;
    btf_log log;
    btf_result failed;     /* what the ranks left by */
    char held[HELD_BYTES]; /* errors of a rank other than 0, a line each */
    size_t held_length;
    enc_team_volume volumes[MOST_STAGES];
    char names[MOST_STAGES][32];
    size_t n_volumes;
    enc_team_volume *volume; /* of the stage at hand */
    size_t *bounds;          /* [2][size + 1] of a transfer, in bytes */
};

static enc_team *team_of(const enc_context *context) {
    return context ? context->team : NULL;
}

static void begin(enc_team *team) {
    team->failed = BTF_OK;
    team->held_length = 0;
    team->n_volumes = 0;
    enc_team_stage(team, "start");
}

enc_team *enc_team_create(const enc_transport *transport) {
    enc_team *team = calloc(1, sizeof *team);
    size_t *bounds = calloc(2 * ((size_t)transport->size + 1), sizeof *bounds);
    if (!team || !bounds) {
        free(team);
        free(bounds);
        return NULL;
    }
    team->transport = *transport;
    team->bounds = bounds;
    begin(team);
    return team;
}

void enc_team_destroy(enc_team **team) {
    if (!team || !*team)
        return;
    free((*team)->bounds);
    free(*team);
    *team = NULL;
}

static void hold(void *user, btf_log_level level, const char *message) {
    enc_team *team = user;
    const size_t length = strlen(message) + 1;
    if (level != BTF_LOG_ERROR || length > HELD_BYTES - team->held_length)
        return;
    memcpy(team->held + team->held_length, message, length);
    team->held_length += length;
}

btf_log enc_team_log(enc_team *team, btf_log log) {
    team->log = log;
    return team->transport.rank == 0 ? log : (btf_log){hold, team};
}

static void show_held(enc_team *team, btf_result result) {
    char text[HELD_BYTES + 32];
    if (team->transport.rank == 0 || !team->log.callback || result == BTF_ERROR_INTERRUPTED)
        return;
    if (team->held_length == 0)
        hold(team, BTF_LOG_ERROR, btf_result_text(result));
    for (const char *line = team->held; line < team->held + team->held_length; line += strlen(line) + 1) {
        snprintf(text, sizeof text, "rank %d: %s", team->transport.rank, line);
        team->log.callback(team->log.user, BTF_LOG_ERROR, text);
    }
}

void enc_team_begin(const enc_context *context) {
    if (team_of(context))
        begin(context->team);
}

int enc_team_rank(const enc_context *context) {
    const enc_team *team = team_of(context);
    return team ? team->transport.rank : 0;
}

int enc_team_size(const enc_context *context) {
    const enc_team *team = team_of(context);
    return team ? team->transport.size : 1;
}

int enc_team_node_ranks(const enc_context *context) {
    const enc_team *team = team_of(context);
    return team ? team->transport.node_ranks : 1;
}

bool enc_team_leads(const enc_context *context) {
    return enc_team_rank(context) == 0;
}

void enc_team_range_of(const enc_context *context, int rank, size_t count, size_t *out_first,
                       size_t *out_end) {
    const size_t size = (size_t)enc_team_size(context), r = (size_t)rank;
    const size_t each = count / size, more = count % size; /* the first `more` ranks have one more */
    *out_first = r * each + (r < more ? r : more);
    *out_end = *out_first + each + (r < more);
}

void enc_team_range(const enc_context *context, size_t count, size_t *out_first, size_t *out_end) {
    enc_team_range_of(context, enc_team_rank(context), count, out_first, out_end);
}

btf_result enc_team_agree(const enc_context *context, btf_result result) {
    enc_team *team = team_of(context);
    if (!team)
        return result;
    if (team->failed != BTF_OK)
        return team->failed;
    if (result == BTF_OK && enc_cancelled(context))
        result = BTF_ERROR_INTERRUPTED;
    const uint64_t rank = (uint64_t)team->transport.rank;
    const double start = progress_clock();
    uint64_t worst = result == BTF_OK ? UINT64_MAX : rank << 8 | (uint64_t)result;
    team->transport.least(team->transport.user, &worst);
    team->volume->waited += progress_clock() - start;
    team->volume->meetings++;
    if (worst == UINT64_MAX)
        return BTF_OK;
    team->failed = (btf_result)(worst & 255);
    if (worst >> 8 == rank)
        show_held(team, team->failed);
    return team->failed;
}

bool enc_team_all(const enc_context *context, bool holds) {
    enc_team *team = team_of(context);
    if (!team)
        return holds;
    if (enc_team_agree(context, BTF_OK) != BTF_OK)
        return false;
    uint64_t least = holds;
    team->transport.least(team->transport.user, &least);
    return least != 0;
}

btf_result enc_team_gather_bounds(const enc_context *context, btf_result result, void *array,
                                  size_t item_bytes, const size_t *bounds) {
    enc_team *team = team_of(context);
    result = enc_team_agree(context, result);
    if (!team || result != BTF_OK)
        return result;
    const int size = team->transport.size, rank = team->transport.rank;
    for (int r = 0; r <= size; r++)
        team->bounds[r] = bounds[r] * item_bytes;
    const size_t mine = team->bounds[rank + 1] - team->bounds[rank];
    const double start = progress_clock();
    team->transport.gather(team->transport.user, array, team->bounds);
    team->volume->moved += progress_clock() - start;
    team->volume->sent += mine;
    team->volume->received += team->bounds[size] - team->bounds[0] - mine;
    return BTF_OK;
}

btf_result enc_team_gather(const enc_context *context, btf_result result, void *array, size_t item_bytes,
                           size_t count) {
    enc_team *team = team_of(context);
    if (!team)
        return result;
    size_t *bounds = team->bounds + team->transport.size + 1, first;
    bounds[0] = 0;
    for (int r = 0; r < team->transport.size; r++)
        enc_team_range_of(context, r, count, &first, &bounds[r + 1]);
    return enc_team_gather_bounds(context, result, array, item_bytes, bounds);
}

btf_result enc_team_exchange(const enc_context *context, btf_result result, const float *send,
                             const size_t *send_bounds, float *receive, const size_t *receive_bounds) {
    enc_team *team = team_of(context);
    result = enc_team_agree(context, result);
    if (!team || result != BTF_OK)
        return result;
    const int size = team->transport.size, rank = team->transport.rank;
    size_t *from = team->bounds, *to = from + size + 1;
    for (int r = 0; r <= size; r++) {
        from[r] = send_bounds[r] * sizeof(float);
        to[r] = receive_bounds[r] * sizeof(float);
    }
    const double start = progress_clock();
    team->transport.exchange(team->transport.user, send, from, receive, to);
    team->volume->moved += progress_clock() - start;
    team->volume->sent += from[size] - from[0] - (from[rank + 1] - from[rank]);
    team->volume->received += to[size] - to[0] - (to[rank + 1] - to[rank]);
    return BTF_OK;
}

btf_result enc_team_sum(const enc_context *context, btf_result result, uint64_t *values, size_t count) {
    enc_team *team = team_of(context);
    result = enc_team_agree(context, result);
    if (!team || result != BTF_OK)
        return result;
    const double start = progress_clock();
    team->transport.sum(team->transport.user, values, count);
    team->volume->moved += progress_clock() - start;
    team->volume->sent += count * sizeof *values;
    team->volume->received += count * sizeof *values;
    return BTF_OK;
}

btf_result enc_team_broadcast(const enc_context *context, btf_result result, void *bytes, size_t size) {
    enc_team *team = team_of(context);
    result = enc_team_agree(context, result);
    if (!team || result != BTF_OK || size == 0)
        return result;
    const double start = progress_clock();
    team->transport.broadcast(team->transport.user, bytes, size);
    team->volume->moved += progress_clock() - start;
    *(team->transport.rank == 0 ? &team->volume->sent : &team->volume->received) += size;
    return BTF_OK;
}

void enc_team_stage(enc_team *team, const char *stage) {
    size_t i = 0;
    while (i < team->n_volumes && strcmp(team->names[i], stage) != 0)
        i++;
    if (i == MOST_STAGES)
        i--;
    if (i == team->n_volumes) {
        snprintf(team->names[i], sizeof team->names[i], "%s", stage);
        team->volumes[team->n_volumes++] = (enc_team_volume){.stage = team->names[i]};
    }
    team->volume = &team->volumes[i];
}

const enc_team_volume *enc_team_volumes(const enc_context *context, size_t *out_count) {
    const enc_team *team = team_of(context);
    *out_count = team ? team->n_volumes : 0;
    return team ? team->volumes : NULL;
}
