/* The small linear algebra and the matrix product.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/math/gemm.h"
#include "encoder/math/linear.h"
#include "encoder/math/symmetric.h"
#include "tests/support/test.h"

static uint64_t state = 7;

/* Uniform in -1 .. 1 (xorshift64*, Vigna 2016). */
static double uniform(void) {
    state ^= state >> 12;
    state ^= state << 25;
    state ^= state >> 27;
    return (double)((state * 2685821657736338717u) >> 11) * 0x1p-52 - 1.0;
}

enum { N = 37 };

/* a = b^T b + 0.1 I. */
static void positive_definite(double *a) {
    static double b[N * N];
    for (int i = 0; i < N * N; i++) {
        b[i] = uniform();
    }
    for (int i = 0; i < N; i++) {
        for (int j = 0; j < N; j++) {
            a[i * N + j] = i == j ? 0.1 : 0.0;
            for (int p = 0; p < N; p++) {
                a[i * N + j] += b[p * N + i] * b[p * N + j];
            }
        }
    }
}

TEST(test_solve) {
    static double a[N * N], r[N * N], x[N * 3], y[N * 3], single[N];
    positive_definite(a);
    memcpy(r, a, sizeof r);
    for (int i = 0; i < N; i++) {
        for (int j = 0; j < i; j++) {
            r[i * N + j] = NAN; /* below the diagonal nothing may be read */
        }
    }
    for (int i = 0; i < N * 3; i++) {
        x[i] = uniform();
    }
    memset(y, 0, sizeof y);
    for (int i = 0; i < N; i++) {
        for (int j = 0; j < N; j++) {
            for (int c = 0; c < 3; c++) {
                y[i * 3 + c] += a[i * N + j] * x[j * 3 + c];
            }
        }
    }
    assert_true(enc_cholesky(N, r));
    for (int i = 0; i < N; i++) {
        single[i] = y[i * 3 + 1];
    }
    enc_lower_solve(N, r, y, 3);
    enc_upper_solve(N, r, y, 3);
    enc_lower_solve(N, r, single, 1);
    enc_upper_solve(N, r, single, 1);
    for (int i = 0; i < N; i++) {
        assert_true(fabs(single[i] - x[i * 3 + 1]) < 1e-9);
        for (int c = 0; c < 3; c++) {
            assert_true(fabs(y[i * 3 + c] - x[i * 3 + c]) < 1e-9);
        }
    }
    memset(r, 0, sizeof r);
    assert_false(enc_cholesky(N, r));
}

TEST(test_orthonormal_rows) {
    enum { K = 9, ROW = 50 };
    static float v[K * ROW], basis[K * ROW], lower[K * K];
    for (int i = 0; i < K * ROW; i++) {
        v[i] = (float)uniform();
    }
    for (int p = 0; p < ROW; p++) { /* row 4 depends on row 0 */
        v[4 * ROW + p] = -2.0f * v[p];
    }
    assert_true(enc_orthonormal_rows(K, ROW, v, basis, lower));
    for (int i = 0; i < K; i++) {
        for (int j = 0; j < K; j++) {
            double dot = 0.0;
            for (int p = 0; p < ROW; p++) {
                dot += (double)basis[i * ROW + p] * basis[j * ROW + p];
            }
            assert_true(fabs(dot - (i == j && i != 4)) < 1e-5);
            if (j > i) {
                assert_true(lower[i * K + j] == 0.0f);
            }
        }
        for (int p = 0; p < ROW; p++) {
            double sum = 0.0;
            for (int j = 0; j < K; j++) {
                sum += (double)lower[i * K + j] * basis[j * ROW + p];
            }
            assert_true(fabs(sum - v[i * ROW + p]) < 1e-5);
        }
    }
}

TEST(test_eigen) {
    static double a[N * N], work[N * N], values[N], vectors[N * N];
    positive_definite(a);
    memcpy(work, a, sizeof work);
    enc_eigen(N, work, values, vectors);
    for (int i = 0; i < N; i++) {
        assert_true(i == 0 || values[i] <= values[i - 1]);
        for (int j = 0; j < N; j++) {
            double sum = 0.0;
            for (int p = 0; p < N; p++) {
                sum += a[j * N + p] * vectors[i * N + p];
            }
            assert_true(fabs(sum - values[i] * vectors[i * N + j]) < 1e-9);
        }
    }
}

