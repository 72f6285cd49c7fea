/* Functions of window.h, which has the model. */
#include "window.h"

#include <math.h>
static inline double arael_max(double a, double b) { return (a > b || a != a ? a : b); }

void window_pose_retract(
    const double x[WINDOW_POSE_SIZE], const double step[WINDOW_POSE_STEP_SIZE],
    double moved[WINDOW_POSE_SIZE])
{
    const double x0 = x[0];
    const double x1 = x[1];
    const double x2 = x[2];
    const double x3 = step[0];
    const double x4 = step[1];
    const double x5 = step[2];
    const double t0 = x0 + x3;
    const double t1 = x1 + x4;
    const double t2 = x2 + x5;
    const double t3 = t2 - 3.141592653589793;
    const double t4 = t3 / 6.283185307179586;
    const double t5 = ceil(t4);
    const double t6 = 6.283185307179586 * t5;
    const double t7 = t2 - t6;
    moved[0] = t0;
    moved[1] = t1;
    moved[2] = t7;
}

void window_pose_local(
    const double x[WINDOW_POSE_SIZE], const double y[WINDOW_POSE_SIZE],
    double step[WINDOW_POSE_STEP_SIZE])
{
    const double x0 = x[0];
    const double x1 = x[1];
    const double x2 = x[2];
    const double x3 = y[0];
    const double x4 = y[1];
    const double x5 = y[2];
    const double t0 = x3 - x0;
    const double t1 = x4 - x1;
    const double t2 = x5 - x2;
    const double t3 = t2 - 3.141592653589793;
    const double t4 = t3 / 6.283185307179586;
    const double t5 = ceil(t4);
    const double t6 = 6.283185307179586 * t5;
    const double t7 = t2 - t6;
    step[0] = t0;
    step[1] = t1;
    step[2] = t7;
}

void window_landmark_retract(
    const double x[WINDOW_LANDMARK_SIZE], const double step[WINDOW_LANDMARK_STEP_SIZE],
    double moved[WINDOW_LANDMARK_SIZE])
{
    const double x0 = x[0];
    const double x1 = x[1];
    const double x2 = step[0];
    const double x3 = step[1];
    const double t0 = x0 + x2;
    const double t1 = x1 + x3;
    moved[0] = t0;
    moved[1] = t1;
}

void window_landmark_local(
    const double x[WINDOW_LANDMARK_SIZE], const double y[WINDOW_LANDMARK_SIZE],
    double step[WINDOW_LANDMARK_STEP_SIZE])
{
    const double x0 = x[0];
    const double x1 = x[1];
    const double x2 = y[0];
    const double x3 = y[1];
    const double t0 = x2 - x0;
    const double t1 = x3 - x1;
    step[0] = t0;
    step[1] = t1;
}

int window_step_odometry(
    const double a[WINDOW_POSE_SIZE], const double b[WINDOW_POSE_SIZE],
    const double step_data[WINDOW_STEP_DATA_SIZE], double residual[3], double *jacobian_a,
    double *jacobian_b)
{
    const double step_moved_x = step_data[0];
    const double step_moved_y = step_data[1];
    const double step_turned = step_data[2];
    const double a_pos_x = a[0];
    const double a_pos_y = a[1];
    const double a_th = a[2];
    const double t0 = a_th - 3.141592653589793;
    const double t1 = t0 / 6.283185307179586;
    const double t2 = ceil(t1);
    const double t3 = 6.283185307179586 * t2;
    const double t4 = a_th - t3;
    const double t5 = sin(t4);
    const double t6 = cos(t4);
    const double b_pos_x = b[0];
    const double b_pos_y = b[1];
    const double b_th = b[2];
    const double t7 = b_th - 3.141592653589793;
    const double t8 = t7 / 6.283185307179586;
    const double t9 = ceil(t8);
    const double t10 = 6.283185307179586 * t9;
    const double t11 = b_th - t10;
    /* window.arael:20:44: b.pos - a.pos */
    const double t12 = b_pos_x - a_pos_x;
    const double t13 = b_pos_y - a_pos_y;
    /* window.arael:20:17: a.th.rotation_matrix()' * (b.pos - a.pos) */
    const double t14 = t6 * t12;
    const double t15 = t5 * t13;
    const double t16 = t14 + t15;
    const double t17 = t5 * t12;
    const double t18 = t6 * t13;
    const double t19 = t18 - t17;
    /* window.arael:20:17: a.th.rotation_matrix()' * (b.pos - a.pos) - moved */
    const double t20 = t16 - step_moved_x;
    const double t21 = t19 - step_moved_y;
    /* window.arael:21:10: d / 0.05 [m] */
    const double t22 = t20 / 0.05;
    const double t23 = t21 / 0.05;
    /* window.arael:21:33: rad_diff(b.th, a.th) */
    const double t24 = t11 - t4;
    const double t25 = t24 - 3.141592653589793;
    const double t26 = t25 / 6.283185307179586;
    const double t27 = ceil(t26);
    const double t28 = 6.283185307179586 * t27;
    const double t29 = t24 - t28;
    /* window.arael:21:24: rad_diff(rad_diff(b.th, a.th), turned) */
    const double t30 = t29 - step_turned;
    const double t31 = t30 - 3.141592653589793;
    const double t32 = t31 / 6.283185307179586;
    const double t33 = ceil(t32);
    const double t34 = 6.283185307179586 * t33;
    const double t35 = t30 - t34;
    /* window.arael:21:24: rad_diff(rad_diff(b.th, a.th), turned) / 0.02 [rad] */
    const double t36 = t35 / 0.02;
    residual[0] = t22;
    residual[1] = t23;
    residual[2] = t36;
    if (!jacobian_a && !jacobian_b) return 1;

    /* window.arael:21:10: d / 0.05 [m] */
    const double t37 = t19 * 20.0;
    const double t38 = t6 * 20.0;
    const double t39 = t5 * 20.0;
    const double t40 = t16 * (-20.0);
    if (jacobian_a) {
        jacobian_a[0] = -t38;
        jacobian_a[1] = -t39;
        jacobian_a[2] = t37;
        jacobian_a[3] = t39;
        jacobian_a[4] = -t38;
        jacobian_a[5] = t40;
        jacobian_a[6] = 0.0;
        jacobian_a[7] = 0.0;
        jacobian_a[8] = -50.0;
    }
    if (jacobian_b) {
        jacobian_b[0] = t38;
        jacobian_b[1] = t39;
        jacobian_b[2] = 0.0;
        jacobian_b[3] = -t39;
        jacobian_b[4] = t38;
        jacobian_b[5] = 0.0;
        jacobian_b[6] = 0.0;
        jacobian_b[7] = 0.0;
        jacobian_b[8] = 50.0;
    }
    return 1;
}

