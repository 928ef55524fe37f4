// The leaves that extraction finds brick by brick, against a walk of the hierarchy that asks the
// one question at every node and knows no shortcut.
#include "lode/models/diamond/selection.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "lode/models/diamond/build.h"
#include "lode/models/diamond/extract.h"
#include "lode/models/diamond/refinable.h"
#include "tests/oracles/random.h"

namespace lode::diamond {
namespace {

template <int D>
using Vertices = std::array<std::array<std::int32_t, as_size(D)>, as_size(D) + 1>;

template <int D, typename Points>
Vertices<D> sorted(const Points& points) {
  Vertices<D> vertices;
  for (std::size_t i = 0; i <= as_size(D); ++i) vertices[i] = points[i].v;
  std::sort(vertices.begin(), vertices.end());
  return vertices;
}

template <int D>
class PlainWalk {
 public:
  PlainWalk(const Model<D>& model, const IsosurfaceQuery& query)
      : model_(model), nodes_(model), query_(query) {
    for (const Simplex<D>& s : kuhn_simplices<D>({}, model.shape.root_side())) visit(s);
  }
  [[nodiscard]] const std::set<Vertices<D>>& leaves() const { return leaves_; }

 private:
  void visit(const Simplex<D>& s) {
    if (!model_.shape.overlaps_data(bounds_of(s))) return;
    if (!is_finest(s)) {
      const Diamond<D> d = diamond_at<D>(s.bisection_point());
      const NodeFacts facts = nodes_.facts_at(d);
      const bool is_wanted = query_.tolerance == 0 || facts.error > query_.tolerance ||
                             model_.shape.reaches_across(d.centre, d.level);
      if (is_wanted && facts.range.crosses(query_.isovalue)) {
        for (const Simplex<D>& half : bisect(s)) visit(half);
        return;
      }
    }
    std::size_t n_inside = 0;
    for (const Index<D>& v : s.v) {
      const double value = model_.value_or_nan(v);
      if (std::isnan(value)) return;
      n_inside += value >= query_.isovalue ? 1 : 0;
    }
    if (n_inside == 0 || n_inside > as_size(D)) return;
    if (model_.has_holes() && model_.is_removed(s)) return;
    leaves_.insert(sorted<D>(s.v));
  }

  const Model<D>& model_;
  Refinable<D> nodes_;
  IsosurfaceQuery query_;
  std::set<Vertices<D>> leaves_;
};

/// Ramps with noise: large simplices in the middle, and samples equal to the isovalue.
template <typename T>
Volume ramp(const Index3& dims, std::uint64_t seed, double hole_share) {
  oracles::Random random(seed);
  RegularGrid grid;
  grid.dims = dims;
  const double slope[3] = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
  std::vector<T> samples;
  Index3 p;
  for (p[2] = 0; p[2] < dims[2]; ++p[2])
    for (p[1] = 0; p[1] < dims[1]; ++p[1])
      for (p[0] = 0; p[0] < dims[0]; ++p[0]) {
        double f = random.uniform(0, 2);
        for (std::size_t i = 0; i < 3; ++i) f += slope[i] * (p[i] - dims[i] / 2);
        samples.push_back(static_cast<T>(std::floor(f)));
        if constexpr (std::numeric_limits<T>::has_quiet_NaN)
          if (random.uniform(0, 1) < hole_share)
            samples.back() = std::numeric_limits<T>::quiet_NaN();
      }
  return make_volume<T>(grid, samples);
}

template <int D, typename T>
void expect_same_leaves(const Index3& dims, std::uint64_t seed, double hole_share) {
  const Volume volume = ramp<T>(dims, seed, hole_share);
  Progress progress;
  const auto model = build<D>(*make_memory_source(volume), {.threads = {2}}, progress);
  ASSERT_TRUE(model);
  for (const double isovalue : {0.0, 0.3})
    for (const double tolerance : {0.6, 1.0, 2.0, 5.0}) {
      const IsosurfaceQuery query{.isovalue = isovalue, .tolerance = tolerance};
      std::set<Vertices<D>> found;
      for (const ActiveSimplex<D>& s : active_simplices<D>(*model, query))
        EXPECT_TRUE(found.insert(sorted<D>(s.vertex)).second);
      const PlainWalk<D> expected(*model, query);
      EXPECT_EQ(found.size(), expected.leaves().size())
          << "isovalue " << isovalue << " tolerance " << tolerance << " seed " << seed;
      EXPECT_TRUE(found == expected.leaves());
    }
}

TEST(selection, finds_the_leaves_of_the_plain_walk) {
  for (std::uint64_t seed = 0; seed < 2; ++seed) {
    expect_same_leaves<3, std::int16_t>({{35, 40, 66}}, seed, 0);
    expect_same_leaves<3, float>({{33, 48, 37}}, seed, 0.0005);
    expect_same_leaves<3, double>({{41, 12, 34}}, seed, 0);
    expect_same_leaves<2, std::int16_t>({{150, 260, 1}}, seed, 0);
    expect_same_leaves<2, float>({{1, 300, 140}}, seed, 0.0005);
  }
}

}  // namespace
}  // namespace lode::diamond
