// Own attributes of single nodes, found by walking their simplices, against the nested ones that a
// build finds brick by brick and stores: a nested attribute is the own one joined with all
// descendants'.
#include "lode/models/diamond/node_attributes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>

#include "lode/models/diamond/build.h"
#include "lode/models/diamond/selection.h"
#include "tests/oracles/random.h"

namespace lode::diamond {
namespace {

template <int D>
class Nested {
 public:
  explicit Nested(const Model<D>& model) : model_(model) {}

  const NodeAttributes& operator()(const Index<D>& centre) {
    const auto [at, is_new] = known_.try_emplace(centre.v);
    if (!is_new) return at->second;
    const Diamond<D> node = diamond_at<D>(centre);
    NodeAttributes nested = own_attributes(model_, node);
    for (const Index<D>& child : children<D>(node)) {
      if (!model_.shape.overlaps_data(bounds_of(diamond_at<D>(child)))) continue;
      const NodeAttributes& below = (*this)(child);
      nested.error = std::max(nested.error, below.error);
      nested.low = std::min(nested.low, below.low);
      nested.high = std::max(nested.high, below.high);
    }
    return known_[centre.v] = nested;
  }

 private:
  const Model<D>& model_;
  std::map<std::array<std::int32_t, as_size(D)>, NodeAttributes> known_;
};

template <int D>
bool is_inside_data(const Shape<D>& shape, const Diamond<D>& node) {
  const LatticeBox<D> box = bounds_of(node);
  return shape.is_sample(box.lower) && shape.is_sample(box.upper);
}

/// How many stored errors are finite, and how many of the true ones are not.
struct Finiteness {
  int n_finite = 0;
  int n_infinite = 0;
};

template <int D, typename T>
Finiteness expect_stored_nested(const Index3& dims, std::uint64_t seed, double hole_share) {
  oracles::Random random(seed);
  RegularGrid grid;
  grid.dims = dims;
  std::vector<T> samples(static_cast<std::size_t>(grid.n_samples()));
  for (T& f : samples) {
    f = static_cast<T>(random.uniform(0, 200));
    if (hole_share > 0 && random.uniform(0, 1) < hole_share)
      f = std::numeric_limits<T>::quiet_NaN();
  }
  Progress progress;
  const auto model = build<D>(*make_memory_source(make_volume<T>(grid, samples)), {}, progress);
  EXPECT_TRUE(model);
  if (!model) return {};
  const Selection<D> selection(*model, 0, 0);
  Nested<D> nested(*model);
  const double slack = std::is_integral_v<T> ? 0 : 1e-9;
  const double reference = model->range_reference();
  std::size_t n_checked = 0;
  Finiteness found;
  for (int level = 0; level < model->shape.n_levels; ++level) {
    const Index<D> points = model->shape.grid_dims(level);
    for (std::size_t i = 0; i < n_points<D>(points); ++i) {
      const Diamond<D> node = diamond_at<D>(point_of<D>(points, i) * (1 << level));
      if (node.level != level || (level == 0 && node.tier > 0)) continue;
      if (!model->shape.overlaps_data(bounds_of(node))) continue;
      const NodeAttributes& expected = nested(node.centre);
      const NodeLevel& stored = model->levels[as_size(level)];
      const std::size_t at = selection.index_of(node);
      SCOPED_TRACE(testing::Message() << "level " << level << ", tier " << node.tier);
      const double error = static_cast<double>(decode_error(stored.error[at]));
      EXPECT_GE(error, expected.error);
      found.n_finite += std::isfinite(error) ? 1 : 0;
      found.n_infinite += std::isfinite(expected.error) ? 0 : 1;
      if (hole_share == 0) EXPECT_LE(error, (expected.error + slack) * (1 + 1.0 / 127));
      if (expected.low > expected.high) continue;
      const double low = static_cast<double>(stored.low[at]) + reference;
      const double high = static_cast<double>(stored.high[at]) + reference;
      EXPECT_LE(low, expected.low + slack);
      EXPECT_GE(high, expected.high - slack);
      if (is_inside_data(model->shape, node)) {
        const double rounded =
            has_exact_ranges(model->storage) ? 0 : (expected.high - expected.low) / 64 + 1e-4;
        EXPECT_GE(low, expected.low - rounded);
        EXPECT_LE(high, expected.high + rounded);
      }
      ++n_checked;
    }
  }
  EXPECT_GT(n_checked, 10U);
  return found;
}

TEST(node_attributes, join_to_the_stored_nested_ones) {
  for (std::uint64_t seed = 0; seed < 2; ++seed) {
    expect_stored_nested<3, std::uint8_t>({{17, 17, 17}}, seed, 0);
    expect_stored_nested<3, std::uint8_t>({{40, 7, 19}}, seed, 0);
    expect_stored_nested<3, float>({{9, 35, 12}}, seed, 0);
    expect_stored_nested<2, std::uint8_t>({{70, 1, 33}}, seed, 0);
    expect_stored_nested<2, float>({{1, 140, 21}}, seed, 0);
  }
}

TEST(node_attributes, are_infinite_where_holes_meet_present_cells) {
  for (const Finiteness n : {expect_stored_nested<3, float>({{40, 12, 9}}, 3, 0.002),
                             expect_stored_nested<2, float>({{70, 1, 40}}, 4, 0.004)}) {
    EXPECT_GT(n.n_finite, 0);
    EXPECT_GT(n.n_infinite, 0);
  }
}

TEST(diamond_build, refuses_magnitudes_that_could_overflow) {
  RegularGrid grid;
  grid.dims = {{2, 2, 2}};
  const std::vector<double> samples{0, 1, 2, 3, 4, 5, 6, -1.7e308};
  Progress progress;
  const auto model =
      build<3>(*make_memory_source(make_volume<double>(grid, samples)), {}, progress);
  ASSERT_FALSE(model);
  EXPECT_NE(model.error().message.find("-1.7"), std::string::npos) << model.error().message;
}

TEST(node_attributes, are_own_and_not_nested) {
  // Ends 0 and 0, middle 1, quarter -1: the parent's own error is 1, its child's 1.5.
  RegularGrid grid;
  grid.dims = {{5, 2, 1}};
  std::vector<float> samples{0, -1, 1, 0, 0, 0, 0, 0, 0, 0};
  Progress progress;
  const auto model = build<2>(*make_memory_source(make_volume<float>(grid, samples)), {}, progress);
  ASSERT_TRUE(model);
  EXPECT_EQ(own_attributes(*model, diamond_at<2>({{2, 0}})).error, 1);
  EXPECT_EQ(own_attributes(*model, diamond_at<2>({{1, 0}})).error, 1.5);
}

}  // namespace
}  // namespace lode::diamond
