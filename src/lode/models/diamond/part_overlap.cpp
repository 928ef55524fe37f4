#include "lode/models/diamond/part_overlap.h"

#include <algorithm>

namespace lode::diamond {
namespace {

/// Moves [first, first + n) to the beginning, as far as it is there; room for `capacity` elements.
template <typename T>
void move_to_front(UninitializedArray<T>& array, std::size_t first, std::size_t n,
                   std::size_t capacity) {
  array.reserve(capacity);
  if (first >= array.size()) return;
  n = std::min(n, array.size() - first);
  std::memmove(array.data(), array.data() + first, n * sizeof(T));
}

/// Elements of a level's arrays in one layer across the last axis.
template <int D>
std::size_t layer_size(const Shape<D>& shape, int level) {
  const Index<D> dims = shape.attribute_dims(level);
  return n_points<D>(dims) / as_size(dims[kLastAxis<D>]);
}

}  // namespace

template <int D>
std::size_t n_overlap_nodes(const Shape<D>& shape, int level, std::size_t n) {
  const std::int32_t cells = (kOverlapBricks * kBrickEdge<D>) >> std::max(level, 1);
  // Level 0 has one entry a cube, not a grid.
  return std::min(n, as_size(cells + (level > 0 ? 1 : 0)) * layer_size<D>(shape, level));
}

/// Where a level's nodes begin in layer `first` of bricks, and how many the overlap has from there.
template <int D>
std::array<std::size_t, 2> overlap_of(const Model<D>& model, int level, std::int32_t first) {
  const std::size_t n = n_points<D>(model.shape.attribute_dims(level));
  const std::size_t from =
      as_size((first * kBrickEdge<D>) >> std::max(level, 1)) * layer_size<D>(model.shape, level);
  return {from, n_overlap_nodes<D>(model.shape, level, n)};
}

template <int D>
void keep_overlap(const Model<D>& model, std::int32_t first, PartErrors& own) {
  own.resize(model.levels.size());
  for (std::size_t i = 1; i < own.size(); ++i) {
    const UninitializedArray<ErrorCode>& errors = model.levels[i].error;
    const auto [from, n] = overlap_of<D>(model, static_cast<int>(i), first);
    const std::size_t begin = std::min(from, errors.size());
    const std::size_t end = std::min(from + n, errors.size());
    own[i].assign(errors.data() + begin, errors.data() + end);
  }
}

template <int D>
void move_overlap(Model<D>& model, const PartErrors& own, std::int32_t first,
                  const Index<D>& dims) {
  const Shape<D> next = Shape<D>::of(dims);
  const std::size_t bricks = model.n_bricks() / as_size(model.brick_dims[kLastAxis<D>]);
  const std::size_t brick_bytes = kBrickSize<D> * model.sample_size();
  move_to_front(model.samples, as_size(first) * bricks * brick_bytes,
                as_size(kOverlapBricks) * bricks * brick_bytes,
                n_points<D>(brick_counts<D>(next)) * brick_bytes);
  for (std::size_t i = 0; i < model.levels.size(); ++i) {
    const int level = static_cast<int>(i);
    NodeLevel& nodes = model.levels[i];
    const auto [from, n] = overlap_of<D>(model, level, first);
    const std::size_t capacity = n_points<D>(next.attribute_dims(level));
    // What is nested is found again from level 0.
    move_to_front(nodes.error, from, level == 0 ? n : 0, capacity);
    if (level > 0) std::copy(own[i].begin(), own[i].end(), nodes.error.begin());
    move_to_front(nodes.low, from, level == 0 ? n : 0, capacity);
    move_to_front(nodes.high, from, level == 0 ? n : 0, capacity);
    move_to_front(model.worlds[i], from, level == 0 ? n : 0, capacity);
  }
}

template void keep_overlap<2>(const Model<2>&, std::int32_t, PartErrors&);
template void keep_overlap<3>(const Model<3>&, std::int32_t, PartErrors&);
template void move_overlap<2>(Model<2>&, const PartErrors&, std::int32_t, const Index<2>&);
template void move_overlap<3>(Model<3>&, const PartErrors&, std::int32_t, const Index<3>&);
template std::size_t n_overlap_nodes<2>(const Shape<2>&, int, std::size_t);
template std::size_t n_overlap_nodes<3>(const Shape<3>&, int, std::size_t);

}  // namespace lode::diamond
