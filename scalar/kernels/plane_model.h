/* A model of arm, sensor and planes: its rows and their derivatives, of four poses at a time. */

#pragma once

#include "chain.h"

/* A model of arm, sensor and planes. Coordinates x (P,): geometry (5, n), the sensor's translation and rotation vector, (u, v, d) of every plane. */
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

/* What follows from the coordinates x once for all poses. */
typedef struct {
    Link *links;
    double flange_R[9], flange_o[3]; /* of the flange in the last joint's frame */
    double R[9], t[3];               /* of the sensor on the flange */
    double turns[9];                 /* left Jacobian of its rotation vector */
    double *planes;                  /* (K, 10): n, d, dn/du, dn/dv */
    four *flanges;                   /* (groups, 12): rotation and origin of the flange in the base frame; NULL where the arm may change */
} State;

/* R (3 x 3) of a rotation vector r (3) [rad], and its left Jacobian (3 x 3). */
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
    if (!(s->links && s->planes)) return NO_MEMORY;
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

/* Four poses that follow one another, from `first` on; past the last pose it stands in for those that are missing. */
typedef struct {
    int64_t first, n_poses, poses[FOUR];
} Group;

static ALWAYS int64_t groups(const Problem *p) { return (p->N + FOUR - 1) / FOUR; }

static ALWAYS void group_at(const Problem *p, int64_t g, Group *group) {
    group->first = FOUR * g;
    group->n_poses = p->N - group->first < FOUR ? p->N - group->first : FOUR;
    for (int l = 0; l < FOUR; l++) group->poses[l] = group->first + (l < group->n_poses ? l : group->n_poses - 1);
}

/* The factors (3) of row k of each pose; zeros for poses that are missing. */
static ALWAYS void factors_of(const Problem *p, const Group *group, int64_t k, four *w) {
    const double *own[FOUR], none[3] = {0};
    for (int l = 0; l < FOUR; l++) own[l] = l < group->n_poses ? p->factors + 3 * (group->poses[l] * p->m + k) : none;
    for (int j = 0; j < 3; j++) gather(own, j, w + j);
}

static ALWAYS void base_frame(const Problem *p, four *R, four *o) {
    const four zero = {0};
    for (int r = 0; r < 3; r++) {
        for (int j = 0; j < 3; j++) R[3 * r + j] = zero + p->T_base_0[4 * r + j];
        o[r] = zero + p->T_base_0[4 * r + 3];
    }
}

/* Frames R (3 x 3) and o (3) become those after joint i, as by `step`; y (3) is the axis about which beta turns. */
static ALWAYS void next_frame(const Problem *p, const State *s, const Group *group, int64_t i, four *R, four *o, four *y) {
    const Link *k = s->links + i;
    const double *q[FOUR];
    for (int l = 0; l < FOUR; l++) q[l] = p->turned + 2 * (group->poses[l] * p->n + i);
    four q_cos, q_sin;
    gather(q, 0, &q_cos), gather(q, 1, &q_sin);
    four c = q_cos * k->ct - q_sin * k->st, sine = q_sin * k->ct + q_cos * k->st;
    for (int r = 0; r < 3; r++) {
        four *row = R + 3 * r, tilted = row[2] * k->ca - row[1] * k->sa, x = row[0] * k->cb - tilted * k->sb;
        y[r] = row[1] * k->ca + row[2] * k->sa;
        o[r] += row[0] * k->a;
        row[2] = row[0] * k->sb + tilted * k->cb;
        o[r] += row[2] * k->d;
        row[0] = x * c + y[r] * sine, row[1] = y[r] * c - x * sine;
    }
}

/* The flange's rotation (3 x 3) and place (3) in the base frame, from those of the last joint's frame. */
static ALWAYS void flange_of(const State *s, const four *R, const four *o, four *F, four *place) {
    const double *f = s->flange_R, *g = s->flange_o;
    for (int r = 0; r < 3; r++) {
        for (int j = 0; j < 3; j++) F[3 * r + j] = R[3 * r] * f[j] + R[3 * r + 1] * f[3 + j] + R[3 * r + 2] * f[6 + j];
        place[r] = o[r] + R[3 * r] * g[0] + R[3 * r + 1] * g[1] + R[3 * r + 2] * g[2];
    }
}

