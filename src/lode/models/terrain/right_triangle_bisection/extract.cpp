#include "lode/models/terrain/right_triangle_bisection/extract.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "lode/core/expects.h"
#include "lode/core/least_float.h"
#include "lode/delaunay/triangle_error.h"
#include "lode/models/terrain/right_triangle_bisection/sample_numbers.h"
#include "lode/models/terrain/right_triangle_bisection/scanned_mesh.h"
#include "lode/models/terrain/right_triangle_bisection/walk.h"

namespace lode::bisection {
namespace {

/// Vertices and heights of samples that are marked and counted, in parts.
class VertexWriter {
 public:
  VertexWriter(const Bisection& bisection, const HeightGrid& grid, const SampleMesh& mesh,
               delaunay::Tin& tin)
      : stride_(static_cast<std::size_t>(bisection.lattice().stride())),
        grid_(grid),
        mesh_(mesh),
        tin_(tin) {
    tin.vertices.resize(mesh.n_samples);
    tin.heights.resize(mesh.n_samples);
  }

  [[nodiscard]] std::size_t n_words() const { return mesh_.marks.words().size(); }
  /// Of words of marks.
  void put(std::size_t first, std::size_t end) {
    std::visit([&](const auto& samples) { put_of(samples, first, end); }, grid_.heights);
  }

 private:
  template <typename Samples>
  void put_of(const Samples& samples, std::size_t first, std::size_t end) {
    const std::vector<std::uint64_t>& words = mesh_.marks.words();
    std::size_t y = 64 * first / stride_;
    std::size_t row = y * stride_;
    for (std::size_t k = first; k < end; ++k) {
      std::size_t n = mesh_.n_before[k];
      for (std::uint64_t word = words[k]; word != 0; word &= word - 1) {
        const std::size_t i = 64 * k + static_cast<std::size_t>(std::countr_zero(word));
        for (; i - row >= stride_; row += stride_) ++y;
        const std::size_t x = i - row;
        tin_.vertices[n] = {static_cast<std::int32_t>(x), static_cast<std::int32_t>(y)};
        tin_.heights[n++] =
            static_cast<double>(samples[y * static_cast<std::size_t>(grid_.stride) + x]);
      }
    }
  }

  std::size_t stride_;
  const HeightGrid& grid_;
  const SampleMesh& mesh_;
  delaunay::Tin& tin_;
};

/// Of numbered samples.
delaunay::Tin to_tin(const Bisection& bisection, const HeightGrid& grid, SampleMesh&& mesh,
                     Threads threads) {
  delaunay::Tin tin;
  tin.triangles = std::move(mesh.triangles);
  tin.errors = std::move(mesh.errors);
  VertexWriter vertices(bisection, grid, mesh, tin);
  constexpr std::size_t kWords = 1024;
  constexpr std::uint32_t kWorthThreads = 1 << 15;
  if (mesh.n_samples < kWorthThreads) threads = {1};
  const std::size_t n_words = vertices.n_words();
  parallel_for((n_words + kWords - 1) / kWords, threads, 1, [&](std::size_t part, int) {
    vertices.put(part * kWords, std::min(n_words, (part + 1) * kWords));
  });
  return tin;
}

/// A half of the triangles, the other, and the vertices, at once. These are a fifth of the work,
/// and go to whoever has the smaller half.
void walk_at_once(const MeshScan& scan, Threads threads, VertexWriter& vertices,
                  delaunay::Tin& tin) {
  delaunay::Tin upper;
  parallel_for(3, threads, 1, [&](std::size_t part, int) {
    if (part < 2)
      scan.walk(part, part == 0 ? tin : upper);
    else
      vertices.put(0, vertices.n_words());
  });
  tin.triangles.insert(tin.triangles.end(), upper.triangles.begin(), upper.triangles.end());
  tin.errors.insert(tin.errors.end(), upper.errors.begin(), upper.errors.end());
}

delaunay::Tin scanned_tin(const Bisection& bisection, const HeightGrid& grid, float limit,
                          Threads threads) {
  const MeshScan scan(bisection, limit, threads);
  delaunay::Tin tin;
  tin.triangles.reserve(scan.most_triangles());
  tin.errors.reserve(scan.most_triangles());
  VertexWriter vertices(bisection, grid, scan.mesh(), tin);
  constexpr std::size_t kWorthThreads = 1 << 13;  // else waking them takes as long
  if (scan.most_triangles() >= kWorthThreads && n_workers(threads) > 1) {
    walk_at_once(scan, threads, vertices, tin);
  } else {
    for (const std::size_t half : {0U, 1U}) scan.walk(half, tin);
    vertices.put(0, vertices.n_words());
  }
  return tin;
}

/// Of corners by their indices: see Bisection::has_triangle().
class InDomain {
 public:
  explicit InDomain(const Bisection& bisection)
      : bisection_(bisection), stride_(bisection.lattice().stride()) {}

