#include <cmath>
#include <cstring>

#include "lode/io/quantized_mesh.h"
#include "lode/io/quantized_mesh_layout.h"

namespace lode::io {
namespace {

constexpr std::size_t kHeaderBytes = 88;

std::int32_t from_zigzag(std::uint16_t code) {
  return static_cast<std::int32_t>(code >> 1) ^ -static_cast<std::int32_t>(code & 1);
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

 private:
  std::span<const std::byte> bytes_;
  const std::string& path_;
  std::size_t at_ = 0;
};

Result<Vec<double, 3>> read_place(ByteSource& in) {
  LODE_TRY(const auto values, in.read_all<double>(3));
  return Vec<double, 3>{values[0], values[1], values[2]};
}

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
  for (std::size_t side = 0; side < kTileSides; ++side) {
    LODE_TRY(const auto n, in.read<std::uint32_t>());
    LODE_TRY(const auto found, in.read_all<Index>(n));
    std::uint64_t n_on = 0;
    for (const LatticePoint node : mesh.nodes) n_on += is_on_side(node, side) ? 1 : 0;
    for (const Index v : found)
      if (v >= mesh.nodes.size() || !is_on_side(mesh.nodes[v], side))
        return fail("{}: side {}: expected vertices on it, got {}", path, side, v);
    if (found.size() != n_on)
      return fail("{}: side {}: expected {} vertices, got {}", path, side, n_on, found.size());
  }
  return {};
}

}  // namespace

Result<QuantizedMesh> decode_quantized_mesh(std::span<const std::byte> bytes, double west,
                                            double south, double east, double north,
                                            const std::string& path) {
  if (bytes.size() < kHeaderBytes)
    return fail("{}: expected a header of {} bytes, got a file of {}", path, kHeaderBytes,
                bytes.size());
  QuantizedMesh mesh{.west = west, .south = south, .east = east, .north = north};
  ByteSource in(bytes, path);
  LODE_TRY(mesh.bounds.centre, read_place(in));
  LODE_TRY(mesh.lowest, in.read<float>());
  LODE_TRY(mesh.highest, in.read<float>());
  if (!std::isfinite(mesh.lowest) || !std::isfinite(mesh.highest) || mesh.lowest > mesh.highest)
    return fail("{}: expected a range of heights, got {} to {}", path, mesh.lowest, mesh.highest);
  LODE_TRY(mesh.bounds.sphere_centre, read_place(in));
  LODE_TRY(mesh.bounds.sphere_radius, in.read<double>());
  LODE_TRY(mesh.bounds.occlusion_point, read_place(in));
  LODE_TRY(const auto n, in.read<std::uint32_t>());
  LODE_TRY(const auto u, read_differences(in, n, "column", path));
  LODE_TRY(const auto v, read_differences(in, n, "row", path));
  LODE_TRY(const auto h, read_differences(in, n, "height", path));
  for (std::size_t i = 0; i < n; ++i) {
    mesh.nodes.push_back({u[i], v[i]});
    mesh.heights.push_back(static_cast<std::uint16_t>(h[i]));
  }
  if (n <= kMostSmallVertices) {
    LODE_CHECK(read_triangles<std::uint16_t>(in, mesh, path));
    LODE_CHECK(check_sides<std::uint16_t>(in, mesh, path));
  } else {
    LODE_CHECK(read_triangles<std::uint32_t>(in, mesh, path));
    LODE_CHECK(check_sides<std::uint32_t>(in, mesh, path));
  }
  return mesh;
}

}  // namespace lode::io
