/* Restricted likelihood of correlated heights about the lines of scans. */

#pragma once

#include "vectors.h"

/* For S scans of m points, of unit variance and correlated, the sum of all log |C| / 2 and log |X' C^-1 X| / 2, and the squares y' P y (S,), P as
`within_scan_noise/restricted_likelihood.py` defines it. pairs (S, m (m - 1) / 2), correlation of points i < j, row by row; bordering (S, 3, m), the two
columns X of each line and the heights y; nugget, added to the diagonal. NOT_POSITIVE where a correlation is not, NO_MEMORY without memory.

Rows are eliminated from all rows below, so that the inner loops run along rows: U (m, m + 3) becomes L' and L^-1 [X y]. */
WIDE int restricted_likelihood(int64_t S, int64_t m, const double *pairs, const double *bordering, double nugget, double *determinants,
                               double *squares) {
    int64_t n = m + 3, status = 0;
    double *U = malloc((size_t)(m * n + 1) * sizeof(double));
    if (!U) return NO_MEMORY;
    *determinants = 0.0;
    for (int64_t s = 0; s < S && !status; s++, bordering += 3 * m) {
        for (int64_t i = 0; i < m; i++) {
            double *row = U + i * n;
            row[i] = 1.0 + nugget;
            for (int64_t j = i + 1; j < m; j++) row[j] = *pairs++;
            for (int64_t b = 0; b < 3; b++) row[m + b] = bordering[b * m + i];
        }
        double G[6] = {0};
        for (int64_t k = 0; k < m && !status; k++) {
            double *row = U + k * n, pivot = row[k];
            if (!(pivot > 0.0)) status = NOT_POSITIVE;
            *determinants += 0.5 * log(pivot);
            double factor = 1.0 / sqrt(pivot);
            for (int64_t j = k; j < n; j++) row[j] *= factor;
            for (int64_t i = k + 1; i < m; i++) {
                double *below = U + i * n, times = row[i];
                for (int64_t j = i; j < n; j++) below[j] -= times * row[j];
            }
            const double *z = row + m;
            G[0] += z[0] * z[0], G[1] += z[0] * z[1], G[2] += z[0] * z[2], G[3] += z[1] * z[1], G[4] += z[1] * z[2], G[5] += z[2] * z[2];
        }
        double shift = sqrt(G[0]), both = G[1] / shift, turn = sqrt(G[3] - both * both), along = G[2] / shift, across = (G[4] - both * along) / turn;
        *determinants += log(shift) + log(turn);
        squares[s] = G[5] - along * along - across * across;
    }
    free(U);
    return (int)status;
}
