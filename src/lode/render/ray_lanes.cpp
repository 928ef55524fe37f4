#include "lode/render/ray_lanes.h"

#include <cstring>

#include "lode/render/face_meeting.h"
#include "lode/render/light_integral.h"

// Each target is another copy of this file to compile.
#define HWY_DISABLED_TARGETS (HWY_SSE4 | HWY_AVX3_DL)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lode/render/ray_lanes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace lode::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using LaneTag = hn::CappedTag<double, 8>;
using WordTag = hn::RebindToUnsigned<LaneTag>;
using IndexTag = hn::RebindToSigned<LaneTag>;
using Doubles = hn::Vec<LaneTag>;
using Words = hn::Vec<WordTag>;
using LaneMask = hn::Mask<LaneTag>;

HWY_INLINE std::uint64_t bits_of(LaneMask mask) {
  std::array<std::uint8_t, 8> bytes{};
  hn::StoreMaskBits(LaneTag(), mask, bytes.data());
  return bytes[0];
}

/// Word k of an element of `n_words` words.
template <typename Tag, typename T>
HWY_INLINE hn::Vec<Tag> gather(Tag tag, const T* base, Words first_word, std::size_t k) {
  const WordTag words;
  const auto at = hn::Add(first_word, hn::Set(words, k));
  return hn::GatherIndex(tag, base, hn::BitCast(IndexTag(), at));
}

/// A block of lanes and the mesh they are in.
struct LaneBlock {
  RayLanes& lanes;
  std::size_t first;
  LaneMask is_active;
  const std::uint64_t* cells;
  const double* vertices;

  HWY_INLINE Doubles load(const RayLanes::Row<double>& row) const {
    return hn::Load(LaneTag(), row.data() + first);
  }
  HWY_INLINE Words load(const RayLanes::Row<std::uint64_t>& row) const {
    return hn::Load(WordTag(), row.data() + first);
  }
  HWY_INLINE void store(Doubles values, RayLanes::Row<double>& row) const {
    hn::Store(values, LaneTag(), row.data() + first);
  }
  HWY_INLINE void store(Words values, RayLanes::Row<std::uint64_t>& row) const {
    hn::Store(values, WordTag(), row.data() + first);
  }
  [[nodiscard]] HWY_INLINE Words only_active(Words words) const {
    return hn::IfThenElseZero(hn::RebindMask(WordTag(), is_active), words);
  }
};

HWY_INLINE Words low_half(Words words) { return hn::And(words, hn::Set(WordTag(), 0xffffffff)); }
HWY_INLINE Words high_half(Words words) { return hn::ShiftRight<32>(words); }

HWY_INLINE Words choose(LaneMask mask, Words yes, Words no) {
  return hn::IfThenElse(hn::RebindMask(WordTag(), mask), yes, no);
}

HWY_INLINE Doubles cut(Doubles a) {
  const LaneTag d;
  return hn::And(a, hn::BitCast(d, hn::Set(WordTag(), ~kCutBits)));
}

/// The corners of the cells, and the one that the face does not have.
struct LaneApex {
  Words corners01;
  Words corners23;
  Words id;
  Doubles u;
  Doubles v;
  Doubles depth;
  Doubles level;
};

HWY_INLINE LaneApex find_apex(const LaneBlock& block, Words cell) {
  const LaneTag d;
  const WordTag w;
  RayLanes& lanes = block.lanes;
  LaneApex apex;
  apex.corners01 = gather(w, block.cells, cell, 0);
  apex.corners23 = gather(w, block.cells, cell, 1);
  const Words pairs = hn::Xor(apex.corners01, apex.corners23);
  const Words of_face =
      hn::Xor(block.load(lanes.corners[0]),
              hn::Xor(block.load(lanes.corners[1]), block.load(lanes.corners[2])));
  apex.id = block.only_active(hn::Xor(low_half(hn::Xor(pairs, high_half(pairs))), of_face));
  const Words vertex = hn::ShiftLeft<2>(apex.id);
  apex.depth = gather(d, block.vertices, vertex, 2);
  apex.level = gather(d, block.vertices, vertex, 3);
  apex.u = cut(hn::Sub(hn::Sub(gather(d, block.vertices, vertex, 0), block.load(lanes.right)),
                       hn::Mul(block.load(lanes.right_slope), apex.depth)));
  apex.v = cut(hn::Sub(hn::Sub(gather(d, block.vertices, vertex, 1), block.load(lanes.up)),
                       hn::Mul(block.load(lanes.up_slope), apex.depth)));
  return apex;
}

