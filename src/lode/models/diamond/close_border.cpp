#include "lode/models/diamond/close_border.h"

#include <algorithm>
#include <optional>
#include <unordered_map>

#include "lode/delaunay/triangulation.h"
#include "lode/mappers/lattice_frame.h"
#include "lode/mappers/surface_topology.h"
#include "lode/models/diamond/surface_coordinates.h"

namespace lode::diamond {
namespace {

using Ends = std::array<std::uint32_t, 2>;

/// A border plane: an axis and which of its two ends. Its number is its bit in
/// SurfaceCoordinates::border_planes().
struct Plane {
  std::size_t axis;
  bool is_upper;

  explicit Plane(std::size_t number) : axis(number / 2), is_upper(number % 2 == 1) {}
};
constexpr std::size_t kPlanes = 6;

constexpr std::size_t plane_number(std::size_t axis, bool is_upper) {
  return 2 * axis + (is_upper ? 1 : 0);
}

/// A corner of the domain's border polygon, or a vertex of the surface on it.
struct Stop {
  std::uint32_t vertex = delaunay::kNone;  ///< kNone: a corner that is no vertex yet.
  Index3 corner;                           ///< In samples; for corners only.
  int balance = 0;                         ///< Edges in the plane that start here - that end here.
};

/// The border polygon of one plane, counter-clockwise as seen from outside: which parts of it, from
/// each stop to the next, are inside.
struct Cycle {
  std::vector<Stop> stops;
  std::vector<bool> is_inside;
  bool is_known = false;

  /// An edge that ends here goes on along the border; one that starts here came along it.
  [[nodiscard]] Result<void> walk() {
    const auto turning = std::find_if(stops.begin(), stops.end(),
                                      [](const Stop& stop) { return stop.balance != 0; });
    if (turning == stops.end()) return {};
    is_inside.assign(stops.size(), false);
    const auto first = static_cast<std::size_t>(turning - stops.begin());
    bool state = turning->balance > 0;
    for (std::size_t n = 0; n < stops.size(); ++n) {
      const std::size_t i = (first + n) % stops.size();
      if (stops[i].balance != 0) {
        if (std::abs(stops[i].balance) != 1 || state != (stops[i].balance > 0))
          return fail("the surface's edges there do not alternate along an edge of the domain");
        state = !state;
      }
      is_inside[i] = state;
    }
    is_known = true;
    return {};
  }
  void set_all(bool state) {
    is_inside.assign(stops.size(), state);
    is_known = true;
  }
};

class BorderCloser {
 public:
  BorderCloser(const RegularGrid& grid, bool is_first_sample_inside, Threads threads,
               Surface& surface)
      : grid_(grid),
        frame_(LatticeFrame::of(grid)),
        coordinates_(grid, surface, {}, threads),
        is_first_sample_inside_(is_first_sample_inside),
        surface_(surface),
        boundary_(find_boundary_edges(surface, threads)) {
    for (std::size_t i = 0; i < 3; ++i) last_[i] = grid.dims[i] - 1;
    find_rim();
  }

  Result<CapReport> close_surface() {
    LODE_CHECK(sort_edges());
    for (std::size_t p = 0; p < kPlanes; ++p) {
      const Plane plane(p);
      const std::size_t i = (plane.axis + 1) % 3;
      const bool is_mirrored = determinant(grid_.index_to_world_matrix()) < 0;
      Index3 corner;
      corner[plane.axis] = plane.is_upper ? last_[plane.axis] : 0;
      cycles_[p] = cycle_of(corner, i, (i + 1) % 3, plane.is_upper == is_mirrored, edges_[p]);
      LODE_CHECK(check_ends(p));
      LODE_CHECK(cycles_[p].walk());
    }
    settle_unknown();
    std::vector<std::array<std::uint32_t, 3>> caps;
    const std::size_t n_vertices = surface_.positions.size();  // corners are added on the way
    for (std::size_t p = 0; p < kPlanes; ++p)
      if (auto done = add_cap(p, caps); !done) {
        remove_corners(n_vertices);
        return done.error();
      }
    surface_.triangles.insert(surface_.triangles.end(), caps.begin(), caps.end());
    return CapReport{caps.size(), n_open_};
  }

