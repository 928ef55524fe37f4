// With a persistence the topology kept is that of a field so near, found here by brute force.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "lode/models/diamond/critical_nodes.h"
#include "lode/models/diamond/refinable.h"
#include "tests/models/kept_surfaces.h"
#include "tests/models/turned_regions.h"
#include "tests/oracles/trials.h"

namespace lode {
namespace {

using namespace test;

/// The volume, with values on the other side of the isovalue where the cut that has the nodes, and
/// those beyond the tolerance, leaves out nodes whose samples may be on the side that it has in
/// their place: by brute force, without bricks.
Volume relaxed(const diamond::Model<3>& model, const Volume& volume, const ExtractOptions& options,
               const diamond::NodeSet<3>& wanted) {
  const double c = options.isovalues.front();
  const double persistence = *options.keep_topology;
  const Index3& dims = volume.info.grid.dims;
  const diamond::Refinable<3> nodes(model);
  const auto is_refined = [&](const diamond::Diamond<3>& node) {
    const auto facts = nodes.facts_at(node);
    const bool is_active = facts.range.low < c && facts.range.high >= c;
    return *options.max_error == 0 || wanted.contains(node.centre) ||
           model.shape.reaches_across(node.centre, node.level) ||
           (static_cast<double>(facts.error) > *options.max_error &&
            (is_active || node.level == 0));
  };
  const auto as_float = [](double value, double limit) {
    const auto f = static_cast<float>(value);
    return static_cast<double>(f) < value ? std::nextafter(f, static_cast<float>(limit)) : f;
  };
  const float inside = as_float(c, 1e30);
  const float outside = std::nextafter(inside, -1e30F);
  Volume result = volume;
  const auto samples = oracles::typed_samples<float>(result);
  std::vector<double> values(samples.size());
  const auto at = [&](const Index3& p) { return diamond::linear_index<3>(dims, p); };
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<double>(samples[i]) - c;
  for (int level = model.shape.n_levels - 1; level >= 0; --level)
    for (std::size_t i = 0; i < values.size(); ++i) {
      const Index3 p = diamond::point_of<3>(dims, i);
      if (diamond::common_exponent<3>(p) != level) continue;
      const auto node = diamond::diamond_at<3>(p);
      const auto ends = diamond::axis_ends<3>(node);
      if (!model.shape.is_sample(ends[0]) || !model.shape.is_sample(ends[1])) continue;
      const double mean = 0.5 * (values[at(ends[0])] + values[at(ends[1])]);
      const auto sample = static_cast<double>(samples[i]);
      const bool may_be = mean >= 0 ? sample >= c - persistence : sample < c + persistence;
      if (std::isnan(mean) || std::isnan(values[i]) || !may_be || is_refined(node)) continue;
      values[i] = mean;
      if ((mean >= 0) == (sample >= c)) continue;
      samples[i] = mean >= 0 ? inside : outside;
      EXPECT_LE(std::abs(static_cast<double>(samples[i]) - sample), persistence * (1 + 1e-6));
    }
  return result;
}

/// Of a field that is nowhere farther than the persistence from the samples, and all of whose
/// regions have a sample farther from the isovalue.
void expect_topology_of_relaxed(const Volume& volume, const ExtractOptions& options) {
  const Dataset dataset = built_in_memory(volume);
  Progress progress;
  const auto& model = std::get<diamond::Model<3>>(**dataset.impl().model(progress));
  const double c = options.isovalues.front();
  const auto nodes = diamond::find_critical_nodes(model,
                                                  {.isovalue = c,
                                                   .persistence = *options.keep_topology,
                                                   .threads = {2},
                                                   .tolerance = *options.max_error},
                                                  progress);
  ASSERT_TRUE(nodes);
  const Volume other = without_weak_regions(relaxed(model, volume, options, nodes->nodes), volume,
                                            c, *options.keep_topology);
  const Surface kept = surface_of(dataset, c, options.max_error, options.keep_topology);
  const Surface full = surface_of(built_in_memory(other), c, 0.0, kNotKept);
  if (model.has_holes()) {  // pinched vertices come twice
    const auto expected = check_topology(full, {});
    const auto got = check_topology(kept, {});
    EXPECT_EQ(got.components.size(), expected.components.size());
    EXPECT_EQ(got.euler_number, expected.euler_number);
  } else {
    EXPECT_EQ(pieces_of(kept), pieces_of(full));
  }
}

TEST(keep_topology, with_a_persistence_is_that_of_a_field_so_near) {
  for (const Index3& dims : oracles::trials<std::vector<Index3>>(
           {{{33, 33, 33}}, {{49, 33, 65}}, {{30, 25, 19}}, {{2, 20, 33}}, {{70, 40, 38}}},
           {{{30, 25, 19}}, {{38, 45, 31}}, {{2, 20, 33}}}))
    for (const int n_rounds : {0, 1, 2})
      for (const double persistence : oracles::trials<std::vector<double>>({0.05, 0.3, 0.8}, {0.2}))
        for (const double max_error :
             oracles::trials<std::vector<double>>({0.0, 0.4, kAny}, {0.4, kAny})) {
          SCOPED_TRACE(::testing::Message()
                       << dims[0] << " " << n_rounds << " " << persistence << " " << max_error);
          const auto seed = static_cast<std::uint64_t>(dims[0] + n_rounds);
          Volume volume = smoothed_noise(dims, seed, n_rounds);
          const ExtractOptions options{
              .isovalues = {0.2}, .max_error = max_error, .keep_topology = persistence};
          expect_topology_of_relaxed(volume, options);
          oracles::Random random(seed);
          const auto samples = oracles::typed_samples<float>(volume);
          for (int i = 0; i < 10; ++i)
            samples[static_cast<std::size_t>(random.uniform(
                0, static_cast<double>(samples.size())))] = std::numeric_limits<float>::quiet_NaN();
          expect_topology_of_relaxed(volume, options);
        }
}

/// With levels that are not kept apart, and with fewer.
TEST(keep_topology, with_a_persistence_in_small_volumes_is_that_of_a_field_so_near) {
  for (std::uint64_t seed = 1; seed <= oracles::trials(300U, 60U) && !HasFailure(); ++seed) {
    oracles::Random random(seed);
    Index3 dims;
    for (std::int32_t& n : dims.v) n = 2 + static_cast<std::int32_t>(random.below(11));
    if (seed % 3 == 0) dims = {{5, 5, 5}};
    SCOPED_TRACE(::testing::Message() << dims[0] << " " << dims[1] << " " << dims[2]);
    const Volume volume = smoothed_noise(dims, seed, static_cast<int>(seed % 2));
    for (const double max_error : {0.0, 0.5, kAny})
      expect_topology_of_relaxed(
          volume, {.isovalues = {0.1}, .max_error = max_error, .keep_topology = 0.2});
  }
}

/// -0 is at 0, not below it.
TEST(keep_topology, with_a_persistence_at_negative_zero) {
  for (std::uint64_t seed = 1; seed <= oracles::trials(4U, 2U); ++seed) {
    RegularGrid grid;
    grid.dims = {{33, 29, 26}};
    oracles::Random random(seed);
    const Volume volume = oracles::volume_of<float>(grid, [&](const Index3& p) {
      const double wave = std::sin(0.3 * p[0]) + std::cos(0.2 * p[1]) * std::sin(0.25 * p[2]);
      return -std::round(wave + random.uniform(-0.8, 0.8));
    });
    for (const double persistence : {0.5, 1.0, 1.5})
      expect_topology_of_relaxed(
          volume, {.isovalues = {0}, .max_error = kAny, .keep_topology = persistence});
  }
}

/// What one isovalue has refined is not counted again with the next.
TEST(keep_topology, with_a_persistence_counts_nodes_once) {
  const Dataset dataset = built_in_memory(smoothed_noise({{40, 33, 38}}, 7, 1));
  const auto counted = [&](std::vector<double> isovalues, std::optional<double> max_distance) {
    Progress progress;
    Surface surface;
    const auto report = dataset.extract({.isovalues = std::move(isovalues),
                                         .max_error = kAny,
                                         .max_distance = max_distance,
                                         .keep_topology = 0.1},
                                        surface, progress);
    EXPECT_TRUE(report);
    return *report->topology;
  };
  const KeptTopology low = counted({0.1}, {});
  const KeptTopology high = counted({0.3}, {});
  const KeptTopology both = counted({0.3, 0.1}, {});
  const KeptTopology near = counted({0.1}, 2.0);
  EXPECT_GE(both.critical_nodes, std::max(low.critical_nodes, high.critical_nodes));
  EXPECT_GE(both.nodes, std::max(low.nodes, high.nodes));
  EXPECT_LT(both.nodes, low.nodes + high.nodes);
  EXPECT_GE(near.critical_nodes, low.critical_nodes);
  EXPECT_GT(low.nodes, low.critical_nodes);
}

/// Where large parts of what is on one side are within the persistence, and other parts are not.
TEST(keep_topology, with_a_persistence_far_from_the_surface) {
  for (std::uint64_t seed = 1; seed <= oracles::trials(6U, 2U); ++seed) {
    RegularGrid grid;
    grid.dims = {{97, 66, 65}};
    oracles::Random random(seed);
    const double phase = random.uniform(0, 6);
    const Volume volume = oracles::volume_of<float>(grid, [&](const Index3& p) {
      const double wave = std::sin(0.05 * p[0] + phase) * std::cos(0.07 * p[1]) +
                          std::sin(0.06 * p[2] + 0.01 * p[0]);
      return (wave > 0.3 ? 1.0 : -1.0) * (random.below(300) == 0 ? 3.0 : 0.5);
    });
    for (const double persistence :
         oracles::trials<std::vector<double>>({0.4, 0.6, 2.0}, {0.6, 2.0}))
      expect_topology_of_relaxed(
          volume, {.isovalues = {0}, .max_error = kAny, .keep_topology = persistence});
  }
}

}  // namespace
}  // namespace lode