int window_sight_sight(
    const double pose[WINDOW_POSE_SIZE], const double landmark[WINDOW_LANDMARK_SIZE],
    const double sight_data[WINDOW_SIGHT_DATA_SIZE], double residual[2], double *jacobian_pose,
    double *jacobian_landmark)
{
    const double sight_bearing = sight_data[1];
    const double sight_range = sight_data[0];
    const double pose_pos_x = pose[0];
    const double pose_pos_y = pose[1];
    const double pose_th = pose[2];
    const double t0 = pose_th - 3.141592653589793;
    const double t1 = t0 / 6.283185307179586;
    const double t2 = ceil(t1);
    const double t3 = 6.283185307179586 * t2;
    const double t4 = pose_th - t3;
    const double t5 = sin(t4);
    const double t6 = cos(t4);
    const double landmark_pos_x = landmark[0];
    const double landmark_pos_y = landmark[1];
    /* window.arael:32:47: landmark.pos - pose.pos */
    const double t7 = landmark_pos_x - pose_pos_x;
    const double t8 = landmark_pos_y - pose_pos_y;
    /* window.arael:32:17: pose.th.rotation_matrix()' * (landmark.pos - pose.pos) */
    const double t9 = t6 * t7;
    const double t10 = t5 * t8;
    const double t11 = t9 + t10;
    const double t12 = t5 * t7;
    const double t13 = t6 * t8;
    const double t14 = t13 - t12;
    /* window.arael:33:11: norm(d) */
    const double t15 = t11 * t11;
    const double t16 = t14 * t14;
    const double t17 = t15 + t16;
    const double t18 = sqrt(t17);
    /* window.arael:33:11: norm(d) - range */
    const double t19 = t18 - sight_range;
    /* window.arael:33:10: (norm(d) - range) / 0.1 [m] */
    const double t20 = t19 / 0.1;
    /* window.arael:33:48: atan2(d.y, d.x) */
    const double t21 = atan2(t14, t11);
    /* window.arael:33:39: rad_diff(atan2(d.y, d.x), bearing) */
    const double t22 = t21 - sight_bearing;
    const double t23 = t22 - 3.141592653589793;
    const double t24 = t23 / 6.283185307179586;
    const double t25 = ceil(t24);
    const double t26 = 6.283185307179586 * t25;
    const double t27 = t22 - t26;
    /* window.arael:33:39: rad_diff(atan2(d.y, d.x), bearing) / 0.03 [rad] */
    const double t28 = t27 / 0.03;
    /* window.arael:31:27: cauchy(2) */
    const double t29 = t20 * t20;
    const double t30 = t28 * t28;
    const double t31 = t29 + t30;
    const double t32 = t31 * 0.25;
    const double t33 = 1.0 + t32;
    const double t34 = t33;
    const double t35 = (1.0 == t34 ? 1.0 : 0.0);
    const double t36 = t34 - 1.0;
    const double t37 = (t35 != 0.0 ? 1.0 : t36);
    const double t38 = log(t34);
    const double t39 = t38 / t37;
    const double t40 = (t35 != 0.0 ? 1.0 : t39);
    const double t41 = sqrt(t40);
    const double t42 = t20 * t41;
    const double t43 = t28 * t41;
    residual[0] = t42;
    residual[1] = t43;
    if (!jacobian_pose && !jacobian_landmark) return 1;

    const double t44 = 1.0 / t33;
    const double t45 = t44 / t41;
    const double t46 = 0.01 * t40;
    const double t47 = arael_max(t44, t46);
    const double t48 = sqrt(t47);
    const double t49 = arael_max(t31, 1e-30);
    const double t50 = t45 - t48;
    const double t51 = 0.5 * t50;
    const double t52 = t51 / t49;
    const double t53 = t20 * t52;
    const double t54 = t28 * t52;
    /* window.arael:33:11: norm(d) */
    const double t55 = t17 * 0.03;
    const double t56 = 1.0 / t55;
    /* window.arael:31:27: cauchy(2) */
    const double t57 = t28 * t56;
    /* window.arael:33:11: norm(d) */
    const double t58 = t18 * 0.1;
    const double t59 = 1.0 / t58;
    /* window.arael:31:27: cauchy(2) */
    const double t60 = t20 * t59;
    const double t61 = t11 * t60;
    const double t62 = t14 * t57;
    const double t63 = t61 - t62;
    const double t64 = t11 * t57;
    const double t65 = t14 * t60;
    const double t66 = t64 + t65;
    /* window.arael:32:17: pose.th.rotation_matrix()' * (landmark.pos - pose.pos) */
    const double t67 = t48 * t59;
    const double t68 = 2.0 * t63;
    const double t69 = t11 * t67;
    const double t70 = t53 * t68;
    const double t71 = t69 + t70;
    const double t72 = t48 * t56;
    const double t73 = t14 * t72;
    const double t74 = t54 * t68;
    const double t75 = t73 - t74;
    const double t76 = 2.0 * t66;
    const double t77 = t14 * t67;
    const double t78 = t53 * t76;
    const double t79 = t77 + t78;
    const double t80 = t11 * t72;
    const double t81 = t54 * t76;
    const double t82 = t80 + t81;
    /* window.arael:31:27: cauchy(2) */
    const double t83 = t14 * t71;
    const double t84 = t11 * t79;
    const double t85 = t6 * t71;
    const double t86 = t5 * t79;
    const double t87 = t85 - t86;
    const double t88 = t5 * t71;
    const double t89 = t6 * t79;
    const double t90 = t88 + t89;
    const double t91 = t14 * t75;
    const double t92 = t11 * t82;
    const double t93 = t91 + t92;
    const double t94 = t6 * t75;
    const double t95 = t5 * t82;
    const double t96 = t94 + t95;
    const double t97 = t5 * t75;
    const double t98 = t6 * t82;
    const double t99 = t97 - t98;
    const double t100 = t83 - t84;
    if (jacobian_pose) {
        jacobian_pose[0] = -t87;
        jacobian_pose[1] = -t90;
        jacobian_pose[2] = t100;
        jacobian_pose[3] = t96;
        jacobian_pose[4] = t99;
        jacobian_pose[5] = -t93;
    }
    if (jacobian_landmark) {
        jacobian_landmark[0] = t87;
        jacobian_landmark[1] = t90;
        jacobian_landmark[2] = -t96;
        jacobian_landmark[3] = -t99;
    }
    return 1;
}

