#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "lode/models/tetra_mt/box_codes.h"
#include "lode/models/tetra_mt/number_models.h"
#include "lode/models/tetra_mt/page_tree.h"

namespace lode::tetra_mt {

struct BoxModels {
  static constexpr int kStepBits = BoxCodes::kAxisBits / 2;
  static constexpr std::uint32_t kExponents = 1U << BoxCodes::kExponentBits;
  static constexpr std::uint32_t kNoStep = 1U << kStepBits;

  /// By the least exponent of what it discovers in the page (else 16, 17 where in others alone),
  /// and how many it discovers.
  std::array<std::array<SymbolModel<BoxCodes::kExponentBits>, 3>, kExponents + 2> exponents;
  /// By which step it is, whether it discovers any, the step before, and how large those before
  /// are.
  std::array<std::array<std::array<std::array<SymbolModel<kStepBits>, 3>, kNoStep + 1>, 2>, 6>
      steps;
};

/// Codes the boxes of a page, whose exponents are mostly little less than those of what they hold.
template <typename Coder>
class BoxSteps {
 public:
  BoxSteps(Coder& coder, BoxModels& models) : coder_(coder), models_(models) {}

  /// `boxes`: of BoxCodes, by node; a reader fills them.
  void code(const PageTree& tree, std::vector<std::uint32_t>& boxes) {
    for (const std::uint16_t i : tree.order) boxes[i] = code_box(tree, i, boxes);
  }

 private:
  static constexpr int kStepBits = BoxModels::kStepBits;
  static constexpr std::uint32_t kExponents = BoxModels::kExponents;
  static constexpr std::uint32_t kNoStep = BoxModels::kNoStep;

  std::uint32_t code_box(const PageTree& tree, std::uint16_t i,
                         const std::vector<std::uint32_t>& boxes) {
    const std::uint32_t given = boxes[i];
    const auto found = tree.found[i];
    const auto n_discovered = static_cast<std::uint32_t>(found.size()) + tree.n_others[i];
    std::uint32_t least = n_discovered > 0 ? kExponents + 1 : kExponents;
    for (const std::uint16_t child : found) least = std::min(least, boxes[child] % kExponents);
    std::uint32_t box =
        models_.exponents[least][std::min(n_discovered, 2U)].code(coder_, given % kExponents);
    std::uint32_t last = kNoStep;
    std::uint32_t largest = 0;
    for (std::size_t k = 0; k < 6; ++k) {
      const int at = BoxCodes::kExponentBits + kStepBits * static_cast<int>(k);
      const std::size_t width = k < 2 ? 2 : largest > 3 ? 1 : 0;
      auto& model = models_.steps[k][n_discovered > 0 ? 1 : 0][last][width];
      last = model.code(coder_, given >> at & (kNoStep - 1));
      largest = std::max(largest, last);
      box |= last << at;
    }
    return box;
  }

  Coder& coder_;
  BoxModels& models_;
};

}  // namespace lode::tetra_mt
