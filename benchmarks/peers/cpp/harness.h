// What every C++ program of the benchmarks does, as ../runner.py does it for Python:
//
//     PROGRAM SUITE PROBLEM SHORT LONG RUNS THREADS LIMIT OUT
//
// times a problem from its start by slopes between runs of SHORT and LONG iterations, writes the
// answer after at most LIMIT iterations, and prints one JSON object.
#pragma once

#include <algorithm>
#include <chrono>
#include <memory>

#include "columns.h"
#include "endings.h"

class System {
 public:
  virtual ~System() = default;

  virtual void restart() = 0;
  // Iterates at most `count` times, all of them unless `to_end`; returns the attempts at a step.
  virtual int iterate(int count, bool to_end) = 0;
  virtual void answer(Answer& out) const = 0;
  virtual const char* settings() const = 0;
  // For the suite `optimum`: back to the start, and to the system's own end in one way; returns its
  // words on it.
  virtual void fresh() { restart(); }
  virtual std::string solve(const std::string& way, Path& path, int limit) = 0;
};

namespace harness {

// As in ../runner.py: when no further slope is begun.
constexpr double kBudget = 6.0, kBrief = 1.0;
constexpr int kLeast = 3, kMost = 51;

inline double now() {
  using std::chrono::duration;
  using std::chrono::steady_clock;
  return duration<double>(steady_clock::now().time_since_epoch()).count();
}

inline double peak_megabytes() {
  std::ifstream file("/proc/self/status");
  for (std::string line; std::getline(file, line);) {
    if (line.rfind("VmHWM:", 0) == 0) return std::atof(line.c_str() + 6) / 1024;
  }
  return 0.0;
}

using Loader = std::unique_ptr<System> (*)(const std::string& suite, const Columns&, int threads);

inline int run(int count, char** words, const char* version, Loader load) {
  if (count == 8) return endings::run(words, version, load);
  if (count != 9) fail("expected SUITE PROBLEM SHORT LONG RUNS THREADS LIMIT OUT");
  const Columns data(words[2]);
  const int from = std::atoi(words[3]), to = std::atoi(words[4]), runs = std::atoi(words[5]);
  const int threads = std::atoi(words[6]), limit = std::atoi(words[7]);
  const auto system = load(words[1], data, threads);
  const auto timed = [&](int iterations) {
    system->restart();
    const double began = now();
    const int attempts = system->iterate(iterations, false);
    return std::make_pair(now() - began, attempts);
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
  const double memory = peak_megabytes();
  system->restart();
  const int attempts = system->iterate(limit, true);
  Answer answer;
  system->answer(answer);
  answer.write(words[8]);
  std::printf(
      "{\"slopes\": [%s], \"iterations\": %d, \"memory\": %.1f, \"version\": \"%s\", "
      "\"plan\": \"%s\"}\n",
      slopes.str().c_str(), attempts, memory, version, system->settings());
  return 0;
}

}  // namespace harness
