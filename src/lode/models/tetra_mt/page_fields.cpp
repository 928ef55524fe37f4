// What nodes of a page have for a field, as bits: docs/format.md, section 7.

#include <algorithm>
#include <array>
#include <utility>

#include "lode/models/tetra_mt/page_blocks.h"

namespace lode::tetra_mt {
namespace {

/// Codes facts in the tree's order, so that those of what a node discovers are known: it states no
/// less, and as a rule just that.
template <typename Coder>
class FactCoder {
 public:
  FactCoder(Coder& coder, FieldModels::Facts& models, const PageTree& tree,
            const std::vector<std::uint32_t>& places)
      : coder_(coder), models_(models), tree_(tree), places_(places) {}

  /// In place.
  void run(std::vector<FactCodes>& facts) {
    for (const std::uint16_t i : tree_.order)
      facts[i] = tree_.found[i].empty() ? code_alone(i, facts[i]) : code_nested(i, facts);
  }

 private:
  static constexpr std::uint32_t kMask = (1U << FactCodes::kBits) - 1;
  static constexpr std::uint32_t kFew = FieldModels::kFew;

  /// Of its own value.
  [[nodiscard]] std::uint32_t code_at(std::uint16_t i) const {
    return std::min<std::uint32_t>(places_[i] / ValueScale::kSteps, ValueScale::kLargest);
  }

  FactCodes code_alone(std::uint16_t i, const FactCodes& given) {
    const std::size_t is_inner = tree_.n_others[i] > 0 ? 1 : 0;
    const std::uint32_t own = code_at(i);
    const std::uint32_t octave = models_.octaves[is_inner].code(coder_, given.error >> 7);
    const std::uint32_t quarter = models_.quarters[octave].code(coder_, given.error >> 5 & 3);
    const std::uint32_t error =
        octave << 7 | quarter << 5 |
        static_cast<std::uint32_t>(code_plain(coder_, 5, given.error & 31U));
    const std::uint32_t size = std::max(octave, 20U) - 20;
    const std::uint32_t low = code_from(models_.lows[is_inner][size], own, given.low);
    const auto below = static_cast<std::size_t>(std::bit_width(own > low ? own - low : 1));
    const std::uint32_t high = code_from(models_.highs[is_inner][below], own, given.high);
    return made(error, low, high);
  }
  /// Modulo 4096, wherever bytes lead.
  std::uint32_t code_from(NumberModel& model, std::uint32_t from, std::uint32_t given) {
    const auto step = static_cast<std::int32_t>(given - from);
    return (from + static_cast<std::uint32_t>(unfolded(model.code(coder_, folded(step))))) & kMask;
  }

  FactCodes code_nested(std::uint16_t i, const std::vector<FactCodes>& facts) {
    const auto found = tree_.found[i];
    const std::size_t has_others = tree_.n_others[i] > 0 ? 1 : 0;
    const std::size_t n = std::min<std::size_t>(found.size() + tree_.n_others[i], kFew);
    FactCodes joined = facts[found[0]];
    for (const std::uint16_t k : found)
      joined = {std::max(joined.error, facts[k].error), std::min(joined.low, facts[k].low),
                std::max(joined.high, facts[k].high)};
    const std::uint32_t own = code_at(i);
    const std::array<std::size_t, 2> is_beyond{own < joined.low ? std::size_t{1} : 0,
                                               own > joined.high ? std::size_t{1} : 0};
    const FactCodes& given = facts[i];
    const std::uint32_t error =
        code_more(models_.excess[0][has_others][n][0], joined.error, given.error - joined.error);
    const std::uint32_t least = std::min<std::uint32_t>(joined.low, own);
    const std::uint32_t low =
        least - (code_more(models_.excess[1][has_others][n][is_beyond[0]], 0, least - given.low));
    const std::uint32_t most = std::max<std::uint32_t>(joined.high, own);
    const std::uint32_t high =
        code_more(models_.excess[2][has_others][n][is_beyond[1]], most, given.high - most);
    return made(error, low, high);
  }
  /// From + what is more, modulo 4096.
  std::uint32_t code_more(FieldModels::Excess& models, std::uint32_t from, std::uint32_t given) {
    if (!coder_.bit(models.is_any, (given & kMask) != 0)) return from & kMask;
    return (from + 1 + models.size.code(coder_, (given - 1) & kMask)) & kMask;
  }
  [[nodiscard]] static FactCodes made(std::uint32_t error, std::uint32_t low, std::uint32_t high) {
    return {static_cast<std::uint16_t>(error & kMask), static_cast<std::uint16_t>(low & kMask),
            static_cast<std::uint16_t>(high & kMask)};
  }

  Coder& coder_;
  FieldModels::Facts& models_;
  const PageTree& tree_;
  const std::vector<std::uint32_t>& places_;
};

/// All in place.
template <typename Coder>
Result<void> code_content(Coder& coder, FieldModels& models, const ValueScale& scale,
                          const PageTree& tree, bool is_narrow, const std::string& what,
                          FieldContent& content) {
  ValueCoder<Coder> values(coder, models.values, scale, is_narrow, what);
  std::vector<std::uint32_t> places;
  for (double& value : content.values) {
    LODE_TRY(const std::uint32_t place, values.code(value));
    places.push_back(place);
  }
  FactCoder<Coder>(coder, models.facts, tree, places).run(content.facts);
  return {};
}

}  // namespace

std::vector<std::byte> encode_field(const FieldContent& content, const ValueScale& scale,
                                    const PageTree& tree, bool is_narrow, FieldModels& models) {
  RangeWriter out;
  FieldContent made = content;
  const auto done = code_content(out, models, scale, tree, is_narrow, "page", made);
  LODE_EXPECTS(done && made == content);
  return std::move(out).take();
}

Result<FieldContent> decode_field(std::span<const std::byte> bytes, const std::string& what,
                                  const ValueScale& scale, const PageTree& tree, bool is_narrow,
                                  FieldModels& models) {
  RangeReader in(bytes);
  FieldContent content{std::vector<double>(tree.n_nodes()), std::vector<FactCodes>(tree.n_nodes())};
  LODE_CHECK(code_content(in, models, scale, tree, is_narrow, what, content));
  for (const FactCodes& codes : content.facts)
    if (codes.low > codes.high || codes.high > ValueScale::kLargest)
      return fail("{}: expected ranges of codes up to {}, got {} to {}", what, ValueScale::kLargest,
                  codes.low, codes.high);
  if (!in.is_at_end()) return fail("{}: expected as many bytes as were read", what);
  return content;
}

}  // namespace lode::tetra_mt