  [[nodiscard]] bool operator()(std::int64_t a, std::int64_t b, std::int64_t c) const {
    return bisection_.has_triangle({at(a), at(b), at(c)});
  }

 private:
  [[nodiscard]] LatticePoint at(std::int64_t i) const {
    return {static_cast<std::int32_t>(i % stride_), static_cast<std::int32_t>(i / stride_)};
  }

  const Bisection& bisection_;
  std::int64_t stride_;
};

struct PassNone {
  void operator()(std::int64_t /*sample*/) const {}
};

/// visit(a, b, c, node) of all triangles in the domain.
template <typename IsRefined, typename Visit>
void walk_domain(const Bisection& bisection, const IsRefined& is_refined, const Visit& visit) {
  if (bisection.is_whole()) {
    Walk(bisection.lattice(), is_refined, visit, PassNone()).all();
    return;
  }
  const InDomain is_in_domain(bisection);
  const auto visit_if = [&](std::int64_t a, std::int64_t b, std::int64_t c, std::int64_t node) {
    if (is_in_domain(a, b, c)) visit(a, b, c, node);
  };
  Walk(bisection.lattice(), is_refined, visit_if, PassNone()).all();
}

template <typename IsRefined>
SampleMesh collect(const Bisection& bisection, const IsRefined& is_refined) {
  const Lattice& lattice = bisection.lattice();
  SampleMesh collected{
      {}, {}, SampleMarks(lattice.stride() * (std::int64_t{lattice.last().y} + 1)), {}};
  const float* errors = bisection.errors();
  const auto add = [&](std::int64_t a, std::int64_t b, std::int64_t c, std::int64_t node) {
    collected.triangles.push_back({static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b),
                                   static_cast<std::uint32_t>(c)});
    collected.errors.push_back(node < 0 ? 0.0F : errors[node]);
  };
  if (!bisection.is_whole()) {
    // Refined nodes beyond the outline are no corners.
    walk_domain(bisection, is_refined,
                [&](std::int64_t a, std::int64_t b, std::int64_t c, std::int64_t node) {
                  add(a, b, c, node);
                  for (const std::int64_t i : {a, b, c}) collected.marks.add(i);
                });
    number_samples(collected);
    return collected;
  }
  for (const LatticePoint corner :
       {LatticePoint{0, 0}, {lattice.last().x, 0}, {0, lattice.last().y}, lattice.last()})
    collected.marks.add(static_cast<std::int64_t>(lattice.index(corner)));
  const auto mark = [&](std::int64_t i) { collected.marks.add(i); };
  Walk(lattice, is_refined, add, mark).all();
  number_samples(collected);
  return collected;
}

/// What errors are compared with. Those of the outline are beyond any tolerance.
float limit_of(double tolerance) {
  LODE_EXPECTS(tolerance >= 0);
  return std::min(delaunay::to_float_below(tolerance), std::numeric_limits<float>::max());
}

}  // namespace

delaunay::Tin tin_within(const Bisection& bisection, const HeightGrid& grid, double tolerance,
                         Threads threads) {
  const float* errors = bisection.errors();
  const float limit = limit_of(tolerance);
  if (bisection.is_whole() && is_scanned(bisection.lattice()))
    return scanned_tin(bisection, grid, limit, threads);
  return to_tin(bisection, grid,
                collect(bisection, [errors, limit](std::int64_t i) { return errors[i] > limit; }),
                threads);
}

delaunay::Tin tin_of(const Bisection& bisection, const HeightGrid& grid, const NodeSet& nodes) {
  return to_tin(bisection, grid,
                collect(bisection, [&nodes](std::int64_t i) { return nodes.has(i); }), {1});
}

std::uint64_t count_triangles(const Bisection& bisection, double tolerance, std::uint64_t most) {
  const float* errors = bisection.errors();
  const float limit = limit_of(tolerance);
  std::uint64_t n = 0;
  // Once there are too many nothing is refined any more.
  const auto is_refined = [&](std::int64_t i) { return errors[i] > limit && n <= most; };
  walk_domain(bisection, is_refined,
              [&n](std::int64_t, std::int64_t, std::int64_t, std::int64_t) { ++n; });
  return std::min(n, most + 1);
}

std::optional<double> tolerance_of_cells(const Bisection& bisection, std::uint64_t max_cells) {
  return least_float([&](double tolerance) {
    return count_triangles(bisection, tolerance, max_cells) <= max_cells;
  });
}

}  // namespace lode::bisection
