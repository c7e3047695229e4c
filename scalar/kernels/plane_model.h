/* A model of arm, sensor and planes: its rows and their derivatives. */

#pragma once

#include "chain.h"

/* Coordinates x (P,): geometry (5, n), the sensor's translation and rotation vector, (u, v, d) of every plane. */
typedef struct {
    int64_t N, n, K, m;       /* poses, joints, planes, rows a pose */
    const double *turned;     /* (N, n, 2): cosine and sine of the joint angles, which no coordinate changes */
    const int64_t *index;     /* (N,), plane of each pose */
    const double *factors;    /* (N, m, 3): the rows are factors @ contact */
    const double *T_base_0;   /* (4, 4) */
    const double *T_n_flange; /* (4, 4) */
    const double *R_sensor;   /* (3, 3), reference rotation of the sensor on the flange */
    const double *normals;    /* (K, 3), reference normals */
    const double *tangents;   /* (K, 2, 3) */
} Problem;

typedef struct {
    Link *links;
    double flange_R[9], flange_o[3]; /* of the flange in the last joint's frame */
    double R[9], t[3];               /* of the sensor on the flange */
    double turns[9];                 /* left Jacobian of its rotation vector */
    double *planes;                  /* (K, 10): n, d, dn/du, dn/dv */
    double *flanges;                 /* (N, 12): rotation and origin of the flange in the base frame; NULL where the arm may change */
} State;

static void rotation(const double *r, double *R, double *left) {
    double angle = sqrt(dot3(r, r)), a, b, c;
    if (angle < 1e-4)
        a = 1.0 - angle * angle / 6.0, b = 0.5 - angle * angle / 24.0, c = 1.0 / 6.0;
    else {
        double half = sin(0.5 * angle) / (0.5 * angle);
        a = sin(angle) / angle, b = 0.5 * half * half, c = (angle - sin(angle)) / (angle * angle * angle);
    }
    double W[9] = {0, -r[2], r[1], r[2], 0, -r[0], -r[1], r[0], 0};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            double squared = W[3 * i] * W[j] + W[3 * i + 1] * W[3 + j] + W[3 * i + 2] * W[6 + j], unit = i == j;
            R[3 * i + j] = unit + a * W[3 * i + j] + b * squared;
            left[3 * i + j] = unit + b * W[3 * i + j] + c * squared;
        }
}

static int state_begin(const Problem *p, State *s) {
    s->links = malloc((size_t)(p->n + 1) * sizeof(Link));
    s->planes = malloc((size_t)(p->K + 1) * 10 * sizeof(double));
    s->flanges = NULL;
    if (!(s->links && s->planes)) return -1;
    read_frame(p->T_n_flange, s->flange_R, s->flange_o);
    return 0;
}

static void state_end(State *s) { free(s->links), free(s->planes), free(s->flanges); }

static void state_at(const Problem *p, const double *x, State *s) {
    double turned[9];
    for (int64_t i = 0; i < p->n; i++) link_of(x, p->n, i, s->links + i);
    const double *sensor = x + 5 * p->n, *planes = sensor + 6;
    memcpy(s->t, sensor, 3 * sizeof(double));
    rotation(sensor + 3, turned, s->turns);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            s->R[3 * i + j] = turned[3 * i] * p->R_sensor[j] + turned[3 * i + 1] * p->R_sensor[3 + j] + turned[3 * i + 2] * p->R_sensor[6 + j];
    for (int64_t k = 0; k < p->K; k++) {
        double u = planes[3 * k], v = planes[3 * k + 1], *out = s->planes + 10 * k;
        const double *e = p->tangents + 6 * k;
        for (int j = 0; j < 3; j++) out[j] = p->normals[3 * k + j] + u * e[j] + v * e[3 + j];
        double length = sqrt(dot3(out, out));
        for (int j = 0; j < 3; j++) out[j] /= length;
        out[3] = planes[3 * k + 2];
        double along[2] = {dot3(out, e), dot3(out, e + 3)};
        for (int j = 0; j < 3; j++)
            for (int c = 0; c < 2; c++) out[4 + 3 * c + j] = (e[3 * c + j] - out[j] * along[c]) / length;
    }
}

