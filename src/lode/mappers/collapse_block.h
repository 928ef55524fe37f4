#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "lode/core/progress.h"
#include "lode/mappers/collapse_mesh.h"
#include "lode/mappers/quadric.h"
#include "lode/mappers/simplify_surface.h"
#include "lode/mappers/surface_band.h"

namespace lode::simplification {

/// Triangles whose vertices no other block uses, but for locked ones.
struct Block {
  std::span<const std::uint32_t> triangles;
  std::uint32_t first_collapse = 0;  ///< Its collapses are numbered from here.
  bool attaches = false;             ///< Attaches each vertex to one of its triangles first.
  /// By vertex: those to try first; others when their star has changed. Empty: all.
  std::span<const std::uint8_t> is_open;
};

struct BlockLimits {
  /// Of attached original vertices from the triangle they are attached to; infinite: none is.
  float distance = 0;
  const SurfaceBand* band = nullptr;  ///< Of the mesh's positions; null: no matter.
  float area = 0;                     ///< About that of an original triangle.
  float reach = 0;  ///< What thresholds of costs go by: how far the surface may move, about.
  float longest2 = std::numeric_limits<float>::infinity();  ///< Squared, of edges that collapse.
  /// The surface is a piece of one: its border is locked, and vertices move strictly inside the
  /// box.
  bool is_piece = false;
  Vec3f lower, upper;
  const ConvexDomain* domain = nullptr;  ///< Where vertices move to is inside; null: no matter.
};

/// Numbers of some vertices, below kMost, which are all forgotten at once.
class VertexMarks {
 public:
  static constexpr std::uint32_t kMost = 64;

  void resize(std::size_t n) {
    marks_.assign(n, 0);
    round_ = 0;
  }
  void forget() {
    round_ += kMost;
    if (round_ != 0) return;
    std::fill(marks_.begin(), marks_.end(), 0);  // once in 2^26 rounds
    round_ = kMost;
  }
  void set(std::uint32_t v, std::uint32_t number) { marks_[v] = round_ | number; }
  /// kNone where it was not set since.
  [[nodiscard]] std::uint32_t of(std::uint32_t v) const {
    const std::uint32_t number = marks_[v] ^ round_;
    return number < kMost ? number : kNone;
  }

 private:
  std::vector<std::uint32_t> marks_;
  std::uint32_t round_ = 0;
};

/// Once over all vertices.
struct Sweep {
  float threshold = 0;  ///< Of the quadric's cost; in `kSweeps` of area times reach squared.
  float shape = 0;      ///< New triangles have a height of at least its root of their longest edge,
                        ///< or as much of it as before.
  unsigned n_others = 0;  ///< Neighbours to try where the best choice fails.
};

/// Collapses edges inside blocks, one block after another, in memory of its own that is reused.
class BlockSimplifier {
 public:
  /// `is_locked`: by vertex; those stay as they are, and so do edges between them and others.
  /// `local`: by vertex, kNone for those of the block; used up.
  BlockSimplifier(CollapseMesh& mesh, std::span<const Vec3f> original,
                  std::span<const std::uint8_t> is_locked, std::span<std::uint32_t> local,
                  const BlockLimits& limits)
      : mesh_(mesh), original_(original), is_locked_(is_locked), local_(local), limits_(limits) {}

  /// Returns how many collapses there were.
  std::uint32_t run(const Block& block, const Progress& progress);

 private:
  static constexpr std::uint32_t kMaxValence = 24;
  static constexpr std::size_t kMaxStar = 2 * kMaxValence;
  static_assert(kMaxStar <= VertexMarks::kMost);

  static constexpr std::uint8_t kLockedFlag = 1;
  static constexpr std::uint8_t kBorderFlag = 2;
  static constexpr std::uint8_t kMovedFlag = 4;

  /// A triangle of a vertex's star: (vertex, a, b) in its orientation.
  struct Spoke {
    std::uint32_t triangle;
    std::uint32_t a;
    std::uint32_t b;
  };
  struct Star {
    std::uint32_t size = 0;
    bool is_open = false;  ///< The vertex is on the surface's border.
    std::array<Spoke, kMaxValence> spokes;

