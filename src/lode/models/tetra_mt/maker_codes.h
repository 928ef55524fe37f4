#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "lode/models/tetra_mt/number_models.h"
#include "lode/models/tetra_mt/page_content.h"

namespace lode::tetra_mt {

/// Who may have made a tetrahedron that a node brings: a child in another page, one in the node's
/// page by what vertex it splits, the node's, its target's or another; or the reference mesh.
enum class MakerRole : std::uint8_t { far, splits_vertex, splits_target, splits_other, reference };

struct MakerModels {
  static constexpr std::uint32_t kFew = 6;
  static constexpr std::size_t kRoles = 5;

  std::array<BitModel, kFew + 1> has_reference;
  using OfUses = std::array<std::array<BitModel, kRoles>, 5>;
  /// By how many were seen, how many were not, whether it is early in the list, rank, uses, role.
  std::array<std::array<std::array<std::array<OfUses, kFew>, 2>, 4>, kFew + 1> is_seen;
  std::array<std::array<std::array<BitModel, kRoles>, kFew + 1>, kFew + 1> is_new;
};

/// Codes who made the tetrahedra that nodes bring: places of children, each at least once, and,
/// where there are any of the reference, the number of children. Often they are who was there just
/// before.
template <typename Coder>
class MakerCoder {
 public:
  MakerCoder(Coder& coder, MakerModels& models) : coder_(coder), models_(models) {}

  /// Appends as many makers to `makers`, as many as children at least, of which there are some.
  /// `roles`: of the children, then of the reference. `given`: what they are, for a writer.
  void code(std::span<const MakerRole> roles, std::uint32_t n_makers,
            std::span<const std::uint8_t> given, std::vector<std::uint8_t>& makers) {
    const auto n_children = static_cast<std::uint32_t>(roles.size()) - 1;
    roles_ = roles;
    const bool has_reference =
        n_makers > n_children && coder_.bit(models_.has_reference[std::min(n_children, kFew)],
                                            !Coder::kReads && has(given, n_children));
    n_ = n_children + (has_reference ? 1 : 0);
    n_unused_ = n_;
    std::iota(recent_.begin(), recent_.begin() + n_, std::uint8_t{0});
    n_uses_.fill(0);
    for (std::uint32_t k = 0; k < n_makers; ++k) {
      const std::uint32_t rank =
          code_rank(n_makers - k, k < n_makers / 3, Coder::kReads ? 0 : rank_of(given[k]));
      const std::uint8_t maker = recent_[rank];
      makers.push_back(maker);
      for (std::uint32_t i = rank; i > 0; --i) recent_[i] = recent_[i - 1];
      recent_[0] = maker;
      if (n_uses_[maker]++ == 0) --n_unused_;
    }
  }

 private:
  static constexpr std::uint32_t kFew = MakerModels::kFew;
  static constexpr std::size_t kMost = kMaxBrought + 1;

  [[nodiscard]] static bool has(std::span<const std::uint8_t> makers, std::uint32_t maker) {
    return std::ranges::find(makers, maker) != makers.end();
  }
  [[nodiscard]] std::uint32_t rank_of(std::uint8_t maker) const {
    return static_cast<std::uint32_t>(std::ranges::find(recent_, maker) - recent_.begin());
  }
  [[nodiscard]] std::size_t role_at(std::uint32_t rank) const {
    return static_cast<std::size_t>(roles_[recent_[rank]]);
  }
  /// Among those seen, the last one first, or then among those that were not, ascending.
  std::uint32_t code_rank(std::uint32_t n_left, bool is_early, std::uint32_t given) {
    Held held(coder_);
    const std::uint32_t n_seen = n_ - n_unused_;
    if (n_unused_ < n_left) {
      const std::uint32_t n_asked = n_unused_ == 0 ? n_seen - 1 : n_seen;
      auto& models =
          models_.is_seen[std::min(n_seen, kFew)][std::min(n_unused_, 3U)][is_early ? 1 : 0];
      for (std::uint32_t rank = 0; rank < n_asked; ++rank) {
        const std::uint32_t n_uses = std::min<std::uint32_t>(n_uses_[recent_[rank]], 4);
        if (held.bit(models[std::min(rank, kFew - 1)][n_uses][role_at(rank)], rank == given))
          return rank;
      }
      if (n_unused_ == 0) return n_asked;
    }
    auto& models = models_.is_new[std::min(n_unused_, kFew)];
    for (std::uint32_t rank = n_seen; rank + 1 < n_; ++rank)
      if (held.bit(models[std::min(rank - n_seen, kFew)][role_at(rank)], rank == given))
        return rank;
    return n_ - 1;
  }

  Coder& coder_;
  MakerModels& models_;
  std::span<const MakerRole> roles_;
  std::uint32_t n_ = 0;  ///< Makers that differ.
  std::uint32_t n_unused_ = 0;
  std::array<std::uint8_t, kMost> recent_{};  ///< The last one first, behind them those not seen.
  std::array<std::uint8_t, kMost> n_uses_{};
};

}  // namespace lode::tetra_mt