int window_anchor_prior(
    const double pose[WINDOW_POSE_SIZE], const double anchor_data[WINDOW_ANCHOR_DATA_SIZE],
    double residual[3], double *jacobian_pose)
{
    const double anchor_pos_x = anchor_data[0];
    const double anchor_pos_y = anchor_data[1];
    const double anchor_th = anchor_data[2];
    const double pose_pos_x = pose[0];
    const double pose_pos_y = pose[1];
    const double pose_th = pose[2];
    const double t0 = pose_th - 3.141592653589793;
    const double t1 = t0 / 6.283185307179586;
    const double t2 = ceil(t1);
    const double t3 = 6.283185307179586 * t2;
    const double t4 = pose_th - t3;
    /* window.arael:43:26: pose.pos - pos */
    const double t5 = pose_pos_x - anchor_pos_x;
    const double t6 = pose_pos_y - anchor_pos_y;
    /* window.arael:43:25: (pose.pos - pos) / 0.01 [m] */
    const double t7 = t5 / 0.01;
    const double t8 = t6 / 0.01;
    /* window.arael:43:54: rad_diff(pose.th, th) */
    const double t9 = t4 - anchor_th;
    const double t10 = t9 - 3.141592653589793;
    const double t11 = t10 / 6.283185307179586;
    const double t12 = ceil(t11);
    const double t13 = 6.283185307179586 * t12;
    const double t14 = t9 - t13;
    /* window.arael:43:54: rad_diff(pose.th, th) / 0.01 [rad] */
    const double t15 = t14 / 0.01;
    residual[0] = t7;
    residual[1] = t8;
    residual[2] = t15;
    if (!jacobian_pose) return 1;

    if (jacobian_pose) {
        jacobian_pose[0] = 100.0;
        jacobian_pose[1] = 0.0;
        jacobian_pose[2] = 0.0;
        jacobian_pose[3] = 0.0;
        jacobian_pose[4] = 100.0;
        jacobian_pose[5] = 0.0;
        jacobian_pose[6] = 0.0;
        jacobian_pose[7] = 0.0;
        jacobian_pose[8] = 100.0;
    }
    return 1;
}
