/* Compression of scans of any length to triangular factors of three rows. */

#pragma once

#include "vectors.h"

#define LEAST_INCIDENCE 0.05 /* |n . e|, as in scalar/sensors/profile.py */
#define RANK_TOLERANCE 1e-13 /* of a column's own norm, as in scalar/sensors/compression.py */

/* A column (n,) loses its part along another of unit length, which is added to *sum. */
static ALWAYS void orthogonalised(double *column, const double *other, int64_t n, double *sum) {
    double along = dot(other, column, n);
    *sum += along;
    for (int64_t i = 0; i < n; i++) column[i] -= along * other[i];
}

/* A column (n,) gets unit length; its norm is returned. Where that is lost in the rounding of `size`, the column becomes zero, and 0 is returned. */
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

/* The length of the ray to a point [m], at least so long that one may divide by it. */
static ALWAYS double reach_of(double x, double z) {
    double reach = sqrt(x * x + z * z);
    return reach > 1e-12 ? reach : 1e-12;
}

/* The weights 1 / (sigma |n . e|) of M points (M, 2), c = (n.o - d, n.X, n.Z), e the ray, or z where along_z. */
static ALWAYS void weights(const double *p, int64_t M, const double *c, int along_z, double sigma, double *weight) {
    for (int64_t i = 0; i < M; i++) {
        double x = p[2 * i], z = p[2 * i + 1];
        double slant = along_z ? fabs(c[2]) : fabs(c[1] * x + c[2] * z) / reach_of(x, z);
        slant = slant > LEAST_INCIDENCE ? slant : LEAST_INCIDENCE;
        weight[i] = 1.0 / (sigma * slant);
    }
}

static int64_t most_points(int64_t N, const int64_t *starts) {
    int64_t most = 0;
    for (int64_t s = 0; s < N; s++)
        if (starts[s + 1] - starts[s] > most) most = starts[s + 1] - starts[s];
    return most;
}

/* The triangular factors R (N, k, k) of any k functions of the points, basis (P, k), by two sweeps of modified Gram-Schmidt. */
WIDE int factors(int64_t N, int64_t k, const double *basis, const int64_t *starts, double *R) {
    double *columns = malloc((size_t)(k * most_points(N, starts) + 1) * sizeof(double));
    if (!columns) return NO_MEMORY;
    memset(R, 0, (size_t)(N * k * k) * sizeof(double));
    for (int64_t s = 0; s < N; s++, R += k * k) {
        int64_t M = starts[s + 1] - starts[s];
        for (int64_t i = 0; i < M; i++)
            for (int64_t j = 0; j < k; j++) columns[j * M + i] = basis[(starts[s] + i) * k + j];
        for (int64_t j = 0; j < k; j++) {
            double *column = columns + j * M, size = sqrt(dot(column, column, M));
            for (int sweep = 0; sweep < 2; sweep++)
                for (int64_t i = 0; i < j; i++) orthogonalised(column, columns + i * M, M, R + i * k + j);
            R[j * k + j] = normalised(column, size, M);
        }
    }
    free(columns);
    return 0;
}

/* The triangular factors R (N, 3, 3) of w [1, x, z], two sweeps of modified Gram-Schmidt.

contact (N, 3) or NULL: with it, w = 1 / (sigma |n . e|), e the ray, or z where along_z; without it, w = 1. */
WIDE int compress(int64_t N, const double *points, const int64_t *starts, const double *contact, int along_z, double sigma, double *R) {
    int64_t most = most_points(N, starts);
    double *columns = malloc((size_t)(3 * most + 1) * sizeof(double));
    if (!columns) return NO_MEMORY;
    double *one = columns, *x = columns + most, *z = columns + 2 * most;
    for (int64_t s = 0; s < N; s++, R += 9) {
        int64_t M = starts[s + 1] - starts[s];
        const double *p = points + 2 * starts[s];
        if (contact)
            weights(p, M, contact + 3 * s, along_z, sigma, one);
        else
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

/* The components (N, 3, k) of k functions of the points along 1, t, t^2 of every scan, all weighted, t along its line.

codes (k, 4): a function is (1, u_x or u_z) reach^r x^i z^j, u the direction in which the scanner errs; its code is (along, r, i, j), along 0, 1 or 2
for 1, u_x or u_z. */
WIDE int profiles(int64_t N, const double *points, const int64_t *starts, const double *contact, int along_z, double sigma,
                  int64_t k, const int64_t *codes, double *found) {
    int64_t most = most_points(N, starts);
    double *scratch = malloc((size_t)(9 * most + 1) * sizeof(double));
    if (!scratch) return NO_MEMORY;
    double *q[3] = {scratch, scratch + most, scratch + 2 * most};
    double *weight = scratch + 3 * most, *reach = scratch + 4 * most, *t = scratch + 5 * most, *value = scratch + 6 * most;
    double *u[2] = {scratch + 7 * most, scratch + 8 * most};
    for (int64_t s = 0; s < N; s++) {
        int64_t M = starts[s + 1] - starts[s];
        const double *p = points + 2 * starts[s], *c = contact + 3 * s;
        weights(p, M, c, along_z, sigma, weight);
        double mean = 0.0, unused = 0.0;
        for (int64_t i = 0; i < M; i++) {
            reach[i] = along_z ? p[2 * i + 1] : reach_of(p[2 * i], p[2 * i + 1]);
            u[0][i] = along_z ? 0.0 : p[2 * i] / reach[i], u[1][i] = along_z ? 1.0 : p[2 * i + 1] / reach[i];
            t[i] = c[1] * p[2 * i + 1] - c[2] * p[2 * i];
            mean += t[i];
        }
        mean /= (double)M;
        for (int64_t i = 0; i < M; i++) {
            t[i] -= mean;
            q[0][i] = weight[i], q[1][i] = weight[i] * t[i], q[2][i] = weight[i] * (t[i] * t[i]);
        }
        for (int j = 0; j < 3; j++) {
            double size = sqrt(dot(q[j], q[j], M));
            for (int sweep = 0; sweep < 2; sweep++)
                for (int other = 0; other < j; other++) orthogonalised(q[j], q[other], M, &unused);
            normalised(q[j], size, M);
        }
        for (int64_t f = 0; f < k; f++) {
            const int64_t *code = codes + 4 * f;
            memcpy(value, weight, (size_t)M * sizeof(double));
            for (int64_t n = 0; n < code[1]; n++)
                for (int64_t i = 0; i < M; i++) value[i] *= reach[i];
            for (int axis = 0; axis < 2; axis++)
                for (int64_t n = 0; n < code[2 + axis]; n++)
                    for (int64_t i = 0; i < M; i++) value[i] *= p[2 * i + axis];
            if (code[0])
                for (int64_t i = 0; i < M; i++) value[i] *= u[code[0] - 1][i];
            for (int j = 0; j < 3; j++) found[(3 * s + j) * k + f] = dot(q[j], value, M);
        }
    }
    free(scratch);
    return 0;
}
