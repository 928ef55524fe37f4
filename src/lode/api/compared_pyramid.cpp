#include "lode/api/compared_pyramid.h"

#include <algorithm>
#include <filesystem>
#include <functional>
#include <optional>
#include <utility>

#include "lode/core/stopwatch.h"
#include "lode/models/terrain/delaunay_pyramid/build.h"
#include "lode/models/terrain/delaunay_pyramid/encodings.h"
#include "lode/models/terrain/delaunay_pyramid/extract.h"
#include "lode/refine/focus.h"

namespace lode {
namespace {

using delaunay_pyramid::EncodingLimit;
using delaunay_pyramid::Interference;
using delaunay_pyramid::Window;

/// Links may be quadratic: what is more is refused, and the page says so.
constexpr EncodingLimit kLimit{.n_bytes = std::uint64_t{4} << 30};

/// The history of a grid, and when it reaches its levels.
struct SharedHistory {
  std::optional<delaunay_pyramid::History> history;
  std::vector<double> levels;  ///< That get finer.
  std::vector<std::uint32_t> times;
  double seconds = 0;

  Result<void> build(const HeightGrid& grid, std::span<const double> tolerances,
                     Progress& progress) {
    if (history) return {};
    levels.assign(tolerances.begin(), tolerances.end());
    std::ranges::sort(levels, std::greater());
    levels.erase(std::unique(levels.begin(), levels.end()), levels.end());
    const Stopwatch watch;
    LODE_TRY(history, delaunay_pyramid::build_history(grid, levels.back(), progress));
    seconds = watch.seconds();
    times = delaunay_pyramid::times_of(*history, levels);
    return {};
  }
  [[nodiscard]] std::size_t level_of(double tolerance) const {
    return static_cast<std::size_t>(std::ranges::find(levels, tolerance) - levels.begin());
  }
};

class PyramidCandidate : public TerrainCandidate {
 public:
  explicit PyramidCandidate(std::shared_ptr<SharedHistory> shared) : shared_(std::move(shared)) {}

  [[nodiscard]] Result<void> prepare(const HeightGrid& grid, std::span<const double> tolerances,
                                     Threads /*threads*/, Progress& progress) final {
    LODE_CHECK(shared_->build(grid, tolerances, progress));
    const Stopwatch watch;
    LODE_CHECK(encode(progress));
    encoding_seconds_ = watch.seconds();
    return {};
  }
  [[nodiscard]] Result<Answer> extract(double tolerance, Progress& progress) final {
    if (progress.is_cancelled()) return cancelled_error();
    return Answer{.tin = tin_of_level(shared_->level_of(tolerance)), .stated_error = tolerance};
  }
  [[nodiscard]] std::optional<double> build_seconds() const final {
    return shared_->seconds + encoding_seconds_;
  }
  [[nodiscard]] int n_levels() const final { return static_cast<int>(shared_->levels.size()); }
  [[nodiscard]] Result<std::optional<std::uint64_t>> zoom(double tolerance,
                                                          const TerrainWindow& window) final {
    return zoom_level(shared_->level_of(tolerance), Window{window.lower, window.upper});
  }
  [[nodiscard]] std::optional<std::uint64_t> locate(
      double tolerance, std::span<const delaunay::LatticePoint> places) final {
    return locate_in_level(shared_->level_of(tolerance), places);
  }

 protected:
  virtual Result<void> encode(Progress& progress) = 0;
  [[nodiscard]] virtual delaunay::Tin tin_of_level(std::size_t level) = 0;
  [[nodiscard]] virtual std::optional<std::uint64_t> zoom_level(std::size_t level,
                                                                const Window& window) = 0;
  [[nodiscard]] virtual std::optional<std::uint64_t> locate_in_level(
      std::size_t level, std::span<const delaunay::LatticePoint> places) = 0;
  /// How many of the places find(place) finds.
  template <typename Find>
  static std::uint64_t count_found(std::span<const delaunay::LatticePoint> places,
                                   const Find& find) {
    return static_cast<std::uint64_t>(std::ranges::count_if(
        places, [&](const delaunay::LatticePoint& p) { return find(p).has_value(); }));
  }
  [[nodiscard]] const delaunay_pyramid::History& history() const { return *shared_->history; }
  [[nodiscard]] const SharedHistory& shared() const { return *shared_; }

 private:
  std::shared_ptr<SharedHistory> shared_;
  double encoding_seconds_ = 0;
};

class Hypertriangulation final : public PyramidCandidate {
 public:
  using PyramidCandidate::PyramidCandidate;
  [[nodiscard]] std::string name() const override { return "delaunay_pyramid"; }
  [[nodiscard]] std::string what() const override {
    return "all insertions of the strict selector, with every triangle that there ever was "
           "(hypertriangulation): any tolerance, which may vary";
  }
  [[nodiscard]] bool can_vary() const override { return true; }
  [[nodiscard]] Result<std::uint64_t> extract_middle(double tolerance, Progress&) override {
    const FocusDemand demand = middle_demand(history().frame, tolerance);
    return tin_of(history(), select_nodes(history(), demand), delaunay::TinLinks::left_out)
        .triangles.size();
  }
  [[nodiscard]] std::optional<std::uint64_t> memory_bytes() const override {
    return history().n_bytes() + locator_->n_bytes();
  }

