#include "lode/models/diamond/cube_plan.h"

#include <algorithm>
#include <bit>

namespace lode::diamond {
namespace {

template <int D>
std::size_t plan_number(const Index<D>& p) {
  std::size_t number = 0;
  for (int i = D - 1; i >= 0; --i)
    number = number * as_size(kPlanEdge<D> + 1) + as_size(p[as_size(i)]);
  return number;
}

/// Where its values are in an array of kLanes values a point.
template <int D>
std::uint16_t place_of(const Index<D>& p) {
  static_assert(kPlanPoints<D> * kLanes <= std::size_t{1} << 16);
  return static_cast<std::uint16_t>(plan_number<D>(p) * kLanes);
}

/// A point of the cube that is no corner: its diamond inside the canonical cube. The origin is
/// ≡ 0 for every modulus, so canonical coordinates classify as lattice ones do.
template <int D>
bool is_vertex(const Index<D>& u, std::int32_t side, int tier) {
  const int exponent = common_exponent<D>(u);
  if (exponent >= 31 || (std::int32_t{1} << exponent) >= side) return true;
  const Diamond<D> d = diamond_at<D>(u);
  return 2 * d.h() == side && d.tier < tier;
}

template <int D>
void add_values(InterpolantPass& pass, const CanonicalCube<D>& cube, int tier) {
  struct Step {
    int level, tier;
    InterpolantPass::Mean mean;
  };
  std::vector<Step> steps;
  const Index<D> dims = all_equal<D>(cube.side + 1);
  for (std::size_t i = 0; i < n_points<D>(dims); ++i) {
    const Index<D> u = point_of<D>(dims, i);
    const auto to = place_of<D>(cube.global(u));
    if (is_vertex<D>(u, cube.side, tier)) {
      pass.vertices.push_back(to);
      continue;
    }
    const Diamond<D> d = diamond_at<D>(u);
    const auto ends = axis_ends<D>(d);
    steps.push_back({d.level,
                     d.tier,
                     {to, place_of<D>(cube.global(ends[0])), place_of<D>(cube.global(ends[1]))}});
  }
  std::stable_sort(steps.begin(), steps.end(), [](const Step& a, const Step& b) {
    return a.level != b.level ? a.level > b.level : a.tier < b.tier;
  });
  for (const Step& step : steps) pass.means.push_back(step.mean);
}

void add_region(InterpolantPass& pass, std::uint32_t node,
                const std::vector<std::uint16_t>& points) {
  InterpolantPass::Region region{node, static_cast<std::uint32_t>(pass.points.size()), 0};
  pass.points.insert(pass.points.end(), points.begin(), points.end());
  region.end = static_cast<std::uint32_t>(pass.points.size());
  pass.regions.push_back(region);
}

template <int D>
void add_node_regions(InterpolantPass& pass, const CanonicalCube<D>& cube, int tier) {
  std::vector<std::pair<std::uint32_t, std::uint16_t>> pairs;
  const Index<D> dims = all_equal<D>(cube.side + 1);
  for (std::size_t i = 0; i < n_points<D>(dims); ++i) {
    const Index<D> u = point_of<D>(dims, i);
    if (is_vertex<D>(u, cube.side, tier)) continue;  // the interpolant is exact there
    for (const Index<D>& node : nodes_containing<D>(u, cube.side, tier))
      pairs.emplace_back(static_cast<std::uint32_t>(plan_number<D>(cube.global(node))),
                         place_of<D>(cube.global(u)));
  }
  std::sort(pairs.begin(), pairs.end());
  for (std::size_t i = 0; i < pairs.size();) {
    std::vector<std::uint16_t> points;
    const std::uint32_t node = pairs[i].first;
    for (; i < pairs.size() && pairs[i].first == node; ++i) points.push_back(pairs[i].second);
    add_region(pass, node, points);
  }
}

/// The rows of a Kuhn simplex: points with kPlanEdge >= u[0] >= .. >= u[D-1] >= 0 steps along the
/// edges of its chain, joined along edge 0.
template <int D>
KuhnSimplex<D> kuhn_rows(const Simplex<D>& simplex) {
  KuhnSimplex<D> result{.simplex = simplex, .corner = {}, .step = 0, .rows = {}};
  std::array<std::size_t, as_size(D)> strides;  // per edge of the chain
  for (std::size_t j = 0; j < as_size(D); ++j)
    for (std::size_t i = 0; i < as_size(D); ++i) {
      if (simplex.v[j + 1][i] == simplex.v[j][i]) continue;
      strides[j] = kLanes * power(as_size(kPlanEdge<D> + 1), static_cast<int>(i));
      result.corner[j + 1] = static_cast<std::uint16_t>(result.corner[j] | 1U << i);
    }
  result.step = static_cast<std::uint16_t>(strides[0]);
  Index<D> dims;  // of all u with u[0] left out
  for (std::size_t i = 0; i < as_size(D); ++i) dims[i] = i == 0 ? 1 : kPlanEdge<D> + 1;
  for (std::size_t i = 0; i < n_points<D>(dims); ++i) {
    Index<D> u = point_of<D>(dims, i);
    u[0] = u[1];
    if (!std::is_sorted(u.v.rbegin(), u.v.rend())) continue;
    typename KuhnSimplex<D>::Row row{0, static_cast<std::uint16_t>(kPlanEdge<D> + 1 - u[0]), {}};
    for (std::size_t j = 0; j < as_size(D); ++j) {
      row.u[j] = static_cast<std::uint16_t>(u[j]);
      row.first = static_cast<std::uint16_t>(row.first + as_size(u[j]) * strides[j]);
    }
    result.rows.push_back(row);
  }
  return result;
}

template <int D>
CubePlan<D> make_plan() {
  CubePlan<D> plan;
  for (int level = 1; (std::int32_t{2} << level) <= kPlanEdge<D>; ++level) {
    const std::int32_t side = std::int32_t{2} << level;
    const Index<D> n = all_equal<D>(kPlanEdge<D> / side);
    for (std::size_t i = 0; i < n_points<D>(n); ++i) {
      const CanonicalCube<D> cube(point_of<D>(n, i) * side, side);
      for (int tier = 0; tier < D; ++tier) {
        typename CubePlan<D>::NodePass node_pass{level, {}};
        add_values<D>(node_pass.pass, cube, tier);
        add_node_regions<D>(node_pass.pass, cube, tier);
        plan.node_passes.push_back(std::move(node_pass));
      }
    }
  }
  for (const Simplex<D>& s : kuhn_simplices<D>({}, kPlanEdge<D>))
    plan.kuhn.push_back(kuhn_rows<D>(s));
  return plan;
}

}  // namespace

template <int D>
NearPoints<D> nodes_containing(const Index<D>& u, std::int32_t side, int tier) {
  NearPoints<D> result;
  for (std::uint32_t snapped = 0; snapped < 1U << D; ++snapped) {
    if (std::popcount(snapped) != tier) continue;
    std::int32_t nearest_free = side;
    for (std::size_t i = 0; i < as_size(D); ++i)
      if ((snapped >> i & 1U) == 0) nearest_free = std::min({nearest_free, u[i], side - u[i]});
    for (std::uint32_t upper = snapped;; upper = (upper - 1) & snapped) {
      Index<D> node;
      bool is_nearer = true;
      for (std::size_t i = 0; i < as_size(D); ++i) {
        const bool is_upper = (upper >> i & 1U) != 0;
        node[i] = (snapped >> i & 1U) == 0 ? side / 2 : is_upper ? side : 0;
        if ((snapped >> i & 1U) != 0)
          is_nearer = is_nearer && (is_upper ? side - u[i] : u[i]) <= nearest_free;
      }
      if (is_nearer) result.push_back(node);
      if (upper == 0) break;
    }
  }
  return result;
}

template <int D>
const CubePlan<D>& CubePlan<D>::instance() {
  static const CubePlan<D> kPlan = make_plan<D>();
  return kPlan;
}

template struct CubePlan<2>;
template struct CubePlan<3>;
template NearPoints<2> nodes_containing<2>(const Index<2>&, std::int32_t, int);
template NearPoints<3> nodes_containing<3>(const Index<3>&, std::int32_t, int);

}  // namespace lode::diamond