static ALWAYS void flange_of(const State *s, const double *R, const double *o, double *F, double *place) {
    const double *f = s->flange_R, *g = s->flange_o;
    for (int r = 0; r < 3; r++) {
        for (int j = 0; j < 3; j++) F[3 * r + j] = R[3 * r] * f[j] + R[3 * r + 1] * f[3 + j] + R[3 * r + 2] * f[6 + j];
        place[r] = o[r] + R[3 * r] * g[0] + R[3 * r + 1] * g[1] + R[3 * r + 2] * g[2];
    }
}

static ALWAYS void next_frame(const Problem *p, const State *s, int64_t at, int64_t i, double *R, double *o) {
    const Link *link = s->links + i;
    const double *q = p->turned + 2 * (at * p->n + i);
    step(link, q[0] * link->ct - q[1] * link->st, q[1] * link->ct + q[0] * link->st, R, o);
}

/* For a fit in which the arm keeps the geometry of `state_at`: its flange in every pose, once. */
static int arm_stays(const Problem *p, State *s) {
    double R[9], o[3];
    s->flanges = malloc((size_t)(12 * p->N + 1) * sizeof(double));
    if (!s->flanges) return -1;
    for (int64_t at = 0; at < p->N; at++) {
        read_frame(p->T_base_0, R, o);
        for (int64_t i = 0; i < p->n; i++) next_frame(p, s, at, i, R, o);
        flange_of(s, R, o, s->flanges + 12 * at, s->flanges + 12 * at + 9);
    }
    return 0;
}

