#include "bench/tetra_errors.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace lode::bench {
namespace {

// A point so little outside, as a share of a tetrahedron's height, is inside: it may only have been
// rounded there.
constexpr double kSlack = 1e-9;

/// What one point has found so far.
class Search {
 public:
  Search(const TetraField& field, const Vec3d& p) : field_(field), p_(p) {}

  void look_inside(std::size_t tetrahedron);
  void look_at_surface(std::size_t tetrahedron);

  [[nodiscard]] bool is_inside() const { return weight_ >= -kSlack; }
  [[nodiscard]] double distance() const { return nearest_.distance; }
  [[nodiscard]] Located found() const { return is_inside() ? Located{value_, 0} : nearest_; }

 private:
  struct Corner {
    Vec3d position;  ///< From the point that is looked for.
    double value = 0;
  };
  using Corners = std::array<Corner, 4>;

  [[nodiscard]] Corners corners_of(std::size_t tetrahedron) const {
    Corners corners;
    const auto& ids = field_.tetrahedra[tetrahedron];
    for (std::size_t i = 0; i < 4; ++i)
      corners[i] = {field_.positions[ids[i]] - p_, field_.values[ids[i]]};
    return corners;
  }
  void offer(double distance, double value) {
    if (distance < nearest_.distance) nearest_ = {value, distance};
  }
  void look_at_edge(const Corner& a, const Corner& b);
  void look_at_face(const std::array<const Corner*, 3>& corners);

  const TetraField& field_;
  const Vec3d& p_;
  double weight_ = -std::numeric_limits<double>::infinity();  ///< Largest smallest one so far.
  double value_ = 0;
  Located nearest_{0, std::numeric_limits<double>::infinity()};
};

double volume(const Vec3d& a, const Vec3d& b, const Vec3d& c) { return dot(cross(a, b), c); }

void Search::look_inside(std::size_t tetrahedron) {
  const Corners c = corners_of(tetrahedron);
  const auto& [a, b, d, e] = c;
  const double whole =
      volume(b.position - a.position, d.position - a.position, e.position - a.position);
  if (whole == 0) return;
  const std::array<double, 4> weights{volume(b.position, d.position, e.position) / whole,
                                      -volume(a.position, d.position, e.position) / whole,
                                      volume(a.position, b.position, e.position) / whole,
                                      -volume(a.position, b.position, d.position) / whole};
  const double least = *std::ranges::min_element(weights);
  if (!(least > weight_)) return;
  weight_ = least;
  value_ = 0;
  for (std::size_t i = 0; i < 4; ++i) value_ += weights[i] * c[i].value;
}

void Search::look_at_surface(std::size_t tetrahedron) {
  const Corners c = corners_of(tetrahedron);
  for (std::size_t i = 0; i < 4; ++i) {
    look_at_face({&c[i], &c[(i + 1) % 4], &c[(i + 2) % 4]});
    for (std::size_t j = 0; j < i; ++j) look_at_edge(c[i], c[j]);
  }
}

void Search::look_at_edge(const Corner& a, const Corner& b) {
  const Vec3d along = b.position - a.position;
  const double square = dot(along, along);
  const double t = square > 0 ? std::clamp(-dot(a.position, along) / square, 0.0, 1.0) : 0;
  offer(length(a.position + along * t), a.value + (b.value - a.value) * t);
}

/// Where the nearest point is not inside the face, it is on an edge.
void Search::look_at_face(const std::array<const Corner*, 3>& corners) {
  const auto& [a, b, c] = corners;
  const Vec3d normal = cross(b->position - a->position, c->position - a->position);
  const double square = dot(normal, normal);
  if (square == 0) return;
  const std::array<double, 3> weights{volume(b->position, c->position, normal) / square,
                                      volume(c->position, a->position, normal) / square,
                                      volume(a->position, b->position, normal) / square};
  if (*std::ranges::min_element(weights) < 0) return;
  offer(std::abs(dot(normal, a->position)) / std::sqrt(square),
        weights[0] * a->value + weights[1] * b->value + weights[2] * c->value);
}

Located locate_among_all(const TetraField& field, const Vec3d& p) {
  Search search(field, p);
  for (std::size_t t = 0; t < field.tetrahedra.size(); ++t) {
    search.look_inside(t);
    search.look_at_surface(t);
  }
  return search.found();
}

}  // namespace

