#pragma once

#include <cstdlib>
#include <filesystem>

namespace lode::bench {

/// Where the data sets are: LODE_DATA, or beside the checkout.
[[nodiscard]] inline std::filesystem::path data_directory() {
  const char* from_environment = std::getenv("LODE_DATA");
  return from_environment != nullptr ? from_environment : LODE_DEFAULT_DATA;
}

}  // namespace lode::bench
