#pragma once

#include <gtest/gtest.h>

#include <string>

#include "lode/api/dataset_impl.h"

namespace lode::test {

struct StoredExtract {
  ExtractReport report;
  Surface surface;
};

/// From a file: in memory, or, limited, chunk by chunk, as the memory limit does not let it in.
inline void extract_stored(const std::string& lode, ExtractOptions options, bool is_limited,
                           StoredExtract& result) {
  const auto dataset = Dataset::open(lode, options.threads);
  ASSERT_TRUE(dataset);
  Progress progress;
  if (is_limited) {
    options.memory_limit = dataset->impl().chunk_bytes();
    // Room for regions that do not persist.
    if (options.keep_topology.value_or(0) > 0)
      options.memory_limit = dataset->impl().model_bytes() - 1;
    ASSERT_LT(options.memory_limit, dataset->impl().model_bytes());
    ASSERT_TRUE(dataset->comes_in_pieces(options, progress).value());
  } else {
    ASSERT_TRUE(dataset->impl().model(progress));
  }
  const auto report = dataset->extract(options, result.surface, progress);
  ASSERT_TRUE(report) << report.error().message;
  result.report = *report;
  EXPECT_EQ(dataset->impl().is_in_file(), is_limited);
}

}  // namespace lode::test
