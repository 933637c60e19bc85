/* Writes the truth of a sample as NumPy files.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_SAMPLE_TRUTH_FILES_H
#define OPENBTF_SAMPLE_TRUTH_FILES_H

#include "sample.h"

/* Writes into the folder, which must exist; each file is whole or absent:
 *   position.npy    float32 (views, rows, columns, 3)
 *   shift.npy       float32 (views, rows, columns, 2)
 *   hidden.npy      uint8 (views, rows, columns)
 *   shadow.npy      uint8 (views, lights, rows, columns)
 *   top_shadow.npy  uint8 (lights, rows, columns)
 *   views.npy, lights.npy   float64 (directions, 2): theta, phi in degrees
 *   README.txt      what they mean
 * with the meaning of sample_truth's fields. Errors: BTF_ERROR_IO, BTF_ERROR_MEMORY (named on the log). */
btf_result truth_files_write(const sample_scene *scene, const sample_truth *truth, const char *folder);

#endif