/* For all sizes: a v = x v, with orthonormal v and falling x, also where eigenvalues are equal or 0. */
TEST(test_eigen_symmetric) {
    enum { MOST = 70 };
    static double a[MOST * MOST], v[MOST * MOST], values[MOST];
    for (int n = 1; n <= MOST; n += 23) {
        for (int kind = 0; kind < 3; kind++) { /* general, of rank 2, a multiple of the identity */
            for (int i = 0; i < n; i++) {
                for (int j = 0; j <= i; j++) {
                    const double x = kind == 0   ? uniform()
                                     : kind == 1 ? cos(i) * cos(j) + 2.0 * sin(i) * sin(j)
                                                 : 3.0 * (i == j);
                    a[i * n + j] = a[j * n + i] = x;
                }
            }
            memcpy(v, a, sizeof v);
            assert_true(enc_eigen_symmetric((size_t)n, v, values));
            for (int i = 0; i < n; i++) {
                assert_true(i == 0 || values[i] <= values[i - 1]);
                for (int j = 0; j < n; j++) {
                    double product = 0.0, dot = 0.0;
                    for (int p = 0; p < n; p++) {
                        product += a[j * n + p] * v[i * n + p];
                        dot += v[i * n + p] * v[j * n + p];
                    }
                    assert_true(fabs(product - values[i] * v[i * n + j]) < 1e-11 * n);
                    assert_true(fabs(dot - (i == j)) < 1e-12 * n);
                }
            }
        }
    }
    for (int i = 0; i < 25; i++) {
        a[i] = NAN;
    }
    assert_true(!enc_eigen_symmetric(5, a, values));
}

TEST(test_gram_rows) {
    enum { MOST = 11, LENGTH = 2503 };
    static float x[MOST * LENGTH];
    static double one[MOST * MOST], four[MOST * MOST];
    for (int i = 0; i < MOST * LENGTH; i++) {
        x[i] = (float)uniform() + (i / LENGTH == 3 ? 1e4f : 0.0f);
    }
    for (size_t n = 1; n <= MOST; n++) {
        for (size_t length = n; length <= LENGTH; length += 1248) {
            enc_gram_rows(1, n, length, x, one);
            enc_gram_rows(4, n, length, x, four);
            assert_memory_equal(one, four, n * n * sizeof *one);
            for (size_t i = 0; i < n * n; i++) {
                double sum = 0.0;
                for (size_t p = 0; p < length; p++) {
                    sum += (double)x[i / n * length + p] * x[i % n * length + p];
                }
                assert_true(fabs(one[i] - sum) <= 1e-12 * fabs(sum) + 1e-8);
            }
        }
    }
}

/* The product of packed operands against plain sums, in both packings and for sizes that no tile divides. */
TEST(test_product) {
    const size_t sizes[][3] = {{1, 1, 1}, {12, 32, 8}, {13, 33, 5}, {29, 70, 243}, {5, 100, 1}};
    for (size_t t = 0; t < sizeof sizes / sizeof *sizes; t++) {
        const size_t m = sizes[t][0], n = sizes[t][1], k = sizes[t][2];
        float *a = malloc(m * k * sizeof *a), *b = malloc(k * n * sizeof *b),
              *out = malloc(m * n * sizeof *out);
        float *left = enc_gemm_alloc(enc_gemm_panels(m, ENC_GEMM_M) * ENC_GEMM_M * k);
        float *right = enc_gemm_alloc(enc_gemm_panels(n, ENC_GEMM_N) * ENC_GEMM_N * k);
        assert_true(a && b && out && left && right);
        for (size_t i = 0; i < m * k; i++) {
            a[i] = (float)uniform();
        }
        for (size_t i = 0; i < k * n; i++) {
            b[i] = (float)uniform();
        }
        enc_gemm_pack_rows(m, k, a, k, ENC_GEMM_M, left);
        enc_gemm_pack_columns(n, k, b, n, ENC_GEMM_N, right);
        enc_gemm_multiply(enc_gemm_select(), m, n, k, left, right, out, n, 0);
        enc_gemm_multiply(enc_gemm_select(), m, n, k, left, right, out, n, 1);
        for (size_t i = 0; i < m; i++) {
            for (size_t j = 0; j < n; j++) {
                double sum = 0.0;
                for (size_t p = 0; p < k; p++) {
                    sum += (double)a[i * k + p] * b[p * n + j];
                }
                assert_true(fabs(out[i * n + j] - 2.0 * sum) < 1e-4);
            }
        }
        free(a);
        free(b);
        free(out);
        free(left);
        free(right);
    }
}

RUN_TESTS(NULL, NULL)
