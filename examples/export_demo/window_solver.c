/* Solver of window_solver.h, which has the model and its sizes. */
#include "window_solver.h"

#include <math.h>

/* The block of each row with parameters, in the order of elimination; scalars of each block, and the
   first of them; the pattern of the factor by columns, with fill; the blocks that eliminating a
   column changes. */
static const unsigned char POSITION[5] = {
    0, 1, 2, 3, 4,
};
static const unsigned char SIZE[5] = {
    3, 3, 3, 2, 2,
};
static const unsigned char FIRST[5] = {
    0, 3, 6, 9, 11,
};
static const unsigned char COLUMN_START[6] = {
    0, 4, 8, 11, 13, 14,
};
static const unsigned char BLOCK_ROW[14] = {
    0, 1, 3, 4, 1, 2, 3, 4, 2, 3, 4, 3, 4, 4,
};
static const unsigned char VALUE_START[14] = {
    0, 9, 18, 24, 30, 39, 48, 54, 60, 69, 75, 81, 85, 89,
};
static const unsigned char UPDATE[16] = {
    30, 48, 54, 81, 85, 89, 60, 69, 75, 81, 85, 89, 81, 85, 89, 89,
};

static int find_block(int row, int column)
{
    for (int p = COLUMN_START[column]; p < COLUMN_START[column + 1]; p++)
        if (BLOCK_ROW[p] == row) return VALUE_START[p];
    return -1;
}

static void add_gradient(window_state *s, int entity_row, int residuals, const double *j, const double *r)
{
    const int block = POSITION[entity_row], n = SIZE[block];
    double *g = s->gradient + FIRST[block];
    for (int i = 0; i < residuals; i++)
        for (int k = 0; k < n; k++) g[k] += j[i * n + k] * r[i];
}

/* Adds J_a' J_b to the block of two entity rows; 0 if the pattern has no such block. */
static int add_product(window_state *s, int row_a, int row_b, int residuals, const double *ja, const double *jb,
                       int same_use)
{
    int a = POSITION[row_a], b = POSITION[row_b];
    if (a < b) {
        const int other = a;
        const double *j = ja;
        a = b, b = other, ja = jb, jb = j;
    }
    const int at = find_block(a, b), m = SIZE[a], n = SIZE[b];
    if (at < 0) return 0;
    double *v = s->values + at;
    for (int i = 0; i < residuals; i++)
        for (int p = 0; p < m; p++)
            for (int q = 0; q < n; q++) v[p * n + q] += ja[i * m + p] * jb[i * n + q];
    if (a == b && !same_use)
        for (int i = 0; i < residuals; i++)
            for (int p = 0; p < m; p++)
                for (int q = 0; q < n; q++) v[p * n + q] += jb[i * n + p] * ja[i * m + q];
    return 1;
}

/* Scalars that do not move have no gradient and a row of the unit matrix. */
static void hold(window_state *s)
{
    for (int column = 0; column < WINDOW_BLOCKS; column++) {
        const int n = SIZE[column], c = FIRST[column];
        for (int p = COLUMN_START[column]; p < COLUMN_START[column + 1]; p++) {
            const int m = SIZE[BLOCK_ROW[p]], r = FIRST[BLOCK_ROW[p]];
            double *v = s->values + VALUE_START[p];
            for (int i = 0; i < m; i++)
                for (int k = 0; k < n; k++)
                    if (s->held[r + i] || s->held[c + k])
                        v[i * n + k] = r + i == c + k ? 1.0 : 0.0;
        }
    }
    for (int k = 0; k < WINDOW_SCALARS; k++)
        if (s->held[k]) s->gradient[k] = 0.0;
}

