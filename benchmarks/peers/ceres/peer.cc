// Ceres from the system, for problems that pyceres has no compiled cost functions for:
//
//     peer SUITE PROBLEM SHORT LONG RUNS THREADS LIMIT OUT
//
// prints one JSON object, like every system of the benchmarks (see ../runner.py).

#include <chrono>
#include <memory>

#include "bundle.h"
#include "plane.h"
#include "pose_graph.h"

namespace {

// As in ../runner.py: when no further slope is begun.
constexpr double kBudget = 6.0, kBrief = 1.0;
constexpr int kLeast = 3, kMost = 51;

double now() {
  using std::chrono::duration;
  using std::chrono::steady_clock;
  return duration<double>(steady_clock::now().time_since_epoch()).count();
}

double peak_megabytes() {
  std::ifstream file("/proc/self/status");
  for (std::string line; std::getline(file, line);) {
    if (line.rfind("VmHWM:", 0) == 0) return std::atof(line.c_str() + 6) / 1024;
  }
  return 0.0;
}

std::unique_ptr<Problem> load(const std::string& suite, const Columns& data) {
  if (suite == "pose_graph" && data.has("poses.th")) return std::make_unique<PlanarGraph>(data);
  if (suite == "bundle") return std::make_unique<Bundle>(data);
  if (suite == "plane") return std::make_unique<PlaneMap>(data);
  fail("no suite " + suite);
}

}  // namespace

int main(int count, char** words) {
  if (count != 9) fail("peer SUITE PROBLEM SHORT LONG RUNS THREADS LIMIT OUT");
  google::InitGoogleLogging(words[0]);
  const Columns data(words[2]);
  const int from = std::atoi(words[3]), to = std::atoi(words[4]), runs = std::atoi(words[5]);
  const int threads = std::atoi(words[6]), limit = std::atoi(words[7]);
  const auto problem = load(words[1], data);
  const auto timed = [&](int iterations) {
    problem->restart();
    const double began = now();
    const auto summary = problem->solve(iterations, false, threads);
    // The first entry of both is the start.
    return std::make_pair(now() - began,
                          summary.num_successful_steps + summary.num_unsuccessful_steps - 1);
  };

  timed(from);
  std::ostringstream slopes;
  size_t found = 0;
  const double began = now();
  for (int done = 0; done < kMost; ++done) {
    const double spent = now() - began;
    if (spent > kBrief && (done >= runs || (done >= kLeast && spent > kBudget))) break;
    const auto [a, n] = timed(from);
    const auto [b, m] = timed(to);
    if (m > n) slopes << (found++ ? ", " : "") << (b - a) / (m - n);
  }
  problem->restart();
  const auto summary = problem->solve(limit, true, threads);
  Answer answer;
  problem->answer(answer);
  answer.write(words[8]);
  std::printf(
      "{\"slopes\": [%s], \"iterations\": %d, \"memory\": %.1f, \"version\": \"Ceres %s (C++)\", "
      "\"plan\": \"%s\"}\n",
      slopes.str().c_str(), summary.num_successful_steps + summary.num_unsuccessful_steps - 1,
      peak_megabytes(), CERES_VERSION_STRING, problem->settings());
  return 0;
}
