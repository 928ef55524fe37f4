#pragma once

#include <cstdint>
#include <unordered_map>

#include "lode/api/dataset.h"
#include "lode/core/surface_sink.h"

namespace lode {

/// Finishes an isosurface's pieces on their way to a sink as a whole surface is finished: isovalues
/// are added, normals completed, orientation turned round.
class PieceFinisher : public SurfaceSink {
 public:
  PieceFinisher(const ExtractOptions& options, SurfaceSink& out) : options_(options), out_(out) {}

  /// Pieces that follow are of this isovalue's surface.
  void begin(double isovalue);
  [[nodiscard]] Result<void> add(SurfacePiece piece) override;
  void set_normals(std::span<const VertexNormal> normals) override { out_.set_normals(normals); }
  [[nodiscard]] std::uint32_t n_vertices() const override { return out_.n_vertices(); }
  /// After the last piece: completes normals, and counts what came.
  void finish(ExtractReport& report);

 private:
  void end_isovalue();
  void find_zero_normals(const SurfacePiece& piece);

  const ExtractOptions& options_;
  SurfaceSink& out_;
  double isovalue_ = 0;
  bool is_begun_ = false;
  std::uint32_t n_before_ = 0;  ///< Vertices of isovalues before this one.
  std::uint64_t n_triangles_ = 0;
  std::uint64_t n_lines_ = 0;
  std::vector<double> unmet_;
  /// Vertices whose own normal is zero: the area vectors of their triangles so far, added up.
  std::unordered_map<std::uint32_t, Vec3f> areas_;
};

}  // namespace lode
