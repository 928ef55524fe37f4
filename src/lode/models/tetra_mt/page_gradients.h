#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "lode/core/result.h"
#include "lode/models/tetra_mt/gradient_codes.h"
#include "lode/models/tetra_mt/number_models.h"

namespace lode::tetra_mt {

/// Of how codes of gradients differ from those before, by how many bits the differences before had.
struct GradientModels {
  std::array<NumberModel, kGradientLengthBits + 1> lengths;
  std::array<std::array<NumberModel, kGradientBits + 1>, 2> coordinates;
};

/// gradient_code()s of a page as bits: docs/format.md, section 7. `models`: as they are before the
/// page, then as it leaves them.
[[nodiscard]] std::vector<std::byte> encode_gradients(std::span<const std::uint32_t> codes,
                                                      GradientModels& models);
/// n of them. Fails on what is no code. what: the block, for messages.
[[nodiscard]] Result<std::vector<std::uint32_t>> decode_gradients(std::span<const std::byte> bytes,
                                                                  std::size_t n,
                                                                  const std::string& what,
                                                                  GradientModels& models);

}  // namespace lode::tetra_mt