/* y = J'J x */
static void multiply(const window_state *s, const double *x, double *y)
{
    for (int k = 0; k < WINDOW_SCALARS; k++) y[k] = 0.0;
    for (int column = 0; column < WINDOW_BLOCKS; column++) {
        const int n = SIZE[column], c = FIRST[column];
        for (int p = COLUMN_START[column]; p < COLUMN_START[column + 1]; p++) {
            const int m = SIZE[BLOCK_ROW[p]], r = FIRST[BLOCK_ROW[p]];
            const double *v = s->values + VALUE_START[p];
            for (int i = 0; i < m; i++)
                for (int k = 0; k < n; k++) {
                    y[r + i] += v[i * n + k] * x[c + k];
                    if (r != c) y[c + k] += v[i * n + k] * x[r + i];
                }
        }
    }
}

/* Right-looking block Cholesky of J'J + damping * diagonal; 0 if it is not positive definite. */
static int factorise(window_state *s, double damping)
{
    double *l = s->factor;
    int update = 0;
    for (int k = 0; k < WINDOW_VALUES; k++) l[k] = s->values[k];
    for (int column = 0; column < WINDOW_BLOCKS; column++) {
        const int n = SIZE[column], c = FIRST[column];
        const int begin = COLUMN_START[column], end = COLUMN_START[column + 1];
        double *d = l + VALUE_START[begin];
        for (int i = 0; i < n; i++) {
            const double diagonal = s->values[VALUE_START[begin] + i * n + i];
            if (!s->held[c + i]) d[i * n + i] += damping * s->scale[c + i] * s->scale[c + i];
            for (int k = 0; k < i; k++) d[i * n + i] -= d[i * n + k] * d[i * n + k];
            if (!(d[i * n + i] > 2.220446049250313e-16 * diagonal)) return 0;
            d[i * n + i] = sqrt(d[i * n + i]);
            for (int r = i + 1; r < n; r++) {
                for (int k = 0; k < i; k++) d[r * n + i] -= d[r * n + k] * d[i * n + k];
                d[r * n + i] /= d[i * n + i];
            }
        }
        for (int p = begin + 1; p < end; p++) {
            double *v = l + VALUE_START[p];
            for (int r = 0; r < SIZE[BLOCK_ROW[p]]; r++)
                for (int i = 0; i < n; i++) {
                    for (int k = 0; k < i; k++) v[r * n + i] -= v[r * n + k] * d[i * n + k];
                    v[r * n + i] /= d[i * n + i];
                }
        }
        for (int q = begin + 1; q < end; q++)
            for (int p = q; p < end; p++) {
                const int rows = SIZE[BLOCK_ROW[p]], columns = SIZE[BLOCK_ROW[q]];
                const double *a = l + VALUE_START[p], *b = l + VALUE_START[q];
                double *target = l + UPDATE[update++];
                for (int i = 0; i < rows; i++)
                    for (int j = 0; j < columns; j++) {
                        double sum = 0.0;
                        for (int k = 0; k < n; k++) sum += a[i * n + k] * b[j * n + k];
                        target[i * columns + j] -= sum;
                    }
            }
    }
    return 1;
}

/* x = (L L')^-1 x */
static void substitute(const window_state *s, double *x)
{
    const double *l = s->factor;
    for (int column = 0; column < WINDOW_BLOCKS; column++) {
        const int n = SIZE[column], begin = COLUMN_START[column];
        const double *d = l + VALUE_START[begin];
        double *y = x + FIRST[column];
        for (int i = 0; i < n; i++) {
            for (int k = 0; k < i; k++) y[i] -= d[i * n + k] * y[k];
            y[i] /= d[i * n + i];
        }
        for (int p = begin + 1; p < COLUMN_START[column + 1]; p++) {
            const double *v = l + VALUE_START[p];
            double *z = x + FIRST[BLOCK_ROW[p]];
            for (int i = 0; i < SIZE[BLOCK_ROW[p]]; i++)
                for (int k = 0; k < n; k++) z[i] -= v[i * n + k] * y[k];
        }
    }
    for (int column = WINDOW_BLOCKS - 1; column >= 0; column--) {
        const int n = SIZE[column], begin = COLUMN_START[column];
        const double *d = l + VALUE_START[begin];
        double *y = x + FIRST[column];
        for (int p = begin + 1; p < COLUMN_START[column + 1]; p++) {
            const double *v = l + VALUE_START[p], *z = x + FIRST[BLOCK_ROW[p]];
            for (int i = 0; i < SIZE[BLOCK_ROW[p]]; i++)
                for (int k = 0; k < n; k++) y[k] -= v[i * n + k] * z[i];
        }
        for (int i = n - 1; i >= 0; i--) {
            for (int k = i + 1; k < n; k++) y[i] -= d[k * n + i] * y[k];
            y[i] /= d[i * n + i];
        }
    }
}

