#include "lode/api/piece_simplifier.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "lode/core/expects.h"
#include "lode/mappers/band_components.h"
#include "lode/mappers/border_vertices.h"

namespace lode {
namespace {

/// Three times the centre.
double centre3(const Surface& surface, std::uint32_t triangle, std::size_t axis) {
  double sum = 0;
  for (const std::uint32_t v : surface.triangles[triangle])
    sum += static_cast<double>(surface.positions[v][axis]);
  return sum;
}

}  // namespace

Result<void> PieceSimplifier::add(SurfacePiece piece) {
  const auto n_new = static_cast<std::uint32_t>(piece.n_new());
  std::vector<std::uint32_t> numbers(piece.surface.positions.size(), kGone);  // in the sink
  for (std::size_t i = 0; i < piece.earlier.size(); ++i)
    numbers[n_new + i] = number_of(piece.earlier[i]);
  local_.assign(numbers.size(), kGone);
  for (const Triangles& triangles : cut(piece.surface))
    LODE_CHECK(add_part(piece.surface, triangles, numbers));
  const std::vector<std::uint8_t> is_border = find_border_vertices(piece.surface);
  std::vector<Shared> shared;
  for (std::uint32_t v = 0; v < n_new; ++v)
    if (is_border[v] != 0) shared.push_back({piece.first_new + v, numbers[v]});
  shared.shrink_to_fit();
  shared_.push_back(std::move(shared));
  if (shared_.size() > shape_.n_apart) shared_.pop_front();
  return {};
}

/// Parts of a piece, each in a box of cells of its own.
std::vector<PieceSimplifier::Triangles> PieceSimplifier::cut(const Surface& surface) const {
  std::vector<Triangles> parts;
  std::vector<Triangles> open(1, Triangles(surface.triangles.size()));
  std::iota(open.front().begin(), open.front().end(), 0U);
  while (!open.empty()) {
    Triangles lower = std::move(open.back());
    open.pop_back();
    Triangles upper;
    if (lower.size() > shape_.max_triangles && halve(surface, lower, upper)) {
      open.push_back(std::move(upper));
      open.push_back(std::move(lower));
    } else if (!lower.empty()) {
      parts.push_back(std::move(lower));
    }
  }
  return parts;
}

/// Moves what is above a plane of samples to `upper`. False: all is in one cell.
bool PieceSimplifier::halve(const Surface& surface, Triangles& lower, Triangles& upper) const {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const Mat3 to_world = shape_.grid.index_to_world_matrix();
  double most = 1;
  std::size_t axis = 0;
  double plane3 = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    double least = kInfinity;
    double largest = -kInfinity;
    for (const std::uint32_t t : lower) {
      const double c = centre3(surface, t, i) / 3;
      least = std::min(least, c);
      largest = std::max(largest, c);
    }
    const Vec3d& row = to_world.rows[i];
    const double step = std::abs(row[0] + row[1] + row[2]);  // two of them are 0
    const double zero = shape_.grid.origin[i] - surface.origin[i];
    const double begin = std::floor((least - zero) / step);
    const double end = std::floor((largest - zero) / step) + 1;
    if (!(end - begin > most)) continue;
    most = end - begin;
    axis = i;
    plane3 = 3 * (zero + step * std::floor((begin + end) / 2));
  }
  if (most <= 1) return false;
  const auto above = std::stable_partition(lower.begin(), lower.end(), [&](std::uint32_t t) {
    return centre3(surface, t, axis) < plane3;
  });
  if (above == lower.begin() || above == lower.end()) return false;
  upper.assign(above, lower.end());
  lower.erase(above, lower.end());
  return true;
}

/// `numbers`: of the piece's vertices in the sink, kGone before they are there.
Result<void> PieceSimplifier::add_part(const Surface& surface, const Triangles& triangles,
                                       std::vector<std::uint32_t>& numbers) {
  std::vector<std::uint32_t> vertices;
  for (const std::uint32_t t : triangles)
    for (const std::uint32_t v : surface.triangles[t]) {
      if (local_[v] != kGone) continue;
      local_[v] = 0;
      vertices.push_back(v);
    }
  std::ranges::sort(vertices);
  const auto is_new = [&](std::uint32_t v) { return numbers[v] == kGone; };
  const auto known = std::stable_partition(vertices.begin(), vertices.end(), is_new);
  const auto n_new = static_cast<std::size_t>(known - vertices.begin());
  SurfacePiece part;
  part.surface.origin = surface.origin;
  part.surface.positions.reserve(vertices.size());
  for (std::uint32_t i = 0; i < vertices.size(); ++i) {
    local_[vertices[i]] = i;
    part.surface.positions.push_back(surface.positions[vertices[i]]);
    if (!surface.normals.empty()) part.surface.normals.push_back(surface.normals[vertices[i]]);
    if (i >= n_new) part.earlier.push_back(numbers[vertices[i]]);
  }
  part.surface.triangles.reserve(triangles.size());
  for (const std::uint32_t t : triangles) {
    const auto& v = surface.triangles[t];
    part.surface.triangles.push_back({local_[v[0]], local_[v[1]], local_[v[2]]});
  }
  for (const std::uint32_t v : vertices) local_[v] = kGone;
  part.first_new = out_.n_vertices();
  LODE_TRY(const auto left, drop_components(part.surface));
  std::vector<std::uint32_t> simplified;
  LODE_TRY(const SimplifyReport done,
           simplify_piece(part.surface, options_, simplified, progress_));
  report_.join(done);
  part.surface.shrink_to_fit();  // it may wait for the others
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const std::uint32_t after = left[i] == kGone ? kGone : simplified[left[i]];
    LODE_EXPECTS(i < n_new || after != kGone);
    if (i < n_new && after != kGone) numbers[vertices[i]] = part.first_new + after;
  }
  return out_.add(std::move(part));
}

/// Those in the band, where they may go: closed ones, which no other part has vertices of. By
/// vertex: its number among those that are left.
Result<std::vector<std::uint32_t>> PieceSimplifier::drop_components(Surface& surface) {
  std::vector<std::uint32_t> left(surface.positions.size());
  std::iota(left.begin(), left.end(), 0U);
  if (options_.band == nullptr || !shape_.drops_components) return left;
  LODE_TRY(const auto found,
           find_components_in_band(surface, *options_.band, options_.threads, progress_));
  std::uint32_t n = 0;
  for (std::size_t v = 0; v < left.size(); ++v)
    left[v] = found.may_go[found.numbers.of_vertex[v]] != 0 ? kGone : n++;
  const Dropped dropped = lode::drop_components(surface, found.numbers, found.may_go);
  report_.components_dropped += dropped.components;
  report_.triangles_dropped += dropped.cells;
  return left;
}

std::uint32_t PieceSimplifier::number_of(std::uint32_t before) const {
  for (auto piece = shared_.rbegin(); piece != shared_.rend(); ++piece) {
    const auto found = std::ranges::lower_bound(*piece, before, {}, &Shared::before);
    if (found != piece->end() && found->before == before) return found->after;
  }
  LODE_EXPECTS(false);
  return 0;
}

}  // namespace lode
