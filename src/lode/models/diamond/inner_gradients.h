#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "lode/models/diamond/flat_field.h"
#include "lode/models/diamond/model.h"

namespace lode::diamond {

/// Gradients at points whose neighbours are all samples of the field, wherever its bricks end: as
/// NormalSampler::gradient() has them, to the bit. Of a field without holes. T: its storage.
template <typename T>
class InnerGradients {
 public:
  explicit InnerGradients(const Model<3>& model)
      : InnerGradients(model.samples.data(), model.shape.dims) {
    auto bricks = static_cast<std::ptrdiff_t>(kBrickSize<3>);
    std::ptrdiff_t up = 1;
    for (std::size_t a = 0; a < 3; ++a) {
      axes_[a].up = up;
      axes_[a].brick = bricks;
      up *= kBrickSamples<3>;
      bricks *= model.brick_dims[a];
    }
  }
  explicit InnerGradients(const FlatField<3>& field)
      : InnerGradients(field.samples.data(), field.shape.dims) {
    std::ptrdiff_t up = 1;
    for (std::size_t a = 0; a < 3; ++a) {
      axes_[a].up = up;
      axes_[a].brick = up * kBrickEdge<3>;
      up *= field.shape.dims[a];
    }
  }

  /// False where one of them is not, or where the step is longer than a brick. `step`: a power of
  /// two. `out`: three numbers.
  [[nodiscard]] bool find(const Index3& p, std::int32_t step, double* out) const {
    const std::array<Ends, 3> ends{axes_[0].ends(p[0], step), axes_[1].ends(p[1], step),
                                   axes_[2].ends(p[2], step)};
    if (!ends[0].are_inside || !ends[1].are_inside || !ends[2].are_inside || step > kBrickEdge<3>)
      return false;
    const T* const at = samples_ + (ends[0].offset + ends[1].offset + ends[2].offset);
    const double scale = 0.5 / step;
    const auto difference = [&](const Ends& e) {
      return (static_cast<double>(at[e.high]) - static_cast<double>(at[e.low])) * scale;
    };
    out[0] = difference(ends[0]);
    out[1] = difference(ends[1]);
    out[2] = difference(ends[2]);
    return true;
  }

 private:
  /// Along an axis: from the first sample to the point, and from there to its neighbours.
  struct Ends {
    std::ptrdiff_t offset;
    std::ptrdiff_t low, high;
    bool are_inside;
  };
  struct Axis {
    std::ptrdiff_t up = 0;     ///< From a sample to the next one in its brick,
    std::ptrdiff_t brick = 0;  ///< and from a brick to the next one.
    std::int32_t last = 0;     ///< Coordinate of the field's last sample.

    [[nodiscard]] Ends ends(std::int32_t p, std::int32_t step) const {
      const std::int32_t local = p & (kBrickEdge<3> - 1);
      const std::ptrdiff_t next = brick - kBrickEdge<3> * up;  // what it takes beside the steps
      return {(p / kBrickEdge<3>)*brick + local * up, -step * up - (local >= step ? 0 : next),
              step * up + (local + step <= kBrickEdge<3> ? 0 : next),
              p >= step && p + step <= last};
    }
  };

  InnerGradients(const std::byte* samples, const Index<3>& dims)
      : samples_(reinterpret_cast<const T*>(samples)) {
    for (std::size_t a = 0; a < 3; ++a) axes_[a].last = dims[a] - 1;
  }

  const T* samples_;
  std::array<Axis, 3> axes_{};
};

}  // namespace lode::diamond