TetraLocator::TetraLocator(const TetraField& field) : field_(field) {
  set_lattice();
  const auto n_cells = number(dims_[0] - 1, dims_[1] - 1, dims_[2] - 1) + 1;
  begins_.assign(n_cells + 1, 0);
  for (std::size_t t = 0; t < field_.tetrahedra.size(); ++t)
    visit_cells_of(t, [&](std::size_t cell) { ++begins_[cell + 1]; });
  for (std::size_t cell = 0; cell < n_cells; ++cell) begins_[cell + 1] += begins_[cell];
  tetrahedra_.resize(begins_.back());
  std::vector<std::uint64_t> next(begins_.begin(), begins_.end() - 1);
  for (std::size_t t = 0; t < field_.tetrahedra.size(); ++t)
    visit_cells_of(
        t, [&](std::size_t cell) { tetrahedra_[next[cell]++] = static_cast<std::uint32_t>(t); });
}

/// About a cell for each tetrahedron.
void TetraLocator::set_lattice() {
  lower_ = field_.positions.front();
  Vec3d upper = lower_;
  for (const Vec3d& p : field_.positions)
    for (std::size_t i = 0; i < 3; ++i) {
      lower_[i] = std::min(lower_[i], p[i]);
      upper[i] = std::max(upper[i], p[i]);
    }
  const Vec3d size = upper - lower_;
  const auto n = static_cast<double>(field_.tetrahedra.size());
  edge_ = std::cbrt(size[0] * size[1] * size[2] / n);
  // Also where the mesh is flat.
  edge_ = std::max(edge_, std::max({size[0], size[1], size[2]}) / 1024);
  for (std::size_t i = 0; i < 3; ++i) dims_[i] = static_cast<int>(size[i] / edge_) + 1;
}

int TetraLocator::index(double x, std::size_t axis) const {
  const double cell = std::floor((x - lower_[axis]) / edge_);
  return static_cast<int>(std::clamp(cell, 0.0, static_cast<double>(dims_[axis] - 1)));
}

std::size_t TetraLocator::number(int x, int y, int z) const {
  return (static_cast<std::size_t>(z) * static_cast<std::size_t>(dims_[1]) +
          static_cast<std::size_t>(y)) *
             static_cast<std::size_t>(dims_[0]) +
         static_cast<std::size_t>(x);
}

template <typename Visit>
void TetraLocator::visit_cells_of(std::size_t tetrahedron, const Visit& visit) const {
  Cell low = dims_;
  Cell high{};
  for (const std::uint32_t corner : field_.tetrahedra[tetrahedron])
    for (std::size_t i = 0; i < 3; ++i) {
      const int at = index(field_.positions[corner][i], i);
      low[i] = std::min(low[i], at);
      high[i] = std::max(high[i], at);
    }
  for (int z = low[2]; z <= high[2]; ++z)
    for (int y = low[1]; y <= high[1]; ++y)
      for (int x = low[0]; x <= high[0]; ++x) visit(number(x, y, z));
}

/// The tetrahedra in the cells that are `ring` away from one.
template <typename Visit>
void TetraLocator::visit_ring(const Cell& at, int ring, const Visit& visit) const {
  const auto low = [&](std::size_t i) { return std::max(0, at[i] - ring); };
  const auto high = [&](std::size_t i) { return std::min(dims_[i] - 1, at[i] + ring); };
  for (int z = low(2); z <= high(2); ++z)
    for (int y = low(1); y <= high(1); ++y)
      for (int x = low(0); x <= high(0); ++x) {
        const int away = std::max({std::abs(x - at[0]), std::abs(y - at[1]), std::abs(z - at[2])});
        if (away != ring) continue;
        const std::size_t cell = number(x, y, z);
        for (std::uint64_t i = begins_[cell]; i < begins_[cell + 1]; ++i) visit(tetrahedra_[i]);
      }
}

