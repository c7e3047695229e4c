/* Contact vectors of scans with planes, and what of the scans no line explains. */

#pragma once

#include "vectors.h"

/* c (N, 3): (n.o - d, n.X, n.Z), o, X and Z the origin and axes of T (N, 4, 4), n and d those of plane index (N,)
of normals (K, 3), distances (K,). */
void contacts(int64_t N, const double *T, const double *normals, const double *distances, const int64_t *index, double *c) {
    for (int64_t i = 0; i < N; i++, T += 16, c += 3) {
        const double *n = normals + 3 * index[i];
        const int carriers[3] = {3, 0, 2};
        for (int k = 0; k < 3; k++) c[k] = n[0] * T[carriers[k]] + n[1] * T[4 + carriers[k]] + n[2] * T[8 + carriers[k]];
        c[0] -= distances[index[i]];
    }
}

/* Two unit vectors (K, 2, 3) perpendicular to each unit normal (K, 3) and to each other, as `tangent_basis` of scalar/geometry/planes.py. */
void tangents(int64_t K, const double *normals, double *out) {
    for (int64_t k = 0; k < K; k++, normals += 3, out += 6) {
        double axis[3] = {0};
        int least = fabs(normals[1]) < fabs(normals[0]);
        axis[fabs(normals[2]) < fabs(normals[least]) ? 2 : least] = 1.0;
        cross3(normals, axis, out);
        double size = sqrt(dot3(out, out));
        for (int r = 0; r < 3; r++) out[r] /= size;
        cross3(normals, out, out + 3);
    }
}

/* y loses its part along x; a vector without length takes nothing. */
static void without(double *y, const double *x, int64_t m) {
    double squares = 0.0, product = 0.0;
    for (int64_t i = 0; i < m; i++) squares += x[i] * x[i], product += y[i] * x[i];
    double along = product / (squares > 0.0 ? squares : 1.0);
    for (int64_t i = 0; i < m; i++) y[i] -= x[i] * along;
}

/* For each scan the square of f = R full (of R c where full is NULL) without its parts along a shift R (1, 0, 0)
and a turn R (0, -c_z, c_x) of the line.

R (N, m, k), of k functions of the points, the first three those of a flat plane; c (N, 3); full (N, k); out (N,). */
int scatter(int64_t N, int64_t m, int64_t k, const double *R, const double *c, const double *full, double *out) {
    double *f = malloc((size_t)(3 * m + 1) * sizeof(double));
    if (!f) return NO_MEMORY;
    double *shift = f + m, *turn = shift + m;
    for (int64_t s = 0; s < N; s++, R += m * k, c += 3) {
        const double *by = full ? full + s * k : c;
        for (int64_t i = 0; i < m; i++) {
            const double *row = R + i * k;
            f[i] = 0.0, shift[i] = row[0], turn[i] = row[2] * c[1] - row[1] * c[2];
            for (int64_t j = 0; j < (full ? k : 3); j++) f[i] += row[j] * by[j];
        }
        for (int sweep = 0; sweep < 2; sweep++) without(f, shift, m), without(turn, shift, m), without(f, turn, m);
        out[s] = 0.0;
        for (int64_t i = 0; i < m; i++) out[s] += f[i] * f[i];
    }
    free(f);
    return 0;
}

/* The sum of squared distances of the points (P, 2) of each scan from its line of least squares, out (N,). */
WIDE void off_lines(int64_t N, const double *points, const int64_t *starts, double *out) {
    for (int64_t s = 0; s < N; s++) {
        const double *p = points + 2 * starts[s];
        int64_t M = starts[s + 1] - starts[s];
        double x = 0.0, z = 0.0, xx = 0.0, xz = 0.0, zz = 0.0;
        for (int64_t i = 0; i < M; i++) x += p[2 * i], z += p[2 * i + 1];
        x /= (double)M, z /= (double)M;
        for (int64_t i = 0; i < M; i++) {
            double u = p[2 * i] - x, v = p[2 * i + 1] - z;
            xx += u * u, xz += u * v, zz += v * v;
        }
        double angle = 0.5 * atan2(2.0 * xz, xx - zz), ca = cos(angle), sa = sin(angle);
        out[s] = 0.0;
        for (int64_t i = 0; i < M; i++) {
            double off = (p[2 * i + 1] - z) * ca - (p[2 * i] - x) * sa;
            out[s] += off * off;
        }
    }
}