/* For a fit in which the arm keeps the geometry of `state_at`: its flange in every pose, once. */
static int arm_stays(const Problem *p, State *s) {
    four R[9], o[3], y[3];
    Group group;
    s->flanges = malloc((size_t)(12 * groups(p) + 1) * sizeof(four));
    if (!s->flanges) return NO_MEMORY;
    for (int64_t g = 0; g < groups(p); g++) {
        group_at(p, g, &group);
        base_frame(p, R, o);
        for (int64_t i = 0; i < p->n; i++) next_frame(p, s, &group, i, R, o, y);
        flange_of(s, R, o, s->flanges + 12 * g, s->flanges + 12 * g + 9);
    }
    return 0;
}

/* Axes and points of the chain, (n, 3) each, by which its parameters turn and shift the sensor. */
typedef struct {
    four *x_before, *y_tilted, *z_after, *o_before, *o_after;
} Axes;

/* What the derivatives of one group need besides its axes: the sensor's place, the planes' normals, and X x n and Z x n (3 each). */
typedef struct {
    four place[3], normal[3], mX[3], mZ[3];
} Touch;

/* A turn about e through `point` changes the contact by e . ((place - point) x n, X x n, Z x n): written at column j. */
static ALWAYS void turn_about(const four *e, const four *point, const Touch *at, int64_t j, int64_t A, four *by) {
    four arm[3], mo[3];
    for (int r = 0; r < 3; r++) arm[r] = at->place[r] - point[r];
    cross3_of_four(arm, at->normal, mo);
    dot3_of_four(e, mo, by + j), dot3_of_four(e, at->mX, by + A + j), dot3_of_four(e, at->mZ, by + 2 * A + j);
}

/* Derivatives by the arm's parameters; a shift along e changes the contact by (e . n, 0, 0). */
static ALWAYS void by_the_arm(const Problem *p, const State *s, const Axes *axes, const Touch *at, four *by) {
    int64_t n = p->n, A = 5 * n + 6;
    memset(by, 0, (size_t)(3 * A) * sizeof(four));
    for (int64_t i = 0; i < n; i++) {
        const four *x = axes->x_before + 3 * i, *z = axes->z_after + 3 * i, *o = axes->o_before + 3 * i;
        four shifted[3];
        for (int r = 0; r < 3; r++) shifted[r] = o[r] + x[r] * s->links[i].a;
        dot3_of_four(x, at->normal, by + i), dot3_of_four(z, at->normal, by + 2 * n + i);
        turn_about(x, o, at, n + i, A, by);
        turn_about(axes->y_tilted + 3 * i, shifted, at, 4 * n + i, A, by);
        turn_about(z, axes->o_after + 3 * i, at, 3 * n + i, A, by);
    }
}

/* Derivatives by the sensor's shift and turn on the flange, whose rotation in the base frame is F (3 x 3). */
static ALWAYS void by_the_sensor(const Problem *p, const State *s, const four *F, const Touch *at, four *by) {
    int64_t first = 5 * p->n, A = first + 6;
    for (int j = 0; j < 3; j++) {
        four along_X = {0}, along_Z = {0};
        by[first + j] = F[j] * at->normal[0] + F[3 + j] * at->normal[1] + F[6 + j] * at->normal[2];
        for (int r = 0; r < 3; r++) {
            four e = F[3 * r] * s->turns[j] + F[3 * r + 1] * s->turns[3 + j] + F[3 * r + 2] * s->turns[6 + j];
            along_X += e * at->mX[r], along_Z += e * at->mZ[r];
        }
        by[A + first + 3 + j] = along_X, by[2 * A + first + 3 + j] = along_Z;
    }
}

/* The flange's rotation F (3 x 3) and place (3) in the base frame in a group, and the axes of the chain where they are wanted. */
static ALWAYS void flange_in(const Problem *p, const State *s, const Group *group, four *F, four *place, const Axes *axes) {
    four R[9], o[3], y[3];
    if (s->flanges) {
        const four *kept = s->flanges + 3 * group->first;
        memcpy(F, kept, 9 * sizeof(four)), memcpy(place, kept + 9, 3 * sizeof(four));
        return;
    }
    base_frame(p, R, o);
    for (int64_t i = 0; i < p->n; i++) {
        for (int r = 0; axes && r < 3; r++) axes->x_before[3 * i + r] = R[3 * r], axes->o_before[3 * i + r] = o[r];
        next_frame(p, s, group, i, R, o, y);
        for (int r = 0; axes && r < 3; r++)
            axes->y_tilted[3 * i + r] = y[r], axes->z_after[3 * i + r] = R[3 * r + 2], axes->o_after[3 * i + r] = o[r];
    }
    flange_of(s, R, o, F, place);
}