    [[nodiscard]] std::span<const Spoke> all() const { return {spokes.data(), size}; }
  };
  /// Of a triangle (w, a, b) of the star that a collapse leaves.
  struct NewTriangle {
    std::uint32_t triangle;
    std::uint32_t a;
    std::uint32_t b;
    std::uint32_t across_a = kNone;  ///< In the new star, beyond the edge w-a.
    std::uint32_t across_b = kNone;
    Vec3f u, v;  ///< From w to a and to b.
    float uu = 0, uv = 0, vv = 0, area2 = 0;
  };
  struct Vertex {
    Vec3f position;
    std::uint32_t corners;  ///< The first of its list; kNone when it is removed.
  };
  struct Choice {
    std::uint32_t other = kNone;
    float cost = 0;
    Vec3f position;
  };

  void load(const Block& block);
  void load_triangle(const Block& block, std::uint32_t global);
  void prepare(const Block& block);
  void run_sweep(const Sweep& sweep);
  void store();

  [[nodiscard]] bool gather(std::uint32_t v, Star& star) const;
  [[nodiscard]] Choice choose(std::uint32_t v, const Star& star) const;
  [[nodiscard]] Choice choose_on_border(std::uint32_t v, const Star& star) const;
  [[nodiscard]] Choice refine(std::uint32_t v, Choice choice) const;
  [[nodiscard]] bool try_others(std::uint32_t v, const Star& star, const Choice& failed,
                                const Sweep& sweep);
  [[nodiscard]] bool may_lie_at(const Vec3f& position) const;
  [[nodiscard]] bool may_collapse(std::uint32_t v, std::uint32_t other) const;
  [[nodiscard]] bool try_collapse(std::uint32_t kept, std::uint32_t removed,
                                  const Star& star_of_removed, const Vec3f& position);
  [[nodiscard]] bool is_link_simple(std::uint32_t kept, const Star& of_kept,
                                    const Star& of_removed);
  [[nodiscard]] bool make_triangles(std::uint32_t kept, std::uint32_t removed, const Star& of_kept,
                                    const Star& of_removed, const Vec3f& position);
  [[nodiscard]] bool keeps_shape(const NewTriangle& t, std::uint32_t old) const;
  void join_triangles();
  [[nodiscard]] bool folds_little() const;
  [[nodiscard]] bool keeps_to_band(std::uint32_t kept, std::uint32_t removed,
                                   const Star& star_of_removed, const Vec3f& position) const;
  [[nodiscard]] Vec3d find_in_band(std::uint32_t v) const;
  [[nodiscard]] Vec3f stored_position(std::uint32_t v) const;
  [[nodiscard]] bool attach_points(const Vec3f& position);
  [[nodiscard]] bool attach_point(std::uint32_t point, const Vec3f& position, std::uint32_t start);
  void apply(std::uint32_t kept, std::uint32_t removed, const Vec3f& position);
  void unlink(std::uint32_t v, std::uint32_t triangle);
  [[nodiscard]] Vec3f position(std::uint32_t v) const { return vertices_[v].position; }

  CollapseMesh& mesh_;
  std::span<const Vec3f> original_;
  std::span<const std::uint8_t> is_locked_;
  std::span<std::uint32_t> local_;
  BlockLimits limits_;
  Vec3f centre_;

  std::vector<Vertex> vertices_;
  std::vector<std::uint32_t> vertex_ids_;
  std::vector<std::uint32_t> last_;
  std::vector<Quadric> quadrics_;
  std::vector<Vec3d> in_band_;  ///< Of vertices, the band's own coordinates; empty without one.
  std::vector<std::uint8_t> flags_;
  std::vector<float> costs_;  ///< Of the best collapse at a vertex; negative: not known.
  std::vector<WorkTriangle> triangles_;
  std::vector<std::uint32_t> triangle_ids_;
  std::vector<std::uint32_t> next_corner_;  ///< By 4 * triangle + k.
  std::vector<Vec3f> points_;
  std::vector<std::uint32_t> point_ids_;
  std::vector<std::uint32_t> next_point_;

  // Of the collapse that is being tried.
  Star other_star_;
  VertexMarks marks_;
  std::array<NewTriangle, kMaxStar> new_triangles_;
  std::uint32_t n_new_ = 0;
  std::array<std::uint32_t, 2> dead_{};
  std::vector<std::array<std::uint32_t, 2>> moves_;  ///< Point, its new triangle (in the star).
  float least_shape_ = 0;                            ///< Of the sweep.
  float nearest_point_ = 0;  ///< Squared distance of the new vertex from attached ones.
  std::uint32_t next_collapse_ = 0;
};

}  // namespace lode::simplification
