#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "lode/core/result.h"
#include "lode/models/tetra_mt/range_coder.h"

namespace lode::tetra_mt {

/// Pages of which models learn what pages are like, before those of all others: spread evenly,
/// ascending. Few, as whoever reads any page reads these.
inline constexpr std::uint32_t kMostPrimers = 3;
[[nodiscard]] inline std::vector<std::uint32_t> primers_of(std::uint32_t n_pages) {
  std::vector<std::uint32_t> primers;
  for (std::uint64_t k = 0; k < kMostPrimers && n_pages > 0; ++k) {
    const auto page = static_cast<std::uint32_t>((2 * k + 1) * n_pages / (2 * kMostPrimers));
    if (primers.empty() || primers.back() != page) primers.push_back(page);
  }
  return primers;
}

/// As a page begins with what others taught: so that it learns its own ways soon.
inline constexpr std::uint16_t kMostTaught = 14;
template <typename Models>
void soften(Models& models) {
  static_assert(std::is_trivially_copyable_v<Models> && alignof(Models) == alignof(BitModel) &&
                    sizeof(Models) % sizeof(BitModel) == 0,
                "of BitModels alone");
  const std::span all(reinterpret_cast<BitModel*>(&models), sizeof(Models) / sizeof(BitModel));
  for (BitModel& model : all) model.n_seen = std::min(model.n_seen, kMostTaught);
}

/// What primers taught, and they themselves, as a writer's bytes or a reader's contents.
template <typename Models, typename Page>
class Primers {
 public:
  /// `code(page, models)` codes a page, the models as they are before it.
  template <typename Code>
  [[nodiscard]] static Result<Primers> of(std::uint32_t n_pages, const Code& code) {
    Primers primers;
    primers.numbers_ = primers_of(n_pages);
    for (const std::uint32_t number : primers.numbers_) {
      LODE_TRY(auto page, code(number, *primers.models_));
      primers.pages_.push_back(std::move(page));
      soften(*primers.models_);
    }
    if (primers.numbers_.size() == n_pages) primers.models_.reset();  // nobody begins with them
    return primers;
  }

  /// A primer as it was made, another page by `code(models)`, with models as they are before it:
  /// what that returns, a Page or a Result of one.
  template <typename Code>
  [[nodiscard]] auto page(std::uint32_t number, const Code& code) const {
    if (const Page* const primer = find(number)) return decltype(code(*models_))(*primer);
    const auto models = std::make_unique<Models>(*models_);
    return code(*models);
  }
  /// With which pages begin that are no primers; null where all are.
  [[nodiscard]] const Models* models() const { return models_.get(); }
  /// None: of another page.
  [[nodiscard]] const Page* find(std::uint32_t number) const {
    const auto at = std::ranges::find(numbers_, number);
    return at == numbers_.end() ? nullptr
                                : &pages_[static_cast<std::size_t>(at - numbers_.begin())];
  }

 private:
  std::unique_ptr<Models> models_ = std::make_unique<Models>();
  std::vector<std::uint32_t> numbers_;
  std::vector<Page> pages_;
};

}  // namespace lode::tetra_mt
