#include "lode/models/diamond/close_border.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <unordered_map>

#include "lode/mappers/lattice_frame.h"
#include "lode/mappers/surface_topology.h"
#include "lode/models/diamond/border_polygon.h"
#include "lode/models/diamond/cap_points.h"
#include "lode/models/diamond/surface_coordinates.h"

namespace lode::diamond {
namespace {

using Ends = std::array<std::uint32_t, 2>;

class BorderCloser {
 public:
  BorderCloser(const RegularGrid& grid, bool is_first_sample_inside, bool has_normals,
               Threads threads, Surface& surface)
      : grid_(grid),
        frame_(LatticeFrame::of(grid)),
        coordinates_(grid, surface, {}, threads),
        is_oblique_(is_oblique(frame_.to_world)),
        is_mirrored_(frame_.is_mirrored),
        is_first_sample_inside_(is_first_sample_inside),
        has_normals_(has_normals),
        surface_(surface),
        boundary_(find_boundary_edges(surface, threads)) {
    for (std::size_t i = 0; i < 3; ++i) last_[i] = grid.dims[i] - 1;
    find_rim();
  }

  Result<CapReport> close_surface() {
    LODE_CHECK(sort_edges());
    if (is_oblique_) find_samples();
    for (std::size_t p = 0; p < kBorderPlanes; ++p) {
      const BorderPlane plane(p);
      const std::size_t i = (plane.axis + 1) % 3;
      Index3 corner;
      corner[plane.axis] = plane.is_upper ? last_[plane.axis] : 0;
      polygons_[p] = polygon_of(corner, i, (i + 1) % 3, plane.is_upper == is_mirrored_, edges_[p]);
      LODE_CHECK(check_ends(p));
      LODE_CHECK(polygons_[p].walk());
    }
    settle_unknown();
    std::vector<std::array<std::uint32_t, 3>> caps;
    const std::size_t n_vertices = surface_.positions.size();  // samples are added on the way
    for (std::size_t p = 0; p < kBorderPlanes; ++p)
      if (auto done = add_cap(p, caps); !done) {
        remove_samples(n_vertices);
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
    BorderPolygon polygon;
    for (const bool is_clockwise : {false, true}) {
      polygon = polygon_of({}, i, j, is_clockwise, surface_.lines);
      LODE_CHECK(polygon.walk());
      if (!polygon.is_known) polygon.set_all(is_first_sample_inside_);
      const bool state = polygon.is_inside[is_clockwise ? polygon.is_inside.size() - 1 : 0];
      if (state == is_first_sample_inside_) break;
    }
    const std::size_t n_before = surface_.lines.size();
    add_parts(polygon, surface_.lines);
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
  [[nodiscard]] BorderPolygon polygon_of(const Index3& corner, std::size_t i, std::size_t j,
                                         bool is_clockwise, const std::vector<Ends>& edges) {
    balance_.clear();
    for (const Ends& edge : edges) {
      ++balance_[edge[0]];
      --balance_[edge[1]];
    }
    BorderPolygon polygon;
    const auto add_side = [&](std::size_t along, std::size_t across, bool at_end, bool backward) {
      Index3 start = corner;
      start[across] = at_end ? last_[across] : 0;
      start[along] = backward ? last_[along] : 0;
      const std::uint32_t vertex = corners_[corner_number(start)];
      polygon.stops.push_back({vertex, start, balance_of(vertex)});
      add_stops(corner, i, j, along, across, at_end, backward, polygon);
    };
    add_side(i, j, false, false);
    add_side(j, i, true, false);
    add_side(i, j, true, true);
    add_side(j, i, false, true);
    // Counter-clockwise in (i, j); the other way round keeps the first corner first.
    if (is_clockwise) std::reverse(polygon.stops.begin() + 1, polygon.stops.end());
    return polygon;
  }

  /// The surface's vertices and the samples on one side of the polygon, in order.
  void add_stops(const Index3& corner, std::size_t i, std::size_t j, std::size_t along,
                 std::size_t across, bool at_end, bool backward, BorderPolygon& polygon) const {
    unsigned needed = 1U << border_plane_number(across, at_end);
    const std::size_t axis = 3 - i - j;
    if (grid_.dims[axis] > 1) needed |= 1U << border_plane_number(axis, corner[axis] > 0);
    std::vector<std::pair<double, BorderStop>> found;
    for (const std::uint32_t vertex : rim_)
      if ((coordinates_.border_planes(vertex) & needed) == needed && !is_at_corner(vertex))
        found.push_back({coordinates_[vertex][along], {vertex, {}, balance_of(vertex)}});
    for (const Index3& sample : samples_)
      if (sample[axis] == corner[axis] && sample[across] == (at_end ? last_[across] : 0))
        found.push_back({1.0 * sample[along], {delaunay::kNone, sample, 0}});
    std::sort(found.begin(), found.end(), [&](const auto& a, const auto& b) {
      if (a.first != b.first) return backward ? a.first > b.first : a.first < b.first;
      return a.second.vertex < b.second.vertex;
    });
    for (const auto& [coordinate, stop] : found) polygon.stops.push_back(stop);
  }

  /// Edges in a plane may end only on the border polygon.
  [[nodiscard]] Result<void> check_ends(std::size_t p) const {
    std::size_t n_ends = 0;
    for (const auto& [vertex, balance] : balance_) n_ends += balance != 0 ? 1 : 0;
    for (const BorderStop& stop : polygons_[p].stops) n_ends -= stop.balance != 0 ? 1 : 0;
    if (n_ends != 0)
      return fail("the surface cannot be closed: it ends inside a border plane of the domain");
    return {};
  }

  /// Planes whose polygon no edge reaches take the state from a neighbour, across their side.
  void settle_unknown() {
    const auto is_any_known = std::any_of(polygons_.begin(), polygons_.end(),
                                          [](const BorderPolygon& c) { return c.is_known; });
    if (!is_any_known) {
      for (BorderPolygon& polygon : polygons_) polygon.set_all(is_first_sample_inside_);
      return;
    }
    for (bool is_changed = true; is_changed;) {
      is_changed = false;
      for (std::size_t p = 0; p < kBorderPlanes; ++p) {
        if (polygons_[p].is_known) continue;
        for (std::size_t q = 0; q < kBorderPlanes && !polygons_[p].is_known; ++q) {
          if (q / 2 == p / 2 || !polygons_[q].is_known) continue;
          if (const auto state = state_at_side(polygons_[q], BorderPlane(p)))
            polygons_[p].set_all(*state);
        }
        is_changed = is_changed || polygons_[p].is_known;
      }
    }
  }

  /// Whether the part of a polygon that starts or ends in a corner of another plane, and lies in
  /// that, is inside.
  [[nodiscard]] std::optional<bool> state_at_side(const BorderPolygon& polygon,
                                                  const BorderPlane& plane) const {
    const auto is_in = [&](const BorderStop& stop) {
      if (stop.vertex != delaunay::kNone)
        return ((coordinates_.border_planes(stop.vertex) >>
                 border_plane_number(plane.axis, plane.is_upper)) &
                1U) != 0;
      return stop.sample[plane.axis] == (plane.is_upper ? last_[plane.axis] : 0);
    };
    for (std::size_t n = 0; n < polygon.stops.size(); ++n)
      if (is_in(polygon.stops[n]) && is_in(polygon.stops[(n + 1) % polygon.stops.size()]))
        return polygon.is_inside[n];
    return {};
  }

  [[nodiscard]] bool is_corner(const Index3& sample) const {
    for (std::size_t i = 0; i < 3; ++i)
      if (sample[i] != 0 && sample[i] != last_[i]) return false;
    return true;
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
        if (grid_.dims[i] > 1) planes |= 1U << border_plane_number(i, ((number >> i) & 1) != 0);
      for (const std::uint32_t v : rim_)
        if (coordinates_.border_planes(v) == planes) corners_[number] = v;
    }
  }

  /// Samples on the domain's edges with vertices hardly beside them. As vertices, they keep the
  /// caps' triangles there from reaching past several such vertices, so close to the line from one
  /// to the next that rounding decides on which side they are.
  void find_samples() {
    constexpr double kNear = 1.0 / 16;
    std::vector<Index3> taken;  // by a vertex
    for (const std::uint32_t v : rim_) {
      Index3 sample;
      double distance = 0;
      int n_planes = 0;
      for (std::size_t i = 0; i < 3; ++i) {
        sample[i] = static_cast<std::int32_t>(std::lround(coordinates_[v][i]));
        distance = std::max(distance, std::abs(coordinates_[v][i] - sample[i]));
        n_planes += sample[i] == 0 || sample[i] == last_[i] ? 1 : 0;
      }
      if (n_planes != 2 || distance >= kNear) continue;
      (distance < frame_.margin / 2 ? taken : samples_).push_back(sample);
    }
    const auto by_coordinates = [](const Index3& a, const Index3& b) { return a.v < b.v; };
    std::sort(taken.begin(), taken.end(), by_coordinates);
    std::sort(samples_.begin(), samples_.end(), by_coordinates);
    samples_.erase(std::unique(samples_.begin(), samples_.end()), samples_.end());
    std::erase_if(samples_, [&](const Index3& sample) {
      return std::binary_search(taken.begin(), taken.end(), sample, by_coordinates);
    });
  }

  std::uint32_t vertex_of(const BorderStop& stop) {
    if (stop.vertex != delaunay::kNone) return stop.vertex;
    if (is_corner(stop.sample)) {
      const std::uint32_t corner = corners_[corner_number(stop.sample)];
      if (corner != delaunay::kNone) return corner;
    }
    const auto [entry, is_new] = added_.try_emplace(stop.sample.v, 0U);
    if (is_new) {
      entry->second = add_sample(stop.sample);
      added_samples_.push_back(stop.sample);
    }
    return entry->second;
  }

  std::uint32_t add_sample(const Index3& sample) {
    const Vec3d p = frame_.position({{1.0 * sample[0], 1.0 * sample[1], 1.0 * sample[2]}});
    surface_.positions.push_back(
        {{static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])}});
    if (has_normals_) {
      Vec3d normal;
      for (std::size_t i = 0; i < 3; ++i)
        if (sample[i] == 0 || sample[i] == last_[i]) normal = normal + outward(i, sample[i] > 0);
      const Vec3d n = normalized(normal);
      surface_.normals.push_back(
          {{static_cast<float>(n[0]), static_cast<float>(n[1]), static_cast<float>(n[2])}});
    }
    if (!surface_.isovalues.empty()) surface_.isovalues.push_back(surface_.isovalues.front());
    return static_cast<std::uint32_t>(surface_.positions.size() - 1);
  }

