// A problem in Ceres, with its start.
#pragma once

#include <ceres/ceres.h>

#include "columns.h"

class Problem {
 public:
  virtual ~Problem() = default;

  void restart() { *state_ = start_; }

  ceres::Solver::Summary solve(int iterations, bool to_end, int threads) {
    ceres::Solver::Options options;
    configure(options);
    options.max_num_iterations = iterations;
    options.num_threads = threads;
    options.logging_type = ceres::SILENT;
    options.function_tolerance = to_end ? 1e-9 : 0.0;
    if (!to_end) options.gradient_tolerance = options.parameter_tolerance = 0.0;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    return summary;
  }

  virtual void answer(Answer& out) const = 0;
  virtual const char* settings() const = 0;

 protected:
  virtual void configure(ceres::Solver::Options& options) const = 0;
  void remember(std::vector<double>& state) {
    state_ = &state;
    start_ = state;
  }

  ceres::Problem problem_;

 private:
  std::vector<double>* state_ = nullptr;
  std::vector<double> start_;
};
