/* Functions of the model window, written by arael 0.1.0.

   Model       window.arael, SHA-256 d942fc37bfe1b18705f1952dbd298327c65ab21c7fd0793a47f09b361f724ca6
   Precision   f64
   Constraints 3

     # A planar window for a small computer: poses with odometry, and landmarks seen by range and bearing.

     struct Pose {
         param pos: vec2 [m]
         param th:  angle
     }

     struct Landmark {
         param pos: vec2 [m]
     }

     # Motion between poses, in the frame of the first.
     struct Step {
         a: ref Pose in root.poses
         b: ref Pose in root.poses
         moved:  vec2 [m]
         turned: real [rad]

         constraint odometry {
             let d = a.th.rotation_matrix()' * (b.pos - a.pos) - moved
             [d / 0.05 [m], rad_diff(rad_diff(b.th, a.th), turned) / 0.02 [rad]]
         }
     }

     struct Sight {
         pose:     ref Pose in root.poses
         landmark: ref Landmark in root.landmarks
         range:   real [m]
         bearing: real [rad]

         constraint sight loss cauchy(2) {
             let d = pose.th.rotation_matrix()' * (landmark.pos - pose.pos)
             [(norm(d) - range) / 0.1 [m], rad_diff(atan2(d.y, d.x), bearing) / 0.03 [rad]]
         }
     }

     # Where the window begins.
     struct Anchor {
         pose: ref Pose in root.poses
         pos:  vec2 [m]
         th:   real [rad]

         constraint prior { [(pose.pos - pos) / 0.01 [m], rad_diff(pose.th, th) / 0.01 [rad]] }
     }

     root Window {
         poses:     list of Pose
         landmarks: list of Landmark
         steps:     list of Step
         sights:    list of Sight
         anchors:   list of Anchor
     }

   An iteration takes at most 2513 operations:
   1596 to linearise, 917 to factorise and substitute.
   RAM of the workspace: 2125 bytes, and padding.
*/
#ifndef WINDOW_SOLVER_H
#define WINDOW_SOLVER_H

#include "window.h"

#ifdef __cplusplus
extern "C" {
#endif

#define WINDOW_SCALARS 13 /* solved for, fixed ones included */
#define WINDOW_BLOCKS 5 /* rows with parameters */
#define WINDOW_VALUES 93 /* scalars of the blocks of J'J and of its factor */

/* Most rows of each collection. */
#define WINDOW_POSES_ROWS 3
#define WINDOW_LANDMARKS_ROWS 2
#define WINDOW_STEPS_ROWS 2
#define WINDOW_SIGHTS_ROWS 6
#define WINDOW_ANCHORS_ROWS 1

/* Stored scalars of all parameters; a row of a collection is a row of an array. */
typedef struct {
    double pose[3][WINDOW_POSE_SIZE];
    double landmark[2][WINDOW_LANDMARK_SIZE];
} window_parameters;

/* A problem. Counts are rows in use, at most those of above; the other arrays have a row each. */
typedef struct {
    window_parameters parameters; /* the start, then the solution */
    unsigned char pose_fixed[3][3]; /* 1: it is fixed */
    unsigned char landmark_fixed[2][2]; /* 1: it is fixed */
    int poses_count;
    int landmarks_count;
    int steps_count;
    int steps_a[2]; /* row that `a` names */
    int steps_b[2]; /* row that `b` names */
    double step_data[2][WINDOW_STEP_DATA_SIZE];
    int sights_count;
    int sights_pose[6]; /* row that `pose` names */
    int sights_landmark[6]; /* row that `landmark` names */
    double sight_data[6][WINDOW_SIGHT_DATA_SIZE];
    int anchors_count;
    int anchors_pose[1]; /* row that `pose` names */
    double anchor_data[1][WINDOW_ANCHOR_DATA_SIZE];
} window_data;

/* Workspace of a solve. */
typedef struct {
    double values[WINDOW_VALUES], factor[WINDOW_VALUES]; /* J'J by blocks, and its factor */
    double gradient[WINDOW_SCALARS];                 /* J'r */
    double scale[WINDOW_SCALARS];                    /* largest norm of each column of J so far */
    double newton[WINDOW_SCALARS], step[WINDOW_SCALARS], product[WINDOW_SCALARS];
    unsigned char held[WINDOW_SCALARS]; /* 1: does not move */
    unsigned char pass;
    window_parameters trial;
} window_state;

typedef enum {
    WINDOW_OK = -1,        /* within a solve */
    WINDOW_CONVERGED,      /* the predicted decrease is below the precision */
    WINDOW_MAX_ITERATIONS, /* the best state so far is in the parameters */
    WINDOW_NOT_FINITE,     /* the cost or a derivative of the start is NaN or infinite */
    WINDOW_SINGULAR,       /* no damping makes J'J positive definite */
    WINDOW_BAD_COUNT,      /* a count is negative, or larger than the collection */
    WINDOW_BAD_REF,        /* a ref or parent names no row */
    WINDOW_PATTERN,        /* refs couple rows that the solver was not exported for */
    WINDOW_OUT_OF_BOUNDS   /* a parameter that is not fixed starts outside of its bounds */
} window_status;

typedef enum {
    WINDOW_DOGLEG, /* trust region */
    WINDOW_DAMPING /* Levenberg-Marquardt */
} window_strategy;

typedef struct {
    int max_iterations;        /* attempts of each pass; 100 */
    double relative_precision; /* of predicted decrease to cost at the end; 0: the model's */
    window_strategy strategy;
    double initial_damping; /* of Levenberg-Marquardt, relative to the scale; 1e-4 */
} window_options;

typedef struct {
    window_status status;
    double start_cost, cost;  /* sums of squared residuals */
    int iterations, accepted; /* attempted steps, and those that lowered the cost */
} window_result;

window_options window_default_options(void);

/* Solves from `data->parameters`, and leaves the solution there. */
window_result window_solve(window_state *state, window_data *data, const window_options *options);

/* Covariance of the step of one row at `data->parameters`, row by row: its block of (J'J)^-1.
   Return 0 if the system is singular or there is no such row. */
int window_covariance_pose(window_state *state, const window_data *data, int row, double covariance[9]);
int window_covariance_landmark(window_state *state, const window_data *data, int row, double covariance[4]);

#ifdef __cplusplus
}
#endif

#endif
