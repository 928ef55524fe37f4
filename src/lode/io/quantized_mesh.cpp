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

double dot(const Place& a, const Place& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Place scaled(const Place& a, double by) { return {a[0] * by, a[1] * by, a[2] * by}; }
double semi_minor() {
  return kWgs84Ellipsoid.semi_major * (1 - 1 / kWgs84Ellipsoid.inverse_flattening);
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
  for (const Place& place : places) {
    const Place way{place[0] - sphere.centre[0], place[1] - sphere.centre[1],
                    place[2] - sphere.centre[2]};
    sphere.radius = std::max(sphere.radius, std::sqrt(dot(way, way)));
  }
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

/// A point that is below the horizon only when all places are; in the space of the unit sphere.
Place occlusion_point(const std::vector<Place>& places, const Place& centre) {
  const double a = kWgs84Ellipsoid.semi_major;
  const Place radii{a, a, semi_minor()};
  const auto to_unit = [&](const Place& p) {
    return Place{p[0] / radii[0], p[1] / radii[1], p[2] / radii[2]};
  };
  constexpr double kNever = 100;  // radii: of a tile that goes round half the world
  const Place middle = to_unit(centre);
  const double length = std::sqrt(dot(middle, middle));
  if (!(length > 0)) return {kNever, 0, 0};
  const Place direction = scaled(middle, 1 / length);
  double most = 0;
  for (const Place& place : places) {
    const double distance = occlusion_distance(to_unit(place), direction);
    most = distance > 0 && distance < kNever ? std::max(most, distance) : kNever;
  }
  return scaled(direction, std::min(most, kNever));
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

}  // namespace

std::vector<std::byte> encode(const QuantizedMesh& mesh) {
  const Numbering order = number_by_use(mesh);
  const std::vector<Place> places = places_of(mesh);
  const Sphere sphere = sphere_round(places);
  ByteSink out;
  out.add_place(to_earth((mesh.west + mesh.east) / 2, (mesh.south + mesh.north) / 2,
                         (mesh.lowest + mesh.highest) / 2));
  out.add(static_cast<float>(mesh.lowest));
  out.add(static_cast<float>(mesh.highest));
  out.add_place(sphere.centre);
  out.add(sphere.radius);
  out.add_place(occlusion_point(places, sphere.centre));
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
