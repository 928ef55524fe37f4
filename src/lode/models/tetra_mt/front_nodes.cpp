#include "lode/models/tetra_mt/front_nodes.h"

#include <algorithm>
#include <array>
#include <cstdlib>

#include "lode/core/expects.h"
#include "lode/models/tetra_mt/number_models.h"
#include "lode/models/tetra_mt/region_masks.h"

namespace lode::tetra_mt {
namespace {

/// By place of a node, the tetrahedra of the base that wait for it.
class Waiting {
 public:
  Waiting(std::span<const std::uint32_t> nodes, const FrontBase& base)
      : base_(base), begins_(nodes.size() + 1, 0) {
    // What is beside each other mostly waits for one node.
    std::vector<std::uint32_t> places(base.makers.size(), kNone);
    for (std::size_t t = 0; t < places.size(); ++t) {
      if (base.makers[t] == kNone) continue;
      places[t] = t > 0 && base.makers[t] == base.makers[t - 1]
                      ? places[t - 1]
                      : static_cast<std::uint32_t>(std::ranges::lower_bound(nodes, base.makers[t]) -
                                                   nodes.begin());
      ++begins_[places[t] + std::size_t{1}];
    }
    for (std::size_t i = 1; i < begins_.size(); ++i) begins_[i] += begins_[i - 1];
    waiting_.resize(begins_.back());
    std::vector<std::size_t> ends(begins_.begin(), begins_.end() - 1);
    for (std::uint32_t t = 0; t < places.size(); ++t)
      if (places[t] != kNone) waiting_[ends[places[t]]++] = t;
  }

  /// `visit(tetrahedron)`.
  template <typename Visit>
  void visit(std::size_t place, const Visit& visit) const {
    for (std::size_t i = begins_[place]; i < begins_[place + 1]; ++i) visit(waiting_[i]);
  }
  /// `visit_vertex(vertex)`: corners, some several times, none outside.
  template <typename Visit>
  void visit_corners(std::size_t place, const Visit& visit_vertex) const {
    visit(place, [&](std::uint32_t t) {
      for (const std::uint32_t v : base_.tetrahedra[t])
        if (v < base_.positions.size()) visit_vertex(v);
    });
  }

 private:
  const FrontBase& base_;
  std::vector<std::size_t> begins_;
  std::vector<std::uint32_t> waiting_;
};

/// By zigzag; small ones in few bits.
template <typename Coder>
std::int32_t code_signed(Coder& coder, NumberModel& model, std::int32_t given) {
  return unfolded(model.code(coder, folded(given)));
}

/// Boxes, and masks of regions.
template <typename Coder>
class FrontCoder {
 public:
  FrontCoder(Coder& coder, const FrontBase& base, const BoxCodes& codes, const Waiting& waiting)
      : coder_(coder), base_(base), codes_(codes), waiting_(waiting) {}

  BoxCodes::Lines code_box(std::size_t place, const BoxCodes::Lines& given) {
    Box3d round;
    bool is_first = true;
    waiting_.visit_corners(place, [&](std::uint32_t v) {
      const Vec3d& p = base_.positions[v];
      for (std::size_t i = 0; i < 3; ++i) {
        round.lower[i] = is_first ? p[i] : std::min(round.lower[i], p[i]);
        round.upper[i] = is_first ? p[i] : std::max(round.upper[i], p[i]);
      }
      is_first = false;
    });
    last_exponent_ =
        exponents_[last_exponent_].code(coder_, static_cast<std::uint32_t>(given.exponent));
    const BoxCodes::Lines guess = codes_.lines_round(round, static_cast<int>(last_exponent_));
    BoxCodes::Lines lines{.exponent = guess.exponent};
    std::uint32_t last = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      lines.lower[i] = guess.lower[i] - code_steps(0, guess.lower[i] - given.lower[i], last);
      lines.upper[i] = guess.upper[i] + code_steps(1, given.upper[i] - guess.upper[i], last);
    }
    return lines;
  }
  std::uint64_t code_mask(std::size_t place, std::uint64_t given) {
    std::uint64_t guess = 0;
    waiting_.visit(place, [&](std::uint32_t t) {
      const auto& corners = base_.tetrahedra[t];
      const bool is_inside =
          std::ranges::all_of(corners, [&](std::uint32_t v) { return v < base_.positions.size(); });
      if (is_inside && !base_.regions.empty()) guess |= region_bit(base_.regions[t]);
    });
    return guess ^ masks_.code(coder_, given ^ guess);
  }

