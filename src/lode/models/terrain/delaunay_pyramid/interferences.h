#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "lode/core/result.h"
#include "lode/models/terrain/delaunay_pyramid/encodings.h"
#include "lode/models/terrain/insertions/descent.h"

namespace lode::delaunay_pyramid {

using delaunay::meets_window;
using insertions::corners_of;
using insertions::Descent;
using insertions::do_interiors_meet;
using insertions::holds;
using insertions::LatticeCorners;
using insertions::Triangle;

/// By triangle of the mesh at `time`, those of the mesh at `later` whose interiors meet its own.
class Interferences {
 public:
  Interferences(const History& history, EncodingLimit limit)
      : history_(history), descent_(history), limit_(limit) {}

  /// number_of(t): of what is linked.
  template <typename NumberOf>
  Result<void> add(std::uint32_t t, std::uint32_t later, const NumberOf& number_of,
                   LinkLists& links) {
    const LatticeCorners own = corners_of(history_, history_.triangles[t].corner);
    if (links.first.empty()) links.first.push_back(0);
    descent_.restart();
    descent_.run(
        t, insertions::NodeSet(later),
        [&](std::uint32_t other) {
          return other == t ||
                 do_interiors_meet(own, corners_of(history_, history_.triangles[other].corner));
        },
        [&](std::uint32_t other) { links.items.push_back(number_of(other)); });
    std::sort(links.items.begin() + static_cast<std::ptrdiff_t>(links.first.back()),
              links.items.end());
    n_links_ += links.items.size() - links.first.back();
    n_bytes_ += (links.items.size() - links.first.back()) * sizeof(links.items[0]);
    n_bytes_ += sizeof(links.first[0]);
    links.first.push_back(links.items.size());
    if (n_bytes_ > limit_.n_bytes)
      return fail(
          "expected interference links of up to {} bytes, got more, {} links so far: fewer levels, "
          "or the lists without links, take less, and --memory-limit allows more",
          limit_.n_bytes, n_links_);
    return {};
  }

 private:
  const History& history_;
  Descent descent_;
  EncodingLimit limit_;
  std::uint64_t n_bytes_ = 0;
  std::uint64_t n_links_ = 0;
};

/// Its place among ascending numbers.
[[nodiscard]] inline std::uint32_t number_in(const std::vector<std::uint32_t>& ascending,
                                             std::uint32_t t) {
  return static_cast<std::uint32_t>(std::ranges::lower_bound(ascending, t) - ascending.begin());
}

}  // namespace lode::delaunay_pyramid
