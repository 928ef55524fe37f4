#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/result.h"
#include "lode/core/surface.h"

namespace lode {

/// A piece of a surface that comes in pieces. It is a surface of its own; its last vertices are
/// those that it shares with earlier pieces.
struct SurfacePiece {
  Surface surface;
  std::uint32_t first_new = 0;         ///< Of the new vertices the first's number in the whole.
  std::vector<std::uint32_t> earlier;  ///< Numbers in the whole of the last vertices here.

  /// New vertices come first, and are numbered on from those of the last piece.
  [[nodiscard]] std::size_t n_new() const { return surface.positions.size() - earlier.size(); }
  /// A vertex's number in the whole.
  [[nodiscard]] std::uint32_t number(std::uint32_t vertex) const {
    const std::size_t n = n_new();
    return vertex < n ? first_new + vertex : earlier[vertex - n];
  }
};

/// A vertex of the whole surface and its normal.
struct VertexNormal {
  std::uint32_t vertex = 0;
  Vec3f normal;
};

/// Takes a surface piece by piece, so that it need not be in memory.
class SurfaceSink {
 public:
  SurfaceSink() = default;
  SurfaceSink(const SurfaceSink&) = delete;
  SurfaceSink& operator=(const SurfaceSink&) = delete;
  virtual ~SurfaceSink() = default;

  /// All pieces have the same origin and the same attributes. Empty ones may come.
  [[nodiscard]] virtual Result<void> add(SurfacePiece piece) = 0;
  /// Gives vertices that have come other normals.
  virtual void set_normals(std::span<const VertexNormal> normals) = 0;
  /// How many have come.
  [[nodiscard]] virtual std::uint32_t n_vertices() const = 0;
};

/// Puts the pieces together behind what `surface` already has.
class SurfaceCollector : public SurfaceSink {
 public:
  explicit SurfaceCollector(Surface& surface) : surface_(surface) {}

  [[nodiscard]] Result<void> add(SurfacePiece piece) override;
  void set_normals(std::span<const VertexNormal> normals) override;
  [[nodiscard]] std::uint32_t n_vertices() const override {
    return static_cast<std::uint32_t>(surface_.positions.size());
  }

 private:
  Surface& surface_;
};

}  // namespace lode
