#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "lode/core/result.h"
#include "lode/core/surface.h"
#include "lode/core/volume.h"

namespace lode::bench {

/// What a peer made of a volume.
struct PeerCounts {
  std::uint64_t triangles = 0;
  std::uint64_t vertices = 0;
};

enum class PeerNormals : std::uint8_t { off, on };

/// "VTK 9.1.0, TBB, 2 threads": what runs the peer.
[[nodiscard]] std::string describe_peer();

/// vtkFlyingEdges3D on a volume copied into VTK's memory beforehand: scalars and gradients off,
/// two threads. Each call of extract() does all the work again, into fresh output.
class FlyingEdges {
 public:
  FlyingEdges(const Volume& volume, double isovalue, PeerNormals normals);
  FlyingEdges(FlyingEdges&&) noexcept;
  ~FlyingEdges();

  /// Fails where the filter ran but left no output.
  [[nodiscard]] Result<PeerCounts> extract();
  /// extract(), then vtkQuadricDecimation down to about `target` triangles.
  [[nodiscard]] Result<PeerCounts> extract_and_decimate(std::uint64_t target);
  /// The surface that the last call left.
  [[nodiscard]] Surface surface() const;
  /// How the peer's input differs from ours, for the row; empty when it does not.
  [[nodiscard]] const std::string& note() const { return note_; }

 private:
  class Pipeline;
  std::unique_ptr<Pipeline> pipeline_;
  std::string note_;
};

}  // namespace lode::bench