  Result<CapReport> close_lines() {
    const auto flat = static_cast<std::size_t>(
        std::find(grid_.dims.v.begin(), grid_.dims.v.end(), 1) - grid_.dims.v.begin());
    const std::size_t i = flat == 0 ? 1 : 0;
    const std::size_t j = 3 - flat - i;
    for (const Ends& end : boundary_)
      if (!coordinates_.are_on_border(std::span(end).first(1))) ++n_open_;
    // Which way round the lines turn follows from the side on which the first sample is.
    Cycle cycle;
    for (const bool is_clockwise : {false, true}) {
      cycle = cycle_of({}, i, j, is_clockwise, surface_.lines);
      LODE_CHECK(cycle.walk());
      if (!cycle.is_known) cycle.set_all(is_first_sample_inside_);
      const bool state = cycle.is_inside[is_clockwise ? cycle.is_inside.size() - 1 : 0];
      if (state == is_first_sample_inside_) break;
    }
    const std::size_t n_before = surface_.lines.size();
    add_parts(cycle, surface_.lines);
    return CapReport{surface_.lines.size() - n_before, n_open_};
  }

 private:
  /// Puts each boundary edge, turned round for the cap, into its plane.
  Result<void> sort_edges() {
    for (const Ends& edge : boundary_) {
      const unsigned planes =
          coordinates_.border_planes(edge[0]) & coordinates_.border_planes(edge[1]);
      if (planes == 0) {
        ++n_open_;
        continue;
      }
      const auto p = static_cast<std::size_t>(std::countr_zero(planes));
      if ((planes & (planes - 1)) != 0)
        return fail("the surface cannot be closed: it ends along an edge of the domain");
      edges_[p].push_back({edge[1], edge[0]});
    }
    return {};
  }

  /// The border polygon in the plane of axes i and j through `corner` (with i and j at 0).
  [[nodiscard]] Cycle cycle_of(const Index3& corner, std::size_t i, std::size_t j,
                               bool is_clockwise, const std::vector<Ends>& edges) {
    balance_.clear();
    for (const Ends& edge : edges) {
      ++balance_[edge[0]];
      --balance_[edge[1]];
    }
    Cycle cycle;
    const auto add_side = [&](std::size_t along, std::size_t across, bool at_end, bool backward) {
      Index3 start = corner;
      start[across] = at_end ? last_[across] : 0;
      start[along] = backward ? last_[along] : 0;
      const std::uint32_t vertex = corners_[corner_number(start)];
      cycle.stops.push_back({vertex, start, balance_of(vertex)});
      add_stops(corner, i, j, along, across, at_end, backward, cycle);
    };
    add_side(i, j, false, false);
    add_side(j, i, true, false);
    add_side(i, j, true, true);
    add_side(j, i, false, true);
    // Counter-clockwise in (i, j); the other way round keeps the first corner first.
    if (is_clockwise) std::reverse(cycle.stops.begin() + 1, cycle.stops.end());
    return cycle;
  }

  /// The surface's vertices on one side of the polygon, in order.
  void add_stops(const Index3& corner, std::size_t i, std::size_t j, std::size_t along,
                 std::size_t across, bool at_end, bool backward, Cycle& cycle) const {
    unsigned needed = 1U << plane_number(across, at_end);
    const std::size_t axis = 3 - i - j;
    if (grid_.dims[axis] > 1) needed |= 1U << plane_number(axis, corner[axis] > 0);
    std::vector<std::uint32_t> vertices;
    for (const std::uint32_t vertex : rim_)
      if ((coordinates_.border_planes(vertex) & needed) == needed && !is_at_corner(vertex))
        vertices.push_back(vertex);
    std::sort(vertices.begin(), vertices.end(), [&](std::uint32_t a, std::uint32_t b) {
      const double x = coordinates_[a][along];
      const double y = coordinates_[b][along];
      return x != y ? (backward ? x > y : x < y) : a < b;
    });
    for (const std::uint32_t v : vertices) cycle.stops.push_back({v, {}, balance_of(v)});
  }

  /// Edges in a plane may end only on the border polygon.
  [[nodiscard]] Result<void> check_ends(std::size_t p) const {
    std::size_t n_ends = 0;
    for (const auto& [vertex, balance] : balance_) n_ends += balance != 0 ? 1 : 0;
    for (const Stop& stop : cycles_[p].stops) n_ends -= stop.balance != 0 ? 1 : 0;
    if (n_ends != 0)
      return fail("the surface cannot be closed: it ends inside a border plane of the domain");
    return {};
  }

