#pragma once

#include <cstdint>

#include "lode/refine/model.h"

namespace lode {

/// A RefinableModel that counts what is done to it.
template <typename Cut>
class CountedCut : public Cut {
 public:
  using Cut::Cut;
  std::uint64_t apply(NodeId node) {
    ++n_updates_;
    return Cut::apply(node);
  }
  std::uint64_t undo(NodeId node) {
    ++n_updates_;
    return Cut::undo(node);
  }
  /// Nodes applied and undone.
  [[nodiscard]] std::uint64_t n_updates() const { return n_updates_; }

 private:
  std::uint64_t n_updates_ = 0;
};

}  // namespace lode
