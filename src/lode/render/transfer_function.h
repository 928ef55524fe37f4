#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "lode/core/result.h"
#include "lode/core/vec.h"

namespace lode {

/// What a field value looks like in direct volume rendering.
struct TransferKnot {
  double value = 0;  ///< Field units.
  Vec3d color;       ///< Linear light, >= 0, of what glows there; 1 is white.
  double extinction =
      0;  ///< Per world length, >= 0: over a length L of it exp(-extinction L) passes.

  friend bool operator==(const TransferKnot&, const TransferKnot&) = default;
};

/// Colour and extinction by field value: linear between knots, constant beyond the first and the
/// last. Light of a ray: the integral of transmittance · extinction · colour along it.
struct TransferFunction {
  std::vector<TransferKnot> knots;  ///< At least one; values strictly ascending.

  [[nodiscard]] TransferKnot at(double value) const;
  friend bool operator==(const TransferFunction&, const TransferFunction&) = default;
};

/// Refuses what cannot be integrated: no knots or more than 65,536, values that do not ascend or
/// are closer than rounding can tell, colours and extinctions that are negative, not finite or
/// above 1e6 (colours) and 1e100 (extinctions).
[[nodiscard]] Result<void> check_transfer_function(const TransferFunction& function);

/// Where a preset is to fit.
struct TransferScale {
  double range_min = 0;  ///< Field values of the first and the last knot.
  double range_max = 1;
  double length = 1;  ///< World units, of a long way through the data: the domain's diagonal, say.
};

/// "viridis-smoke": a haze from violet over teal to yellow, denser where values are large.
/// "smoke": grey, clear below and dense above. "bands": five thin shells of different colours.
/// "solid": opaque but for a skin, coloured by value. "clear-middle": both ends of the range.
/// The error names them all; ranges must be finite, range_min <= range_max, length > 0.
[[nodiscard]] Result<TransferFunction> transfer_preset(std::string_view name,
                                                       const TransferScale& scale);
[[nodiscard]] bool is_transfer_preset(std::string_view name);

/// Of a text file, at most 1 MiB: a knot a line as five numbers,
///
///     # value   red green blue   extinction
///     1.2       0.1 0.2   0.9    0
///     2.5       1   0.9   0.3    14.5
///
/// with values ascending, colours in linear light (0..1) and extinction per world length. What
/// follows a # is a comment. Errors name the file and the line.
[[nodiscard]] Result<TransferFunction> read_transfer_function(const std::string& path);
/// The same, of the text of a file; `name` for messages.
[[nodiscard]] Result<TransferFunction> parse_transfer_function(std::string_view text,
                                                               std::string_view name);

}  // namespace lode