  /// Planes whose polygon no edge reaches take the state from a neighbour, across their side.
  void settle_unknown() {
    const auto is_any_known =
        std::any_of(cycles_.begin(), cycles_.end(), [](const Cycle& c) { return c.is_known; });
    if (!is_any_known) {
      for (Cycle& cycle : cycles_) cycle.set_all(is_first_sample_inside_);
      return;
    }
    for (bool is_changed = true; is_changed;) {
      is_changed = false;
      for (std::size_t p = 0; p < kPlanes; ++p) {
        if (cycles_[p].is_known) continue;
        for (std::size_t q = 0; q < kPlanes && !cycles_[p].is_known; ++q) {
          if (q / 2 == p / 2 || !cycles_[q].is_known) continue;
          if (const auto state = state_at_side(cycles_[q], Plane(p))) cycles_[p].set_all(*state);
        }
        is_changed = is_changed || cycles_[p].is_known;
      }
    }
  }

  /// Whether the part of a cycle that starts or ends in a corner of another plane, and lies in
  /// that, is inside.
  [[nodiscard]] std::optional<bool> state_at_side(const Cycle& cycle, const Plane& plane) const {
    const auto is_in = [&](const Stop& stop) {
      if (stop.vertex != delaunay::kNone)
        return ((coordinates_.border_planes(stop.vertex) >>
                 plane_number(plane.axis, plane.is_upper)) &
                1U) != 0;
      return stop.corner[plane.axis] == (plane.is_upper ? last_[plane.axis] : 0);
    };
    for (std::size_t n = 0; n < cycle.stops.size(); ++n)
      if (is_in(cycle.stops[n]) && is_in(cycle.stops[(n + 1) % cycle.stops.size()]))
        return cycle.is_inside[n];
    return {};
  }

  [[nodiscard]] static std::size_t corner_number(const Index3& corner) {
    std::size_t number = 0;
    for (std::size_t i = 0; i < 3; ++i) number |= corner[i] > 0 ? std::size_t{1} << i : 0;
    return number;
  }

  [[nodiscard]] bool is_at_corner(std::uint32_t vertex) const {
    return std::find(corners_.begin(), corners_.end(), vertex) != corners_.end();
  }

  [[nodiscard]] int balance_of(std::uint32_t vertex) const {
    const auto at = balance_.find(vertex);
    return at == balance_.end() ? 0 : at->second;
  }

  /// The surface's vertices in the border, and those of them in the domain's corners.
  void find_rim() {
    for (const Ends& edge : boundary_)
      for (const std::uint32_t v : edge)
        if (coordinates_.border_planes(v) != 0) rim_.push_back(v);
    std::sort(rim_.begin(), rim_.end());
    rim_.erase(std::unique(rim_.begin(), rim_.end()), rim_.end());
    corners_.fill(delaunay::kNone);
    for (std::size_t number = 0; number < corners_.size(); ++number) {
      unsigned planes = 0;
      for (std::size_t i = 0; i < 3; ++i)
        if (grid_.dims[i] > 1) planes |= 1U << plane_number(i, ((number >> i) & 1) != 0);
      for (const std::uint32_t v : rim_)
        if (coordinates_.border_planes(v) == planes) corners_[number] = v;
    }
  }

  std::uint32_t vertex_of(const Stop& stop) {
    if (stop.vertex != delaunay::kNone) return stop.vertex;
    std::uint32_t& corner = corners_[corner_number(stop.corner)];
    if (corner == delaunay::kNone) corner = add_corner(stop.corner);
    return corner;
  }

  std::uint32_t add_corner(const Index3& corner) {
    const Vec3d p =
        frame_.position({{static_cast<double>(corner[0]), static_cast<double>(corner[1]),
                          static_cast<double>(corner[2])}});
    surface_.positions.push_back(
        {{static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])}});
    if (!surface_.normals.empty()) {
      Vec3d normal;
      for (std::size_t i = 0; i < 3; ++i) normal = normal + outward(i, corner[i] > 0);
      const Vec3d n = normalized(normal);
      surface_.normals.push_back(
          {{static_cast<float>(n[0]), static_cast<float>(n[1]), static_cast<float>(n[2])}});
    }
    if (!surface_.isovalues.empty()) surface_.isovalues.push_back(surface_.isovalues.front());
    return static_cast<std::uint32_t>(surface_.positions.size() - 1);
  }

