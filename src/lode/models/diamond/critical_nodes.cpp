#include "lode/models/diamond/critical_nodes.h"

#include <array>
#include <mutex>
#include <vector>

#include "lode/models/diamond/refinable.h"
#include "lode/models/diamond/sample_rows.h"

namespace lode::diamond {
namespace {

/// The vertices of a star round its axis, in order, in steps of h from the centre.
struct Ring {
  std::array<Index<3>, 8> steps{};
  std::size_t n = 0;

  void add(const Index<3>& step) { steps[n++] = step; }
  /// The first end of the axis with one or two of its odd coordinates mirrored.
  void add_mirrored(Index<3> first, std::size_t i, std::size_t j) {
    first[i] = -first[i];
    if (j != i) first[j] = -first[j];
    add(first);
  }
};

Index<3> unit(std::size_t axis, std::int32_t sign) {
  Index<3> step;
  step[axis] = sign;
  return step;
}

/// `first` leads to one end of the axis.
Ring ring_round(const Index<3>& first) {
  Ring ring;
  std::array<std::size_t, 3> odd{};
  std::array<std::size_t, 3> even{};
  std::size_t n_odd = 0;
  std::size_t n_even = 0;
  for (std::size_t i = 0; i < 3; ++i) (first[i] != 0 ? odd[n_odd++] : even[n_even++]) = i;
  if (n_odd == 3) {
    for (std::size_t i = 0; i < 3; ++i) {
      ring.add_mirrored(first, i, i);
      ring.add_mirrored(first, i, (i + 1) % 3);
    }
  } else if (n_odd == 2) {
    ring.add_mirrored(first, odd[0], odd[0]);
    ring.add(unit(even[0], 1));
    ring.add_mirrored(first, odd[1], odd[1]);
    ring.add(unit(even[0], -1));
  } else {
    const Index<3> u = unit(even[0], 1);
    const Index<3> v = unit(even[1], 1);
    for (const Index<3>& step : {u, u + v, v, v - u, u * -1, (u + v) * -1, v * -1, u - v})
      ring.add(step);
  }
  return ring;
}

/// By the first end's steps, in base 3.
const Ring& ring_of(const Index<3>& first) {
  static const auto kRings = [] {
    std::array<Ring, 27> rings;
    for (std::size_t i = 0; i < rings.size(); ++i) {
      const Index<3> step = point_of<3>(all_equal<3>(3), i) - all_equal<3>(1);
      if (step != Index<3>{}) rings[i] = ring_round(step);
    }
    return rings;
  }();
  return kRings[linear_index<3>(all_equal<3>(3), first + all_equal<3>(1))];
}

/// The sides of an isovalue that a volume's samples are on.
class NodeSides {
 public:
  enum Side : std::uint8_t { outside, inside, hole };

  NodeSides(const Model<3>& model, double isovalue, Threads threads)
      : dims_(model.shape.dims), sides_(n_points<3>(dims_)) {
    const auto n_x = as_size(dims_[0]);
    visit_storage_type(model.storage, [&]<typename T>() {
      parallel_for(sides_.size() / n_x, threads, 64, [&](std::size_t row, int) {
        std::vector<T> samples(n_x);
        copy_samples<T, 3>(model, point_of<3>(dims_, row * n_x), dims_[0], 1, samples.data());
        for (std::size_t x = 0; x < n_x; ++x) {
          const auto value = static_cast<double>(samples[x]);
          const bool is_hole = model.has_holes() && model.is_hole(value);
          sides_[row * n_x + x] = is_hole ? hole : value >= isovalue ? inside : outside;
        }
      });
    });
  }

