#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include "lode/delaunay/lattice.h"

namespace lode::delaunay {

/// Steps through x = x0 + i dx / dy, exactly, with one division. dy > 0.
class EdgeSteps {
 public:
  explicit EdgeSteps(std::int32_t x) : x_(x), run_(1), whole_(0) {}
  EdgeSteps(LatticePoint from, LatticePoint to)
      : x_(from.x), run_(to.y - from.y), whole_((to.x - from.x) / run_) {
    part_ = (to.x - from.x) - whole_ * run_;
    if (part_ < 0) {
      part_ += run_;
      --whole_;
    }
  }
  [[nodiscard]] std::int32_t floor() const { return x_; }
  [[nodiscard]] std::int32_t ceil() const { return x_ + (rest_ > 0 ? 1 : 0); }
  void step() {
    x_ += whole_;
    rest_ += part_;
    if (rest_ >= run_) {
      rest_ -= run_;
      ++x_;
    }
  }
  /// n steps at once, n >= 0.
  void step(std::int64_t n) {
    const std::int64_t parts = rest_ + n * part_;
    x_ += static_cast<std::int32_t>(n * whole_ + parts / run_);
    rest_ = static_cast<std::int32_t>(parts % run_);
  }

 private:
  std::int32_t x_;
  std::int32_t run_;
  std::int32_t whole_;
  std::int32_t part_ = 0;
  std::int32_t rest_ = 0;
};

/// The rows of nodes in a closed triangle of positive area, upwards, in steps of one:
/// for (TriangleRows rows(a, b, c); rows.has_row(); rows.next()). A row may be without nodes:
/// first() > last().
class TriangleRows {
 public:
  TriangleRows(LatticePoint a, LatticePoint b, LatticePoint c)
      : v_{a, b, c}, long_(a.x), short_(a.x) {
    order(0, 1);
    order(1, 2);
    order(0, 1);
    y_ = v_[0].y;
    long_ = EdgeSteps(v_[0], v_[2]);
    short_ = y_ < v_[1].y ? EdgeSteps(v_[0], v_[1]) : upper_edge();
  }

  [[nodiscard]] bool has_row() const { return y_ <= v_[2].y; }
  [[nodiscard]] std::int32_t y() const { return y_; }
  /// Columns.
  [[nodiscard]] std::int32_t first() const { return is_left_ ? long_.ceil() : short_.ceil(); }
  [[nodiscard]] std::int32_t last() const { return is_left_ ? short_.floor() : long_.floor(); }
  void next() {
    ++y_;
    long_.step();
    if (y_ == v_[1].y)
      short_ = upper_edge();
    else
      short_.step();
  }
  /// To row y, if that is above this one and not above the last.
  void skip_to(std::int32_t y) {
    if (y <= y_ || y > v_[2].y) return;
    long_.step(y - y_);
    if (y < v_[1].y) {
      short_.step(y - y_);
    } else {
      if (y_ < v_[1].y) short_ = upper_edge();
      short_.step(y - std::max(y_, v_[1].y));
    }
    y_ = y;
  }

 private:
  void order(std::size_t i, std::size_t j) {
    if (v_[i].y <= v_[j].y) return;
    std::swap(v_[i], v_[j]);
    is_left_ = !is_left_;
  }
  [[nodiscard]] EdgeSteps upper_edge() const {
    return v_[1].y < v_[2].y ? EdgeSteps(v_[1], v_[2]) : EdgeSteps(v_[1].x);
  }

  std::array<LatticePoint, 3> v_;  ///< From the lowest to the highest.
  bool is_left_ = true;            ///< They turn left: the edge from first to last is on the left.
  std::int32_t y_ = 0;
  EdgeSteps long_;
  EdgeSteps short_;
};

/// Of the same, only nodes whose columns and rows are multiples of 2^bits, all in such steps.
class SparseRows {
 public:
  SparseRows(LatticePoint a, LatticePoint b, LatticePoint c, int bits) : v_{a, b, c}, bits_(bits) {
    // From low to high, as they turn.
    std::array<std::size_t, 3> order{0, 1, 2};
    std::sort(order.begin(), order.end(),
              [&](std::size_t i, std::size_t j) { return v_[i].y < v_[j].y; });
    v_ = {v_[order[0]], v_[order[1]], v_[order[2]]};
    is_left_ = doubled_area(v_[0], v_[1], v_[2]) > 0;
    y_ = ceil_shifted(v_[0].y);
    find_span();
  }

  [[nodiscard]] bool has_row() const { return (y_ << bits_) <= v_[2].y; }
  [[nodiscard]] std::int32_t y() const { return y_; }
  [[nodiscard]] std::int32_t first() const { return first_; }
  [[nodiscard]] std::int32_t last() const { return last_; }
  void next() {
    ++y_;
    if (has_row()) find_span();
  }

 private:
  [[nodiscard]] std::int32_t ceil_shifted(std::int32_t x) const {
    return (x + (1 << bits_) - 1) >> bits_;
  }
  [[nodiscard]] static std::int64_t floor_divided(std::int64_t a, std::int64_t b) {
    const std::int64_t quotient = a / b;
    return quotient - static_cast<std::int64_t>(a % b != 0 && a < 0);
  }
  /// Of the edge p -> q, q higher: the largest x <= that at row y, or the smallest x >= it.
  [[nodiscard]] static std::int32_t floor_at(LatticePoint p, LatticePoint q, std::int32_t y) {
    return p.x +
           static_cast<std::int32_t>(floor_divided(std::int64_t{y - p.y} * (q.x - p.x), q.y - p.y));
  }
  [[nodiscard]] static std::int32_t ceil_at(LatticePoint p, LatticePoint q, std::int32_t y) {
    return p.x - static_cast<std::int32_t>(
                     floor_divided(-std::int64_t{y - p.y} * (q.x - p.x), q.y - p.y));
  }
  void find_span() {
    const std::int32_t y = y_ << bits_;
    const bool is_lower = y < v_[1].y || v_[1].y == v_[2].y;
    const LatticePoint p = is_lower ? v_[0] : v_[1];
    const LatticePoint q = is_lower ? v_[1] : v_[2];
    // Level edges are whole rows of the other two.
    const std::int32_t low = p.y == q.y ? p.x : (is_left_ ? floor_at(p, q, y) : ceil_at(p, q, y));
    const std::int32_t other = is_left_ ? ceil_at(v_[0], v_[2], y) : floor_at(v_[0], v_[2], y);
    first_ = ceil_shifted(is_left_ ? other : low);
    last_ = (is_left_ ? low : other) >> bits_;
  }

  std::array<LatticePoint, 3> v_;
  int bits_;
  bool is_left_ = true;
  std::int32_t y_ = 0;
  std::int32_t first_ = 0;
  std::int32_t last_ = -1;
};

}  // namespace lode::delaunay