static double dot(const double *a, const double *b)
{
    double sum = 0.0;
    for (int k = 0; k < WINDOW_SCALARS; k++) sum += (double)a[k] * (double)b[k];
    return sum;
}

/* Length of a step in units of the scale of each scalar. */
static double scaled_length(const window_state *s, const double *x)
{
    double sum = 0.0;
    for (int k = 0; k < WINDOW_SCALARS; k++) {
        const double y = (double)s->scale[k] * (double)x[k];
        sum += y * y;
    }
    return sqrt(sum);
}

/* Decrease of the cost that the linear model predicts for a step: -(2 g'p + p'J'Jp). */
static double predicted_decrease(window_state *s, const double *step)
{
    multiply(s, step, s->product);
    return -(2.0 * dot(s->gradient, step) + dot(step, s->product));
}

/* Cost at `x`; with `derive` J'r and J'J as well. */
static window_status evaluate(const window_data *data, const window_parameters *x,
                           window_state *s, int derive, double *cost)
{
    double sum = 0.0;
    for (int i = 0; i < data->steps_count; i++) { /* Step.odometry */
        const int row1 = data->steps_a[i];
        if (row1 < 0 || row1 >= data->poses_count) return WINDOW_BAD_REF;
        const int row2 = data->steps_b[i];
        if (row2 < 0 || row2 >= data->poses_count) return WINDOW_BAD_REF;
        double residual[3];
        double j0[9];
        double j1[9];
        if (!window_step_odometry(x->pose[row1], x->pose[row2], data->step_data[i], residual, derive ? j0 : 0, derive ? j1 : 0)) continue;
        for (int k = 0; k < 3; k++) sum += (double)residual[k] * (double)residual[k];
        if (!derive) continue;
        add_gradient(s, row1, 3, j0, residual);
        add_gradient(s, row2, 3, j1, residual);
        if (!add_product(s, row1, row1, 3, j0, j0, 1)) return WINDOW_PATTERN;
        if (!add_product(s, row2, row1, 3, j1, j0, 0)) return WINDOW_PATTERN;
        if (!add_product(s, row2, row2, 3, j1, j1, 1)) return WINDOW_PATTERN;
    }
    for (int i = 0; i < data->sights_count; i++) { /* Sight.sight */
        const int row1 = data->sights_pose[i];
        if (row1 < 0 || row1 >= data->poses_count) return WINDOW_BAD_REF;
        const int row2 = data->sights_landmark[i];
        if (row2 < 0 || row2 >= data->landmarks_count) return WINDOW_BAD_REF;
        double residual[2];
        double j0[6];
        double j1[4];
        if (!window_sight_sight(x->pose[row1], x->landmark[row2], data->sight_data[i], residual, derive ? j0 : 0, derive ? j1 : 0)) continue;
        for (int k = 0; k < 2; k++) sum += (double)residual[k] * (double)residual[k];
        if (!derive) continue;
        add_gradient(s, row1, 2, j0, residual);
        add_gradient(s, 3 + row2, 2, j1, residual);
        if (!add_product(s, row1, row1, 2, j0, j0, 1)) return WINDOW_PATTERN;
        if (!add_product(s, 3 + row2, row1, 2, j1, j0, 0)) return WINDOW_PATTERN;
        if (!add_product(s, 3 + row2, 3 + row2, 2, j1, j1, 1)) return WINDOW_PATTERN;
    }
    for (int i = 0; i < data->anchors_count; i++) { /* Anchor.prior */
        const int row1 = data->anchors_pose[i];
        if (row1 < 0 || row1 >= data->poses_count) return WINDOW_BAD_REF;
        double residual[3];
        double j0[9];
        if (!window_anchor_prior(x->pose[row1], data->anchor_data[i], residual, derive ? j0 : 0)) continue;
        for (int k = 0; k < 3; k++) sum += (double)residual[k] * (double)residual[k];
        if (!derive) continue;
        add_gradient(s, row1, 3, j0, residual);
        if (!add_product(s, row1, row1, 3, j0, j0, 1)) return WINDOW_PATTERN;
    }
    *cost = sum;
    return WINDOW_OK;
}