  /// Appends the centres of the critical nodes in a row of a level's grid. Most nodes are told by
  /// three samples.
  void find_in_row(int level, const Index<3>& row, std::vector<Index<3>>& found) const {
    std::array<std::ptrdiff_t, 3> strides{};
    std::ptrdiff_t stride = std::ptrdiff_t{1} << level;
    for (std::size_t i = 0; i < 3; stride *= dims_[i++]) strides[i] = stride;
    std::ptrdiff_t to_end = 0;  // from a node to an end of its axis, without the x part
    bool is_even = true;
    for (std::size_t i = 1; i < 3; ++i) {
      if ((row[i] & 1) == 0) continue;
      if (!has_ends(level, row, i)) return;
      is_even = false;
      to_end += (row[i] & 3) == 1 ? -strides[i] : strides[i];
    }
    const std::uint8_t* const sides =
        sides_.data() + linear_index<3>(dims_, row * (std::int32_t{1} << level));
    Index<3> q = row;
    for (q[0] = is_even ? 1 : 0; q[0] << level < dims_[0]; q[0] += is_even ? 2 : 1) {
      const bool is_odd = (q[0] & 1) != 0;
      if (is_odd && !has_ends(level, q, 0)) return;
      const std::ptrdiff_t x_part = !is_odd ? 0 : (q[0] & 3) == 1 ? -strides[0] : strides[0];
      const std::uint8_t* const centre = sides + q[0] * strides[0];
      const std::uint8_t end = centre[to_end + x_part];
      if (end == *centre || end != centre[-(to_end + x_part)]) continue;
      const Diamond<3> node = diamond_at<3>(q * (std::int32_t{1} << level));
      if (*centre != hole && end != hole && is_critical(node)) found.push_back(node.centre);
    }
  }

 private:
  /// Whether both ends of the axis are samples, as far as one odd coordinate goes.
  [[nodiscard]] bool has_ends(int level, const Index<3>& q, std::size_t axis) const {
    return (q[axis] + 1) << level < dims_[axis];
  }

  /// Whether round the axis, whose ends lie on the other side than the centre, there is anything
  /// but one arc of either side. At the data's border the ring is a path: then one change of
  /// sides. Nodes with holes have infinite errors, and are refined for that.
  [[nodiscard]] bool is_critical(const Diamond<3>& node) const {
    constexpr int kNone = -1;
    Index<3> first = axis_ends<3>(node)[0] - node.centre;
    for (std::size_t i = 0; i < 3; ++i) first[i] >>= node.level;
    const Ring& ring = ring_of(first);
    std::array<int, 8> sides{};
    bool is_closed = true;
    for (std::size_t i = 0; i < ring.n; ++i) {
      const Index<3> p = node.centre + ring.steps[i] * node.h();
      bool is_sample = true;
      for (std::size_t axis = 0; axis < 3; ++axis)
        is_sample = is_sample && p[axis] >= 0 && p[axis] < dims_[axis];
      sides[i] = is_sample ? sides_[linear_index<3>(dims_, p)] : kNone;
      if (sides[i] == hole) return false;
      is_closed = is_closed && is_sample;
    }
    int n_changes = 0;
    for (std::size_t i = 0; i < ring.n; ++i) {
      const int next = sides[(i + 1) % ring.n];
      n_changes += sides[i] != kNone && next != kNone && sides[i] != next ? 1 : 0;
    }
    return n_changes != (is_closed ? 2 : 1);
  }

  Index<3> dims_;
  std::vector<std::uint8_t> sides_;  ///< x fastest.
};

}  // namespace

Result<CriticalNodes> find_critical_nodes(const Model<3>& model, double isovalue,
                                          double persistence, Threads threads,
                                          const Progress& progress) {
  CriticalNodes critical{NodeSet<3>(model.shape)};
  if (!model.shape.has_cells()) return critical;
  const NodeSides sides(model, isovalue, threads);
  const Refinable<3> nodes(model);
  const auto is_slight = [&](const Index<3>& centre) {
    const NodeFacts facts = nodes.facts_at(diamond_at<3>(centre));
    return facts.error <= persistence ||
           (facts.range.low >= isovalue - persistence && facts.range.high < isovalue + persistence);
  };
  std::mutex mutex;
  for (int level = 0; level < model.shape.n_levels; ++level) {
    if (progress.is_cancelled()) return cancelled_error();
    Index<3> dims;  // of the level's grid points those that are samples
    for (std::size_t i = 0; i < 3; ++i) dims[i] = ((model.shape.dims[i] - 1) >> level) + 1;
    const auto n_x = as_size(dims[0]);
    parallel_for(n_points<3>(dims) / n_x, threads, 64, [&](std::size_t row, int) {
      std::vector<Index<3>> found;
      sides.find_in_row(level, point_of<3>(dims, row * n_x), found);
      if (persistence > 0) std::erase_if(found, is_slight);
      if (found.empty()) return;
      const std::lock_guard lock(mutex);  // a set, whatever the order
      critical.n_critical += found.size();
      for (const Index<3>& centre : found)
        critical.nodes.insert(centre, [&](const Index<3>&) { ++critical.n_nodes; });
    });
  }
  return critical;
}

}  // namespace lode::diamond
