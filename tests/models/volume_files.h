#pragma once

#include <gtest/gtest.h>

#include <string>

#include "lode/api/file_build.h"
#include "tests/store/test_file.h"

namespace lode::test {

/// The .lode file of a volume; its path.
inline std::string stored(const store::TestPath& path, const Volume& volume) {
  Progress progress;
  const auto source = make_memory_source(volume);
  const auto built = build_file(*source, path.str(), {}, progress);
  EXPECT_TRUE(built) << (built ? "" : built.error().message);
  return path.str();
}

}  // namespace lode::test
