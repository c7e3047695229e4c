/* Eigenvalues of symmetric matrices, and the components of a vector along their eigenvectors, which are not formed themselves. */

#pragma once

#include <float.h>

#include "vectors.h"

#define SWEEPS 40        /* of Jacobi's method at most; usually six suffice */
#define MOST_TURNED 8    /* columns: Jacobi's method, which is exact for small eigenvalues too, is slower for larger matrices */
#define STEPS_EACH 30    /* QR steps for each eigenvalue at most; usually two suffice */

/* A symmetric matrix A (w, w) becomes diagonal, and vectors p (w) are expressed in its eigenvectors (Golub and Van Loan, 8.5). */
static void turn_pairs(double *A, double *p, int64_t w) {
    for (int sweep = 0, turned = 1; turned && sweep < SWEEPS; sweep++) {
        turned = 0;
        for (int64_t i = 0; i < w; i++)
            for (int64_t j = i + 1; j < w; j++) {
                double b = A[i * w + j];
                if (!(b * b > 1e-34 * fabs(A[i * w + i] * A[j * w + j]))) continue;
                double half = (A[j * w + j] - A[i * w + i]) / (2.0 * b);
                double t = copysign(1.0, half) / (fabs(half) + sqrt(1.0 + half * half)), c = 1.0 / sqrt(1.0 + t * t), s = t * c;
                for (int64_t k = 0; k < w; k++) {
                    double x = A[i * w + k], y = A[j * w + k];
                    if (k == i || k == j) continue;
                    A[i * w + k] = A[k * w + i] = c * x - s * y;
                    A[j * w + k] = A[k * w + j] = s * x + c * y;
                }
                A[i * w + i] -= t * b, A[j * w + j] += t * b;
                A[i * w + j] = A[j * w + i] = 0.0;
                double x = p[i], y = p[j];
                p[i] = c * x - s * y, p[j] = s * x + c * y;
                turned = 1;
            }
    }
}

/* A symmetric matrix A (w, w) becomes tridiagonal by reflections, which p (w) follows; q (w) is overwritten (Golub and Van Loan, 8.3.1).
Only the diagonal of A and the numbers right of it are meant to be read afterwards. */
static ALWAYS void make_tridiagonal(double *A, double *p, int64_t w, double *q) {
    for (int64_t k = 0; k + 2 < w; k++) {
        double *v = A + k * w, squares = 0.0, along = 0.0, half = 0.0;
        for (int64_t j = k + 1; j < w; j++) squares += v[j] * v[j];
        double length = -copysign(sqrt(squares), v[k + 1]), first = v[k + 1] - length;
        if (!(first * first > 0.0)) continue; /* the row is zero already */
        double factor = -1.0 / (length * first);
        v[k + 1] = first;
        memset(q, 0, (size_t)w * sizeof(double));
        for (int64_t i = k + 1; i < w; i++) {
            const double *row = A + i * w, size = factor * v[i];
            for (int64_t j = k + 1; j < w; j++) q[j] += size * row[j];
            along += v[i] * p[i];
        }
        for (int64_t j = k + 1; j < w; j++) half += 0.5 * factor * q[j] * v[j];
        for (int64_t j = k + 1; j < w; j++) q[j] -= half * v[j], p[j] -= factor * along * v[j];
        for (int64_t i = k + 1; i < w; i++) {
            double *row = A + i * w, a = v[i], b = q[i];
            for (int64_t j = k + 1; j < w; j++) row[j] -= a * q[j] + b * v[j];
        }
        v[k + 1] = length;
    }
}

/* One QR step with Wilkinson's shift on the rows from `low` to `high` of a tridiagonal matrix, which p follows (the same, 8.3.5). */
static ALWAYS void qr_step(double *A, double *p, int64_t w, int64_t low, int64_t high) {
    double last = A[high * w + high], beside = A[(high - 1) * w + high], half = 0.5 * (A[(high - 1) * w + high - 1] - last);
    double shift = last - beside * beside / (half + copysign(sqrt(half * half + beside * beside), half));
    double x = A[low * w + low] - shift, z = A[low * w + low + 1];
    for (int64_t k = low; k < high; k++) {
        double *row = A + k * w + k, *next = row + w + 1, length = sqrt(x * x + z * z);
        double c = length > 0.0 ? x / length : 1.0, s = length > 0.0 ? z / length : 0.0, a = row[0], b = row[1], d = next[0];
        if (k > low) row[-w] = length;
        row[0] = c * c * a + 2.0 * c * s * b + s * s * d;
        next[0] = s * s * a - 2.0 * c * s * b + c * c * d;
        row[1] = c * s * (d - a) + (c * c - s * s) * b;
        double here = p[k];
        p[k] = c * here + s * p[k + 1], p[k + 1] = c * p[k + 1] - s * here;
        if (k + 1 == high) break;
        x = row[1], z = s * next[1];
        next[1] *= c;
    }
}

/* The diagonal of a symmetric matrix A (w, w) becomes its eigenvalues, and p (w) is expressed in its eigenvectors; q (w) is overwritten, as is the
rest of A. */
static ALWAYS void diagonalise(double *A, double *p, int64_t w, double *q) {
    if (w <= MOST_TURNED) {
        turn_pairs(A, p, w);
        return;
    }
    make_tridiagonal(A, p, w, q);
    int64_t high = w - 1;
    for (int64_t step = 0; high > 0 && step < STEPS_EACH * w; step++) {
        int64_t low = high;
        for (; low > 0; low--) {
            const double *at = A + (low - 1) * w + low - 1;
            if (!(fabs(at[1]) > DBL_EPSILON * (fabs(at[0]) + fabs(at[w + 1])))) break;
        }
        if (low == high)
            high--;
        else
            qr_step(A, p, w, low, high);
    }
}