/* One pose: contact c (3), and its derivatives (3, 5 n + 6) by the arm and the sensor and (3, 3) by its plane, where `by` is given; those by an arm
that stays are left as they are. */
static ALWAYS void pose(const Problem *p, const State *s, int64_t at, double *c, double *by, double *by_plane, double *work) {
    int64_t n = p->n, A = 5 * n + 6;
    double F[9], X[3], Z[3], place[3], R[9], o[3], *x_before = work, *y_tilted = x_before + 3 * n, *z_after = y_tilted + 3 * n,
           *o_before = z_after + 3 * n, *o_after = o_before + 3 * n;
    if (s->flanges)
        memcpy(F, s->flanges + 12 * at, sizeof F), memcpy(place, s->flanges + 12 * at + 9, sizeof place);
    else
        read_frame(p->T_base_0, R, o);
    for (int64_t i = 0; i < (s->flanges ? 0 : n); i++) {
        const Link *link = s->links + i;
        if (by)
            for (int r = 0; r < 3; r++) {
                x_before[3 * i + r] = R[3 * r], o_before[3 * i + r] = o[r];
                y_tilted[3 * i + r] = link->ca * R[3 * r + 1] + link->sa * R[3 * r + 2];
            }
        next_frame(p, s, at, i, R, o);
        if (by)
            for (int r = 0; r < 3; r++) z_after[3 * i + r] = R[3 * r + 2], o_after[3 * i + r] = o[r];
    }
    if (!s->flanges) flange_of(s, R, o, F, place);
    const double *N = s->planes + 10 * p->index[at];
    for (int r = 0; r < 3; r++) {
        place[r] += F[3 * r] * s->t[0] + F[3 * r + 1] * s->t[1] + F[3 * r + 2] * s->t[2];
        X[r] = F[3 * r] * s->R[0] + F[3 * r + 1] * s->R[3] + F[3 * r + 2] * s->R[6];
        Z[r] = F[3 * r] * s->R[2] + F[3 * r + 1] * s->R[5] + F[3 * r + 2] * s->R[8];
    }
    c[0] = dot3(N, place) - N[3], c[1] = dot3(N, X), c[2] = dot3(N, Z);
    if (!by) return;
    /* A turn about e through p changes the contact by e . ((o - p) x n, X x n, Z x n), a shift along e by (e . n, 0, 0). */
    double mX[3], mZ[3], arm[3], mo[3], *by_o = by, *by_X = by + A, *by_Z = by + 2 * A;
    cross3(X, N, mX), cross3(Z, N, mZ);
    if (!s->flanges) memset(by, 0, (size_t)(3 * A) * sizeof(double));
    for (int64_t i = 0; i < (s->flanges ? 0 : n); i++) {
        const double *x = x_before + 3 * i, *y = y_tilted + 3 * i, *z = z_after + 3 * i;
        by_o[i] = dot3(x, N), by_o[2 * n + i] = dot3(z, N);
        for (int r = 0; r < 3; r++) arm[r] = place[r] - o_before[3 * i + r];
        cross3(arm, N, mo);
        by_o[n + i] = dot3(x, mo), by_X[n + i] = dot3(x, mX), by_Z[n + i] = dot3(x, mZ);
        for (int r = 0; r < 3; r++) arm[r] -= s->links[i].a * x[r];
        cross3(arm, N, mo);
        by_o[4 * n + i] = dot3(y, mo), by_X[4 * n + i] = dot3(y, mX), by_Z[4 * n + i] = dot3(y, mZ);
        for (int r = 0; r < 3; r++) arm[r] = place[r] - o_after[3 * i + r];
        cross3(arm, N, mo);
        by_o[3 * n + i] = dot3(z, mo), by_X[3 * n + i] = dot3(z, mX), by_Z[3 * n + i] = dot3(z, mZ);
    }
    for (int j = 0; j < 3; j++) {
        by_o[5 * n + j] = F[j] * N[0] + F[3 + j] * N[1] + F[6 + j] * N[2];
        double e[3];
        for (int r = 0; r < 3; r++) e[r] = F[3 * r] * s->turns[j] + F[3 * r + 1] * s->turns[3 + j] + F[3 * r + 2] * s->turns[6 + j];
        by_X[5 * n + 3 + j] = dot3(e, mX), by_Z[5 * n + 3 + j] = dot3(e, mZ);
    }
    for (int j = 0; j < 2; j++) {
        const double *dn = N + 4 + 3 * j;
        by_plane[j] = dot3(dn, place), by_plane[3 + j] = dot3(dn, X), by_plane[6 + j] = dot3(dn, Z);
    }
    by_plane[2] = -1.0, by_plane[5] = by_plane[8] = 0.0;
}

static int64_t work_size(const Problem *p) { return 15 * p->n + 3 * (5 * p->n + 6) + 1; }

/* Rows (N, m) and, unless NULL, their Jacobian (N, m, P). */
WIDE int linearise(const Problem *p, const double *x, double *residual, double *jacobian) {
    State s;
    int64_t A = 5 * p->n + 6, P = A + 3 * p->K;
    double *work = malloc((size_t)work_size(p) * sizeof(double));
    if (state_begin(p, &s) || !work) {
        state_end(&s), free(work);
        return -1;
    }
    state_at(p, x, &s);
    double c[3], by_plane[9] = {0}, *by = jacobian ? work + 15 * p->n : NULL;
    if (jacobian) memset(jacobian, 0, (size_t)(p->N * p->m * P) * sizeof(double));
    for (int64_t at = 0; at < p->N; at++) {
        pose(p, &s, at, c, by, by_plane, work);
        for (int64_t r = 0; r < p->m; r++) {
            const double *f = p->factors + 3 * (at * p->m + r);
            residual[at * p->m + r] = dot3(f, c);
            if (!jacobian) continue;
            double *row = jacobian + (at * p->m + r) * P, *own = row + A + 3 * p->index[at];
            for (int64_t j = 0; j < A; j++) row[j] = f[0] * by[j] + f[1] * by[A + j] + f[2] * by[2 * A + j];
            for (int j = 0; j < 3; j++) own[j] = f[0] * by_plane[j] + f[1] * by_plane[3 + j] + f[2] * by_plane[6 + j];
        }
    }
    state_end(&s), free(work);
    return 0;
}
