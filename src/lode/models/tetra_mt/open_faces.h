#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <map>

#include "lode/core/flat_index.h"
#include "lode/models/tetra_mt/closed_mesh.h"
#include "lode/models/tetra_mt/hierarchy.h"

namespace lode::tetra_mt {

/// Numbers of faces, by their corners; in a hash map where these fit into 64 bits, as they do up to
/// two million vertices.
class OpenFaces {
 public:
  /// Corners are below n_vertices, or the one number above that stands for the vertex outside.
  explicit OpenFaces(std::uint32_t n_vertices)
      : n_vertices_(n_vertices), n_bits_(static_cast<int>(std::bit_width(n_vertices))) {}

  [[nodiscard]] std::uint32_t find(const FaceKey& face) const {
    if (is_packed()) return few_.find(packed(face));
    const auto at = many_.find(face);
    return at == many_.end() ? kNone : at->second;
  }
  /// A face that is not there.
  void insert(const FaceKey& face, std::uint32_t number) {
    if (is_packed())
      few_.insert(packed(face), number);
    else
      many_.emplace(face, number);
  }
  void erase(const FaceKey& face) {
    if (is_packed())
      few_.erase(packed(face));
    else
      many_.erase(face);
  }

 private:
  [[nodiscard]] bool is_packed() const { return 3 * n_bits_ <= 64; }
  [[nodiscard]] std::uint64_t packed(const FaceKey& face) const {
    std::uint64_t key = 0;
    for (const std::uint64_t corner :
         {face.first >> 32, face.first & 0xFFFFFFFFU, std::uint64_t{face.last}})
      key = key << n_bits_ | std::min<std::uint64_t>(corner, n_vertices_);
    return key;
  }

  std::uint32_t n_vertices_;
  int n_bits_;
  FlatIndex few_;
  std::map<FaceKey, std::uint32_t> many_;
};

}  // namespace lode::tetra_mt
