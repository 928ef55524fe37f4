#include "lode/models/diamond/leaf_facets.h"

#include <algorithm>
#include <atomic>
#include <memory>

#include "lode/mappers/march_simplex.h"
#include "lode/models/diamond/brick_work.h"

namespace lode::diamond {
namespace {

using Corners = std::array<Index<3>, 4>;

/// Turns leaves into facets, vertex by vertex as IsoPart and stitch() do.
class FacetMaker {
 public:
  FacetMaker(const LatticeFrame& frame, double isovalue) : frame_(frame), isovalue_(isovalue) {}

  void add(const Corners& vertex, const std::array<double, 4>& value, std::uint64_t place,
           std::vector<Facet>& out) const {
    std::size_t inside = 0;
    for (std::size_t i = 0; i < 4; ++i) inside |= (value[i] >= isovalue_ ? std::size_t{1} : 0) << i;
    std::array<Vec3f, 4> points;
    std::uint32_t n_points = 0;
    const auto vertex_on = [&](std::size_t i, std::size_t j) {
      points[n_points] = position(to_key(vertex[i]), value[i], to_key(vertex[j]), value[j]);
      return n_points++;
    };
    march_simplex<3>(inside, false, vertex_on, [&](const auto& cell) {
      out.push_back({{points[cell[0]], points[cell[1]], points[cell[2]]}, place});
    });
  }

 private:
  [[nodiscard]] Vec3f position(LatticeKey p, double a, LatticeKey q, double b) const {
    EdgePoint point = lode::crossing(p, a, q, b, isovalue_);
    point.t = std::clamp(point.t, frame_.margin, 1 - frame_.margin);
    const Vec3d at = frame_.position(point.lattice_position());
    return {{static_cast<float>(at[0]), static_cast<float>(at[1]), static_cast<float>(at[2])}};
  }

