#include "lode/api/tin_samples.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <vector>

namespace lode {
namespace {

double rounded_to(io::RasterType type, double z) {
  return type == io::RasterType::float32 ? static_cast<double>(static_cast<float>(z)) : z;
}

double beside(io::RasterType type, double z, double towards) {
  return type == io::RasterType::float32 ? static_cast<double>(std::nextafter(
                                               static_cast<float>(z), static_cast<float>(towards)))
                                         : std::nextafter(z, towards);
}

/// The value of a type nearest to z that is at most `limit` from `middle`, or else the nearest of
/// all. z is not beyond it by more than rounding.
double rounded_within(io::RasterType type, double z, double middle, double limit) {
  const double nearest = rounded_to(type, z);
  if (std::abs(nearest - middle) <= limit) return nearest;
  const bool is_above = nearest > middle;
  double edge = rounded_to(type, is_above ? middle + limit : middle - limit);
  const double inwards =
      is_above ? -std::numeric_limits<double>::infinity() : std::numeric_limits<double>::infinity();
  for (int i = 0; i < 2 && std::abs(edge - middle) > limit; ++i) edge = beside(type, edge, inwards);
  return std::abs(edge - middle) <= limit ? edge : nearest;
}

void join(TinSampleFacts& all, const TinSampleFacts& one) {
  all.n_heights += one.n_heights;
  all.error = std::max(all.error, one.error);
  all.rounding = std::max(all.rounding, one.rounding);
  all.meets_value = all.meets_value || one.meets_value;
}

}  // namespace

double StoredHeights::stored(io::RasterType type, double z, double sample) const {
  if (std::abs(z - sample) > limit_ + tin_.rounding()) return rounded_to(type, z);
  return rounded_within(type, z, sample, limit_);
}

TinSampleFacts StoredHeights::store(std::int32_t strip, io::RasterType type, double looked_for,
                                    std::span<double> heights) const {
  TinSampleFacts facts;
  tin_.fill(strip, heights);
  const std::int32_t first = TinRaster::first_row(strip);
  const std::size_t n_columns = heights.size() / static_cast<std::size_t>(tin_.n_rows(strip));
  for (std::size_t i = 0; i < heights.size(); ++i) {
    double& z = heights[i];
    if (std::isnan(z)) continue;
    const double plane = z;
    if (samples_ != nullptr) {
      const double sample = samples_->height(static_cast<std::int32_t>(i % n_columns),
                                             first + static_cast<std::int32_t>(i / n_columns));
      z = stored(type, plane, sample);
      facts.error = std::max(facts.error, std::abs(z - sample));
    } else {
      z = rounded_to(type, plane);
    }
    ++facts.n_heights;
    facts.rounding = std::max(facts.rounding, std::abs(z - plane));
    facts.meets_value = facts.meets_value || z == looked_for;
  }
  return facts;
}

void StoredHeights::fill(std::int32_t strip, io::RasterType type, std::span<double> heights) const {
  (void)store(strip, type, std::numeric_limits<double>::quiet_NaN(), heights);
}

void StoredHeights::subtract_samples(std::int32_t strip, io::RasterType type,
                                     std::span<const double> heights,
                                     std::span<double> differences) const {
  const std::int32_t first = TinRaster::first_row(strip);
  const std::size_t n_columns = heights.size() / static_cast<std::size_t>(tin_.n_rows(strip));
  for (std::size_t i = 0; i < heights.size(); ++i) {
    differences[i] = heights[i];
    if (std::isnan(heights[i])) continue;
    const double sample = samples_->height(static_cast<std::int32_t>(i % n_columns),
                                           first + static_cast<std::int32_t>(i / n_columns));
    differences[i] = rounded_within(type, heights[i] - sample, 0, limit_);
  }
}

Result<TinSampleFacts> StoredHeights::measure(io::RasterType type, double looked_for,
                                              Threads threads, Progress& progress) const {
  const auto n = static_cast<std::size_t>(tin_.n_strips());
  std::vector<TinSampleFacts> of_strip(n);
  std::vector<std::vector<double>> scratch(static_cast<std::size_t>(n_workers(threads)));
  std::atomic<std::size_t> n_done{0};
  parallel_for(n, threads, 1, [&](std::size_t i, int worker) {
    if (progress.is_cancelled()) return;
    const auto strip = static_cast<std::int32_t>(i);
    std::vector<double>& heights = scratch[static_cast<std::size_t>(worker)];
    heights.resize(tin_.n_nodes(strip));
    of_strip[i] = store(strip, type, looked_for, heights);
    progress.report("measuring", static_cast<double>(++n_done) / static_cast<double>(n));
  });
  if (progress.is_cancelled()) return cancelled_error();
  TinSampleFacts all;
  for (const TinSampleFacts& one : of_strip) join(all, one);
  return all;
}

}  // namespace lode
