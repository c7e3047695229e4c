/* Gains of sets of columns whose coefficients have priors, in units as in gains.h. */

#pragma once

#include "gains.h"

#define SMALL_PIVOT 1e-3  /* of the largest number of its row: with a smaller one, signs of pivots are not trusted */

/* How many eigenvalues of A (s, s) exceed 1: the number of positive pivots of A - I (Sylvester's law of inertia), by M (s, s) and q (s).
Large diagonal elements become 1 first, which changes no sign (congruence), so that no pivot is small because of its unit. Where one still is small
beside its row, the eigenvalues are computed instead; p (s) is overwritten. */
static ALWAYS int64_t above_one(const double *A, int64_t s, double *M, double *p, double *q) {
    int64_t count = 0;
    memcpy(M, A, (size_t)(s * s) * sizeof(double));
    for (int64_t i = 0; i < s; i++) {
        M[i * s + i] -= 1.0;
        p[i] = 1.0 / sqrt(fmax(A[i * s + i], 1.0));
    }
    for (int64_t i = 0; i < s; i++)
        for (int64_t j = 0; j < s; j++) M[i * s + j] *= p[i] * p[j];
    for (int64_t i = 0; i < s; i++) {
        double pivot = M[i * s + i], largest = 0.0;
        for (int64_t j = i + 1; j < s; j++) {
            double size = fabs(M[i * s + j]);
            if (size > largest) largest = size;
        }
        if (!(fabs(pivot) > SMALL_PIVOT * largest)) {
            memcpy(M, A, (size_t)(s * s) * sizeof(double));
            diagonalise(M, p, s, q);
            count = 0;
            for (int64_t k = 0; k < s; k++) count += M[k * s + k] > 1.0;
            return count;
        }
        count += pivot > 0.0;
        for (int64_t j = i + 1; j < s; j++) {
            double factor = M[i * s + j] / pivot;
            for (int64_t k = j; k < s; k++) M[j * s + k] -= factor * M[i * s + k];
        }
    }
    return count;
}

/* For T sets of s columns each, given by the columns' indices (T, s) in gram (e, e) and projection (e): the gain (T), that is the drop of the sum of
squares with the priors' penalty, and how many directions have an eigenvalue above 1 (T). NOT_POSITIVE where a matrix is not. */
WIDE int set_gains(int64_t e, const double *gram, const double *projection, int64_t T, int64_t s, const int64_t *columns, double *gain,
                   int64_t *seen) {
    double *A = malloc((size_t)(2 * s * (s + 1) + 1) * sizeof(double));
    if (!A) return NO_MEMORY;
    double *M = A + s * s, *p = M + s * s, *q = p + s;
    int status = 0;
    for (int64_t t = 0; t < T && !status; t++, columns += s) {
        for (int64_t i = 0; i < s; i++)
            for (int64_t j = 0; j < s; j++) A[i * s + j] = gram[columns[i] * e + columns[j]];
        status = shifted_factor(A, s, 1.0, 0.0, M);
        if (status) break;
        gain[t] = 0.0;
        for (int64_t i = 0; i < s; i++) {
            double sum = projection[columns[i]];
            for (int64_t k = 0; k < i; k++) sum -= M[k * s + i] * p[k];
            p[i] = sum / M[i * s + i];
            gain[t] += p[i] * p[i];
        }
        seen[t] = above_one(A, s, M, p, q);
    }
    free(A);
    return status;
}
