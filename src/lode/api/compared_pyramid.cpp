#include "lode/api/compared_pyramid.h"

#include <algorithm>
#include <filesystem>
#include <functional>
#include <optional>
#include <utility>

#include "lode/api/compared_insertions.h"
#include "lode/models/terrain/delaunay_pyramid/encodings.h"

namespace lode {
namespace {

using delaunay_pyramid::EncodingLimit;
using delaunay_pyramid::Interference;

/// Links may be quadratic: what is more is refused, and the page says so.
constexpr EncodingLimit kLimit{.n_bytes = std::uint64_t{4} << 30};

/// What an encoding takes beside the places and heights of its vertices, and these.
std::uint64_t with_vertices(const insertions::History& history, std::uint64_t n_bytes) {
  return n_bytes + history.vertices.size() * (sizeof(delaunay::LatticePoint) + sizeof(double));
}

class Lists final : public HistoryCandidate {
 public:
  Lists(std::shared_ptr<SharedHistory> shared, Interference interference)
      : HistoryCandidate(std::move(shared)), interference_(interference) {}
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
    LODE_TRY(lists_,
             delaunay_pyramid::TriangleLists::make(history(), times_of(history(), shared().levels),
                                                   interference_, kLimit, progress));
    return {};
  }
  [[nodiscard]] delaunay::Tin tin_of_level(std::size_t level) override {
    return lists_->extract(history(), level);
  }
  [[nodiscard]] std::optional<std::uint64_t> zoom_level(std::size_t level,
                                                        const delaunay::Window& window) override {
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

class Complete final : public HistoryCandidate {
 public:
  using HistoryCandidate::HistoryCandidate;
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
    LODE_TRY(pyramid_, delaunay_pyramid::CompletePyramid::make(
                           history(), times_of(history(), shared().levels), kLimit, progress));
    return {};
  }
  [[nodiscard]] delaunay::Tin tin_of_level(std::size_t level) override {
    return pyramid_->extract(history(), level);
  }
  [[nodiscard]] std::optional<std::uint64_t> zoom_level(std::size_t level,
                                                        const delaunay::Window& window) override {
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
  const auto shared = std::make_shared<SharedHistory>(TerrainModel::delaunay_pyramid);
  std::vector<std::unique_ptr<TerrainCandidate>> all;
  all.push_back(insertions_candidate(shared));
  all.push_back(std::make_unique<Lists>(shared, Interference::left_out));
  all.push_back(std::make_unique<Lists>(shared, Interference::linked));
  all.push_back(std::make_unique<Complete>(shared));
  for (const TerrainModel model :
       {TerrainModel::ternary_triangulation, TerrainModel::implicit_delaunay_pyramid})
    all.push_back(insertions_candidate(std::make_shared<SharedHistory>(model)));
  return all;
}

}  // namespace lode
