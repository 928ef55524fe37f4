#include "lode/models/tetra_mt/midpoint/field_records.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace lode::tetra_mt::midpoint {
namespace {

float world_above(double x) {
  return x == 0 ? 0 : std::nextafter(static_cast<float>(x), std::numeric_limits<float>::infinity());
}

class FieldMaker {
 public:
  FieldMaker(const FieldTrees& trees, const MeshField& field, std::span<const EdgeFacts> facts)
      : trees_(trees),
        from_(field),
        facts_(facts),
        n_leaves_(static_cast<std::uint32_t>(trees.mesh_vertices.size())) {}

  FieldRecords run(double base_error) {
    ForestField& head = made_.head;
    head = {.name = from_.name, .type = from_.type, .scale = scale_of(from_.values)};
    head.base_error = base_error;
    if (!from_.values.empty()) {
      head.low = std::ranges::min(from_.values);
      head.high = std::ranges::max(from_.values);
    }
    double largest_error = 0;
    for (const EdgeFacts& facts : facts_) largest_error = std::max(largest_error, facts.error);
    head.codes = NodeCodes(from_.values, largest_error);
    take_leaves();
    take_nodes();
    take_roots();
    if (trees_.world_codes) take_world_errors(*trees_.world_codes);
    return std::move(made_);
  }

 private:
  [[nodiscard]] bool is_leaf(std::uint32_t label) const { return label < n_leaves_; }

  void take_leaves() {
    for (std::uint32_t leaf = 0; leaf < n_leaves_; ++leaf) {
      const double exact = from_.values[trees_.mesh_vertices[leaf]];
      codes_.push_back(made_.head.scale.code(exact));
      const auto offset = offset_between(made_.head.scale.value(codes_.back()), exact);
      if (!offset) continue;
      made_.records.exact.add(leaf, *offset);
      if (leaf < trees_.n_base_leaves) made_.records.roots.exact.add(leaf, *offset);
    }
  }

  /// Children have smaller labels, so that all is known of them.
  void take_nodes() {
    for (std::uint32_t node = 0; node < facts_.size(); ++node) {
      const auto [first, second] = trees_.children[node];
      const EdgeFacts& own = facts_[node];
      codes_.push_back(merged(codes_[first], codes_[second], own.value));
      const NodeCodes& codes = made_.head.codes;
      NodeCodes::Parts all{codes.error_code(own.error), codes.low_code(own.low),
                           codes.high_code(own.high), 0};
      for (const std::uint32_t child : {first, second}) {
        if (is_leaf(child)) continue;
        const NodeCodes::Parts below =
            NodeCodes::parts(made_.records.nodes[child - n_leaves_].facts());
        all.error = std::max(all.error, below.error);
        all.low = std::min(all.low, below.low);
        all.high = std::max(all.high, below.high);
      }
      made_.records.nodes.emplace_back(difference(codes_[first], codes_[second]),
                                       NodeCodes::word(all), own.value);
    }
  }

  void take_roots() {
    for (const std::uint32_t root : trees_.roots) {
      made_.records.roots.codes.push_back(codes_[root]);
      made_.records.roots.facts.push_back(
          is_leaf(root) ? 0 : made_.records.nodes[root - n_leaves_].facts());
    }
  }

  void take_world_errors(const WorldCodes& codes) {
    const auto known = [&](std::uint32_t label) {
      return is_leaf(label) ? std::uint8_t{0} : made_.world_codes[label - n_leaves_];
    };
    for (std::uint32_t node = 0; node < facts_.size(); ++node) {
      const auto [first, second] = trees_.children[node];
      const std::uint8_t own = codes.code(world_above(facts_[node].world_error));
      made_.world_codes.push_back(std::max({own, known(first), known(second)}));
    }
    std::uint8_t largest = 0;
    for (const std::uint32_t root : trees_.roots) largest = std::max(largest, known(root));
    made_.head.base_world_error = static_cast<double>(codes.error(largest));
  }

  const FieldTrees& trees_;
  const MeshField& from_;
  std::span<const EdgeFacts> facts_;
  std::uint32_t n_leaves_;
  std::vector<std::int32_t> codes_;  ///< By label.
  FieldRecords made_;
};

}  // namespace

FieldRecords make_field(const FieldTrees& trees, const MeshField& field,
                        std::span<const EdgeFacts> facts, double base_error) {
  return FieldMaker(trees, field, facts).run(base_error);
}

double base_error_of(std::span<const float> errors, std::size_t field, std::size_t n_fields,
                     const MeshField& of) {
  if (of.values.empty()) return 0;
  const double range = std::ranges::max(of.values) - std::ranges::min(of.values);
  constexpr double kRounded = 1 + 0x1p-23;  // Shares are rounded to the nearest float32.
  double largest = 0;
  for (std::size_t i = field; i < errors.size(); i += n_fields)
    largest = std::max(largest, kRounded * std::abs(static_cast<double>(errors[i])) * range);
  return largest;
}

}  // namespace lode::tetra_mt::midpoint
