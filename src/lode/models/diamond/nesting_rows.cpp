#include "lode/models/diamond/nesting_rows.h"

// Each target is another copy of this file to compile.
#define HWY_DISABLED_TARGETS (HWY_SSE4 | HWY_AVX3_DL)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lode/models/diamond/nesting_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace lode::diamond::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Of two equal values (0 and -0) both take the second.
struct Larger {
  template <typename V>
  static HWY_INLINE V of(V value, V so_far) {
    return hn::Max(value, so_far);
  }
  template <typename T>
  static T of_one(T value, T so_far) {
    return value > so_far ? value : so_far;
  }
};
struct Smaller {
  template <typename V>
  static HWY_INLINE V of(V value, V so_far) {
    return hn::Min(value, so_far);
  }
  template <typename T>
  static T of_one(T value, T so_far) {
    return value < so_far ? value : so_far;
  }
};

/// One attribute of a row.
template <typename Op, typename T>
struct ValueRows {
  std::array<const T*, 4> rows{};
  std::size_t n_rows = 0;
  std::size_t n_children = 0;  ///< Points of each.
  T none{};                    ///< What stands for no child.
  T* nodes = nullptr;
  std::size_t n = 0;
  bool keeps_own = false;  ///< Joined with what a node has; else that is replaced.
};

/// The node at x, anywhere in the row.
template <ChildPlaces kPlaces, typename Op, typename T>
void join_one(const ValueRows<Op, T>& r, std::size_t x) {
  T joined = r.none;
  const auto take = [&joined](const T* row, std::size_t at, std::size_t n) {
    if (at < n) joined = Op::of_one(row[at], joined);  // what is before 0 is beyond n
  };
  for (std::size_t i = 0; i < r.n_rows; ++i) {
    if constexpr (kPlaces == ChildPlaces::halves) {
      take(r.rows[i], 2 * x - 1, r.n_children);
      take(r.rows[i], 2 * x + 1, r.n_children);
    } else {
      if constexpr (kPlaces == ChildPlaces::cubes) take(r.rows[i], x - 1, r.n_children);
      take(r.rows[i], x, r.n_children);
    }
  }
  if constexpr (kPlaces == ChildPlaces::at_and_round) {
    take(r.nodes, x - 1, r.n);
    take(r.nodes, x + 1, r.n);
  }
  r.nodes[x] = r.keeps_own ? Op::of_one(r.nodes[x], joined) : joined;
}

/// What the children of the nodes from x on are together; all of them exist.
template <ChildPlaces kPlaces, typename Op, typename T>
HWY_INLINE hn::Vec<hn::ScalableTag<T>> join_at(const ValueRows<Op, T>& r, std::size_t x) {
  const hn::ScalableTag<T> d;
  const std::size_t n_lanes = hn::Lanes(d);
  auto joined = hn::Set(d, r.none);
  for (std::size_t i = 0; i < r.n_rows; ++i) {
    const T* const row = r.rows[i];
    if constexpr (kPlaces == ChildPlaces::halves) {
      for (const std::size_t first : {2 * x - 1, 2 * x + 1})
        joined = Op::of(
            hn::ConcatEven(d, hn::LoadU(d, row + first + n_lanes), hn::LoadU(d, row + first)),
            joined);
    } else {
      if constexpr (kPlaces == ChildPlaces::cubes)
        joined = Op::of(hn::LoadU(d, row + x - 1), joined);
      joined = Op::of(hn::LoadU(d, row + x), joined);
    }
  }
  if constexpr (kPlaces == ChildPlaces::at_and_round) {
    joined = Op::of(hn::LoadU(d, r.nodes + x - 1), joined);
    joined = Op::of(hn::LoadU(d, r.nodes + x + 1), joined);
  }
  return joined;
}

/// The nodes from x on, where the mask is set.
template <ChildPlaces kPlaces, typename Op, typename T, typename M>
HWY_INLINE void join_some(const ValueRows<Op, T>& r, std::size_t x, M is_node) {
  const hn::ScalableTag<T> d;
  const auto before = hn::LoadU(d, r.nodes + x);
  auto joined = join_at<kPlaces>(r, x);
  if (r.keeps_own) joined = Op::of(before, joined);
  hn::StoreU(hn::IfThenElse(is_node, joined, before), d, r.nodes + x);
}

