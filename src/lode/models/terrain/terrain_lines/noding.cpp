#include "lode/models/terrain/terrain_lines/noding.h"

#include <geos_c.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace lode::terrain_lines {
namespace {

/// GEOS for one thread, and what it last complained of.
class Geos {
 public:
  Geos() : handle_(GEOS_init_r()) {
    GEOSContext_setErrorMessageHandler_r(handle_, &Geos::on_error, &error_);
  }
  Geos(const Geos&) = delete;
  Geos& operator=(const Geos&) = delete;
  ~Geos() { GEOS_finish_r(handle_); }

  [[nodiscard]] GEOSContextHandle_t handle() const { return handle_; }
  [[nodiscard]] const std::string& error() const { return error_; }

 private:
  static void on_error(const char* message, void* error) {
    *static_cast<std::string*>(error) = message;
  }

  GEOSContextHandle_t handle_;
  std::string error_;
};

struct GeometryDeleter {
  GEOSContextHandle_t handle;
  void operator()(GEOSGeometry* geometry) const { GEOSGeom_destroy_r(handle, geometry); }
};
using Geometry = std::unique_ptr<GEOSGeometry, GeometryDeleter>;

class LineNoder {
 public:
  Result<NodedLines> run(std::span<const LineToNode> lines) {
    LODE_TRY(const Geometry all, to_geometry(lines));
    const Geometry noded(GEOSUnaryUnionPrec_r(geos_.handle(), all.get(), 1), {geos_.handle()});
    if (noded == nullptr) return refused();
    LODE_CHECK(add(noded.get()));
    return take();
  }

 private:
  [[nodiscard]] Error refused() const {
    return fail("expected lines that GEOS can take together, got: {}",
                geos_.error().empty() ? "no reason" : geos_.error());
  }

  Result<Geometry> to_geometry(std::span<const LineToNode> lines) const {
    std::vector<Geometry> parts;
    for (const auto& [places, has_own_heights] : lines) {
      std::vector<Vec<double, 2>> flat;
      flat.reserve(places.size());
      for (const Vec3d& p : places) flat.push_back({{p[0], p[1]}});
      const auto n = static_cast<unsigned>(flat.size());
      GEOSCoordSequence* points =
          GEOSCoordSeq_copyFromBuffer_r(geos_.handle(), flat.data()->v.data(), n, 0, 0);
      if (points == nullptr) return refused();
      parts.emplace_back(GEOSGeom_createLineString_r(geos_.handle(), points),
                         GeometryDeleter{geos_.handle()});
      if (parts.back() == nullptr) return refused();
    }
    std::vector<GEOSGeometry*> raw;
    raw.reserve(parts.size());
    for (Geometry& part : parts) raw.push_back(part.release());
    Geometry all(GEOSGeom_createCollection_r(geos_.handle(), GEOS_MULTILINESTRING, raw.data(),
                                             static_cast<unsigned>(raw.size())),
                 {geos_.handle()});
    if (all == nullptr) return refused();
    return all;
  }

  Result<void> add(const GEOSGeometry* geometry) {
    const int n = GEOSGetNumGeometries_r(geos_.handle(), geometry);
    const int type = GEOSGeomTypeId_r(geos_.handle(), geometry);
    if (type == GEOS_LINESTRING) return add_line(geometry);
    for (int i = 0; i < n; ++i) LODE_CHECK(add(GEOSGetGeometryN_r(geos_.handle(), geometry, i)));
    return {};
  }

  Result<void> add_line(const GEOSGeometry* line) {
    const GEOSCoordSequence* points = GEOSGeom_getCoordSeq_r(geos_.handle(), line);
    unsigned n = 0;
    if (points == nullptr || GEOSCoordSeq_getSize_r(geos_.handle(), points, &n) == 0)
      return refused();
    std::vector<Vec<double, 2>> coordinates(n);
    if (n > 0 && GEOSCoordSeq_copyToBuffer_r(geos_.handle(), points, coordinates.data()->v.data(),
                                             0, 0) == 0)
      return refused();
    for (unsigned i = 0; i < n; ++i) {
      const auto node = [](double x) { return static_cast<std::int32_t>(std::lround(x)); };
      vertices_.push_back({node(coordinates[i][0]), node(coordinates[i][1])});
      if (i > 0) ends_.push_back(vertices_.size() - 1);
    }
    return {};
  }

  NodedLines take() const {
    const auto row_order = [](LatticePoint p) { return std::pair(p.y, p.x); };
    NodedLines noded;
    noded.nodes = vertices_;
    std::ranges::sort(noded.nodes, {}, row_order);
    noded.nodes.erase(std::unique(noded.nodes.begin(), noded.nodes.end()), noded.nodes.end());
    std::vector<std::uint32_t> number;
    number.reserve(vertices_.size());
    for (const LatticePoint vertex : vertices_)
      number.push_back(static_cast<std::uint32_t>(
          std::ranges::lower_bound(noded.nodes, row_order(vertex), {}, row_order) -
          noded.nodes.begin()));
    for (const std::size_t end : ends_) {
      const auto [a, b] = std::minmax(number[end - 1], number[end]);
      if (a != b) noded.edges.push_back({a, b});
    }
    std::ranges::sort(noded.edges);
    noded.edges.erase(std::unique(noded.edges.begin(), noded.edges.end()), noded.edges.end());
    return noded;
  }

