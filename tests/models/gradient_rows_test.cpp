// Gradients found in rows, or by strides, are those of NormalSampler, bit for bit.

#include "lode/models/diamond/gradient_rows.h"

#include <gtest/gtest.h>

#include "lode/models/diamond/inner_gradients.h"
#include "lode/models/diamond/normals.h"
#include "lode/models/diamond/row_edges.h"
#include "tests/models/all_targets.h"
#include "tests/models/stored_fixtures.h"
#include "tests/oracles/random.h"
#include "tests/oracles/trials.h"
#include "tests/oracles/typed_samples.h"

namespace lode::diamond {
namespace {

template <typename T>
Volume noise(const Index3& dims) {
  RegularGrid grid;
  grid.dims = dims;
  grid.spacing = {{0.5, 1.25, 0.75}};
  oracles::Random random(29);
  return oracles::volume_of<T>(grid, [&](const Index3&) { return random.uniform(0, 250); });
}

/// Which edges of a row are crossed: all there are, or one in so many.
std::vector<WordGroup> crossed_edges(const Index3& dims, std::int32_t y, std::int32_t z,
                                     std::uint64_t one_in, oracles::Random& random) {
  const std::size_t n_words = as_size(dims[0] + 31) / 32;
  std::vector<WordGroup> groups((n_words + WordGroup::kWords - 1) / WordGroup::kWords);
  for (std::size_t i = 0; i < groups.size(); ++i) groups[i].first = i * WordGroup::kWords;
  for (std::int32_t x = 0; x < dims[0]; ++x)
    for (std::uint32_t direction = 1; direction < 8; ++direction) {
      const bool is_inside = ((direction & 1) == 0 || x + 1 < dims[0]) &&
                             ((direction & 2) == 0 || y + 1 < dims[1]) &&
                             ((direction & 4) == 0 || z + 1 < dims[2]);
      if (!is_inside || random.below(one_in) != 0) continue;
      const std::size_t word = as_size(x) / 32;
      WordGroup& group = groups[word / WordGroup::kWords];
      group.crossings[word % WordGroup::kWords][direction - 1] |= 1U << (x % 32);
      group.met |= 1U << word % WordGroup::kWords;
    }
  return groups;
}

/// The packed edges of a row that is the n-th of a run.
std::vector<std::uint32_t> packed(std::span<const WordGroup> groups, std::int32_t y, std::int32_t z,
                                  std::uint32_t n) {
  std::vector<std::uint32_t> edges;
  for (std::size_t s = 0; s < kOwnSeries; ++s)
    for (const WordGroup& group : groups)
      for (std::size_t i = 0; i < WordGroup::kWords; ++i)
        for (std::uint32_t bits = group.crossings[i][s]; bits != 0; bits &= bits - 1) {
          const auto x = static_cast<std::uint32_t>(32 * (group.first + i)) +
                         static_cast<std::uint32_t>(std::countr_zero(bits));
          const EdgeEnds& ends = edge_ends((y & 1) | (z & 1) << 1)[s][x & 1];
          edges.push_back((n << PackedEdge::kRowShift) + x + ends.place);
        }
  return edges;
}

template <typename T>
class RowsAgainstSampler {
 public:
  explicit RowsAgainstSampler(const Index3& dims)
      : model_(test::built<3>(noise<T>(dims))), sampler_(model_), rows_(model_) {}

  void run(std::uint64_t one_in) {
    const Index3 dims = model_.shape.dims;
    oracles::Random random(one_in);
    for (std::int32_t z = 0; z < dims[2]; ++z)
      for (std::int32_t y = 0; y < dims[1]; ++y) {
        if (y == 0 || y - first_ == kRowsPerRun) begin(y);
        const auto groups = crossed_edges(dims, y, z, one_in, random);
        rows_.find(y, z, groups);
        const auto row = packed(groups, y, z, static_cast<std::uint32_t>(y - first_));
        edges_.insert(edges_.end(), row.begin(), row.end());
        if (y + 1 == dims[1] || y + 1 - first_ == kRowsPerRun) check(z);
      }
  }

