#include "lode/io/quantized_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <type_traits>
#include <utility>

#include "lode/core/ellipsoid.h"
#include "lode/core/vec.h"

namespace lode::io {
namespace {

using Place = Vec<double, 3>;

constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();
constexpr std::size_t kMostSmall = 65536;  ///< Vertices that 16 bits can number.
constexpr std::size_t kHeaderBytes = 88;

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
std::int32_t from_zigzag(std::uint16_t code) {
  return static_cast<std::int32_t>(code >> 1) ^ -static_cast<std::int32_t>(code & 1);
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

/// The sides in the file's order: west, south, east, north.
constexpr std::size_t kSides = 4;

bool is_on(LatticePoint node, std::size_t side) {
  const std::int32_t across = side % 2 == 0 ? node.x : node.y;
  return across == (side < 2 ? 0 : QuantizedMesh::kLast);
}

template <typename Index>
void add_sides(const QuantizedMesh& mesh, const Numbering& order, ByteSink& out) {
  for (std::size_t side = 0; side < kSides; ++side) {
    std::vector<std::uint32_t> found;
    for (const std::uint32_t v : order.vertices)
      if (is_on(mesh.nodes[v], side)) found.push_back(v);
    std::ranges::sort(found, {}, [&](std::uint32_t v) {
      return side % 2 == 0 ? mesh.nodes[v].y : mesh.nodes[v].x;
    });
    out.add(static_cast<std::uint32_t>(found.size()));
    for (const std::uint32_t v : found) out.add(static_cast<Index>(order.number[v]));
  }
}

/// Little-endian values one after another; fails beyond the end.
class ByteSource {
 public:
  ByteSource(std::span<const std::byte> bytes, const std::string& path)
      : bytes_(bytes), path_(path) {}

  template <typename T>
  Result<T> read() {
    LODE_TRY(const auto values, read_all<T>(1));
    return values[0];
  }
  template <typename T>
  Result<std::vector<T>> read_all(std::uint64_t n) {
    if (n > (bytes_.size() - at_) / sizeof(T))
      return fail("{}: at byte {}: expected {} values of {} bytes, got {} bytes", path_, at_, n,
                  sizeof(T), bytes_.size() - at_);
    std::vector<T> values(n);
    if (n > 0) std::memcpy(values.data(), &bytes_[at_], n * sizeof(T));
    at_ += n * sizeof(T);
    return values;
  }
  void align(std::size_t to) { at_ = std::min(bytes_.size(), (at_ + to - 1) / to * to); }
  void skip(std::size_t n) { at_ = std::min(bytes_.size(), at_ + n); }
  [[nodiscard]] std::size_t at() const { return at_; }

 private:
  std::span<const std::byte> bytes_;
  const std::string& path_;
  std::size_t at_ = 0;
};

Result<std::vector<std::int32_t>> read_differences(ByteSource& in, std::size_t n, const char* what,
                                                   const std::string& path) {
  LODE_TRY(const auto codes, in.read_all<std::uint16_t>(n));
  std::vector<std::int32_t> values(n);
  std::int32_t value = 0;
  for (std::size_t i = 0; i < n; ++i) {
    value += from_zigzag(codes[i]);
    if (value < 0 || value > QuantizedMesh::kLast)
      return fail("{}: {} of vertex {}: expected a number from 0 to {}, got {}", path, what, i,
                  QuantizedMesh::kLast, value);
    values[i] = value;
  }
  return values;
}

template <typename Index>
Result<void> read_triangles(ByteSource& in, QuantizedMesh& mesh, const std::string& path) {
  in.align(sizeof(Index));
  LODE_TRY(const auto n, in.read<std::uint32_t>());
  LODE_TRY(const auto codes, in.read_all<Index>(3 * std::uint64_t{n}));
  std::uint32_t next = 0;
  mesh.triangles.resize(n);
  for (std::size_t i = 0; i < codes.size(); ++i) {
    if (codes[i] > next || next - codes[i] >= mesh.nodes.size())
      return fail("{}: triangle {}: expected a vertex below {}, got {} below number {}", path,
                  i / 3, mesh.nodes.size(), codes[i], next);
    mesh.triangles[i / 3][i % 3] = next - codes[i];
    if (codes[i] == 0) ++next;
  }
  return {};
}

template <typename Index>
Result<void> check_sides(ByteSource& in, const QuantizedMesh& mesh, const std::string& path) {
  for (std::size_t side = 0; side < kSides; ++side) {
    LODE_TRY(const auto n, in.read<std::uint32_t>());
    LODE_TRY(const auto found, in.read_all<Index>(n));
    std::uint64_t n_on = 0;
    for (const LatticePoint node : mesh.nodes) n_on += is_on(node, side) ? 1 : 0;
    for (const Index v : found)
      if (v >= mesh.nodes.size() || !is_on(mesh.nodes[v], side))
        return fail("{}: side {}: expected vertices on it, got {}", path, side, v);
    if (found.size() != n_on)
      return fail("{}: side {}: expected {} vertices, got {}", path, side, n_on, found.size());
  }
  return {};
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
  if (order.vertices.size() <= kMostSmall) {
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

Result<QuantizedMesh> decode_quantized_mesh(std::span<const std::byte> bytes, double west,
                                            double south, double east, double north,
                                            const std::string& path) {
  if (bytes.size() < kHeaderBytes)
    return fail("{}: expected a header of {} bytes, got a file of {}", path, kHeaderBytes,
                bytes.size());
  QuantizedMesh mesh{.west = west, .south = south, .east = east, .north = north};
  ByteSource in(bytes, path);
  in.skip(sizeof(Place));
  LODE_TRY(mesh.lowest, in.read<float>());
  LODE_TRY(mesh.highest, in.read<float>());
  if (!std::isfinite(mesh.lowest) || !std::isfinite(mesh.highest) || mesh.lowest > mesh.highest)
    return fail("{}: expected a range of heights, got {} to {}", path, mesh.lowest, mesh.highest);
  in.skip(kHeaderBytes - in.at());
  LODE_TRY(const auto n, in.read<std::uint32_t>());
  LODE_TRY(const auto u, read_differences(in, n, "column", path));
  LODE_TRY(const auto v, read_differences(in, n, "row", path));
  LODE_TRY(const auto h, read_differences(in, n, "height", path));
  for (std::size_t i = 0; i < n; ++i) {
    mesh.nodes.push_back({u[i], v[i]});
    mesh.heights.push_back(static_cast<std::uint16_t>(h[i]));
  }
  if (n <= kMostSmall) {
    LODE_CHECK(read_triangles<std::uint16_t>(in, mesh, path));
    LODE_CHECK(check_sides<std::uint16_t>(in, mesh, path));
  } else {
    LODE_CHECK(read_triangles<std::uint32_t>(in, mesh, path));
    LODE_CHECK(check_sides<std::uint32_t>(in, mesh, path));
  }
  return mesh;
}

}  // namespace lode::io