/// How near may be what lies in none of the cells up to `ring` away; infinite where these are all.
double TetraLocator::reach(const Vec3d& p, const Cell& at, int ring) const {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 3; ++i) {
    if (at[i] - ring > 0) least = std::min(least, p[i] - (lower_[i] + (at[i] - ring) * edge_));
    if (at[i] + ring < dims_[i] - 1)
      least = std::min(least, lower_[i] + (at[i] + ring + 1) * edge_ - p[i]);
  }
  return least;
}

Located TetraLocator::locate(const Vec3d& p) const {
  const Cell at{index(p[0], 0), index(p[1], 1), index(p[2], 2)};
  Search search(field_, p);
  visit_ring(at, 0, [&](std::uint32_t t) { search.look_inside(t); });
  if (search.is_inside()) return search.found();
  const int most = std::max({dims_[0], dims_[1], dims_[2]});
  for (int ring = 0; ring <= most; ++ring) {
    visit_ring(at, ring, [&](std::uint32_t t) { search.look_at_surface(t); });
    if (search.distance() <= reach(p, at, ring)) break;
  }
  return search.found();
}

FieldErrors measure_errors(const TetraMesh& reference, const TetraField& simplified,
                           Threads threads) {
  const TetraLocator locator(simplified);
  std::vector<Located> found(reference.positions.size());
  parallel_for(found.size(), threads, 1024, [&](std::size_t v, int /*worker*/) {
    found[v] = locator.locate(reference.positions[v]);
  });
  FieldErrors errors;
  double squares = 0;
  for (std::size_t v = 0; v < found.size(); ++v) {
    const double error = std::abs(found[v].value - reference.fields.front().values[v]);
    errors.max = std::max(errors.max, error);
    errors.farthest = std::max(errors.farthest, found[v].distance);
    squares += error * error;
  }
  errors.rms = std::sqrt(squares / static_cast<double>(found.size()));
  return errors;
}

Result<void> check_locator(const TetraField& mesh) {
  // Both ways round a value off by some 1e-16 of what is summed, on a tetrahedron whose smallest
  // height is above 1e-4; what is taken for inside may be kSlack off. The sides of the box that was
  // simplified may be a millionth of an edge off.
  constexpr double kSame = 1e-8;
  constexpr double kKnown = 1e-5;
  constexpr int kPoints = 14;
  const auto plane = [](const Vec3d& p) { return 1 + p[0] - 2 * p[1] + 3 * p[2]; };
  std::vector<double> planar;
  for (const Vec3d& p : mesh.positions) planar.push_back(plane(p));
  const TetraField known{mesh.positions, planar, mesh.tetrahedra};
  const TetraLocator locator(mesh);
  const TetraLocator known_locator(known);
  for (int i = 0; i < kPoints * kPoints * kPoints; ++i) {
    // From -0.25 to 1.375: vertices of a 9^3 mesh, points between them, and points outside.
    Vec3d p{{i % kPoints * 0.125, i / kPoints % kPoints * 0.125, i / kPoints / kPoints * 0.125}};
    for (double& x : p.v) x -= 0.25;
    if (i % 2 == 1) p = p + Vec3d{{0.031, 0.047, 0.011}};
    Vec3d nearest = p;
    for (double& x : nearest.v) x = std::clamp(x, 0.0, 1.0);
    const Located a = locator.locate(p);
    const Located b = locate_among_all(mesh, p);
    const Located c = known_locator.locate(p);
    if (!(std::abs(a.value - b.value) < kSame && std::abs(a.distance - b.distance) < kSame))
      return fail("locator at ({}, {}, {}): expected {} at {}, got {} at {}", p[0], p[1], p[2],
                  b.value, b.distance, a.value, a.distance);
    if (!(std::abs(c.value - plane(nearest)) < kKnown &&
          std::abs(c.distance - length(p - nearest)) < kKnown))
      return fail("locator at ({}, {}, {}): expected a plane's {} at {}, got {} at {}", p[0], p[1],
                  p[2], plane(nearest), length(p - nearest), c.value, c.distance);
  }
  return {};
}

}  // namespace lode::bench
