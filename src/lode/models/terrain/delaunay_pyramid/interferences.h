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

  /// Begins a level, for so many triangles. All are begun before one is filled that has links, so
  /// that what they take is known early; fails where that is too much.
  Result<void> begin(std::size_t n_triangles, LinkLists& links) {
    LODE_CHECK(take((n_triangles + 1) * sizeof(links.first[0])));
    links.first.reserve(n_triangles + 1);
    links.first.push_back(0);
    return {};
  }

  /// Of the next triangle of a level. number_of(t): of what is linked.
  template <typename NumberOf>
  Result<void> add(std::uint32_t t, std::uint32_t later, const NumberOf& number_of,
                   LinkLists& links) {
    const LatticeCorners own = corners_of(history_, history_.triangles[t].corner);
    Result<void> grown;
    descent_.restart();
    descent_.run(
        t, insertions::NodeSet(later),
        [&](std::uint32_t other) {
          return grown &&
                 (other == t ||
                  do_interiors_meet(own, corners_of(history_, history_.triangles[other].corner)));
        },
        [&](std::uint32_t other) {
          if (links.items.size() == links.items.capacity() && grown)
            grown = resize(links.items, grown_size(links.items.size()));
          if (!grown) return;
          links.items.push_back(number_of(other));
          ++n_links_;
        });
    if (!grown) return grown.error();
    std::sort(links.items.begin() + static_cast<std::ptrdiff_t>(links.first.back()),
              links.items.end());
    add_none(links);
    return {};
  }
  /// Of one that has no links.
  static void add_none(LinkLists& links) { links.first.push_back(links.items.size()); }

  /// Ends a level: gives back the room that it does not need.
  Result<void> end(LinkLists& links) { return resize(links.items, links.items.size()); }

 private:
  static std::size_t grown_size(std::size_t n) {
    constexpr std::size_t kLeast = 16;
    return std::max(kLeast, n + n / 2);
  }
  /// Room for n items, which are there twice for a moment.
  Result<void> resize(std::vector<std::uint32_t>& items, std::size_t n) {
    if (items.capacity() == n) return {};
    LODE_CHECK(take(n * sizeof(items[0])));
    std::vector<std::uint32_t> moved;
    moved.reserve(n);
    moved.assign(items.begin(), items.end());
    n_bytes_ -= items.capacity() * sizeof(items[0]);
    items.swap(moved);
    return {};
  }
  Result<void> take(std::uint64_t n_bytes) {
    if (n_bytes > limit_.n_bytes - std::min(limit_.n_bytes, n_bytes_))
      return fail(
          "expected interference links of up to {} bytes, got more, {} links so far: fewer levels, "
          "or the lists without links, take less, and --memory-limit allows more",
          limit_.n_bytes, n_links_);
    n_bytes_ += n_bytes;
    return {};
  }

  const History& history_;
  Descent descent_;
  EncodingLimit limit_;
  std::uint64_t n_bytes_ = 0;  ///< Of all that is there.
  std::uint64_t n_links_ = 0;
};

/// Its place among ascending numbers.
[[nodiscard]] inline std::uint32_t number_in(const std::vector<std::uint32_t>& ascending,
                                             std::uint32_t t) {
  return static_cast<std::uint32_t>(std::ranges::lower_bound(ascending, t) - ascending.begin());
}

}  // namespace lode::delaunay_pyramid
