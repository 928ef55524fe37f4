#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/surface.h"
#include "lode/mappers/collapse_cells.h"
#include "lode/mappers/shadow_cover.h"

namespace lode::simplification {

/// Pieces of a new triangle that shadows do not cover, against original vertices near it, in floats
/// with a margin, and where these are too far apart against original triangles round them.
class Cover {
 public:
  Cover(const Surface& original, const Surroundings& around, double limit, float longest_edge)
      : original_(original),
        around_(around),
        limit_(static_cast<float>(limit)),
        longest_edge_(longest_edge) {}

  /// Empties it, for another triangle.
  void begin(const Piece& triangle);
  void add(std::uint32_t vertex) { push(vertex, local_position(original_.positions[vertex])); }
  /// Of those added the nearest to a point; kNone of none.
  [[nodiscard]] std::uint32_t nearest(const Vec3d& point);
  /// Or gives up: what takes too long counts as not covered. `shadows`: on the triangle's plane;
  /// may be null.
  [[nodiscard]] bool covers(const Piece& triangle, const ShadowCover* shadows);

 private:
  void clear() {
    vertices_.clear();
    for (auto& axis : local_) axis.clear();
  }
  [[nodiscard]] Vec3f local_position(const Vec3f& p) const {
    return {{static_cast<float>(p[0] - lower_[0]), static_cast<float>(p[1] - lower_[1]),
             static_cast<float>(p[2] - lower_[2])}};
  }
  void push(std::uint32_t vertex, const Vec3f& at) {
    vertices_.push_back(vertex);
    for (std::size_t i = 0; i < 3; ++i) local_[i].push_back(at[i]);
  }

  /// Squared distances of vertices [begin, end) from a point.
  void find_distances(const Vec3d& point, std::size_t begin, std::size_t end);

  /// Vertices [begin, end) of the lists are those that may be near the piece.
  bool covers_part(const Piece& piece, std::size_t begin, std::size_t end, int depth);

  /// By triangles near what is not marked yet.
  void mark_by_triangles(std::size_t begin, std::size_t end, float limit2);

  /// Vertices that are too far away left out.
  bool covers_quarters(const Piece& piece, std::size_t begin, std::size_t end, int depth);

  /// Cells against a vertex; their corners against a triangle take as long as a few of these.
  static constexpr std::size_t kMostTests = 20'000;
  static constexpr std::size_t kCorners = 4;

  const Surface& original_;
  Surroundings around_;
  const ShadowCover* shadows_ = nullptr;
  std::size_t n_tests_ = 0;
  float limit_;
  float longest_edge_;  ///< About, of original triangles.
  Vec3d lower_;
  Vec3d upper_;
  std::vector<std::uint32_t> vertices_;  ///< Those to look at, then those of pieces being cut.
  std::array<std::vector<float>, 3> local_;
  std::vector<float> distances_;
  Cells cells_;
  std::vector<std::uint32_t> near_;
  std::vector<std::uint32_t> last_call_;  ///< Of mark_by_triangles() that met the triangle.
  std::uint32_t n_calls_ = 0;
};

}  // namespace lode::simplification