/// Signs of `sides` where they are zero: 1 or -1 in their place.
HWY_NOINLINE void break_ties(const LaneBlock& block, std::size_t corner, const double* u,
                             const double* v, const std::uint64_t* apex, double* sides) {
  const RayLanes& lanes = block.lanes;
  for (std::size_t i = 0; i < hn::Lanes(LaneTag()); ++i) {
    const std::size_t lane = block.first + i;
    if (sides[i] != 0) continue;
    const bool is_negative = is_tie_negative({lanes.u[corner][lane], lanes.v[corner][lane]},
                                             {u[i], v[i]}, lanes.corners[corner][lane], apex[i]);
    sides[i] = is_negative ? -1 : 1;
  }
}

HWY_INLINE LaneMask negatives(const LaneBlock& block, std::size_t corner, Doubles sides,
                              const LaneApex& apex) {
  const LaneTag d;
  const Doubles zero = hn::Zero(d);
  if (HWY_UNLIKELY(!hn::AllFalse(d, hn::And(hn::Eq(sides, zero), block.is_active)))) {
    HWY_ALIGN std::array<double, 8> side_row;
    HWY_ALIGN std::array<double, 8> u_row;
    HWY_ALIGN std::array<double, 8> v_row;
    HWY_ALIGN std::array<std::uint64_t, 8> apex_row;
    hn::Store(sides, d, side_row.data());
    hn::Store(apex.u, d, u_row.data());
    hn::Store(apex.v, d, v_row.data());
    hn::Store(apex.id, WordTag(), apex_row.data());
    break_ties(block, corner, u_row.data(), v_row.data(), apex_row.data(), side_row.data());
    sides = hn::Load(d, side_row.data());
  }
  return hn::Lt(sides, zero);
}

/// By corner of the face: the edge from it to the apex, and whether the next face does not have it.
struct LaneSides {
  std::array<Doubles, 3> edges;
  std::array<LaneMask, 3> leaves;
};

HWY_INLINE LaneSides find_sides(const LaneBlock& block, const LaneApex& apex) {
  RayLanes& lanes = block.lanes;
  LaneSides sides;
  std::array<LaneMask, 3> negative;
  for (std::size_t i = 0; i < 3; ++i) {
    sides.edges[i] =
        hn::Sub(hn::Mul(block.load(lanes.u[i]), apex.v), hn::Mul(apex.u, block.load(lanes.v[i])));
    negative[i] = negatives(block, i, sides.edges[i], apex);
  }
  // A negative side follows the corner that leaves, then a positive one. All alike cannot be.
  sides.leaves[1] = hn::AndNot(negative[0], negative[2]);
  sides.leaves[2] = hn::AndNot(negative[1], negative[0]);
  sides.leaves[0] = hn::Not(hn::Or(sides.leaves[1], sides.leaves[2]));
  return sides;
}

/// Sets what is across the face without the corner that leaves.
HWY_INLINE void find_next(const LaneBlock& block, Words cell, const LaneApex& apex,
                          const LaneSides& sides) {
  const WordTag w;
  RayLanes& lanes = block.lanes;
  const Words gone =
      choose(sides.leaves[2], block.load(lanes.corners[2]),
             choose(sides.leaves[1], block.load(lanes.corners[1]), block.load(lanes.corners[0])));
  const auto is1 = hn::Eq(high_half(apex.corners01), gone);
  const auto is2 = hn::Eq(low_half(apex.corners23), gone);
  const auto is3 = hn::Eq(high_half(apex.corners23), gone);
  const Words word = hn::IfThenElseZero(hn::Or(is2, is3), hn::Set(w, 1));
  const Words across = gather(w, block.cells, hn::Add(cell, word), 2);
  block.store(hn::IfThenElse(hn::Or(is1, is3), high_half(across), low_half(across)), lanes.next);
}

