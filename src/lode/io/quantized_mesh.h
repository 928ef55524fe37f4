#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "lode/core/lattice_point.h"
#include "lode/core/result.h"
#include "lode/core/vec.h"

namespace lode::io {

/// What a tile's header says of where it is: earth-centred, earth-fixed, in metres.
struct TileBounds {
  Vec<double, 3> centre{};
  Vec<double, 3> sphere_centre{};
  double sphere_radius = 0;
  /// In the space where the ellipsoid is the unit sphere.
  Vec<double, 3> occlusion_point{};
};

/// A tile of terrain as quantized-mesh 1.0 has it (Cesium, "quantized-mesh-1.0 terrain format"):
/// heights above the ellipsoid WGS 84, in metres.
struct QuantizedMesh {
  static constexpr std::int32_t kLast = 32767;

  /// Degrees.
  double west = 0, south = 0, east = 0, north = 0;
  /// Of numbers 0 and kLast; float32 has them exactly.
  double lowest = 0, highest = 0;
  std::vector<LatticePoint> nodes{};     ///< From 0 to kLast both ways, to the east and north.
  std::vector<std::uint16_t> heights{};  ///< Numbers from 0 to kLast.
  std::vector<std::array<std::uint32_t, 3>> triangles{};  ///< Turning left.

  TileBounds bounds{};  ///< As read; encode() makes its own.

  /// As a client decodes it.
  [[nodiscard]] double height(std::size_t vertex) const {
    return lowest + (highest - lowest) * (static_cast<double>(heights[vertex]) / kLast);
  }
};

/// The bytes of a tile's file: header with bounding sphere and horizon occlusion point, vertices in
/// the order in which triangles use them first, triangles, and the vertices on each side in order.
/// `mesh`: vertices are different and used, heights and nodes in their ranges.
[[nodiscard]] std::vector<std::byte> encode(const QuantizedMesh& mesh);

/// Fails where bounds as read are not finite, where the sphere misses vertices by more than the
/// lattice's steps, or where the occlusion point is inside of the ellipsoid, and so always hidden.
[[nodiscard]] Result<void> check_bounds(const QuantizedMesh& mesh);

/// Reads such bytes of the tile between the given degrees, with its extensions left out. Fails,
/// naming `path`, on what the format does not allow: sizes beyond the file, vertices and heights
/// out of range, triangles of other vertices, sides with vertices that are not on them.
[[nodiscard]] Result<QuantizedMesh> decode_quantized_mesh(std::span<const std::byte> bytes,
                                                          double west, double south, double east,
                                                          double north, const std::string& path);

}  // namespace lode::io
