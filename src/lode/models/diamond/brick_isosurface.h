#pragma once

#include <array>
#include <unordered_map>

#include "lode/mappers/iso_part.h"
#include "lode/mappers/march_simplex.h"
#include "lode/models/diamond/brick_traversal.h"
#include "lode/models/diamond/brick_vertices.h"

namespace lode::diamond {

/// Marching simplices, leaves of a selection's cut, inside one brick after another.
template <int D>
class BrickIsosurface {
 public:
  explicit BrickIsosurface(const LatticeFrame& frame)
      : is_mirrored_(frame.is_mirrored), vertices_(frame.margin) {}

  /// What follows lies in the brick that `samples` has open and goes to `part`; `origin` is where
  /// their lattice begins in the part's.
  void open(const BrickSamples<D>& samples, const AxisMap<D>& axes, const Index<D>& origin,
            double isovalue, IsoPart<D>& part) {
    vertices_.open(samples.base() + origin, axes, isovalue, part);
    twins_.clear();
    samples_ = &samples;
  }

  void add(const BrickSimplex<D>& s) {
    std::size_t inside = 0;
    for (std::size_t i = 0; i <= as_size(D); ++i)
      inside |= (s.corner[i].value >= vertices_.isovalue() ? std::size_t{1} : 0) << i;
    march_simplex<D>(
        inside, s.is_positive == is_mirrored_,
        [&](std::size_t i, std::size_t j) { return vertex_on(s, i, j); },
        [&](const auto& cell) { vertices_.part().cells.push_back(cell); });
  }

  [[nodiscard]] bool is_mirrored() const { return is_mirrored_; }
  [[nodiscard]] BrickVertices<D>& vertices() { return vertices_; }

 private:
  static constexpr std::uint32_t kNone = BrickVertices<D>::kNone;
  static constexpr std::uint32_t kTwoThere = kNone - 1;  ///< See twins_.

  std::uint32_t vertex_on(const BrickSimplex<D>& s, std::size_t i, std::size_t j) {
    const BrickPoint& a = s.corner[i];
    const BrickPoint& b = s.corner[j];
    const std::size_t at = vertices_.place(a.packed + b.packed);
    const std::uint32_t known = vertices_[at];
    if (known < kTwoThere) return known;
    if (known == kNone) {
      if (!samples_->is_pinched(a, b)) {
        const std::uint32_t vertex = vertices_.add(a, b);
        vertices_.set(at, vertex);
        return vertex;
      }
      vertices_.set(at, kTwoThere);
      twins_[static_cast<std::uint32_t>(at)] = {kNone, kNone};
    }
    return twin_on(s, i, j, twins_[static_cast<std::uint32_t>(at)]);
  }

  /// Of the two vertices of a pinched edge that of the simplex's arc.
  std::uint32_t twin_on(const BrickSimplex<D>& s, std::size_t i, std::size_t j,
                        std::array<std::uint32_t, 2>& twins) {
    bool is_second = false;
    if constexpr (D == 3) {
      std::array<Index<3>, 4> corners;
      for (std::size_t c = 0; c < corners.size(); ++c)
        corners[c] = samples_->global(s.corner[c].packed);
      is_second = is_in_second_arc(corners, corners[i], corners[j]);
    }
    std::uint32_t& vertex = twins[is_second ? 1 : 0];
    if (vertex == kNone) vertex = vertices_.add(s.corner[i], s.corner[j], is_second ? kTwin : 0);
    return vertex;
  }

  bool is_mirrored_;
  BrickVertices<D> vertices_;
  /// By the place of an edge whose entry is kTwoThere: one for each arc of simplices round it.
  std::unordered_map<std::uint32_t, std::array<std::uint32_t, 2>> twins_;
  const BrickSamples<D>* samples_ = nullptr;
};

}  // namespace lode::diamond
