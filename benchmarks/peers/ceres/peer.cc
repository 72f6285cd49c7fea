// Ceres from the system, for problems that pyceres has no compiled cost functions for
// (../cpp/harness.h says how it is called and what it prints).

#include "bundle.h"
#include "plane.h"
#include "pose_graph.h"

namespace {

std::unique_ptr<System> load(const std::string& suite, const Columns& data, int threads) {
  std::unique_ptr<Problem> found;
  if (suite == "pose_graph" && data.has("poses.th")) found = std::make_unique<PlanarGraph>(data);
  if (suite == "pose_graph" && data.has("poses.q")) found = std::make_unique<SpatialGraph>(data);
  if (suite == "bundle") found = std::make_unique<Bundle>(data);
  if (suite == "plane") found = std::make_unique<PlaneMap>(data);
  if (!found) fail("no suite " + suite);
  found->threads = threads;
  return found;
}

}  // namespace

int main(int count, char** words) {
  google::InitGoogleLogging(words[0]);
  return harness::run(count, words, "Ceres " CERES_VERSION_STRING " (C++)", load);
}
