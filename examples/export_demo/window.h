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
*/
#ifndef WINDOW_H
#define WINDOW_H

#ifdef __cplusplus
extern "C" {
#endif

/* Parameters of Pose, poses:
     [0-1] pos (vec2) [m]: x, y
     [2] th (angle) */
#define WINDOW_POSE_SIZE 3

/* A step of Pose:
     [0-1] pos (vec2) [m]: x, y
     [2] th (angle) */
#define WINDOW_POSE_STEP_SIZE 3

/* Parameters of Landmark, landmarks:
     [0-1] pos (vec2) [m]: x, y */
#define WINDOW_LANDMARK_SIZE 2

/* A step of Landmark:
     [0-1] pos (vec2) [m]: x, y */
#define WINDOW_LANDMARK_STEP_SIZE 2

/* Data of Step, steps:
     [0-1] moved (vec2 [m]) [m]: x, y
     [2] turned (real [rad]) [rad] */
#define WINDOW_STEP_DATA_SIZE 3
#define WINDOW_STEP_DATA_MOVED 0
#define WINDOW_STEP_DATA_TURNED 2

/* Data of Sight, sights:
     [0] range (real [m]) [m]
     [1] bearing (real [rad]) [rad] */
#define WINDOW_SIGHT_DATA_SIZE 2
#define WINDOW_SIGHT_DATA_RANGE 0
#define WINDOW_SIGHT_DATA_BEARING 1

/* Data of Anchor, anchors:
     [0-1] pos (vec2 [m]) [m]: x, y
     [2] th (real [rad]) [rad] */
#define WINDOW_ANCHOR_DATA_SIZE 3
#define WINDOW_ANCHOR_DATA_POS 0
#define WINDOW_ANCHOR_DATA_TH 2

/* Moves the parameters x of pose by a step; `moved` may be x itself. */
void window_pose_retract(
    const double x[WINDOW_POSE_SIZE], const double step[WINDOW_POSE_STEP_SIZE],
    double moved[WINDOW_POSE_SIZE]);

/* The step that leads from x to y, parameters of pose, by the shortest rotation. */
void window_pose_local(
    const double x[WINDOW_POSE_SIZE], const double y[WINDOW_POSE_SIZE],
    double step[WINDOW_POSE_STEP_SIZE]);

/* Moves the parameters x of landmark by a step; `moved` may be x itself. */
void window_landmark_retract(
    const double x[WINDOW_LANDMARK_SIZE], const double step[WINDOW_LANDMARK_STEP_SIZE],
    double moved[WINDOW_LANDMARK_SIZE]);

/* The step that leads from x to y, parameters of landmark, by the shortest rotation. */
void window_landmark_local(
    const double x[WINDOW_LANDMARK_SIZE], const double y[WINDOW_LANDMARK_SIZE],
    double step[WINDOW_LANDMARK_STEP_SIZE]);

/* Step.odometry, window.arael:19:5: 3 residuals.
   jacobian_a: 3 x 3, row by row, by a step of `a`; or NULL.
   jacobian_b: 3 x 3, row by row, by a step of `b`; or NULL.
   Returns 1. 43 operations with all derivatives. */
int window_step_odometry(
    const double a[WINDOW_POSE_SIZE], const double b[WINDOW_POSE_SIZE],
    const double step_data[WINDOW_STEP_DATA_SIZE], double residual[3], double *jacobian_a,
    double *jacobian_b);

/* Sight.sight, window.arael:31:5: 2 residuals.
   Robustified by cauchy(2).
   jacobian_pose: 2 x 3, row by row, by a step of `pose`; or NULL.
   jacobian_landmark: 2 x 2, row by row, by a step of `landmark`; or NULL.
   Returns 1. 106 operations with all derivatives. */
int window_sight_sight(
    const double pose[WINDOW_POSE_SIZE], const double landmark[WINDOW_LANDMARK_SIZE],
    const double sight_data[WINDOW_SIGHT_DATA_SIZE], double residual[2], double *jacobian_pose,
    double *jacobian_landmark);

/* Anchor.prior, window.arael:43:5: 3 residuals.
   jacobian_pose: 3 x 3, row by row, by a step of `pose`; or NULL.
   Returns 1. 16 operations with all derivatives. */
int window_anchor_prior(
    const double pose[WINDOW_POSE_SIZE], const double anchor_data[WINDOW_ANCHOR_DATA_SIZE],
    double residual[3], double *jacobian_pose);

#ifdef __cplusplus
}
#endif

#endif
