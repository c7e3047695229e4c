/* The original paper's model: its rows, and by how much they change when each of its parameters is stepped. */

#pragma once

#include "plane_model.h"

/* Parameters x (P,): a, alpha, d, theta (n each), the sensor's axis and angle (4) and place (3), and (n_x, n_y, n_z, d) of every plane, its
normal of almost unit length. The third component of each unit vector is the root of 1 - x^2 - y^2, read as `reading` has it. */
typedef struct {
    int64_t N, n, K;          /* poses, joints, planes */
    int64_t reading;          /* of a negative argument: 0 not a number, 1 its absolute value, 2 zero */
    const double *q;          /* (N, n) */
    const int64_t *index;     /* (N,), plane of each pose */
    const double *factors;    /* (N, 3, 3): the rows are factors @ contact */
    const double *beta;       /* (n,) */
    const double *T_base_0;   /* (4, 4) */
    const double *T_n_flange; /* (4, 4) */
} Published;

/* The third component of a unit vector, from the first two. */
static double third(const Published *p, const double *two) {
    double rest = 1.0 - two[0] * two[0] - two[1] * two[1];
    if (rest < 0.0 && p->reading) rest = p->reading == 1 ? -rest : 0.0;
    return sqrt(rest);
}

/* The sensor's pose on the flange as three columns (3 x 3): origin, X and Z. */
static void sensor_columns(const double *sensor, double *S) {
    double length = sqrt(dot3(sensor, sensor)), turn[3], R[9], left[9];
    for (int r = 0; r < 3; r++) turn[r] = sensor[r] / length * sensor[3];
    rotation(turn, R, left);
    for (int r = 0; r < 3; r++) S[3 * r] = sensor[4 + r], S[3 * r + 1] = R[3 * r], S[3 * r + 2] = R[3 * r + 2];
}

/* L (3 x 4) times the columns origin, X and Z (3 x 3): the origin alone is moved. */
static ALWAYS void carry(const double *L, const double *from, double *to) {
    for (int r = 0; r < 3; r++)
        for (int j = 0; j < 3; j++)
            to[3 * r + j] = L[4 * r] * from[j] + L[4 * r + 1] * from[3 + j] + L[4 * r + 2] * from[6 + j] + (j ? 0.0 : L[4 * r + 3]);
}

/* A plane's row (4,) times the columns origin, X and Z (3 x 3). place: whether the origin is a point (1) or the change of one (0). */
static ALWAYS void meet(const double *row, const double *columns, double *c, int place) {
    for (int j = 0; j < 3; j++) c[j] = row[0] * columns[j] + row[1] * columns[3 + j] + row[2] * columns[6 + j] + (j || !place ? 0.0 : row[3]);
}

/* A plane's row (4,) times L (3 x 4, or 4 x 4 of a rigid motion). */
static ALWAYS void carry_row(const double *row, const double *L, double *to) {
    for (int j = 0; j < 4; j++) to[j] = row[0] * L[j] + row[1] * L[4 + j] + row[2] * L[8 + j] + (j == 3 ? row[3] : 0.0);
}

/* What does not change from pose to pose: the links at the parameters x and with each of their four parameters stepped, and the columns of the
sensor and the rows of the planes, with by how much a step of each of their own parameters changes them. */
typedef struct {
    Link *links;        /* (n, 5): at x; with a, alpha, d or theta stepped */
    double flange[9];   /* columns of the sensor in the last joint's frame */
    double sensor[7][9];
    double *planes;     /* (K, 4, 4) */
    double *work;       /* of one pose */
} Steps;

static void steps_of(const Published *p, const double *x, const double *steps, Steps *s) {
    int64_t n = p->n;
    const double *sensor = x + 4 * n, *planes = sensor + 7;
    double S[9], own[7];
    for (int64_t i = 0; i < n; i++)
        for (int k = -1; k < (steps ? 4 : 0); k++) {
            double link[5] = {x[i], x[n + i], x[2 * n + i], x[3 * n + i], p->beta[i]};
            if (k >= 0) link[k] += steps[k * n + i];
            link_of(link, 1, 0, s->links + 5 * i + 1 + k);
        }
    sensor_columns(sensor, S);
    carry(p->T_n_flange, S, s->flange);
    if (!steps) return;
    for (int k = 0; k < 7; k++) {
        memcpy(own, sensor, sizeof own);
        own[k] += steps[4 * n + k];
        own[2] = third(p, own);
        sensor_columns(own, s->sensor[k]);
        for (int r = 0; r < 9; r++) s->sensor[k][r] -= S[r];
    }
    for (int64_t k = 0; k < 4 * p->K; k++) { /* row (n, -d): times (p, 1), it is the distance of p from the plane */
        const double *plane = planes + 4 * (k / 4);
        double *change = s->planes + 4 * k;
        memcpy(own, plane, 4 * sizeof(double));
        own[k % 4] += steps[4 * n + 7 + k];
        own[2] = third(p, own);
        for (int r = 0; r < 4; r++) change[r] = r < 3 ? own[r] - plane[r] : plane[r] - own[r];
    }
}

