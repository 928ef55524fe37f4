#pragma once

// What tests of probing share.

#include <gtest/gtest.h>

#include <functional>
#include <utility>
#include <vector>

#include "lode/api/tetra_dataset.h"

namespace lode::test {

inline void set_field(TetraMesh& mesh, const std::function<double(const Vec3d&)>& field) {
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    mesh.fields[0].values[v] = field(mesh.positions[v]);
}

inline TetraDataset built(const TetraMesh& mesh, const TetraBuildOptions& options = {}) {
  Progress progress;
  auto dataset = TetraDataset::build(mesh, options, progress);
  EXPECT_TRUE(dataset) << dataset.error().message;
  return std::move(*dataset);
}

inline std::vector<ProbedPoint> probed(const TetraDataset& dataset,
                                       const std::vector<Vec3d>& points, double max_error,
                                       int threads = 2) {
  Progress progress;
  std::vector<ProbedPoint> found;
  const auto report =
      dataset.probe(points, {.max_error = max_error, .threads = {threads}}, found, progress);
  EXPECT_TRUE(report) << report.error().message;
  EXPECT_EQ(found.size(), points.size());
  EXPECT_LE(report->achieved_error, max_error);
  return found;
}

inline IntegralReport integral_of(const TetraDataset& dataset, const IntegralOptions& options) {
  Progress progress;
  auto report = dataset.integrate(options, progress);
  EXPECT_TRUE(report) << report.error().message;
  return *report;
}

inline void expect_holds(const BoundedNumber& number, double truth, double rounding,
                         const char* what) {
  EXPECT_LE(number.low, number.value) << what;
  EXPECT_LE(number.value, number.high) << what;
  EXPECT_LE(number.low, truth + rounding) << what;
  EXPECT_GE(number.high, truth - rounding) << what;
}

}  // namespace lode::test
