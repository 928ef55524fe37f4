#include "lode/mappers/collapse_cover.h"

#include <algorithm>
#include <cmath>

#include "lode/mappers/collapse_mesh.h"

namespace lode::simplification {
namespace {

bool is_near_box(const std::pair<Vec3f, Vec3f>& box, const Vec3f& low, const Vec3f& high,
                 float reach) {
  for (std::size_t i = 0; i < 3; ++i)
    if (low[i] > box.second[i] + reach || high[i] < box.first[i] - reach) return false;
  return true;
}

}  // namespace

void Cover::begin(const Piece& triangle) {
  clear();
  lower_ = upper_ = triangle[0];
  for (const Vec3d& corner : triangle)
    for (std::size_t i = 0; i < 3; ++i) {
      lower_[i] = std::min(lower_[i], corner[i]);
      upper_[i] = std::max(upper_[i], corner[i]);
    }
  const double reach = 1.01 * static_cast<double>(limit_);
  for (std::size_t i = 0; i < 3; ++i) {
    lower_[i] -= reach;
    upper_[i] += reach;
  }
}

std::uint32_t Cover::nearest(const Vec3d& point) {
  find_distances(point, 0, vertices_.size());
  const auto end = distances_.begin() + static_cast<std::ptrdiff_t>(vertices_.size());
  const auto least = std::min_element(distances_.begin(), end);
  return least == end ? kNone : vertices_[static_cast<std::size_t>(least - distances_.begin())];
}

bool Cover::covers(const Piece& triangle, const ShadowCover* shadows) {
  n_tests_ = 0;
  shadows_ = shadows;
  for (std::size_t i = 0; i < 3; ++i)
    if (upper_[i] - lower_[i] > 2000 * static_cast<double>(limit_)) return false;
  constexpr int kDepth = 10;
  return covers_part(triangle, 0, vertices_.size(), kDepth);
}

void Cover::find_distances(const Vec3d& point, std::size_t begin, std::size_t end) {
  if (distances_.size() < end) distances_.resize(2 * end);
  const Vec3d at = point - lower_;
  const auto px = static_cast<float>(at[0]);
  const auto py = static_cast<float>(at[1]);
  const auto pz = static_cast<float>(at[2]);
  const float* const xs = local_[0].data();
  const float* const ys = local_[1].data();
  const float* const zs = local_[2].data();
  float* const distances = distances_.data();
  for (std::size_t i = begin; i < end; ++i) {
    const float x = xs[i] - px;
    const float y = ys[i] - py;
    const float z = zs[i] - pz;
    distances[i] = x * x + y * y + z * z;
  }
}

bool Cover::covers_part(const Piece& piece, std::size_t begin, std::size_t end, int depth) {
  if (begin == end || depth == 0 || n_tests_ > kMostTests) return false;
  const double cells = std::ceil(radius_of(piece) / (kCellRadius * limit_));
  if (cells > kMaxCells) return covers_quarters(piece, begin, end, depth);
  const auto n = static_cast<std::size_t>(cells);
  cells_.place(piece, lower_, n);
  if (shadows_ != nullptr) {
    cells_.mark(*shadows_, piece);
    if (cells_.are_all_marked()) return true;
  }
  // Coordinates are below 2000 limits (more fail), so the rounding of floats is below a
  // thousandth of it, by which the limit is made smaller.
  const float limit2 = limit_ * limit_ * 0.996F;
  cells_.place_points(piece, lower_);
  const std::pair<Vec3f, Vec3f> box = cells_.unmarked_box();
  for (std::size_t i = begin; i < end; ++i) {
    const Vec3f p{{local_[0][i], local_[1][i], local_[2][i]}};
    if (!is_near_box(box, p, p, limit_)) continue;
    cells_.mark(p, limit2);
    ++n_tests_;
    constexpr std::size_t kOften = 8;
    if (i % kOften == 0 && cells_.are_all_marked()) return true;
  }
  if (cells_.are_all_marked()) return true;
  mark_by_triangles(begin, end, limit2);
  if (cells_.is_hopeless()) return false;
  const int deeper = std::min(depth, 4);
  shadows_ = nullptr;
  const Cells marked = cells_;
  for (std::size_t cell = 0; cell < n * n; ++cell)
    if (!marked.is_marked(cell) && !covers_quarters(cell_of(piece, cell, n), begin, end, deeper))
      return false;
  return true;
}

void Cover::mark_by_triangles(std::size_t begin, std::size_t end, float limit2) {
  cells_.want_unmarked();
  const std::pair<Vec3f, Vec3f> box = cells_.unmarked_box();
  near_.clear();
  if (++n_calls_ == 0 || last_call_.empty()) {
    last_call_.assign(original_.triangles.size(), 0);
    n_calls_ = 1;
  }
  for (std::size_t i = begin; i < end; ++i) {
    const Vec3f p{{local_[0][i], local_[1][i], local_[2][i]}};
    if (!is_near_box(box, p, p, limit_ + longest_edge_)) continue;
    for (const std::uint32_t t : around_.of(vertices_[i])) {
      if (last_call_[t] == n_calls_) continue;
      last_call_[t] = n_calls_;
      near_.push_back(t);
    }
  }
  for (const std::uint32_t t : near_) {
    std::array<Vec3f, 3> target;
    for (std::size_t k = 0; k < 3; ++k)
      target[k] = local_position(original_.positions[original_.triangles[t][k]]);
    Vec3f low = target[0];
    Vec3f high = target[0];
    for (std::size_t i = 0; i < 3; ++i) {
      low[i] = std::min({target[0][i], target[1][i], target[2][i]});
      high[i] = std::max({target[0][i], target[1][i], target[2][i]});
    }
    // Of a sliver floats know the direction to 6e-6, which along 100 limits is a thousandth.
    const bool is_small =
        std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]}) < 100 * limit_;
    if (!is_small || !is_near_box(box, low, high, limit_)) continue;
    const Vec3f reach{{limit_, limit_, limit_}};
    if (!cells_.may_use(low - reach, high + reach)) continue;
    cells_.mark(target, limit2);
    n_tests_ += kCorners;
    if (cells_.are_all_marked()) return;
  }
}

bool Cover::covers_quarters(const Piece& piece, std::size_t begin, std::size_t end, int depth) {
  find_distances((piece[0] + piece[1] + piece[2]) * (1.0 / 3), begin, end);
  const float reach = 1.01F * (limit_ + static_cast<float>(radius_of(piece))) + longest_edge_;
  const std::size_t n = vertices_.size();
  for (std::size_t i = begin; i < end; ++i)
    if (distances_[i] <= reach * reach)
      push(vertices_[i], {{local_[0][i], local_[1][i], local_[2][i]}});
  const ShadowCover* const shadows = shadows_;
  bool covers = true;
  const std::size_t n_near = vertices_.size();
  for (const Piece& part : quarters(piece)) {
    shadows_ = shadows;
    covers = covers && covers_part(part, n, n_near, depth - 1);
  }
  vertices_.resize(n);
  for (auto& axis : local_) axis.resize(n);
  return covers;
}

}  // namespace lode::simplification
