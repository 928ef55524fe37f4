#include "bench/papers/growth.h"

#include <array>
#include <cmath>
#include <limits>

#include "bench/papers/live_run.h"
#include "bench/timing.h"
#include "lode/models/diamond/build.h"

namespace lode::bench {
namespace {

using oracles::Field;

Result<diamond::Model<3>> build_field(Field field, std::int32_t n) {
  const Volume volume = oracles::sample(field, n);
  const auto source = make_memory_source(volume);
  Progress progress;
  return diamond::build<3>(*source, {.threads = {2}}, progress);
}

std::vector<Table::Column> columns() {
  return {{"data", "data set"},
          {"contour", "contour"},
          {"samples", "n"},
          {"isovalue", "isovalue"},
          {"triangles", "k"},
          {"applied", "nodes refined"},
          {"visited", "looked at"},
          {"applied_by_k", "refined / k"},
          {"applied_by_k_log_n", "refined / (k log n)"},
          {"visited_by_k_log_n", "looked at / (k log n)"},
          {"live_ms", "time, ms"},
          {"live_ns_by_k", "ns / k"},
          {"one_shot_ms", "one-shot, ms"}};
}

void add_row(Table& table, Field field, const std::string& contour, const diamond::Model<3>& model,
             double isovalue) {
  LiveRun run;
  Surface surface;
  const std::array<TimedWork, 2> works = {
      [&] {
        run = run_live(model, {.isovalue = isovalue});
        return run.seconds;
      },
      [&] { return run_one_shot(model, isovalue, 0, surface); }};
  const auto seconds = run_in_turns(works);
  const double live = median(seconds[0]), one_shot = median(seconds[1]);
  const auto n = static_cast<double>(model.info.grid.n_samples());
  const auto k = static_cast<double>(run.n_triangles);
  const auto applied = static_cast<double>(run.n_applied);
  const auto visited = static_cast<double>(run.n_visited);
  table.rows.push_back(
      {fmt::format("{} {}³", oracles::name_of(field), model.info.grid.dims[0]), contour,
       fmt::format("{}", model.info.grid.n_samples()), fmt::format("{:.6g}", isovalue),
       fmt::format("{}", run.n_triangles), fmt::format("{}", run.n_applied),
       fmt::format("{}", run.n_visited), fmt::format("{:.3f}", applied / k),
       fmt::format("{:.4f}", applied / (k * std::log2(n))),
       fmt::format("{:.4f}", visited / (k * std::log2(n))), fmt::format("{:.3f}", live * 1e3),
       fmt::format("{:.0f}", live * 1e9 / k), fmt::format("{:.3f}", one_shot * 1e3)});
}

/// From the smallest contour to one that fills the volume. The sphere's radii are odd quarters of
/// an interval, so that none of its vertices is a sample.
std::vector<double> isovalues_at_257(Field field) {
  if (field == Field::gaussians40) return {3.03, 3.0, 2.9, 2.7, 2.4, 2.0, 1.6, 1.2, 0.8, 0.5, 0.3};
  std::vector<double> isovalues;
  for (const double radius : {1.25, 2.75, 5.25, 10.25, 20.25, 40.25, 80.25, 120.25})
    isovalues.push_back(radius / 128);
  return isovalues;
}

/// The mean along the axes, three and four samples away, round the field's extremum: a contour of
/// the same few triangles at any resolution.
double small_isovalue(Field field, const diamond::Model<3>& model) {
  const Index3 dims = model.info.grid.dims;
  Index3 centre;
  double best = -std::numeric_limits<double>::infinity();
  for (std::int32_t z = 0; z < dims[2]; ++z)
    for (std::int32_t y = 0; y < dims[1]; ++y)
      for (std::int32_t x = 0; x < dims[0]; ++x) {
        const double value = model.value({{x, y, z}});
        const double rank = field == Field::sphere ? -value : value;
        if (rank > best) {
          best = rank;
          centre = {{x, y, z}};
        }
      }
  double sum = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const std::int32_t step : {-4, -3, 3, 4}) {
      Index3 p = centre;
      p[axis] += step;
      sum += model.value(p);
    }
  return sum / 12;
}

}  // namespace

Growth::Growth()
    : by_output_{"growth_by_output",
                 "Theorems 4.1 and 4.2: nodes and time against the output's size k",
                 columns(),
                 {}},
      by_data_{"growth_by_data",
               "Theorem 4.3: nodes and time against the data's size n",
               columns(),
               {}} {}

Result<void> Growth::add_contours(Field field) {
  LODE_TRY(const auto model, build_field(field, 257));
  for (const double isovalue : isovalues_at_257(field))
    add_row(by_output_, field, "any", model, isovalue);
  return {};
}

Result<void> Growth::add_sizes(Field field, std::int32_t largest) {
  for (std::int32_t n = 33; n <= largest; n = 2 * n - 1) {
    LODE_TRY(const auto model, build_field(field, n));
    add_row(by_data_, field, "large", model, oracles::usual_isovalue(field));
    add_row(by_data_, field, "small", model, small_isovalue(field, model));
  }
  return {};
}

}  // namespace lode::bench