  const LatticeFrame& frame_;
  double isovalue_;
};

/// Where leaves of some bricks come from.
struct BrickLeaves {
  const Selection<3>& selection;
  Threads threads;
  const Progress& progress;
};

/// Calls visit(vertices, values, i) for the leaves in brick i of n that the surface crosses, on the
/// lattice of the selection's model; in parallel. brick(i) is its place, simplices(i) what it
/// begins with.
template <typename Brick, typename Simplices, typename Visit>
void for_each_leaf(const BrickLeaves& leaves, std::size_t n, const Brick& brick,
                   const Simplices& simplices, const Visit& visit) {
  std::vector<std::unique_ptr<BrickTraversal<3>>> workers(as_size(n_workers(leaves.threads)));
  parallel_for(n, leaves.threads, 1, [&](std::size_t i, int worker) {
    if (leaves.progress.is_cancelled()) return;
    auto& traversal = workers[as_size(worker)];
    if (!traversal) traversal = std::make_unique<BrickTraversal<3>>(leaves.selection);
    traversal->open(brick(i));
    TraversalStats stats;
    for (const Simplex<3>& simplex : simplices(i))
      traversal->visit(simplex, stats, [&](const BrickSimplex<3>& leaf) {
        Corners vertex;
        std::array<double, 4> value{};
        for (std::size_t c = 0; c < 4; ++c) {
          vertex[c] = traversal->samples().global(leaf.corner[c].packed);
          value[c] = leaf.corner[c].value;
        }
        visit(vertex, value, i);
      });
  });
}

/// Behind those that are there.
void append_parts(std::vector<std::vector<Facet>>& parts, std::vector<Facet>& all) {
  std::size_t n = all.size();
  for (const auto& part : parts) n += part.size();
  all.reserve(n);
  for (auto& part : parts) {
    all.insert(all.end(), part.begin(), part.end());
    std::vector<Facet>().swap(part);  // they are as much again
  }
}

/// place_of(vertices) for each leaf that the surface of a selection crosses.
template <typename PlaceOf>
std::vector<Facet> find_facets(const Selection<3>& selection, Threads threads,
                               const Progress& progress, const PlaceOf& place_of) {
  const Model<3>& model = selection.model();
  std::vector<Facet> all;
  if (!model.shape.has_cells()) return all;
  const LatticeFrame frame = LatticeFrame::of(model.info.grid);
  const FacetMaker maker(frame, selection.isovalue());
  CoarseCut<3> cut;
  CoarseTraversal<3, Selection<3>>(selection, cut).run();
  for (const ActiveSimplex<3>& leaf : cut.leaves)
    maker.add(leaf.vertex, leaf.value, place_of(leaf.vertex), all);
  const auto work = work_of(cut);
  std::vector<std::vector<Facet>> parts(work.size());
  for_each_leaf(
      {selection, threads, progress}, work.size(),
      [&](std::size_t i) { return point_of<3>(model.brick_dims, work[i].brick); },
      [&](std::size_t i) {
        std::vector<Simplex<3>> simplices;
        for (std::size_t s = work[i].begin; s < work[i].end; ++s)
          simplices.push_back(cut.brick_simplices[s].second);
        return simplices;
      },
      [&](const Corners& vertex, const std::array<double, 4>& value, std::size_t i) {
        maker.add(vertex, value, place_of(vertex), parts[i]);
      });
  append_parts(parts, all);
  return all;
}

/// Of bricks of a part of a field: place_of(vertices) gets them in the lattice of the field.
template <typename PlaceOf>
std::vector<Facet> find_facets(const FieldBricks& field, const Selection<3>& selection,
                               Threads threads, const Progress& progress, const PlaceOf& place_of) {
  const LatticeFrame frame = LatticeFrame::of(field.grid);
  const FacetMaker maker(frame, selection.isovalue());
  const auto is_known = [&](const Corners& vertex) {
    for (const Index<3>& p : vertex)
      for (std::size_t a = 0; a < 3; ++a)
        if (p[a] < field.known.lower[a] || p[a] > field.known.upper[a]) return false;
    return true;
  };
  std::vector<std::vector<Facet>> parts(field.bricks.size());
  std::atomic<std::size_t> n{0};
  for_each_leaf(
      {selection, threads, progress}, parts.size(), [&](std::size_t i) { return field.bricks[i]; },
      [&](std::size_t i) {
        if (n.load(std::memory_order_relaxed) > field.n_most) return std::vector<Simplex<3>>();
        const Index<3> lower = field.bricks[i] * kBrickEdge<3> + field.origin;
        std::vector<Simplex<3>> simplices = kuhn_simplices<3>(lower, kBrickEdge<3>);
        for (Simplex<3>& s : simplices)
          for (Index<3>& v : s.v) v = v - field.origin;
        return simplices;
      },
      [&](Corners vertex, const std::array<double, 4>& value, std::size_t i) {
        if (!is_known(vertex)) return;
        for (Index<3>& p : vertex) p = p + field.origin;
        const std::size_t n_before = parts[i].size();
        maker.add(vertex, value, place_of(vertex), parts[i]);
        n.fetch_add(parts[i].size() - n_before, std::memory_order_relaxed);
      });
  std::vector<Facet> all;
  append_parts(parts, all);
  return all;
}

std::uint64_t place_in_full(const Corners& vertex) {
  return to_key(vertex[0] + vertex[1] + vertex[2] + vertex[3]);
}

/// `origin`: of the lattice of `fresh`.
std::uint64_t place_in_cut(const Corners& vertex, const NodeSet<3>* fresh, const Index<3>& origin) {
  const Index<3> doubled = doubled_bisection_point(vertex);
  if (common_exponent<3>(doubled) == 0) return LeafPlace::kFinest;
  const bool is_fresh = fresh == nullptr || fresh->contains(newest_vertex(vertex) - origin);
  Index<3> centre;
  for (std::size_t i = 0; i < 3; ++i) centre[i] = doubled[i] / 2;
  return to_key(centre) | (is_fresh ? LeafPlace::kFresh : 0);
}

}  // namespace

Index<3> doubled_bisection_point(const std::array<Index<3>, 4>& vertex) {
  Index<3> sum;
  std::int64_t longest = 0;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i + 1; j < 4; ++j) {
      std::int64_t squared = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::int64_t d = vertex[i][k] - vertex[j][k];
        squared += d * d;
      }
      if (squared <= longest) continue;
      longest = squared;
      sum = vertex[i] + vertex[j];
    }
  return sum;
}

Index<3> newest_vertex(const std::array<Index<3>, 4>& vertex) {
  const auto age = [](const Index<3>& p) {
    const int level = common_exponent<3>(p);
    return 4 * level - (level < 31 ? diamond_at<3>(p).tier : 0);
  };
  return *std::min_element(vertex.begin(), vertex.end(),
                           [&](const auto& a, const auto& b) { return age(a) < age(b); });
}

std::vector<Facet> full_facets(const Model<3>& model, const IsosurfaceQuery& query,
                               const Progress& progress) {
  const Selection<3> selection(model, query.isovalue, 0);
  return find_facets(selection, query.threads, progress, place_in_full);
}

std::vector<Facet> full_facets(const FieldBricks& bricks, const IsosurfaceQuery& query,
                               const Progress& progress) {
  const Selection<3> selection(bricks.model, query.isovalue, 0);
  return find_facets(bricks, selection, query.threads, progress, place_in_full);
}

std::vector<Facet> cut_facets(const Model<3>& model, const IsosurfaceQuery& query,
                              const NodeSet<3>* fresh, const Progress& progress) {
  const Selection<3> selection(model, query.isovalue, query.tolerance, query.wanted);
  return find_facets(selection, query.threads, progress,
                     [&](const Corners& vertex) { return place_in_cut(vertex, fresh, {}); });
}

std::vector<Facet> cut_facets(const FieldBricks& bricks, const IsosurfaceQuery& query,
                              const NodeSet<3>* fresh, const Progress& progress) {
  const Selection<3> selection(bricks.model, query.isovalue, query.tolerance, query.wanted);
  return find_facets(bricks, selection, query.threads, progress, [&](const Corners& vertex) {
    return place_in_cut(vertex, fresh, bricks.origin);
  });
}

}  // namespace lode::diamond
