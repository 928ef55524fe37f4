#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/io/surface_stream_parts.h"

namespace lode::io {

/// A stream to a format whose vertices all come before the cells. Pieces wait for the end as they
/// came, as long as they are few bytes; beyond that all go to spools.
class WaitingStream : public SurfaceStream {
 public:
  explicit WaitingStream(std::uint64_t memory_bytes) : memory_bytes_(memory_bytes) {}

  [[nodiscard]] Result<void> add(SurfacePiece piece) final;
  void set_normals(std::span<const VertexNormal> normals) final;
  [[nodiscard]] std::uint32_t n_vertices() const final {
    return static_cast<std::uint32_t>(layout_.n_vertices);
  }

 protected:
  /// Of all that came.
  [[nodiscard]] const SurfaceLayout& layout() const { return layout_; }
  [[nodiscard]] bool is_spooled() const { return is_spooled_; }
  /// In their order; none where they are spooled.
  [[nodiscard]] std::span<const SurfacePiece> pieces() const { return pieces_; }

 private:
  [[nodiscard]] virtual Result<void> spool(const SurfacePiece& piece) = 0;
  virtual void set_spooled_normal(const VertexNormal& normal) = 0;

  std::uint64_t memory_bytes_;
  std::uint64_t n_bytes_ = 0;  ///< Of the pieces.
  SurfaceLayout layout_;
  std::vector<SurfacePiece> pieces_;
  bool is_spooled_ = false;
};

}  // namespace lode::io