 private:
  Result<void> encode(Progress&) override {
    locator_.emplace(history());
    return {};
  }
  [[nodiscard]] delaunay::Tin tin_of_level(std::size_t level) override {
    return tin_at(history(), shared().times[level], delaunay::TinLinks::left_out);
  }
  [[nodiscard]] std::optional<std::uint64_t> zoom_level(std::size_t level,
                                                        const Window& window) override {
    return zoom_at(history(), shared().times[level], window).size();
  }
  [[nodiscard]] std::optional<std::uint64_t> locate_in_level(
      std::size_t level, std::span<const delaunay::LatticePoint> places) override {
    return count_found(places, [&](delaunay::LatticePoint p) {
      const delaunay::Point at{{static_cast<double>(p.x), static_cast<double>(p.y)}};
      return locator_->find(shared().times[level], at);
    });
  }

  std::optional<delaunay_pyramid::HistoryLocator> locator_;
};

/// What an encoding takes beside the places and heights of its vertices, and these.
std::uint64_t with_vertices(const delaunay_pyramid::History& history, std::uint64_t n_bytes) {
  return n_bytes + history.vertices.size() * (sizeof(delaunay::LatticePoint) + sizeof(double));
}

class Lists final : public PyramidCandidate {
 public:
  Lists(std::shared_ptr<SharedHistory> shared, Interference interference)
      : PyramidCandidate(std::move(shared)), interference_(interference) {}
  [[nodiscard]] std::string name() const override {
    return has_links() ? "delaunay_pyramid, linked lists" : "delaunay_pyramid, lists";
  }
  [[nodiscard]] std::string what() const override {
    return has_links() ? "lists of the triangles that each level makes (SLT), with interference "
                         "links"
                       : "lists of the triangles that each level makes (SLT), no links: neither "
                         "zoom nor location but in a mesh";
  }
  [[nodiscard]] std::optional<std::uint64_t> memory_bytes() const override {
    return with_vertices(history(), lists_->n_bytes());
  }
  [[nodiscard]] std::optional<std::uint64_t> n_links() const override {
    return has_links() ? std::optional(lists_->n_links()) : std::nullopt;
  }

 private:
  [[nodiscard]] bool has_links() const { return interference_ == Interference::linked; }
  Result<void> encode(Progress& progress) override {
    LODE_TRY(lists_, delaunay_pyramid::TriangleLists::make(history(), shared().times, interference_,
                                                           kLimit, progress));
    return {};
  }
  [[nodiscard]] delaunay::Tin tin_of_level(std::size_t level) override {
    return lists_->extract(history(), level);
  }
  [[nodiscard]] std::optional<std::uint64_t> zoom_level(std::size_t level,
                                                        const Window& window) override {
    if (!has_links()) return {};
    return lists_->zoom(history(), level, window).size();
  }
  [[nodiscard]] std::optional<std::uint64_t> locate_in_level(
      std::size_t level, std::span<const delaunay::LatticePoint> places) override {
    if (!has_links()) return {};
    return count_found(
        places, [&](delaunay::LatticePoint p) { return lists_->locate(history(), level, p); });
  }

  Interference interference_;
  std::optional<delaunay_pyramid::TriangleLists> lists_;
};

class Complete final : public PyramidCandidate {
 public:
  using PyramidCandidate::PyramidCandidate;
  [[nodiscard]] std::string name() const override { return "delaunay_pyramid, complete"; }
  [[nodiscard]] std::string what() const override {
    return "every level's whole triangulation with neighbours, and interference links";
  }
  [[nodiscard]] std::optional<std::uint64_t> memory_bytes() const override {
    return with_vertices(history(), pyramid_->n_bytes());
  }
  [[nodiscard]] std::optional<std::uint64_t> n_links() const override {
    return pyramid_->n_links();
  }

 private:
  Result<void> encode(Progress& progress) override {
    LODE_TRY(pyramid_,
             delaunay_pyramid::CompletePyramid::make(history(), shared().times, kLimit, progress));
    return {};
  }
  [[nodiscard]] delaunay::Tin tin_of_level(std::size_t level) override {
    return pyramid_->extract(history(), level);
  }
  [[nodiscard]] std::optional<std::uint64_t> zoom_level(std::size_t level,
                                                        const Window& window) override {
    return pyramid_->zoom(history(), level, window).size();
  }
  [[nodiscard]] std::optional<std::uint64_t> locate_in_level(
      std::size_t level, std::span<const delaunay::LatticePoint> places) override {
    return count_found(
        places, [&](delaunay::LatticePoint p) { return pyramid_->locate(history(), level, p); });
  }

  std::optional<delaunay_pyramid::CompletePyramid> pyramid_;
};

}  // namespace

std::vector<std::unique_ptr<TerrainCandidate>> pyramid_candidates() {
  const auto shared = std::make_shared<SharedHistory>();
  std::vector<std::unique_ptr<TerrainCandidate>> all;
  all.push_back(std::make_unique<Hypertriangulation>(shared));
  all.push_back(std::make_unique<Lists>(shared, Interference::left_out));
  all.push_back(std::make_unique<Lists>(shared, Interference::linked));
  all.push_back(std::make_unique<Complete>(shared));
  return all;
}

}  // namespace lode
