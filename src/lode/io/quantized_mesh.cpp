#include "lode/io/quantized_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "lode/core/ellipsoid.h"
#include "lode/core/vec.h"
#include "lode/io/quantized_mesh_layout.h"

namespace lode::io {
namespace {

using Place = Vec<double, 3>;

constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();

double semi_minor() {
  return kWgs84Ellipsoid.semi_major * (1 - 1 / kWgs84Ellipsoid.inverse_flattening);
}

Place to_unit_sphere(const Place& p) {
  const double a = kWgs84Ellipsoid.semi_major;
  return {p[0] / a, p[1] / a, p[2] / semi_minor()};
}

/// Earth-centred, earth-fixed.
Place to_earth(double longitude, double latitude, double height) {
  constexpr double kRadian = std::numbers::pi / 180;
  const double flattening = 1 / kWgs84Ellipsoid.inverse_flattening;
  const double e2 = flattening * (2 - flattening);
  const double sine = std::sin(latitude * kRadian);
  const double cosine = std::cos(latitude * kRadian);
  const double across = kWgs84Ellipsoid.semi_major / std::sqrt(1 - e2 * sine * sine);
  return {(across + height) * cosine * std::cos(longitude * kRadian),
          (across + height) * cosine * std::sin(longitude * kRadian),
          (across * (1 - e2) + height) * sine};
}

std::vector<Place> places_of(const QuantizedMesh& mesh) {
  std::vector<Place> places;
  places.reserve(mesh.nodes.size());
  for (std::size_t v = 0; v < mesh.nodes.size(); ++v)
    places.push_back(
        to_earth(mesh.west + (mesh.east - mesh.west) * mesh.nodes[v].x / QuantizedMesh::kLast,
                 mesh.south + (mesh.north - mesh.south) * mesh.nodes[v].y / QuantizedMesh::kLast,
                 mesh.height(v)));
  return places;
}

struct Sphere {
  Place centre{};
  double radius = 0;
};

/// About the middle of the box round them.
Sphere sphere_round(const std::vector<Place>& places) {
  Place lower = places.front();
  Place upper = places.front();
  for (const Place& place : places)
    for (std::size_t k = 0; k < 3; ++k) {
      lower[k] = std::min(lower[k], place[k]);
      upper[k] = std::max(upper[k], place[k]);
    }
  Sphere sphere;
  for (std::size_t k = 0; k < 3; ++k) sphere.centre[k] = (lower[k] + upper[k]) / 2;
  for (const Place& place : places)
    sphere.radius = std::max(sphere.radius, length(place - sphere.centre));
  return sphere;
}

/// In the space where the ellipsoid is the unit sphere: how far out along `direction` a point sees
/// all that `place` is seen from, beyond the horizon; not positive where none does.
double occlusion_distance(const Place& place, const Place& direction) {
  const double squared = std::max(1.0, dot(place, place));
  const double length = std::sqrt(squared);
  const double cos_alpha = dot(place, direction) / std::sqrt(dot(place, place));
  const double sin_alpha = std::sqrt(std::max(0.0, 1 - cos_alpha * cos_alpha));
  const double cos_beta = 1 / length;
  const double sin_beta = std::sqrt(squared - 1) * cos_beta;
  return 1 / (cos_alpha * cos_beta - sin_alpha * sin_beta);
}

/// A point that is below the horizon only when all places are; in the space of the unit sphere. It
/// is out above the middle of the tile: of vertices alone, which may be on one side of it, the
/// middle may be elsewhere, and the horizon with it. Of a tile of half the world there is no such
/// point: from above its rim it has to be infinitely far out.
Place occlusion_point(const std::vector<Place>& places, const Place& middle) {
  constexpr double kNever = 1e6;  // radii
  const Place direction = to_unit_sphere(middle) * (1 / length(to_unit_sphere(middle)));
  double most = 1;
  for (const Place& place : places) {
    const double distance = occlusion_distance(to_unit_sphere(place), direction);
    most = distance > 0 && distance < kNever ? std::max(most, distance) : kNever;
  }
  return direction * most;
}

class ByteSink {
 public:
  template <typename T>
  void add(T value) {
    const auto* from = reinterpret_cast<const std::byte*>(&value);
    bytes_.insert(bytes_.end(), from, from + sizeof value);
  }
  void add_place(const Place& place) {
    for (std::size_t k = 0; k < 3; ++k) add(place[k]);
  }
  void align(std::size_t to) {
    while (bytes_.size() % to != 0) bytes_.push_back(std::byte{0});
  }
  std::vector<std::byte> take() && { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

std::uint16_t zigzag(std::int32_t difference) {
  return static_cast<std::uint16_t>((difference << 1) ^ (difference >> 31));
}

/// Vertices in the order in which triangles use them.
struct Numbering {
  std::vector<std::uint32_t> vertices;
  std::vector<std::uint32_t> number;  ///< By vertex.
};

Numbering number_by_use(const QuantizedMesh& mesh) {
  Numbering out;
  out.number.assign(mesh.nodes.size(), kUnused);
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t v : triangle)
      if (out.number[v] == kUnused) {
        out.number[v] = static_cast<std::uint32_t>(out.vertices.size());
        out.vertices.push_back(v);
      }
  return out;
}

template <typename Value>
void add_differences(const Numbering& order, const Value& value, ByteSink& out) {
  std::int32_t last = 0;
  for (const std::uint32_t v : order.vertices) {
    out.add(zigzag(value(v) - last));
    last = value(v);
  }
}

/// Each number as its distance from the highest yet, of which it may be the next.
template <typename Index>
void add_triangles(const QuantizedMesh& mesh, const Numbering& order, ByteSink& out) {
  std::uint32_t next = 0;
  out.add(static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t v : triangle) {
      out.add(static_cast<Index>(next - order.number[v]));
      if (order.number[v] == next) ++next;
    }
}

template <typename Index>
void add_sides(const QuantizedMesh& mesh, const Numbering& order, ByteSink& out) {
  for (std::size_t side = 0; side < kTileSides; ++side) {
    std::vector<std::uint32_t> found;
    for (const std::uint32_t v : order.vertices)
      if (is_on_side(mesh.nodes[v], side)) found.push_back(v);
    std::ranges::sort(found, {}, [&](std::uint32_t v) {
      return side % 2 == 0 ? mesh.nodes[v].y : mesh.nodes[v].x;
    });
    out.add(static_cast<std::uint32_t>(found.size()));
    for (const std::uint32_t v : found) out.add(static_cast<Index>(order.number[v]));
  }
}

bool has_finite(const Place& place) {
  return std::isfinite(place[0]) && std::isfinite(place[1]) && std::isfinite(place[2]);
}

}  // namespace

Result<void> check_bounds(const QuantizedMesh& mesh) {
  const TileBounds& bounds = mesh.bounds;
  if (!has_finite(bounds.centre) || !has_finite(bounds.sphere_centre) ||
      !std::isfinite(bounds.sphere_radius) || !has_finite(bounds.occlusion_point))
    return fail("expected bounds that are finite");
  // Others may take the sphere of vertices before these are put on the lattice.
  const double slack =
      (2 * std::abs(bounds.sphere_radius) + mesh.highest - mesh.lowest) / QuantizedMesh::kLast;
  for (const Place& place : places_of(mesh)) {
    const double distance = length(place - bounds.sphere_centre);
    if (!(distance <= bounds.sphere_radius + slack))
      return fail("expected a sphere round all vertices, got one of {} m and a vertex at {} m",
                  bounds.sphere_radius, distance);
  }
  constexpr double kRounding = 1e-6;
  if (!(length(bounds.occlusion_point) >= 1 - kRounding))
    return fail("expected an occlusion point outside of the ellipsoid, got one at {} radii",
                length(bounds.occlusion_point));
  return {};
}

std::vector<std::byte> encode(const QuantizedMesh& mesh) {
  const Numbering order = number_by_use(mesh);
  const std::vector<Place> places = places_of(mesh);
  const Sphere sphere = sphere_round(places);
  ByteSink out;
  const double longitude = (mesh.west + mesh.east) / 2;
  const double latitude = (mesh.south + mesh.north) / 2;
  const auto highest = std::ranges::max_element(mesh.heights) - mesh.heights.begin();
  const double top = mesh.height(static_cast<std::size_t>(highest));
  out.add_place(to_earth(longitude, latitude, (mesh.lowest + top) / 2));
  out.add(static_cast<float>(mesh.lowest));
  out.add(static_cast<float>(mesh.highest));
  out.add_place(sphere.centre);
  out.add(sphere.radius);
  out.add_place(occlusion_point(places, to_earth(longitude, latitude, 0)));
  out.add(static_cast<std::uint32_t>(order.vertices.size()));
  add_differences(
      order, [&](std::uint32_t v) { return mesh.nodes[v].x; }, out);
  add_differences(
      order, [&](std::uint32_t v) { return mesh.nodes[v].y; }, out);
  add_differences(
      order, [&](std::uint32_t v) { return std::int32_t{mesh.heights[v]}; }, out);
  if (order.vertices.size() <= kMostSmallVertices) {
    out.align(sizeof(std::uint16_t));
    add_triangles<std::uint16_t>(mesh, order, out);
    add_sides<std::uint16_t>(mesh, order, out);
  } else {
    out.align(sizeof(std::uint32_t));
    add_triangles<std::uint32_t>(mesh, order, out);
    add_sides<std::uint32_t>(mesh, order, out);
  }
  return std::move(out).take();
}

}  // namespace lode::io
