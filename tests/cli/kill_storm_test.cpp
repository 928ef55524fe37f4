#include <cstdlib>

#include "tests/cli/kill_storm.h"

namespace lode::test {
namespace {

/// LODE_KILLS says how many, where 200 are not enough.
TEST(cli_resume, survives_a_storm_of_kills) {
  const char* wanted = std::getenv("LODE_KILLS");
  KillStorm().run(wanted != nullptr ? std::atoi(wanted) : 200, 4);
}

}  // namespace
}  // namespace lode::test
