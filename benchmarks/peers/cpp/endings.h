// What a C++ program does for the suite `optimum`, as ../endings.py does it for Python:
//
//     PROGRAM optimum SUITE PROBLEM WAY RUNS LIMIT OUT
//
// solves a problem from its start to the system's own end in one way, writes the answer and prints
// one JSON object.
#pragma once

#include <chrono>
#include <ctime>
#include <string>

#include "columns.h"

// What a run has recorded: a cost an iteration, with attempts and seconds of the processor so far.
struct Path {
  std::vector<double> costs, times;
  std::vector<int> counts;
  double began = seconds();

  static double seconds() {
    timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return now.tv_sec + 1e-9 * now.tv_nsec;
  }

  void mark(double cost, int attempts) { mark(cost, attempts, seconds() - began); }
  void mark(double cost, int attempts, double time) {
    costs.push_back(cost), counts.push_back(attempts), times.push_back(time);
  }
};

namespace endings {

// As in ../endings.py: when no further run is begun.
constexpr double kBudget = 0.4, kLong = 0.5;

template <typename T>
std::string list(const std::vector<T>& values) {
  std::ostringstream out;
  out.precision(17);
  out << '[';
  for (size_t k = 0; k < values.size(); ++k) {
    // JSON has no infinity.
    const bool finite = values[k] - values[k] == T(0);
    out << (k ? ", " : "");
    finite ? out << values[k] : out << 1e300;
  }
  out << ']';
  return out.str();
}

template <typename Loader>
int run(char** words, const char* version, Loader load) {
  const double loading = Path::seconds();
  const Columns data(words[3]);
  const auto system = load(words[2], data, 1);
  const double setup = Path::seconds() - loading;
  const int runs = std::atoi(words[5]), limit = std::atoi(words[6]);
  std::ostringstream timed;
  timed.precision(9);
  std::string status;
  Path path;
  double spent = 0.0;
  bool any = false;
  for (int k = 0; k <= runs && !(k > 1 && spent > kBudget); ++k) {
    using std::chrono::steady_clock;
    system->fresh();
    const auto wall = steady_clock::now();
    path = Path();
    status = system->solve(words[4], path, limit);
    const double cpu = Path::seconds() - path.began;
    const std::chrono::duration<double> passed = steady_clock::now() - wall;
    spent += cpu;
    if (k > 0 || cpu > kLong) {
      timed << (any ? ", " : "") << "{\"cpu\": " << cpu << ", \"wall\": " << passed.count()
            << ", \"times\": " << list(path.times) << '}';
      any = true;
    }
  }
  Answer answer;
  system->answer(answer);
  answer.write(words[7]);
  std::printf(
      "{\"status\": \"%s\", \"attempts\": %d, \"cost\": %.17g, \"costs\": %s, \"counts\": %s, "
      "\"runs\": [%s], \"version\": \"%s\", \"setup\": %g}\n",
      status.c_str(), path.counts.back(), path.costs.back(), list(path.costs).c_str(),
      list(path.counts).c_str(), timed.str().c_str(), version, setup);
  return 0;
}

}  // namespace endings