/// [begin, end): where all children exist, as many as vectors read.
struct WholePart {
  std::size_t begin;
  std::size_t end;
};
template <ChildPlaces kPlaces>
WholePart whole_part(std::size_t n, std::size_t n_children) {
  if constexpr (kPlaces == ChildPlaces::at_x) return {0, std::min(n, n_children)};
  if constexpr (kPlaces == ChildPlaces::at_and_round)
    return {1, std::min(n - std::min<std::size_t>(n, 1), n_children)};
  if constexpr (kPlaces == ChildPlaces::halves)
    return {1, std::min(n, (n_children - std::min<std::size_t>(n_children, 1)) / 2)};
  return {1, std::min(n, n_children)};
}

template <ChildPlaces kPlaces, typename Op, typename T>
void join_row(const ValueRows<Op, T>& r, std::size_t parity) {
  const hn::ScalableTag<T> d;
  const hn::RebindToUnsigned<decltype(d)> du;
  using U = hn::TFromD<decltype(du)>;
  const std::size_t n_lanes = hn::Lanes(d);
  auto [begin, end] = whole_part<kPlaces>(r.n, r.n_children);
  if (begin + n_lanes > end) begin = end = 0;
  for (std::size_t x = parity; x < begin; x += 2) join_one<kPlaces>(r, x);
  const auto odd = hn::And(hn::Iota(du, U{0}), hn::Set(du, U{1}));
  const auto is_node = [&](std::size_t x) HWY_ATTR {
    return hn::RebindMask(d, hn::Eq(odd, hn::Set(du, static_cast<U>((x ^ parity) & 1U))));
  };
  const auto mask = is_node(begin);  // the number of lanes is even
  for (std::size_t x = begin; x + n_lanes < end; x += n_lanes) join_some<kPlaces>(r, x, mask);
  // Joining nodes again changes nothing.
  if (end > 0) join_some<kPlaces>(r, end - n_lanes, is_node(end - n_lanes));
  for (std::size_t x = end + ((end ^ parity) & 1U); x < r.n; x += 2) join_one<kPlaces>(r, x);
}

template <ChildPlaces kPlaces>
void join_attributes(const ChildRows& children, std::size_t n, std::size_t parity,
                     const NodeRow& nodes) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const std::size_t n_rows = children.n_rows;
  ValueRows<Larger, ErrorCode> errors{{}, n_rows, children.n, 0, nodes.error, n, true};
  ValueRows<Smaller, float> lows{{}, n_rows, children.n, kInfinity, nodes.low, n, false};
  ValueRows<Larger, float> highs{{}, n_rows, children.n, -kInfinity, nodes.high, n, false};
  for (std::size_t i = 0; i < n_rows; ++i) {
    errors.rows[i] = children.rows[i].error;
    lows.rows[i] = children.rows[i].low;
    highs.rows[i] = children.rows[i].high;
  }
  join_row<kPlaces>(errors, parity);
  join_row<kPlaces>(lows, parity);
  join_row<kPlaces>(highs, parity);
}

void join_children_of_row(const ChildRows& children, std::size_t n, std::size_t parity,
                          const NodeRow& nodes) {
  switch (children.places) {
    case ChildPlaces::at_x: return join_attributes<ChildPlaces::at_x>(children, n, parity, nodes);
    case ChildPlaces::at_and_round:
      return join_attributes<ChildPlaces::at_and_round>(children, n, parity, nodes);
    case ChildPlaces::halves:
      return join_attributes<ChildPlaces::halves>(children, n, parity, nodes);
    case ChildPlaces::cubes: return join_attributes<ChildPlaces::cubes>(children, n, parity, nodes);
  }
}

}  // namespace lode::diamond::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lode::diamond {

HWY_EXPORT(join_children_of_row);

void join_children(const ChildRows& children, std::size_t n, std::size_t parity,
                   const NodeRow& nodes) {
  HWY_DYNAMIC_DISPATCH(join_children_of_row)(children, n, parity, nodes);
}

}  // namespace lode::diamond
#endif
