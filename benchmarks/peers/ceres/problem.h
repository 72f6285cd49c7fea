// A problem in Ceres, with its start.
#pragma once

#include <ceres/ceres.h>

#include "../cpp/harness.h"

class Problem : public System {
 public:
  int threads = 1;

  void restart() override { *state_ = start_; }

  int iterate(int count, bool to_end) override {
    ceres::Solver::Options options;
    configure(options);
    options.max_num_iterations = count;
    options.num_threads = threads;
    options.logging_type = ceres::SILENT;
    options.function_tolerance = to_end ? 1e-9 : 0.0;
    if (!to_end) options.gradient_tolerance = options.parameter_tolerance = 0.0;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    // The first entry is the start.
    return summary.num_successful_steps + summary.num_unsuccessful_steps - 1;
  }

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
