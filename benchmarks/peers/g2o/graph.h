// A problem in g2o: Levenberg-Marquardt on a graph of our own vertices and edges.
#pragma once

#include <g2o/core/auto_differentiation.h>
#include <g2o/core/base_binary_edge.h>
#include <g2o/core/base_unary_edge.h>
#include <g2o/core/base_vertex.h>
#include <g2o/core/block_solver.h>
#include <g2o/core/hyper_graph_action.h>
#include <g2o/core/optimization_algorithm_dogleg.h>
#include <g2o/core/optimization_algorithm_gauss_newton.h>
#include <g2o/core/optimization_algorithm_levenberg.h>
#include <g2o/core/sparse_optimizer.h>
#include <g2o/core/sparse_optimizer_terminate_action.h>
#include <g2o/solvers/eigen/linear_solver_eigen.h>

#include "../cpp/harness.h"

// A vertex that steps are added to.
template <int N>
class Plain : public g2o::BaseVertex<Plain<N>, N, Eigen::Matrix<double, N, 1>> {
 public:
  void oplusImpl(const g2o::VectorX::MapType& step) { this->estimate_ += step; }
};

// After each iteration: counts the attempts at a step in it, and ends the run where the cost no
// longer falls.
class Watch : public g2o::HyperGraphAction {
 public:
  Watch(const g2o::SparseOptimizer& optimizer, const g2o::OptimizationAlgorithmLevenberg& algorithm)
      : optimizer_(optimizer), algorithm_(algorithm) {}

  void begin(bool to_end) {
    stop = false, to_end_ = to_end, attempts = 0, last_ = -1.0;
  }

  bool operator()(const g2o::HyperGraph&, Parameters&) override {
    attempts += algorithm_.levenbergIteration();
    if (!to_end_) return true;
    const double cost = optimizer_.activeRobustChi2();
    if (last_ >= cost && last_ - cost <= 1e-9 * last_) stop = true;
    last_ = cost;
    return true;
  }

  bool stop = false;
  int attempts = 0;

 private:
  const g2o::SparseOptimizer& optimizer_;
  const g2o::OptimizationAlgorithmLevenberg& algorithm_;
  bool to_end_ = false;
  double last_ = -1.0;
};

// After each iteration: records the cost and the attempts until then.
class Recorder : public g2o::HyperGraphAction {
 public:
  Recorder(const g2o::SparseOptimizer& optimizer, Path& path,
           const g2o::OptimizationAlgorithmLevenberg* levenberg)
      : optimizer_(optimizer), path_(path), levenberg_(levenberg) {}

  bool operator()(const g2o::HyperGraph&, Parameters& now) override {
    // Called once before the first iteration, too.
    if (static_cast<ParametersIteration&>(now).iteration < 0) return true;
    attempts_ += levenberg_ ? levenberg_->levenbergIteration() : 1;
    path_.mark(optimizer_.activeRobustChi2(), attempts_);
    return true;
  }

 private:
  const g2o::SparseOptimizer& optimizer_;
  Path& path_;
  const g2o::OptimizationAlgorithmLevenberg* levenberg_;
  int attempts_ = 0;
};

class Graph : public System {
 public:
  void fresh() override {
    for (const auto& back : start_) back();
  }

  std::string solve(const std::string& way, Path& path, int limit) override {
    std::shared_ptr<g2o::OptimizationAlgorithm> algorithm;
    const g2o::OptimizationAlgorithmLevenberg* levenberg = nullptr;
    if (way == "GN") {
      algorithm = std::make_shared<g2o::OptimizationAlgorithmGaussNewton>(solver_());
    } else if (way == "dogleg") {
      algorithm = std::make_shared<g2o::OptimizationAlgorithmDogleg>(solver_());
    } else {
      auto made = std::make_shared<g2o::OptimizationAlgorithmLevenberg>(solver_());
      levenberg = made.get();
      algorithm = made;
    }
    optimizer_.removePostIterationAction(watch_);
    optimizer_.setForceStopFlag(nullptr);
    optimizer_.setAlgorithm(algorithm);
    auto ending = std::make_shared<g2o::SparseOptimizerTerminateAction>();
    ending->setMaxIterations(limit);
    auto recorder = std::make_shared<Recorder>(optimizer_, path, levenberg);
    // The ending computes the errors that are recorded.
    optimizer_.addPostIterationAction(ending);
    optimizer_.addPostIterationAction(recorder);
    optimizer_.initializeOptimization();
    optimizer_.computeActiveErrors();
    path.mark(optimizer_.activeRobustChi2(), 0);
    const int done = optimizer_.optimize(limit);
    optimizer_.removePostIterationAction(ending);
    optimizer_.removePostIterationAction(recorder);
    optimizer_.setForceStopFlag(nullptr);
    if (done >= limit) return "limit of iterations";
    return "ended after " + std::to_string(done) + " iterations";
  }

  void restart() override {
    for (const auto& back : start_) back();
    optimizer_.initializeOptimization();
  }

  int iterate(int count, bool to_end) override {
    watch_->begin(to_end);
    optimizer_.optimize(count);
    return watch_->attempts;
  }

 protected:
  template <typename Solver>
  void use() {
    solver_ = [] {
      auto inner = std::make_unique<g2o::LinearSolverEigen<typename Solver::PoseMatrixType>>();
      inner->setBlockOrdering(true);
      return std::make_unique<Solver>(std::move(inner));
    };
    auto algorithm = std::make_shared<g2o::OptimizationAlgorithmLevenberg>(solver_());
    watch_ = std::make_shared<Watch>(optimizer_, *algorithm);
    optimizer_.setAlgorithm(algorithm);
    optimizer_.addPostIterationAction(watch_);
    optimizer_.setForceStopFlag(&watch_->stop);
  }

  template <typename Vertex, typename Estimate>
  std::shared_ptr<Vertex> vertex(const Estimate& start, bool eliminated) {
    auto made = std::make_shared<Vertex>();
    made->setId(next_++);
    made->setMarginalized(eliminated);
    made->setEstimate(start);
    optimizer_.addVertex(made);
    start_.push_back([made, start] { made->setEstimate(start); });
    return made;
  }

  // Residuals come weighted.
  template <typename Edge, typename... Vertices>
  void edge(std::shared_ptr<Edge> made, const Vertices&... ends) {
    int at = 0;
    (made->setVertex(at++, ends), ...);
    made->setInformation(Edge::InformationType::Identity());
    optimizer_.addEdge(made);
  }

 private:
  g2o::SparseOptimizer optimizer_;
  std::shared_ptr<Watch> watch_;
  std::function<std::unique_ptr<g2o::BlockSolverBase>()> solver_;
  std::vector<std::function<void()>> start_;
  int next_ = 0;
};