/* The contact c (3) of a pose, and with `by` the changes (3, P) of it by the step of each parameter. */
static ALWAYS void published_pose(const Published *p, const double *x, const Steps *s, int64_t at, double *c, double *by) {
    int64_t n = p->n, P = 4 * n + 7 + 4 * p->K, of_sensor = 4 * n, of_plane = of_sensor + 7 + 4 * p->index[at];
    const double *plane = x + of_plane;
    double *L = s->work, *turned = L + 12 * n, *after = turned + 2 * n, *before = after + 9 * (n + 1), contact[9], reached[4];
    double row[4] = {plane[0], plane[1], plane[2], -plane[3]};
    memcpy(after + 9 * n, s->flange, sizeof s->flange);
    for (int64_t i = n - 1; i >= 0; i--) {
        double turn = p->q[at * n + i] + s->links[5 * i].theta;
        turned[2 * i] = cos(turn), turned[2 * i + 1] = sin(turn);
        link_matrix(s->links + 5 * i, turned[2 * i], turned[2 * i + 1], L + 12 * i);
        carry(L + 12 * i, after + 9 * (i + 1), after + 9 * i);
    }
    carry(p->T_base_0, after, contact);
    meet(row, contact, c, 1);
    if (!by) return;
    memset(by, 0, (size_t)(3 * P) * sizeof(double));
    carry_row(row, p->T_base_0, before);
    for (int64_t i = 0; i < n; i++) {
        const double *own = L + 12 * i, *b = before + 4 * i;
        carry_row(b, own, before + 4 * (i + 1));
        for (int k = 0; k < 4; k++) {
            const Link *link = s->links + 5 * i + 1 + k;
            double stepped[12], v[4], change[3], turn = p->q[at * n + i] + link->theta;
            link_matrix(link, k == 3 ? cos(turn) : turned[2 * i], k == 3 ? sin(turn) : turned[2 * i + 1], stepped);
            for (int j = 0; j < 4; j++)
                v[j] = b[0] * (stepped[j] - own[j]) + b[1] * (stepped[4 + j] - own[4 + j]) + b[2] * (stepped[8 + j] - own[8 + j]);
            meet(v, after + 9 * (i + 1), change, 1);
            for (int r = 0; r < 3; r++) by[r * P + k * n + i] = change[r];
        }
    }
    carry_row(before + 4 * n, p->T_n_flange, reached);
    for (int k = 0; k < 7; k++) {
        double change[3];
        meet(reached, s->sensor[k], change, 0);
        for (int r = 0; r < 3; r++) by[r * P + of_sensor + k] = change[r];
    }
    for (int k = 0; k < 4; k++) {
        double change[3];
        meet(s->planes + 16 * p->index[at] + 4 * k, contact, change, 1);
        for (int r = 0; r < 3; r++) by[r * P + of_plane + k] = change[r];
    }
}

/* rows (N, 3) at parameters x (P,), and where steps (P,) are given by how much the step of each parameter changes them, changes (N, 3, P). */
WIDE int published(const Published *p, const double *x, const double *steps, double *rows, double *changes) {
    int64_t n = p->n, P = 4 * n + 7 + 4 * p->K;
    Steps s;
    s.links = malloc((size_t)(5 * n + 1) * sizeof(Link));
    s.planes = malloc((size_t)(16 * p->K + 1) * sizeof(double));
    s.work = malloc((size_t)(27 * n + 13 + 3 * P) * sizeof(double));
    int status = s.links && s.planes && s.work ? 0 : NO_MEMORY;
    if (!status) steps_of(p, x, steps, &s);
    for (int64_t at = 0; !status && at < p->N; at++) {
        const double *w = p->factors + 9 * at;
        double c[3], *by = steps ? s.work + 27 * n + 13 : NULL;
        published_pose(p, x, &s, at, c, by);
        for (int r = 0; r < 3; r++) {
            rows[3 * at + r] = dot3(w + 3 * r, c);
            if (!by) continue;
            double *out = changes + P * (3 * at + r);
            for (int64_t f = 0; f < P; f++) out[f] = w[3 * r] * by[f] + w[3 * r + 1] * by[P + f] + w[3 * r + 2] * by[2 * P + f];
        }
    }
    free(s.links), free(s.planes), free(s.work);
    return status;
}