  Geos geos_;
  std::vector<LatticePoint> vertices_;
  std::vector<std::size_t> ends_;  ///< Of edges: vertices that the one before is joined to.
};

/// Finds the edges that lines with own heights have become.
class OwnEdges {
 public:
  explicit OwnEdges(NodedLines& noded) : noded_(noded) {
    noded_.is_own.assign(noded_.edges.size(), false);
    sums_.resize(noded_.nodes.size());
    for (std::uint32_t i = 0; i < noded_.edges.size(); ++i)
      for (const std::uint32_t end : noded_.edges[i]) sides_.push_back({end, i});
    std::ranges::sort(sides_);
  }

  /// Which piece of which line.
  struct Piece {
    std::size_t line;
    std::size_t number;
  };
  /// Along a piece of a line, by the edges that lead on and stay within the rounding of it. Pieces
  /// come in the order of lines.
  void follow(const Vec3d& from, const Vec3d& to, const Piece& piece) {
    const Vec<double, 2> a{{from[0], from[1]}};
    const Vec<double, 2> way = Vec<double, 2>{{to[0], to[1]}} - a;
    const double length = std::hypot(way[0], way[1]);
    std::optional<std::uint32_t> at = node_at(from);
    double along = -kReach;
    if (at) add_height(*at, from[2], piece);
    while (at && noded_.nodes[*at] != rounded(to)) {
      std::optional<std::uint32_t> best;
      double least = kReach;
      double next_along = along;
      auto side = std::ranges::lower_bound(sides_, *at, {}, &Side::node);
      for (; side != sides_.end() && side->node == *at; ++side) {
        const auto& edge = noded_.edges[side->edge];
        const LatticePoint p = noded_.nodes[edge[0] == *at ? edge[1] : edge[0]];
        const Vec<double, 2> off{{p.x - a[0], p.y - a[1]}};
        const double ahead = (off[0] * way[0] + off[1] * way[1]) / length;
        const double beside = std::abs(off[0] * way[1] - off[1] * way[0]) / length;
        if (ahead <= along || ahead > length + kReach || beside >= least) continue;
        least = beside;
        best = side->edge;
        next_along = ahead;
      }
      if (!best) return;
      noded_.is_own[*best] = true;
      const auto& edge = noded_.edges[*best];
      at = edge[0] == *at ? edge[1] : edge[0];
      along = next_along;
      const double t = std::clamp(along / length, 0.0, 1.0);
      add_height(*at, noded_.nodes[*at] == rounded(to) ? to[2] : from[2] + (to[2] - from[2]) * t,
                 piece);
    }
  }
  /// Of all lines that were followed.
  void finish() {
    noded_.own_heights.clear();
    for (const HeightSum& here : sums_) {
      noded_.own_heights.push_back(here.n > 0 ? here.sum / here.n
                                              : std::numeric_limits<double>::quiet_NaN());
      if (!here.is_unequal()) continue;
      ++noded_.n_unequal;
      noded_.largest_spread = std::max(noded_.largest_spread, here.highest - here.lowest);
    }
  }

 private:
  /// More than the diagonal of half a cell.
  static constexpr double kReach = 1;
  struct Side {
    std::uint32_t node;
    std::uint32_t edge;
    auto operator<=>(const Side&) const = default;
  };
  static LatticePoint rounded(const Vec3d& p) {
    return {static_cast<std::int32_t>(std::lround(p[0])),
            static_cast<std::int32_t>(std::lround(p[1]))};
  }
  [[nodiscard]] std::optional<std::uint32_t> node_at(const Vec3d& p) const {
    const auto row_order = [](LatticePoint q) { return std::pair(q.y, q.x); };
    const auto found = std::ranges::lower_bound(noded_.nodes, row_order(rounded(p)), {}, row_order);
    if (found == noded_.nodes.end() || *found != rounded(p)) return std::nullopt;
    return static_cast<std::uint32_t>(found - noded_.nodes.begin());
  }

  struct HeightSum {
    double n = 0;
    double sum = 0;
    double lowest = std::numeric_limits<double>::infinity();
    double highest = -std::numeric_limits<double>::infinity();
    Piece last{};
    int n_passes = 0;  ///< Of lines, each along pieces that follow one another.

    [[nodiscard]] bool is_unequal() const {
      return n_passes > 1 &&
             highest - lowest > 0x1p-40 * std::max(std::abs(lowest), std::abs(highest));
    }
  };
  void add_height(std::uint32_t node, double height, const Piece& piece) {
    HeightSum& here = sums_[node];
    ++here.n;
    here.sum += height;
    here.lowest = std::min(here.lowest, height);
    here.highest = std::max(here.highest, height);
    const bool goes_on =
        here.n_passes > 0 && here.last.line == piece.line && piece.number <= here.last.number + 1;
    if (!goes_on) ++here.n_passes;
    here.last = piece;
  }

  NodedLines& noded_;
  std::vector<Side> sides_;
  std::vector<HeightSum> sums_;  ///< By node.
};

}  // namespace

Result<NodedLines> node_lines(std::span<const LineToNode> lines) {
  if (lines.empty()) return NodedLines{};
  LODE_TRY(NodedLines noded, LineNoder().run(lines));
  OwnEdges own(noded);
  for (std::size_t line = 0; line < lines.size(); ++line) {
    const auto& [places, has_own_heights] = lines[line];
    for (std::size_t i = 0; has_own_heights && i + 1 < places.size(); ++i)
      own.follow(places[i], places[i + 1], {line, i});
  }
  own.finish();
  return noded;
}

}  // namespace lode::terrain_lines
