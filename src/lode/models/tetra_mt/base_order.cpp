#include "lode/models/tetra_mt/base_order.h"

#include <algorithm>
#include <utility>

#include "lode/core/expects.h"

namespace lode::tetra_mt {
namespace {

class BaseOrderer {
 public:
  explicit BaseOrderer(const BaseTetrahedra& base)
      : base_(base), across_(find_across(base.corners)), is_there_(base.corners.size(), 0) {
    came_.reserve(base.corners.size());
    ordered_.corners.reserve(base.corners.size());
    ordered_.makers.reserve(base.corners.size());
    ordered_.regions.reserve(base.regions.size());
  }

  BaseTetrahedra run() && {
    for (std::uint32_t first = 0; first < is_there_.size(); ++first) {
      if (is_there_[first] != 0) continue;
      add(first, base_.corners[first]);
      for (; next_ < came_.size(); ++next_) walk_on(came_[next_]);
    }
    return std::move(ordered_);
  }

 private:
  void add(std::uint32_t index, const Tetrahedron& corners) {
    is_there_[index] = 1;
    came_.push_back(index);
    ordered_.corners.push_back(corners);
    ordered_.makers.push_back(base_.makers[index]);
    if (!base_.regions.empty()) ordered_.regions.push_back(base_.regions[index]);
  }
  /// Through the faces of one, in the order of its corners as they are turned now.
  void walk_on(std::uint32_t index) {
    const Tetrahedron corners = ordered_.corners[next_];
    const Tetrahedron& own = base_.corners[index];
    for (std::size_t place = 0; place < 4; ++place) {
      const auto at =
          static_cast<std::size_t>(std::ranges::find(own, corners[place]) - own.begin());
      const std::uint32_t beyond = across_[index][at];
      if (beyond == kNone || is_there_[beyond] != 0) continue;
      const auto face = others(corners, place);
      Tetrahedron turned{face[0], face[1], face[2], kNone};
      for (const std::uint32_t v : base_.corners[beyond])
        if (std::ranges::find(face, v) == face.end()) turned[3] = v;
      if (is_turned_alike(turned, base_.corners[beyond])) add(beyond, turned);
    }
  }
  /// Whether one is an even permutation of the other.
  static bool is_turned_alike(const Tetrahedron& a, Tetrahedron b) {
    bool is_even = true;
    for (std::size_t i = 0; i < 4; ++i) {
      const auto at = static_cast<std::size_t>(std::ranges::find(b, a[i]) - b.begin());
      if (at == b.size()) return false;
      if (at == i) continue;
      std::swap(b[i], b[at]);
      is_even = !is_even;
    }
    return is_even;
  }

  const BaseTetrahedra& base_;
  std::vector<std::array<std::uint32_t, 4>> across_;
  std::vector<std::uint8_t> is_there_;
  std::vector<std::uint32_t> came_;  ///< Those there, as they came.
  std::size_t next_ = 0;
  BaseTetrahedra ordered_;
};

}  // namespace

BaseTetrahedra in_base_order(const BaseTetrahedra& base) { return BaseOrderer(base).run(); }

std::vector<std::byte> encode_base(const BaseTetrahedra& base, const BaseLimits& limits) {
  RangeWriter out;
  const std::string what = "base";
  BaseTetrahedra given = base;
  const auto done = BaseWalk<RangeWriter>(out, limits, what).code(given, given.corners.size());
  LODE_EXPECTS(done && given == base);
  return std::move(out).take();
}

Result<BaseTetrahedra> decode_base(std::span<const std::byte> bytes, std::size_t n,
                                   const BaseLimits& limits, const std::string& what) {
  RangeReader in(bytes);
  BaseTetrahedra base;
  LODE_CHECK(BaseWalk<RangeReader>(in, limits, what).code(base, n));
  if (!in.is_at_end()) return fail("{}: expected as many bytes as were read", what);
  return base;
}

}  // namespace lode::tetra_mt
