#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "lode/core/scalar_type.h"
#include "lode/core/vec.h"
#include "lode/core/volume.h"

namespace lode::oracles {

/// Smooth fields on [-1, 1]³ whose values, gradients and level sets are known in closed form.
enum class Field : std::uint8_t {
  gaussians40,     ///< Sum of 40 Gaussians; large smooth parts, few fine ones.
  sphere,          ///< |p|: the exact surface and its area are known.
  marschner_lobb,  ///< The classic frequency test, near the Nyquist limit at small n.
  gyroid,          ///< Much surface everywhere: nothing to simplify.
};

inline constexpr std::array kFields = {Field::gaussians40, Field::sphere, Field::marschner_lobb,
                                       Field::gyroid};

/// "gaussians40", "sphere", ...
[[nodiscard]] std::string_view name_of(Field field);
/// The isovalue the figures in the documentation use.
[[nodiscard]] double usual_isovalue(Field field);

[[nodiscard]] double value(Field field, const Vec3d& point);
/// d value / d point. The sphere's gradient at its centre, where it has none, is zero.
[[nodiscard]] Vec3d gradient(Field field, const Vec3d& point);

/// dims[i] equidistant samples on [-1, 1] (an axis with one sample lies at 0); world coordinates
/// are the field's own.
[[nodiscard]] RegularGrid field_grid(const Index3& dims);

/// What is stored: scale · value + offset, rounded to nearest and clamped for integer types.
struct SampleOptions {
  ScalarType type = ScalarType::float32;
  double scale = 1;
  double offset = 0;
};

/// The field sampled on field_grid(dims), the same bytes whatever the number of threads.
/// 513³ of gaussians40 takes a few seconds on two cores.
[[nodiscard]] Volume sample(Field field, const Index3& dims, const SampleOptions& options = {});
/// n samples on each axis.
[[nodiscard]] Volume sample(Field field, std::int32_t n, const SampleOptions& options = {});

}  // namespace lode::oracles