/* Marks what does not move: fixed scalars, those a pass freezes, rows not in use. */
static void hold_fixed(const window_data *data, window_state *s)
{
    for (int row = 0; row < 3; row++)
        for (int k = 0; k < 3; k++)
            s->held[FIRST[POSITION[0 + row]] + k] =
                row >= data->poses_count || data->pose_fixed[row][k] != 0;
    for (int row = 0; row < 2; row++)
        for (int k = 0; k < 2; k++)
            s->held[FIRST[POSITION[3 + row]] + k] =
                row >= data->landmarks_count || data->landmark_fixed[row][k] != 0;
}

/* Holds scalars that are on a bound and whose gradient points outwards. */
static void hold_bounds(const window_data *data, window_state *s)
{
    (void)data;
    (void)s;
}

/* The trial parameters: those accepted, moved by the step, within their bounds. */
static void retract(const window_data *data, window_state *s)
{
    for (int row = 0; row < 3; row++) {
        window_pose_retract(data->parameters.pose[row],
            s->step + FIRST[POSITION[0 + row]], s->trial.pose[row]);
    }
    for (int row = 0; row < 2; row++) {
        window_landmark_retract(data->parameters.landmark[row],
            s->step + FIRST[POSITION[3 + row]], s->trial.landmark[row]);
    }
}

/* Residuals, J'r and J'J at the accepted parameters. */
static int linearise(const window_data *data, window_state *s, double *cost)
{
    for (int k = 0; k < WINDOW_SCALARS; k++) s->gradient[k] = 0.0;
    for (int k = 0; k < WINDOW_VALUES; k++) s->values[k] = 0.0;
    const int status = evaluate(data, &data->parameters, s, 1, cost);
    if (status != WINDOW_OK) return status;
    hold_fixed(data, s);
    hold(s);
    for (int column = 0; column < WINDOW_BLOCKS; column++)
        for (int k = 0; k < SIZE[column]; k++) {
            const int at = FIRST[column] + k;
            const int diagonal = VALUE_START[COLUMN_START[column]] + k * (SIZE[column] + 1);
            const double norm = sqrt(s->values[diagonal]);
            if (norm > s->scale[at]) s->scale[at] = norm;
            if (!(s->scale[at] > 0.0)) s->scale[at] = 1.0;
        }
    return WINDOW_OK;
}

/* The Gauss-Newton step, damped where J'J is not positive definite; 0 if no damping helps. */
static int newton_step(window_state *s, double damping)
{
    for (int tries = 0; !factorise(s, damping); tries++) {
        if (tries == 20) return 0;
        damping = damping > 0.0 ? damping * (double)10 : (double)1e3 * 2.220446049250313e-16;
    }
    for (int k = 0; k < WINDOW_SCALARS; k++) s->newton[k] = -s->gradient[k];
    substitute(s, s->newton);
    return 1;
}

