#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "lode/io/height_reader.h"

namespace lode::io::test {

/// A directory that is gone when the test is.
class HeightReading : public testing::Test {
 protected:
  HeightReading() {
    std::string name = testing::TempDir() + "/lode_heights_XXXXXX";
    directory_ = mkdtemp(name.data());
  }
  ~HeightReading() override { std::filesystem::remove_all(directory_); }

  [[nodiscard]] std::string operator()(const std::string& name) const {
    return (directory_ / name).string();
  }
  static HeightRaster read(const std::string& path, const HeightReadOptions& options = {}) {
    Progress progress;
    auto raster = read_heights(path, options, progress);
    if (!raster) ADD_FAILURE() << raster.error().message;
    return raster ? std::move(raster).value() : HeightRaster{};
  }
  static std::string refusal(const std::string& path, const HeightReadOptions& options = {}) {
    Progress progress;
    const auto raster = read_heights(path, options, progress);
    EXPECT_FALSE(raster) << path;
    if (raster) return "";
    EXPECT_TRUE(raster.error().message.starts_with(path)) << raster.error().message;
    EXPECT_EQ(raster.error().message.find('\n'), std::string::npos) << raster.error().message;
    return raster.error().message;
  }
  static void expect_samples(const HeightGrid& grid, const std::vector<double>& samples) {
    for (std::int32_t y = 0; y < grid.n_rows; ++y)
      for (std::int32_t x = 0; x < grid.n_columns; ++x)
        if (grid.has_height(x, y))
          EXPECT_EQ(grid.height(x, y), samples[static_cast<std::size_t>(y * grid.n_columns + x)])
              << x << ", " << y;
  }

  std::filesystem::path directory_;
};

/// 12 of them, from -7 up.
inline std::vector<double> twelve(double step) {
  std::vector<double> samples;
  for (int i = 0; i < 12; ++i) samples.push_back(step * i - 7);
  return samples;
}

}  // namespace lode::io::test
