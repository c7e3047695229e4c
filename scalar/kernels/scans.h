/* Scans of any length to triangular factors of three rows. */

#pragma once

#include "vectors.h"

#define LEAST_INCIDENCE 0.05 /* |n . e|, as in scalar/sensors/profile.py */
#define RANK_TOLERANCE 1e-13 /* of a column's own norm, as in scalar/sensors/compression.py */

static ALWAYS void orthogonalised(double *column, const double *other, int64_t n, double *sum) {
    double along = dot(other, column, n);
    *sum += along;
    for (int64_t i = 0; i < n; i++) column[i] -= along * other[i];
}

static ALWAYS double normalised(double *column, double size, int64_t n) {
    double norm = sqrt(dot(column, column, n));
    if (!(norm > RANK_TOLERANCE * size)) {
        memset(column, 0, (size_t)n * sizeof(double));
        return 0.0;
    }
    double scale = 1.0 / norm;
    for (int64_t i = 0; i < n; i++) column[i] *= scale;
    return norm;
}

/* The triangular factors R (N, 3, 3) of w [1, x, z], two sweeps of modified Gram-Schmidt.

contact (N, 3) or NULL: with it, w = 1 / (sigma |n . e|), e the ray, or z where along_z; without it, w = 1. */
WIDE int compress(int64_t N, const double *points, const int64_t *starts, const double *contact, int along_z, double sigma, double *R) {
    int64_t most = 0;
    for (int64_t s = 0; s < N; s++)
        if (starts[s + 1] - starts[s] > most) most = starts[s + 1] - starts[s];
    double *columns = malloc((size_t)(3 * most + 1) * sizeof(double));
    if (!columns) return -1;
    double *one = columns, *x = columns + most, *z = columns + 2 * most;
    for (int64_t s = 0; s < N; s++, R += 9) {
        int64_t M = starts[s + 1] - starts[s];
        const double *p = points + 2 * starts[s];
        if (contact) {
            double cx = contact[3 * s + 1], cz = contact[3 * s + 2];
            if (along_z) {
                double slant = fabs(cz) > LEAST_INCIDENCE ? fabs(cz) : LEAST_INCIDENCE;
                for (int64_t i = 0; i < M; i++) one[i] = 1.0 / (sigma * slant);
            } else
                for (int64_t i = 0; i < M; i++) {
                    double u = p[2 * i], v = p[2 * i + 1], reach = sqrt(u * u + v * v);
                    reach = reach > 1e-12 ? reach : 1e-12;
                    double slant = fabs(cx * u + cz * v) / reach;
                    slant = slant > LEAST_INCIDENCE ? slant : LEAST_INCIDENCE;
                    one[i] = 1.0 / (sigma * slant);
                }
        } else
            for (int64_t i = 0; i < M; i++) one[i] = 1.0;
        for (int64_t i = 0; i < M; i++) x[i] = one[i] * p[2 * i], z[i] = one[i] * p[2 * i + 1];
        double sizes[3] = {sqrt(dot(one, one, M)), sqrt(dot(x, x, M)), sqrt(dot(z, z, M))};
        memset(R, 0, 9 * sizeof(double));
        R[0] = normalised(one, sizes[0], M);
        for (int sweep = 0; sweep < 2; sweep++) orthogonalised(x, one, M, R + 1);
        R[4] = normalised(x, sizes[1], M);
        for (int sweep = 0; sweep < 2; sweep++) {
            orthogonalised(z, one, M, R + 2);
            orthogonalised(z, x, M, R + 5);
        }
        R[8] = normalised(z, sizes[2], M);
    }
    free(columns);
    return 0;
}