 private:
  void begin(std::int32_t y) {
    first_ = y;
    edges_.clear();
  }
  void check(std::int32_t z) {
    const std::size_t n = edges_.size();
    std::vector<std::uint32_t> edges = edges_;
    edges.resize(n + kEdgePadding);
    std::vector<std::uint32_t> first(n + kEdgePadding);
    std::vector<std::uint32_t> second(n + kEdgePadding);
    find_places(rows_.places(), {edges.data(), n, first_, z, first.data(), second.data()});
    for (std::size_t i = 0; i < n; ++i) {
      const auto [p, q] = unpacked_edge(edges[i], first_, z);
      expect_gradient(p, first[i]);
      expect_gradient(q, second[i]);
    }
  }
  void expect_gradient(const Index3& p, std::uint32_t place) {
    const GradientOf<T>* const found = rows_.gradients() + std::size_t{4} * place;
    const Vec3d expected = sampler_.gradient(p, 1);
    for (std::size_t i = 0; i < 3; ++i)
      ASSERT_EQ(static_cast<double>(found[i]), expected[i])
          << p[0] << " " << p[1] << " " << p[2] << ", axis " << i;
    ASSERT_EQ(found[3], 0);
  }

  Model<3> model_;
  NormalSampler<3, T> sampler_;
  GradientRows<T> rows_;
  std::int32_t first_ = 0;
  std::vector<std::uint32_t> edges_;
};

template <typename T>
void expect_rows(const Index3& dims) {
  RowsAgainstSampler<T>(dims).run(1);
  RowsAgainstSampler<T>(dims).run(60);
}

TEST(gradient_rows, are_those_of_the_sampler_bit_for_bit) {
  for (const Index3& dims : oracles::trials<std::vector<Index3>>(
           {{{2, 2, 2}},
            {{3, 2, 33}},
            {{16, 16, 16}},
            {{32, 33, 33}},
            {{33, 34, 65}},
            {{48, 35, 3}},
            {{64, 66, 3}},
            {{65, 16, 34}},
            {{1025, 3, 3}}},
           {{{2, 2, 2}}, {{16, 5, 4}}, {{49, 35, 3}}, {{600, 3, 3}}})) {
    SCOPED_TRACE(testing::Message() << dims[0] << " " << dims[1] << " " << dims[2]);
    test::for_each_target([&] {
      expect_rows<std::uint8_t>(dims);
      expect_rows<std::uint16_t>(dims);
      expect_rows<std::int16_t>(dims);
      expect_rows<float>(dims);
      expect_rows<double>(dims);
    });
  }
}

TEST(gradient_rows, are_so_where_slices_are_not_kept_whole) {
  constexpr std::size_t kRows = 8192;  // the next power of two
  static_assert(8 * sizeof(double) * 48 * kRows > kMostGradientBytes);
  expect_rows<double>({{20, 5000, 4}});
}

/// Behind the last row's last sample, which is a brick's, there is nothing to read.
TEST(gradient_rows, read_nothing_behind_the_model) {
  expect_rows<std::uint8_t>({{32, 33, 33}});
  expect_rows<double>({{32, 33, 33}});
}

/// Of points of all levels, in bricks, and in a box of samples one after the other.
TEST(inner_gradients, are_those_of_the_sampler_bit_for_bit) {
  oracles::Random random(3);
  for (const Index3& dims : {Index3{{9, 70, 33}}, Index3{{150, 65, 97}}, Index3{{32, 33, 34}}}) {
    const Volume volume = noise<float>(dims);
    const Model<3> model = test::built<3>(volume);
    FlatField<3> flat;
    flat.set_info(volume.info);
    flat.stats = model.stats;
    flat.samples.assign(volume.samples.begin(), volume.samples.end());
    const NormalSampler<3, float> sampler(model);
    const InnerGradients<float> of_bricks(model);
    const InnerGradients<float> of_box(flat);
    std::size_t n_found = 0;
    for (int i = 0; i < 20'000; ++i) {
      const std::int32_t step = 1 << random.below(7);
      Index3 p;
      for (std::size_t a = 0; a < 3; ++a)
        p[a] = static_cast<std::int32_t>(random.below(as_size(dims[a]))) / step * step;
      std::array<double, 3> found{};
      const bool is_found = of_bricks.find(p, step, found.data());
      std::array<double, 3> in_box{};
      ASSERT_EQ(of_box.find(p, step, in_box.data()), is_found);
      bool is_inner = step <= kBrickEdge<3>;
      for (std::size_t a = 0; a < 3; ++a)
        is_inner = is_inner && p[a] >= step && p[a] + step < dims[a];
      ASSERT_EQ(is_found, is_inner);
      if (!is_found) continue;
      ++n_found;
      const Vec3d expected = sampler.gradient(p, step);
      ASSERT_EQ(found, expected.v);
      ASSERT_EQ(in_box, expected.v);
    }
    EXPECT_GT(n_found, 1000U);
  }
}

}  // namespace
}  // namespace lode::diamond