/* Powell's dogleg in the scaled variables: steepest descent, then towards the Gauss-Newton step. */
static void dogleg(window_state *s, double radius)
{
    if (scaled_length(s, s->newton) <= radius) {
        for (int k = 0; k < WINDOW_SCALARS; k++) s->step[k] = s->newton[k];
        return;
    }
    for (int k = 0; k < WINDOW_SCALARS; k++)
        s->step[k] = -s->gradient[k] / (s->scale[k] * s->scale[k]);
    multiply(s, s->step, s->product);
    const double curvature = dot(s->step, s->product), slope = -dot(s->gradient, s->step);
    const double length = scaled_length(s, s->step);
    double factor = curvature > 0.0 ? slope / curvature : radius / length;
    if (factor * length >= radius) {
        factor = radius / length;
        for (int k = 0; k < WINDOW_SCALARS; k++) s->step[k] *= (double)factor;
        return;
    }
    double aa = 0.0, ab = 0.0, bb = 0.0; /* of the corner a and the way b to the Gauss-Newton step */
    for (int k = 0; k < WINDOW_SCALARS; k++) {
        s->step[k] *= (double)factor;
        const double a = (double)s->scale[k] * (double)s->step[k];
        const double b = (double)s->scale[k] * (double)s->newton[k] - a;
        aa += a * a, ab += a * b, bb += b * b;
    }
    const double gap = radius * radius - aa;
    const double along = gap / (ab + sqrt(ab * ab + bb * gap));
    for (int k = 0; k < WINDOW_SCALARS; k++) s->step[k] += (double)along * (s->newton[k] - s->step[k]);
}

static int is_finite(double x) { return x - x == 0.0; }

/* One pass: trust region or damping until the predicted decrease is below precision * cost. */
static void minimise(window_data *data, window_state *s, const window_options *options, double precision,
                     int most, window_result *result)
{
    const int begin = result->iterations;
    double cost, radius = 0.0, damping = options->initial_damping, growth = 2.0;
    for (int k = 0; k < WINDOW_SCALARS; k++) s->scale[k] = 0.0;
    result->status = linearise(data, s, &cost);
    result->cost = cost;
    if (result->status != WINDOW_OK) return;
    if (!is_finite(cost) || !is_finite(dot(s->gradient, s->gradient))) {
        result->status = WINDOW_NOT_FINITE;
        return;
    }
    int stepped = 1; /* whether the linearisation is new */
    while (result->iterations - begin < most) {
        if (stepped) hold_bounds(data, s);
        if (stepped || options->strategy == WINDOW_DAMPING)
            if (!newton_step(s, options->strategy == WINDOW_DAMPING ? (double)damping : 0.0)) {
                result->status = WINDOW_SINGULAR;
                return;
            }
        if (options->strategy == WINDOW_DAMPING)
            for (int k = 0; k < WINDOW_SCALARS; k++) s->step[k] = s->newton[k];
        else {
            if (radius <= 0.0) radius = scaled_length(s, s->newton);
            dogleg(s, radius);
        }
        const double predicted = predicted_decrease(s, s->step);
        const double floor = 16.0 * 2.220446049250313e-16 * cost;
        const int last = predicted <= precision * cost || predicted <= floor;
        retract(data, s);
        double trial;
        result->iterations++;
        const int status = evaluate(data, &s->trial, s, 0, &trial);
        if (status != WINDOW_OK) {
            result->status = status;
            return;
        }
        const double gain = is_finite(trial) && predicted > 0.0 ? (cost - trial) / predicted : -1.0;
        const double length = scaled_length(s, s->step);
        stepped = trial < cost && (gain > 1e-4 || last);
        if (stepped) {
            data->parameters = s->trial;
            result->accepted++;
        }
        if (last) {
            result->cost = stepped ? trial : cost;
            result->status = WINDOW_CONVERGED;
            return;
        }
        if (gain < 0.25) radius = 0.25 * length;
        if (gain > 0.75 && 3.0 * length > radius) radius = 3.0 * length;
        if (stepped) {
            const double bend = 2.0 * gain - 1.0, shrink = 1.0 - bend * bend * bend;
            damping *= shrink > 1.0 / 3.0 ? shrink : 1.0 / 3.0, growth = 2.0;
            result->status = linearise(data, s, &cost);
            result->cost = cost;
            if (result->status != WINDOW_OK) return;
        } else
            damping *= growth, growth *= 2.0;
    }
    result->status = WINDOW_MAX_ITERATIONS;
}