  void remove_corners(std::size_t n_vertices) {
    surface_.positions.resize(n_vertices);
    if (!surface_.normals.empty()) surface_.normals.resize(n_vertices);
    if (!surface_.isovalues.empty()) surface_.isovalues.resize(n_vertices);
  }

  /// The plane's unit normal in the world, away from the domain.
  [[nodiscard]] Vec3d outward(std::size_t axis, bool is_upper) const {
    const Mat3 matrix = grid_.index_to_world_matrix();
    const double sign = (determinant(matrix) < 0) == is_upper ? -1 : 1;
    return sign * normalized(cofactors(matrix).column(axis));
  }

  void add_parts(const Cycle& cycle, std::vector<Ends>& edges) {
    for (std::size_t n = 0; n < cycle.stops.size(); ++n)
      if (cycle.is_inside[n]) {
        const std::uint32_t from = vertex_of(cycle.stops[n]);
        edges.push_back({from, vertex_of(cycle.stops[(n + 1) % cycle.stops.size()])});
      }
  }

  Result<void> add_cap(std::size_t p, std::vector<std::array<std::uint32_t, 3>>& caps) {
    std::vector<Ends> edges = edges_[p];
    add_parts(cycles_[p], edges);
    if (edges.empty()) return {};
    // Numbers of their own, in the order of the surface's vertices.
    std::vector<std::uint32_t> vertices;
    for (const Ends& edge : edges) vertices.insert(vertices.end(), edge.begin(), edge.end());
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    for (Ends& edge : edges)
      for (std::uint32_t& end : edge)
        end = static_cast<std::uint32_t>(std::lower_bound(vertices.begin(), vertices.end(), end) -
                                         vertices.begin());
    auto triangles = delaunay::triangulate_region(project(p, vertices), edges);
    if (!triangles)
      return fail("the surface cannot be closed in the border plane {} of axis {}: {}",
                  p % 2 == 0 ? "at the start" : "at the end", p / 2, triangles.error().message);
    for (const auto& t : *triangles)
      caps.push_back({vertices[t[0]], vertices[t[1]], vertices[t[2]]});
    return {};
  }

  /// Positions in the plane, seen from outside, without the coordinate that varies least: those
  /// written, so that what is exact there is exact in the file.
  [[nodiscard]] std::vector<delaunay::Point> project(
      std::size_t p, const std::vector<std::uint32_t>& vertices) const {
    const Vec3d normal = outward(Plane(p).axis, Plane(p).is_upper);
    std::size_t drop = 0;
    for (std::size_t i = 1; i < 3; ++i)
      if (std::abs(normal[i]) > std::abs(normal[drop])) drop = i;
    std::size_t x = (drop + 1) % 3;
    std::size_t y = (drop + 2) % 3;
    if (normal[drop] < 0) std::swap(x, y);
    std::vector<delaunay::Point> points;
    points.reserve(vertices.size());
    for (const std::uint32_t v : vertices)
      points.push_back({{static_cast<double>(surface_.positions[v][x]),
                         static_cast<double>(surface_.positions[v][y])}});
    return points;
  }

  const RegularGrid& grid_;
  LatticeFrame frame_;
  SurfaceCoordinates coordinates_;
  bool is_first_sample_inside_;
  Surface& surface_;
  std::vector<Ends> boundary_;
  Index3 last_;
  std::array<std::vector<Ends>, kPlanes> edges_;
  std::array<Cycle, kPlanes> cycles_;
  std::unordered_map<std::uint32_t, int> balance_;  ///< Of the plane at hand.
  std::vector<std::uint32_t> rim_;
  std::array<std::uint32_t, 8> corners_;  ///< Vertices in the domain's corners, as far as any.
  std::uint64_t n_open_ = 0;
};

}  // namespace

Result<CapReport> close_border(const RegularGrid& grid, bool is_first_sample_inside,
                               Threads threads, Surface& surface) {
  if (surface.is_empty()) return CapReport{};
  BorderCloser closer(grid, is_first_sample_inside, threads, surface);
  return surface.triangles.empty() ? closer.close_lines() : closer.close_surface();
}

}  // namespace lode::diamond
