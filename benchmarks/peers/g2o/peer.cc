// g2o from the libraries in its wheel, for problems that it has no edges for with the residuals of
// the models (../cpp/harness.h says how it is called and what it prints).

#include "bundle.h"
#include "plane.h"

namespace {

std::unique_ptr<System> load(const std::string& suite, const Columns& data, int) {
  if (suite == "bundle") return std::make_unique<Bundle>(data);
  if (suite == "plane") return std::make_unique<PlaneMap>(data);
  fail("no suite " + suite);
}

}  // namespace

int main(int count, char** words) { return harness::run(count, words, "g2o (C++)", load); }
