/* Frames of a chain of modified Denavit-Hartenberg parameters. */

#pragma once

#include "vectors.h"

/* A joint's parameters a, d [m] and theta [rad], and the cosines (c) and sines (s) of alpha (a), beta (b) and theta (t). */
typedef struct {
    double ca, sa, cb, sb, a, d, theta, ct, st;
} Link;

/* Joint i of n, from geometry (5, n): rows a, alpha, d, theta, beta. */
static void link_of(const double *geometry, int64_t n, int64_t i, Link *link) {
    link->a = geometry[i];
    link->ca = cos(geometry[n + i]), link->sa = sin(geometry[n + i]);
    link->d = geometry[2 * n + i], link->theta = geometry[3 * n + i];
    link->cb = cos(geometry[4 * n + i]), link->sb = sin(geometry[4 * n + i]);
    link->ct = cos(link->theta), link->st = sin(link->theta);
}

/* L (3, 4), the first three rows of Rx(alpha) Tx(a) Ry(beta) Rz(q + theta) Tz(d); c and s are of q + theta. */
static ALWAYS void link_matrix(const Link *k, double c, double s, double *L) {
    L[0] = k->cb * c, L[1] = -k->cb * s, L[2] = k->sb;
    L[4] = k->sa * k->sb * c + k->ca * s, L[5] = k->ca * c - k->sa * k->sb * s, L[6] = -k->sa * k->cb;
    L[8] = k->sa * s - k->ca * k->sb * c, L[9] = k->ca * k->sb * s + k->sa * c, L[10] = k->ca * k->cb;
    L[3] = L[2] * k->d + k->a, L[7] = L[6] * k->d, L[11] = L[10] * k->d;
}

/* R (3 x 3) and o (3) become those of the next frame, by link_matrix. */
static ALWAYS void step(const Link *k, double c, double s, double *R, double *o) {
    double next[9], L[12];
    link_matrix(k, c, s, L);
    for (int r = 0; r < 3; r++) {
        o[r] += R[3 * r] * L[3] + R[3 * r + 1] * L[7] + R[3 * r + 2] * L[11];
        for (int j = 0; j < 3; j++)
            next[3 * r + j] = R[3 * r] * L[j] + R[3 * r + 1] * L[4 + j] + R[3 * r + 2] * L[8 + j];
    }
    memcpy(R, next, sizeof next);
}

static void write_frame(const double *R, const double *o, double *T) {
    for (int r = 0; r < 3; r++) {
        memcpy(T + 4 * r, R + 3 * r, 3 * sizeof(double));
        T[4 * r + 3] = o[r];
    }
    T[12] = T[13] = T[14] = 0.0, T[15] = 1.0;
}

static void read_frame(const double *T, double *R, double *o) {
    for (int r = 0; r < 3; r++) {
        memcpy(R + 3 * r, T + 4 * r, 3 * sizeof(double));
        o[r] = T[4 * r + 3];
    }
}

/* frames (N, n + 1, 4, 4) from q (N, n), geometry (5, n), or (N, 5, n) where it is that of each pose, T_base_0 (4, 4). */
int frames(int64_t N, int64_t n, const double *q, const double *geometry, int of_each_pose, const double *T_base_0, double *out) {
    Link *links = malloc((size_t)(n + 1) * sizeof(Link));
    if (!links) return NO_MEMORY;
    for (int64_t p = 0; p < N; p++) {
        double R[9], o[3];
        for (int64_t i = 0; i < n && (p == 0 || of_each_pose); i++) link_of(geometry + 5 * n * p, n, i, links + i);
        read_frame(T_base_0, R, o);
        write_frame(R, o, out);
        out += 16;
        for (int64_t i = 0; i < n; i++, out += 16) {
            double turn = q[p * n + i] + links[i].theta;
            step(links + i, cos(turn), sin(turn), R, o);
            write_frame(R, o, out);
        }
    }
    free(links);
    return 0;
}

/* The cosine and sine of q (count,): out (count, 2). */
void turned(int64_t count, const double *q, double *out) {
    for (int64_t i = 0; i < count; i++) out[2 * i] = cos(q[i]), out[2 * i + 1] = sin(q[i]);
}

/* Where the end of the chain is in each pose, out (N, 4, 4); turned (N, n, 2) as above, geometry (5, n),
T_n_end (4, 4) its pose in the last frame. */
int ends(int64_t N, int64_t n, const double *turned, const double *geometry, const double *T_base_0, const double *T_n_end, double *out) {
    Link *links = malloc((size_t)(n + 1) * sizeof(Link));
    if (!links) return NO_MEMORY;
    double E[9], e[3], S[9], s[3];
    read_frame(T_n_end, E, e);
    for (int64_t i = 0; i < n; i++) link_of(geometry, n, i, links + i);
    for (int64_t p = 0; p < N; p++, turned += 2 * n, out += 16) {
        double R[9], o[3];
        read_frame(T_base_0, R, o);
        for (int64_t i = 0; i < n; i++) {
            const Link *k = links + i;
            step(k, turned[2 * i] * k->ct - turned[2 * i + 1] * k->st, turned[2 * i + 1] * k->ct + turned[2 * i] * k->st, R, o);
        }
        for (int r = 0; r < 3; r++) {
            s[r] = o[r] + R[3 * r] * e[0] + R[3 * r + 1] * e[1] + R[3 * r + 2] * e[2];
            for (int j = 0; j < 3; j++) S[3 * r + j] = R[3 * r] * E[j] + R[3 * r + 1] * E[3 + j] + R[3 * r + 2] * E[6 + j];
        }
        write_frame(S, s, out);
    }
    free(links);
    return 0;
}

/* The screw (6), rotation then translation at the base's origin, of every geometric parameter from frames (N, n + 1, 4, 4): out (N, 6, width), of
which the first 5 n columns are written. geometry as in `frames`. */
WIDE void screws(int64_t N, int64_t n, const double *frames, const double *geometry, int of_each_pose, int64_t width, double *out) {
    for (int64_t p = 0; p < N; p++, frames += 16 * (n + 1), out += 6 * width) {
        const double *g = geometry + (of_each_pose ? 5 * n * p : 0);
        for (int64_t i = 0; i < n; i++) {
            const double *before = frames + 16 * i, *after = before + 16;
            double a = g[i], c = cos(g[n + i]), s = sin(g[n + i]), axes[3][3], points[3][3];
            for (int r = 0; r < 3; r++) {
                axes[0][r] = before[4 * r], axes[1][r] = after[4 * r + 2], axes[2][r] = c * before[4 * r + 1] + s * before[4 * r + 2];
                points[0][r] = before[4 * r + 3], points[1][r] = after[4 * r + 3], points[2][r] = before[4 * r + 3] + a * before[4 * r];
                out[r * width + i] = out[r * width + 2 * n + i] = 0.0;
                out[(3 + r) * width + i] = axes[0][r], out[(3 + r) * width + 2 * n + i] = axes[1][r];
            }
            const int kinds[3] = {1, 3, 4}; /* alpha, theta and beta turn about these axes through these points */
            for (int k = 0; k < 3; k++) {
                double shift[3];
                cross3(points[k], axes[k], shift);
                for (int r = 0; r < 3; r++) {
                    out[r * width + kinds[k] * n + i] = axes[k][r];
                    out[(3 + r) * width + kinds[k] * n + i] = shift[r];
                }
            }
        }
    }
}
