/* Writes the parts of a run that the documents show: tables of the headline plots, and the guide on what to choose,
 * with the measured numbers. readme.sh puts them into the documents.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_BENCH_README_H
#define OPENBTF_TESTS_BENCH_README_H

#include "tests/bench/decode/decode_table.h"

/* readme-encode-MATERIAL.md and guide-encode-MATERIAL.md; nothing without the presets fast and medium and
 * the paper. Errors: BTF_ERROR_IO. */
btf_result bench_readme_encode(const bench_run *run, const bench_table *table);
/* readme-between-MATERIAL.md, the rows of a table without its head, which also go into the summary. Errors:
 * BTF_ERROR_IO. */
btf_result bench_readme_between(const bench_run *run, const bench_table *table);
/* readme-decode-MATERIAL.md and guide-decode-MATERIAL.md, of the first device. Errors: BTF_ERROR_IO. */
btf_result bench_readme_decode(const bench_run *run, const decode_table *table);

#endif