/// Through the cells to their other faces; where these are met comes back.
HWY_INLINE void walk(const LaneBlock& block, Doubles& met_depth, Doubles& met_level) {
  const LaneTag d;
  RayLanes& lanes = block.lanes;
  const Words cell = hn::ShiftLeft<2>(block.only_active(block.load(lanes.next)));
  const LaneApex apex = find_apex(block, cell);
  const LaneSides sides = find_sides(block, apex);
  find_next(block, cell, apex, sides);
  Doubles sum = hn::Zero(d);
  Doubles depth_sum = hn::Zero(d);
  Doubles level_sum = hn::Zero(d);
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    const std::size_t k = (i + 2) % 3;
    const LaneMask leaves = sides.leaves[i];
    const Doubles edge =
        hn::IfThenElse(sides.leaves[j], hn::Neg(sides.edges[k]),
                       hn::IfThenElse(sides.leaves[k], sides.edges[j], block.load(lanes.edges[i])));
    block.store(edge, lanes.edges[i]);
    block.store(choose(leaves, apex.id, block.load(lanes.corners[i])), lanes.corners[i]);
    block.store(hn::IfThenElse(leaves, apex.u, block.load(lanes.u[i])), lanes.u[i]);
    block.store(hn::IfThenElse(leaves, apex.v, block.load(lanes.v[i])), lanes.v[i]);
    const Doubles depth = hn::IfThenElse(leaves, apex.depth, block.load(lanes.depths[i]));
    const Doubles level = hn::IfThenElse(leaves, apex.level, block.load(lanes.levels[i]));
    block.store(depth, lanes.depths[i]);
    block.store(level, lanes.levels[i]);
    sum = hn::Add(sum, edge);
    depth_sum = hn::Add(depth_sum, hn::Mul(edge, depth));
    level_sum = hn::Add(level_sum, hn::Mul(edge, level));
  }
  const LaneMask has_area = hn::Gt(sum, hn::Zero(d));
  const Doubles share = hn::Div(hn::Set(d, 1.0), sum);
  met_depth = hn::IfThenElse(has_area, hn::Mul(depth_sum, share), block.load(lanes.depth));
  met_level = hn::IfThenElse(has_area, hn::Mul(level_sum, share), block.load(lanes.level));
}

/// a - t b
HWY_INLINE Doubles less(double a, Doubles t, Doubles b) {
  return hn::Sub(hn::Set(LaneTag(), a), hn::Mul(t, b));
}

/// LightIntegral::add_thin() for the lanes of `is_thin`.
HWY_INLINE void add_thin(const LaneBlock& block, LaneMask is_thin, Doubles t, Doubles b, Doubles h0,
                         Doubles h1) {
  const LaneTag d;
  RayLanes& lanes = block.lanes;
  const Doubles mean =
      less(1, t,
           less(1.0 / 2, t,
                less(1.0 / 6, t, less(1.0 / 24, t, less(1.0 / 120, t, hn::Set(d, 1.0 / 720))))));
  const Doubles first =
      less(1.0 / 6, t, less(1.0 / 12, t, less(1.0 / 40, t, hn::Set(d, 1.0 / 180))));
  const Doubles second = less(1.0 / 60, t, less(1.0 / 120, t, hn::Set(d, 1.0 / 420)));
  const Doubles m = hn::Add(
      mean,
      hn::Mul(b, hn::Add(first, hn::Mul(b, hn::Add(second, hn::Mul(b, hn::Set(d, 1.0 / 840)))))));
  const Doubles transmittance = block.load(lanes.transmittance);
  const Doubles near_weight = hn::Sub(hn::Set(d, 1.0), m);
  const Doubles shone = hn::IfThenElseZero(is_thin, hn::Mul(transmittance, hn::Mul(t, mean)));
  const Doubles levels = hn::IfThenElseZero(
      is_thin,
      hn::Add(hn::Mul(shone, h1), hn::Mul(hn::Mul(transmittance, near_weight), hn::Sub(h0, h1))));
  block.store(hn::Add(block.load(lanes.level_weight), levels), lanes.level_weight);
  block.store(hn::Add(block.load(lanes.weight), shone), lanes.weight);
  block.store(hn::Sub(transmittance, shone), lanes.transmittance);
}

