/* The components of a BTF that a budget holds, and the plan that gives them bits.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_FACTOR_FACTORISE_H
#define OPENBTF_ENCODER_FACTOR_FACTORISE_H

#include "components.h"
#include "encoder/allocation/allocate.h"
#include "encoder/model/trial.h"

/* Finds components and a plan for them within `budget` bytes: with a tolerance of 0 one that fills it, else
 * one that leaves out what is noise and stops where a tenth more bytes gains less than `tolerance` dB
 * (stop.h). Channels whose components turn out too few are searched again for twice as many. A plan of few
 * units is chosen by trial, with `sweeps` as there (choose_plan.h). Stage "factorise". Errors:
 * BTF_ERROR_MEMORY, BTF_ERROR_IO, BTF_ERROR_INTERRUPTED; the caller clears the components then, too. */
btf_result enc_factorise(const enc_factor_matrix *matrix, uint64_t budget, double tolerance, int sweeps,
                         enc_components out_components[ENC_FACTOR_CHANNELS], enc_factor_plan *out_plan,
                         enc_unspent *out_unspent);

/* The bytes that each of two candidates may use: those that pay without match; where these leave less than
 * a unit of the budget, the budget. */
uint64_t enc_factorise_equal_bytes(const enc_factor_matrix *matrix, uint64_t budget,
                                   const enc_unspent *unspent);

/* Components of luma and chroma that are looked for first. */
void enc_factorise_first_ranks(size_t texels, size_t columns, uint64_t budget,
                               size_t out_ranks[ENC_FACTOR_CHANNELS]);

/* The number of factors that a budget is expected to hold. */
double enc_factorise_expected(uint64_t budget);

#endif