 private:
  std::int32_t code_steps(std::size_t side, std::int32_t given, std::uint32_t& last) {
    const std::int32_t steps = code_signed(coder_, steps_[side][std::min(last, 3U)], given);
    last = static_cast<std::uint32_t>(std::abs(steps));
    return steps;
  }

  Coder& coder_;
  const FrontBase& base_;
  const BoxCodes& codes_;
  const Waiting& waiting_;
  std::uint32_t last_exponent_ = 0;
  std::array<SymbolModel<BoxCodes::kExponentBits>, 1U << BoxCodes::kExponentBits> exponents_;
  std::array<std::array<NumberModel, 4>, 2> steps_;
  WideModel masks_;
};

/// What nodes state of a field.
template <typename Coder>
class FrontFactCoder {
 public:
  FrontFactCoder(Coder& coder, const Waiting& waiting, std::span<const double> values,
                 const ValueScale& scale)
      : coder_(coder), waiting_(waiting), values_(values), scale_(scale) {}

  FactCodes code(std::size_t place, const FactCodes& given) {
    double low = 0;
    double high = 0;
    bool is_first = true;
    waiting_.visit_corners(place, [&](std::uint32_t v) {
      low = is_first ? values_[v] : std::min(low, values_[v]);
      high = is_first ? values_[v] : std::max(high, values_[v]);
      is_first = false;
    });
    octave_ = octaves_[octave_].code(coder_, given.error >> 7);
    const std::uint32_t quarter = quarters_[octave_].code(coder_, given.error >> 5 & 3);
    const auto rest = static_cast<std::uint32_t>(code_plain(coder_, 5, given.error & 31U));
    const std::size_t size = std::max(octave_, kSmall) - kSmall;
    return {static_cast<std::uint16_t>(octave_ << 7 | quarter << 5 | rest),
            code_from(lows_[size], scale_.code_below(low), given.low),
            code_from(highs_[size], scale_.code_above(high), given.high)};
  }
  std::uint8_t code_world(std::uint8_t given) {
    return static_cast<std::uint8_t>(worlds_.code(coder_, given));
  }

 private:
  static constexpr std::uint32_t kSmall = 20;  ///< Octaves up to this are as one.

  /// Modulo 4096, wherever bytes lead.
  std::uint16_t code_from(NumberModel& model, std::uint16_t from, std::uint16_t given) {
    constexpr std::uint32_t kMask = (1U << FactCodes::kBits) - 1;
    const std::int32_t step = code_signed(coder_, model, std::int32_t{given} - from);
    return static_cast<std::uint16_t>((from + static_cast<std::uint32_t>(step)) & kMask);
  }

  Coder& coder_;
  const Waiting& waiting_;
  std::span<const double> values_;
  const ValueScale& scale_;
  std::uint32_t octave_ = 0;
  std::array<SymbolModel<5>, 32> octaves_;  ///< By that of the node before.
  std::array<SymbolModel<2>, 32> quarters_;
  std::array<NumberModel, 12> lows_;
  std::array<NumberModel, 12> highs_;
  SymbolModel<8> worlds_;
};

}  // namespace