/// Over the segment to where the face is met; lanes whose segment is still open come back.
HWY_INLINE LaneMask integrate(const LaneBlock& block, Doubles met_depth, Doubles met_level) {
  const LaneTag d;
  RayLanes& lanes = block.lanes;
  const Doubles zero = hn::Zero(d);
  const Doubles from = block.load(lanes.depth);
  const Doubles from_level = block.load(lanes.level);
  // Rounding may turn the two faces of a flat cell round: depths that do not grow add nothing.
  const Doubles to = hn::Max(from, met_depth);
  block.store(to, lanes.to_depth);
  block.store(met_level, lanes.to_level);
  const Doubles begin = block.load(lanes.begin);
  const LaneMask is_behind = hn::Le(to, begin);  // The eye.
  const Doubles length = hn::Mul(hn::IfThenElse(is_behind, zero, hn::Sub(to, from)),
                                 block.load(lanes.world_per_depth));
  const Doubles origin = block.load(lanes.origin);
  const Doubles extinction = block.load(lanes.extinction);
  const Doubles slope = block.load(lanes.extinction_slope);
  const Doubles h0 = hn::Sub(from_level, origin);
  const Doubles h1 = hn::Sub(met_level, origin);
  const Doubles near = hn::Max(zero, hn::Add(extinction, hn::Mul(slope, h0)));
  const Doubles far = hn::Max(zero, hn::Add(extinction, hn::Mul(slope, h1)));
  const Doubles half = hn::Set(d, 0.5);
  const Doubles t = hn::Mul(hn::Mul(half, hn::Add(near, far)), length);
  const Doubles b = hn::Mul(hn::Mul(half, hn::Sub(far, near)), length);
  const LaneMask is_on_ramp = hn::And(hn::Ge(met_level, block.load(lanes.lower)),
                                      hn::Le(met_level, block.load(lanes.upper)));
  const LaneMask is_within =
      hn::And(hn::Or(is_behind, hn::Ge(from, begin)), hn::Le(to, block.load(lanes.end)));
  const LaneMask is_thin =
      hn::And(block.is_active,
              hn::And(hn::And(is_on_ramp, is_within), hn::Le(t, hn::Set(d, LightIntegral::kThin))));
  add_thin(block, is_thin, t, b, h0, h1);
  block.store(hn::IfThenElse(is_thin, to, from), lanes.depth);
  block.store(hn::IfThenElse(is_thin, met_level, from_level), lanes.level);
  return hn::AndNot(is_thin, block.is_active);
}

LaneEvents run_step(const std::uint64_t* cells, const double* vertices, std::size_t n,
                    RayLanes& lanes) {
  const LaneTag d;
  LaneEvents events;
  for (std::size_t i = 0; i < n; i += hn::Lanes(d)) {
    const LaneBlock block{lanes, i, hn::FirstN(d, n - i), cells, vertices};
    Doubles met_depth;
    Doubles met_level;
    walk(block, met_depth, met_level);
    const LaneMask is_open = integrate(block, met_depth, met_level);
    const LaneMask is_outer =
        hn::RebindMask(d, hn::Gt(hn::BitCast(IndexTag(), block.load(lanes.next)),
                                 hn::Set(IndexTag(), std::int64_t{CellLinks::kOuter} - 1)));
    const LaneMask is_done =
        hn::Or(hn::Lt(block.load(lanes.transmittance), hn::Set(d, LightIntegral::kOpaque)),
               hn::Ge(block.load(lanes.depth), block.load(lanes.end)));
    events.is_segment_open |= bits_of(is_open) << i;
    events.has_ended |= bits_of(hn::And(block.is_active, hn::Or(is_outer, is_done))) << i;
  }
  return events;
}

}  // namespace lode::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lode {

HWY_EXPORT(run_step);

LaneEvents step_lanes(const CellLinks& links, std::span<const ViewVertex> vertices, std::size_t n,
                      RayLanes& lanes) {
  static_assert(sizeof(LinkedCell) == 4 * sizeof(std::uint64_t));
  static_assert(sizeof(ViewVertex) == 4 * sizeof(double));
  return HWY_DYNAMIC_DISPATCH(run_step)(links.cells.data()->words.data(), &vertices.data()->right,
                                        n, lanes);
}

}  // namespace lode
#endif
