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

  // Tolerances are the defaults (1e-6 of the cost, 1e-10 gradient, 1e-8 parameters), and so is the
  // first radius of the trust region.
  std::string solve(const std::string& way, Path& path, int limit) override {
    ceres::Solver::Options options;
    configure(options);
    options.initial_trust_region_radius = ceres::Solver::Options().initial_trust_region_radius;
    options.max_num_iterations = limit;
    options.num_threads = threads;
    options.logging_type = ceres::SILENT;
    if (way.find("dogleg") != std::string::npos) {
      options.trust_region_strategy_type = ceres::DOGLEG;
      if (way.find("subspace") != std::string::npos) {
        options.dogleg_type = ceres::SUBSPACE_DOGLEG;
      }
    }
    options.use_nonmonotonic_steps = way.find("non-monotone") != std::string::npos;
    Record record(path);
    options.callbacks.push_back(&record);
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    // Without monotonicity the least cost is what is kept.
    path.mark(summary.final_cost, path.counts.back());
    return ceres::TerminationTypeToString(summary.termination_type);
  }

 protected:
  // Every iteration of Ceres is one attempt; the first call is at the start.
  struct Record : ceres::IterationCallback {
    explicit Record(Path& path) : path(path) {}
    ceres::CallbackReturnType operator()(const ceres::IterationSummary& now) override {
      path.mark(now.cost, now.iteration);
      return ceres::SOLVER_CONTINUE;
    }
    Path& path;
  };

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