  void remove_samples(std::size_t n_vertices) {
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

  void add_parts(const BorderPolygon& polygon, std::vector<Ends>& edges) {
    for (std::size_t n = 0; n < polygon.stops.size(); ++n)
      if (polygon.is_inside[n]) {
        const std::uint32_t from = vertex_of(polygon.stops[n]);
        edges.push_back({from, vertex_of(polygon.stops[(n + 1) % polygon.stops.size()])});
      }
  }

  Result<void> add_cap(std::size_t p, std::vector<std::array<std::uint32_t, 3>>& caps) {
    std::vector<Ends> edges = edges_[p];
    add_parts(polygons_[p], edges);
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

  [[nodiscard]] std::vector<delaunay::Point> project(
      std::size_t p, const std::vector<std::uint32_t>& vertices) const {
    std::vector<CapVertex> on_cap;
    on_cap.reserve(vertices.size());
    for (const std::uint32_t v : vertices)
      on_cap.push_back({lattice_position(v), surface_.positions[v]});
    return cap_points(frame_, coordinates_.rounding(), BorderPlane(p), on_cap);
  }

  /// Of a vertex of the surface, or of a sample that has become one.
  [[nodiscard]] Vec3d lattice_position(std::uint32_t v) const {
    if (v < coordinates_.size()) return coordinates_[v];
    const Index3& sample = added_samples_[v - coordinates_.size()];
    return {{1.0 * sample[0], 1.0 * sample[1], 1.0 * sample[2]}};
  }

  const RegularGrid& grid_;
  LatticeFrame frame_;
  SurfaceCoordinates coordinates_;
  bool is_oblique_;
  bool is_mirrored_;
  bool is_first_sample_inside_;
  bool has_normals_;
  Surface& surface_;
  std::vector<Ends> boundary_;
  Index3 last_;
  std::array<std::vector<Ends>, kBorderPlanes> edges_;
  std::array<BorderPolygon, kBorderPlanes> polygons_;
  std::unordered_map<std::uint32_t, int> balance_;  ///< Of the plane at hand.
  std::vector<std::uint32_t> rim_;
  std::array<std::uint32_t, 8> corners_;  ///< Vertices in the domain's corners, as far as any.
  std::vector<Index3> samples_;           ///< Those find_samples() found.
  std::map<std::array<std::int32_t, 3>, std::uint32_t> added_;  ///< Samples that are vertices now.
  std::vector<Index3> added_samples_;                           ///< By vertex.
  std::uint64_t n_open_ = 0;
};

}  // namespace

Result<CapReport> close_border(const RegularGrid& grid, bool is_first_sample_inside,
                               bool has_normals, Threads threads, Surface& surface) {
  if (surface.is_empty() && !is_first_sample_inside) return CapReport{};
  const bool is_image = std::ranges::find(grid.dims.v, 1) != grid.dims.v.end();
  if (surface.is_empty()) surface.origin = LatticeFrame::of(grid).surface_origin;
  const bool keeps_normals =
      surface.is_empty() ? has_normals && !is_image : !surface.normals.empty();
  BorderCloser closer(grid, is_first_sample_inside, keeps_normals, threads, surface);
  return is_image ? closer.close_lines() : closer.close_surface();
}

}  // namespace lode::diamond
