/* Solves the problem of the data file, and prints the solution. */
#include <stdio.h>

#include "window_solver.h"

static window_data data = {
    .parameters.pose = {
        {0.0, 0.0, 0.0},
        {1.1, 0.1, 0.05},
        {2.2, 0.2, 0.1},
    },
    .pose_fixed = {
        {0, 0, 0},
        {0, 0, 0},
        {0, 0, 0},
    },
    .parameters.landmark = {
        {1.5, 1.5},
        {2.5, -0.5},
    },
    .landmark_fixed = {
        {0, 0},
        {0, 0},
    },
    .poses_count = 3,
    .landmarks_count = 2,
    .steps_count = 2,
    .steps_a = {0, 1},
    .steps_b = {1, 2},
    .step_data = {
        {1.0, 0.0, 0.0},
        {1.0, 0.0, 0.0},
    },
    .sights_count = 6,
    .sights_pose = {0, 1, 2, 0, 1, 2},
    .sights_landmark = {0, 0, 0, 1, 1, 1},
    .sight_data = {
        {1.414, 0.785},
        {1.0, 1.571},
        {1.414, 2.356},
        {2.236, -0.464},
        {1.414, -0.785},
        {1.0, -1.571},
    },
    .anchors_count = 1,
    .anchors_pose = {0},
    .anchor_data = {
        {0.0, 0.0, 0.0},
    },
};
static window_state state;

int main(void)
{
    const window_options options = window_default_options();
    const window_result result = window_solve(&state, &data, &options);
    printf("status %d, cost %.17g -> %.17g, %d attempts, %d accepted\n",
           (int)result.status, result.start_cost, result.cost, result.iterations,
           result.accepted);
    for (int row = 0; row < data.poses_count; row++) {
        printf("pose %d", row);
        for (int k = 0; k < WINDOW_POSE_SIZE; k++)
            printf(" %.17g", (double)data.parameters.pose[row][k]);
        printf("\n");
    }
    for (int row = 0; row < data.landmarks_count; row++) {
        printf("landmark %d", row);
        for (int k = 0; k < WINDOW_LANDMARK_SIZE; k++)
            printf(" %.17g", (double)data.parameters.landmark[row][k]);
        printf("\n");
    }
    return result.status != WINDOW_CONVERGED;
}