std::optional<std::uint32_t> FrontNodes::find(std::uint32_t node) const {
  const auto at = std::ranges::lower_bound(nodes, node);
  if (at == nodes.end() || *at != node) return std::nullopt;
  return static_cast<std::uint32_t>(at - nodes.begin());
}

std::vector<std::uint32_t> front_nodes_of(std::span<const std::uint32_t> makers) {
  std::vector<std::uint32_t> nodes;
  std::uint32_t last = kNone;  // what is beside each other mostly waits for one
  for (const std::uint32_t maker : makers) {
    if (maker != last && maker != kNone) nodes.push_back(maker);
    last = maker;
  }
  std::ranges::sort(nodes);
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

std::vector<std::byte> encode_front(const FrontNodes& front, const FrontBase& base,
                                    const BoxCodes& codes) {
  RangeWriter out;
  const Waiting waiting(front.nodes, base);
  FrontCoder coder(out, base, codes, waiting);
  for (std::size_t i = 0; i < front.nodes.size(); ++i) {
    const BoxCodes::Lines made = coder.code_box(i, front.boxes[i]);
    LODE_EXPECTS(made == front.boxes[i]);
  }
  for (std::size_t i = 0; i < front.region_masks.size(); ++i)
    coder.code_mask(i, front.region_masks[i]);
  return std::move(out).take();
}

Result<void> decode_front(std::span<const std::byte> bytes, const std::string& what,
                          const FrontBase& base, const BoxCodes& codes, std::uint32_t n_regions,
                          FrontNodes& front) {
  RangeReader in(bytes);
  const Waiting waiting(front.nodes, base);
  FrontCoder coder(in, base, codes, waiting);
  for (std::size_t i = 0; i < front.nodes.size(); ++i) front.boxes.push_back(coder.code_box(i, {}));
  for (std::size_t i = 0; n_regions > 1 && i < front.nodes.size(); ++i) {
    const std::uint64_t mask = coder.code_mask(i, 0);
    if (mask == 0 || (mask & ~mask_of_all(n_regions)) != 0)
      return fail("{}: node {}: expected a mask of {} regions, got {:#x}", what, front.nodes[i],
                  n_regions, mask);
    front.region_masks.push_back(mask);
  }
  if (!in.is_at_end()) return fail("{}: expected as many bytes as were read", what);
  return {};
}

std::vector<std::byte> encode_front_facts(const FrontFacts& facts,
                                          std::span<const std::uint32_t> nodes,
                                          const FrontBase& base, std::span<const double> values,
                                          const ValueScale& scale) {
  RangeWriter out;
  const Waiting waiting(nodes, base);
  FrontFactCoder coder(out, waiting, values, scale);
  for (std::size_t i = 0; i < nodes.size(); ++i)
    LODE_EXPECTS(coder.code(i, facts.facts[i]) == facts.facts[i]);
  for (const std::uint8_t error : facts.world_errors) coder.code_world(error);
  return std::move(out).take();
}

Result<FrontFacts> decode_front_facts(std::span<const std::byte> bytes, const std::string& what,
                                      std::span<const std::uint32_t> nodes, const FrontBase& base,
                                      std::span<const double> values, const ValueScale& scale,
                                      bool has_world_errors) {
  RangeReader in(bytes);
  const Waiting waiting(nodes, base);
  FrontFactCoder coder(in, waiting, values, scale);
  FrontFacts made;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const FactCodes codes = coder.code(i, {});
    if (codes.low > codes.high || codes.high > ValueScale::kLargest)
      return fail("{}: node {}: expected a range of codes up to {}, got {} to {}", what, nodes[i],
                  ValueScale::kLargest, codes.low, codes.high);
    made.facts.push_back(codes);
  }
  for (std::size_t i = 0; has_world_errors && i < nodes.size(); ++i)
    made.world_errors.push_back(coder.code_world(0));
  if (!in.is_at_end()) return fail("{}: expected as many bytes as were read", what);
  return made;
}

}  // namespace lode::tetra_mt