/* One group: contacts c (3), and their derivatives (3, 5 n + 6) by the arm and the sensor and (3, 3) by their planes, where `by` is given; those by
an arm that stays are left as they are. `work` has room for the axes. */
static ALWAYS void pose_group(const Problem *p, const State *s, const Group *group, four *c, four *by, four *by_plane, four *work) {
    int64_t n = p->n;
    Axes axes = {work, work + 3 * n, work + 6 * n, work + 9 * n, work + 12 * n};
    Touch at;
    four F[9], X[3], Z[3], planes[10];
    const double *own[FOUR];
    for (int l = 0; l < FOUR; l++) own[l] = s->planes + 10 * p->index[group->poses[l]];
    for (int j = 0; j < 10; j++) gather(own, j, planes + j);
    memcpy(at.normal, planes, sizeof at.normal);
    flange_in(p, s, group, F, at.place, by ? &axes : NULL);
    for (int r = 0; r < 3; r++) {
        at.place[r] += F[3 * r] * s->t[0] + F[3 * r + 1] * s->t[1] + F[3 * r + 2] * s->t[2];
        X[r] = F[3 * r] * s->R[0] + F[3 * r + 1] * s->R[3] + F[3 * r + 2] * s->R[6];
        Z[r] = F[3 * r] * s->R[2] + F[3 * r + 1] * s->R[5] + F[3 * r + 2] * s->R[8];
    }
    dot3_of_four(at.normal, at.place, c), dot3_of_four(at.normal, X, c + 1), dot3_of_four(at.normal, Z, c + 2);
    c[0] -= planes[3];
    if (!by) return;
    cross3_of_four(X, at.normal, at.mX), cross3_of_four(Z, at.normal, at.mZ);
    if (!s->flanges) by_the_arm(p, s, &axes, &at, by);
    by_the_sensor(p, s, F, &at, by);
    for (int j = 0; j < 2; j++) {
        const four *dn = planes + 4 + 3 * j;
        dot3_of_four(dn, at.place, by_plane + j), dot3_of_four(dn, X, by_plane + 3 + j), dot3_of_four(dn, Z, by_plane + 6 + j);
    }
    by_plane[5] = by_plane[8] = (four){0};
    by_plane[2] = by_plane[5] - 1.0;
}

/* Numbers (of type four) that one group needs: axes, and derivatives by arm and sensor. */
static int64_t work_size(const Problem *p) { return 15 * p->n + 3 * (5 * p->n + 6) + 1; }

/* Rows (N, m) and, unless NULL, their Jacobian (N, m, P). */
WIDE int linearise(const Problem *p, const double *x, double *residual, double *jacobian) {
    State s;
    Group group;
    int64_t A = 5 * p->n + 6, P = A + 3 * p->K;
    four *work = malloc((size_t)work_size(p) * sizeof(four)), c[3], by_plane[9], w[3], row;
    if (state_begin(p, &s) || !work) {
        state_end(&s), free(work);
        return NO_MEMORY;
    }
    state_at(p, x, &s);
    memset(work, 0, (size_t)work_size(p) * sizeof(four));
    four *by = jacobian ? work + 15 * p->n : NULL;
    if (jacobian) memset(jacobian, 0, (size_t)(p->N * p->m * P) * sizeof(double));
    for (int64_t g = 0; g < groups(p); g++) {
        group_at(p, g, &group);
        pose_group(p, &s, &group, c, by, by_plane, work);
        for (int64_t k = 0; k < p->m; k++) {
            factors_of(p, &group, k, w);
            dot3_of_four(w, c, &row);
            for (int l = 0; l < group.n_poses; l++) residual[(group.first + l) * p->m + k] = row[l];
            if (!jacobian) continue;
            double *out = jacobian + (group.first * p->m + k) * P;
            for (int64_t j = 0; j < A; j++) {
                row = w[0] * by[j] + w[1] * by[A + j] + w[2] * by[2 * A + j];
                for (int l = 0; l < group.n_poses; l++) out[l * p->m * P + j] = row[l];
            }
            for (int j = 0; j < 3; j++) {
                row = w[0] * by_plane[j] + w[1] * by_plane[3 + j] + w[2] * by_plane[6 + j];
                for (int l = 0; l < group.n_poses; l++) out[l * p->m * P + A + 3 * p->index[group.poses[l]] + j] = row[l];
            }
        }
    }
    state_end(&s), free(work);
    return 0;
}