window_options window_default_options(void)
{
    const window_options options = {100, 0.0, WINDOW_DOGLEG, 1e-4};
    return options;
}

/* Stored values that constraints read: the parameters when a solve begins. */
static void keep_stored(window_data *data)
{
    (void)data;
}

static window_status check_counts(const window_data *data)
{
    if (data->poses_count < 0 || data->poses_count > 3) return WINDOW_BAD_COUNT;
    if (data->landmarks_count < 0 || data->landmarks_count > 2) return WINDOW_BAD_COUNT;
    if (data->steps_count < 0 || data->steps_count > 2) return WINDOW_BAD_COUNT;
    if (data->sights_count < 0 || data->sights_count > 6) return WINDOW_BAD_COUNT;
    if (data->anchors_count < 0 || data->anchors_count > 1) return WINDOW_BAD_COUNT;
    (void)data;
    return WINDOW_OK;
}

window_result window_solve(window_state *state, window_data *data, const window_options *options)
{
    window_result result = {check_counts(data), 0.0, 0.0, 0, 0};
    if (result.status != WINDOW_OK) return result;
    keep_stored(data);
    /* pass solve */
    state->pass = 0;
    result.status =
        evaluate(data, &data->parameters, state, 0, &result.start_cost);
    result.cost = result.start_cost;
    if (result.status != WINDOW_OK) return result;
    minimise(data, state, options, options->relative_precision > 0.0 ? options->relative_precision : 1e-09, options->max_iterations, &result);
    return result;
}

int window_covariance_pose(window_state *state, const window_data *data, int row, double covariance[9])
{
    double cost;
    if (row < 0 || row >= data->poses_count) return 0;
    for (int k = 0; k < WINDOW_SCALARS; k++) state->scale[k] = 0.0;
    state->pass = 0;
    if (linearise(data, state, &cost) != WINDOW_OK) return 0;
    if (!factorise(state, 0.0)) return 0;
    const int first = FIRST[POSITION[0 + row]];
    for (int k = 0; k < 3; k++) {
        for (int i = 0; i < WINDOW_SCALARS; i++) state->newton[i] = 0.0;
        if (!state->held[first + k]) state->newton[first + k] = 1;
        substitute(state, state->newton);
        for (int i = 0; i < 3; i++)
            covariance[i * 3 + k] =
                state->held[first + i] ? 0.0 : state->newton[first + i];
    }
    return 1;
}

int window_covariance_landmark(window_state *state, const window_data *data, int row, double covariance[4])
{
    double cost;
    if (row < 0 || row >= data->landmarks_count) return 0;
    for (int k = 0; k < WINDOW_SCALARS; k++) state->scale[k] = 0.0;
    state->pass = 0;
    if (linearise(data, state, &cost) != WINDOW_OK) return 0;
    if (!factorise(state, 0.0)) return 0;
    const int first = FIRST[POSITION[3 + row]];
    for (int k = 0; k < 2; k++) {
        for (int i = 0; i < WINDOW_SCALARS; i++) state->newton[i] = 0.0;
        if (!state->held[first + k]) state->newton[first + k] = 1;
        substitute(state, state->newton);
        for (int i = 0; i < 2; i++)
            covariance[i * 2 + k] =
                state->held[first + i] ? 0.0 : state->newton[first + i];
    }
    return 1;
}

